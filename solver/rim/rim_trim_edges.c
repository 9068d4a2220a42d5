/* SPDX-License-Identifier: MIT */
/* The edges of a surface with trims: what of them, and of the border of the domain, has cloth on
 * one side, as chains that are joined to loops. */
#include "rim_builder.h"

#include <math.h>
#include <string.h>

/* How far beside an edge, as a share of the domain, it is asked what lies there: more than curves
 * are flattened to. */
static const double beside = 4e-6;

/* Ends of chains that are this near to each other, as a share of the domain, are joined. */
static const double joint = 1e-5;

enum { STEPS = 64, HALVINGS = 40, SUBDIVISIONS = 32 };

/* Pieces that a straight one is cut into at the most, across both cuts of a torus. */
enum { BETWEEN_CUTS = 3 };

/* Which side of a piece of edge is to be covered. */
enum cover { COVER_NEITHER, COVER_LEFT, COVER_RIGHT };

/* Polylines in the parameters while chains are made of them. */
struct polyline {
    double (*uv)[2];
    size_t count, room;
};

struct chain {
    size_t first, count; /* in the line */
    bool closed, used;
};

struct chains {
    struct rim_builder *builder;
    struct rim_window window;
    struct polyline line;
    struct chain *chain;
    size_t count, room;
};

/* ---- which of the edges count ---- */

/* Whether a place is to be covered. */
static bool is_covered(const struct chains *c, const double uv[2]) {
    const struct surface *surface = c->builder->march->surface;
    double wrapped[2], outer[2];
    for (int k = 0; k < 2; k++)
        wrapped[k] = surface_axis_wrap(&surface->axis[k], uv[k]);
    surface_outer(surface, wrapped, outer);
    return trim_contains(c->builder->march->trim, outer);
}

/* Whether a piece lies along a pole, where it is one point. */
static bool is_along_pole(const struct chains *c, const double from[2], const double to[2]) {
    const struct rim_window *w = &c->window;
    bool along = false;
    for (int n = 0; n < 4; n++) {
        int k = n / 2;
        double at = n % 2 ? w->high[k] : w->low[k], slack = beside * w->length[k];
        along |= rim_builder_is_pole(c->builder, k, n % 2) && fabs(from[k] - at) <= slack &&
                 fabs(to[k] - at) <= slack;
    }
    return along;
}

/* Which side is to be covered of a piece of edge at its place t. A trim's edge counts where it lies
 * in the domain and has what is to be covered on one side; the domain's border where the trims
 * would let the region go on beyond it. */
static enum cover cover_at(const struct chains *c, bool trim, const double from[2],
                           const double to[2], double t) {
    const struct rim_window *w = &c->window;
    double along[2], size = 0, at[2], left_of[2], right_of[2];
    for (int k = 0; k < 2; k++) {
        at[k] = from[k] + t * (to[k] - from[k]);
        along[k] = (to[k] - from[k]) / w->length[k];
        size += along[k] * along[k];
    }
    double scale = size > 0 ? beside / sqrt(size) : 0;
    const double leftward[2] = {-along[1] * scale * w->length[0], along[0] * scale * w->length[1]};
    for (int k = 0; k < 2; k++) {
        left_of[k] = at[k] + leftward[k];
        right_of[k] = at[k] - leftward[k];
    }
    for (int k = 0; k < 2 && trim; k++) {
        double slack = beside * w->length[k];
        if (!w->endless[k] && !(at[k] >= w->low[k] - slack && at[k] <= w->high[k] + slack))
            return COVER_NEITHER;
    }
    if (trim && is_along_pole(c, from, to))
        return COVER_NEITHER;
    bool left = is_covered(c, left_of), right = is_covered(c, right_of);
    if (!trim)
        return left && right ? COVER_LEFT : COVER_NEITHER;
    return left == right ? COVER_NEITHER : left ? COVER_LEFT : COVER_RIGHT;
}

/* ---- chains of those that count ---- */

