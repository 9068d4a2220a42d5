/* SPDX-License-Identifier: MIT */
/* The drapes that a laminate consists of. */
#ifndef API_LAMINATE_RUN_H
#define API_LAMINATE_RUN_H

#include "api/sink.h"
#include "laminate.h"
#include "solver/drape.h"

/* The drape request of net n of a laminate that is resolved, zero-terminated in `arena`: one that
 * anybody can post again. NULL without memory. */
const char *laminate_request(const struct laminate *laminate, size_t n, struct arena *arena);

/* Whether the solver could take each drape (`api_check_decoded`). Problems: of all that it could
 * not, at the first ply that has the net. */
enum api_problem_id laminate_check_drapes(const struct laminate *laminate,
                                          const struct api_limits *limits, struct arena *arena,
                                          struct api_problem *problem) STATUS_MUST_USE;

/* Drapes net n as `api_run` does; `surface` is the stored surface that the laminate names, if it
 * does. What is wrong is said of the first ply that has the net. */
enum api_problem_id laminate_run(const struct laminate *laminate, size_t n,
                                 const struct api_input *input, const struct api_limits *limits,
                                 const struct drape_monitor *monitor, const struct api_sink *sink,
                                 struct api_problem *problem) STATUS_MUST_USE;

#endif
