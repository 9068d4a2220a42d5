/* SPDX-License-Identifier: MIT */
/*
 * The geodesic curvature of a generator along itself: by how much a yarn is steered sideways. It is
 * a cubic B-spline of the arc length s from the start. Each side of the start is cut into `points`
 * equal parts, and the knots are their middles, at each of which one value stands: curvature is
 * twice continuously differentiable through the start, lies between the least and the greatest of
 * four neighbouring values, and beyond the last knot it tends to the last value.
 */
#ifndef SOLVER_CURVATURE_H
#define SOLVER_CURVATURE_H

#include <stdbool.h>

enum { DRAPE_CURVATURE_POINTS = 16, DRAPE_CURVATURE_VALUES = 2 * DRAPE_CURVATURE_POINTS };

struct drape_curvature {
    int points;       /* a side, 1..DRAPE_CURVATURE_POINTS; 0: straight */
    double length[2]; /* of the side against the positive arm, and of that along it, > 0 */
    double value[DRAPE_CURVATURE_VALUES]; /* 2 points of them, in the order of s, 1 / length:
                                             positive to the left, about r_u x r_v */
};

/* The curvature at the arc length s along the positive arm, of either sign. */
double curvature_at(const struct drape_curvature *curvature, double s);

/* How it rises there with each of its values, of which there is one at least. */
void curvature_weights(const struct drape_curvature *curvature, double s, double *weight);

/* The length from s to the next knot in the sense 1 or -1, beyond which it is another polynomial;
 * knots within a rounding error of s are behind it. */
double curvature_to_knot(const struct drape_curvature *curvature, double s, int sense);

/* Whether it is nowhere but 0: the generator is a geodesic. */
bool curvature_is_none(const struct drape_curvature *curvature);

/* The greatest absolute value: no place has more. */
double curvature_most(const struct drape_curvature *curvature);

#endif
