/* SPDX-License-Identifier: MIT */
#include "smooth_corner.h"

#include "smooth_path.h"

enum { NEWTON_MAX = 12, STALLED_MAX = 2 };

/* The gap wanted, relative to the lengths, that at which it is not worth while to go on, and that
 * still taken: as their directions turn, ends of geodesics jump by the steps of their integration,
 * the most over folds. The largest turn of a step, in radians. */
static const double wanted = 1e-11, settled = 1e-5, taken = 1e-4, turn_most = 0.3;

/* A geodesic of a given length in a direction that Newton's method turns. */
struct shot {
    struct mesh_point from;
    struct vec3 normal, direction; /* there; unit */
    double length;
    struct mesh_smooth_path end;
    struct vec3 rate; /* of the end, as the direction turns about the normal: as on a developable */
};

static struct shot aim_shot(const struct mesh_smooth *smooth, const struct mesh_point *from,
                            struct vec3 way, double length) {
    struct shot shot = {
        .from = *from, .normal = mesh_smooth_normal(smooth, from), .length = length};
    shot.direction = vec3_unit(vec3_axpy(-vec3_dot(way, shot.normal), shot.normal, way));
    return shot;
}

/* A tangent at one point as it is at another over a fold: turned as the one normal turns into the
 * other (Rodrigues), which unfolds a straight fold. */
static struct vec3 turn_over_fold(struct vec3 v, struct vec3 from, struct vec3 to) {
    struct vec3 axis = vec3_unit(vec3_cross(from, to));
    double cosine = vec3_dot(from, to), sine = vec3_norm(vec3_cross(from, to));
    struct vec3 turned = vec3_axpy(sine, vec3_cross(axis, v), vec3_scale(cosine, v));
    return vec3_axpy((1 - cosine) * vec3_dot(axis, v), axis, turned);
}

static enum mesh_path_end fire(const struct mesh_smooth *smooth, struct shot *shot) {
    if (!mesh_smooth_path(&shot->end, smooth, &shot->from, shot->direction, vec3_make(0, 0, 0)))
        return MESH_PATH_LOST;
    enum mesh_path_end end = mesh_smooth_length(&shot->end, shot->length);
    struct vec3 normal = mesh_smooth_normal(smooth, &shot->end.at);
    shot->rate = vec3_scale(shot->length, vec3_cross(normal, shot->end.direction));
    return end;
}

/* Turns by a small angle, to second order, which is as good as any. */
static void turn_shot(struct shot *shot, double angle) {
    angle = fmin(fmax(angle, -turn_most), turn_most);
    struct vec3 across = vec3_cross(shot->normal, shot->direction);
    shot->direction = vec3_unit(vec3_axpy(angle, across, shot->direction));
}

/* Whether a geodesic from a corner beside A, to which a yarn leaves there as `back`, leads away
 * from A, which is to the left of it when `left` is 1. */
static bool leads_away(const struct shot *shot, struct vec3 back, int left) {
    return left * vec3_dot(vec3_cross(shot->direction, back), shot->normal) > 0;
}

/* Newton's method from two directions on. */
static enum mesh_corner_end shoot_until_met(const struct mesh_smooth *smooth,
                                            const struct mesh_cell *cell, const struct vec3 back[2],
                                            struct shot b, struct shot c,
                                            struct mesh_corner *corner, struct mesh_yarns *yarns) {
    double shorter = fmin(cell->bd, cell->cd), least = HUGE_VAL;
    int stalled = 0;
    for (int k = 0; k < NEWTON_MAX; k++) {
        enum mesh_path_end end_b = fire(smooth, &b), end_c = fire(smooth, &c);
        corner->steps++;
        if (end_b == MESH_PATH_BOUNDARY || end_c == MESH_PATH_BOUNDARY)
            return MESH_CORNER_BOUNDARY;
        if (end_b != MESH_PATH_DONE || end_c != MESH_PATH_DONE)
            return MESH_CORNER_NO_CONVERGENCE;
        struct vec3 gap = vec3_sub(b.end.at.r, c.end.at.r);
        double size = vec3_norm(gap) / shorter;
        stalled = size < 0.5 * least ? 0 : stalled + 1;
        if (least <= settled && stalled == STALLED_MAX)
            break;
        if (size < least && leads_away(&b, back[0], -cell->orientation) &&
            leads_away(&c, back[1], cell->orientation)) {
            least = size;
            corner->at = c.end.at;
            corner->residual = size;
            /* both end in D's plane; b may have ended on the other side of a fold through D */
            const struct mesh_point *at_b = &b.end.at, *at_c = &c.end.at;
            bool same = smooth->patch[at_b->triangle] == smooth->patch[at_c->triangle];
            yarns->start[0] = b.direction;
            yarns->start[1] = c.direction;
            yarns->end[0] = same ? b.end.direction
                                 : turn_over_fold(b.end.direction, mesh_smooth_normal(smooth, at_b),
                                                  mesh_smooth_normal(smooth, at_c));
            yarns->end[1] = c.end.direction;
        }
        if (least <= wanted)
            break;
        /* turns by the angles that close the gap, to first order, by least squares */
        double bb = vec3_norm2(b.rate), cc = vec3_norm2(c.rate), bc = vec3_dot(b.rate, c.rate);
        double gb = vec3_dot(gap, b.rate), gc = vec3_dot(gap, c.rate);
        double determinant = bb * cc - bc * bc;
        if (!(determinant > 1e-4 * bb * cc))
            return MESH_CORNER_COLLAPSED;
        turn_shot(&b, (bc * gc - cc * gb) / determinant);
        turn_shot(&c, (bb * gc - bc * gb) / determinant);
    }
    return least <= taken ? MESH_CORNER_FOUND : MESH_CORNER_NO_CONVERGENCE;
}

enum mesh_corner_end mesh_smooth_geodesics(const struct mesh_smooth *smooth,
                                           const struct mesh_cell *cell, const struct vec3 back[2],
                                           struct mesh_corner *corner, struct mesh_yarns *yarns) {
    struct shot b = aim_shot(smooth, &cell->b, yarns->start[0], cell->bd);
    struct shot c = aim_shot(smooth, &cell->c, yarns->start[1], cell->cd);
    enum mesh_corner_end end = shoot_until_met(smooth, cell, back, b, c, corner, yarns);
    if (end == MESH_CORNER_FOUND)
        return end;
    b = aim_shot(smooth, &cell->b, vec3_sub(cell->guess, cell->b.r), cell->bd);
    c = aim_shot(smooth, &cell->c, vec3_sub(cell->guess, cell->c.r), cell->cd);
    return shoot_until_met(smooth, cell, back, b, c, corner, yarns);
}
