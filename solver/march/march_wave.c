/* SPDX-License-Identifier: MIT */
/*
 * Rows of a quadrant side by side, as a wave. Row k begins when row k - 1 is three places long
 * (where weft slides four), and goes on as long as it is sure to, whatever becomes of the rows
 * below. From there on, and where the kernel leaves a cell alone, it is marched like any other row.
 */
#include "cuts.h"
#include "quadrant.h"
#include "solver/fishnet/rough.h"
#include "solver/shell/crossing.h"
#include "solver/wide.h"

#include <string.h>

/* Of the way to the cut opposite the start: what lies nearer is certainly inside. */
static const double not_quite = 1 - 1e-9;

/* Between which parameters a node is inside whatever else: of a closed direction up to the
 * cut. Nowhere, where a trim has to be asked. */
static void find_safe_bounds(const struct march *march, struct wave *wave) {
    const struct shell *shell = wave->surface->shell;
    bool trimmed = shell ? shell_trim(shell, wave->surface->face) : march->trim;
    for (int k = 0; k < 2; k++) {
        const struct surface_axis *axis = &wave->surface->axis[k];
        double centre = march->cut.centre[k];
        double turn = shell ? HUGE_VAL : surface_point_cut_turn(wave->surface, k);
        wave->lower[k] = axis->closed ? centre - not_quite * turn : surface_axis_lower(axis);
        wave->upper[k] = axis->closed ? centre + not_quite * turn : surface_axis_upper(axis);
        if (trimmed)
            wave->upper[k] = -HUGE_VAL;
    }
}

enum status wave_make(const struct march *march, struct arena *arena, int most,
                      struct quadrant *q) {
    const struct drape_settings *s = march->settings;
    int lanes = s->lanes && s->lanes < most ? s->lanes : most;
    /* It can go over patches, by methods whose edges have chords of known length. */
    bool suits = march->method->yarn != DRAPE_YARN_GEODESIC && march->surface && !march->mesh &&
                 s->yarn_path == DRAPE_PATH_CHORD;
    q->kernel = suits ? wave_kernel_for(lanes) : NULL;
    if (!q->kernel)
        return STATUS_OK;
    q->wave = arena_alloc(arena, 1, sizeof *q->wave);
    if (!q->wave)
        return STATUS_OUT_OF_MEMORY;
    q->wave->surface = march->surface;
    memcpy(q->wave->length, s->spacing, sizeof q->wave->length);
    q->wave->slide = s->slide;
    q->wave->lag = s->slide > 0 ? 2 : 1;
    q->wave->arcs = march->method->yarn != DRAPE_YARN_CHORD;
    q->wave->corrected = march->before.net;
    q->wave->pole_reach2 = march_pole_reach2(march);
    for (int k = 0; k <= WAVE_LANES; k++)
        q->before[k] = march->before;
    find_safe_bounds(march, q->wave);
    return STATUS_OK;
}

/* Whether lane k's row goes on for certain: it does not end, or the rows below reach far enough as
 * they are. Where those are complete, whether it goes on at all. */
static bool goes(const struct quadrant *q, int k) {
    const struct quadrant_row *row = &q->row[k + 1], *below = &q->row[k];
    int32_t i = row->count, fringe = q->march->fringe;
    int32_t one = k > 0 ? below->last : q->reach[0];
    int32_t two = k > 1 ? q->row[k - 1].last : k == 1 ? q->reach[0] : q->reach[1];
    return !row->ended && !row->parted && !row->waits && i < q->length &&
           (i <= row->last + fringe || i <= one + fringe || i <= two + fringe);
}

/* And it lies on a place of the row below; where weft slides on two. */
static bool runs(const struct quadrant *q, int k) {
    const struct quadrant_row *row = &q->row[k + 1], *below = &q->row[k];
    return goes(q, k) && row->count + (int32_t)q->wave->lag - 1 < below->count &&
           quadrant_has_cell(below, row);
}

static struct vec3 wave_position(const struct wave_places *places, int slot) {
    enum { AT_X = offsetof(struct wave_point, jet.r) / sizeof(double) };
    return vec3_make(places->of[AT_X][slot], places->of[AT_X + 1][slot],
                     places->of[AT_X + 2][slot]);
}

static bool is_regular(const struct net_node *node) {
    return node && (node->state == NET_INSIDE || node->state == NET_GHOST) && !node->grown &&
           !node->rough && !node->beside;
}

