/* SPDX-License-Identifier: MIT */
/* A step of Levenberg and Marquardt's method between bounds. */
#ifndef SOLVER_STEER_DAMPED_STEP_H
#define SOLVER_STEER_DAMPED_STEP_H

#include "slope.h"

/*
 * (H + damping diag H) step = -gradient, by Cholesky's factors; values that lie on a bound, -most
 * or most, and would pass it stay there, and the step of the others ends at theirs. Returns by how
 * much the quadratic model says that the energy falls; 0 where there is no step.
 */
double steer_damped_step(const struct steer_slope *slope, const double *value, double most,
                         double damping, double *step);

#endif
