/* SPDX-License-Identifier: MIT */
/*
 * The rim of a stored result in the net's coordinates (p, q), to tell on which side of it a place
 * of the cloth lies. Its loops have the part on their left: a place is within them when they go
 * round it once more to the left than to the right.
 */
#ifndef API_RESULT_STORED_RIM_H
#define API_RESULT_STORED_RIM_H

#include "columns.h"
#include "solver/vec.h"

struct stored_rim;

/* Reads the rim into `arena`. Problems: API_INTERNAL, API_OUT_OF_MEMORY. */
enum api_problem_id stored_rim_make(const struct api_reader *reader,
                                    const struct api_columns *columns, struct arena *arena,
                                    struct stored_rim **rim,
                                    struct api_problem *problem) STATUS_MUST_USE;

/* Whether (p, q), right to `slack` spacings, lies beyond the rim. False where there is no rim, and
 * in rows of cells in which it leaves the cloth. */
bool stored_rim_is_beyond(const struct stored_rim *rim, double p, double q, double slack);

/* Notes of each of these cells, which lie within the rim with their corners and come by j, then i,
 * whether they do so as a whole: that no rim comes near any place of it. */
void stored_rim_find_clear(const struct stored_rim *rim, const int32_t (*cells)[2], size_t count,
                           bool *clear);

/* An end of a stretch of a line q = const. Where the line meets the rim, and cloth reaches that,
 * the point of the part; else not `known`. */
struct stretch_end {
    double p;
    bool known;
    struct vec3 point;
};

enum { STORED_RIM_STRETCHES = 16 };

/* The stretches of that line from p = low to p = high within the rim, ascending, of which the rest
 * are left out; all of it where there is no rim. How many. */
size_t stored_rim_stretches(const struct stored_rim *rim, double q, double low, double high,
                            struct stretch_end stretches[STORED_RIM_STRETCHES][2]);

#endif