/* ---- the faces of a shell ---- */

static const struct differences none = {0};

/* By lane k's edge, whose differences are not known as far as they are not given. */
static void set_differences(struct wave *wave, int k, const struct differences *edge) {
    for (int order = 0; order < WAVE_ORDERS; order++)
        for (int n = 0; n < 2; n++)
            wave->difference[order][n][k] = order < edge->count ? edge->of[order][n] : (double)NAN;
}

/* The face that A, B and C of lane k's cell lie on; NULL: they do not lie on one. */
static const struct surface *cell_face(struct wave *wave, int k) {
    const struct surface *surface = wave_a(wave)->surface[k];
    return surface == wave_c(wave)->surface[k] && surface == wave_b(wave)->surface[k + 1] ? surface
                                                                                          : NULL;
}

/* Lanes whose D is found and in the region of its face, as it was on the way there: elsewhere it
 * belongs to another one, or there is none. */
static void drop_outside_faces(struct wave *wave) {
    for (unsigned bits = wave->found & ~wave->inside; bits; bits &= bits - 1) {
        int k = __builtin_ctz(bits);
        double(*d)[WAVE_STRIDE] = wave->into->of;
        const double uv[3][2] = {{wave->expected[0][k], wave->expected[1][k]},
                                 {wave->tried[0][k], wave->tried[1][k]},
                                 {d[0][k + 1], d[1][k + 1]}};
        unsigned bit = 1u << k;
        if (crossing_within(wave->surface, uv[0]) && crossing_within(wave->surface, uv[1]) &&
            crossing_within(wave->surface, uv[2]))
            wave->inside |= bit;
        else
            wave->found &= ~bit;
    }
}

/* What the net before says of a place, by the nodes beside it, along warp and along weft. */
INLINE void note_before(struct wave_before *to, int slot, const struct net_node *at,
                        const struct net_node *const side[4]) {
    to->even[slot] = -1;
    to->face[slot] = at->face;
    for (int k = 0; k < 2; k++) {
        struct vec3 bend = correction_bend(side[2 * k]->r, at->r, side[2 * k + 1]->r);
        to->uv[k][slot] = at->uv[k];
        to->bend[k][0][slot] = bend.x;
        to->bend[k][1][slot] = bend.y;
        to->bend[k][2][slot] = bend.z;
    }
}

/* The places of row y of a tile that `is_regular` says yes of, as bits. */
static unsigned regular_bits(const struct net_tile *tile, int y) {
    return tile->bits[NET_BIT_PLACE][y] & ~tile->bits[NET_BIT_GROWN][y] &
           ~(unsigned)tile->bits[NET_BIT_ROUGH][y];
}

/* Of a second march: takes in what the net before says of place i of row j, as that of a slot some
 * steps back. Next to a generator D2 is not the same for both edges that end there. */
static void recall(struct quadrant *q, unsigned back, int slot, int32_t i, int32_t j) {
    enum { LAST = NET_TILE - 1 };
    struct wave_before *to = wave_before_at(q->wave, back);
    struct net_view *view = &q->before[slot];
    to->even[slot] = 0;
    if (!q->wave->corrected || i == 0 || j == 0)
        return;
    net_view_move(view, i * q->si, j * q->sj);
    const struct net_window *window = &view->window;
    int x = i * q->si - view->ti * NET_TILE, y = j * q->sj - view->tj * NET_TILE;
    const struct net_tile *tile = window->tile[1][1];
    if (tile && x > 0 && x < LAST && y > 0 &&
        y < LAST) { /* as most: all beside it are of its tile */
        const struct net_node *at = &tile->node[y][x];
        unsigned row = regular_bits(tile, y),
                 across = regular_bits(tile, y - 1) & regular_bits(tile, y + 1);
        const struct net_node *const side[4] = {at - 1, at + 1, at - NET_TILE, at + NET_TILE};
        if ((row & row >> 1 & row << 1 & across) >> x & 1)
            note_before(to, slot, at, side);
        return;
    }
    const struct net_node *at = net_window_find(window, x, y);
    const struct net_node *side[4] = {
        net_window_find(window, x - 1, y), net_window_find(window, x + 1, y),
        net_window_find(window, x, y - 1), net_window_find(window, x, y + 1)};
    if (is_regular(at) && is_regular(side[0]) && is_regular(side[1]) && is_regular(side[2]) &&
        is_regular(side[3]))
        note_before(to, slot, at, side);
}

