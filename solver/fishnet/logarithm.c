/* SPDX-License-Identifier: MIT */
#include "logarithm.h"

#include "fishnet_geodesic.h"
#include "solver/surface/spans.h"
#include "unfolding.h"

enum { PIECES = 16, JOINTS = 8, SWEEPS = 6, PULLS = 6, ALONG = -1 };

/* Over pieces whose normals differ by more than this, as a cosine, nothing is known. */
static const double least_cosine = 0.3;

/* A point that is put on the path is this near to where it was to be, as a share of the piece. */
static const double pull_share = 0.02;

/* Directions are as exact as this, by the root of the accuracy. Pieces that meet at an angle a need
 * not be moved for good where what moves leave out of it, a (a + K s^2) on a path s long, is less
 * than that; and a^3 less than the accuracy. */
static const double angle_share = 0.3;

/* The least sine between the path and a knot line that it crosses. */
static const double least_crossing = 3e-3;

/* First and second derivatives that differ by less than this, as a share, are the same. */
static const double even = 1e-9;

/* The sine of the angle by which normals on both sides of a knot line differ at a crease. */
static const double creased = 1e-6;

/* A knot line within this share of a piece from its end is where the piece ends. */
static const double at_end = 1e-9;

/* A point this share of a way on from a knot line is surely on that side of it. */
static const double beside = 1e-6;

/* The points from p to q and the pieces between them; on a knot line of direction `axis` one for
 * either side. */
struct chain {
    struct surface_cursor *cursor;
    double accuracy, whole;
    int pieces, used;
    struct surface_point *from[PIECES], *to[PIECES];
    int axis[PIECES + 1]; /* of the point at the beginning of each piece; ALONG: none */
    struct rough_geodesic piece[PIECES];
    bool known[PIECES];
    struct surface_point points[2 * (PIECES + JOINTS)];
};

static void estimate_piece(struct chain *c, int k) {
    struct rough_geodesic *g = &c->piece[k];
    c->known[k] = rough_estimate(c->from[k], c->to[k], g) &&
                  vec3_dot(c->from[k]->normal, c->to[k]->normal) > least_cosine &&
                  g->error * g->length < c->accuracy * c->whole &&
                  g->angle < angle_share * sqrt(c->accuracy);
}

/* ---- knot lines ---- */

struct joint {
    int axis;
    double at, share; /* the parameter of the axis, and the share of the way */
};

/* The knot lines of direction k between p and q at which curvature may jump. False when there are
 * too many, or more than once round a closed direction. */
static bool find_joints(const struct surface_point *p, const struct surface_point *q, int k,
                        struct joint joint[], int *count) {
    const struct surface_axis *axis = &p->surface->axis[k];
    struct surface_walk walk = surface_walk_begin(axis, p->uv[k], q->uv[k]);
    if (!(fabs(walk.way) <= surface_axis_upper(axis) - surface_axis_lower(axis)))
        return false;
    while (surface_walk_next(&walk)) {
        if (!axis->joints[walk.number])
            continue;
        if (*count == JOINTS)
            return false;
        int n = (*count)++;
        for (; n > 0 && joint[n - 1].share > walk.share; n--)
            joint[n] = joint[n - 1];
        joint[n] = (struct joint){k, walk.at, walk.share};
    }
    return true;
}

/* The point at uv as the span has it in which the way to `towards` begins. A span further on,
 * over a knot line on which parameters alone change, has another point at uv. */
