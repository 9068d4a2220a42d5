/* SPDX-License-Identifier: MIT */
/*
 * Rows of a quadrant side by side, as a wave. Row k begins when row k - 1 is three places long, and
 * goes on as long as it is sure to, whatever becomes of the rows below. From there on, and where
 * the kernel leaves a cell alone, it is marched like any other row.
 */
#include "quadrant.h"
#include "rough.h"

#include <string.h>

/* What a wave can go over: one patch on which parameters are good guesses everywhere, by methods
 * whose edges have chords of known length; where the net may meet itself, the order of nodes
 * matters. */
bool wave_suits(const struct march *march) {
    const struct drape_settings *s = march->settings;
    const struct surface *surface = march->surface;
    bool chords = s->method == DRAPE_BASIC || s->method == DRAPE_GIB || s->method == DRAPE_GIB4;
    return chords && surface && !surface->shell && !surface->has_poles && !march->mesh &&
           !march->fold && !march->before.net && s->yarn_path == DRAPE_PATH_CHORD;
}

enum status wave_make(struct march *march, struct quadrant *q) {
    const struct drape_settings *s = march->settings;
    q->kernel = wave_suits(march) ? wave_kernel_for(s->lanes) : NULL;
    if (!q->kernel)
        return STATUS_OK;
    q->wave = arena_alloc(march->arena, 1, sizeof *q->wave);
    if (!q->wave)
        return STATUS_OUT_OF_MEMORY;
    q->wave->surface = march->surface;
    memcpy(q->wave->length, s->spacing, sizeof q->wave->length);
    q->wave->arcs = s->method != DRAPE_BASIC;
    return STATUS_OK;
}

/* Whether lane k has a next place for certain: its row is not complete, and the rows below reach
 * far enough as they are. */
static bool runs(const struct quadrant *q, int k) {
    const struct quadrant_row *row = &q->row[k + 1], *below = &q->row[k];
    int32_t i = row->count, fringe = q->march->fringe;
    int32_t one = k > 0 ? below->last : q->reach[0];
    int32_t two = k > 1 ? q->row[k - 1].last : k == 1 ? q->reach[0] : q->reach[1];
    return !row->ended && i < q->length && i < below->count &&
           (i <= row->last + fringe || i <= one + fringe || i <= two + fringe);
}

/* Begins row k of the wave, which lies on row j + k - 1: its first two places. */
static enum status start_lane(struct quadrant *q, int32_t j, int k, bool *started) {
    struct wave *wave = q->wave;
    struct quadrant_row *row = &q->row[k + 1], *below = &q->row[k];
    *started = below->count > 2 && q->length > 2 && (k == 0 || below->last >= 0);
    if (!*started)
        return STATUS_OK;
    quadrant_begin_row(q, below, row, j + k);
    row->begun = true;
    if (row->planted) {
        enum status status = quadrant_grow_node(q, below, row, j + k);
        if (status != STATUS_OK)
            return status;
    }
    *started = row->planted && runs(q, k);
    if (!*started)
        return STATUS_OK;
    wave_put(wave_at(wave, 2), k + 1, &row->at[0]);
    wave_put(wave_at(wave, 1), k + 1, &row->at[1]);
    for (unsigned i = 0; k == 0 && i < 3; i++)
        wave_put(wave_at(wave, 3 - i), 0, &below->at[i]);
    for (int order = 0; order < WAVE_ORDERS; order++)
        for (int n = 0; n < 2; n++)
            wave->difference[order][n][k] =
                order == 0 ? row->at[0].uv[n] - below->at[0].uv[n] : (double)NAN;
    return STATUS_OK;
}

/* Leaves lanes from `first` on to be marched row by row, after a step at which lane 0 had the place
 * `column`: what their next places rest on is put into the rows. */
static void hand_over(struct quadrant *q, int first, int lanes, int32_t column) {
    struct wave *wave = q->wave;
    for (int k = first > 0 ? first - 1 : 0; k < lanes; k++) {
        struct quadrant_row *row = &q->row[k + 1];
        int32_t at = column - k;
        for (int n = 0; n < 3 && at - n >= 2; n++)
            wave_get(wave, wave_at(wave, 1 + (unsigned)n), k + 1, &row->at[at - n]);
        if (k < first)
            continue;
        const struct wave_places *d = wave_at(wave, 1), *c = wave_at(wave, 2);
        double below[2] = {c->of[0][k], c->of[1][k]}, last[2] = {d->of[0][k + 1], d->of[1][k + 1]};
        row->edge.count = at < WAVE_ORDERS ? at : WAVE_ORDERS;
        for (int order = 0; order < row->edge.count; order++)
            for (int n = 0; n < 2; n++)
                row->edge.of[order][n] = wave->difference[order][n][k];
        quadrant_add_edge(&row->edge, below, last);
    }
}

