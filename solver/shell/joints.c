/* SPDX-License-Identifier: MIT */
/*
 * The edges of a shell's faces and what joins them. Curves are sampled, and cut at the ends of all
 * curves that come within the tolerance of them, and at their own corners. Two edges are joined
 * when their ends coincide and each passes all samples of the other, within the tolerance.
 */
#include "faces.h"

#include <stdlib.h>
#include <string.h>

enum { HALVINGS = 12, FIRST_PIECES = 4, SAMPLES = 3, MATES_MAX = 8 };

/* Segments leave their curve by less than this share of the domain, and by less than that share of
 * their own length in space. */
static const double flatness = 1e-6, sagitta = 0.02;

/* A curve has a corner where its direction turns by more than the arc sine of this. */
static const double corner_sine = 0.01;

/* How far to the sides of an edge its face is looked for, as shares of the domain; flattening moves
 * edges by a quarter of the first. */
static const double beside[] = {4e-6, 2e-5, 1e-4, 1e-3};

/* Two faces at an edge are folded on each other when the cosine of their angle is more. */
static const double turned_back = 0.9994;

struct point {
    double t, uv[2];
    struct vec3 r;
};

/* Everything while it is gathered. */
struct join {
    struct shell *shell;
    struct arena *arena, *scratch; /* scratch: what only the joining needs, more than what stays */
    struct arena *pool[2]; /* of the points, and of those they are copied to when they grow */
    struct point *points;
    size_t point_count, point_room;
    size_t curve_room;
    struct cut *cuts; /* of curves, in no order until they are sorted */
    size_t cut_count, cut_room;
    struct boxes *boxes;         /* round the steps from point to point */
    int32_t *curve_of, *edge_of; /* of points; of the steps that follow them */
    bool failed;                 /* no memory */
};

struct cut {
    int32_t curve;
    double t;
    struct vec3 r;
};

/* Room for one more element; false, and `failed` set, without memory. */
static bool make_room(struct join *join, struct arena *arena, void **array, size_t count,
                      size_t *room, size_t size) {
    if (count < *room)
        return true;
    size_t wanted = *room ? 2 * *room : 256;
    void *to = arena_alloc(arena, wanted, size);
    join->failed = join->failed || !to;
    if (!to)
        return false;
    if (count)
        memcpy(to, *array, count * size);
    *array = to;
    *room = wanted;
    return true;
}

static void add_point(struct join *join, const struct point *point) {
    void *points = join->points;
    if (!make_room(join, join->pool[1], &points, join->point_count, &join->point_room,
                   sizeof *join->points))
        return;
    if (points != join->points) {
        struct arena *left = join->pool[0];
        arena_rewind(left, (struct arena_mark){0});
        join->pool[0] = join->pool[1];
        join->pool[1] = left;
    }
    join->points = points;
    join->points[join->point_count++] = *point;
}

static void add_cut(struct join *join, int32_t curve, double t, struct vec3 r) {
    void *cuts = join->cuts;
    if (make_room(join, join->scratch, &cuts, join->cut_count, &join->cut_room,
                  sizeof *join->cuts)) {
        join->cuts = cuts;
        join->cuts[join->cut_count++] = (struct cut){curve, t, r};
    }
}

static struct face_curve *add_curve(struct join *join, int32_t face) {
    struct shell *shell = join->shell;
    void *curves = shell->curves;
    if (!make_room(join, join->arena, &curves, shell->curve_count, &join->curve_room,
                   sizeof *shell->curves))
        return NULL;
    shell->curves = curves;
    struct face_curve *curve = &shell->curves[shell->curve_count++];
    *curve = (struct face_curve){.face = face, .range = {0, 1}};
    return curve;
}

static void add_line(struct join *join, int32_t face, const double from[2], const double to[2]) {
    struct face_curve *curve = add_curve(join, face);
    if (!curve)
        return;
    memcpy(curve->line[0], from, sizeof curve->line[0]);
    memcpy(curve->line[1], to, sizeof curve->line[1]);
}

