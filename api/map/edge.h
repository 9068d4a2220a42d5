/* SPDX-License-Identifier: MIT */
/*
 * The rim of a stored result in the net's coordinates (p, q), to tell on which side of it a place
 * of the cloth lies. Its loops have the part on their left: a place is within them when they go
 * round it once more to the left than to the right.
 */
#ifndef API_MAP_EDGE_H
#define API_MAP_EDGE_H

#include "api/result/columns.h"

struct edge;

/* Reads the rim into `arena`. Problems: API_INTERNAL, API_OUT_OF_MEMORY. */
enum api_problem_id edge_make(const struct api_reader *reader, const struct api_columns *columns,
                              struct arena *arena, struct edge **edge,
                              struct api_problem *problem) STATUS_MUST_USE;

/* Whether (p, q), right to `slack` spacings, lies beyond the rim. False where there is no rim, and
 * in rows of cells in which it leaves the cloth. */
bool edge_is_beyond(const struct edge *edge, double p, double q, double slack);

#endif
