/* SPDX-License-Identifier: MIT */
/*
 * Where on a surface a function is least, beyond doubt: branch and bound over the spans.
 *
 * On a span, a coordinate of the surface, or the square of its distance to a point, is a rational
 * Bezier function f = N / W with positive weights. With the Bernstein polynomials B_k,
 *
 *   f = sum_k (N_k / W_k) (W_k B_k / W),
 *
 * a mean of the ratios N_k / W_k: nowhere is f less than the least of them, and at the corners it
 * is a ratio itself. A cell of the span that could still hold something better than what is known
 * is halved by de Casteljau's algorithm; the gap between the bound and f shrinks with the
 * square of the cell.
 */
#ifndef SOLVER_SURFACE_BOUNDS_H
#define SOLVER_SURFACE_BOUNDS_H

#include "nurbs.h"
#include "surface.h"
#include <stdbool.h>

/* A coefficient: numerator N_k in lane 0, denominator W_k > 0 in lane 1. */
typedef double bounds_pair __attribute__((vector_size(16)));

enum {
    /* The square of a distance has twice the degree of the surface. */
    BOUNDS_DEGREE_MAX = 2 * NURBS_DEGREE_MAX,
    BOUNDS_ORDER_MAX = BOUNDS_DEGREE_MAX + 1,
    BOUNDS_SIZE_MAX = BOUNDS_ORDER_MAX * BOUNDS_ORDER_MAX,
    /* Cells are never halved more often: 22 times in each direction, when the gap is 1e-13 of what
     * it was, and rounding is all that is left to find. */
    BOUNDS_DEPTH_MAX = 44,
    BOUNDS_STORE = (BOUNDS_DEPTH_MAX + 1) * BOUNDS_SIZE_MAX
};

/* A piece of a span and the coefficients there, [k][l] with l fastest. */
struct bounds_cell {
    const int *degree;         /* of f in u and v */
    double lower[2], upper[2]; /* within the span's [0, 1]^2; the ends are exact */
    const bounds_pair *pairs;
};

enum { BOUNDS_SETTLED = -1 };

/* Judges a cell: BOUNDS_SETTLED when it holds nothing better than what `context` knows, else the
 * direction to halve it in, 0 or 1. */
typedef int bounds_judge(void *context, const struct bounds_cell *cell);

/* One search, 260 kB for the stack; not to be cleared. */
struct bounds_search {
    int degree[2];
    bounds_judge *judge;
    void *context;
    bounds_pair store[BOUNDS_STORE]; /* first the coefficients of the span: set by the caller */
};

/* Has every cell of the span judged, until all are settled. */
void bounds_run(struct bounds_search *search);

/* The least ratio of a cell, and the least at its four corners, which f attains; `corner` (may be
 * NULL) gets which: bit 0 for the upper end of u, bit 1 of v. */
double bounds_least(const struct bounds_cell *cell);
double bounds_least_corner(const struct bounds_cell *cell, int *corner);

/* The direction in which N - level W bends more, by its second differences. */
int bounds_bend(const struct bounds_cell *cell, double level);

/* Whether N - level W is convex on the cell. If so, and it vanishes where f has a minimum of value
 * `level` relative to the cell, f is no less than `level` anywhere in the cell. */
bool bounds_convex(const struct bounds_cell *cell, double level);

/* The box of the surface itself, to 1e-10 of the diagonal of `surface_bounds`: each coordinate is
 * one of a point of the surface, never beyond it. Of a moved surface: a box that contains it, wider
 * than that of the surface itself by the height. */
void bounds_tight(const struct surface *surface, struct vec3 *lower, struct vec3 *upper);

#endif