static bool surface_point_beside(const struct surface *surface, const double uv[2],
                                 const double towards[2], struct surface_point *point) {
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

/* Evaluates both ends of piece k in the span that it runs through. */
static bool place_ends(const struct surface *surface, struct chain *c, int k) {
    double middle[2];
    for (int n = 0; n < 2; n++)
        middle[n] = (c->from[k]->uv[n] + c->to[k]->uv[n]) / 2;
    return surface_point_beside(surface, c->from[k]->uv, middle, c->from[k]) &&
           surface_point_beside(surface, c->to[k]->uv, middle, c->to[k]);
}

/* Splits the way from p to q at the knot lines that are joints: the last piece ends there, and the
 * next one begins; not where the surface bends the same on both sides, at a knot that was inserted.
 * An end that lies on a fold has two frames: here that of the side on which the way runs.
 */
static bool split_at_joints(struct chain *c, const struct surface_point *p,
                            const struct surface_point *q) {
    struct joint joint[JOINTS];
    int count = 0;
    if (!find_joints(p, q, 0, joint, &count) || !find_joints(p, q, 1, joint, &count))
        return false;
    c->pieces = 1;
    c->used = 2;
    c->from[0] = &c->points[0];
    *c->from[0] = *p;
    c->axis[0] = ALONG;
    for (int k = 0; k < count; k++) {
        struct surface_point *to = &c->points[c->used], *from = &c->points[c->used + 1];
        const struct surface_point *last = c->from[c->pieces - 1];
        double uv[2], before[2], after[2], next_share = k + 1 < count ? joint[k + 1].share : 1;
        for (int n = 0; n < 2; n++) {
            double way = q->uv[n] - p->uv[n];
            uv[n] = n == joint[k].axis ? joint[k].at : p->uv[n] + joint[k].share * way;
            before[n] = (last->uv[n] + uv[n]) / 2;
            after[n] = (uv[n] + p->uv[n] + next_share * way) / 2;
        }
        if (!surface_point_beside(p->surface, uv, before, to) ||
            !surface_point_beside(p->surface, uv, after, from))
            return false;
        double differ = 0, size = 0;
        for (int n = 0; n < 3; n++) {
            differ += fabs(to->first[n] - from->first[n]) + fabs(to->second[n] - from->second[n]);
            size += fabs(to->first[n]) + fabs(to->second[n]);
        }
        if (differ < even * size && vec3_dot(to->normal, from->normal) > 1 - even)
            continue;
        c->to[c->pieces - 1] = to;
        c->from[c->pieces] = from;
        c->axis[c->pieces++] = joint[k].axis;
        c->used += 2;
    }
    struct surface_point *end = c->to[c->pieces - 1] = &c->points[1];
    *end = *q;
    if (c->pieces == 1 && !p->surface->has_folds)
        return true;
    return place_ends(p->surface, c, 0) && place_ends(p->surface, c, c->pieces - 1);
}

/* ---- points within spans ---- */

/* Puts a point in the middle of piece k, on the cubic that leaves its ends as the yarn does. */
static bool halve_piece(struct chain *c, int k) {
    struct surface_point *p = c->from[k], *q = c->to[k];
    double length = vec3_distance(p->jet.r, q->jet.r);
    if (c->pieces == PIECES)
        return false;
    struct vec3 bulge = vec3_sub(c->piece[k].leave, c->piece[k].arrive);
    struct vec3 middle = vec3_scale(0.5, vec3_add(p->jet.r, q->jet.r));
    struct vec3 target = vec3_axpy(length / 8, bulge, middle);
    struct surface_point *to = &c->points[c->used++];
    if ((!fishnet_pull_to(c->cursor, p, target, pull_share * length, PULLS, to) &&
         !fishnet_pull_to(c->cursor, q, target, pull_share * length, PULLS, to)) ||
        !(vec3_norm2(vec3_sub(to->jet.r, middle)) < length * length / 9))
        return false;
    for (int n = c->pieces++; n > k; n--) {
        c->from[n] = c->from[n - 1];
        c->to[n] = c->to[n - 1];
        c->axis[n] = c->axis[n - 1];
        c->piece[n] = c->piece[n - 1];
        c->known[n] = c->known[n - 1];
    }
    c->to[k] = c->from[k + 1] = to;
    c->axis[k + 1] = ALONG;
    return true;
}

/* ---- a straight line of pieces ---- */

static struct vec3 knot_line(const struct surface_point *at, int axis) {
    return vec3_unit(axis == 0 ? at->jet.v : at->jet.u);
}

/* The angles a_k at the points within, to the left, by their sines, and the moves x_k that take
 * them away. On a knot line they are measured against that, on both sides of it. The largest angle;
 * infinite where there is no straight line, as pieces turn back. */
static double straighten(const struct chain *c, double angle[], double move[]) {
    double most = 0, upper[PIECES], inverse[PIECES];
    for (int k = 0; k < c->pieces; k++)
        inverse[k] = 1 / c->piece[k].length;
    for (int k = 1; k < c->pieces; k++) {
        const struct surface_point *before = c->to[k - 1], *after = c->from[k];
        struct vec3 back = vec3_scale(-1, c->piece[k - 1].arrive), onward = c->piece[k].leave;
        bool goes_on = vec3_dot(onward, back) < 0;
        if (c->axis[k] == ALONG) {
            angle[k] = vec3_dot(vec3_cross(onward, back), after->normal);
        } else {
            struct vec3 line[2] = {knot_line(before, c->axis[k]), knot_line(after, c->axis[k])};
            double c0 = -vec3_dot(line[0], back), c1 = vec3_dot(line[1], onward);
            double s0 = -vec3_dot(vec3_cross(line[0], back), before->normal);
            double s1 = vec3_dot(vec3_cross(line[1], onward), after->normal);
            angle[k] = s1 * c0 - c1 * s0;
            goes_on = c0 * c1 + s0 * s1 > 0 && fabs(s0) > least_crossing;
        }
        if (!goes_on)
            return HUGE_VAL;
        most = fmax(most, fabs(angle[k]));
        double own = inverse[k - 1] + inverse[k], right = angle[k];
        if (k > 1) {
            own -= inverse[k - 1] * upper[k - 1];
            right += inverse[k - 1] * move[k - 1];
        }
        upper[k] = inverse[k] / own;
        move[k] = right / own;
    }
    for (int k = c->pieces - 2; k >= 1; k--)
        move[k] += upper[k] * move[k + 1];
    return most;
}

/* Moves the points within to the left of the path, on a knot line along that. */
static bool move_points(struct chain *c, const double move[]) {
    const struct surface *surface = c->from[0]->surface;
    for (int k = 1; k < c->pieces; k++) {
        struct surface_point *here = c->from[k];
        struct vec3 along = surface_point_tangent(here, vec3_sub(c->to[k]->jet.r, here->jet.r));
        struct vec3 left = vec3_cross(here->normal, along);
        if (c->axis[k] == ALONG) {
            struct vec3 target = vec3_axpy(move[k], left, here->jet.r);
            if (!fishnet_pull_to(c->cursor, here, target, pull_share * c->piece[k].length, PULLS,
                                 here))
                return false;
            continue;
        }
        int n = 1 - c->axis[k];
        struct vec3 by = n == 0 ? here->jet.u : here->jet.v;
        double rate = vec3_dot(by, left);
        if (!(fabs(rate) > least_crossing * vec3_norm(by)))
            return false;
        here->uv[n] += move[k] / rate;
        c->to[k - 1]->uv[n] = here->uv[n];
    }
    for (int k = 0; k < c->pieces; k++) {
        if ((c->axis[k] != ALONG || (k + 1 < c->pieces && c->axis[k + 1] != ALONG)) &&
            !place_ends(surface, c, k))
            return false;
    }
    for (int k = 0; k < c->pieces; k++)
        estimate_piece(c, k);
    return true;
}

/* Whether the way of piece k in parameters crosses a crease of direction n: points have moved past
 * where it meets another, and the piece was taken for one in the span of its middle. */
static bool crosses_crease(const struct chain *c, int k, int n) {
    const struct surface_point *from = c->from[k], *to = c->to[k];
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
        if (!surface_point_beside(surface, uv, from->uv, &before) ||
            !surface_point_beside(surface, uv, to->uv, &after) ||
            vec3_norm(vec3_cross(before.normal, after.normal)) > creased)
            return true;
    }
    return false;
}

