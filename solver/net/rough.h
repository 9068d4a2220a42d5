/* SPDX-License-Identifier: MIT */
/*
 * Rough edges: pieces of yarn between two nodes over which the surface bends unevenly, or not a
 * little: a fillet no longer than a spacing, a crease, a joint where the curvature jumps. What a
 * method takes a smooth edge for (an arc of the curvature at one end, a second difference) does not
 * hold there; the yarn is its geodesic, of the spacing's length.
 *
 * An arc of curvature k and length d rises by k d^2 / 2 above the tangent plane at either end. So
 * does a smooth edge, seen from both ends and with the curvature at one of them; what differs from
 * that, as a share of d, is its misfit. It is half the change of curvature over the edge times d,
 * and the angle of a crease.
 */
#ifndef SOLVER_NET_ROUGH_H
#define SOLVER_NET_ROUGH_H

#include "solver/surface/station.h"

/* Smooth below the first misfit, rough above the second; between them it depends on what lies
 * between the ends. At the first the length of an edge across a joint is right to 1e-6. */
#define ROUGH_MISFIT_SMOOTH 2e-3
#define ROUGH_MISFIT_ROUGH 2.5e-2

/* Turns |k| d of an edge: below the first it is an arc for all that matters, above the second too
 * long for one. */
#define ROUGH_TURN_SMOOTH 0.08
#define ROUGH_TURN_ROUGH 0.5

/* Whether the edge from p to q is rough where the misfit or the turn alone does not tell. */
bool rough_edge_closely(const struct station *p, const struct station *q, double curvature,
                        double misfit, double d);

/* Whether the edge from p to q, d long with this normal curvature at p, is rough. */
static inline bool rough_edge(const struct station *p, const struct station *q, double curvature,
                              double d) {
    struct vec3 chord = vec3_sub(q->jet.r, p->jet.r);
    double turn = curvature * d, rise = turn / 2 * d;
    double misfit =
        fabs(vec3_dot(chord, p->normal) - rise) + fabs(vec3_dot(chord, q->normal) + rise);
    bool smooth = misfit < ROUGH_MISFIT_SMOOTH * d && fabs(turn) < ROUGH_TURN_SMOOTH;
    return !smooth && rough_edge_closely(p, q, curvature, misfit / d, d);
}

/* The unit tangent at p of the geodesic to the place `to` with the parameters `to_uv`, over a
 * smooth edge: the chord's projection, turned by d^2 k t / 6, k the normal curvature and t the
 * geodesic torsion, of p or, where p lies on a joint of `surface` (NULL on a mesh), of the other
 * end.
 */
struct vec3 rough_leave(const struct surface *surface, struct surface_cursor *cursor,
                        const struct station *p, const double to_uv[2], struct vec3 to);

#endif
