/* SPDX-License-Identifier: MIT */
#include "way.h"

#include "solver/surface/spans.h"
#include <string.h>

/* The least sine between the way and a line that it crosses. */
static const double least_crossing = 3e-3;

/* First and second derivatives that differ by less than this, as a share, are the same. */
static const double even = 1e-9;

/* The sine of the angle by which normals on both sides of a knot line differ at a crease. */
static const double creased = 1e-6;

/* A knot line or joint within this share of a piece from its end is where the piece ends. */
static const double at_end = 1e-9;

/* A point this share of a way on from a knot line is surely on that side of it. */
static const double beside = 1e-6;

/* There is no piece shorter than this share of the way: p or q lies on a joint, and the way begins
 * on the other side of it, or ends there. */
static const double no_piece = 1e-9;

/* Where a face is left is looked for so many times as far as q is; nearer, so often half as far,
 * where a pole has no line that leads there; and further, so often twice as far in parameters. */
static const double beyond = 1.5;
enum { REACHES = 3 };

/* A place where the way leaves a face is moved, so often, where it is off the straight way by more
 * than this share of that. */
static const double aimed = 0.03;
enum { STRAIGHT_ROUNDS = 2 };

/* An end is moved by less than this share of the last piece. */
static const double near_end = 0.25;

/* The segments of a joint are this near to it, as a share of a piece that ends there. */
static const double off_segment = 1e-3;

/* ---- knot lines ---- */

struct line {
    int axis;
    double at, share; /* the parameter of the axis, and the share of the way */
};

/* The knot lines of direction k between p and q at which curvature may jump. */
static bool find_lines(const struct surface_point *p, const struct surface_point *q, int k,
                       struct line line[], int *count) {
    const struct surface_axis *axis = &p->surface->axis[k];
    struct surface_walk walk = surface_walk_begin(axis, p->uv[k], q->uv[k]);
    if (!(fabs(walk.way) <= surface_axis_upper(axis) - surface_axis_lower(axis)))
        return false;
    while (surface_walk_next(&walk)) {
        if (!axis->joints[walk.number])
            continue;
        if (*count == WAY_LINES)
            return false;
        int n = (*count)++;
        for (; n > 0 && line[n - 1].share > walk.share; n--)
            line[n] = line[n - 1];
        line[n] = (struct line){k, walk.at, walk.share};
    }
    return true;
}

bool way_point_beside(const struct surface *surface, const double uv[2], const double towards[2],
                      struct surface_point *point) {
    int span[2];
    double at[2];
    for (int k = 0; k < 2; k++) {
        const struct surface_axis *axis = &surface->axis[k];
        double on = uv[k] + beside * (towards[k] - uv[k]);
        double wrapped = surface_axis_wrap(axis, on);
        span[k] = surface_axis_span(axis, 0, wrapped);
        at[k] = uv[k] - (on - wrapped);
        point->uv[k] = uv[k];
    }
    surface_evaluate_span(surface, span[0], span[1], at[0], at[1], &point->jet);
    return surface_point_complete(surface, point);
}

bool way_place_ends(struct way *way, int k) {
    double middle[2];
    const struct surface *surface = way->from[k]->surface;
    for (int n = 0; n < 2; n++)
        middle[n] = (way->from[k]->uv[n] + way->to[k]->uv[n]) / 2;
    return way_point_beside(surface, way->from[k]->uv, middle, way->from[k]) &&
           way_point_beside(surface, way->to[k]->uv, middle, way->to[k]);
}

/* Whether a surface bends alike in two points on both sides of a line. */
static bool bends_alike(const struct surface_point *a, const struct surface_point *b) {
    double differ = 0, size = 0;
    for (int n = 0; n < 3; n++) {
        differ += fabs(a->first[n] - b->first[n]) + fabs(a->second[n] - b->second[n]);
        size += fabs(a->first[n]) + fabs(a->second[n]);
    }
    return differ < even * size && vec3_dot(a->normal, b->normal) > 1 - even;
}

/* Adds the way over a face from p to q, split at the knot lines where curvature jumps: the last
 * piece ends there, and the next one begins; not where the surface bends the same on both sides, at
 * a knot that was inserted. An end that lies on a fold has two frames: here that of the side on
 * which the way runs. */
