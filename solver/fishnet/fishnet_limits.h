/* SPDX-License-Identifier: MIT */
/* The numbers of Newton's method for a cell's fourth corner (`cell_formulas.h`). */
#ifndef SOLVER_FISHNET_FISHNET_LIMITS_H
#define SOLVER_FISHNET_FISHNET_LIMITS_H

/* Steps on the paraboloid for one on the surface. */
enum { FISHNET_MODEL_ROUNDS = 3 };

/* Newton stops at this length error relative to the edge, or where rounding hides it. */
#define FISHNET_TOLERANCE 1e-12
#define FISHNET_ROUNDING 1e-15

/* A guess is only taken as it is when it is this much better still: errors of guesses grow from
 * node to node, those of a Newton step do not. */
#define FISHNET_GUESS_SHARE 0.01

/* In a march that corrects a net it is enough that the last step, on the paraboloid, leads to
 * rounding: next chords hardly go by second derivatives, which it leaves as they are. Places of the
 * net before, moved as their neighbours have, are as near as this on fine nets. */
#define FISHNET_CORRECTED_GUESS 1e-8

/* Errors of this size are rounding: no step is of use. And this one, where steps do not reduce it,
 * is rounding of parameters in which the surface goes very fast. */
#define FISHNET_SETTLED 1e-14
#define FISHNET_STAGNATION 1e-9

/* The error of a chord that does not matter. */
#define FISHNET_NEGLIGIBLE 1e-12

/* With less of an error one step of Newton's leads to rounding; and a step on the paraboloid that
 * changes so little of it is the last. */
#define FISHNET_MODEL_LEAST 1e-7
#define FISHNET_MODEL_ENOUGH 1e-3

/* A step of Newton's goes through a pole's chart where the pole is nearer than so many steps. */
#define FISHNET_POLE_STEPS 4

/* Cells open further than this sine are convex. */
#define FISHNET_OPEN_SINE 0.3

#endif
