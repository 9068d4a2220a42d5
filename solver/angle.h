/* SPDX-License-Identifier: MIT */
/*
 * Angles from IEEE operations alone (+, -, *, /, sqrt), so that every machine gives the same bits;
 * the C library's functions differ in the last place from one machine to the next. Accurate to a
 * few units in the last place.
 */
#ifndef SOLVER_ANGLE_H
#define SOLVER_ANGLE_H

#include "vec.h"

#define ANGLE_PI 3.14159265358979323846

/* sin(x) / x for |x| <= pi. */
double angle_sinc(double x);

/* Sine and cosine of an angle in degrees, exact at multiples of 90; |degrees| <= 1e6. */
void angle_sincos_deg(double degrees, double *sine, double *cosine);

/* The angle in degrees whose tangent is x, for -1 <= x <= 1. */
double angle_atan_deg(double x);

/* The angle of (x, y) from the x axis in degrees, -180..180; 0 for the origin. */
double angle_atan2_deg(double y, double x);

#endif