/* Within the window: a trim may leave it by as much as it is asked beside it. */
static void add_to_line(struct chains *c, const double uv[2]) {
    struct polyline *line = &c->line;
    const struct rim_window *w = &c->window;
    if (line->count == line->room)
        line->uv = arena_enlarge(c->builder->march->arena, line->uv, line->count, sizeof *line->uv,
                                 &line->room);
    for (int k = 0; k < 2 && line->uv; k++)
        line->uv[line->count][k] = w->endless[k] ? uv[k] : fmin(fmax(uv[k], w->low[k]), w->high[k]);
    line->count += line->uv != NULL;
    c->builder->failed = c->builder->failed || !line->uv;
}

static void add_chain(struct chains *c, size_t first, enum cover cover, bool closed) {
    struct polyline *line = &c->line;
    if (c->builder->failed || line->count - first < 2)
        return;
    if (c->count == c->room)
        c->chain =
            arena_enlarge(c->builder->march->arena, c->chain, c->count, sizeof *c->chain, &c->room);
    c->builder->failed = !c->chain;
    if (c->builder->failed)
        return;
    for (size_t k = first, l = line->count - 1; cover == COVER_RIGHT && k < l; k++, l--)
        for (int m = 0; m < 2; m++) {
            double swap = line->uv[k][m];
            line->uv[k][m] = line->uv[l][m];
            line->uv[l][m] = swap;
        }
    c->chain[c->count++] = (struct chain){first, line->count - first, closed, false};
}

/* A run of pieces that count, while one follows a polyline. */
struct run {
    size_t first; /* of the line */
    enum cover cover;
    bool gaps; /* pieces before or in between do not count */
};

static void switch_run(struct chains *c, struct run *run, enum cover cover, const double at[2]) {
    run->gaps = run->gaps || cover == COVER_NEITHER;
    if (cover == run->cover)
        return;
    run->gaps = run->gaps || run->cover != COVER_NEITHER;
    if (run->cover != COVER_NEITHER) {
        add_to_line(c, at);
        add_chain(c, run->first, run->cover, false);
    }
    run->cover = cover;
    run->first = c->line.count;
    if (cover != COVER_NEITHER)
        add_to_line(c, at);
}

/* The chains of a closed polyline whose pieces count; its last point is its first. Each straight
 * piece is followed in steps so short that no trim across it is missed; where the ends of a step
 * are of different kinds the place between them is looked for. Where a run passes the polyline's
 * ends the two parts are joined later, unless all of it is one. */
static void follow_polyline(struct chains *c, bool trim, const double (*uv)[2], size_t count) {
    static const double inset = 1e-3;
    struct run run = {c->line.count, COVER_NEITHER, false};
    for (size_t n = 0; n + 1 < count; n++) {
        const double *from = uv[n], *to = uv[n + 1];
        double most = 0, begin[2], end[2], at[2];
        if (to[0] == from[0] && to[1] == from[1])
            continue;
        for (int m = 0; m < 2; m++)
            most = fmax(most, fabs(to[m] - from[m]) / c->window.length[m]);
        int steps = most < 1 ? 1 + (int)(most * STEPS) : STEPS;
        memcpy(end, from, sizeof end);
        for (int k = 1; k <= steps; k++) {
            memcpy(begin, end, sizeof begin);
            for (int m = 0; m < 2; m++)
                end[m] = k == steps ? to[m] : from[m] + (to[m] - from[m]) * ((double)k / steps);
            double low = inset, high = 1 - inset;
            enum cover first = cover_at(c, trim, begin, end, low),
                       last = cover_at(c, trim, begin, end, high);
            switch_run(c, &run, first, begin);
            for (int half = 0; first != last && half < HALVINGS; half++) {
                double middle = (low + high) / 2;
                *(cover_at(c, trim, begin, end, middle) == first ? &low : &high) = middle;
            }
            for (int m = 0; m < 2; m++)
                at[m] = begin[m] + high * (end[m] - begin[m]);
            switch_run(c, &run, last, at);
        }
        if (run.cover != COVER_NEITHER)
            add_to_line(c, to);
    }
    if (run.cover == COVER_NEITHER)
        return;
    bool closed = !run.gaps && memcmp(uv[0], uv[count - 1], sizeof uv[0]) == 0;
    if (closed)
        c->line.count--;
    add_chain(c, run.first, run.cover, closed);
}

