/* SPDX-License-Identifier: MIT */
#include "rim_edges.h"

#include <string.h>

/* How far beside an edge, as a share of the domain, it is asked what lies there: more than curves
 * are flattened to. */
static const double beside = 4e-6;

/* Ends of chains that are this near to each other, as a share of the domain, are joined. */
static const double joint = 1e-5;

/* Tangents whose sine is less than this, beside singular corners, give no sure normal; nor do those
 * that vanish at poles. */
static const double parallel = 1e-6;

enum { SIDE_PIECES = 64, HALVINGS = 40, SUBDIVISIONS = 32 };

/* The domain as the net sees it: closed directions cut open, or without an end. */
struct window {
    double low[2], high[2], length[2];
    bool endless[2];
};

/* Which side of a piece of edge is to be covered. */
enum cover { COVER_NEITHER, COVER_LEFT, COVER_RIGHT };

/* Polylines in the parameters while chains are made of them. */
struct polyline {
    double (*uv)[2];
    size_t count, room;
};

struct chain {
    size_t first, count; /* in the builder's line */
    bool closed, used;
};

struct builder {
    struct march *march;
    struct rim_edges *edges;
    double tolerance;
    struct window window;
    struct polyline line;
    struct chain *chains;
    size_t chain_count, chain_room;
    bool failed; /* no memory */
};

void rim_edges_spot(struct march *march, const struct rim_vertex *from, const struct rim_vertex *to,
                    double t, struct rim_spot *spot) {
    struct surface_jet jet;
    double duv[2];
    spot->face = from->face;
    for (int k = 0; k < 2; k++) {
        duv[k] = to->uv[k] - from->uv[k];
        spot->uv[k] = t == 1 ? to->uv[k] : from->uv[k] + t * duv[k];
    }
    if (!march->surface) {
        memcpy(spot->uv, from->uv, sizeof spot->uv);
        spot->dr = vec3_sub(to->r, from->r);
        spot->r = vec3_axpy(t, spot->dr, from->r);
        spot->normal = march->mesh->normals[from->face];
        return;
    }
    const struct surface *surface = rim_edges_surface(march, from->face);
    surface_jet_at(surface, &march->cursor, spot->uv[0], spot->uv[1], &jet);
    spot->r = jet.r;
    spot->dr = vec3_axpy(duv[1], jet.v, vec3_scale(duv[0], jet.u));
    spot->normal = vec3_scale(surface->side, vec3_cross(jet.u, jet.v));
    double nu = vec3_norm2(jet.u), nv = vec3_norm2(jet.v), area = vec3_norm2(spot->normal);
    const double *least = surface->least_tangent2;
    if (!(nu > least[0] && nv > least[1] && area > parallel * parallel * nu * nv))
        spot->normal = vec3_make(0, 0, 0);
}

/* ---- loops ---- */

static void add_vertex(struct builder *b, const struct rim_vertex *vertex) {
    struct rim_edges *e = b->edges;
    if (e->vertex_count == e->vertex_room)
        e->vertices = arena_enlarge(b->march->arena, e->vertices, e->vertex_count,
                                    sizeof *e->vertices, &e->vertex_room);
    if (e->vertices)
        e->vertices[e->vertex_count++] = *vertex;
    b->failed = b->failed || !e->vertices;
}

static void add_place(struct builder *b, double u, double v) {
    struct surface_jet jet;
    surface_jet_at(b->march->surface, &b->march->cursor, u, v, &jet);
    add_vertex(b, &(struct rim_vertex){.uv = {u, v}, .r = jet.r});
}

static size_t next_loop(const struct rim_edges *e) {
    const struct rim_loop *last = e->loop_count ? &e->loops[e->loop_count - 1] : NULL;
    return last ? last->first + last->count + 1 : 0;
}

/* Ends the loop of the vertices added since the last one: where it began, by a vertex for that
 * unless `closed`. */
