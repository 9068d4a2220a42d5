/* SPDX-License-Identifier: MIT */
#include "joints.h"

#include <stdlib.h>

/* A curve has a corner where its direction turns by more than the arc sine of this. */
static const double corner_sine = 0.01;

/* What reaches no further than this share of the tolerance is one point, and an edge of its own. */
static const double one_point = 1e-3;

/* How far to the sides of an edge its face is looked for, as shares of the domain; flattening moves
 * edges by a quarter of the first. */
static const double beside[] = {4e-6, 2e-5, 1e-4, 1e-3};

enum status join_make_boxes(struct join *join, double margin) {
    const struct shell *shell = join->shell;
    struct box *boxes = arena_take(join->pool[1], join->point_count, sizeof *boxes);
    join->curve_of = arena_take(join->scratch, join->point_count, sizeof *join->curve_of);
    if (!boxes || !join->curve_of)
        return STATUS_OUT_OF_MEMORY;
    for (size_t c = 0; c < shell->curve_count; c++) {
        const struct face_curve *curve = &shell->curves[c];
        for (uint32_t k = 0; k < curve->count; k++) {
            uint32_t at = curve->first + k, next = at + (k + 1 < curve->count);
            struct vec3 a = join->points[at].r, b = join->points[next].r;
            join->curve_of[at] = (int32_t)c;
            boxes[at] = box_round(a, b, margin + join_sagitta * vec3_distance(a, b));
        }
    }
    enum status status = boxes_make(boxes, join->point_count, join->scratch, &join->boxes);
    arena_rewind(join->pool[1], (struct arena_mark){0});
    return status;
}

double join_nearest(const struct join *join, uint32_t at, struct vec3 point, const double range[2],
                    struct curve_place *place) {
    const struct join_point *p = &join->points[at];
    const struct face_curve *curve = &join->shell->curves[join->curve_of[at]];
    struct vec3 way = {0, 0, 0};
    double share = 0, length = 0;
    if (at + 1 < curve->first + curve->count) {
        way = vec3_sub(p[1].r, p[0].r);
        length = p[1].t - p[0].t;
    }
    if (vec3_norm2(way) > 0)
        share = fmin(fmax(vec3_dot(vec3_sub(point, p->r), way) / vec3_norm2(way), 0), 1);
    return curve_nearest(join->shell, curve, point, p->t + share * length, range, place);
}

static void add_join_cut(struct join *join, int32_t curve, double t, struct vec3 r) {
    if (join->failed)
        return;
    if (join->cut_count == join->cut_room)
        join->cuts = arena_enlarge(join->scratch, join->cuts, join->cut_count, sizeof *join->cuts,
                                   &join->cut_room);
    join->failed = join->failed || !join->cuts;
    if (join->failed)
        return;
    join->cuts[join->cut_count] = (struct join_cut){curve, t, r, join->last_cut[curve]};
    join->last_cut[curve] = (int32_t)join->cut_count++;
}

struct vertex {
    struct join *join;
    struct vec3 r;
    bool once; /* it cuts no curve that is cut there */
};

/* Cuts the curve of a step where it passes the vertex, unless that is at its own end or corner: cut
 * beside a corner, an edge would begin on the other side of it. */
static bool cut_at_vertex(void *context, int32_t step) {
    const struct vertex *vertex = context;
    struct join *join = vertex->join;
    int32_t number = join->curve_of[step];
    const struct face_curve *curve = &join->shell->curves[number];
    const struct join_point *ends = join->points + curve->first;
    double tolerance = join->shell->tolerance;
    struct curve_place place;
    if (vec3_distance(ends[0].r, vertex->r) <= tolerance ||
        vec3_distance(ends[curve->count - 1].r, vertex->r) <= tolerance)
        return true;
    if (!(join_nearest(join, (uint32_t)step, vertex->r, curve->range, &place) <= tolerance))
        return true;
    bool cut = false; /* it is cut there already */
    for (int32_t k = join->last_cut[number]; k >= 0; k = join->cuts[k].before)
        cut = cut || ((vertex->once || (size_t)k < join->corner_count) &&
                      vec3_distance(join->cuts[k].r, place.r) <= tolerance);
    if (!cut)
        add_join_cut(join, number, place.t, place.r);
    return !join->failed;
}

