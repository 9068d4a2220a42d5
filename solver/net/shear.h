/* SPDX-License-Identifier: MIT */
/*
 * The shear angle gamma = 90 deg - w, w the angle between warp and weft, at nodes from difference
 * stencils along the yarns and over cells from their four corners. A row of places is computed at
 * once, which takes a third of the time of one after the other.
 */
#ifndef SOLVER_NET_SHEAR_H
#define SOLVER_NET_SHEAR_H

#include "net.h"

/* The accuracy of the stencils at nodes: centred where the yarn goes on to both sides, one-sided of
 * the same order at its ends, of a lower order on yarns that are too short. */
enum shear_order { SHEAR_SECOND = 2, SHEAR_FOURTH = 4 };

/* The directions of the two yarns at up to SHEAR_PLACES places, x, y and z apart; of any length, 0
 * where no yarn passes. */
enum { SHEAR_PLACES = NET_TILE };

/* The farthest place that a stencil at a node reaches. */
enum { SHEAR_REACH = 2 };
struct shear_row {
    int count;
    double warp[3][SHEAR_PLACES], weft[3][SHEAR_PLACES];
};

/* Adds the node (x, y) of a window, which must have a place. */
void shear_add_node(struct shear_row *row, const struct net_window *window, int x, int y,
                    enum shear_order order);

/* Adds the mean directions of the cell with the corners (x, y), (x + 1, y), (x + 1, y + 1),
 * (x, y + 1) of a window, `corner`, as they are in the surface. With a, b, c what the second
 * fundamental form takes from e warp and weft f of the cell, (e, e), (e, f) and (f, f), geodesic
 * triangles at its corners have e . f = that of the chords + b (a + c) / 6; a, b and c are second
 * differences of the nodes. The means are turned against each other by that, unless the cell is
 * `rough`: then there are none. */
void shear_add_cell(struct shear_row *row, const struct net_window *window, int x, int y,
                    const struct vec3 corner[4], bool rough);

/* Replaces the directions of a place, unit vectors, by those with the angle w between them and the
 * same plane and bisector. */
void shear_set_angle(struct vec3 *warp, struct vec3 *weft, double w_deg);

/* Makes unit vectors of them. */
void shear_normalise(struct shear_row *row);

/* The shear angles of the row's places in degrees, -90..90; 0 where only one yarn passes. */
void shear_angles(const struct shear_row *row, double *shear_deg);

#endif