static void end_loop(struct builder *b, bool closed) {
    struct rim_edges *e = b->edges;
    size_t first = next_loop(e);
    if (b->failed)
        return;
    struct rim_vertex begin = e->vertices[first];
    begin.leaps = false;
    if (!closed)
        add_vertex(b, &begin);
    if (e->loop_count == e->loop_room)
        e->loops = arena_enlarge(b->march->arena, e->loops, e->loop_count, sizeof *e->loops,
                                 &e->loop_room);
    b->failed = b->failed || !e->loops;
    if (!b->failed)
        e->loops[e->loop_count++] = (struct rim_loop){first, e->vertex_count - first - 1};
}

/* ---- the border of the domain ---- */

static struct window find_window(const struct march *march) {
    struct window window;
    for (int k = 0; k < 2; k++) {
        const struct surface_axis *axis = &march->surface->axis[k];
        double turn = march->mesh ? HUGE_VAL : station_cut_turn(march->surface, k);
        bool cut = axis->closed && turn < HUGE_VAL && !march->past_cut;
        window.low[k] = surface_axis_lower(axis);
        window.length[k] = surface_axis_upper(axis) - window.low[k];
        if (cut)
            window.low[k] = march->start.station.uv[k] - turn;
        window.high[k] = window.low[k] + window.length[k];
        window.endless[k] = axis->closed && !cut;
    }
    return window;
}

/* Whether all of a side of the domain is one point. */
static bool is_pole(const struct builder *b, int k, int end) {
    const struct surface_axis *axis = &b->march->surface->axis[k];
    return !axis->closed && axis->pole[end];
}

/* A side of the domain round which the other direction closes. */
static void add_ring(struct builder *b, int k, int end) {
    const struct window *w = &b->window;
    bool forward = (k == 1) == (end == 0);
    for (int part = 0; part <= 4; part++) {
        double share = (forward ? part : 4 - part) / 4.0, uv[2];
        uv[k] = end ? w->high[k] : w->low[k];
        uv[1 - k] = w->low[1 - k] + share * w->length[1 - k];
        add_place(b, uv[0], uv[1]);
    }
    end_loop(b, true);
}

static void add_border(struct builder *b) {
    const struct window *w = &b->window;
    if (w->endless[0] && w->endless[1])
        return;
    for (int k = 0; k < 2; k++)
        for (int end = 0; end < 2 && w->endless[1 - k]; end++)
            if (!is_pole(b, k, end))
                add_ring(b, k, end);
    if (w->endless[0] || w->endless[1])
        return;
    add_place(b, w->low[0], w->low[1]);
    add_place(b, w->high[0], w->low[1]);
    add_place(b, w->high[0], w->high[1]);
    add_place(b, w->low[0], w->high[1]);
    end_loop(b, false);
}

/* ---- polylines ---- */

/* How far the place m is from the line a c, in space, and at which share of that it is nearest: r_u
 * and r_v at m measure it. */
static double deviation(const struct builder *b, const struct surface *surface, const double a[2],
                        const double c[2], const double m[2], double *share) {
    struct surface_jet jet;
    double chord[2] = {c[0] - a[0], c[1] - a[1]}, off[2] = {m[0] - a[0], m[1] - a[1]};
    surface_jet_at(surface, &b->march->cursor, m[0], m[1], &jet);
    struct vec3 along = vec3_axpy(chord[1], jet.v, vec3_scale(chord[0], jet.u));
    struct vec3 to = vec3_axpy(off[1], jet.v, vec3_scale(off[0], jet.u));
    double length2 = vec3_norm2(along), at = length2 > 0 ? vec3_dot(to, along) / length2 : 0;
    *share = at < 0 ? 0 : at > 1 ? 1 : at;
    return vec3_norm(vec3_axpy(-*share, along, to));
}

/* Marks the points that a polyline needs to stay within the tolerance: of the stretch between two
 * that are kept the one farthest off, as long as it is too far (Douglas and Peucker). */