static void cut_at(struct join *join, struct vec3 r, bool once) {
    struct vertex vertex = {join, r, once};
    struct box box = box_round(r, r, join->shell->tolerance);
    boxes_visit(join->boxes, &box, cut_at_vertex, &vertex);
}

/* Whether the curve turns at its point number k, counted in all points, or comes to a pole. */
static bool is_corner(const struct join *join, size_t k) {
    struct vec3 a = vec3_sub(join->points[k].r, join->points[k - 1].r);
    struct vec3 b = vec3_sub(join->points[k + 1].r, join->points[k].r);
    if (fmin(vec3_norm(a), vec3_norm(b)) <= one_point * join->shell->tolerance)
        return true;
    a = vec3_unit(a);
    b = vec3_unit(b);
    if (vec3_dot(a, b) > 0 && vec3_norm(vec3_cross(a, b)) < corner_sine)
        return false;
    const struct face_curve *curve = &join->shell->curves[join->curve_of[k]];
    double t = join->points[k].t, step = 1e-7 * (curve->range[1] - curve->range[0]);
    struct curve_place before, after;
    curve_at(join->shell, curve, t - step, &before);
    curve_at(join->shell, curve, t + step, &after);
    a = vec3_unit(before.tangent);
    b = vec3_unit(after.tangent);
    return !(vec3_dot(a, b) > 0 && vec3_norm(vec3_cross(a, b)) < corner_sine);
}

void join_cut_curves(struct join *join) {
    const struct shell *shell = join->shell;
    join->last_cut = arena_take(join->scratch, shell->curve_count, sizeof *join->last_cut);
    join->failed = join->failed || !join->last_cut;
    for (size_t c = 0; c < shell->curve_count && !join->failed; c++)
        join->last_cut[c] = -1;
    for (size_t c = 0; c < shell->curve_count && !join->failed; c++) {
        const struct face_curve *curve = &shell->curves[c];
        const struct join_point *points = join->points + curve->first;
        for (uint32_t k = 1; k + 1 < curve->count; k++)
            if (is_corner(join, curve->first + k))
                add_join_cut(join, (int32_t)c, points[k].t, points[k].r);
    }
    join->corner_count = join->cut_count;
    for (size_t k = 0; k < join->corner_count && !join->failed; k++)
        cut_at(join, join->cuts[k].r, false);
    for (size_t c = 0; c < shell->curve_count && !join->failed; c++) {
        const struct face_curve *curve = &shell->curves[c];
        cut_at(join, join->points[curve->first].r, false);
        cut_at(join, join->points[curve->first + curve->count - 1].r, false);
    }
    /* Slivers may be between a curve and the one that is cut. */
    size_t count = join->cut_count;
    for (size_t k = 0; k < join->cut_count && !join->failed; k++)
        cut_at(join, join->cuts[k].r, k >= count);
}

static int compare_join_cuts(const void *a, const void *b) {
    const struct join_cut *p = a, *q = b;
    if (p->curve != q->curve)
        return p->curve < q->curve ? -1 : 1;
    return (p->t > q->t) - (p->t < q->t);
}

static bool free_of(const struct face *face, const double uv[2], const double step[2]) {
    const double at[2] = {uv[0] + step[0], uv[1] + step[1]};
    return !face_contains(face, at);
}

/* Where on its way an edge is looked at. */
static const double looked_at = 0.38;

/* On which side of an edge its face lies; 0 on both or neither. */
static int8_t side_with_face(const struct shell *shell, const struct face_edge *edge) {
    const struct face *face = &shell->faces[shell->curves[edge->curve].face];
    struct curve_place place;
    double length[2], rate[2];
    edge_at_share(shell, edge, looked_at, &place);
    for (int k = 0; k < 2; k++) {
        const struct surface_axis *axis = &face->surface.axis[k];
        length[k] = surface_axis_length(axis);
        rate[k] = place.rate[k] / length[k];
    }
    double speed = sqrt(rate[0] * rate[0] + rate[1] * rate[1]);
    for (size_t k = 0; k < sizeof beside / sizeof *beside; k++) {
        double left[2] = {-beside[k] * length[0] * rate[1] / speed,
                          beside[k] * length[1] * rate[0] / speed};
        const double right[2] = {-left[0], -left[1]};
        bool out_left = free_of(face, place.uv, left), out_right = free_of(face, place.uv, right);
        if (out_left != out_right)
            return out_left ? -1 : 1;
    }
    return 0;
}

