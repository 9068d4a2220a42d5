/* SPDX-License-Identifier: MIT */
/*
 * A station: a place on the surface with all the march needs to know there, and the ways to get
 * from one to another. Everything that is special about a place (the seam of a closed direction, a
 * pole, the continuation beyond the boundary) is settled here, so that the march can think in
 * space.
 */
#ifndef DRAPE_STATION_H
#define DRAPE_STATION_H

#include "drape.h"
#include "surface_spans.h"

struct station {
    double uv[2]; /* continuous along the net: a closed direction is not wrapped */
    struct surface_jet jet;
    struct vec3 normal; /* unit, r_u x r_v; its limit at a pole; zero where there is none */
    double first[3];    /* E, F, G: r_u.r_u, r_u.r_v, r_v.r_v */
    double second[3];   /* L, M, N: r_uu, r_uv, r_vv times the normal */
};

/* Where (u, v) lies, from the net's point of view the better first. */
enum station_zone {
    STATION_INSIDE,
    STATION_GHOST, /* on the continuation, while that is healthy */
    STATION_BEYOND
};

/* Evaluates at uv. False when the surface has no tangent plane there. */
bool station_at(const struct surface *surface, struct surface_cursor *cursor, const double uv[2],
                struct station *station);

/* Completes a station whose uv and jet are set. False as above. */
bool station_complete(const struct surface *surface, struct station *station);

/* Whether r_u or r_v vanishes at a station that is complete. */
bool station_at_pole(const struct surface *surface, const struct station *station);

/* The parameters of the surface point next to `from` displaced by `step` in space, |step| small
 * against the radii of curvature: to second order in |step| away from poles, to first order near
 * one, where it goes through the pole. False when that is impossible (across a pole's open side);
 * uv is then that of `from`. */
bool station_pull(const struct surface *surface, struct surface_cursor *cursor,
                  const struct station *from, struct vec3 step, double uv[2]);

/* The distance from `point` to the nearest pole, and that pole; infinite when there is none. */
double station_pole_distance(const struct surface *surface, struct vec3 point, struct vec3 *pole);

/* Components (a, b) of the projection of `direction` on the tangent plane: r_u a + r_v b. False
 * where r_u and r_v are parallel. */
bool station_components(const struct station *station, struct vec3 direction, double ab[2]);

/* `direction` projected on the tangent plane, unit; zero when it is normal to the surface. */
struct vec3 station_tangent(const struct station *station, struct vec3 direction);

/* Normal curvature II(t, t) / I(t, t) in the direction t of the projection of `direction`
 * (paper, equation 12), in 1 / length, positive where the surface bends towards the normal. 0
 * where there is none. */
double station_normal_curvature(const struct station *station, struct vec3 direction);

/* Round a closed direction k that no pole closes, the net is cut open half a turn from its start:
 * that much in its parameter; HUGE_VAL for other directions. */
double station_cut_turn(const struct surface *surface, int k);

/* The zone of a station and, unless it is inside, why the net ends there. `start` is where the net
 * began: round a closed direction that no pole closes, the net ends half a period from it on either
 * side, where it would meet itself. */
enum station_zone station_zone(const struct surface *surface, struct surface_cursor *cursor,
                               const double start[2], const struct station *station,
                               enum drape_reason *reason);

#endif
