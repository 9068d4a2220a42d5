/* SPDX-License-Identifier: MIT */
/*
 * The outline of the cloth of a result in the coordinates (p, q) of the net before it was sheared:
 * closed polygons with the cloth on their left, so that holes turn the other way. The cloth is its
 * cells, those that the rim cuts up to the rim; where the rim is not covered, and passes for
 * nothing, it is the whole cells. That is what `flat_area` of the summary measures.
 *
 * Every cell is enclosed by sides and by pieces of the rim, with the cell on their left. Two cells
 * beside each other have the same side with opposite senses: what is left of all of them where both
 * have it is nothing, and the rest is the outline. Cells that touch at a corner alone have an
 * outline each. Memory grows with the outline's length, not with the area.
 */
#ifndef API_RESULT_OUTLINE_H
#define API_RESULT_OUTLINE_H

#include "columns.h"
#include "polygons.h"

/* The points of the rim, as the columns of a result have them. */
struct outline_rim {
    const double *loop, *p, *q, *covered;
    size_t count;
};

/* Some of a cell's side on the outline, where the net ends: the cloth is on its left. */
struct outline_side {
    double from[2], to[2];
};

struct outline {
    struct polygons polygons; /* with corners only where they follow cells */
    struct outline_side *sides;
    size_t count;
};

/* Makes the outline of what `outline` (zero-initialised) is to hold. API_OUT_OF_MEMORY, or
 * API_INTERNAL when the container cannot be read or its cells are not sorted by j, then i. The
 * caller frees it in any case. */
enum api_problem_id outline_make(const struct api_reader *reader, const struct api_columns *columns,
                                 const struct outline_rim *rim, struct outline *outline,
                                 struct api_problem *problem) STATUS_MUST_USE;

void outline_free(struct outline *outline);

#endif
