/* SPDX-License-Identifier: MIT */
/*
 * Formulas are written once, for one number and for lanes of them (`lanes.h`), in files of their
 * own that include this and use
 *
 *   NUMBER, VECTOR, MASK   double, struct vec3, bool;  or lanes, struct lanes3, lanes_mask
 *   JET, POINT             struct surface_jet, struct surface_point;  or those of lanes
 *   NAME(f)                the names of the formulas: f, or f_lanes
 *   N(f), V(f)             operations on numbers and masks, and on vectors
 *
 * They are included as they are for numbers, and with FORMULAS_OF_LANES defined for lanes: the same
 * operations in the same order, and so the same bits.
 */
#include "vec.h"
#include "wide.h"
#include <stdbool.h>

#undef NUMBER
#undef VECTOR
#undef MASK
#undef JET
#undef POINT
#undef NAME
#undef N
#undef V

#ifdef FORMULAS_OF_LANES
#include "lanes.h"
#define NUMBER lanes
#define VECTOR struct lanes3
#define MASK lanes_mask
#define JET struct lanes_jet
#define POINT struct lanes_point
#define NAME(f) f##_lanes
#define N(f) lanes_##f
#define V(f) lanes3_##f
#else
#define NUMBER double
#define VECTOR struct vec3
#define MASK bool
#define JET struct surface_jet
#define POINT struct surface_point
#define NAME(f) f
#define N(f) number_##f
#define V(f) vec3_##f
#endif

#ifndef SOLVER_NUMBERS_H
#define SOLVER_NUMBERS_H

/* For one number, what lanes.h has for several. */
INLINE double number_of(double a) {
    return a;
}

INLINE double number_select(bool choose, double a, double b) {
    return choose ? a : b;
}

INLINE double number_abs(double a) {
    return fabs(a);
}

INLINE bool number_finite(double a) {
    return isfinite(a);
}

INLINE double number_sqrt(double a) {
    return sqrt(a);
}

/* x > 0, normal: m, 1/2 <= m < 1, with x = m 2^e. */
INLINE double number_split(double x, double *e) {
    int exponent;
    double m = frexp(x, &exponent);
    *e = exponent;
    return m;
}

/* x 2^k for a whole number k, both x and that normal. */
INLINE double number_scale2(double x, double k) {
    return ldexp(x, (int)k);
}

INLINE struct vec3 vec3_of(struct vec3 a) {
    return a;
}

INLINE struct vec3 vec3_select(bool choose, struct vec3 a, struct vec3 b) {
    return choose ? a : b;
}

INLINE bool number_not(bool mask) {
    return !mask;
}

INLINE bool number_any(bool mask) {
    return mask;
}

INLINE bool number_all(bool mask) {
    return mask;
}

#endif
