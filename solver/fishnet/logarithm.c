/* SPDX-License-Identifier: MIT */
#include "logarithm.h"

#include "fishnet_geodesic.h"
#include "unfolding.h"

enum { SWEEPS = 6, PULLS = 6 };

/* Over pieces whose normals differ by more than this, as a cosine, nothing is known. */
static const double least_cosine = 0.3;

/* A point that is put on the path is this near to where it was to be, as a share of the piece. */
static const double pull_share = 0.02;

/* Directions are as exact as this, by the root of the accuracy. Pieces that meet at an angle a need
 * not be moved for good where what moves leave out of it, a (a + K s^2) on a path s long, is less
 * than that; and a^2 (a + c) less than the accuracy: a joint that is curved is otherwise curved on
 * its other side where that is turned by c. */
static const double angle_share = 0.3;

/* The least sine between the path and a line or joint that it crosses. */
static const double least_crossing = 3e-3;

static void estimate_piece(struct logarithm_chain *c, int k) {
    const struct surface_point *from = c->way.from[k], *to = c->way.to[k];
    c->sound[k] =
        rough_estimate(from, to, &c->piece[k]) && vec3_dot(from->normal, to->normal) > least_cosine;
}

/* Whether a piece is known by its ends as well as is asked for. */
static bool is_known(const struct logarithm_chain *c, int k) {
    const struct rough_geodesic *g = &c->piece[k];
    return c->sound[k] && g->error * g->length < c->accuracy * c->whole &&
           g->angle < angle_share * sqrt(c->accuracy);
}

/* ---- points within spans ---- */

/* Whether a point is where one is put in the middle of a piece of that length. */
static bool is_near(const struct surface_point *at, struct vec3 target, double length) {
    struct vec3 left = vec3_sub(target, at->jet.r);
    double off = pull_share * length;
    return vec3_norm2(surface_point_projection(at, left)) < off * off &&
           vec3_norm2(left) < length * length / 9;
}

/* Puts a point in the middle of piece k, on the cubic that leaves its ends as the yarn does: from
 * the middle in parameters or, beside a pole, where that may be far off, from an end. */
static bool halve_piece(struct logarithm_chain *c, int k) {
    struct way *way = &c->way;
    struct surface_point *p = way->from[k], *q = way->to[k], middle;
    double length = vec3_distance(p->jet.r, q->jet.r);
    if (way->pieces == WAY_PIECES)
        return false;
    struct vec3 bulge = vec3_sub(c->piece[k].leave, c->piece[k].arrive);
    struct vec3 target =
        vec3_axpy(length / 8, bulge, vec3_scale(0.5, vec3_add(p->jet.r, q->jet.r)));
    const double uv[2] = {(p->uv[0] + q->uv[0]) / 2, (p->uv[1] + q->uv[1]) / 2};
    const struct surface_point *from[] = {&middle, p, q};
    struct surface_point *to = &way->points[way->used++];
    bool made = surface_point_at(p->surface, c->cursor, uv, &middle), put = false;
    if (made && is_near(&middle, target, length)) {
        *to = middle;
        put = true;
    }
    for (int n = made ? 0 : 1; n < 3 && !put; n++)
        put = fishnet_pull_to(c->cursor, from[n], target, pull_share * length, PULLS, to) &&
              is_near(to, target, length);
    if (!put)
        return false;
    for (int n = way->pieces++; n > k; n--) {
        way->from[n] = way->from[n - 1];
        way->to[n] = way->to[n - 1];
        way->on[n] = way->on[n - 1];
        c->piece[n] = c->piece[n - 1];
        c->sound[n] = c->sound[n - 1];
    }
    way->to[k] = way->from[k + 1] = to;
    way->on[k + 1] = WAY_ALONG;
    return true;
}

/* ---- a straight line of pieces ---- */

/* The angles a_k at the points within, to the left, by their sines, and the moves x_k that take
 * them away. On a line or joint they are measured against that, on both sides of it. The largest
 * angle; infinite where there is no straight line, as pieces turn back. */