/* ---- curves ---- */

static void add_domain(struct join *join, int32_t face) {
    static const int8_t corner[5][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}, {0, 0}};
    const struct surface *surface = &join->shell->faces[face].surface;
    for (int side = 0; side < 4; side++) {
        double end[2][2];
        if (surface->axis[1 - side % 2].closed)
            continue;
        for (int e = 0; e < 2; e++)
            for (int k = 0; k < 2; k++) {
                const struct surface_axis *axis = &surface->axis[k];
                end[e][k] =
                    corner[side + e][k] ? surface_axis_upper(axis) : surface_axis_lower(axis);
            }
        add_line(join, face, end[0], end[1]);
    }
}

/* Whether two places are one, as far as curves are meant to meet. */
static bool meets(const struct surface *surface, const double a[2], const double b[2]) {
    bool same = true;
    for (int k = 0; k < 2; k++) {
        const double *outer = surface->axis[k].outer;
        same = same && fabs(a[k] - b[k]) <= flatness * (outer[1] - outer[0]);
    }
    return same;
}

static void close_loop(struct join *join, int32_t face, const double from[2], const double to[2]) {
    double line[2][2];
    surface_inner(&join->shell->faces[face].surface, from, line[0]);
    surface_inner(&join->shell->faces[face].surface, to, line[1]);
    add_line(join, face, line[0], line[1]);
}

static void add_loop(struct join *join, int32_t face, const struct trim_loop *loop) {
    const struct surface *surface = &join->shell->faces[face].surface;
    double first[2] = {0, 0}, last[2] = {0, 0};
    for (size_t k = 0; k <= loop->count; k++) {
        double range[2], begin[2];
        const struct trim_curve *trim = k < loop->count ? &loop->curves[k] : NULL;
        if (trim) {
            trim_curve_range(trim, range);
            trim_curve_at(trim, range[0], begin, NULL);
        } else {
            memcpy(begin, first, sizeof begin);
        }
        if (k == 0)
            memcpy(first, begin, sizeof first);
        else if (!meets(surface, last, begin))
            close_loop(join, face, last, begin);
        struct face_curve *curve = trim ? add_curve(join, face) : NULL;
        if (!curve)
            continue;
        curve->trim = trim;
        memcpy(curve->range, range, sizeof range);
        trim_curve_at(trim, range[1], last, NULL);
    }
}

static void add_curves(struct join *join, const struct shell_part *parts) {
    for (size_t k = 0; k < join->shell->face_count; k++) {
        bool keeps = false;
        for (size_t loop = 0; loop < parts[k].loop_count; loop++) {
            add_loop(join, (int32_t)k, &parts[k].loops[loop]);
            keeps = keeps || parts[k].loops[loop].reversed;
        }
        if (!keeps)
            add_domain(join, (int32_t)k);
    }
}

/* ---- samples ---- */

static struct point sample(const struct shell *shell, const struct face_curve *curve, double t) {
    struct curve_place place;
    curve_at(shell, curve, t, &place);
    return (struct point){t, {place.uv[0], place.uv[1]}, place.r};
}

/* The square of the distance of x from the straight line between a and b. */
static double off_line2(struct vec3 a, struct vec3 b, struct vec3 x) {
    struct vec3 way = vec3_sub(b, a), to = vec3_sub(x, a);
    double length2 = vec3_norm2(way);
    double share = length2 > 0 ? fmin(fmax(vec3_dot(to, way) / length2, 0), 1) : 0;
    return vec3_norm2(vec3_axpy(-share, way, to));
}

