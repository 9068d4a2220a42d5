/* SPDX-License-Identifier: MIT */
/*
 * A line on a part, as the edge of a course of cloth is laid along it: points of the surface, about
 * a step apart, with the unit tangents of the line and its arc length there. Between two points it
 * is the cubic with their tangents, brought down to the surface, which is right to the fourth power
 * of the step.
 *
 * A line may run over faces of a shell, and beyond the part on its continuation. Its left is that
 * of the normals of its points, which a shell must have on one side (`shell_orient`).
 *
 * Its parallel at the distance h(s) is
 *
 *     x(s) = exp_r(s) (h(s) n(s)),    n = N x t,
 *
 * the end of the geodesic of the length h that leaves the line at right angles. With h constant it
 * is equidistant, and meets these geodesics at right angles itself (Gauss's lemma).
 */
#ifndef SOLVER_COURSE_LINE_H
#define SOLVER_COURSE_LINE_H

#include "solver/arena.h"
#include "solver/shell/surface_point.h"
#include "solver/status.h"
#include <stdbool.h>
#include <stddef.h>

struct course_line {
    struct surface_point *at;
    struct vec3 *tangent; /* unit, towards the next point */
    double *s;            /* arc length from the first point */
    size_t count;         /* at least 2, but before `line_extend` */
};

/* An empty line with room for so many points. False without memory. */
bool line_alloc(struct course_line *line, size_t count, struct arena *arena);

/* From points that are set, the tangents and arc lengths: each tangent by the polynomial through
 * seven points, each arc from the turn between its chord's ends. `count` >= 2. */
void line_complete(struct course_line *line);

/* Goes on from both ends of a line, which may be one point with its tangent, along geodesics in
 * steps: as far as `most` or, if that comes first, the continuation beyond the part goes. `before`
 * gets the number of points before the first one. Errors: STATUS_OUT_OF_MEMORY;
 * STATUS_NO_CONVERGENCE when it is still one point. */
enum status line_extend(struct course_line *line, double step, double most, struct arena *arena,
                        size_t *before) STATUS_MUST_USE;

/* The point at arc length s, on the end's geodesic beyond it, with the unit tangent. False where
 * the surface has none. */
bool line_point(const struct course_line *line, double s, struct surface_cursor *cursor,
                struct surface_point *point, struct vec3 *tangent);

/* A distance, to the left of a line, as a function of its arc length. */
struct line_distance {
    const double *values; /* of a Bezier polynomial over `from` .. `to`, straight beyond: nowhere
                             between is it outside its least and greatest value */
    size_t count;         /* at least 1 */
    double from, to;      /* arc lengths */
};
enum { LINE_VALUES_MAX = 16 };

double line_distance_at(const struct line_distance *distance, double s);

/*
 * The parallel of a line, with points a `step` apart along it, one of them, `middle`, at the foot
 * of the line's `foot`; to both sides as far as geodesics can be followed and it goes on in the
 * line's sense: it ends before the line's centre of geodesic curvature. Distances of 0 alike. Each
 * geodesic is exact to `accuracy` of a step; above 1e-6 points need be less evenly apart, too,
 * which takes fewer of them. Errors: STATUS_OUT_OF_MEMORY; STATUS_NO_CONVERGENCE when there are no
 * two such points.
 */
enum status line_parallel(const struct course_line *line, const struct line_distance *distance,
                          double foot, double step, double accuracy, struct arena *arena,
                          struct course_line *parallel, size_t *middle) STATUS_MUST_USE;

#endif