static bool keep_points(struct builder *b, const struct surface *surface, const double (*uv)[2],
                        size_t count, uint8_t *kept) {
    size_t(*stack)[2] = arena_alloc(b->march->arena, count + 4, sizeof *stack);
    size_t depth = 0;
    if (!stack)
        return false;
    for (size_t part = 0; part < 4; part++) {
        size_t first = part * (count - 1) / 4, last = (part + 1) * (count - 1) / 4;
        kept[first] = kept[last] = 1;
        stack[depth][0] = first;
        stack[depth++][1] = last;
    }
    while (depth > 0) {
        size_t first = stack[--depth][0], last = stack[depth][1], at = first;
        double most = b->tolerance;
        for (size_t k = first + 1; k < last; k++) {
            double share, off = deviation(b, surface, uv[first], uv[last], uv[k], &share);
            at = off > most ? k : at;
            most = fmax(most, off);
        }
        if (at == first)
            continue;
        kept[at] = 1;
        stack[depth][0] = first;
        stack[depth++][1] = at;
        stack[depth][0] = at;
        stack[depth++][1] = last;
    }
    return true;
}

/* ---- shells ---- */

/* The free edges as chains: first both sides of the cut, part by part, number 2 k and 2 k + 1. */
struct free_edges {
    struct shell_edge *edges;
    struct vec3 (*ends)[2];
    bool *used;
    size_t count, of_cut;
};

static struct vec3 point_on_face(struct builder *b, int32_t face, const double uv[2]) {
    struct surface_jet jet;
    surface_jet_at(rim_edges_surface(b->march, face), &b->march->cursor, uv[0], uv[1], &jet);
    return jet.r;
}

static void set_ends(struct builder *b, struct free_edges *found, size_t k) {
    const struct shell_edge *edge = &found->edges[k];
    for (int end = 0; end < 2; end++)
        found->ends[k][end] = point_on_face(b, edge->face, edge->uv[end ? edge->count - 1 : 0]);
}

/* The place of an edge nearest to parameters m beside it: its piece and parameters; its distance.
 */
static double nearest_on_edge(struct builder *b, const struct shell_edge *edge, const double m[2],
                              size_t *piece, double uv[2]) {
    const struct surface *surface = rim_edges_surface(b->march, edge->face);
    double best = HUGE_VAL;
    for (size_t k = 0; k + 1 < edge->count; k++) {
        const double *from = edge->uv[k], *to = edge->uv[k + 1];
        double share, own = deviation(b, surface, from, to, m, &share);
        if (!(own < best))
            continue;
        best = own;
        *piece = k;
        for (int n = 0; n < 2; n++)
            uv[n] = from[n] + share * (to[n] - from[n]);
    }
    return best;
}

/* Divides the free edge on which the cut ends at `uv` of a face, which becomes a place of it. */
static void divide_edge(struct builder *b, struct free_edges *found, int32_t face, double uv[2]) {
    double least = HUGE_VAL, at[2] = {0, 0};
    size_t best = 0, best_piece = 0;
    for (size_t k = found->of_cut; k < found->count; k++) {
        double own_uv[2];
        size_t piece = 0;
        if (found->edges[k].face != face)
            continue;
        double own = nearest_on_edge(b, &found->edges[k], uv, &piece, own_uv);
        if (!(own < least))
            continue;
        least = own;
        best = k;
        best_piece = piece;
        memcpy(at, own_uv, sizeof at);
    }
    struct shell_edge *edge = &found->edges[best], *rest = &found->edges[found->count];
    double(*first)[2] = arena_alloc(b->march->arena, best_piece + 2, sizeof *first);
    b->failed = b->failed || !first;
    if (b->failed || !(least < HUGE_VAL))
        return;
    memcpy(first, edge->uv, (best_piece + 1) * sizeof *first);
    memcpy(first[best_piece + 1], at, sizeof at);
    memcpy(uv, at, sizeof at);
    *rest = (struct shell_edge){face, edge->uv + best_piece, edge->count - best_piece};
    memcpy(rest->uv[0], at, sizeof at);
    *edge = (struct shell_edge){face, first, best_piece + 2};
    set_ends(b, found, best);
    set_ends(b, found, found->count++);
}

