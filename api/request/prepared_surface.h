/* SPDX-License-Identifier: MIT */
/* The surface of a request, made ready for the solver, and described for its store. */
#ifndef API_REQUEST_PREPARED_SURFACE_H
#define API_REQUEST_PREPARED_SURFACE_H

#include "api/limits.h"
#include "api/problem.h"
#include "prepared_shell.h"
#include "request.h"
#include "solver/arena.h"
#include "solver/part.h"
#include "solver/surface/loops.h"

/* Bytes of `surface_span_bytes` beyond which a surface is not made ready only to be looked at: the
 * spans of 512 x 512 control points of degree 9 take 800 MB, which a job has and a check has not.
 */
#define PREPARED_SPANS_MAX (INT64_C(64) << 20)

/* Whether a surface of one face or a shell is. */
bool prepared_surface_is_large(const struct api_surface *surface);

/* The part of a request, ready for the solver. */
struct prepared_part {
    struct drape_part part;
    struct prepared_shell shell; /* with the numbers of its faces, if it is one; the solver counts
                               the start's face by shell.start_face */
};

/*
 * Makes the part of a decoded request in `arena`. Refuses at once a spacing so small that covering
 * the area, or the extent where that is less, would take more than `limits->max_nodes` (not asked
 * when only one direction has an extent); cheap enough to be asked before a job is queued.
 * Problems: API_DEGENERATE_SURFACE (no area), API_INVALID_REQUEST (spacing, offset),
 * API_OUT_OF_MEMORY; of shells and meshes as of `prepared_shell_make` and `prepared_mesh_make`.
 */
enum api_problem_id prepared_part_make(const struct api_request *request,
                                       const struct api_limits *limits, struct arena *arena,
                                       struct prepared_part *shape,
                                       struct api_problem *problem) STATUS_MUST_USE;

/* Adds that `what` cannot be moved by `offset` near `at`, for its radius of curvature or, with a
 * radius of 0, a fold. */
enum api_problem_id prepared_surface_offset_fault(struct api_problem *problem, double offset,
                                                  const char *what, struct vec3 at, double radius,
                                                  double fold_deg);

/* Adds at `pointer` what is wrong with a loop of the trims of `what`. */
enum api_problem_id prepared_surface_loop_fault(struct api_problem *problem, const char *pointer,
                                                const char *what, const struct loop_fault *fault);

/*
 * The document of a stored surface: id, degree_u, degree_v, size_u, size_v, rational, closed_u,
 * closed_v, bounding_box and area; of a shell id, faces, edges, tolerance, components, notes,
 * bounding_box, area and, where it is known, length_unit. Zero-terminated, in `arena`; NULL with
 * `problem` set to API_DEGENERATE_SURFACE, API_INVALID_REQUEST (a triangle mesh) or
 * API_OUT_OF_MEMORY.
 */
const char *prepared_surface_describe(const struct api_surface *surface, struct arena *arena,
                                      struct api_problem *problem);

#endif
