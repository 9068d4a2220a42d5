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
#include "solver/result.h"

struct node_shear_place {
    int32_t i, j;
    bool searched, known;
    double shear_deg;
};

struct node_shear {
    struct march *march;
    const struct drape_nodes *nodes; /* sorted by j, then i */
    struct net_view view;
    struct node_shear_place *places; /* nodes and ghosts, those looked at last, .. */
    int32_t across;                  /* .. of a square, a power of two */
};

/* Of a complete net with its result's nodes, in the march's arena. Errors: STATUS_OUT_OF_MEMORY. */
enum status node_shear_make(struct march *march, const struct drape_nodes *nodes,
                            struct node_shear *shear) STATUS_MUST_USE;

/* The shear at (p, q) in degrees, -90..90, between those corners of its cell whose node or ghost
 * tells it; false when none does. */
bool node_shear_between(struct node_shear *shear, double p, double q, double *shear_deg);

#endif
