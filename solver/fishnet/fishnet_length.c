/* SPDX-License-Identifier: MIT */
#include "fishnet_length.h"

#include "logarithm.h"
#include "solver/shell/crossing.h"

enum { ROUNDS = 8, BENDS = 3 };

/* The last step leaves less than this, by the edge's length. Where D is going to move by more,
 * lengths are measured roughly at first. */
static const double settled = 8e-10, first_accuracy = 1e-4;

/* Steps no larger than this, by the edge's length; and the least sine between the yarns. */
static const double longest_step = 0.3, least_sine = 0.05;

/* The step for which both lengths are right: a step beside a yarn, y, lengthens it by
 * y^2 (1 / L - K L / 3) / 2, K being the Gaussian curvature. False where the yarns are nearly
 * parallel. */
static bool find_length_step(const struct logarithm l[2], const struct surface_point *d,
                             const double miss[2], struct vec3 *step) {
    struct vec3 b = l[0].arrive, c = l[1].arrive;
    double sine = vec3_dot(vec3_cross(b, c), d->normal), left[2] = {miss[0], miss[1]};
    double gauss = surface_point_gauss_curvature(d);
    struct vec3 across_b = vec3_cross(d->normal, b), across_c = vec3_cross(d->normal, c);
    if (!(fabs(sine) > least_sine))
        return false;
    for (int bend = 0; bend < BENDS; bend++) {
        *step = vec3_axpy(left[1] / sine, across_b, vec3_scale(-left[0] / sine, across_c));
        double y[2] = {vec3_dot(*step, across_b), vec3_dot(*step, across_c)};
        for (int k = 0; k < 2; k++)
            left[k] = miss[k] - y[k] * y[k] * (1 / l[k].length - gauss * l[k].length / 3) / 2;
    }
    return true;
}

/* What the step to D, `size` by the edge's length, leaves: its cube and, as K is not the same all
 * along the edge, its square by a third of K L^2; over a crease, by which the normal turns, as much
 * as its chord is shorter. */
static double left_by(const struct surface_point *d, double size, double length,
                      struct vec3 normal) {
    double k = fabs(surface_point_gauss_curvature(d)) * length * length;
    return size * size * (size + k / 3) + size * (1 - vec3_dot(normal, d->normal));
}

/* Carries a D that has passed a joint to the face beyond; not past the end of one. */
static bool enter_face(struct surface_cursor *cursor, struct surface_point *d) {
    struct crossing joint;
    if (!d->surface->shell || crossing_within(d->surface, d->uv))
        return true;
    crossing_find(d, NULL, &joint);
    return joint.kind != CROSSING_JOINT || joint.at_corner || crossing_settle(cursor, d);
}

bool fishnet_length_meet(struct surface_cursor *cursor, const struct fishnet_cell *cell, double bd,
                         double cd, double accuracy, struct fishnet_yarns *yarns,
                         struct fishnet_node *node) {
    const struct surface_point *from[2] = {cell->b, cell->c};
    const double length[2] = {bd, cd};
    double least = fmin(bd, cd);
    struct logarithm l[2];
    struct logarithm_chain chain[2];
    struct vec3 step = {0, 0, 0};
    bool last = false, near = true;
    chain[0].way.pieces = chain[1].way.pieces = 0;
    /* Whether the first step will be the last, by lengths estimated from the ends of the edges. */
    for (int k = 0; k < 2 && near; k++) {
        struct rough_geodesic about;
        near = rough_estimate(from[k], &node->point, &about);
        double miss = fabs(about.length - length[k]) + about.error * length[k];
        near = near && left_by(&node->point, miss / least, least, node->point.normal) < settled;
    }
    for (int round = 0; round < ROUNDS && !last; round++) {
        double miss[2], asked = near ? accuracy : fmax(first_accuracy, accuracy);
        struct surface_point *d = &node->point;
        for (int k = 0; k < 2; k++) {
            if (!logarithm_go_on(cursor, &chain[k], from[k], d, asked, &l[k]))
                return false;
            miss[k] = length[k] - l[k].length;
        }
        node->iterations++;
        if (!find_length_step(l, d, miss, &step))
            return false;
        double size = vec3_norm(step) / least;
        struct vec3 normal = d->normal;
        const struct surface *face = d->surface;
        if (!(size < longest_step) || !surface_point_move(cursor, d, step, d) ||
            !enter_face(cursor, d))
            return false;
        node->residual = left_by(d, size, least, normal);
        last = asked <= accuracy && node->residual < settled && d->surface == face;
        near = true;
    }
    struct vec3 cross = vec3_cross(l[0].arrive, l[1].arrive);
    if (!last || !way_holds(&chain[0].way) || !way_holds(&chain[1].way) ||
        !(cell->orientation * vec3_dot(cross, node->point.normal) > 0))
        return false;
    for (int k = 0; k < 2; k++) {
        const struct surface_point *d = &node->point; /* each yarn turns as its end has moved */
        struct vec3 leave = l[k].leave, arrive = l[k].arrive;
        double angle = vec3_dot(step, vec3_cross(d->normal, arrive)) / l[k].length;
        yarns->start[k] = vec3_unit(vec3_axpy(angle, vec3_cross(from[k]->normal, leave), leave));
        yarns->end[k] =
            surface_point_tangent(d, vec3_axpy(angle, vec3_cross(d->normal, arrive), arrive));
    }
    return true;
}
