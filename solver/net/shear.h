/* SPDX-License-Identifier: MIT */
/*
 * The shear angle gamma = 90 deg - w, w the angle between warp and weft, at nodes from difference
 * stencils along the yarns and over cells from their four corners. A row of places is computed at
 * once, in vector instructions; those at the ends of yarns one by one.
 */
#ifndef SOLVER_NET_SHEAR_H
#define SOLVER_NET_SHEAR_H

#include "net.h"

/* The accuracy of the stencils at nodes: centred where the yarn goes on to both sides, one-sided of
 * the same order at its ends, of a lower order on yarns that are too short. */
enum shear_order { SHEAR_SECOND = 2, SHEAR_FOURTH = 4 };

/* A row of a tile. */
enum { SHEAR_PLACES = NET_TILE };

/* The farthest place that a stencil reaches: that of most nodes, and one at the end of a yarn. */
enum { SHEAR_REACH = 2, SHEAR_REACH_AT_END = 4, SHEAR_ROWS = 2 * SHEAR_REACH + 1 };

/* The nodes round a row of a tile, x, y and z apart: those of row y + n - SHEAR_REACH, from
 * x = -SHEAR_REACH on. */
struct shear_block {
    double r[3][SHEAR_ROWS][SHEAR_PLACES + 2 * SHEAR_REACH];
    uint32_t place[SHEAR_ROWS]; /* bits: it has a place there; where not r is of no use */
};

/* Coordinate k of the nodes of the block's own row, from x on. */
static inline const double *shear_places(const struct shear_block *block, int k, int x) {
    return &block->r[k][SHEAR_REACH][SHEAR_REACH + x];
}

/* The directions of the two yarns at the places of a row, x, y and z apart; of any length, 0 where
 * no yarn passes. */
struct shear_row {
    double warp[3][SHEAR_PLACES], weft[3][SHEAR_PLACES];
};

void shear_load(struct shear_block *block, const struct net_window *window, int y);

/* The directions at the nodes of the block's row, by the stencil that most nodes have. Returns the
 * places at which both yarns have all of its nodes, as bits; at others what stands there is of no
 * use. */
uint32_t shear_nodes(const struct shear_block *block, enum shear_order order,
                     struct shear_row *row);

/* Sets those of the node (x, y) of a window, which must have a place, by the best stencil. */
void shear_node(struct shear_row *row, const struct net_window *window, int x, int y,
                enum shear_order order);

/* The mean directions of the cells with the corners (x, y), (x + 1, y), (x + 1, y + 1), (x, y + 1)
 * for the block's row, as they are in the surface. With a, b, c what the second fundamental form
 * takes from e warp and weft f of the cell, (e, e), (e, f) and (f, f), geodesic triangles at its
 * corners have e . f = that of the chords + b (a + c) / 6, and the sums of opposite sides' chords
 * are shorter than they are by shares of (a^2 / 3 + b^2) / 8 e^2 and (c^2 / 3 + b^2) / 8 f^2, these
 * being the sums; a, b and c are second differences of the
 * nodes. The means are turned against each other by that. Also the area of each: half the cross
 * product of the diagonals, to second order that of a curved quadrilateral. Returns the places
 * whose yarns go on to both sides, as bits; at others only the area is of use. */
uint32_t shear_cells(const struct shear_block *block, struct shear_row *row, double *area);

/* Sets those of the cell from (x, y) of a window. Where it is `rough` its means are not turned. */
void shear_cell(struct shear_row *row, const struct net_window *window, int x, int y, bool rough);

/* A shear angle in degrees, of which what is rounding, less than 5e-9, is 0. */
double shear_rounded(double shear_deg);

/* That between two directions of any length, -90..90. */
double shear_between_deg(const struct vec3 along[2]);

/* Replaces the directions of a place, unit vectors, by those with the angle w between them and the
 * same plane and bisector. */
void shear_set_angle(struct vec3 *warp, struct vec3 *weft, double w_deg);

/* Makes unit vectors of them. */
void shear_normalise(struct shear_row *row);

/* The shear angles of the row's places in degrees, -90..90; 0 where only one yarn passes, and
 * for what is rounding. */
void shear_angles(const struct shear_row *row, double *shear_deg);

#endif
