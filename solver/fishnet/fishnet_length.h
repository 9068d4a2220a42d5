/* SPDX-License-Identifier: MIT */
/*
 * The fourth corner of a cell by the lengths of its yarns, each the `logarithm.h` of D at B and at
 * C. A step x in the tangent plane at D lengthens BD by its component along the yarn's end and, as
 * the circle about B is round, by half the square of that across it times 1 / |BD| - K |BD| / 3, K
 * being the surface's own curvature:
 *
 *     t_BD . x + (n_BD . x)^2 (1 / |BD| - K |BD| / 3) / 2 = d_warp - |BD|,   and so for CD
 *
 * What that leaves is of the third order.
 */
#ifndef SOLVER_FISHNET_FISHNET_LENGTH_H
#define SOLVER_FISHNET_FISHNET_LENGTH_H

#include "fishnet.h"
#include "fishnet_geodesic.h"

/* Moves D, at node->point, until BD and CD, measured to `accuracy` of their lengths, are `bd` and
 * `cd` long, and says how they leave and arrive (as fishnet_geodesic_meet does). False, with the
 * node as it may be, where logarithms cannot be had or D is not found. */
bool fishnet_length_meet(struct surface_cursor *cursor, const struct fishnet_cell *cell, double bd,
                         double cd, double accuracy, struct fishnet_yarns *yarns,
                         struct fishnet_node *node);

#endif