static double straighten(const struct logarithm_chain *c, double angle[], double move[]) {
    const struct way *way = &c->way;
    double most = 0, upper[WAY_PIECES], inverse[WAY_PIECES];
    for (int k = 0; k < way->pieces; k++)
        inverse[k] = 1 / c->piece[k].length;
    for (int k = 1; k < way->pieces; k++) {
        const struct surface_point *before = way->to[k - 1], *after = way->from[k];
        struct vec3 back = vec3_scale(-1, c->piece[k - 1].arrive), onward = c->piece[k].leave;
        bool goes_on = vec3_dot(onward, back) < 0;
        if (way->on[k] == WAY_ALONG) {
            angle[k] = vec3_dot(vec3_cross(onward, back), after->normal);
        } else {
            struct vec3 line[2];
            way_tangents(way, k, line);
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
    for (int k = way->pieces - 2; k >= 1; k--)
        move[k] += upper[k] * move[k + 1];
    return most;
}

/* Moves the points within to the left of the path, on a line or joint along that. */
static bool move_points(struct logarithm_chain *c, const double move[]) {
    struct way *way = &c->way;
    for (int k = 1; k < way->pieces; k++) {
        struct surface_point *here = way->from[k];
        struct vec3 along = surface_point_tangent(here, vec3_sub(way->to[k]->jet.r, here->jet.r));
        struct vec3 target = vec3_axpy(move[k], vec3_cross(here->normal, along), here->jet.r);
        if (way->on[k] != WAY_ALONG
                ? !way_slide(way, k, move[k])
                : !fishnet_pull_to(c->cursor, here, target, pull_share * c->piece[k].length, PULLS,
                                   here))
            return false;
    }
    for (int k = 0; k < way->pieces; k++) {
        if ((way->on[k] != WAY_ALONG || (k + 1 < way->pieces && way->on[k + 1] != WAY_ALONG)) &&
            !way_place_ends(way, k))
            return false;
    }
    for (int k = 0; k < way->pieces; k++)
        estimate_piece(c, k);
    return true;
}

/* Halves the pieces that are not known by their ends. */
static bool halve_pieces(struct logarithm_chain *c) {
    for (int k = 0; k < c->way.pieces;) {
        if (is_known(c, k)) {
            k++;
            continue;
        }
        if (!halve_piece(c, k))
            return false;
        estimate_piece(c, k);
        estimate_piece(c, k + 1);
    }
    return true;
}

/* Lays the way from p to q, or moves its end there. */
static bool lay_pieces(struct logarithm_chain *c, const struct surface_point *p,
                       const struct surface_point *q) {
    bool kept = c->way.pieces > 0 && way_move_end(&c->way, q);
    if (!surface_point_is_regular(p) || !surface_point_is_regular(q) || !(c->whole > 0) ||
        (!kept && !way_lay(c->cursor, p, q, &c->way)))
        return false;
    for (int k = kept ? c->way.pieces - 1 : 0; k < c->way.pieces; k++)
        estimate_piece(c, k);
    return halve_pieces(c);
}

bool logarithm_go_on(struct surface_cursor *cursor, struct logarithm_chain *c,
                     const struct surface_point *p, const struct surface_point *q, double accuracy,
                     struct logarithm *logarithm) {
    const struct way *way = &c->way;
    double angle[WAY_PIECES], move[WAY_PIECES + 1];
    c->cursor = cursor;
    c->accuracy = accuracy;
    c->whole = vec3_distance(p->jet.r, q->jet.r);
    if (!lay_pieces(c, p, q))
        return false;
    const struct surface_point *begin = way->from[0], *end = way->to[way->pieces - 1];
    for (int sweep = 0; way->pieces > 1; sweep++) {
        double most = straighten(c, angle, move);
        double gauss = fmax(fabs(surface_point_gauss_curvature(begin)),
                            fabs(surface_point_gauss_curvature(end)));
        if (most * (most + gauss * c->whole * c->whole) <= angle_share * sqrt(accuracy) &&
            most * most * (most + way_crease(way)) <= accuracy)
            break;
        if (!(most < 1) || sweep == SWEEPS || !move_points(c, move))
            return false;
    }
    /* The first and last pieces are turned by the moves that are left. */
    int last = way->pieces - 1;
    struct vec3 leave = c->piece[0].leave, arrive = c->piece[last].arrive;
    double left = last > 0 ? move[1] / c->piece[0].length : 0;
    double right = last > 0 ? move[last] / c->piece[last].length : 0;
    logarithm->length = c->piece[0].length;
    for (int k = 1; k < way->pieces; k++)
        logarithm->length += c->piece[k].length - angle[k] * move[k] / 2;
    leave = vec3_unit(vec3_axpy(left, vec3_cross(begin->normal, leave), leave));
    arrive = vec3_unit(vec3_axpy(-right, vec3_cross(end->normal, arrive), arrive));
    logarithm->leave = unfolding_turned(leave, begin->normal, p->normal);
    logarithm->arrive = unfolding_turned(arrive, end->normal, q->normal);
    return isfinite(logarithm->length);
}

bool logarithm_find(struct surface_cursor *cursor, const struct surface_point *p,
                    const struct surface_point *q, double accuracy, struct logarithm *logarithm) {
    struct logarithm_chain chain;
    chain.way.pieces = 0;
    return logarithm_go_on(cursor, &chain, p, q, accuracy, logarithm) && way_holds(&chain.way);
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
