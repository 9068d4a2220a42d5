/* SPDX-License-Identifier: MIT */
/*
 * Squares of nodes that lie apart: no place of one is in the cells round a node of the other, as
 * that one's yarns measure it (`overlap.h`), but for neighbours in the net. With a and b the yarns'
 * steps at a node q and n its normal, these cells are the places q + x a + y b + z n with |x|, |y|
 * less than 1 and |z| no more than half of |a|: along any direction t they reach no further from q
 * than |t . a| + |t . b| + |a| |t . n| / 2. Directions are the means of A and B, which are dual to
 * a and b, and the longer diagonal, along which all yarns lie where the net all but collapses.
 *
 * Next to each other in the net places are not in each other's cells if their x or y are what their
 * numbers i and j in the net say, but for a part of the steps between those that are no neighbours.
 */
#ifndef SOLVER_NET_SEPARATION_H
#define SOLVER_NET_SEPARATION_H

#include "net.h"

/* Nodes on a side of a square, and what that of its cells' corners has. */
enum {
    SEPARATION_SIDE = 4,
    SEPARATION_POINTS = (SEPARATION_SIDE + 1) * (SEPARATION_SIDE + 1),
    SEPARATION_WAYS = 3
};

/* The corners of a square's cells, and their numbers. */
struct separation_points {
    struct vec3 r[SEPARATION_POINTS];
    int32_t at[SEPARATION_POINTS][2];
    int count;
};

struct separation_range {
    double low, high;
};

/* The cells of a square. */
struct separation_frame {
    struct vec3 way[SEPARATION_WAYS]; /* means of A and B, and the diagonal */
    struct separation_range cells[SEPARATION_WAYS];
    struct separation_range beyond[2]; /* along A and B, less the numbers of the nodes */
    double spread[2]; /* the largest difference of a node's A and B from the mean */
    bool known;       /* all its nodes have yarns that cross */
};

/* Of the square that begins at column x and row y of a window: its nodes inside. */
void separation_points(const struct net_window *window, int x, int y,
                       struct separation_points *points);
void separation_frame(const struct net_window *window, int x, int y,
                      struct separation_frame *frame);

/* Whether no place is in the cells of the frame, but those whose numbers both differ by less than
 * `least` from the node's; of those within `reach` of it. */
bool separation_holds(const struct separation_frame *frame, const struct separation_points *points,
                      double reach, double least);

/* Whether a place is not. */
bool separation_holds_at(const struct separation_frame *frame, struct vec3 r);

#endif
