/* SPDX-License-Identifier: MIT */
/*
 * A point: a place on the surface with all the march needs to know there, and the ways to get
 * from one to another. Everything that is special about a place (the seam of a closed direction, a
 * pole, the continuation beyond the boundary) is settled here, so that the march can think in
 * space.
 */
#ifndef SOLVER_SHELL_STATION_H
#define SOLVER_SHELL_STATION_H

#include "solver/reason.h"
#include "solver/surface/spans.h"

struct surface_point {
    const struct surface *surface; /* that uv are parameters of; NULL on a mesh */
    double uv[2];                  /* continuous along the net: a closed direction is not wrapped */
    struct surface_jet jet;
    struct vec3 normal; /* unit, along r_u x r_v or, on faces of a shell that are turned round,
                           against it; its limit at a pole; zero where there is none */
    double first[3];    /* E, F, G: r_u.r_u, r_u.r_v, r_v.r_v */
    double second[3];   /* L, M, N: r_uu, r_uv, r_vv times the normal */
};

/* Where (u, v) lies, from the net's point of view the better first. */
enum surface_point_zone {
    SURFACE_POINT_INSIDE,
    SURFACE_POINT_GHOST, /* on the continuation, while that is healthy */
    SURFACE_POINT_BEYOND
};

/* Evaluates at uv. False when the surface has no tangent plane there. */
bool surface_point_at(const struct surface *surface, struct surface_cursor *cursor,
                      const double uv[2], struct surface_point *point);

/* Completes a point whose uv and jet are set. False as above. */
bool surface_point_complete(const struct surface *surface, struct surface_point *point);

/* Whether r_u or r_v vanishes at a point that is complete. */
bool surface_point_at_pole(const struct surface *surface, const struct surface_point *point);

/* The parameters of the surface point next to `from` displaced by `step` in space, |step| small
 * against the radii of curvature: to second order in |step| away from poles, to first order near
 * one, where it goes through the pole. False when that is impossible (across a pole's open side);
 * uv is then that of `from`. */
bool surface_point_pull(const struct surface *surface, struct surface_cursor *cursor,
                        const struct surface_point *from, struct vec3 step, double uv[2]);

/* The distance from `point` to the nearest pole, and that pole; infinite when there is none. */
double surface_point_pole_distance(const struct surface *surface, struct vec3 point,
                                   struct vec3 *pole);

/* Whether a pole is nearer to a point than the square root of `distance2`. */
static inline bool surface_point_near_pole(const struct surface *surface, struct vec3 point,
                                           double distance2) {
    bool near = false;
    for (int k = 0; surface->has_poles && k < 4; k++) {
        const struct surface_axis *axis = &surface->axis[k / 2];
        near = near || (axis->pole[k % 2] &&
                        vec3_norm2(vec3_sub(point, axis->pole_point[k % 2])) < distance2);
    }
    return near;
}

/* Round a closed direction k that no pole closes, the net is cut open half a turn from its centre:
 * that much in its parameter; HUGE_VAL for other directions. */
double surface_point_cut_turn(const struct surface *surface, int k);

/* A node this close outside the domain, as a share of the domain and of the surface's size, is on
 * its boundary. */
#define SURFACE_POINT_BOUNDARY_WIDTH 1e-9

/* The zone of a point of a surface alone and, unless it is inside, why the net ends there. Round
 * a closed direction that no pole closes, the net ends half a period from `centre` on either side,
 * where it would meet itself. */
enum surface_point_zone surface_point_zone(const struct surface *surface,
                                           struct surface_cursor *cursor, const double centre[2],
                                           const struct surface_point *point,
                                           enum drape_reason *reason);

/* The same on a face of a shell: inside as far as the face or a joint of it reaches, by what was
 * found between the point and its face (`crossing.h`). */
struct crossing;
enum surface_point_zone surface_point_zone_on_face(struct surface_cursor *cursor,
                                                   const struct surface_point *point,
                                                   const struct crossing *crossing);

/* ---- the tangent plane: inline, because every node needs it several times ---- */

/* Tangents this nearly parallel (sine of their angle) span no tangent plane. */
#define SURFACE_POINT_PARALLEL 1e-9

/* With E, F, G the first fundamental form and (p, q) = direction . (r_u, r_v), the components are
 * (G p - F q, E q - F p) / (E G - F^2); this is the numerator. */
static inline void surface_point_scaled_components(const struct surface_point *point,
                                                   struct vec3 direction, double ab[2]) {
    const double *first = point->first;
    double p = vec3_dot(direction, point->jet.u), q = vec3_dot(direction, point->jet.v);
    ab[0] = first[2] * p - first[1] * q;
    ab[1] = first[0] * q - first[1] * p;
}

static inline double surface_point_determinant(const struct surface_point *point) {
    return point->first[0] * point->first[2] - point->first[1] * point->first[1];
}

/* Whether r_u and r_v are not parallel; written so that NaN says no. */
static inline bool surface_point_is_regular(const struct surface_point *point) {
    double least =
        SURFACE_POINT_PARALLEL * SURFACE_POINT_PARALLEL * point->first[0] * point->first[2];
    return surface_point_determinant(point) > least;
}

/* Components (a, b) of the projection of `direction` on the tangent plane: r_u a + r_v b. False
 * where r_u and r_v are parallel. */
static inline bool surface_point_components(const struct surface_point *point,
                                            struct vec3 direction, double ab[2]) {
    if (!surface_point_is_regular(point))
        return false;
    double inverse = 1 / surface_point_determinant(point);
    surface_point_scaled_components(point, direction, ab);
    ab[0] *= inverse;
    ab[1] *= inverse;
    return true;
}

/* `direction` projected on the tangent plane, zero when it is normal to the surface; and that as a
 * unit vector. */
static inline struct vec3 surface_point_projection(const struct surface_point *point,
                                                   struct vec3 direction) {
    double along = vec3_dot(direction, point->normal);
    return vec3_axpy(-along, point->normal, direction);
}

static inline struct vec3 surface_point_tangent(const struct surface_point *point,
                                                struct vec3 direction) {
    return vec3_unit(surface_point_projection(point, direction));
}

/* a^2, 2 a b, b^2 weighted by a fundamental form */
static inline double surface_point_form(const double coefficients[3], const double ab[2]) {
    return ab[0] * ab[0] * coefficients[0] + 2 * ab[0] * ab[1] * coefficients[1] +
           ab[1] * ab[1] * coefficients[2];
}

/* Normal curvature II(t, t) / I(t, t) in the direction t of the projection of `direction`
 * (paper, equation 12), in 1 / length, positive where the surface bends towards the normal; a ratio
 * of forms, so that the length of t does not matter. 0 where there is none. */
static inline double surface_point_normal_curvature(const struct surface_point *point,
                                                    struct vec3 direction) {
    double ab[2];
    surface_point_scaled_components(point, direction, ab);
    double length2 = surface_point_form(point->first, ab);
    bool good = surface_point_is_regular(point) && length2 > 0;
    return good ? surface_point_form(point->second, ab) / length2 : 0;
}

/* Gaussian curvature, det II / det I. */
static inline double surface_point_gauss_curvature(const struct surface_point *point) {
    const double *second = point->second;
    return (second[0] * second[2] - second[1] * second[1]) / surface_point_determinant(point);
}

#endif
