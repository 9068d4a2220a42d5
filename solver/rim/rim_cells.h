/* SPDX-License-Identifier: MIT */
/*
 * The cells that the rim cuts. The share of a cell that lies
 * within the rim is exact for the rim's polygons: a piece of an edge in a cell adds its rise to all
 * cells of the row on its left, and the area beside it to its own, as in the filling of letters.
 */
#ifndef SOLVER_RIM_RIM_CELLS_H
#define SOLVER_RIM_RIM_CELLS_H

#include "rim.h"

/* A cell that the rim passes. */
struct rim_cell {
    int32_t i, j;
    double share;  /* of the unsheared cell that lies within the rim, 0..1 */
    double p, q;   /* the middle of the rim in it */
    bool loose;    /* where the cloth does not reach the rim, its share means nothing */
    int32_t inner; /* so many that follow it in its row lie within the rim, which does not pass
                      them; 0 where that is not sure */
    size_t point;  /* of the rim, on whose side of all cuts the most of it lies */
};

struct rim_cells {
    struct rim_cell *cells; /* sorted by j, then i */
    size_t count;
    bool overlaps; /* the rim goes round some of a cell twice, or the wrong way round */
};

/* Finds them, in the march's arena. Errors: STATUS_OUT_OF_MEMORY. */
enum status rim_cells_make(struct march *march, const struct rim *rim,
                           struct rim_cells *cells) STATUS_MUST_USE;

#endif
