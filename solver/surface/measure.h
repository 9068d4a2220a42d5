/* SPDX-License-Identifier: MIT */
/*
 * What can be said of a surface without keeping its spans: a surface of 512 x 512 control points of
 * degree 9 takes 800 MB when it is made ready, this a few. It is measured strip by strip, a strip
 * being one span of one direction with all of the other.
 */
#ifndef SOLVER_SURFACE_MEASURE_H
#define SOLVER_SURFACE_MEASURE_H

#include "nurbs.h"
#include "solver/arena.h"
#include "solver/status.h"
#include <stdbool.h>
#include <stdint.h>

struct surface_measure {
    double area;
    struct vec3 lower, upper; /* the box of the surface itself, as `bounds_tight` */
    bool closed[2];           /* as `surface_closed` */
};

/* Bytes that the spans of the surface take when `surface_make` makes it ready, at the most. */
int64_t surface_span_bytes(const struct nurbs *nurbs);

/* Measures `nurbs`, which must have passed `nurbs_validate`; scratch of one strip at a time comes
 * from `arena`. Errors: STATUS_OUT_OF_MEMORY; STATUS_DEGENERATE_SURFACE when there is no area. */
enum status surface_measure(const struct nurbs *nurbs, struct arena *arena,
                            struct surface_measure *measure) STATUS_MUST_USE;

#endif
