/* SPDX-License-Identifier: MIT */
/*
 * One step of the explicit Runge-Kutta method of order 8 by Dormand and Prince for y' = f(s, y), y
 * of four components, with the two error estimates of its authors' program DOP853; and of one of
 * order 5, which is cheaper where little is asked.
 */
#ifndef SOLVER_PATH_DORMAND_H
#define SOLVER_PATH_DORMAND_H

#include "solver/surface/spans.h"

enum { DORMAND_STAGES = 12 };

/* slope = f(s, y), s counted from where the step begins */
typedef void dormand_slope(const void *context, double s, const vec4 *y, vec4 *slope);

/* The differences to the embedded solutions of order 5 and 3. With |.| a norm, the error of the
 * step is about |fifth|^2 / sqrt(|fifth|^2 + 0.01 |third|^2), of order h^8. */
struct dormand_error {
    vec4 fifth, third;
};

/* y after a step of h from y = from[0], where f is from[1]; s = 0 there. */
void dormand_step(dormand_slope *slope_at, const void *context, double h, const vec4 *from,
                  vec4 *to, struct dormand_error *error);

/* Two steps that do not depend on each other, stage by stage: each stage waits for the one before
 * it, and the processor does the one step's while the other's waits. */
struct dormand_task {
    const void *context;
    double h;
    const vec4 *from;
    vec4 *to;
    struct dormand_error *error;
};

void dormand_two_steps(dormand_slope *slope_at, const struct dormand_task task[2]);

/* One step of order 5, by Cash and Karp, of half the evaluations: `third` is 0, and `fifth` the
 * difference to the embedded solution of order 4, so that the error as above is that, of order h^5.
 */
void dormand_rough_step(dormand_slope *slope_at, const void *context, double h, const vec4 *from,
                        vec4 *to, struct dormand_error *error);

#endif
