/* SPDX-License-Identifier: MIT */
/*
 * What a study varies of a ply's courses: some of their distances, origins and widths, as a list of
 * unknowns, each of which has a range. A list of them is a plan, by which courses are laid.
 *
 * Unknowns in order: of the first near edge its distances from the line, of each next course its
 * distances from the one before, of each course its origin, and its width. Of a list of widths the
 * unknown is the place in the list, rounded down. Courses beyond `count` are as the last one.
 */
#ifndef API_STUDY_COURSE_PLAN_H
#define API_STUDY_COURSE_PLAN_H

#include "api/laminate/laminate.h"

enum { STUDY_COURSES_MAX = 32 };

/* How a member is varied. */
struct study_span {
    size_t points; /* values of it; 0: it stays as it is */
    double from, to;
};

struct study_courses {
    const struct laminate_courses *base; /* as the study has them; NULL: it lays none */
    size_t count;                        /* courses with values of their own, at least 1 */
    struct study_span first, gap, origin, width;
    const double *widths; /* that there are, of which each course has one; NULL: any of the span */
    size_t width_count;
    struct vec3 wanted; /* where warp should run; zero: not asked */
};

size_t course_plan_unknowns(const struct study_courses *courses);

/* The range of unknown k. */
struct study_span course_plan_span(const struct study_courses *courses, size_t k);

/* The unknowns of the courses as the study has them, as far as their ranges allow. */
void course_plan_begin(const struct study_courses *courses, double *unknowns);

/* Courses with all their values; `lay` points into it. */
struct course_plan {
    size_t count; /* courses with values of their own */
    double first[COURSES_VALUES_MAX], gap[STUDY_COURSES_MAX][COURSES_VALUES_MAX];
    double origin[STUDY_COURSES_MAX], width[STUDY_COURSES_MAX];
    struct courses_offset gaps[STUDY_COURSES_MAX];
    struct courses_settings lay; /* all but its drape */
};
void course_plan_make(const struct study_courses *courses, const double *unknowns,
                      struct course_plan *plan);

#endif