/* A cell that the kernel has left alone. */
static enum status grow_alone(struct quadrant *q, int32_t j, int k) {
    struct wave *wave = q->wave;
    struct quadrant_row *row = &q->row[k + 1];
    struct march *march = q->march;
    struct fishnet_node node;
    enum drape_reason reason;
    struct station a, b, c, a2, b2;
    double uv[2] = {wave->expected[0][k], wave->expected[1][k]};
    wave_get(wave, wave_at(wave, 2), k, &a);
    wave_get(wave, wave_at(wave, 1), k + 1, &b);
    wave_get(wave, wave_at(wave, 1), k, &c);
    wave_get(wave, wave_at(wave, 3), k, &a2);
    wave_get(wave, wave_at(wave, 2), k + 1, &b2);
    struct march_cell cell = {row->count * q->si, (j + k) * q->sj, q->si, q->sj, &a, &b, &c,
                              .guess_uv = uv};
    cell.trend = vec3_sub(vec3_sub(b.jet.r, a.jet.r), vec3_sub(b2.jet.r, a2.jet.r));
    if (!march_solve_corner(march, &cell, &node, &reason)) {
        row->ended = true;
        return march_fail(march, cell.i, cell.j, reason);
    }
    wave_put(wave_at(wave, 0), k + 1, &node.station);
    return quadrant_place(q, row, j + k, &node.station);
}

/* Whether an edge of lane k's cell to its D is rough. */
static bool has_rough_edge(struct wave *wave, int k) {
    struct station b, c, d;
    wave_get(wave, wave_at(wave, 1), k + 1, &b);
    wave_get(wave, wave_at(wave, 1), k, &c);
    wave_get(wave, wave_at(wave, 0), k + 1, &d);
    return rough_edge(&b, &d, wave->curvature[0][k], wave->length[0]) ||
           rough_edge(&c, &d, wave->curvature[1][k], wave->length[1]);
}

static bool in_domain(const struct surface *surface, const double uv[2]) {
    bool inside = true;
    for (int k = 0; k < 2; k++) {
        const struct surface_axis *axis = &surface->axis[k];
        inside = inside && (axis->closed || (uv[k] >= surface_axis_lower(axis) &&
                                             uv[k] <= surface_axis_upper(axis)));
    }
    return inside;
}

/* Puts D of lane k, as the kernel has found it or otherwise. */
static enum status grow_lane(struct quadrant *q, int32_t j, int k) {
    struct wave *wave = q->wave;
    struct march *march = q->march;
    unsigned bit = 1u << k;
    struct wave_places *d = wave_at(wave, 0);
    if (!(wave->found & bit) || (wave->arcs && !(wave->smooth & bit) && has_rough_edge(wave, k)))
        return grow_alone(q, j, k);
    struct station station = {.surface = wave->surface,
                              .uv = {d->of[0][k + 1], d->of[1][k + 1]},
                              .jet.r = {d->of[2][k + 1], d->of[3][k + 1], d->of[4][k + 1]}};
    if (!in_domain(wave->surface, station.uv))
        wave_get(wave, d, k + 1, &station);
    march->solved++;
    march->iterations += (size_t)wave->iterations[k];
    march->residual_max = fmax(march->residual_max, wave->residual[k]);
    march->edges.rough = 0;
    return quadrant_place(q, &q->row[k + 1], j + k, &station);
}

/* A step of `lanes` rows; lane 0 is at `column`. */
static enum status take_step(struct quadrant *q, int32_t j, int lanes, int32_t column) {
    struct wave *wave = q->wave;
    const struct quadrant_row *below = &q->row[0];
    enum status status = STATUS_OK;
    q->kernel->prepare(wave);
    q->kernel->solve(wave);
    for (int k = 0; k < lanes && status == STATUS_OK; k++)
        status = grow_lane(q, j, k);
    /* What the next wave, or the row above that is not part of this one, rests on. */
    wave_get(wave, wave_at(wave, 0), lanes, &q->row[lanes].at[column - lanes + 1]);
    if (column + 1 < below->count)
        wave_put(wave_at(wave, 0), 0, &below->at[column + 1]);
    return status;
}

static int running(const struct quadrant *q, int lanes) {
    int k = 0;
    while (k < lanes && runs(q, k))
        k++;
    return k;
}

enum status wave_run(struct quadrant *q, int32_t j, int *count) {
    struct wave *wave = q->wave;
    int lanes = 0;
    bool open = true; /* rows may still join */
    *count = 1;
    wave->cursor = &q->march->cursor;
    wave->orientation = q->si * q->sj;
    wave->step = WAVE_STEPS;
    for (int32_t column = 2;; column++, wave->step++) {
        int going = running(q, lanes);
        open = open && going == lanes && lanes < q->kernel->lanes;
        hand_over(q, going, going < lanes ? lanes : 0, column - 1);
        lanes = going;
        if (open) {
            enum status status = start_lane(q, j, lanes, &open);
            if (status != STATUS_OK)
                return status;
            *count = q->row[lanes + 1].begun ? lanes + 1 : *count;
            lanes += open;
        }
        if (lanes == 0 || (lanes == 1 && !open))
            break;
        enum status status = take_step(q, j, lanes, column);
        if (status != STATUS_OK)
            return status;
    }
    hand_over(q, 0, lanes, /* the last step's */ q->row[1].count - 1);
    return STATUS_OK;
}
