/* SPDX-License-Identifier: MIT */
#include "fishnet_geodesic.h"

#include "path.h"

enum { ROUNDS = 30 };

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

enum fishnet_end fishnet_geodesic_solve(const struct surface *surface,
                                        struct surface_cursor *cursor,
                                        const struct fishnet_cell *cell, double bd, double cd,
                                        struct fishnet_node *node) {
    struct ray b = aim(cell->b, bd, node->station.jet.r);
    struct ray c = aim(cell->c, cd, node->station.jet.r);
    double least = fmin(bd, cd), previous = HUGE_VAL;
    double enough = tolerance + rounding * surface->magnitude / least;
    for (int round = 0; round < ROUNDS; round++) {
        double x, y;
        if (!shoot(surface, cursor, &b) || !shoot(surface, cursor, &c))
            return FISHNET_NO_CONVERGENCE;
        struct vec3 gap = vec3_sub(c.end.jet.r, b.end.jet.r);
        node->residual = vec3_norm(gap) / least;
        node->iterations++;
        if (node->residual <= enough) {
            node->station = b.end;
            return fishnet_right_root(cell, &node->station) ? FISHNET_FOUND
                                                            : FISHNET_NO_CONVERGENCE;
        }
        if (!(node->residual < 4 * previous))
            return FISHNET_NO_CONVERGENCE;
        previous = node->residual;
        if (!solve_angles(jacobi_field(&b), jacobi_field(&c), gap, &x, &y))
            return FISHNET_COLLAPSED;
        turn(&b, x);
        turn(&c, y);
    }
    return FISHNET_NO_CONVERGENCE;
}
