/* SPDX-License-Identifier: MIT */
/*
 * The fourth corner of a cell by the lengths of its yarns, each the `logarithm.h` of D at B and at
 * C. The length of BD grows by the component of D's step along the yarn's end, so that Newton's
 * method is two products for
 *
 *     t_BD . x = d_warp - |BD|,   t_CD . x = d_weft - |CD|
 *
 * x the step in the tangent plane at D. It converges quadratically, lengths being convex.
 */
#ifndef SOLVER_NET_FISHNET_LENGTH_H
#define SOLVER_NET_FISHNET_LENGTH_H

#include "fishnet.h"
#include "fishnet_geodesic.h"

/* Moves D, at node->station, until BD and CD, measured to `accuracy` of their lengths, are `bd` and
 * `cd` long, and says how they leave and arrive (as fishnet_geodesic_meet does). False, with the
 * node as it may be, where logarithms cannot be had or D is not found. */
bool fishnet_length_meet(struct surface_cursor *cursor, const struct fishnet_cell *cell, double bd,
                         double cd, double accuracy, struct fishnet_yarns *yarns,
                         struct fishnet_node *node);

#endif