/* Where weft slides: notes whether place i of row j is a node with smooth edges. */
static void note_even(struct quadrant *q, unsigned back, int slot, int32_t i, int32_t j) {
    if (q->wave->lag == 1)
        return;
    const struct net_node *node = march_node_at(q->march, i * q->si, j * q->sj);
    bool there = node && (node->state == NET_INSIDE || node->state == NET_GHOST);
    wave_at(q->wave, back)->even[slot] = there && !node->rough && !node->parted ? -1 : 0;
}

/* Place i of row j, as that of a slot some steps back. */
static void put_in_slot(struct quadrant *q, unsigned back, int slot,
                        const struct surface_point *point, int32_t i, int32_t j) {
    wave_put(wave_at(q->wave, back), slot, point);
    note_even(q, back, slot, i, j);
    recall(q, back, slot, i, j);
}

/* The lanes of a wave from `low` to the one before `high`, lane 0 at `column`. */
struct front {
    int low, high;
    int32_t column;
    bool open;   /* rows may still join */
    bool steady; /* at the last step all lanes had a usual node */
};

/* The place of lane k at this step. */
static int32_t front_column(const struct quadrant *q, const struct front *front, int k) {
    return front->column - (int32_t)q->wave->lag * k;
}

/* Begins the row above the front, if it is time: its places up to the front, which it then joins.
 * As long as the row below has not come in it is not certain that there is to be one. */
static enum status start_row(struct quadrant *q, int32_t j, struct front *front, int *count) {
    const int k = front->high;
    struct quadrant_row *row = &q->row[k + 1], *below = &q->row[k];
    const int32_t lag = (int32_t)q->wave->lag;
    if (front_column(q, front, k) < 2 || (k > 0 && below->last < 0))
        return STATUS_OK;
    front->open = below->count > 1 + lag && q->length > 1 + lag;
    if (!front->open)
        return STATUS_OK;
    quadrant_begin_row(q, below, row, j + k);
    row->begun = true;
    *count = k + 1;
    struct differences edge = row->edge; /* to the last place but one */
    front->open = row->planted && quadrant_has_cell(below, row);
    while (front->open && row->count < front_column(q, front, k)) {
        edge = row->edge;
        if (lag > 1 && quadrant_rests_far(q, below, row, j + k)) {
            front->open = false;
            break;
        }
        enum status status = quadrant_grow_node(q, below, row, j + k);
        if (status != STATUS_OK)
            return status;
        front->open = runs(q, k);
    }
    if (!front->open)
        return STATUS_OK;
    front->high++;
    for (int32_t back = 1; back <= 2 + lag; back++) {
        int32_t i = row->count - back, at = 2 + lag - back;
        if (i >= 0)
            put_in_slot(q, (unsigned)back, k + 1, &row->at[i], i, j + k);
        if (k == 0)
            put_in_slot(q, (unsigned)back, 0, &below->at[at], at, j - 1);
    }
    set_differences(q->wave, k, &edge);
    return STATUS_OK;
}

/* Leaves lanes from `first` to the one before `lanes` to be marched row by row, after a step at
 * which lane 0 had the place `column`: what their next places rest on is put into the rows, that of
 * the row below from lane `from` on. */
static void leave_rows(struct quadrant *q, int from, int first, int lanes, int32_t column) {
    struct wave *wave = q->wave;
    for (int k = from; k < lanes; k++) {
        struct quadrant_row *row = &q->row[k + 1];
        int32_t at = column - (int32_t)wave->lag * k;
        for (int n = 0; n < 2 + (int)wave->lag && at - n >= 2; n++)
            wave_get(wave_at(wave, 1 + (unsigned)n), k + 1, &row->at[at - n]);
        if (k < first)
            continue;
        struct surface_point below;
        wave_get_forms(wave_at(wave, 1 + wave->lag), k, &below);
        for (row->edge.count = 0; row->edge.count < WAVE_ORDERS; row->edge.count++) {
            double(*of)[WAVE_LANES] = wave->difference[row->edge.count];
            if (isnan(of[0][k]))
                break;
            row->edge.of[row->edge.count][0] = of[0][k];
            row->edge.of[row->edge.count][1] = of[1][k];
        }
        quadrant_take_edge(&row->edge, &below, &row->at[at], &row->at[at - 1]);
    }
}

