/* SPDX-License-Identifier: MIT */
#include "joints.h"

#include <string.h>

enum { HALVINGS = 12, FIRST_PIECES = 4 };

/* Segments leave their curve by less than this share of the domain. */
static const double flatness = 1e-6;

static void add_join_point(struct join *join, const struct join_point *point) {
    if (join->failed)
        return;
    if (join->point_count == join->point_room) { /* what they are copied from is given back */
        struct arena *from = join->pool[0];
        join->points = arena_enlarge(join->pool[1], join->points, join->point_count,
                                     sizeof *join->points, &join->point_room);
        arena_rewind(from, (struct arena_mark){0});
        join->pool[0] = join->pool[1];
        join->pool[1] = from;
    }
    join->failed = join->failed || !join->points;
    if (!join->failed)
        join->points[join->point_count++] = *point;
}

static struct face_curve *add_face_curve(struct join *join, int32_t face) {
    struct shell *shell = join->shell;
    if (join->failed)
        return NULL;
    if (shell->curve_count == join->curve_room)
        shell->curves = arena_enlarge(join->arena, shell->curves, shell->curve_count,
                                      sizeof *shell->curves, &join->curve_room);
    join->failed = join->failed || !shell->curves;
    if (join->failed)
        return NULL;
    struct face_curve *curve = &shell->curves[shell->curve_count++];
    *curve = (struct face_curve){.face = face, .range = {0, 1}};
    return curve;
}

static void add_straight_curve(struct join *join, int32_t face, const double from[2],
                               const double to[2]) {
    struct face_curve *curve = add_face_curve(join, face);
    if (!curve)
        return;
    memcpy(curve->line[0], from, sizeof curve->line[0]);
    memcpy(curve->line[1], to, sizeof curve->line[1]);
}

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
        add_straight_curve(join, face, end[0], end[1]);
    }
}

static void add_trim_curve(struct join *join, int32_t face, const struct trim_curve *trim) {
    struct face_curve *curve = add_face_curve(join, face);
    if (!curve)
        return;
    curve->trim = trim;
    trim_curve_range(trim, curve->range);
}

static void add_trim_loop(struct join *join, int32_t face, const struct trim_loop *loop) {
    const struct surface *surface = &join->shell->faces[face].surface;
    double first[2] = {0, 0}, last[2] = {0, 0};
    for (size_t k = 0; k <= loop->count; k++) {
        double begin[2];
        const struct trim_curve *trim = k < loop->count ? &loop->curves[k] : NULL;
        if (trim)
            trim_curve_end(trim, 0, begin);
        else
            memcpy(begin, first, sizeof begin);
        bool meets = true; /* as far as curves are meant to */
        for (int x = 0; x < 2; x++) {
            const double *outer = surface->axis[x].outer;
            meets = meets && fabs(last[x] - begin[x]) <= flatness * (outer[1] - outer[0]);
        }
        if (k == 0)
            memcpy(first, begin, sizeof first);
        else if (!meets) { /* the loop is closed by a line that is straight in (u, v) */
            struct trim_curve *line = arena_alloc(join->arena, 1, sizeof *line);
            double(*ends)[2] = arena_alloc(join->arena, 2, sizeof *ends);
            join->failed = join->failed || !line || !ends;
            if (join->failed)
                return;
            memcpy(ends[0], last, sizeof ends[0]);
            memcpy(ends[1], begin, sizeof ends[1]);
            *line =
                (struct trim_curve){.degree = 1, .points = (const double(*)[2])ends, .count = 2};
            add_trim_curve(join, face, line);
        }
        if (!trim)
            break;
        add_trim_curve(join, face, trim);
        trim_curve_end(trim, 1, last);
    }
}

void join_gather_curves(struct join *join, const struct shell_patch *patches) {
    for (size_t k = 0; k < join->shell->face_count; k++) {
        bool keeps = false;
        for (size_t loop = 0; loop < patches[k].loop_count; loop++) {
            add_trim_loop(join, (int32_t)k, &patches[k].loops[loop]);
            keeps = keeps || patches[k].loops[loop].reversed;
        }
        if (!keeps)
            add_domain(join, (int32_t)k);
    }
}

