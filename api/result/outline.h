/* SPDX-License-Identifier: MIT */
/*
 * The outline of a result's cells in steps (i, j) of the unsheared net: closed polygons with
 * corners only, the cells on their left, so that holes turn the other way. Cells that touch at a
 * corner alone have an outline each. Memory grows with the outline's length, not with the area.
 */
#ifndef API_RESULT_OUTLINE_H
#define API_RESULT_OUTLINE_H

#include "columns.h"
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct outline_point {
    int32_t i, j;
    bool last; /* the polygon ends here */
};

struct outline {
    struct outline_point *points; /* malloc'ed */
    size_t count, capacity;
    int32_t low[2], high[2]; /* bounds of i and j; all 0 without cells */
};

/* Makes the outline of what `outline` (zero-initialised) is to hold. API_OUT_OF_MEMORY, or
 * API_INTERNAL when the container cannot be read or its cells are not sorted by j, then i. The
 * caller frees it in any case. */
enum api_problem_id outline_make(struct outline *outline, const struct api_reader *reader,
                                 const struct api_columns *columns,
                                 struct api_problem *problem) STATUS_MUST_USE;

void outline_free(struct outline *outline);

#endif
