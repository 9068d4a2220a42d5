/* SPDX-License-Identifier: MIT */
#include "fishnet_collocation.h"

#include "rough.h"
#include "solver/path/collocation.h"

enum { ROUNDS = 12, PULLS = 3 };

/* Rounding of points, as a share of the surface's coordinates. */
static const double rounding = 4e-15;

/* No round moves a point by more than this share of the yarns; after the last there is this share
 * of the tolerance left. */
static const double farthest = 0.3, left_share = 0.25;

/* Into how many pieces the way between two knot lines is split, and further those with more than
 * this of the last terms of their bend: with 1e-5 one in five is wrong by 1e-11 of its length, with
 * 3e-7 one in fifty. Where that was not enough it is tried again. */
static const struct {
    int pieces;
    double rest;
} splits[] = {{1, 1e-5}, {1, 3e-7}, {2, 3e-7}};
enum { ATTEMPTS = sizeof splits / sizeof *splits };

/* Yarns that meet under less than this sine are nearly parallel: D is all but a double root. */
static const double least_sine = 1e-3;

/* Both yarns to D. */
struct yarns {
    struct collocation path[2];
    struct vec3 normal, by[2]; /* about D; how the end of each moves for each radian */
    double size[2];            /* of that */
    double angle[2];
};

/* A round: evaluates the yarns, splits pieces with more than `rest` of the last terms, and moves
 * all by the angles that let the ends meet. How far apart they were, or a point has moved; infinite
 * where the yarns get lost. */
static double move_yarns(struct yarns *y, double rest) {
    for (int k = 0; k < 2; k++) {
        bool split = false;
        if (!collocation_evaluate(&y->path[k]) ||
            (rest < HUGE_VAL && !collocation_refine(&y->path[k], rest, &split)) ||
            (split && !collocation_evaluate(&y->path[k])))
            return HUGE_VAL;
    }
    for (int k = 0; k < 2; k++)
        y->by[k] = vec3_scale(y->size[k], vec3_cross(y->normal, y->path[k].arrive));
    struct vec3 gap = vec3_sub(y->path[1].to, y->path[0].to);
    if (!fishnet_close_gap(y->by[0], y->by[1], gap, least_sine * least_sine, y->angle))
        return HUGE_VAL;
    double most = vec3_norm(gap);
    for (int k = 0; k < 2; k++)
        most = fmax(most, collocation_move(&y->path[k], y->angle[k]));
    return most;
}

/* How far the end of a geodesic of length d moves to the left for each radian of its direction: the
 * Jacobi field, by the mean of the Gaussian curvature at both ends. */
static double end_moves(const struct surface_point *from, const struct surface_point *to,
                        double d) {
    double k = (surface_point_gauss_curvature(from) + surface_point_gauss_curvature(to)) / 2;
    return d * (1 - fmin(k * d * d / 6, 0.5));
}

/* Rounds until the ends meet, as long as points move less from one to the next; moves `point` to
 * where they do, and counts them. */
static bool meet_yarns(struct surface_cursor *cursor, const struct fishnet_cell *cell,
                       const struct fishnet_collocation *wanted, int attempt, struct yarns *y,
                       struct surface_point *point, int *rounds) {
    struct surface_point pulled;
    const struct surface_point *d = point;
    double least = fmin(wanted->length[0], wanted->length[1]), last = farthest;
    double enough = wanted->tolerance * least + rounding * d->surface->magnitude;
    y->normal = d->normal;
    for (int k = 0; k < 2; k++) {
        const struct surface_point *from = k ? cell->c : cell->b;
        struct rough_geodesic about;
        (void)rough_estimate(from, d, &about);
        const struct vec3 tangent[2] = {about.leave, about.arrive};
        if (!collocation_begin(&y->path[k], from, d, tangent, wanted->length[k],
                               splits[attempt].pieces, wanted->lanes))
            return false;
        y->size[k] = end_moves(from, d, wanted->length[k]);
    }
    for (int round = 1; round <= ROUNDS; round++) {
        double moved = move_yarns(y, round == 1 ? splits[attempt].rest : HUGE_VAL) / least;
        double change = fmax(collocation_change(&y->path[0]), collocation_change(&y->path[1]));
        if (!(moved < last))
            return false;
        last = round == 1 ? farthest : moved / 2;
        if (!(moved * (change / 2 + moved) < left_share * wanted->tolerance))
            continue;
        /* D is where the ends meet; both may be so far above the surface there. */
        struct vec3 end[2];
        for (int k = 0; k < 2; k++)
            end[k] = vec3_axpy(y->angle[k], y->by[k], y->path[k].to);
        struct vec3 middle = vec3_scale(0.5, vec3_add(end[0], end[1]));
        struct vec3 left = surface_point_projection(d, vec3_sub(middle, d->jet.r));
        if (!(vec3_norm2(left) <= enough / 8 * (enough / 8))) {
            if (!fishnet_pull_to(cursor, d, middle, enough / 8, PULLS, &pulled))
                return false;
            d = &pulled;
        }
        double above = 0;
        for (int k = 0; k < 2; k++)
            above = fmax(above, fabs(vec3_dot(vec3_sub(end[k], d->jet.r), d->normal)));
        if (above < enough) {
            if (d != point)
                *point = pulled;
            *rounds += round;
            return collocation_is_whole(&y->path[0], point) &&
                   collocation_is_whole(&y->path[1], point);
        }
    }
    return false;
}

bool fishnet_collocation_solve(struct surface_cursor *cursor, const struct fishnet_cell *cell,
                               const struct fishnet_collocation *wanted,
                               struct fishnet_yarns *yarns, struct fishnet_node *node) {
    struct yarns y;
    struct surface_point found = node->point;
    int attempt = 0, rounds = 0;
    while (attempt < ATTEMPTS && !meet_yarns(cursor, cell, wanted, attempt, &y, &found, &rounds))
        attempt++;
    if (attempt == ATTEMPTS)
        return false;
    node->point = found;
    node->iterations += rounds;
    node->residual = wanted->tolerance;
    for (int k = 0; yarns && k < 2; k++) {
        yarns->start[k] = y.path[k].leave;
        yarns->end[k] = surface_point_tangent(&node->point, y.path[k].arrive);
    }
    return true;
}
