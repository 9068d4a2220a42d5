/* SPDX-License-Identifier: MIT */
/*
 * The geodesic between two places of the surface, as a boundary-value problem solved by relaxation
 * (paper, section 4.3). With y = (u, v, p, q), s from 0 at A to 1 at B, and the connection G,
 *
 *     u' = p,  v' = q,  p' = -G1(p, q),  q' = -G2(p, q),  (u, v) given at A and at B
 *
 * (equations 33 to 38). On m points a step h = 1 / (m - 1) apart, the trapezoidal rule
 *
 *     F_k = Y_k - Y_(k-1) - h/2 (g_k + g_(k-1)) = 0,  k = 2..m                             (39, 41)
 *
 * and the four boundary values are solved together by Newton's method. Equation 42 of the paper
 * lost a sign: G enters g with a minus, and so F3 and F4 with a plus. Since the ends are given and
 * not the length, p and q are per unit of s: the speed along the path is its length.
 *
 * Shooting (`path.h`) is for lines whose first direction is known; this is for those whose ends
 * are.
 */
#ifndef DRAPE_RELAXATION_H
#define DRAPE_RELAXATION_H

#include "station.h"

enum { RELAXATION_POINTS_MAX = 33 };

/* A path on its mesh. */
struct relaxation {
    int points;                         /* m */
    double y[RELAXATION_POINTS_MAX][4]; /* (u, v) less those of A, and (p, q) */
    int iterations;                     /* Newton corrections computed, those not taken too */
    int halvings;                       /* of the step factor mu (equations 52 to 54) */
};

/* The path from `a` to `b` on 3..RELAXATION_POINTS_MAX points, from the straight line in (u, v).
 * Its error is of second order in h. False when Newton fails. */
bool relaxation_solve(const struct surface *surface, struct surface_cursor *cursor,
                      const struct station *a, const struct station *b, int points,
                      struct relaxation *path);

/* The unit tangent at A of the geodesic to B, and its length, from meshes of 5 and 9 points
 * extrapolated to h = 0 (fourth order in h, where the surface is smooth). `iterations` (may be
 * NULL) gets the Newton corrections of both. With d the distance and R the least radius of
 * curvature, of the surface or of its parameter lines, the tangent is right to about
 * 1e-3 (d / R)^4.
 * (u, v) of both stations must be on the same turn of a closed direction. False, with the outputs
 * unset, where (u, v) does not serve (a pole nearer than a few distances, no tangent plane), where
 * Newton fails, and where the mesh does not resolve what it found; the chord's projection on the
 * tangent plane will then have to do. */
bool relaxation_tangents(const struct surface *surface, struct surface_cursor *cursor,
                         const struct station *a, const struct station *b,
                         struct vec3 *tangent_at_a, double *length, int *iterations);

#endif
