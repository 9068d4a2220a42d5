/* SPDX-License-Identifier: MIT */
/*
 * Logarithm and exponential from IEEE operations alone, as the angles of `angle.h` and for the same
 * reason: every machine gives the same bits. Accurate to a few units in the last place.
 */
#ifndef SOLVER_POWER_H
#define SOLVER_POWER_H

/* ln x for x > 0, normal and finite. */
double power_log(double x);

/* e^x; 0 below -745, infinite above 709. */
double power_exp(double x);

/* a^p for a >= 0, p > 0. */
double power_of(double a, double p);

/* a^(1 - t) b^t for 0 <= t <= 1, the weighted geometric mean of a, b >= 0; 0 where one of them that
 * has a weight is 0. a and b themselves at t = 0 and 1. */
double power_mean(double a, double b, double t);

#endif
