/* SPDX-License-Identifier: MIT */
/*
 * The fourth corner of a cell by geodesics that are found by collocation, both at a time and while
 * their directions still change: what `fishnet_geodesic.h` describes, on one patch without creases.
 */
#ifndef SOLVER_FISHNET_FISHNET_COLLOCATION_H
#define SOLVER_FISHNET_FISHNET_COLLOCATION_H

#include "fishnet_geodesic.h"

/* What is asked of D: how long the yarns BD and CD are, and to what share of that. */
struct fishnet_collocation {
    double length[2], tolerance;
    int lanes; /* as drape_settings' */
};

/* Moves `node`, a point near D, to where the geodesics from B and C meet; `yarns` (may be NULL)
 * gets their tangents. False, with the node as it was, where collocation is not sure to find it. */
bool fishnet_collocation_solve(struct surface_cursor *cursor, const struct fishnet_cell *cell,
                               const struct fishnet_collocation *wanted,
                               struct fishnet_yarns *yarns, struct fishnet_node *node);

#endif