/* Lane k's cell, as the scalar code has it, and the corners that it rests on. */
struct lane_cell {
    struct surface_point a, b, c;
    struct march_cell cell;
};

static void take_lane(struct quadrant *q, int32_t j, int k, struct lane_cell *to) {
    struct wave *wave = q->wave;
    struct surface_point a2, b2;
    wave_get(wave_a(wave), k, &to->a);
    wave_get(wave_b(wave), k + 1, &to->b);
    wave_get(wave_c(wave), k, &to->c);
    wave_get(wave_at(wave, wave->lag + 2), k, &a2);
    wave_get(wave_at(wave, 2), k + 1, &b2);
    to->cell = (struct march_cell){.i = q->row[k + 1].count * q->si,
                                   .j = (j + k) * q->sj,
                                   .si = q->si,
                                   .sj = q->sj,
                                   .a = &to->a,
                                   .b = &to->b,
                                   .c = &to->c};
    to->cell.trend = vec3_sub(vec3_sub(to->b.jet.r, to->a.jet.r), vec3_sub(b2.jet.r, a2.jet.r));
}

/* A cell that the kernel has left alone. */
static enum status grow_alone(struct quadrant *q, int32_t j, int k) {
    struct wave *wave = q->wave;
    struct quadrant_row *row = &q->row[k + 1];
    struct march *march = q->march;
    struct fishnet_node node;
    enum drape_reason reason;
    struct lane_cell at;
    double uv[2] = {wave->expected[0][k], wave->expected[1][k]};
    q->alone++;
    take_lane(q, j, k, &at);
    struct march_cell *cell = &at.cell;
    if (cell_face(wave, k) && !surface_point_near_pole(at.c.surface, at.c.jet.r, wave->pole_reach2))
        cell->guess_uv = uv;
    if (!march_solve_corner(march, cell, &node, &reason)) {
        quadrant_stop_row(q, row, at.b.jet.r);
        return march_fail_cell(march, cell->i, cell->j, reason, &at.b);
    }
    wave_put(wave_at(wave, 0), k + 1, &node.point);
    return quadrant_place(q, row, j + k, &node.point);
}

/* Puts D of lane k: as the kernel has found it, unless an edge of its cell is no arc, or has
 * another chord than it was found by. */
static enum status grow_lane(struct quadrant *q, int32_t j, int k) {
    struct wave *wave = q->wave;
    struct march *march = q->march;
    struct surface_point from[2], d;
    unsigned bit = 1u << k;
    bool looks = !(wave->smooth & bit), uneven = looks && (!wave->corrected || wave->slide > 0);
    wave_get(wave_at(wave, 0), k + 1, &d);
    if (looks && !uneven) {
        struct march_cell cell = {
            .i = q->row[k + 1].count * q->si, .j = (j + k) * q->sj, .si = q->si, .sj = q->sj};
        struct march_corrections corrections;
        wave_get(wave_b(wave), k + 1, &from[0]);
        wave_get(wave_c(wave), k, &from[1]);
        net_view_move(&march->before, cell.i, cell.j);
        march_find_corrections(march, &cell, &corrections);
        for (int n = 0; n < 2 && !uneven; n++) {
            double found = wave->chord[n][k], chord = found;
            corrections.of[n].whole = wave->whole[n][k] != 0;
            uneven = march_edge_chord(march, &corrections, n, &from[n], &d, wave->curvature[n][k],
                                      &chord) != ROUGH_NOT ||
                     chord != found;
        }
    }
    if (!(wave->found & bit) || uneven)
        return grow_alone(q, j, k);
    q->kept++;
    march_count_solved(march, (size_t)wave->iterations[k], wave->residual[k]);
    march->edges.rough = 0;
    return quadrant_place(q, &q->row[k + 1], j + k, &d);
}