/* Both sides of part `number` of the cut, whose ends at the boundary divide the edges there. */
static void add_cut_part(struct builder *b, struct free_edges *found, size_t number,
                         const struct shell_cut_part *part) {
    double(*uv)[2] = arena_alloc(b->march->arena, 2 * part->count, sizeof *uv);
    b->failed = b->failed || !uv;
    if (b->failed)
        return;
    memcpy(uv, part->uv, part->count * sizeof *uv);
    if (part->begins)
        divide_edge(b, found, part->face, uv[0]);
    if (part->ends)
        divide_edge(b, found, part->face, uv[part->count - 1]);
    for (size_t k = 0; k < part->count; k++)
        memcpy(uv[2 * part->count - 1 - k], uv[k], sizeof *uv);
    for (size_t side = 0; side < 2; side++) {
        found->edges[2 * number + side] =
            (struct shell_edge){part->face, uv + side * part->count, part->count};
        set_ends(b, found, 2 * number + side);
    }
}

static bool find_free_edges(struct builder *b, struct free_edges *found) {
    struct march *march = b->march;
    const struct shell *shell = march->surface->shell;
    int32_t component = shell_component(shell, march->surface->face);
    size_t parts = 0, count = shell_edge_count(shell);
    const struct shell_cut_part *part = march->cut ? shell_cut_parts(march->cut, &parts) : NULL;
    size_t room = count + 4 * parts;
    found->edges = arena_alloc(march->arena, room, sizeof *found->edges);
    found->ends = arena_alloc(march->arena, room, sizeof *found->ends);
    found->used = arena_alloc(march->arena, room, sizeof *found->used);
    if (!found->edges || !found->ends || !found->used)
        return false;
    found->count = found->of_cut = 2 * parts;
    for (size_t k = 0; k < count; k++) {
        struct shell_edge *edge = &found->edges[found->count];
        if (shell_edge(shell, k, component, march->arena, edge) != STATUS_OK)
            return false;
        if (edge->count > 0)
            set_ends(b, found, found->count++);
    }
    for (size_t k = 0; k < parts; k++)
        add_cut_part(b, found, k, &part[k]);
    return !b->failed;
}

/* Adds an edge's vertices, of which a polyline within the tolerance needs no more. */
static void add_edge(struct builder *b, const struct shell_edge *edge) {
    struct march *march = b->march;
    const struct surface *surface = shell_surface(march->surface->shell, edge->face);
    uint8_t *kept = arena_alloc(march->arena, edge->count, sizeof *kept);
    b->failed = b->failed || !kept ||
                !keep_points(b, surface, (const double(*)[2])edge->uv, edge->count, kept);
    for (size_t k = 0; k < edge->count && !b->failed; k++) {
        const double *uv = edge->uv[k];
        struct surface_jet jet;
        if (!kept[k])
            continue;
        surface_jet_at(surface, &march->cursor, uv[0], uv[1], &jet);
        add_vertex(b, &(struct rim_vertex){.face = edge->face,
                                           .uv = {uv[0], uv[1]},
                                           .r = jet.r,
                                           .leaps = k + 1 == edge->count});
    }
}

/* Whether two edges are the sides of the same part of the cut. */
static bool turns_back(const struct free_edges *found, size_t edge, size_t other) {
    return edge < found->of_cut && (edge ^ other) == 1;
}

/* Edge after edge, each that whose beginning is nearest to the end of the last, until it is the
 * loop's own. */