bool logarithm_find(struct surface_cursor *cursor, const struct surface_point *p,
                    const struct surface_point *q, double accuracy, struct logarithm *logarithm) {
    struct chain c;
    double angle[PIECES], move[PIECES + 1];
    c.cursor = cursor;
    c.accuracy = accuracy;
    c.whole = vec3_distance(p->jet.r, q->jet.r);
    if (p->surface != q->surface || !surface_point_is_regular(p) || !surface_point_is_regular(q) ||
        !(c.whole > 0) || !split_at_joints(&c, p, q))
        return false;
    for (int k = 0; k < c.pieces; k++)
        estimate_piece(&c, k);
    for (int k = 0; k < c.pieces;) {
        if (c.known[k]) {
            k++;
            continue;
        }
        if (!halve_piece(&c, k))
            return false;
        estimate_piece(&c, k);
        estimate_piece(&c, k + 1);
    }
    for (int sweep = 0; c.pieces > 1; sweep++) {
        double most = straighten(&c, angle, move);
        double gauss = fmax(fabs(surface_point_gauss_curvature(c.from[0])),
                            fabs(surface_point_gauss_curvature(c.to[c.pieces - 1])));
        if (most * (most + gauss * c.whole * c.whole) <= angle_share * sqrt(accuracy) &&
            most * most * most <= accuracy)
            break;
        if (!(most < 1) || sweep == SWEEPS || !move_points(&c, move))
            return false;
    }
    for (int k = 0; p->surface->has_folds && k < c.pieces; k++)
        if (crosses_crease(&c, k, 0) || crosses_crease(&c, k, 1))
            return false;
    /* The first and last pieces are turned by the moves that are left. */
    int last = c.pieces - 1;
    struct vec3 leave = c.piece[0].leave, arrive = c.piece[last].arrive;
    double first = last > 0 ? move[1] / c.piece[0].length : 0;
    double end = last > 0 ? -move[last] / c.piece[last].length : 0;
    logarithm->length = c.piece[0].length;
    for (int k = 1; k < c.pieces; k++)
        logarithm->length += c.piece[k].length - angle[k] * move[k] / 2;
    leave = vec3_unit(vec3_axpy(first, vec3_cross(c.from[0]->normal, leave), leave));
    arrive = vec3_unit(vec3_axpy(end, vec3_cross(c.to[last]->normal, arrive), arrive));
    logarithm->leave = unfolding_turned(leave, c.from[0]->normal, p->normal);
    logarithm->arrive = unfolding_turned(arrive, c.to[last]->normal, q->normal);
    return isfinite(logarithm->length);
}

/* Directions that are asked for alone are right to the square root of this. */
static const double leave_accuracy = 1e-8;

struct vec3 logarithm_leave(struct surface_cursor *cursor, const struct surface_point *p,
                            const struct rough_end *end) {
    bool sure;
    struct surface_point made;
    struct logarithm l;
    struct vec3 leave = rough_leave(cursor, p, end, &sure);
    if (sure || !end->surface || end->surface != p->surface)
        return leave;
    const struct surface_point *q = rough_end_point(cursor, end, &made);
    if (!q || rough_leaves_surely(q, p->jet.r) || !logarithm_find(cursor, p, q, leave_accuracy, &l))
        return leave;
    return l.leave;
}