static bool add_leg(struct way *way, int on, const struct surface_point *p,
                    const struct surface_point *q) {
    struct line line[WAY_LINES];
    int count = 0, first = way->pieces;
    if (!find_lines(p, q, 0, line, &count) || !find_lines(p, q, 1, line, &count) ||
        first + count >= WAY_PIECES)
        return false;
    way->from[first] = &way->points[way->used++];
    struct surface_point *end = &way->points[way->used++];
    *way->from[first] = *p;
    way->on[way->pieces++] = on;
    for (int k = 0; k < count; k++) {
        struct surface_point *to = &way->points[way->used], *from = &way->points[way->used + 1];
        const struct surface_point *last = way->from[way->pieces - 1];
        double uv[2], before[2], after[2], next_share = k + 1 < count ? line[k + 1].share : 1;
        for (int n = 0; n < 2; n++) {
            double step = q->uv[n] - p->uv[n];
            uv[n] = n == line[k].axis ? line[k].at : p->uv[n] + line[k].share * step;
            before[n] = (last->uv[n] + uv[n]) / 2;
            after[n] = (uv[n] + p->uv[n] + next_share * step) / 2;
        }
        if (!way_point_beside(p->surface, uv, before, to) ||
            !way_point_beside(p->surface, uv, after, from))
            return false;
        if (bends_alike(to, from))
            continue;
        way->to[way->pieces - 1] = to;
        way->from[way->pieces] = from;
        way->on[way->pieces++] = line[k].axis;
        way->used += 2;
    }
    *end = *q;
    way->to[way->pieces - 1] = end;
    if (way->pieces == first + 1 && !p->surface->has_folds)
        return true;
    return way_place_ends(way, first) && way_place_ends(way, way->pieces - 1);
}

/* ---- joints of faces ---- */

/* Puts parameters into the turn of a near place. */
static void put_in_turn(const struct surface *surface, const double near[2], double uv[2]) {
    for (int k = 0; k < 2; k++) {
        double turn = surface_axis_length(&surface->axis[k]);
        if (surface->axis[k].closed)
            uv[k] += turn * floor((near[k] - uv[k]) / turn + 0.5);
    }
}

/* The joint over which the way from a point towards q leaves its face first; where it goes on past
 * its end, too. */
static bool leave_face(struct surface_cursor *cursor, const struct surface_point *from,
                       const struct surface_point *q, struct crossing *joint) {
    double there[2], to[2], share, reach = beyond * vec3_distance(from->jet.r, q->jet.r);
    struct vec3 step = surface_point_tangent(from, vec3_sub(q->jet.r, from->jet.r));
    bool pulled = false, met = false;
    for (int k = 0; k < REACHES && !pulled; k++, reach /= 2)
        pulled = surface_point_pull_on_face(cursor, from, vec3_scale(reach, step), there);
    for (int k = 0; k < REACHES && pulled && !met; k++) {
        for (int n = 0; n < 2; n++)
            to[n] = from->uv[n] + (1 << k) * (there[n] - from->uv[n]);
        met = crossing_on_way(from->surface, from->uv, to, &share, joint);
    }
    return met && joint->beyond != from->surface;
}

/* Moves the place where the way leaves its face along the joint, to where the plane through its
 * beginning and q does that is normal to the surface: the way is to be straight in space, and lines
 * that are in parameters turn round poles. That place is `end`. */
static bool leave_straight(struct surface_cursor *cursor, const struct surface_point *from,
                           const struct surface_point *q, struct crossing *joint,
                           struct surface_point *end) {
    double whole = vec3_distance(from->jet.r, q->jet.r);
    struct vec3 step = surface_point_tangent(from, vec3_sub(q->jet.r, from->jet.r));
    struct vec3 aside = vec3_cross(from->normal, step);
    for (int round = 0;; round++) {
        if (!surface_point_at(from->surface, cursor, joint->edge, end))
            return false;
        struct vec3 by =
            vec3_axpy(joint->rate[1], end->jet.v, vec3_scale(joint->rate[0], end->jet.u));
        double left = vec3_dot(vec3_sub(end->jet.r, from->jet.r), aside);
        double rate = vec3_dot(by, aside);
        if (round == STRAIGHT_ROUNDS || !(fabs(left) > aimed * whole) ||
            !(fabs(rate) > least_crossing * vec3_norm(by)))
            return true;
        if (!crossing_move(from->surface, joint->t - left / rate, joint))
            return false;
    }
}

bool way_lay(struct surface_cursor *cursor, const struct surface_point *p,
             const struct surface_point *q, struct way *way) {
    struct surface_point begin = *p, end;
    double least = no_piece * vec3_distance(p->jet.r, q->jet.r);
    int on = WAY_ALONG;
    way->pieces = way->used = way->joints = 0;
    /* Round a vertex at p it could go from face to face for ever, without a piece. */
    for (int left = 2 * WAY_JOINTS; begin.surface != q->surface; left--) {
        struct crossing *joint = &way->joint[way->joints];
        if (left == 0 || way->joints == WAY_JOINTS || !leave_face(cursor, &begin, q, joint) ||
            !leave_straight(cursor, &begin, q, joint, &end))
            return false;
        bool beyond_p = way->pieces == 0 && vec3_distance(begin.jet.r, end.jet.r) <= least;
        if ((!beyond_p && !add_leg(way, on, &begin, &end)) ||
            !surface_point_at(joint->beyond, cursor, joint->entry, &begin))
            return false;
        on = beyond_p ? WAY_ALONG : WAY_JOINT + way->joints++;
    }
    if (p->surface != q->surface)
        put_in_turn(q->surface, q->uv, begin.uv);
    bool before_q = way->pieces > 0 && vec3_distance(begin.jet.r, q->jet.r) <= least;
    return before_q || add_leg(way, on, &begin, q);
}

