/* SPDX-License-Identifier: MIT */
/*
 * Angles from IEEE operations alone (+, -, *, /, sqrt), so that every machine gives the same bits;
 * the C library's functions differ in the last place from one machine to the next. Accurate to a
 * few units in the last place.
 */
#ifndef SOLVER_ANGLE_H
#define SOLVER_ANGLE_H

#include "angle_sinc.h"

#define ANGLE_PI 3.14159265358979323846

/* sin(x) / x for |x| <= pi. */
double angle_sinc(double x);

/* Sine and cosine of an angle in degrees, exact at multiples of 90; |degrees| <= 1e6. */
void angle_sincos_deg(double degrees, double *sine, double *cosine);

/* atan(k / 16) */
enum { ANGLE_ARCTANGENTS = 17 };
extern const double angle_arctangents[ANGLE_ARCTANGENTS];

/* atan x = atan c + atan((x - c) / (1 + x c)) for x >= 0, in radians, c = k / 16 being next to x
 * and `arctangent` that of it: an argument of at most 1/32, where 5 terms of the series are enough.
 */
INLINE int angle_next_sixteenth(double x) {
    return (int)(16 * x + 0.5);
}
INLINE double angle_atan_from(int k, double arctangent, double x) {
    double c = k / 16.0, t = (x - c) / (1 + x * c), square = t * t;
    double sum = 1.0 / 9 - square * (1.0 / 11);
    sum = 1.0 / 7 - square * sum;
    sum = 1.0 / 5 - square * sum;
    sum = 1.0 / 3 - square * sum;
    return arctangent + t * (1 - square * sum);
}

/* The angle in degrees whose tangent is x, for -1 <= x <= 1. */
double angle_atan_deg(double x);

/* The angle of (x, y) from the x axis in degrees, -180..180; 0 for the origin. */
double angle_atan2_deg(double y, double x);

#endif
