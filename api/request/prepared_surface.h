/* SPDX-License-Identifier: MIT */
/* A NURBS surface of one face, made ready for the solver. See `prepared_part.h`. */
#ifndef API_REQUEST_PREPARED_SURFACE_H
#define API_REQUEST_PREPARED_SURFACE_H

#include "api/json/text.h"
#include "api/limits.h"
#include "api/problem.h"
#include "request.h"
#include "solver/arena.h"
#include "solver/part.h"
#include "solver/surface/loops.h"

/* Bytes of `surface_span_bytes` beyond which a surface is not made ready only to be looked at: the
 * spans of 512 x 512 control points of degree 9 take 800 MB, which a job has and a check has not.
 */
#define PREPARED_SPANS_MAX (INT64_C(64) << 20)

/* Problems: API_DEGENERATE_SURFACE (no area), API_INVALID_REQUEST (loops of trims, offset,
 * spacing), API_OUT_OF_MEMORY. */
enum api_problem_id prepared_surface_make(const struct api_request *request,
                                          const struct api_limits *limits, struct arena *arena,
                                          struct drape_part *part,
                                          struct api_problem *problem) STATUS_MUST_USE;

/* The same of a surface alone, which is not moved and at which pointers begin. */
enum api_problem_id prepared_surface_make_whole(const struct api_surface *surface,
                                                struct arena *arena, struct drape_part *part,
                                                struct api_problem *problem) STATUS_MUST_USE;

/* The members of its description that are its own. One of very many spans, which is not made ready
 * (`part->surface` is NULL), is measured without keeping them, unless it has trims, whose area
 * takes the whole surface. */
enum api_problem_id prepared_surface_describe(const struct api_surface *surface,
                                              const struct drape_part *part, struct api_text *text,
                                              struct arena *arena,
                                              struct api_problem *problem) STATUS_MUST_USE;

/* Adds that `what` cannot be moved by `offset` near `at`, for its radius of curvature or, with a
 * radius of 0, a fold. */
enum api_problem_id prepared_surface_offset_fault(struct api_problem *problem, double offset,
                                                  const char *what, struct vec3 at, double radius,
                                                  double fold_deg);

/* Adds at `pointer` what is wrong with a loop of the trims of `what`. */
enum api_problem_id prepared_surface_loop_fault(struct api_problem *problem, const char *pointer,
                                                const char *what, const struct loop_fault *fault);

/* Adds that covering `what` takes `nodes`, and so many are not allowed, if that is so. */
enum api_problem_id prepared_surface_check_nodes(double nodes, const char *what,
                                                 const struct api_limits *limits,
                                                 struct api_problem *problem);

#endif