/* ---- their polylines ---- */

/* The polyline gathered so far is followed. */
static void end_stretch(struct chains *c, struct polyline *stretch) {
    follow_polyline(c, true, (const double(*)[2])stretch->uv, stretch->count);
    stretch->count = 0;
}

/* A straight piece in inner parameters, cut where it crosses the window's border in a direction in
 * which the cloth is cut open, and moved into the window by whole turns. What does not go on from
 * the stretch's last point begins another. */
static void add_straight(struct chains *c, struct polyline *stretch, const double from[2],
                         const double to[2]) {
    const struct rim_window *w = &c->window;
    const struct surface_axis *axis = c->builder->march->surface->axis;
    double share = 0, begin[2], end[2], moved[2][2];
    memcpy(end, from, sizeof end);
    while (share < 1) {
        double next = 1; /* where it leaves the window's turn that it is in */
        memcpy(begin, end, sizeof begin);
        for (int k = 0; k < 2; k++)
            for (int turn = -1; turn <= 1 && axis[k].closed && !w->endless[k]; turn++) {
                double at = (w->low[k] + turn * w->length[k] - from[k]) / (to[k] - from[k]);
                next = at > share && at < next ? at : next;
            }
        share = next;
        for (int k = 0; k < 2; k++) {
            end[k] = share < 1 ? from[k] + share * (to[k] - from[k]) : to[k];
            double turns = axis[k].closed && !w->endless[k]
                               ? floor(((begin[k] + end[k]) / 2 - w->low[k]) / w->length[k])
                               : 0;
            moved[0][k] = begin[k] - turns * w->length[k];
            moved[1][k] = end[k] - turns * w->length[k];
        }
        const double *last = stretch->count > 0 ? stretch->uv[stretch->count - 1] : NULL;
        if (last && (last[0] != moved[0][0] || last[1] != moved[0][1]))
            end_stretch(c, stretch);
        if (stretch->count == 0)
            memcpy(stretch->uv[stretch->count++], moved[0], sizeof *moved);
        memcpy(stretch->uv[stretch->count++], moved[1], sizeof *moved);
    }
}

/* In how many parts a straight piece of a trim is as straight in inner parameters, as far as it is
 * asked what lies beside it: a parabola that leaves its chord by h has n that leave theirs by
 * h/n^2.
 */
static int straight_parts(const struct chains *c, const double a[2], const double b[2]) {
    const struct surface *surface = c->builder->march->surface;
    const double middle[2] = {(a[0] + b[0]) / 2, (a[1] + b[1]) / 2};
    double at[3][2], bend = 0;
    surface_inner(surface, a, at[0]);
    surface_inner(surface, middle, at[1]);
    surface_inner(surface, b, at[2]);
    for (int k = 0; k < 2; k++)
        bend = fmax(bend, fabs(at[1][k] - (at[0][k] + at[2][k]) / 2) /
                              surface_axis_length(&surface->axis[k]));
    double parts = ceil(sqrt(4 * bend / beside));
    return parts < 1 ? 1 : parts > SUBDIVISIONS ? SUBDIVISIONS : (int)parts;
}

/* Follows a loop in stretches between the cuts of the window; where its straight lines are bent in
 * inner parameters, in parts. */
