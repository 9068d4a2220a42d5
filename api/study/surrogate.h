/* SPDX-License-Identifier: MIT */
/*
 * Interpolation of values at scattered points, by radial basis functions: the functions
 *
 *     s(x) = sum_i w_i |x - x_i|^3 + a + b x,  s(x_i) = f_i,  sum_i w_i = 0,  sum_i w_i x_i = 0,
 *
 * which need no length scale and reproduce linear functions. Several are made at once from the same
 * points, by IEEE operations alone, so that every machine gives the same bits.
 */
#ifndef API_STUDY_SURROGATE_H
#define API_STUDY_SURROGATE_H

#include "solver/arena.h"
#include "solver/status.h"
#include <stddef.h>

enum { SURROGATE_DIMENSIONS = 7, SURROGATE_VALUES_MOST = 48 };

struct surrogate_point {
    double x[SURROGATE_DIMENSIONS]; /* about 1 in size; what is not needed is 0 everywhere */
};

struct surrogate {
    const struct surrogate_point *points;
    size_t count;   /* of points */
    size_t values;  /* how many functions, at most SURROGATE_VALUES_MOST */
    size_t stride;  /* of `weight`, at least `values`: 0 in between */
    double *weight; /* [i * stride + k]: of point i, then a and b of function k */
    double *across; /* [c * count + i]: coordinate c of point i */
};

/* Makes it of `count` >= 1 points, which it keeps, and what they have: value k of point i is
 * `value[i * values + k]`. Points that are all but equal have about the mean of their values.
 * Errors: STATUS_OUT_OF_MEMORY. */
enum status surrogate_make(const struct surrogate_point *points, const double *value, size_t count,
                           size_t values, struct arena *arena,
                           struct surrogate *surrogate) STATUS_MUST_USE;

/* The functions at `at`, zeros behind them, and the square of the distance to the nearest of the
 * points. */
void surrogate_at(const struct surrogate *surrogate, const struct surrogate_point *at,
                  double value[SURROGATE_VALUES_MOST], double *nearest);

static inline double surrogate_distance2(const struct surrogate_point *a,
                                         const struct surrogate_point *b) {
    double sum = 0;
    for (int c = 0; c < SURROGATE_DIMENSIONS; c++)
        sum += (a->x[c] - b->x[c]) * (a->x[c] - b->x[c]);
    return sum;
}

#endif
