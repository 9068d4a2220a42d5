/* SPDX-License-Identifier: MIT */
/*
 * The courses of a ply, laid on the part (`solver/courses.h`): each becomes a piece, a drape along
 * the places of its near edge that is as wide as the course.
 */
#ifndef API_LAMINATE_LAID_COURSES_H
#define API_LAMINATE_LAID_COURSES_H

#include "laminate.h"

/* Joints of a ply: the near edges of its courses but the first, as points on the part. */
struct joints {
    const struct vec3 *points;
    const size_t *first; /* of each edge, and one more */
    size_t count;
};

/* Lays the courses of ply k, whose pieces they then are. `below` has the joints of the nearest ply
 * below with courses, and then those of this one; `number` counts plies with courses, from 0.
 * Problems at /plies/K: API_INVALID_REQUEST (what cannot be laid, and why),
 * API_DEGENERATE_SURFACE, API_OUT_OF_MEMORY. */
enum api_problem_id laid_courses_make(const struct laminate *laminate, size_t k, size_t number,
                                      const struct api_limits *limits, struct arena *arena,
                                      struct joints *below, struct laminate_pieces *pieces,
                                      struct api_problem *problem) STATUS_MUST_USE;

#endif