static bool is_flat(const struct shell *shell, const struct face_curve *curve,
                    const struct point *a, const struct point *b) {
    const struct surface_axis *axis = shell->faces[curve->face].surface.axis;
    double allowed = sagitta * vec3_distance(a->r, b->r) + shell->tolerance / 4, by[2];
    for (int k = 0; k < 2; k++)
        by[k] = 1 / (surface_axis_upper(&axis[k]) - surface_axis_lower(&axis[k]));
    struct vec3 from = {by[0] * a->uv[0], by[1] * a->uv[1], 0};
    struct vec3 to = {by[0] * b->uv[0], by[1] * b->uv[1], 0};
    for (int quarter = 1; quarter <= 3; quarter++) {
        struct point at = sample(shell, curve, a->t + quarter / 4.0 * (b->t - a->t));
        struct vec3 flat = {by[0] * at.uv[0], by[1] * at.uv[1], 0};
        if (off_line2(from, to, flat) > flatness * flatness ||
            off_line2(a->r, b->r, at.r) > allowed * allowed)
            return false;
    }
    return true;
}

/* The points after `a` up to `b`. */
static void sample_between(struct join *join, const struct face_curve *curve, struct point a,
                           struct point b) {
    struct point stack[HALVINGS + 1];
    int depth = 0;
    stack[0] = b;
    while (depth >= 0) {
        struct point end = stack[depth];
        if (depth == HALVINGS || is_flat(join->shell, curve, &a, &end)) {
            add_point(join, &end);
            a = end;
            depth--;
            continue;
        }
        stack[++depth] = sample(join->shell, curve, a.t + (end.t - a.t) / 2);
    }
}

/* Where a curve may have corners: the knots, or points of a polyline, after t; its end after the
 * last. */
static double next_break(const struct face_curve *curve, double t) {
    const struct trim_curve *trim = curve->trim;
    if (!trim)
        return curve->range[1];
    if (!trim->knots)
        return fmin(floor(t) + 1, curve->range[1]);
    for (size_t k = (size_t)trim->degree; k < trim->count; k++)
        if (trim->knots[k] > t)
            return trim->knots[k];
    return curve->range[1];
}

static void sample_curve(struct join *join, int32_t number) {
    struct face_curve *curve = &join->shell->curves[number];
    struct point at = sample(join->shell, curve, curve->range[0]);
    curve->first = (uint32_t)join->point_count;
    add_point(join, &at);
    while (at.t < curve->range[1] && !join->failed) {
        double from = at.t, to = next_break(curve, from);
        int pieces = curve->trim && !curve->trim->knots ? 1 : FIRST_PIECES;
        for (int k = 1; k <= pieces; k++) {
            double t = k == pieces ? to : from + (to - from) * k / pieces;
            struct point next = sample(join->shell, curve, t);
            sample_between(join, curve, at, next);
            at = next;
        }
    }
    curve->count = (uint32_t)join->point_count - curve->first;
}

/* ---- cuts ---- */

/* Boxes round the steps between points, within which the curve lies, and `margin` more. */
static enum status make_boxes(struct join *join, double margin) {
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
            boxes[at] = box_round(a, b, margin + sagitta * vec3_distance(a, b));
        }
    }
    enum status status = boxes_make(boxes, join->point_count, join->scratch, &join->boxes);
    arena_rewind(join->pool[1], (struct arena_mark){0});
    return status;
}

