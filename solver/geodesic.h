/* SPDX-License-Identifier: MIT */
/*
 * Geodesics from a point in a direction: the straightest lines on the surface, the generators of
 * the net. In parameters, with a = r_uu p^2 + 2 r_uv p q + r_vv q^2 for the velocity (p, q),
 *
 *   u' = p,  v' = q,  (p', q') = -I^-1 (a . r_u, a . r_v)
 *
 * (paper, equations 33-36, with the Christoffel symbols multiplied out; I is the first fundamental
 * form). Each span is integrated as the analytic surface it is, and the line is carried over from
 * span to span by unfolding the two tangent planes about their common edge, so neither a crease
 * nor a jump of curvature costs accuracy.
 */
#ifndef DRAPE_GEODESIC_H
#define DRAPE_GEODESIC_H

#include "station.h"

/* A point moving on the surface at unit speed. */
struct geodesic {
    const struct surface *surface;
    double uv[2];       /* continuous: a closed direction is not wrapped */
    double velocity[2]; /* (p, q): r_u p + r_v q is the unit tangent */
    int span[2];
    double turn[2]; /* what to take off uv to be in the domain of the span */
    double ahead;   /* length already gone of the next advance: a pole is left with a small leap */
};

/* Sets off from `from` along the projection of `direction`. False when there is no such direction:
 * it is normal to the surface, or leads out of it at a pole. */
bool geodesic_start(struct geodesic *geodesic, const struct surface *surface,
                    const struct station *from, struct vec3 direction);

/* Moves on by `length` >= 0 to a relative accuracy of 1e-13 of `length`; on past open boundaries
 * over the continued surface. False when the line cannot be followed; the geodesic is then
 * unusable. */
bool geodesic_advance(struct geodesic *geodesic, double length);

/* The place where it is now, and which way it is going there (unit; may be NULL). False when the
 * surface has no tangent plane there. */
bool geodesic_station(const struct geodesic *geodesic, struct surface_cursor *cursor,
                      struct station *station, struct vec3 *tangent);

#endif