/* The same where the kernel has found it, on smooth edges and inside, in short. */
static enum status grow_inside(struct quadrant *q, int32_t j, int k) {
    const struct wave *wave = q->wave;
    struct march *march = q->march;
    struct quadrant_row *row = &q->row[k + 1];
    double(*d)[WAVE_STRIDE] = q->wave->places[wave->step % WAVE_STEPS].of;
    int32_t i = row->count * q->si, at = (j + k) * q->sj;
    struct net_tile *tile = q->tile[k];
    if (!tile || tile->ti != i >> NET_TILE_BITS || tile->tj != at >> NET_TILE_BITS)
        tile = q->tile[k] = net_touch(march->net, i, at);
    if (!tile)
        return STATUS_OUT_OF_MEMORY;
    row->last = row->count++;
    q->kept++;
    march_count_solved(march, (size_t)wave->iterations[k], wave->residual[k]);
    /* Member by member: a copy would have to wait for the stores that made it. */
    int x = i & (NET_TILE - 1), y = at & (NET_TILE - 1);
    struct net_node *node = &tile->node[y][x];
    node->r = vec3_make(d[2][k + 1], d[3][k + 1], d[4][k + 1]);
    node->uv[0] = d[0][k + 1];
    node->uv[1] = d[1][k + 1];
    node->state = NET_INSIDE;
    node->turn = node->across = 0;
    node->reason = 0;
    node->grown = row->count > row->grown;
    node->rough = 0;
    node->face = (uint16_t)wave->surface->face;
    node->yarns = 0;
    node->parted = 0;
    node->beside = 0;
    net_set_bits(tile, x, y, node);
    if (++march->counts.inside > march->max_nodes)
        return STATUS_TOO_MANY_NODES;
    return node->grown ? march_note_step(march, i, at, q->si, q->sj, MARCH_CELL, true) : STATUS_OK;
}

/* What the net before says of lane k's cell, where that is not even all round. */
static void correct_lane(struct quadrant *q, int32_t j, int k) {
    struct wave *wave = q->wave;
    struct march *march = q->march;
    const struct wave_places *at_a = wave_a(wave);
    struct surface_point a = {.surface = at_a->surface[k]}, b, c;
    struct march_cell cell = {q->row[k + 1].count * q->si,
                              (j + k) * q->sj,
                              q->si,
                              q->sj,
                              &a,
                              &b,
                              &c,
                              {0, 0, 0},
                              NULL,
                              NULL,
                              wave->excess[k]};
    struct march_corrections corrections;
    double uv[2];
    a.uv[0] = at_a->of[0][k];
    a.uv[1] = at_a->of[1][k];
    wave_get_forms(wave_b(wave), k + 1, &b);
    wave_get_forms(wave_c(wave), k, &c);
    net_view_move(&march->before, cell.i, cell.j);
    bool guessed = march_guess_from_before(march, &cell, uv);
    march_find_corrections(march, &cell, &corrections);
    for (int n = 0; n < 2; n++) {
        const struct correction *of = &corrections.of[n];
        const double bend[3] = {of->bend[1].x, of->bend[1].y, of->bend[1].z};
        wave->expected[n][k] = guessed ? uv[n] : wave->expected[n][k];
        wave->chord[n][k] = march_corrected_chord(&corrections, n, n ? &c : &b,
                                                  wave->curvature[n][k], wave->chord[n][k]);
        wave->whole[n][k] = corrections.has[n] && of->whole ? -1 : 0;
        for (int x = 0; x < 3; x++)
            wave->bend[n][x][k] = bend[x];
    }
}

/* What is expected of D of these lanes, by the net before too. */
static void prepare_cells(struct quadrant *q, int32_t j, unsigned lanes) {
    struct wave *wave = q->wave;
    const bool shell = q->march->surface->shell;
    for (unsigned bits = lanes; bits && (wave->corrected || shell); bits &= bits - 1) {
        int k = __builtin_ctz(bits);
        /* As `quadrant_take_edge`; and a guess by the net before on another face is given up. */
        if (shell && wave_at(wave, 2)->surface[k + 1] != wave_at(wave, 1)->surface[k + 1])
            set_differences(wave, k, &none);
        if (!wave->corrected)
            continue;
        recall(q, 0, k + 1, q->row[k + 1].count, j + k);
        if (wave->slide > 0) {
            const struct march_cell cell = {
                .i = q->row[k + 1].count * q->si, .j = (j + k) * q->sj, .si = q->si, .sj = q->sj};
            wave->excess[k] = march_slide_excess(q->march, &cell);
        }
        const struct surface *surface = cell_face(wave, k);
        const struct wave_before *a = wave_before_at(wave, wave->lag + 1);
        const struct wave_before *b = wave_before_at(wave, 1), *c = wave_before_at(wave, wave->lag);
        struct wave_before *d = wave_before_at(wave, 0);
        bool same = surface && d->face[k + 1] == surface->face && a->face[k] == surface->face &&
                    c->face[k] == surface->face && b->face[k + 1] == surface->face;
        if (shell && !same)
            d->even[k + 1] = 0;
    }
    q->kernel->prepare(wave);
    for (unsigned bits = lanes; bits && (wave->corrected || shell); bits &= bits - 1) {
        int k = __builtin_ctz(bits);
        if (wave_a(wave)->surface[k] != wave_b(wave)->surface[k + 1])
            set_differences(wave, k, &none);
        if (wave->corrected && !(wave->settled >> k & 1) && cell_face(wave, k))
            correct_lane(q, j, k);
    }
}

