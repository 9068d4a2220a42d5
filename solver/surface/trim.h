/* SPDX-License-Identifier: MIT */
/*
 * The usable region of a trimmed surface: loops of NURBS curves or polylines in (u, v). It is what
 * lies inside a loop that keeps its inside, or the whole domain when there is none, less what lies
 * inside the others.
 * Curves are flattened once; whether a point is inside a loop is the parity of the edges to its
 * left, found in strips of v.
 */
#ifndef SOLVER_SURFACE_TRIM_H
#define SOLVER_SURFACE_TRIM_H

#include "solver/relocation.h"
#include "surface.h"
#include <stdint.h>

/* A planar curve in (u, v): a NURBS curve, or with `knots` NULL the polyline of its points. */
struct trim_curve {
    int degree;                /* 1..NURBS_DEGREE_MAX; 1 for a polyline */
    const double (*points)[2]; /* not multiplied by the weights */
    size_t count;              /* at least 2, and more than `degree` */
    const double *knots;       /* count + degree + 1, non-decreasing; NULL: a polyline */
    const double *weights;     /* `count`, positive; NULL: all 1 */
};

/* Curves end to end; the last is joined to the first by a straight line if it does not meet it. */
struct trim_loop {
    bool reversed; /* what lies inside the loop is kept, not cut away */
    const struct trim_curve *curves;
    size_t count;
};

/* The point of a curve at t, from its first knot inside to its last, or for a polyline counted in
 * points from 0; and the derivative by t there (may be NULL). */
void trim_curve_at(const struct trim_curve *curve, double t, double uv[2], double rate[2]);

/* The same by the polynomials that the curve has at `from`, wherever t is. */
void trim_curve_beyond(const struct trim_curve *curve, double from, double t, double uv[2],
                       double rate[2]);

/* The same in the knot span from knots[l] to knots[l + 1], wherever t is; of a polyline its segment
 * l, where t counts from 0 to 1. */
void trim_curve_in_span(const struct trim_curve *curve, size_t l, double t, double uv[2],
                        double rate[2]);

/* The first point (end 0) or the last (end 1). */
void trim_curve_end(const struct trim_curve *curve, int end, double uv[2]);

/* The range of t. */
void trim_curve_range(const struct trim_curve *curve, double range[2]);

struct trim;

/* The region of `surface` within the loops, in `arena`; the loops are not needed afterwards.
 * O(n log n) for n points in all, however the loops run: one that crosses itself is no error.
 * Errors: STATUS_OUT_OF_MEMORY; STATUS_DEGENERATE_SURFACE when nothing is left. */
enum status trim_make(const struct surface *surface, const struct trim_loop *loops, size_t count,
                      struct arena *arena, struct trim **trim) STATUS_MUST_USE;

/* Whether (u, v), inside the domain, is in the region. */
bool trim_contains(const struct trim *trim, const double uv[2]);

/* Whether (u, v) is in the box around the region's edges. */
bool trim_near(const struct trim *trim, const double uv[2]);

/* Area of the region in the square of the surface's unit, and its centroid. To about 1e-7 of it;
 * less exactly where its loops have more than 256 corners and turns, or a line v = const crosses
 * more than 512 edges and 4 / 512 of all. */
double trim_area(const struct trim *trim, struct vec3 *centroid);

/* The square of its radius of gyration, as `surface_gyration2`. */
double trim_gyration2(const struct trim *trim);

/* A point of the region near its centroid: well inside it, where the centroid itself may not be. */
void trim_middle(const struct trim *trim, double uv[2]);

/* The middle of the widest strip across direction k, round which the surface closes, that has
 * nothing of the region; `found` is false when of 64 lines none is bare. Errors:
 * STATUS_OUT_OF_MEMORY, in `scratch`. */
enum status trim_bare_line(const struct trim *trim, const struct surface *surface, int k,
                           struct arena *scratch, bool *found, double *at) STATUS_MUST_USE;

/* The loops, as they were given, each a polyline in (u, v) that is closed by its last point;
 * returns how many points it has. */
size_t trim_loop_count(const struct trim *trim);
size_t trim_loop_points(const struct trim *trim, size_t loop, const double (**points)[2]);

/* Walks of `solver/relocation.h` from the pointer to a region on, with its surface; from that to a
 * curve; and from that to `count` loops, as their owner wrote them. */
void trim_curve_relocate(struct relocation *relocation, void *field);
void trim_relocate(struct relocation *relocation, void *field);
void trim_loops_relocate(struct relocation *relocation, void *field, size_t count);

/* How much work it was to make: edges, entries of strips and crossings of lines looked at. */
size_t trim_steps(const struct trim *trim);

#endif
