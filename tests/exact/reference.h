/* SPDX-License-Identifier: MIT */
/*
 * Exact nets (docs/mathematics.md, exact answers): r(s, t), the unit tangents r_s, r_t and the
 * shear angle, for s and t of either sign.
 *
 * - Sphere, geodesic generators, any start angle w0: the yarn angle depends on z = s t / R^2 only,
 *       z w'' + w' = -sin w,  w(0) = w0
 *   (power series, continued by Taylor steps), and r_st = II(r_s, r_t) N = -(cos w / R^2) r is then
 *   linear; it is solved by Chebyshev collocation in space.
 * - Translation surface z = (a x^2 + b y^2) / 2 from its apex: r = a(s) + b(t).
 * - Plane, cylinder, cone: a square grid on the unrolled surface.
 * - Any other: `goursat.h`.
 */
#ifndef DRAPE_TESTS_REFERENCE_H
#define DRAPE_TESTS_REFERENCE_H

#include "goursat.h"

struct reference;

/* A place on a surface with two unit tangents. */
struct frame {
    struct vec3 r, warp, weft;
};

/* Yarn angle w and dw/dz on the sphere; z of either sign, w in radians. */
void sphere_angle(double w0, double z, double *w, double *dw);
/* Where w(z) first becomes 0: the net collapses. */
double sphere_collapse(double w0);

/* The net for |s| <= length[0], |t| <= length[1]; only quadrants that have not collapsed there. */
struct reference *reference_sphere(struct vec3 centre, double radius, const struct frame *start,
                                   const double length[2]);
/* In the axes of `motion`, a similarity, which may mirror. */
struct reference *reference_translation(const struct motion *motion, double a, double b);
struct reference *reference_plane(const struct frame *start);
/* The cylinder rho = radius about the z axis of `motion`. */
struct reference *reference_cylinder(const struct motion *motion, double radius,
                                     const struct frame *start);
/* The cone rho = z tan(half_angle) about the z axis of `motion`. */
struct reference *reference_cone(const struct motion *motion, double half_angle,
                                 const struct frame *start);
struct reference *reference_net(const struct exact_net_setup *setup);
/* The same net without the ownership. */
const struct exact_net *reference_get_net(const struct reference *reference);

void reference_free(struct reference *reference);
void reference_at(const struct reference *reference, double s, double t,
                  struct exact_net_point *point);

/* The discrete net of great-circle edges on the sphere about 0: nodes (i, j), 0 <= i <= n[0],
 * 0 <= j <= n[1], at out[j * (n[0] + 1) + i]; generators are great circles with steps `arc[0]` and
 * `arc[1]` (lengths, not angles). Spherical trigonometry: D makes |BD| = |AC| and |CD| = |AB|, so
 * the quadrangle is symmetric about the middle of BC, and D is A turned by half a turn about
 * m = (B + C) / |B + C|:  D = 2 (A . m) m - A. */
void sphere_recursion(double radius, const struct frame *start, const double arc[2], const int n[2],
                      struct vec3 *out);

#endif