static void add_shell_edges(struct builder *b) {
    struct free_edges found = {.count = 0};
    b->failed = !find_free_edges(b, &found);
    for (size_t first = 0; first < found.count && !b->failed; first++) {
        size_t at = first;
        if (found.used[first])
            continue;
        while (!found.used[at] && !b->failed) {
            double best = turns_back(&found, at, first)
                              ? HUGE_VAL
                              : vec3_distance(found.ends[at][1], found.ends[first][0]);
            size_t next = first;
            found.used[at] = true;
            add_edge(b, &found.edges[at]);
            for (size_t k = 0; k < found.count; k++) {
                double gap = vec3_distance(found.ends[at][1], found.ends[k][0]);
                if (found.used[k] || turns_back(&found, at, k) || gap >= best)
                    continue;
                next = k;
                best = gap;
            }
            at = next;
        }
        end_loop(b, false);
    }
}

/* ---- trims: which of the edges count ---- */

/* Whether a place is to be covered; `inside` whether it is in the domain. */
static bool is_covered(const struct builder *b, const double uv[2], double slack, bool *inside) {
    const struct surface *surface = b->march->surface;
    double wrapped[2], outer[2];
    *inside = true;
    for (int k = 0; k < 2; k++) {
        const struct window *w = &b->window;
        bool beyond =
            uv[k] < w->low[k] - slack * w->length[k] || uv[k] > w->high[k] + slack * w->length[k];
        *inside = *inside && (w->endless[k] || !beyond);
        wrapped[k] = surface_axis_wrap(&surface->axis[k], uv[k]);
    }
    surface_outer(surface, wrapped, outer);
    return trim_contains(b->march->settings->trim, outer);
}

/* The place at t between two, and those beside it: 0 left, 1 right. */
static void beside_line(const struct builder *b, const double from[2], const double to[2], double t,
                        double at[2], double side[2][2]) {
    const double *length = b->window.length;
    double along[2], size = 0;
    for (int k = 0; k < 2; k++) {
        at[k] = from[k] + t * (to[k] - from[k]);
        along[k] = (to[k] - from[k]) / length[k];
        size += along[k] * along[k];
    }
    double scale = size > 0 ? beside / sqrt(size) : 0;
    const double left[2] = {-along[1] * scale * length[0], along[0] * scale * length[1]};
    for (int k = 0; k < 2; k++) {
        side[0][k] = at[k] + left[k];
        side[1][k] = at[k] - left[k];
    }
}

/* A trim's edge counts where it lies in the domain and has what is to be covered on one side. */
static enum cover trim_side(const struct builder *b, const double from[2], const double to[2],
                            double t) {
    double at[2], side[2][2];
    bool in_domain, ignored;
    beside_line(b, from, to, t, at, side);
    (void)is_covered(b, at, beside, &in_domain);
    bool left = is_covered(b, side[0], 0, &ignored), right = is_covered(b, side[1], 0, &ignored);
    return !in_domain || left == right ? COVER_NEITHER : left ? COVER_LEFT : COVER_RIGHT;
}

/* The domain's border counts where the trims would let the region go on beyond it. */
static enum cover border_side(const struct builder *b, const double from[2], const double to[2],
                              double t) {
    double at[2], side[2][2];
    bool ignored;
    beside_line(b, from, to, t, at, side);
    return is_covered(b, side[0], 0, &ignored) && is_covered(b, side[1], 0, &ignored)
               ? COVER_LEFT
               : COVER_NEITHER;
}

typedef enum cover side_finder(const struct builder *b, const double from[2], const double to[2],
                               double t);

/* ---- trims: chains of those that count ---- */

static void add_to_line(struct builder *b, const double uv[2]) {
    struct polyline *line = &b->line;
    if (line->count == line->room)
        line->uv =
            arena_enlarge(b->march->arena, line->uv, line->count, sizeof *line->uv, &line->room);
    if (line->uv)
        memcpy(line->uv[line->count++], uv, sizeof *line->uv);
    b->failed = b->failed || !line->uv;
}