bool way_move_end(struct way *way, const struct surface_point *q) {
    int last = way->pieces - 1, leg = last, count = 0;
    struct surface_point *from = way->from[last], *end = way->to[last];
    struct line line[WAY_LINES];
    double piece2 = vec3_norm2(vec3_sub(end->jet.r, from->jet.r));
    bool stays = q->surface == end->surface &&
                 vec3_norm2(vec3_sub(q->jet.r, end->jet.r)) < near_end * near_end * piece2;
    for (int k = 0; k < 2 && stays; k++)
        stays = 2 * fabs(q->uv[k] - end->uv[k]) < surface_axis_length(&q->surface->axis[k]) &&
                find_lines(from, q, k, line, &count) && count == 0;
    if (!stays)
        return false;
    *end = *q;
    while (leg > 0 && way->on[leg] == WAY_ALONG)
        leg--;
    bool split = leg > 0 && way->on[leg] < WAY_JOINT;
    return !(split || q->surface->has_folds) || way_place_ends(way, last);
}

void way_tangents(const struct way *way, int k, struct vec3 tangent[2]) {
    const struct surface_point *side[2] = {way->to[k - 1], way->from[k]};
    int on = way->on[k];
    if (on >= WAY_JOINT) {
        tangent[0] = way->joint[on - WAY_JOINT].from.along;
        tangent[1] = way->joint[on - WAY_JOINT].to.along;
        return;
    }
    for (int n = 0; n < 2; n++)
        tangent[n] = vec3_unit(on == 0 ? side[n]->jet.v : side[n]->jet.u);
}

double way_crease(const struct way *way) {
    double most = 0;
    for (int k = 0; k < way->joints; k++)
        most = fmax(most, vec3_distance(way->joint[k].from.normal, way->joint[k].to.normal));
    return most;
}

bool way_slide(struct way *way, int k, double left) {
    struct surface_point *before = way->to[k - 1], *after = way->from[k];
    struct vec3 along = surface_point_tangent(after, vec3_sub(way->to[k]->jet.r, after->jet.r));
    struct vec3 aside = vec3_cross(after->normal, along);
    if (way->on[k] < WAY_JOINT) {
        int n = 1 - way->on[k];
        struct vec3 by = n == 0 ? after->jet.u : after->jet.v;
        double rate = vec3_dot(by, aside);
        if (!(fabs(rate) > least_crossing * vec3_norm(by)))
            return false;
        after->uv[n] += left / rate;
        before->uv[n] = after->uv[n];
        return true;
    }
    struct crossing *joint = &way->joint[way->on[k] - WAY_JOINT];
    double sine = vec3_dot(joint->to.along, aside);
    struct vec3 by =
        vec3_axpy(joint->rate[1], before->jet.v, vec3_scale(joint->rate[0], before->jet.u));
    double t = joint->t + left / (sine * vec3_dot(by, joint->from.along));
    if (!(fabs(sine) > least_crossing) || !crossing_move(before->surface, t, joint) ||
        joint->t != t)
        return false;
    memcpy(before->uv, joint->edge, sizeof before->uv);
    const double near[2] = {after->uv[0], after->uv[1]};
    memcpy(after->uv, joint->entry, sizeof after->uv);
    put_in_turn(after->surface, near, after->uv);
    return true;
}

/* Whether the way of a piece in parameters crosses a crease of direction n: points have moved past
 * where it meets another, and the piece was taken for one in the span of its middle. */
static bool crosses_crease(const struct surface_point *from, const struct surface_point *to,
                           int n) {
    const struct surface *surface = from->surface;
    struct surface_walk walk = surface_walk_begin(&surface->axis[n], from->uv[n], to->uv[n]);
    while (surface_walk_next(&walk)) {
        struct surface_point before, after;
        double uv[2];
        if (!surface->axis[n].joints[walk.number] || !(walk.share > at_end) ||
            !(walk.share < 1 - at_end))
            continue;
        for (int x = 0; x < 2; x++)
            uv[x] = x == n ? walk.at : from->uv[x] + walk.share * (to->uv[x] - from->uv[x]);
        if (!way_point_beside(surface, uv, from->uv, &before) ||
            !way_point_beside(surface, uv, to->uv, &after) ||
            vec3_norm(vec3_cross(before.normal, after.normal)) > creased)
            return true;
    }
    return false;
}

/* Whether piece k ends on that joint. */
static bool ends_on(const struct way *way, int k, int32_t joint) {
    int on = k + 1 < way->pieces ? way->on[k + 1] : WAY_ALONG;
    return on >= WAY_JOINT && way->joint[on - WAY_JOINT].number == joint;
}

bool way_holds(const struct way *way) {
    for (int k = 0; k < way->pieces; k++) {
        const struct surface_point *from = way->from[k], *to = way->to[k];
        struct crossing_exit exit;
        if (from->surface->has_folds &&
            (crosses_crease(from, to, 0) || crosses_crease(from, to, 1)))
            return false;
        if (way->joints > 0 && crossing_leaves(from->surface, from->uv, to->uv, &exit) &&
            exit.share > beside &&
            exit.share < 1 - (ends_on(way, k, exit.edge) ? off_segment : beside))
            return false;
    }
    return true;
}
