/* SPDX-License-Identifier: MIT */
/*
 * What is cut: the polygons of the cloth in the coordinates (p, q) of the net. They are the rim
 * where the cloth reaches all of it, else, and in a result without a rim, the outline of the cloth.
 */
#ifndef API_RESULT_FLAT_PATTERN_H
#define API_RESULT_FLAT_PATTERN_H

#include "columns.h"
#include "polygons.h"

/* A mark on the edge, where a generator crosses it or where the lips of a cut meet when sewn: a
 * place, and the direction into the cloth, of length 1 on a net of equal spacings: along the yarn,
 * or at right angles to the lip. */
struct pattern_notch {
    double p, q, in[2];
};

/* Some of the edge where the net ended though the part goes on. */
enum pattern_end { PATTERN_END_BARE, PATTERN_END_COLLAPSED /* the yarns became parallel */ };
struct pattern_front {
    double from[2], to[2]; /* p, q; the cloth is on its left */
    enum pattern_end end;
};

struct flat_pattern {
    struct polygons polygons;     /* a point's `part` is 0, along both lips of cut k it is k + 1 */
    struct pattern_front *fronts; /* malloc'ed; none where the cloth meets itself */
    size_t front_count;
    struct pattern_notch *notches; /* malloc'ed */
    size_t notch_count;
    size_t generator_notches; /* the first of them; the others are of lips */
};

/* Makes the polygons, within `tolerance` of the rim, of what `pattern` (zero-initialised) is to
 * hold. API_OUT_OF_MEMORY, or API_INTERNAL when the container is damaged. The caller frees it in
 * any case. */
enum api_problem_id flat_pattern_make(struct flat_pattern *pattern, const struct api_reader *reader,
                                      const struct api_columns *columns, double tolerance,
                                      struct api_problem *problem) STATUS_MUST_USE;

/* The marks where the generators, x = 0 and y = 0, cross polygons in any unit, at most two for each
 * of their points: how many. */
size_t flat_pattern_generator_notches(const struct polygons *polygons,
                                      struct pattern_notch *notches);

void flat_pattern_free(struct flat_pattern *pattern);

#endif
