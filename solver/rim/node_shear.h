/* SPDX-License-Identifier: MIT */
/*
 * The shear of the cloth between its nodes, where differences in space say little: bilinear in the
 * net's coordinates between the four corners of a cell, nodes of the result and ghosts. A ghost's
 * is the angle between its yarns in the surface, as the report measures nodes near rough edges. So
 * it goes on steadily from cell to cell, and on developable surfaces it is exact, whatever they
 * fold.
 */
#ifndef SOLVER_RIM_NODE_SHEAR_H
#define SOLVER_RIM_NODE_SHEAR_H

#include "solver/march/march.h"

/* Ghosts that are kept, across. */
enum { NODE_SHEAR_KEPT = 8 };

struct node_shear_ghost {
    int32_t i, j;
    bool sought, known;
    double shear_deg;
};

struct node_shear {
    struct march *march;
    const struct drape_nodes *nodes; /* sorted by j, then i */
    struct net_view view;
    struct node_shear_ghost ghost[NODE_SHEAR_KEPT][NODE_SHEAR_KEPT]; /* those looked at last */
};

/* Of a complete net with its result's nodes. */
void node_shear_make(struct march *march, const struct drape_nodes *nodes,
                     struct node_shear *shear);

/* The shear at (p, q) in degrees, -90..90, between those corners of its cell whose node or ghost
 * tells it; false when none does. */
bool node_shear_between(struct node_shear *shear, double p, double q, double *shear_deg);

#endif
