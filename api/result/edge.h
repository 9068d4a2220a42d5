/* SPDX-License-Identifier: MIT */
/*
 * The rim of a stored result in the net's coordinates (p, q), to tell on which side of it a place
 * of the cloth lies. Its loops have the part on their left: a place is within them when they go
 * round it once more to the left than to the right.
 */
#ifndef API_RESULT_EDGE_H
#define API_RESULT_EDGE_H

#include "columns.h"
#include "solver/vec.h"

struct edge;

/* Reads the rim into `arena`. Problems: API_INTERNAL, API_OUT_OF_MEMORY. */
enum api_problem_id edge_make(const struct api_reader *reader, const struct api_columns *columns,
                              struct arena *arena, struct edge **edge,
                              struct api_problem *problem) STATUS_MUST_USE;

/* Whether (p, q), right to `slack` spacings, lies beyond the rim. False where there is no rim, and
 * in rows of cells in which it leaves the cloth. */
bool edge_is_beyond(const struct edge *edge, double p, double q, double slack);

/* Notes of each of these cells, which lie within the rim with their corners and come by j, then i,
 * whether they do so as a whole: that no rim comes near any place of it. */
void edge_find_clear(const struct edge *edge, const int32_t (*cells)[2], size_t count, bool *clear);

/* An end of a stretch of a line q = const. Where the line meets the rim, and cloth reaches that,
 * the point of the part; else not `known`. */
struct edge_end {
    double p;
    bool known;
    struct vec3 point;
};

enum { EDGE_STRETCHES = 16 };

/* The stretches of that line from p = low to p = high within the rim, ascending, of which the rest
 * are left out; all of it where there is no rim. How many. */
size_t edge_stretches(const struct edge *edge, double q, double low, double high,
                      struct edge_end stretches[EDGE_STRETCHES][2]);

#endif