bool join_is_sliver(const struct shell *shell, const struct face_edge *edge, double share,
                    double width) {
    const struct face_curve *curve = &shell->curves[edge->curve];
    struct curve_place place;
    edge_at_share(shell, edge, share, &place);
    struct vec3 u = place.jet.u, v = place.jet.v, normal = vec3_cross(u, v);
    struct vec3 inward = vec3_unit(vec3_scale(edge->inside, vec3_cross(normal, place.tangent)));
    double step = width / vec3_norm2(normal);
    const double across[2] = {step * vec3_dot(vec3_cross(inward, v), normal),
                              step * vec3_dot(vec3_cross(u, inward), normal)};
    return free_of(&shell->faces[curve->face], place.uv, across);
}

/* How far a curve goes from one of two cuts on its way to the other, at a few places, or the first
 * distance beyond the tolerance: a piece that ends where it begins may go round a face in between,
 * or be a pole. */
static double reach_between(const struct shell *shell, const struct join_cut *from,
                            const struct join_cut *to) {
    double reach = vec3_distance(from->r, to->r);
    for (int k = 1; k <= JOIN_SAMPLES && reach <= shell->tolerance; k++) {
        struct curve_place place;
        curve_at(shell, &shell->curves[from->curve],
                 from->t + (to->t - from->t) * k / (JOIN_SAMPLES + 1), &place);
        reach = fmax(reach, vec3_distance(place.r, from->r) / 2);
    }
    return reach;
}

static void add_face_edge(struct shell *shell, int32_t number, const struct join_cut *from,
                          const struct join_cut *to) {
    struct face_edge *edge = &shell->edges[shell->edge_count];
    *edge = (struct face_edge){
        .curve = number, .t = {from->t, to->t}, .mate = EDGE_FREE, .end = {from->r, to->r}};
    edge->bare = edge_is_point(shell, edge, 2 * shell->tolerance);
    edge->inside = edge->bare ? 0 : side_with_face(shell, edge);
    edge->bare = edge->bare || edge->inside == 0;
    shell->edge_count++;
}

enum status join_make_edges(struct join *join) {
    struct shell *shell = join->shell;
    if (join->cut_count)
        qsort(join->cuts, join->cut_count, sizeof *join->cuts, compare_join_cuts);
    shell->edges =
        arena_alloc(join->arena, shell->curve_count + join->cut_count, sizeof *shell->edges);
    if (!shell->edges)
        return STATUS_OUT_OF_MEMORY;
    size_t at = 0;
    for (size_t c = 0; c < shell->curve_count; c++) {
        const struct face_curve *curve = &shell->curves[c];
        const struct join_point *points = join->points + curve->first;
        const struct join_point *last = &points[curve->count - 1];
        const struct join_cut end = {(int32_t)c, last->t, last->r, -1};
        struct join_cut from = {(int32_t)c, points->t, points->r, -1}, to = end;
        for (; at < join->cut_count && join->cuts[at].curve == (int32_t)c; at++) {
            const struct join_cut *cut = &join->cuts[at];
            if (cut->t >= to.t)
                continue;
            double before = reach_between(shell, &from, cut),
                   after = reach_between(shell, cut, &to);
            bool is_edge = before > shell->tolerance && after > shell->tolerance;
            bool is_pole = before <= one_point * shell->tolerance;
            if (is_edge || is_pole) {
                add_face_edge(shell, (int32_t)c, &from, cut);
                from = *cut;
            }
            to = after <= one_point * shell->tolerance ? *cut : to;
        }
        if (from.t < to.t)
            add_face_edge(shell, (int32_t)c, &from, &to);
        if (to.t < end.t)
            add_face_edge(shell, (int32_t)c, &to, &end);
    }
    return STATUS_OK;
}