static void add_chain(struct builder *b, size_t first, enum cover cover, bool closed) {
    struct polyline *line = &b->line;
    if (b->failed || line->count - first < 2)
        return;
    if (b->chain_count == b->chain_room)
        b->chains = arena_enlarge(b->march->arena, b->chains, b->chain_count, sizeof *b->chains,
                                  &b->chain_room);
    b->failed = !b->chains;
    if (b->failed)
        return;
    for (size_t k = first, l = line->count - 1; cover == COVER_RIGHT && k < l; k++, l--)
        for (int m = 0; m < 2; m++) {
            double swap = line->uv[k][m];
            line->uv[k][m] = line->uv[l][m];
            line->uv[l][m] = swap;
        }
    b->chains[b->chain_count++] = (struct chain){first, line->count - first, closed, false};
}

/* A run of pieces that count, while one follows a polyline. */
struct run {
    size_t first; /* of the line */
    enum cover cover;
    bool gaps; /* pieces before or in between do not count */
};

static void switch_run(struct builder *b, struct run *run, enum cover cover, const double at[2]) {
    run->gaps = run->gaps || cover == COVER_NEITHER;
    if (cover == run->cover)
        return;
    run->gaps = run->gaps || run->cover != COVER_NEITHER;
    if (run->cover != COVER_NEITHER) {
        add_to_line(b, at);
        add_chain(b, run->first, run->cover, false);
    }
    run->cover = cover;
    run->first = b->line.count;
    if (cover != COVER_NEITHER)
        add_to_line(b, at);
}

/* Follows one piece: where its ends are of different kinds, the place between them is sought. */
static void follow_piece(struct builder *b, struct run *run, side_finder *side,
                         const double from[2], const double to[2]) {
    static const double inset = 1e-3;
    double low = inset, high = 1 - inset, at[2];
    enum cover begin = side(b, from, to, low), end = side(b, from, to, high);
    switch_run(b, run, begin, from);
    for (int k = 0; begin != end && k < HALVINGS; k++) {
        double middle = (low + high) / 2;
        *(side(b, from, to, middle) == begin ? &low : &high) = middle;
    }
    for (int k = 0; k < 2; k++)
        at[k] = from[k] + high * (to[k] - from[k]);
    switch_run(b, run, end, at);
    if (run->cover != COVER_NEITHER)
        add_to_line(b, to);
}

/* The chains of a closed polyline whose pieces count; its last point is its first. Where a run
 * passes its ends the two parts are joined later, unless all of it is one. */
static void follow(struct builder *b, side_finder *side, const double (*uv)[2], size_t count) {
    struct run run = {b->line.count, COVER_NEITHER, false};
    for (size_t k = 0; k + 1 < count; k++) {
        double step[2] = {fabs(uv[k + 1][0] - uv[k][0]), fabs(uv[k + 1][1] - uv[k][1])};
        bool jumps = step[0] > b->window.length[0] / 2 || step[1] > b->window.length[1] / 2;
        bool whole = b->window.endless[0] || b->window.endless[1];
        if (step[0] == 0 && step[1] == 0)
            continue;
        if (jumps && whole)
            switch_run(b, &run, COVER_NEITHER, uv[k]);
        else
            follow_piece(b, &run, side, uv[k], uv[k + 1]);
    }
    if (run.cover == COVER_NEITHER)
        return;
    bool closed = !run.gaps && memcmp(uv[0], uv[count - 1], sizeof uv[0]) == 0;
    if (closed)
        b->line.count--;
    add_chain(b, run.first, run.cover, closed);
}

/* A side of the window, in short pieces, so that no trim is missed. */
static void follow_side(struct builder *b, const double from[2], const double to[2]) {
    double uv[SIDE_PIECES + 1][2];
    for (int k = 0; k <= SIDE_PIECES; k++)
        for (int m = 0; m < 2; m++)
            uv[k][m] =
                k == SIDE_PIECES ? to[m] : from[m] + (to[m] - from[m]) * ((double)k / SIDE_PIECES);
    follow(b, border_side, (const double(*)[2])uv, SIDE_PIECES + 1);
}

