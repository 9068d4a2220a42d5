/* SPDX-License-Identifier: MIT */
/* Courses that may lie on a part, and what is said of others: of a ply, and of a study. */
#ifndef API_LAMINATE_COURSE_LIMITS_H
#define API_LAMINATE_COURSE_LIMITS_H

#include "laminate.h"

struct course_limits {
    const struct drape_part *part;
    const struct api_unit *unit;
    char prefix[32]; /* of the pointers, for example "/plies/0" */
    struct api_problem *problem;
};

/* What the solver takes of courses of the cloth of a drape. */
void course_limits_settle(const struct courses_settings *lay, const struct drape_settings *drape,
                          struct courses_settings *settings);

/* Whether courses so wide, and so far from each other, may lie on the part, and along their path.
 * API_INVALID_REQUEST. */
enum api_problem_id course_limits_check(const struct course_limits *limits,
                                        const struct courses_settings *settings) STATUS_MUST_USE;

/* Says what is wrong with a member, for example "/courses/gap". */
enum api_problem_id course_limits_refuse(const struct course_limits *limits, enum api_problem_id id,
                                         const char *member, const char *detail);

#endif
