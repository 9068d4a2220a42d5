/* SPDX-License-Identifier: MIT */
/*
 * The search for a ply's courses: two evolution strategies (separable CMA-ES: Ros and Hansen, PPSN
 * X, 2008) from the courses as the study has them, each with numbers of its own. A round has a
 * generation of both. They look on a net of up to four times the spacing, then closer round the
 * best on one of twice that; the best few of that are laid at the end with the spacing that is
 * asked for. The first variant is the study's own courses.
 */
#ifndef API_STUDY_COURSE_SEARCH_H
#define API_STUDY_COURSE_SEARCH_H

#include "task.h"

/* The least budget: of one generation for each net. */
enum { COURSE_SEARCH_LEAST = 45 };

enum api_problem_id course_search_plan(const struct api_study *study, const struct study_row *rows,
                                       size_t count, struct arena *arena,
                                       struct api_study_plan *plan,
                                       struct api_problem *problem) STATUS_MUST_USE;

/* Lays the courses of a variant and fills the row, which has the variant. Errors: as
 * `courses_lay`. */
enum status course_search_lay(const struct api_study *study, const struct drape_monitor *monitor,
                              struct arena *arena, struct study_row *row) STATUS_MUST_USE;

/* The columns of the table `courses`, in `arena`: of each variant every distance of every course.
 * How many columns, or SIZE_MAX without memory. */
size_t course_search_columns(const struct api_study *study, const struct study_row *rows,
                             size_t count, struct arena *arena, struct api_column_source *sources);

/* The laminate of variant k of a stored result, as JSON, whose cloth is that of `drape`; NULL with
 * the problem set. */
const char *course_search_request(const struct api_study *study, const struct api_request *drape,
                                  const struct api_reader *result,
                                  const struct api_columns *columns, size_t k, struct arena *arena,
                                  struct api_problem *problem);

#endif
