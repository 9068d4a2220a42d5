/* SPDX-License-Identifier: MIT */
/*
 * What polygons of the plane enclose together, both, or one alone; and the faces between lines.
 * GEOS finds all of it on a grid of 1e-11 of what the arguments span, on which lines that nearly
 * coincide do, so that none of it depends on how near they come.
 *
 * Results are polygons that cross neither themselves nor each other, what they enclose on their
 * left. They are zero-initialised, and freed by the caller in any case. API_OK, API_OUT_OF_MEMORY,
 * or API_INTERNAL with the words of GEOS.
 */
#ifndef API_LAMINATE_PLANE_H
#define API_LAMINATE_PLANE_H

#include "api/problem.h"
#include "api/result/polygons.h"
#include "solver/arena.h"
#include "solver/status.h"
#include <stdint.h>

enum plane_operation { PLANE_EITHER, PLANE_BOTH, PLANE_FIRST_ALONE };

/* Of polygons that overlap or cross themselves counts what they enclose: the union of those that
 * turn left but of those that turn right. */
enum api_problem_id plane_combine(const struct polygons *a, enum plane_operation operation,
                                  const struct polygons *b, struct polygons *result,
                                  struct api_problem *problem) STATUS_MUST_USE;

/* A segment with a number of the caller's. */
struct segment {
    double from[2], to[2];
    int32_t number;
};

/* A list that grows in an arena. */
struct segments {
    struct segment *list;
    size_t count, room;
    struct arena *arena;
};

/* False without memory. */
bool segments_add(struct segments *segments, const double from[2], const double to[2],
                  int32_t number);
bool segments_add_polygons(struct segments *segments, const struct polygons *polygons,
                           int32_t number);

/*
 * The face between segments in which a point lies, none where it lies outside all; what ends
 * without dividing anything is left out. Of each point of the face, in the arena, the segment along
 * which its edge goes on: of segments on each other the first.
 */
enum api_problem_id plane_face(const struct segments *segments, const double at[2],
                               struct polygons *face, const struct segment ***along,
                               struct api_problem *problem) STATUS_MUST_USE;

#endif
