/* SPDX-License-Identifier: MIT */
#include "fishnet_length.h"

#include "logarithm.h"

enum { ROUNDS = 8 };

/* A step whose square, by the edge's length, is less than this is the last: that is about what it
 * leaves. */
static const double settled_square = 1e-13;

/* Steps no larger than this, by the edge's length; and the least sine between the yarns. */
static const double longest_step = 0.3, least_sine = 0.05;

/* The step for which both lengths are right; false where the yarns are nearly parallel. */
static bool find_step(const struct logarithm l[2], const struct station *d, const double miss[2],
                      struct vec3 *step) {
    struct vec3 b = l[0].arrive, c = l[1].arrive;
    double sine = vec3_dot(vec3_cross(b, c), d->normal);
    if (!(fabs(sine) > least_sine))
        return false;
    struct vec3 across_b = vec3_cross(d->normal, b), across_c = vec3_cross(d->normal, c);
    *step = vec3_axpy(miss[1] / sine, across_b, vec3_scale(-miss[0] / sine, across_c));
    return true;
}

/* Turns a yarn whose end moves by `step`. */
static void turn_yarn(const struct station *from, const struct station *d, struct vec3 step,
                      struct logarithm *l) {
    double angle = vec3_dot(step, vec3_cross(d->normal, l->arrive)) / l->length;
    l->leave = vec3_unit(vec3_axpy(angle, vec3_cross(from->normal, l->leave), l->leave));
    l->arrive = station_tangent(d, vec3_axpy(angle, vec3_cross(d->normal, l->arrive), l->arrive));
}

bool fishnet_length_meet(struct surface_cursor *cursor, const struct fishnet_cell *cell, double bd,
                         double cd, double accuracy, struct fishnet_yarns *yarns,
                         struct fishnet_node *node) {
    const struct station *from[2] = {cell->b, cell->c};
    const double length[2] = {bd, cd};
    double least = fmin(bd, cd);
    struct logarithm l[2];
    struct vec3 step = {0, 0, 0};
    bool settled = false;
    for (int round = 0; round < ROUNDS && !settled; round++) {
        double miss[2], uv[2];
        struct station *d = &node->station;
        for (int k = 0; k < 2; k++) {
            if (!logarithm_find(cursor, from[k], d, accuracy, &l[k]))
                return false;
            miss[k] = length[k] - l[k].length;
        }
        node->iterations++;
        if (!find_step(l, d, miss, &step))
            return false;
        double size = vec3_norm(step) / least;
        settled = size * size < settled_square;
        if (!(size < longest_step) || !station_pull(d->surface, cursor, d, step, uv) ||
            !station_at(d->surface, cursor, uv, d))
            return false;
        node->residual = size * size;
    }
    struct vec3 cross = vec3_cross(l[0].arrive, l[1].arrive);
    if (!settled || !(cell->orientation * vec3_dot(cross, node->station.normal) > 0))
        return false;
    for (int k = 0; k < 2; k++) {
        turn_yarn(from[k], &node->station, step, &l[k]);
        yarns->start[k] = l[k].leave;
        yarns->end[k] = l[k].arrive;
    }
    return true;
}
