/* SPDX-License-Identifier: MIT */
/*
 * Integrals over the region of a trimmed surface by Green's theorem: for f on the surface and
 * F(u, v) the integral of f from the domain's lower border to u,
 *
 *     int f du dv over the inside of a loop = integral of F dv along the loop,
 *
 * by Gauss's rule on each piece of a trim curve between knots, and knots of the surface. To about
 * 1e-9 of what is smooth, where the lines of `trim_area` find 1e-7.
 */
#ifndef SOLVER_SURFACE_CONTOUR_H
#define SOLVER_SURFACE_CONTOUR_H

#include "surface.h"
#include "trim.h"

struct contour_measure {
    double area;
    struct vec3 centre;       /* of the area */
    struct vec3 normal;       /* mean of r_u x r_v, a unit vector; 0 when it cancels */
    struct vec3 lower, upper; /* box of the region, by the points that were looked at */
};

/* Of the region within the loops, as `trim_make`; of the whole surface when there are none. Loops
 * that cross, and such as would take too long, have the area of `trim_area`. Scratch comes from
 * `arena`. Errors: STATUS_OUT_OF_MEMORY; STATUS_DEGENERATE_SURFACE when nothing is left. */
enum status contour_measure(const struct surface *surface, const struct trim_loop *loops,
                            size_t count, struct arena *arena,
                            struct contour_measure *measure) STATUS_MUST_USE;

#endif