static void follow_border(struct builder *b) {
    const struct window *w = &b->window;
    const double corner[5][2] = {{w->low[0], w->low[1]},
                                 {w->high[0], w->low[1]},
                                 {w->high[0], w->high[1]},
                                 {w->low[0], w->high[1]},
                                 {w->low[0], w->low[1]}};
    for (int k = 0; k < 4; k++) {
        int axis = k % 2 ? 0 : 1, end = k == 1 || k == 2;
        if (!w->endless[axis] && !is_pole(b, axis, end))
            follow_side(b, corner[k], corner[k + 1]);
    }
}

/* ---- trims: their polylines ---- */

/* A point of a loop in inner parameters, in the window. */
static void to_window(const struct builder *b, const double outer[2], double inner[2]) {
    const struct surface *surface = b->march->surface;
    surface_inner(surface, outer, inner);
    for (int k = 0; k < 2; k++)
        while (surface->axis[k].closed && !b->window.endless[k] && inner[k] < b->window.low[k])
            inner[k] += b->window.length[k];
}

/* Adds the points of the loop in inner parameters to `line`, between two that are not straight
 * there more of them, and split where the window's cut lies between. */
static void gather_loop(struct builder *b, const double (*outer)[2], size_t count,
                        struct polyline *line) {
    const struct surface_axis *axis = b->march->surface->axis;
    bool bent = axis[0].factor != 1 || axis[1].factor != 1;
    int parts = bent ? SUBDIVISIONS : 1;
    line->count = 0;
    line->room = count * (size_t)parts + 1;
    line->uv = arena_alloc(b->march->arena, line->room, sizeof *line->uv);
    b->failed = b->failed || !line->uv;
    for (size_t k = 0; !b->failed && k < count; k++)
        for (int part = k ? 1 : parts; part <= parts; part++) {
            double share = (double)part / parts, at[2];
            const double *from = outer[k ? k - 1 : 0], *to = outer[k];
            for (int m = 0; m < 2; m++)
                at[m] = part == parts ? to[m] : from[m] + share * (to[m] - from[m]);
            to_window(b, at, line->uv[line->count++]);
        }
}

static bool jumps(const struct builder *b, const double from[2], const double to[2]) {
    return fabs(to[0] - from[0]) > b->window.length[0] / 2 ||
           fabs(to[1] - from[1]) > b->window.length[1] / 2;
}

/* The loop's stretches between the cuts of the window. One that crosses the cut ends there. */
static void follow_stretches(struct builder *b, const double (*uv)[2], size_t count) {
    const struct window *w = &b->window;
    bool cut = (b->march->surface->axis[0].closed && !w->endless[0]) ||
               (b->march->surface->axis[1].closed && !w->endless[1]);
    size_t first = 0;
    for (size_t k = 0; cut && k + 1 < count; k++)
        if (jumps(b, uv[k], uv[k + 1])) {
            follow(b, trim_side, uv + first, k + 1 - first);
            first = k + 1;
        }
    follow(b, trim_side, uv + first, count - first);
}

static void follow_loop(struct builder *b, size_t loop) {
    const double(*outer)[2];
    struct polyline all;
    size_t count = trim_loop_points(b->march->settings->trim, loop, &outer), used = 0;
    if (count < 3)
        return;
    gather_loop(b, outer, count, &all);
    uint8_t *kept = arena_alloc(b->march->arena, all.count, sizeof *kept);
    b->failed = b->failed || !kept ||
                !keep_points(b, b->march->surface, (const double(*)[2])all.uv, all.count, kept);
    for (size_t k = 0; !b->failed && k < all.count; k++)
        if (kept[k])
            memcpy(all.uv[used++], all.uv[k], sizeof *all.uv);
    if (!b->failed)
        follow_stretches(b, (const double(*)[2])all.uv, used);
}

/* ---- trims: chains joined to loops ---- */

/* How far apart two places are: in parameters, as shares of the domain, round endless directions
 * too. */