/* The place of a curve nearest to `point`, sought from the step at `at`. */
static double nearest_to_step(const struct join *join, uint32_t at, struct vec3 point,
                              const double range[2], struct curve_place *place) {
    const struct point *p = &join->points[at];
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

struct vertex {
    struct join *join;
    struct vec3 r;
};

/* Cuts the curve of a step where it passes the vertex, unless that is at its own end. */
static bool cut_at_vertex(void *context, int32_t step) {
    const struct vertex *vertex = context;
    struct join *join = vertex->join;
    int32_t number = join->curve_of[step];
    const struct face_curve *curve = &join->shell->curves[number];
    const struct point *ends = join->points + curve->first;
    double tolerance = join->shell->tolerance;
    struct curve_place place;
    if (vec3_distance(ends[0].r, vertex->r) <= tolerance ||
        vec3_distance(ends[curve->count - 1].r, vertex->r) <= tolerance)
        return true;
    if (nearest_to_step(join, (uint32_t)step, vertex->r, curve->range, &place) <= tolerance)
        add_cut(join, number, place.t, place.r);
    return !join->failed;
}

static void cut_at(struct join *join, struct vec3 r) {
    struct vertex vertex = {join, r};
    struct box box = box_round(r, r, join->shell->tolerance);
    boxes_visit(join->boxes, &box, cut_at_vertex, &vertex);
}

/* Whether the curve turns at its point number k, counted in all points. */
static bool is_corner(const struct join *join, size_t k) {
    struct vec3 a = vec3_unit(vec3_sub(join->points[k].r, join->points[k - 1].r));
    struct vec3 b = vec3_unit(vec3_sub(join->points[k + 1].r, join->points[k].r));
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

static void cut_curves(struct join *join) {
    const struct shell *shell = join->shell;
    for (size_t c = 0; c < shell->curve_count && !join->failed; c++) {
        const struct face_curve *curve = &shell->curves[c];
        const struct point *points = join->points + curve->first;
        for (uint32_t k = 1; k + 1 < curve->count; k++)
            if (is_corner(join, curve->first + k)) {
                add_cut(join, (int32_t)c, points[k].t, points[k].r);
                cut_at(join, points[k].r);
            }
        cut_at(join, points[0].r);
        cut_at(join, points[curve->count - 1].r);
    }
}

static int compare_cuts(const void *a, const void *b) {
    const struct cut *p = a, *q = b;
    if (p->curve != q->curve)
        return p->curve < q->curve ? -1 : 1;
    return (p->t > q->t) - (p->t < q->t);
}

/* ---- edges ---- */

static bool free_of(const struct face *face, const double uv[2], const double step[2]) {
    const double at[2] = {uv[0] + step[0], uv[1] + step[1]};
    return !face_contains(face, at);
}

/* On which side of an edge its face lies, looked at a third of its way; 0 on both or neither. */
static int8_t side_of(const struct shell *shell, const struct face_edge *edge) {
    const struct face_curve *curve = &shell->curves[edge->curve];
    const struct face *face = &shell->faces[curve->face];
    struct curve_place place;
    double length[2], rate[2];
    curve_at(shell, curve, edge->t[0] + 0.38 * (edge->t[1] - edge->t[0]), &place);
    for (int k = 0; k < 2; k++) {
        const struct surface_axis *axis = &face->surface.axis[k];
        length[k] = surface_axis_upper(axis) - surface_axis_lower(axis);
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

/* Whether all of an edge is one point within the tolerance. */
static bool is_point(const struct shell *shell, const struct face_edge *edge) {
    for (int k = 1; k <= SAMPLES; k++) {
        struct curve_place place;
        curve_at(shell, &shell->curves[edge->curve],
                 edge->t[0] + (edge->t[1] - edge->t[0]) * k / (SAMPLES + 1), &place);
        if (vec3_distance(place.r, edge->end[0]) > 2 * shell->tolerance)
            return false;
    }
    return vec3_distance(edge->end[1], edge->end[0]) <= 2 * shell->tolerance;
}

static void add_edge(struct shell *shell, int32_t number, const struct cut *from,
                     const struct cut *to) {
    struct face_edge *edge = &shell->edges[shell->edge_count];
    *edge = (struct face_edge){
        .curve = number, .t = {from->t, to->t}, .mate = EDGE_FREE, .end = {from->r, to->r}};
    edge->bare = is_point(shell, edge);
    edge->inside = edge->bare ? 0 : side_of(shell, edge);
    edge->bare = edge->bare || edge->inside == 0;
    shell->edge_count++;
}

/* The edges of all curves, between cuts further apart than the tolerance. */
static enum status make_edges(struct join *join) {
    struct shell *shell = join->shell;
    if (join->cut_count)
        qsort(join->cuts, join->cut_count, sizeof *join->cuts, compare_cuts);
    shell->edges =
        arena_alloc(join->arena, shell->curve_count + join->cut_count, sizeof *shell->edges);
    if (!shell->edges)
        return STATUS_OUT_OF_MEMORY;
    size_t at = 0;
    for (size_t c = 0; c < shell->curve_count; c++) {
        const struct face_curve *curve = &shell->curves[c];
        const struct point *points = join->points + curve->first;
        const struct point *last = &points[curve->count - 1];
        struct cut from = {(int32_t)c, points->t, points->r}, to = {(int32_t)c, last->t, last->r};
        for (; at < join->cut_count && join->cuts[at].curve == (int32_t)c; at++) {
            const struct cut *cut = &join->cuts[at];
            if (vec3_distance(cut->r, from.r) <= shell->tolerance ||
                vec3_distance(cut->r, to.r) <= shell->tolerance)
                continue;
            add_edge(shell, (int32_t)c, &from, cut);
            from = *cut;
        }
        add_edge(shell, (int32_t)c, &from, &to);
    }
    return STATUS_OK;
}

/* ---- mates ---- */

struct mates {
    struct join *join;
    const struct face_edge *edge;
    struct vec3 sample[SAMPLES];
    int32_t found[MATES_MAX];
    bool reversed[MATES_MAX];
    double gap[MATES_MAX];
    int count;
};

/* The edge of the curve of a step that t lies in. */
static int32_t edge_at(const struct join *join, int32_t curve, double t) {
    const struct shell *shell = join->shell;
    for (int32_t e = join->edge_of[curve]; e < join->edge_of[curve + 1]; e++)
        if (t >= shell->edges[e].t[0] && t <= shell->edges[e].t[1])
            return e;
    return EDGE_FREE;
}

/* Whether the two edges coincide; `gap` gets by how much they miss each other. */
static bool coincide(const struct mates *mates, const struct face_edge *other, double middle,
                     bool *reversed, double *gap) {
    const struct shell *shell = mates->join->shell;
    const struct face_edge *edge = mates->edge;
    double near[2], slack = 3 * shell->tolerance;
    struct curve_place place;
    *gap = 0;
    for (int k = 0; k < 2; k++)
        near[k] = fmax(vec3_distance(edge->end[0], other->end[k]),
                       vec3_distance(edge->end[1], other->end[1 - k]));
    if (!(fmin(near[0], near[1]) <= slack))
        return false;
    double from = middle;
    for (int k = 0; k < SAMPLES; k++) {
        double distance = curve_nearest(shell, &shell->curves[other->curve], mates->sample[k], from,
                                        other->t, &place);
        if (distance > shell->tolerance)
            for (int quarter = 0; quarter <= 4 && distance > shell->tolerance; quarter++)
                distance = curve_nearest(shell, &shell->curves[other->curve], mates->sample[k],
                                         other->t[0] + quarter * (other->t[1] - other->t[0]) / 4,
                                         other->t, &place);
        if (!(distance <= shell->tolerance * (1 + 1e-9)))
            return false;
        *gap = fmax(*gap, distance);
        if (k == 0)
            from = place.t;
    }
    *reversed = near[1] < near[0];
    if (fmax(near[0], near[1]) <= slack) /* closed: by the order of the samples */
        *reversed = place.t < from;
    return true;
}

static bool try_mate(void *context, int32_t step) {
    struct mates *mates = context;
    struct join *join = mates->join;
    const struct shell *shell = join->shell;
    int32_t number = join->curve_of[step];
    struct curve_place place;
    const struct face_curve *curve = &shell->curves[number];
    struct vec3 middle = mates->sample[SAMPLES / 2];
    if (!(nearest_to_step(join, (uint32_t)step, middle, curve->range, &place) <=
          shell->tolerance * (1 + 1e-9)))
        return true;
    int32_t e = edge_at(join, number, place.t);
    if (e == EDGE_FREE || &shell->edges[e] == mates->edge || shell->edges[e].bare)
        return true;
    for (int k = 0; k < mates->count; k++)
        if (mates->found[k] == e)
            return true;
    if (coincide(mates, &shell->edges[e], place.t, &mates->reversed[mates->count],
                 &mates->gap[mates->count]))
        mates->found[mates->count++] = e;
    return mates->count < MATES_MAX;
}

static void find_mates(struct join *join, const struct face_edge *edge, struct mates *mates) {
    *mates = (struct mates){.join = join, .edge = edge};
    for (int k = 0; k < SAMPLES; k++) {
        struct curve_place place;
        double share = (k + 1.0) / (SAMPLES + 1);
        curve_at(join->shell, &join->shell->curves[edge->curve],
                 edge->t[0] + share * (edge->t[1] - edge->t[0]), &place);
        mates->sample[k] = place.r;
    }
    struct vec3 middle = mates->sample[SAMPLES / 2];
    struct box box = box_round(middle, middle, join->shell->tolerance);
    boxes_visit(join->boxes, &box, try_mate, mates);
}

static int32_t face_of(const struct shell *shell, int32_t edge) {
    return shell->curves[shell->edges[edge].curve].face;
}

/* Whether each edge of a face, but those that are no boundary, coincides with one of another. */
static bool has_edges_of(struct join *join, int32_t face, int32_t other) {
    bool any = false;
    for (size_t e = 0; e < join->shell->edge_count; e++) {
        struct mates mates;
        const struct face_edge *edge = &join->shell->edges[e];
        bool found = false;
        if (face_of(join->shell, (int32_t)e) != face || edge->bare)
            continue;
        find_mates(join, edge, &mates);
        for (int k = 0; k < mates.count; k++)
            found = found || face_of(join->shell, mates.found[k]) == other;
        if (!found)
            return false;
        any = true;
    }
    return any;
}

/* Whether a place well inside a face lies on another. */
static bool lies_on(const struct shell *shell, int32_t face, int32_t other) {
    const struct face *f = &shell->faces[face];
    struct surface_cursor cursor = {0, 0};
    struct surface_jet jet;
    double uv[2], distance;
    for (int k = 0; k < 2; k++)
        uv[k] =
            (surface_axis_lower(&f->surface.axis[k]) + surface_axis_upper(&f->surface.axis[k])) / 2;
    if (f->trim) {
        trim_middle(f->trim, uv);
        surface_inner(&f->surface, uv, uv);
    }
    surface_jet_at(&f->surface, &cursor, uv[0], uv[1], &jet);
    surface_nearest_at(&shell->faces[other].surface, jet.r, uv, &distance);
    return distance <= 2 * shell->tolerance;
}

/* Makes an edge no boundary any more. */
static void take_out(struct shell *shell, struct face_edge *edge) {
    if (edge->mate != EDGE_FREE) {
        shell->edges[edge->mate].mate = EDGE_FREE;
        shell->found.joined--;
    }
    edge->mate = EDGE_FREE;
    edge->bare = true;
}

/* The unit vector at the middle of an edge that lies in its face and points into it. */
static struct vec3 inward_at(const struct shell *shell, const struct face_edge *edge) {
    struct curve_place place;
    curve_at(shell, &shell->curves[edge->curve], (edge->t[0] + edge->t[1]) / 2, &place);
    struct vec3 normal = vec3_cross(place.jet.u, place.jet.v);
    return vec3_unit(vec3_scale(edge->inside, vec3_cross(normal, place.tangent)));
}

/* Of two faces at an edge of three that are one and the same, leaves the later out: its edges are
 * no boundary any more. Whether there were such. */
static bool leave_duplicate_out(struct join *join, int32_t edge, const struct mates *mates) {
    struct shell *shell = join->shell;
    int32_t face[MATES_MAX + 1] = {face_of(shell, edge)};
    for (int k = 0; k < mates->count; k++)
        face[k + 1] = face_of(shell, mates->found[k]);
    for (int a = 0; a <= mates->count; a++)
        for (int b = 0; b <= mates->count; b++) {
            if (face[a] <= face[b] || !has_edges_of(join, face[a], face[b]) ||
                !has_edges_of(join, face[b], face[a]) || !lies_on(shell, face[a], face[b]))
                continue;
            shell->faces[face[a]].duplicate = true;
            shell->faces[face[a]].twin = face[b];
            shell->found.duplicates++;
            for (size_t e = 0; e < shell->edge_count; e++)
                if (face_of(shell, (int32_t)e) == face[a])
                    take_out(shell, &shell->edges[e]);
            return true;
        }
    return false;
}

/* Whether more than two faces meet at an edge, or two that turn back on each other there. */
static bool lie_on_each_other(const struct shell *shell, const struct face_edge *edge,
                              const struct mates *mates) {
    if (mates->count != 1)
        return mates->count > 1;
    return vec3_dot(inward_at(shell, edge), inward_at(shell, &shell->edges[mates->found[0]])) >
           turned_back;
}

static enum status three_faces(const struct shell *shell, int32_t edge, const struct mates *mates,
                               struct shell_fault *fault) {
    int32_t face[3] = {face_of(shell, edge), face_of(shell, mates->found[0]),
                       face_of(shell, mates->found[1])};
    for (int a = 0; a < 2; a++)
        for (int b = 0; b < 2; b++)
            if (face[b] > face[b + 1]) {
                int32_t swap = face[b];
                face[b] = face[b + 1];
                face[b + 1] = swap;
            }
    if (fault)
        *fault = (struct shell_fault){.kind = SHELL_THREE_FACES,
                                      .face_count = 3,
                                      .face = {face[0], face[1], face[2]},
                                      .at = mates->sample[SAMPLES / 2]};
    return STATUS_INVALID;
}

/* Whether an edge comes before all those that it meets: a place is counted once. */
static bool is_first(const struct mates *mates, int32_t edge) {
    for (int k = 0; k < mates->count; k++)
        if (mates->found[k] < edge)
            return false;
    return true;
}

static enum status join_edges(struct join *join, struct shell_fault *fault) {
    struct shell *shell = join->shell;
    join->edge_of = arena_alloc(join->scratch, shell->curve_count + 1, sizeof *join->edge_of);
    if (!join->edge_of)
        return STATUS_OUT_OF_MEMORY;
    for (size_t e = shell->edge_count; e > 0; e--)
        join->edge_of[shell->edges[e - 1].curve] = (int32_t)(e - 1);
    join->edge_of[shell->curve_count] = (int32_t)shell->edge_count;
    for (size_t c = shell->curve_count; c > 0; c--) {
        int32_t first = join->edge_of[c - 1];
        bool none =
            first >= (int32_t)shell->edge_count || shell->edges[first].curve != (int32_t)(c - 1);
        if (none)
            join->edge_of[c - 1] = join->edge_of[c];
    }
    for (size_t e = 0; e < shell->edge_count; e++) {
        struct mates mates;
        struct face_edge *edge = &shell->edges[e];
        if (edge->bare || edge->mate != EDGE_FREE)
            continue;
        find_mates(join, edge, &mates);
        while (lie_on_each_other(shell, edge, &mates) && !edge->bare &&
               leave_duplicate_out(join, (int32_t)e, &mates))
            find_mates(join, edge, &mates);
        if (edge->bare)
            continue;
        if (mates.count > 1 && !shell->apart)
            return three_faces(shell, (int32_t)e, &mates, fault);
        if (mates.count > 1)
            shell->found.faulty += is_first(&mates, (int32_t)e);
        if (mates.count > 1 || mates.count == 0 || lie_on_each_other(shell, edge, &mates))
            continue; /* cloth does not turn back upon itself */
        struct face_edge *mate = &shell->edges[mates.found[0]];
        edge->mate = mates.found[0];
        mate->mate = (int32_t)e;
        edge->reversed = mate->reversed = mates.reversed[0];
        shell->found.joined++;
        shell->found.largest_gap = fmax(shell->found.largest_gap, mates.gap[0]);
    }
    for (size_t e = 0; e < shell->edge_count; e++)
        shell->found.free += !shell->edges[e].bare && shell->edges[e].mate == EDGE_FREE;
    return STATUS_OK;
}

/* ---- segments ---- */

/* The steps of an edge's curve within it, its own ends put in; counted, and noted where there is
 * room. */
static uint32_t make_segments(const struct join *join, int32_t number, struct face_segment *to) {
    const struct shell *shell = join->shell;
    const struct face_edge *edge = &shell->edges[number];
    const struct face_curve *curve = &shell->curves[edge->curve];
    const struct point *points = join->points + curve->first;
    struct point from = sample(shell, curve, edge->t[0]);
    uint32_t count = 0;
    for (uint32_t k = 0; k < curve->count && from.t < edge->t[1]; k++) {
        if (!(points[k].t > from.t))
            continue;
        struct point end = points[k].t < edge->t[1] ? points[k] : sample(shell, curve, edge->t[1]);
        if (to)
            to[count] = (struct face_segment){.a = {from.uv[0], from.uv[1]},
                                              .b = {end.uv[0], end.uv[1]},
                                              .t = {from.t, end.t},
                                              .edge = number};
        count++;
        from = end;
    }
    return count;
}

static enum status gather_segments(struct join *join, struct arena *arena) {
    struct shell *shell = join->shell;
    for (int pass = 0; pass < 2; pass++) {
        for (size_t e = 0; e < shell->edge_count; e++) {
            struct face *face = &shell->faces[face_of(shell, (int32_t)e)];
            if (!shell->edges[e].bare)
                face->segment_count += make_segments(
                    join, (int32_t)e, pass ? face->segments + face->segment_count : NULL);
        }
        for (size_t k = 0; k < shell->face_count && pass == 0; k++) {
            struct face *face = &shell->faces[k];
            face->segments = arena_alloc(arena, face->segment_count, sizeof *face->segments);
            if (!face->segments)
                return STATUS_OUT_OF_MEMORY;
            face->segment_count = 0;
        }
    }
    return STATUS_OK;
}

static enum status join_faces(struct join *join, const struct shell_part *parts,
                              struct shell_fault *fault) {
    struct shell *shell = join->shell;
    add_curves(join, parts);
    for (size_t c = 0; c < shell->curve_count && !join->failed; c++)
        sample_curve(join, (int32_t)c);
    enum status status = join->failed ? STATUS_OUT_OF_MEMORY : make_boxes(join, shell->tolerance);
    if (status != STATUS_OK)
        return status;
    cut_curves(join);
    status = join->failed ? STATUS_OUT_OF_MEMORY : make_edges(join);
    if (status == STATUS_OK)
        status = join_edges(join, fault);
    return status == STATUS_OK ? gather_segments(join, join->arena) : status;
}

enum status faces_join(struct shell *shell, const struct shell_part *parts, struct arena *arena,
                       struct shell_fault *fault) {
    struct arena *apart[3] = {arena_child(arena), arena_child(arena), arena_child(arena)};
    struct join join = {
        .shell = shell, .arena = arena, .scratch = apart[0], .pool = {apart[1], apart[2]}};
    enum status status = STATUS_OUT_OF_MEMORY;
    if (apart[0] && apart[1] && apart[2])
        status = join_faces(&join, parts, fault);
    for (int k = 0; k < 3; k++)
        if (apart[k])
            arena_rewind(apart[k], (struct arena_mark){0});
    for (size_t k = 0; k < shell->face_count && status == STATUS_OK; k++) {
        status = face_make_runs(&shell->faces[k], arena);
        if (status == STATUS_OK)
            status = face_make_grid(&shell->faces[k], arena);
    }
    return status;
}
