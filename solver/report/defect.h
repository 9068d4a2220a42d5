/* SPDX-License-Identifier: MIT */
/*
 * By how much an edge of a corrected net is longer than the yarn's, from the net itself.
 *
 * Between two nodes d apart along a yarn r(s) the chord c is, with M the mean of the second
 * differences D2 at its ends, D3 their difference and D4 the fourth difference,
 *
 *     c^2 = d^2 s(M) + (5/144 - 1/240) (M . D4 + q M^2) - (1/720) (|D3|^2 - q^2 c^2),
 *
 * but for terms of order d^8; q = M^2 / d^2, and d^2 s is the square of the chord of a circle with
 * this M (`correction.h`), for which the other terms vanish. The correction, made from a first net
 * and without D4, gives another chord: the difference is the edge's defect. A rough edge
 * (`rough.h`) is a geodesic of the length d: its defect is that of a yarn which turns sideways.
 * Other edges without differences, beside rough ones, are longer by what their geodesics are, too.
 */
#ifndef SOLVER_REPORT_DEFECT_H
#define SOLVER_REPORT_DEFECT_H

#include "solver/march/march.h"

struct defect_net {
    const struct march *march;
    struct net_view net; /* its */
    struct surface_cursor cursor;
    const double *spacing;
};

/* In length: what is known of it, with its sign, and what may be wrong with that, > 0. */
struct defect {
    double known, unsure;
};

/* That of the edge from (i, j) to (i + di, j + dj), which must be places of the net; one of di, dj
 * is 0, the other 1 or -1. The view must have been moved to one of its ends or next to it. */
struct defect defect_of(struct defect_net *net, int32_t i, int32_t j, int di, int dj);

/* Of the edges that end in the nodes of a tile and come from the side of the start: their defects,
 * and the unit vectors along them. */
struct defect_tile {
    uint32_t even[NET_TILE]; /* bit x of row y: the differences of both edges that end there reach
                                nothing but plain nodes; the others are left to defect_of */
    double known[2][NET_TILE][NET_TILE], unsure[2][NET_TILE][NET_TILE]; /* [family][y][x] */
    double along[2][NET_TILE][3][NET_TILE]; /* [family][y][coordinate][x] */
};

void defect_of_tile(const struct defect_net *net, const struct net_window *window,
                    struct defect_tile *tile);

/* The angles by which the yarn turns sideways, in the surface, at both ends of the edge from (i, j)
 * to (i + di, j + dj), in radians, each less than 0 where it is not known: the mean of both, or the
 * one that is known. */
double defect_turn(struct defect_net *net, int32_t i, int32_t j, int di, int dj, double end[2]);

#endif
