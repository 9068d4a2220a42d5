/* SPDX-License-Identifier: MIT */
/*
 * A surface ready for evaluation: the NURBS of `nurbs.h`, split once into rational Bezier spans
 * whose homogeneous control points (w x, w y, w z, w) are four-lane vectors, with what the drape
 * has to know about its domain: its bounds, whether it closes on itself, its poles and its size.
 *
 * A surface is immutable once made and may be read by many threads at once; what an evaluation
 * remembers (the last span) lies in the caller's `surface_cursor`.
 */
#ifndef SOLVER_SURFACE_SURFACE_H
#define SOLVER_SURFACE_SURFACE_H

#include "nurbs.h"
#include "solver/arena.h"
#include "solver/status.h"
#include "solver/vec.h"
#include <stdbool.h>

struct surface;
struct trim;

/* Point and derivatives at (u, v), in the surface's unit and per unit of parameter. */
struct surface_jet {
    struct vec3 r;
    struct vec3 u, v;       /* first derivatives r_u, r_v */
    struct vec3 uu, uv, vv; /* second derivatives */
};

/* The span last visited; start with zeros. One per thread. */
struct surface_cursor {
    int span_u, span_v;
};

/* Splits `nurbs`, which must have passed `nurbs_validate`, into spans in `arena`; the arrays of
 * `nurbs` are not needed afterwards. Errors: STATUS_OUT_OF_MEMORY; STATUS_DEGENERATE_SURFACE when
 * its area is zero. */
enum status surface_make(const struct nurbs *nurbs, struct arena *arena,
                         struct surface **surface) STATUS_MUST_USE;

/* Evaluates to second order. Outside the domain a closed direction wraps and an open one is
 * continued by the polynomials of its end span. */
void surface_evaluate(const struct surface *surface, struct surface_cursor *cursor, double u,
                      double v, struct surface_jet *jet);

/* lower[0..1] and upper[0..1]: the domain in u and v. */
void surface_domain(const struct surface *surface, double lower[2], double upper[2]);

/* Whether r is equal at both ends of u (direction 0) or v (direction 1). */
bool surface_closed(const struct surface *surface, int direction);

/* Corners of the box around the control points: it contains the surface. */
void surface_bounds(const struct surface *surface, struct vec3 *lower, struct vec3 *upper);

/* Area in the square of the surface's unit, by Gauss quadrature of |r_u x r_v| over the spans, and
 * its centroid (may be NULL). */
double surface_area(const struct surface *surface, struct vec3 *centroid);

/* The square of its radius of gyration: the mean of |r - centroid|^2 over the area. Of a flat
 * rectangle it is a twelfth of the square of the diagonal. */
double surface_gyration2(const struct surface *surface);

/* How a surface bends, by samples of the region (NULL: all of it): 32 by 32, one in each span
 * where it has more, at the most 4096. */
struct surface_bends {
    double least_radius; /* of curvature at regular points; infinite where it is flat, 0: unknown */
    bool turns_back;  /* on itself, by more than 178 degrees between two samples, at `turn`: at */
    struct vec3 turn; /* a cusp, at a fold, or where it is inside out */
};
void surface_bends_find(const struct surface *surface, const struct trim *trim,
                        struct surface_bends *bends);

/* Whether a border that is closed, and should be a pole, is none: its control points are not one,
 * but lie within `least` of each other. `at` gets the first of them and `spread` how far another is
 * from it. */
bool surface_has_spread_pole(const struct surface *surface, double least, struct vec3 *at,
                             double *spread);

/* The point of the surface nearest to `point`: its parameters, inside the domain, and its distance,
 * to 1e-10 of the surface's size; by branch and bound over the spans, then Newton on the distance.
 */
void surface_nearest(const struct surface *surface, struct vec3 point, double uv[2],
                     double *distance);

#endif
