/* SPDX-License-Identifier: MIT */
/*
 * The step of the method `geodesic`: D at given distances from B and C along the surface.
 *
 * Geodesics of the wanted lengths leave B and C at unknown angles beta and gamma; D is where their
 * ends meet. The end of one moves at right angles to it, by J = d - K d^3 / 6 + .. for each radian
 * of its angle (the Jacobi field; K is the Gaussian curvature), so that a Newton step for both
 * angles is a system of two equations; what is left out of J makes it converge by a factor of
 * (K d^2)^2 a step.
 */
#ifndef SOLVER_NET_FISHNET_GEODESIC_H
#define SOLVER_NET_FISHNET_GEODESIC_H

#include "fishnet.h"

/* Moves `node`, a place near D on the right side (`fishnet_solve` with the chords of `gib`), to
 * where the geodesics of length `bd` from B and `cd` from C meet, to 1e-11 of them, which is
 * node->residual. */
enum fishnet_end fishnet_geodesic_solve(const struct surface *surface,
                                        struct surface_cursor *cursor,
                                        const struct fishnet_cell *cell, double bd, double cd,
                                        struct fishnet_node *node);

#endif
