/* SPDX-License-Identifier: MIT */
/* The part of a request (a surface, a shell or a mesh), made ready for the solver, and described
 * for its store. */
#ifndef API_REQUEST_PREPARED_PART_H
#define API_REQUEST_PREPARED_PART_H

#include "api/limits.h"
#include "api/problem.h"
#include "prepared_shell.h"
#include "request.h"
#include "solver/arena.h"
#include "solver/part.h"
#include "solver/surface/surface.h"

struct prepared_part {
    struct drape_part part;
    struct surface_bends bends; /* of a part from a prepared form; else unknown until asked for */
    const struct drape_prepared
        *prepared;               /* likewise, of a shell: what its drapes share; or NULL */
    struct prepared_shell shell; /* with the numbers of its faces, if it is one; the solver counts
                                    faces by their places among these (`prepared_part_settle`) */
};

/* Whether its spans take more than PREPARED_SPANS_MAX. */
bool prepared_part_is_large(const struct api_surface *surface);

/*
 * Makes the part of a decoded request in `arena`. Refuses at once a spacing so small that covering
 * the area, or the extent where that is less, would take more than `limits->max_nodes` (not asked
 * when only one direction has an extent); cheap enough to be asked before a job is queued.
 * Problems: as `prepared_surface_make`, `prepared_shell_make` and `prepared_mesh_make`.
 */
enum api_problem_id prepared_part_make(const struct api_request *request,
                                       const struct api_limits *limits, struct arena *arena,
                                       struct prepared_part *prepared,
                                       struct api_problem *problem) STATUS_MUST_USE;

/* How the part bends; found now, and kept, where it is not known. */
const struct surface_bends *prepared_part_bends(struct prepared_part *prepared);

/* The settings of that request with faces as the solver counts them, and what is ready. Problems:
 * API_INVALID_REQUEST (a generator's place on a face that the part does not have),
 * API_OUT_OF_MEMORY. */
enum api_problem_id prepared_part_settle(const struct prepared_part *prepared, struct arena *arena,
                                         struct drape_settings *settings,
                                         struct api_problem *problem) STATUS_MUST_USE;

/*
 * What follows from a surface alone, whatever is asked for: the part of all of it, and of a shell
 * `all` faces. Of a surface that is large (`prepared_part_is_large`) and of faces that cannot be
 * one surface there is no part; why they cannot is left in `fault`, as are all problems, whose
 * pointers begin at the surface. API_OK nevertheless of a shell, unless memory ran out.
 */
enum api_problem_id prepared_part_make_whole(const struct api_surface *surface, struct arena *arena,
                                             struct prepared_part *whole,
                                             struct api_problem *fault) STATUS_MUST_USE;

/*
 * The document of a stored surface, of which that has been made: id, degree_u, degree_v, size_u,
 * size_v, rational, closed_u, closed_v, bounding_box and area; of a shell id, faces, edges,
 * tolerance, components, notes, bounding_box, area and, where it is known, length_unit; of a mesh
 * likewise. Zero-terminated, in `arena`; NULL with `problem` set to API_DEGENERATE_SURFACE,
 * API_INVALID_REQUEST or API_OUT_OF_MEMORY.
 */
const char *prepared_part_describe(const struct api_surface *surface,
                                   const struct prepared_part *whole,
                                   const struct api_problem *fault, struct arena *arena,
                                   struct api_problem *problem);

#endif
