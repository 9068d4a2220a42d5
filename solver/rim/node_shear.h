/* SPDX-License-Identifier: MIT */
/*
 * The shear of the cloth between its nodes, those of the result and ghosts: cubic in the net's
 * coordinates between the four by four around a place or, where not all are known or rough edges
 * are near, bilinear between the corners of its cell. A ghost's is measured as that of nodes: from
 * differences along the yarns, near rough edges from the angle between them in the surface. So it
 * goes on steadily from cell to cell, and on developable surfaces it is exact, whatever they fold.
 */
#ifndef SOLVER_RIM_NODE_SHEAR_H
#define SOLVER_RIM_NODE_SHEAR_H

#include "rim_cloth.h"
#include "solver/net/shear.h"
#include "solver/result.h"

struct node_shear_place {
    int32_t i, j;
    bool searched, known, grown, rough;
    double shear_deg, error_deg; /* the error's bound of the result's nodes; of others -1 */
};

/* A cell with the places around it, those of its corners in the middle. */
struct node_shear_cell {
    int32_t i, j;
    bool loaded, grown; /* a corner is */
    bool known[4];      /* the corners, (i, j), (i + 1, j), .. */
    bool cubic;         /* all places are known, and none is rough */
    double shear_deg[4][4];
};

struct node_shear {
    struct march *march;
    const struct drape_nodes *nodes; /* sorted by j, then i */
    const size_t *rows; /* the number of the first of each row from theirs on, and of them all */
    struct net_view view;
    struct node_shear_place *places; /* nodes and ghosts, those looked at last, .. */
    int32_t across;                  /* .. of a square, a power of two */
    struct node_shear_cell cell[4];  /* the last ones: (i, j) at i % 2 + 2 (j % 2) */
    bool rough;                      /* the net has rough edges */
    enum shear_order order;          /* of ghosts, as of nodes */
};

/* Of a complete net with its result's nodes, in the march's arena. Errors: STATUS_OUT_OF_MEMORY. */
enum status node_shear_make(struct march *march, const struct drape_nodes *nodes,
                            struct node_shear *shear) STATUS_MUST_USE;

/* The shear at (p, q) in degrees, -90..90, by those nodes and ghosts around it that are known;
 * false when none of its cell's corners is. `grown` (may be NULL) gets whether one of them is
 * grown. */
bool node_shear_between(struct node_shear *shear, double p, double q, double *shear_deg,
                        bool *grown);

/* The greatest error of the shear at the nodes of the result by which that at (p, q) is told, of a
 * result that has them, and what a greatest shear there misses of one between nodes: degrees. */
double node_shear_error(struct node_shear *shear, double p, double q);

#endif
