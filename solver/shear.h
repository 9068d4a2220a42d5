/* SPDX-License-Identifier: MIT */
/*
 * The shear angle gamma = 90 deg - w, w the angle between warp and weft, at nodes from difference
 * stencils along the yarns and over cells from their four corners.
 */
#ifndef DRAPE_SHEAR_H
#define DRAPE_SHEAR_H

#include "net.h"

/* The accuracy of the stencils at nodes: centred where the yarn goes on to both sides, one-sided of
 * the same order at its ends, of a lower order on yarns that are too short. */
enum shear_order { SHEAR_SECOND = 2, SHEAR_FOURTH = 4 };

/* Shear in degrees at the node (x, y) of a window, which must have a place; 0 where only one yarn
 * passes. */
double shear_at_node(const struct net_window *window, int x, int y, enum shear_order order);

/* Mean unit yarn directions and the shear between them, of the cell with the corners a = (i, j),
 * b = (i + 1, j), c = (i + 1, j + 1), d = (i, j + 1). */
struct shear_cell {
    struct vec3 warp, weft;
    double shear_deg;
};
struct shear_cell shear_of_cell(struct vec3 a, struct vec3 b, struct vec3 c, struct vec3 d);

#endif
