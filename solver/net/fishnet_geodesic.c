/* SPDX-License-Identifier: MIT */
#include "fishnet_geodesic.h"

#include "solver/surface/path.h"

enum { ROUNDS = 30, HALVINGS_MAX = 8 };

/* How far the two ends may be apart, against the shorter length, and where rounding hides it. */
static const double tolerance = 1e-11;
static const double rounding = 4e-15;

/* A geodesic of fixed length from a corner of the cell. */
struct ray {
    const struct station *from;
    double length;
    struct vec3 direction; /* at its start: unit, tangential */
    struct station end;
    struct vec3 end_tangent;
};

static bool shoot(const struct surface *surface, struct surface_cursor *cursor, struct ray *ray) {
    struct path geodesic;
    return path_geodesic(&geodesic, surface, ray->from, ray->direction) &&
           path_advance(&geodesic, ray->length) &&
           path_station(&geodesic, cursor, &ray->end, &ray->end_tangent);
}

static double gaussian_curvature(const struct station *station) {
    const double *i = station->first, *ii = station->second;
    double area2 = i[0] * i[2] - i[1] * i[1];
    return area2 > 0 ? (ii[0] * ii[2] - ii[1] * ii[1]) / area2 : 0;
}

/* How the end moves for each radian of the direction about the normal. */
static struct vec3 jacobi_field(const struct ray *ray) {
    double d = ray->length;
    double k = (gaussian_curvature(ray->from) + gaussian_curvature(&ray->end)) / 2;
    double size = d * (1 - fmin(k * d * d / 6, 0.5));
    return vec3_scale(size, vec3_cross(ray->end.normal, ray->end_tangent));
}

static void turn(struct ray *ray, double angle) {
    struct vec3 across = vec3_cross(ray->from->normal, ray->direction);
    ray->direction = vec3_unit(vec3_axpy(angle, across, ray->direction));
}

/* The angles for which x b - y c = gap, in the least-squares sense of the tangent plane. */
static bool solve_angles(struct vec3 b, struct vec3 c, struct vec3 gap, double *x, double *y) {
    struct vec3 normal = vec3_cross(b, c);
    double area2 = vec3_norm2(normal);
    if (!(area2 > 1e-12 * vec3_norm2(b) * vec3_norm2(c)))
        return false;
    *x = vec3_dot(vec3_cross(gap, c), normal) / area2;
    *y = vec3_dot(vec3_cross(gap, b), normal) / area2;
    return true;
}

/* The direction at a corner in which a geodesic leaves towards `point`, at first the chord's. */
static struct ray aim(const struct station *from, double length, struct vec3 point) {
    return (struct ray){.from = from,
                        .length = length,
                        .direction = station_tangent(from, vec3_sub(point, from->jet.r))};
}

/* Both geodesics with their angles changed by x and y. False when one cannot be followed. */
static bool shoot_both(const struct surface *surface, struct surface_cursor *cursor,
                       struct ray pair[2], double x, double y) {
    turn(&pair[0], x);
    turn(&pair[1], y);
    return shoot(surface, cursor, &pair[0]) && shoot(surface, cursor, &pair[1]);
}

static struct vec3 gap_between(const struct ray pair[2]) {
    return vec3_sub(pair[1].end.jet.r, pair[0].end.jet.r);
}

/* Where the yarns are nearly parallel, D is nearly a double root: it is lost when the cell
 * collapses, and close to that Newton may go to its twin on the side of A. A step that does not
 * reduce the gap or leaves the right side is therefore halved. */
enum fishnet_end fishnet_geodesic_solve(const struct surface *surface,
                                        struct surface_cursor *cursor,
                                        const struct fishnet_cell *cell, double bd, double cd,
                                        struct fishnet_node *node) {
    struct ray pair[2] = {aim(cell->b, bd, node->station.jet.r),
                          aim(cell->c, cd, node->station.jet.r)};
    double least = fmin(bd, cd), x = 0, y = 0;
    double enough = tolerance + rounding * surface->magnitude / least;
    if (!shoot_both(surface, cursor, pair, 0, 0))
        return FISHNET_NO_CONVERGENCE;
    double gap = vec3_norm(gap_between(pair)) / least;
    for (int round = 0, halvings = 0; round < ROUNDS && halvings < HALVINGS_MAX; round++) {
        struct ray next[2] = {pair[0], pair[1]};
        node->residual = gap;
        node->iterations++;
        if (gap <= enough) {
            node->station = pair[0].end;
            return FISHNET_FOUND;
        }
        if (halvings == 0 && !solve_angles(jacobi_field(&pair[0]), jacobi_field(&pair[1]),
                                           gap_between(pair), &x, &y))
            break;
        double closer = HUGE_VAL;
        if (shoot_both(surface, cursor, next, x, y))
            closer = vec3_norm(gap_between(next)) / least;
        if (closer < gap && fishnet_right_root(cell, &next[0].end)) {
            pair[0] = next[0];
            pair[1] = next[1];
            gap = closer;
            halvings = 0;
        } else {
            x /= 2;
            y /= 2;
            halvings++;
        }
    }
    return fishnet_has_collapsed(cell) ? FISHNET_COLLAPSED : FISHNET_NO_CONVERGENCE;
}
