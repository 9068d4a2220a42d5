/* SPDX-License-Identifier: MIT */
/* The triangle mesh of a request as the solver needs it. */
#ifndef API_REQUEST_PREPARED_MESH_H
#define API_REQUEST_PREPARED_MESH_H

#include "api/json/text.h"
#include "api/limits.h"
#include "api/problem.h"
#include "request.h"
#include "solver/mesh/mesh.h"

/*
 * Makes the mesh of a decoded request whose surface is one, in `arena`, and refuses a spacing so
 * small that covering its largest component would take more than `limits->max_nodes`.
 * Problems: API_INVALID_REQUEST at the vertex, the triangle or the spacing; API_OUT_OF_MEMORY.
 */
enum api_problem_id prepared_mesh_make(const struct api_request *request,
                                       const struct api_limits *limits, struct arena *arena,
                                       const struct mesh **mesh,
                                       struct api_problem *problem) STATUS_MUST_USE;

/* The same of a surface alone, of all of it, at which pointers begin. */
enum api_problem_id prepared_mesh_make_whole(const struct api_surface *surface, struct arena *arena,
                                             const struct mesh **mesh,
                                             struct api_problem *problem) STATUS_MUST_USE;

/* The members of a mesh's description that are its own: vertices, triangles, faces, joints,
 * openings, edges, components, bounding_box, area. See `prepared_part_describe`. */
enum api_problem_id prepared_mesh_describe(const struct api_surface *surface,
                                           const struct mesh *mesh, struct api_text *text,
                                           struct arena *arena,
                                           struct api_problem *problem) STATUS_MUST_USE;

#endif
