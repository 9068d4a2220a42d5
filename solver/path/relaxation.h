/* SPDX-License-Identifier: MIT */
/*
 * The geodesic between two points of the surface, as a boundary-value problem solved by relaxation
 * (paper, section 4.3). With y = (u, v, p, q), s from 0 at A to 1 at B, and the connection G,
 *
 *     u' = p,  v' = q,  p' = -G1(p, q),  q' = -G2(p, q),  (u, v) given at A and at B
 *
 * (equations 33 to 38). On m points, h apart, the trapezoidal rule
 *
 *     F_k = Y_k - Y_(k-1) - h/2 (g_k + g_(k-1)) = 0,  k = 2..m                             (39, 41)
 *
 * and the four boundary values are solved together by Newton's method. Equation 42 of the paper
 * lost a sign: G enters g with a minus, and so F3 and F4 with a plus. Since the ends are given and
 * not the length, p and q are per unit of s: the speed along the path is its length.
 *
 * Where the line crosses a knot, r_uu and with it p' may jump (on every surface of revolution made
 * of quarter circles it does). Each step of the mesh therefore lies in one span, with that span's
 * polynomials at both its ends, and the points that stand for crossings are moved until they are
 * crossings; so knots cost no accuracy. Creases do, and are refused.
 *
 * Shooting (`path.h`) is for lines whose first direction is known; this is for those whose ends
 * are.
 */
#ifndef SOLVER_PATH_RELAXATION_H
#define SOLVER_PATH_RELAXATION_H

#include "solver/shell/surface_point.h"

enum { RELAXATION_POINTS_MAX = 33 };

/* A path on its mesh. */
struct relaxation {
    int points;                         /* m */
    double y[RELAXATION_POINTS_MAX][4]; /* (u, v) less those of A, and (p, q) */
    int iterations;                     /* Newton corrections computed, those not taken too */
    int halvings;                       /* of the step factor mu (equations 52 to 54) */
};

/* The path from `a` to `b` on 3..RELAXATION_POINTS_MAX points, from the straight line in (u, v).
 * Its error is of second order in h. (u, v) of both must be on the same turn of a closed direction.
 * False when Newton fails, or the line does not cross the knots in the order in which the straight
 * one does. */
bool relaxation_solve(const struct surface *surface, const struct surface_point *a,
                      const struct surface_point *b, int points, struct relaxation *path);

/* The unit tangent at A of the geodesic to B, and its length, from meshes of 5 and 9 points
 * extrapolated to h = 0: fourth order in h. With d the distance and R the least radius of
 * curvature, of the surface or of its parameter lines, both are right to about 1e-4 (d / R)^4;
 * the chord's projection on the tangent plane to about 0.1 (d / R)^2.
 * `iterations` (may be NULL) gets the Newton corrections of both meshes, 5 as a rule.
 * (u, v) as above. False, with the outputs unset, where (u, v) does not serve (a pole nearer than
 * four distances, no tangent plane), where relaxation_solve fails, and where the mesh does not
 * resolve what it found; the projected chord will then have to do. */
bool relaxation_tangents(const struct surface *surface, struct surface_cursor *cursor,
                         const struct surface_point *a, const struct surface_point *b,
                         struct vec3 *tangent_at_a, double *length, int *iterations);

#endif
