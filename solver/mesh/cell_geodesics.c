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
    struct mesh_point at; /* its end, with the direction there */
    struct vec3 arrive;
    double sharpest;  /* as `mesh_path` */
    struct vec3 rate; /* of the end, as the direction turns about the normal: as on a developable */
};

/* Of the smooth surface, or of the triangle where there is none. */
static struct vec3 normal_at(const struct mesh_sheet *sheet, const struct mesh_point *at) {
    return sheet->smooth ? mesh_smooth_normal(sheet->smooth, at)
                         : sheet->mesh->normals[at->triangle];
}

static struct shot aim_shot(const struct mesh_sheet *sheet, const struct mesh_point *from,
                            struct vec3 way, double length) {
    struct shot shot = {.from = *from, .normal = normal_at(sheet, from), .length = length};
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

static enum mesh_path_end fire(const struct mesh_sheet *sheet, struct shot *shot) {
    struct mesh_smooth_path smooth;
    struct mesh_path flat;
    bool sets_off = sheet->smooth
                        ? mesh_smooth_path(&smooth, sheet->smooth, &shot->from, shot->direction,
                                           vec3_make(0, 0, 0))
                        : mesh_path_straight(&flat, sheet->mesh, &shot->from, shot->direction);
    if (!sets_off)
        return MESH_PATH_LOST;
    enum mesh_path_end end = sheet->smooth ? mesh_smooth_length(&smooth, shot->length)
                                           : mesh_path_length(&flat, shot->length);
    shot->at = sheet->smooth ? smooth.at : flat.at;
    shot->arrive = sheet->smooth ? smooth.direction : flat.direction;
    shot->sharpest = sheet->smooth ? 1 : flat.sharpest;
    shot->rate = vec3_scale(shot->length, vec3_cross(normal_at(sheet, &shot->at), shot->arrive));
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
static enum mesh_corner_end shoot_until_met(const struct mesh_sheet *sheet,
                                            const struct mesh_cell *cell, const struct vec3 back[2],
                                            struct shot b, struct shot c,
                                            struct mesh_corner *corner, struct mesh_yarns *yarns) {
    double shorter = fmin(cell->bd, cell->cd), least = HUGE_VAL;
    int stalled = 0;
    for (int k = 0; k < NEWTON_MAX; k++) {
        enum mesh_path_end end_b = fire(sheet, &b), end_c = fire(sheet, &c);
        yarns->sharpest = fmin(yarns->sharpest, fmin(b.sharpest, c.sharpest));
        corner->steps++;
        if (end_b == MESH_PATH_BOUNDARY || end_c == MESH_PATH_BOUNDARY)
            return MESH_CORNER_BOUNDARY;
        if (end_b != MESH_PATH_DONE || end_c != MESH_PATH_DONE)
            return MESH_CORNER_NO_CONVERGENCE;
        struct vec3 gap = vec3_sub(b.at.r, c.at.r);
        double size = vec3_norm(gap) / shorter;
        stalled = size < 0.5 * least ? 0 : stalled + 1;
        if (least <= settled && stalled == STALLED_MAX)
            break;
        if (size < least && leads_away(&b, back[0], -cell->orientation) &&
            leads_away(&c, back[1], cell->orientation)) {
            least = size;
            corner->at = c.at;
            corner->residual = size;
            /* both end in D's plane; b may have ended on the other side of a fold through D */
            const struct mesh_point *at_b = &b.at, *at_c = &c.at;
            const struct mesh_smooth *smooth = sheet->smooth;
            bool same = smooth && smooth->patch[at_b->triangle] == smooth->patch[at_c->triangle];
            yarns->start[0] = b.direction;
            yarns->start[1] = c.direction;
            yarns->end[0] =
                same ? b.arrive
                     : turn_over_fold(b.arrive, normal_at(sheet, at_b), normal_at(sheet, at_c));
            yarns->end[1] = c.arrive;
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

enum mesh_corner_end mesh_cell_geodesics(const struct mesh_sheet *sheet,
                                         const struct mesh_cell *cell, const struct vec3 back[2],
                                         struct mesh_corner *corner, struct mesh_yarns *yarns) {
    yarns->sharpest = 1;
    struct shot b = aim_shot(sheet, &cell->b, yarns->start[0], cell->bd);
    struct shot c = aim_shot(sheet, &cell->c, yarns->start[1], cell->cd);
    enum mesh_corner_end end = shoot_until_met(sheet, cell, back, b, c, corner, yarns);
    if (end == MESH_CORNER_FOUND)
        return end;
    b = aim_shot(sheet, &cell->b, vec3_sub(cell->guess, cell->b.r), cell->bd);
    c = aim_shot(sheet, &cell->c, vec3_sub(cell->guess, cell->c.r), cell->cd);
    return shoot_until_met(sheet, cell, back, b, c, corner, yarns);
}