static void follow_trim_loop(struct chains *c, size_t loop) {
    const struct surface *surface = c->builder->march->surface;
    const double(*outer)[2];
    size_t count = trim_loop_points(c->builder->march->trim, loop, &outer);
    bool bent = surface->axis[0].factor != 1 || surface->axis[1].factor != 1;
    struct polyline stretch = {.room = 1 + BETWEEN_CUTS * count * (bent ? SUBDIVISIONS : 1)};
    double from[2], to[2], at[2];
    stretch.uv = arena_alloc(c->builder->march->arena, stretch.room, sizeof *stretch.uv);
    c->builder->failed = c->builder->failed || !stretch.uv;
    if (count < 3 || c->builder->failed)
        return;
    surface_inner(surface, outer[0], from);
    for (size_t k = 1; k < count; k++) {
        int parts = bent ? straight_parts(c, outer[k - 1], outer[k]) : 1;
        for (int part = 1; part <= parts && !c->builder->failed; part++) {
            for (int m = 0; m < 2; m++)
                at[m] = outer[k - 1][m] + (double)part / parts * (outer[k][m] - outer[k - 1][m]);
            surface_inner(surface, part == parts ? outer[k] : at, to);
            add_straight(c, &stretch, from, to);
            memcpy(from, to, sizeof from);
        }
    }
    end_stretch(c, &stretch);
}

/* ---- chains joined to loops ---- */

/* How far apart two places are: in parameters, as shares of the domain, round endless directions
 * too. */
static double gap_between(const struct chains *c, const double p[2], const double q[2]) {
    double most = 0;
    for (int k = 0; k < 2; k++) {
        double gap = fabs(p[k] - q[k]) / c->window.length[k];
        if (c->window.endless[k])
            gap = fmin(gap, fabs(1 - gap));
        most = fmax(most, gap);
    }
    return most;
}

/* Adds of a chain the points that it needs. Which of its pieces count was asked of all of them:
 * what lies beside a piece that leaves some out is not what lies beside the edge. */
static void add_kept_points(struct chains *c, const struct chain *chain) {
    const double(*uv)[2] = (const double(*)[2])c->line.uv + chain->first;
    const uint8_t *kept =
        rim_builder_keep_points(c->builder, c->builder->march->surface, uv, chain->count);
    for (size_t k = 0; kept && k < chain->count; k++)
        if (kept[k])
            rim_builder_add_point(c->builder, uv[k][0], uv[k][1]);
}

/* Joins chain after chain, until the nearest beginning is the loop's own. */
static void join_rim_chains(struct chains *c) {
    for (size_t k = 0; k < c->count && !c->builder->failed; k++) {
        struct chain *chain = &c->chain[k];
        const double *begin = c->line.uv[chain->first];
        if (chain->used)
            continue;
        for (struct chain *next; chain; chain = next) {
            const double *end = c->line.uv[chain->first + chain->count - 1];
            double gap = HUGE_VAL, own_gap = gap_between(c, end, begin);
            chain->used = true;
            add_kept_points(c, chain);
            next = NULL;
            if (chain->closed)
                break;
            if (!c->builder->failed)
                c->builder->edges->vertices[c->builder->edges->vertex_count - 1].leaps = true;
            for (size_t n = 0; n < c->count; n++) {
                struct chain *other = &c->chain[n];
                double own = other->used || other->closed
                                 ? HUGE_VAL
                                 : gap_between(c, end, c->line.uv[other->first]);
                next = own < gap ? other : next;
                gap = fmin(gap, own);
            }
            if (own_gap <= joint || (own_gap <= gap && gap > joint))
                next = NULL;
        }
        rim_builder_end_loop(c->builder, false);
    }
}

void rim_builder_add_trims(struct rim_builder *b, const struct rim_window *w) {
    struct chains c = {.builder = b, .window = *w};
    const struct trim *trim = b->march->trim;
    const double corner[5][2] = {{w->low[0], w->low[1]},
                                 {w->high[0], w->low[1]},
                                 {w->high[0], w->high[1]},
                                 {w->low[0], w->high[1]},
                                 {w->low[0], w->low[1]}};
    for (int k = 0; k < 4; k++) {
        int axis = k % 2 ? 0 : 1, end = k == 1 || k == 2;
        if (!w->endless[axis] && !rim_builder_is_pole(b, axis, end))
            follow_polyline(&c, false, &corner[k], 2);
    }
    for (size_t k = 0; k < trim_loop_count(trim) && !b->failed; k++)
        follow_trim_loop(&c, k);
    join_rim_chains(&c);
}
