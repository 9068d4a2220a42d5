/* SPDX-License-Identifier: MIT */
/*
 * The directory of a result container as JSON: the summary, the grid, the start and what columns
 * there are. Where the columns lie follows from it (`columns.c`).
 */
#ifndef API_RESULT_DIRECTORY_H
#define API_RESULT_DIRECTORY_H

#include "api/json/place.h"
#include "api/json/text.h"
#include "columns.h"

/* The contract's `summary`, with `queue_ms`, or without it when that is negative; and `grid`. */
void directory_write_summary(struct api_text *text, const struct api_summary *summary,
                             double queue_ms);
void directory_write_grid(struct api_text *text, const struct api_grid *grid);

/* The whole directory. */
void directory_write(struct api_text *text, const struct api_columns *columns);

/* Reads it into zero-initialised `columns`, all but offsets and length; what is wrong is reported
 * to the tree's problem. */
void directory_read(const struct tree *tree, struct api_columns *columns);

#endif