/* Puts D of these lanes, of one face after the other: those whose cells lie on the face of the
 * first that lies on one are solved together, and those that lie on none alone. */
static enum status take_wave_step(struct quadrant *q, int32_t j, struct front *front) {
    struct wave *wave = q->wave;
    struct wave_places *at = wave_at(wave, 0);
    const bool shell = q->march->surface->shell;
    const unsigned lanes = (1u << front->high) - (1u << front->low);
    enum status status = STATUS_OK;
    unsigned left = lanes;
    prepare_cells(q, j, lanes);
    for (int k = front->low; k < front->high; k++)
        quadrant_take_growth(&q->row[k], &q->row[k + 1]);
    for (int slot = 0; slot < WAVE_STRIDE; slot++)
        at->even[slot] = -1;
    front->steady = true;
    while (left && status == STATUS_OK) {
        const struct surface *surface = NULL;
        unsigned together = shell ? 0 : left;
        for (unsigned bits = shell ? left : 0; bits; bits &= bits - 1) {
            int k = __builtin_ctz(bits);
            const struct surface *own = cell_face(wave, k);
            surface = surface ? surface : own;
            together |= own && own == surface ? 1u << k : 0;
        }
        if (!together)
            break;
        together = wave->slide > 0 ? together & wave->plain : together;
        if (!together)
            break;
        if (surface && surface != wave->surface) {
            wave->surface = surface;
            find_safe_bounds(q->march, wave);
        }
        for (int k = 0; k < WAVE_LANES; k++)
            wave->active[k] = together >> k & 1 ? -1 : 0;
        wave->lane = __builtin_ctz(together);
        wave->into = together == lanes ? at : &wave->spare;
        q->kernel->solve(wave);
        wave->found &= together;
        if (wave->surface->shell)
            drop_outside_faces(wave);
        unsigned usual = wave->found & wave->inside & wave->smooth;
        usual = q->march->cut.slit[0] ? 0 : usual;
        for (unsigned bits = q->march->cuts ? together : 0; bits; bits &= bits - 1) {
            int k = __builtin_ctz(bits);
            struct vec3 r = wave_position(wave->into, k + 1);
            if (!cuts_may_be_near(q->march->cuts, r))
                continue;
            if (march_is_at_point(q->march, wave_position(wave_a(wave), k)))
                wave->found &= ~(1u << k);
            if (!(wave->found >> k & 1) || march_is_beside_cut(q->march, r))
                usual &= ~(1u << k);
        }
        front->steady = front->steady && usual == together;
        for (unsigned bits = together; bits && status == STATUS_OK; bits &= bits - 1) {
            int k = __builtin_ctz(bits);
            at->surface[k + 1] = wave->surface;
            for (int n = 0; together != lanes && n < WAVE_NUMBERS; n++)
                at->of[n][k + 1] = wave->spare.of[n][k + 1];
            status = usual >> k & 1 ? grow_inside(q, j, k) : grow_lane(q, j, k);
            if (!(usual >> k & 1))
                note_even(q, 0, k + 1, q->row[k + 1].count - 1, j + k);
        }
        left &= ~together;
    }
    front->steady = front->steady && !left;
    for (; left && status == STATUS_OK; left &= left - 1) {
        int k = __builtin_ctz(left);
        status = grow_alone(q, j, k);
        note_even(q, 0, k + 1, q->row[k + 1].count - 1, j + k);
    }
    /* What the next wave, or the row above that is not part of this one, rests on. */
    int top = front->high;
    wave_get(wave_at(wave, 0), top, &q->row[top].at[front_column(q, front, top - 1)]);
    return status;
}

