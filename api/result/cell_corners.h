/* SPDX-License-Identifier: MIT */
/*
 * The corners of a result's cells as rows of its node table. Both tables are sorted by j, then i,
 * so that three readers that only move forward find all corners: one on the cells, one on the nodes
 * of the cell's own row, one on those of the row above.
 */
#ifndef API_RESULT_CELL_CORNERS_H
#define API_RESULT_CELL_CORNERS_H

#include "columns.h"
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { CELL_CORNERS_BLOCK = 512 };

/* A reader of the places (i, j) of a table, one after the other. */
struct site_reader {
    const struct api_reader *reader;
    const struct api_column *column[2]; /* i, j */
    size_t row, first, held;            /* the current row; what is in the block */
    double block[2][CELL_CORNERS_BLOCK];
};

struct cell_corners {
    struct site_reader cells, low, high;
};

/* Starts at the first cell. False when the result has no columns i and j of nodes and cells, or
 * more nodes than int32_t counts. */
bool cell_corners_begin(struct cell_corners *quads, const struct api_reader *reader,
                        const struct api_columns *columns);

/* The next `count` cells, as rows of the nodes (i, j), (i+1, j), (i+1, j+1), (i, j+1); and their i
 * and j unless `places` is NULL. False when they cannot be read or lack a corner. */
bool cell_corners_next(struct cell_corners *quads, size_t count, int32_t (*corners)[4],
                       int32_t (*places)[2]);

#endif
