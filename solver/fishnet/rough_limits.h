/* SPDX-License-Identifier: MIT */
/* The numbers by which the kinds of edges are distinguished (`rough_formulas.h`). */
#ifndef SOLVER_FISHNET_ROUGH_LIMITS_H
#define SOLVER_FISHNET_ROUGH_LIMITS_H

/* Below this misfit and this turn |k| d an edge is an arc for all that matters: its length is right
 * to 1e-5 where there is a joint, and far better where there is none. */
#define ROUGH_MISFIT_SMOOTH 2e-3
#define ROUGH_TURN_SMOOTH 0.08

/* Arcs differ by less between their ends, and turn by less. */
#define ROUGH_ARC_MISFIT 2.5e-2
#define ROUGH_ARC_TURN 0.5

/* What the length of an edge may be wrong by, as a share of it, where the surface is developable:
 * of an arc, and of a bent edge. Elsewhere also by a share of |K| d^2: an eighth of what yarns that
 * turn sideways, as straight ones do not, make `gib` wrong by on a net as large as the surface's
 * radii. */
#define ROUGH_ARC_ERROR 1e-6
#define ROUGH_BENT_ERROR 5e-6
#define ROUGH_OWN_SHARE (1.0 / 200)
#define ROUGH_ARC_SHARE (1.0 / 24)

/* With more of an error than this, and what is allowed by |K| d^2, there is a joint. */
#define ROUGH_EVEN 1e-7

/* On a surface with curvature of its own the square of the misfit may be so much of |K| d^2 before
 * shear has to be measured otherwise than by differences of positions in space. */
#define ROUGH_SHEAR_SHARE 1.0

/* The terms of third and fourth order of the turn, squared, times this are about the error of the
 * chord. */
#define ROUGH_MISSED 3.0

/* Where the surface has no curvature of its own, the direction of an edge that follows from its
 * ends is right to 1e-4 when it goes no further to the side by torsion, by half the angle of
 * rough_leave.
 */
#define ROUGH_WINDING 8e-3

/* An edge that turns by more to either side of its middle is no arc. */
#define ROUGH_TURN_MOST 0.75

/* The surface turns by more than this cosine over a cell that lies across a fold. */
#define ROUGH_FOLD_COSINE 0.9

/* An edge that rises by so much else than the curvature at its end says, as a share of that or of
 * the edge, lies on the other side of a joint there. */
#define ROUGH_OTHER_SIDE 0.2
#define ROUGH_LEAST_RISE 5e-4

/* A chord that is wrong by more than this share of the spacing leads to a D that says nothing of
 * the edge. */
#define ROUGH_FAR_OFF 0.05

/* There is a crease between ends where the surface turns by more than this angle and twice what it
 * bends. */
#define ROUGH_LEAST_FOLD 1e-3

#endif