/* Leaves lanes to be marched row by row: those at the bottom that are complete, and where not all
 * are steady, from the first that may not go on. Of the row that the bottom one then lies on,
 * places are brought into being as they are needed. */
static enum status end_rows(struct quadrant *q, int32_t j, struct front *front) {
    enum status status = STATUS_OK;
    for (; front->low < front->high; front->low++) {
        int low = front->low;
        struct quadrant_row *row = &q->row[low + 1], *below = &q->row[low];
        bool found = false;
        int32_t i = row->count, last = i + (int32_t)q->wave->lag - 1; /* that it rests on */
        row->waits = last >= below->count && (below->parted || below->waits);
        if (goes(q, low)) {
            status = quadrant_reach_below(q, below, i, j + low, &found);
            if (status != STATUS_OK)
                break;
            if (!found)
                quadrant_stop_row(q, row, wave_position(wave_at(q->wave, 1), low + 1));
            row->waits = found && !quadrant_has_cell(below, row);
            found = found && !row->waits;
        }
        bool ahead = found && last < q->length;
        if (ahead && last > i)
            status = quadrant_reach_below(q, below, last, j + low, &ahead);
        wave_at(q->wave, 1)->even[low] = 0; /* unless there is a place ahead */
        if (ahead && status == STATUS_OK)
            put_in_slot(q, 1, low, &below->at[last], last, j + low - 1);
        if (found || status != STATUS_OK)
            break;
        leave_rows(q, low, low, low + 1, front->column - 1);
    }
    int going = front->steady ? front->high : front->low + 1;
    while (going < front->high && runs(q, going))
        going++;
    if (going >= front->high)
        return status;
    leave_rows(q, going - 1, going, front->high, front->column - 1);
    front->high = going;
    front->open = false;
    return status;
}

/* Where weft slides: leaves the lanes from the first that rests on places further ahead in the row
 * below, which it may not have yet; the bottom one's is complete. */
static void leave_far(struct quadrant *q, int32_t j, struct front *front) {
    struct wave *wave = q->wave;
    int going = front->low;
    const struct wave_places *a = wave_a(wave), *c = wave_c(wave), *ahead = wave_at(wave, 1);
    for (int k = 0; k < WAVE_LANES; k++) {
        bool going_on = k >= front->low && k < front->high;
        wave->side[k] = going_on ? c->surface[k]->side : 1;
        wave->one[k] = going_on && a->surface[k] == wave->surface &&
                               c->surface[k] == wave->surface && ahead->surface[k] == wave->surface
                           ? -1
                           : 0;
    }
    q->kernel->lean(wave);
    for (; going < front->high; going++) {
        struct lane_cell at;
        if (wave->plain >> going & 1 || going == front->low)
            continue;
        take_lane(q, j, going, &at);
        if (march_slide_rests_far(q->march, &at.cell))
            break;
    }
    if (going == front->high)
        return;
    leave_rows(q, going - 1, going, front->high, front->column - 1);
    front->high = going;
    front->open = false;
}

/* Where more than a third of the cells have to be solved again, alone, rows go one by one for a
 * while. */
enum status wave_run(struct quadrant *q, int32_t j, int *count) {
    enum { REST = 16 };
    struct wave *wave = q->wave;
    struct front front = {.column = 2, .open = true};
    int32_t left = q->march->by_rows ? quadrant_block_end(q, j) - j : q->kernel->lanes;
    int most = left < q->kernel->lanes ? left : q->kernel->lanes;
    enum status status = STATUS_OK;
    *count = 1;
    if (q->resting > 0) {
        q->resting--;
        return STATUS_OK;
    }
    q->kept = q->alone = 0;
    wave->cursor = &q->march->cursor;
    wave->orientation = q->si * q->sj;
    wave->step = WAVE_STEPS;
    for (; status == STATUS_OK; front.column++, wave->step++) {
        status = end_rows(q, j, &front);
        front.open = front.open && front.high < most;
        if (front.open && status == STATUS_OK)
            status = start_row(q, j, &front, count);
        if (wave->slide > 0 && front.high > front.low && status == STATUS_OK)
            leave_far(q, j, &front);
        if (front.high - front.low <= !front.open || status != STATUS_OK) {
            leave_rows(q, front.low, front.low, front.high, front.column - 1);
            break;
        }
        status = take_wave_step(q, j, &front);
    }
    q->resting = 2 * q->alone > q->kept ? REST : 0;
    return status;
}
