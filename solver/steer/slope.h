/* SPDX-License-Identifier: MIT */
/*
 * How the energy of a drape changes with the curvature values of its generators: gradient and
 * Gauss-Newton matrix, by the derivatives of the net (`variation.h`).
 *
 * With r the place of a piece of cloth, the shear at a fixed place of the part changes by
 *
 *     J = dg - (a g_s + b g_t),    dr = a r_s + b r_t,
 *
 * since cloth moves over the part; the energy, an integral over the part, by the integral of W' J.
 * Yarns bend sideways by g_s and g_t, but for a sign, and bending costs half the stiffness by their
 * squares.
 */
#ifndef SOLVER_STEER_SLOPE_H
#define SOLVER_STEER_SLOPE_H

#include "energy.h"
#include "variation.h"

struct steer_slope {
    bool varied[2];   /* given: which generators, both of which are steered where they are */
    double stiffness; /* given: `steer_bending` */
    /* given: whether the slope of this drape is wanted */
    bool (*wanted)(void *context, const struct drape_result *result);
    void *context;
    struct steer_variation variation; /* in the arena of the drape; all else is made of it */
    double bending;                   /* what bending costs */
    double gradient[STEER_PARAMETERS];
    double matrix[STEER_PARAMETERS][STEER_PARAMETERS]; /* its upper triangle */
};

/* Fills the slope of the march's settings, of a net that is done. Errors: STATUS_OUT_OF_MEMORY. */
enum status steer_slope_make(struct march *march) STATUS_MUST_USE;

#endif