static double apart(const struct builder *b, const double p[2], const double q[2]) {
    double most = 0;
    for (int k = 0; k < 2; k++) {
        double gap = fabs(p[k] - q[k]) / b->window.length[k];
        if (b->window.endless[k])
            gap = fmin(gap, fabs(1 - gap));
        most = fmax(most, gap);
    }
    return most;
}

/* The chain, not yet used, whose beginning is nearest to the place. */
static struct chain *next_chain(struct builder *b, const double at[2], double *gap) {
    struct chain *best = NULL;
    *gap = HUGE_VAL;
    for (size_t k = 0; k < b->chain_count; k++) {
        struct chain *chain = &b->chains[k];
        double own =
            chain->used || chain->closed ? HUGE_VAL : apart(b, at, b->line.uv[chain->first]);
        best = own < *gap ? chain : best;
        *gap = fmin(*gap, own);
    }
    return best;
}

static void add_vertices(struct builder *b, const struct chain *chain) {
    for (size_t k = 0; k < chain->count; k++) {
        const double *uv = b->line.uv[chain->first + k];
        add_place(b, uv[0], uv[1]);
    }
}

/* Chain after chain, until the nearest beginning is the loop's own. */
static void join_chains(struct builder *b) {
    for (size_t k = 0; k < b->chain_count && !b->failed; k++) {
        struct chain *chain = &b->chains[k];
        const double *begin = b->line.uv[chain->first];
        if (chain->used)
            continue;
        for (;;) {
            const double *end = b->line.uv[chain->first + chain->count - 1];
            double gap;
            chain->used = true;
            add_vertices(b, chain);
            if (!b->failed && !chain->closed)
                b->edges->vertices[b->edges->vertex_count - 1].leaps = true;
            struct chain *next = chain->closed ? NULL : next_chain(b, end, &gap);
            if (!next || (apart(b, end, begin) <= gap && gap > joint) ||
                apart(b, end, begin) <= joint)
                break;
            chain = next;
        }
        end_loop(b, false);
    }
}

/* ---- meshes ---- */

static void add_mesh_borders(struct builder *b) {
    const struct mesh *mesh = b->march->mesh;
    int32_t halves = (int32_t)(3 * mesh->triangle_count);
    int32_t own = mesh->component[march_mesh_place(&b->march->start.station).triangle];
    uint8_t *seen = arena_alloc(b->march->arena, (size_t)halves, sizeof *seen);
    b->failed = !seen;
    for (int32_t first = 0; !b->failed && first < halves; first++) {
        if (mesh->twins[first] != MESH_NONE || seen[first] || mesh->component[first / 3] != own)
            continue;
        for (int32_t half = first; !seen[half]; half = mesh_next_on_border(mesh, half)) {
            struct mesh_place place = {half / 3, mesh_corner_point(mesh, half / 3, half % 3)};
            struct rim_vertex vertex = {.face = half / 3, .r = place.r};
            seen[half] = 1;
            mesh_parameters(mesh, &place, vertex.uv);
            add_vertex(b, &vertex);
        }
        end_loop(b, false);
    }
}

enum status rim_edges_make(struct march *march, double tolerance, struct rim_edges *edges) {
    struct builder b = {.march = march, .edges = edges, .tolerance = tolerance};
    const struct trim *trim = march->settings->trim;
    *edges = (struct rim_edges){0};
    if (!march->surface) {
        add_mesh_borders(&b);
        return b.failed ? STATUS_OUT_OF_MEMORY : STATUS_OK;
    }
    if (march->surface->shell) {
        add_shell_edges(&b);
        return b.failed ? STATUS_OUT_OF_MEMORY : STATUS_OK;
    }
    b.window = find_window(march);
    if (!trim) {
        add_border(&b);
        return b.failed ? STATUS_OUT_OF_MEMORY : STATUS_OK;
    }
    follow_border(&b);
    for (size_t k = 0; k < trim_loop_count(trim) && !b.failed; k++)
        follow_loop(&b, k);
    join_chains(&b);
    return b.failed ? STATUS_OUT_OF_MEMORY : STATUS_OK;
}