struct join_point join_sample(const struct shell *shell, const struct face_curve *curve, double t) {
    struct curve_place place;
    curve_at(shell, curve, t, &place);
    return (struct join_point){t, {place.uv[0], place.uv[1]}, place.r};
}

/* The square of the distance of x from the straight line between a and b. */
static double off_line2(struct vec3 a, struct vec3 b, struct vec3 x) {
    struct vec3 way = vec3_sub(b, a), to = vec3_sub(x, a);
    double length2 = vec3_norm2(way);
    double share = length2 > 0 ? fmin(fmax(vec3_dot(to, way) / length2, 0), 1) : 0;
    return vec3_norm2(vec3_axpy(-share, way, to));
}

/* Whether a step, straight in parameters, stays near its curve: at its quarters, and where it
 * crosses knot lines, for a short span may bend between all other points that are looked at. The
 * point in its `middle` is told in any case. */
static bool step_is_flat(const struct shell *shell, const struct face_curve *curve,
                         const struct join_point *a, const struct join_point *b,
                         struct join_point *middle) {
    static const double shares[] = {0.5, 0.25, 0.75};
    const struct surface_axis *axis = shell->faces[curve->face].surface.axis;
    double allowed = join_sagitta * vec3_distance(a->r, b->r) + shell->tolerance / 4, by[2];
    for (int k = 0; k < 2; k++)
        by[k] = 1 / surface_axis_length(&axis[k]);
    struct vec3 from = {by[0] * a->uv[0], by[1] * a->uv[1], 0};
    struct vec3 to = {by[0] * b->uv[0], by[1] * b->uv[1], 0};
    for (int n = 0; n < 3; n++) {
        struct join_point at = join_sample(shell, curve, a->t + shares[n] * (b->t - a->t));
        struct vec3 flat = {by[0] * at.uv[0], by[1] * at.uv[1], 0};
        if (n == 0)
            *middle = at;
        if (off_line2(from, to, flat) > flatness * flatness ||
            off_line2(a->r, b->r, at.r) > allowed * allowed)
            return false;
    }
    for (int k = 0; k < 2; k++) {
        struct surface_walk walk = surface_walk_begin(&axis[k], a->uv[k], b->uv[k]);
        while (surface_walk_next(&walk)) {
            struct join_point at = join_sample(shell, curve, a->t + walk.share * (b->t - a->t));
            if (off_line2(a->r, b->r, at.r) > allowed * allowed)
                return false;
        }
    }
    return true;
}

/* The points after `a` up to `b`. */
static void sample_between(struct join *join, const struct face_curve *curve, struct join_point a,
                           struct join_point b) {
    struct join_point stack[HALVINGS + 1], middle;
    int depth = 0;
    stack[0] = b;
    while (depth >= 0) {
        struct join_point end = stack[depth];
        if (depth == HALVINGS || step_is_flat(join->shell, curve, &a, &end, &middle)) {
            add_join_point(join, &end);
            a = end;
            depth--;
            continue;
        }
        stack[++depth] = middle;
    }
}

void join_sample_curve(struct join *join, int32_t number) {
    struct face_curve *curve = &join->shell->curves[number];
    const struct trim_curve *trim = curve->trim;
    struct join_point at = join_sample(join->shell, curve, curve->range[0]);
    curve->first = (uint32_t)join->point_count;
    add_join_point(join, &at);
    while (at.t < curve->range[1] && !join->failed) {
        /* to where it may have a corner next: a knot, or point of a polyline */
        double from = at.t, to = curve->range[1];
        int pieces = trim && !trim->knots ? 1 : FIRST_PIECES;
        if (trim && trim->knots) {
            size_t k = (size_t)trim->degree;
            while (k < trim->count && !(trim->knots[k] > from))
                k++;
            to = k < trim->count ? trim->knots[k] : to;
        } else if (trim) {
            to = fmin(floor(from) + 1, to);
        }
        for (int k = 1; k <= pieces; k++) {
            double t = k == pieces ? to : from + (to - from) * k / pieces;
            struct join_point next = join_sample(join->shell, curve, t);
            sample_between(join, curve, at, next);
            at = next;
        }
    }
    curve->count = (uint32_t)join->point_count - curve->first;
}
