/* SPDX-License-Identifier: MIT */
#include "fishnet_collocation.h"

#include "rough.h"
#include "solver/path/collocation.h"

enum { TURNS = 12, PULLS = 4 };

/* Rounding of places, as a share of the surface's coordinates. */
static const double rounding = 4e-15;

/* No turn moves a place by more than this share of the yarns; after the last there is this share of
 * the tolerance left. */
static const double farthest = 0.3, left_share = 0.25;

/* Into how many parts pieces between knot lines are cut, and further those with more than this of
 * the last terms of their bend: with 1e-5 one in five is wrong by 1e-11 of its length, with 3e-7
 * one in fifty. Where that was not enough it is tried again. */
static const struct {
    int parts;
    double rest;
} cuts[] = {{1, 1e-5}, {1, 3e-7}, {2, 3e-7}};
enum { ATTEMPTS = sizeof cuts / sizeof *cuts };

/* Yarns that meet under less than this sine are nearly parallel: D is all but a double root. */
static const double least_sine = 1e-3;

/* How far the end moves to the left for each radian of the direction: the Jacobi field. */
static double end_moves(const struct surface_point *from, const struct surface_point *to,
                        double d) {
    double k = (surface_point_gauss_curvature(from) + surface_point_gauss_curvature(to)) / 2;
    return d * (1 - fmin(k * d * d / 6, 0.5));
}

/* The point nearest to the point `target`, from the one that is there. */
static bool pull_to(struct surface_cursor *cursor, struct vec3 target, double enough,
                    struct surface_point *point) {
    for (int pull = 0; pull < PULLS; pull++) {
        double uv[2];
        struct vec3 step = vec3_sub(target, point->jet.r);
        if (vec3_norm2(surface_point_projection(point, step)) <= enough * enough)
            return true;
        if (!surface_point_pull(point->surface, cursor, point, step, uv) ||
            !surface_point_at(point->surface, cursor, uv, point))
            return false;
    }
    return false;
}

/* Both yarns to D. */
struct yarns {
    struct collocation path[2];
    struct vec3 normal, by[2]; /* about D; how the end of each moves for each radian */
    double size[2];            /* of that */
    double angle[2];
};

static bool begin(const struct fishnet_cell *cell, const struct fishnet_collocation *wanted,
                  int parts, const struct surface_point *d, struct yarns *y) {
    y->normal = d->normal;
    for (int k = 0; k < 2; k++) {
        const struct surface_point *from = k ? cell->c : cell->b;
        struct rough_geodesic about;
        (void)rough_estimate(from, d, &about);
        const struct vec3 tangent[2] = {about.leave, about.arrive};
        if (!collocation_begin(&y->path[k], from, d, tangent, wanted->length[k], parts,
                               wanted->lanes))
            return false;
        y->size[k] = end_moves(from, d, wanted->length[k]);
    }
    return true;
}

/* The first half of a turn; cuts pieces with more than `rest` of the last terms. */
static bool lay(struct yarns *y, double rest) {
    for (int k = 0; k < 2; k++) {
        bool cut = false;
        if (!collocation_evaluate(&y->path[k]) ||
            (rest < HUGE_VAL && !collocation_refine(&y->path[k], rest, &cut)) ||
            (cut && !collocation_evaluate(&y->path[k])))
            return false;
    }
    return true;
}

/* The other, with the angles that let the ends meet; how far apart they were, or a place has moved.
 */
static double turn(struct yarns *y) {
    double most;
    for (int k = 0; k < 2; k++)
        y->by[k] = vec3_scale(y->size[k], vec3_cross(y->normal, y->path[k].arrive));
    struct vec3 b = y->by[0], c = y->by[1], normal = vec3_cross(b, c);
    struct vec3 gap = vec3_sub(y->path[1].to, y->path[0].to);
    double area2 = vec3_norm2(normal);
    if (!(area2 > least_sine * least_sine * vec3_norm2(b) * vec3_norm2(c)))
        return HUGE_VAL;
    y->angle[0] = vec3_dot(vec3_cross(gap, c), normal) / area2;
    y->angle[1] = vec3_dot(vec3_cross(gap, b), normal) / area2;
    most = vec3_norm(gap);
    for (int k = 0; k < 2; k++)
        most = fmax(most, collocation_move(&y->path[k], y->angle[k]));
    return most;
}

/* Where the ends meet after the last turn: D, and how far both ends are above the surface there. */
static bool meet(struct surface_cursor *cursor, const struct yarns *y, double enough,
                 struct surface_point *d, double *above) {
    struct vec3 end[2];
    for (int k = 0; k < 2; k++)
        end[k] = vec3_axpy(y->angle[k], y->by[k], y->path[k].to);
    if (!pull_to(cursor, vec3_scale(0.5, vec3_add(end[0], end[1])), enough / 8, d))
        return false;
    *above = 0;
    for (int k = 0; k < 2; k++)
        *above = fmax(*above, fabs(vec3_dot(vec3_sub(end[k], d->jet.r), d->normal)));
    return true;
}

/* Turns until the ends meet, as long as places move less from turn to turn. */
static bool meet_in(struct surface_cursor *cursor, const struct fishnet_cell *cell,
                    const struct fishnet_collocation *wanted, int attempt, struct yarns *y,
                    struct fishnet_node *node) {
    struct surface_point d = node->point;
    double least = fmin(wanted->length[0], wanted->length[1]), above, last = farthest;
    double enough = wanted->tolerance * least + rounding * d.surface->magnitude;
    if (!begin(cell, wanted, cuts[attempt].parts, &d, y))
        return false;
    for (int turns = 1; turns <= TURNS; turns++) {
        double moved =
            lay(y, turns == 1 ? cuts[attempt].rest : HUGE_VAL) ? turn(y) / least : HUGE_VAL;
        double change = fmax(collocation_change(&y->path[0]), collocation_change(&y->path[1]));
        if (!(moved < last))
            return false;
        last = turns == 1 ? farthest : moved / 2;
        if (!(moved * (change / 2 + moved) < left_share * wanted->tolerance))
            continue;
        if (!meet(cursor, y, enough, &d, &above))
            return false;
        if (above < enough) {
            node->point = d;
            node->iterations += turns;
            node->residual = wanted->tolerance;
            return collocation_is_whole(&y->path[0], &d) && collocation_is_whole(&y->path[1], &d);
        }
    }
    return false;
}

bool fishnet_collocation_solve(struct surface_cursor *cursor, const struct fishnet_cell *cell,
                               const struct fishnet_collocation *wanted,
                               struct fishnet_yarns *yarns, struct fishnet_node *node) {
    struct yarns y;
    struct fishnet_node found = *node;
    int attempt = 0;
    while (attempt < ATTEMPTS && !meet_in(cursor, cell, wanted, attempt, &y, &found))
        attempt++;
    if (attempt == ATTEMPTS)
        return false;
    *node = found;
    for (int k = 0; yarns && k < 2; k++) {
        yarns->start[k] = y.path[k].leave;
        yarns->end[k] = surface_point_tangent(&node->point, y.path[k].arrive);
    }
    return true;
}
