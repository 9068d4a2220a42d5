/* SPDX-License-Identifier: MIT */
/*
 * A surface to look at: binary glTF with one primitive a face, in the order of the faces, whose
 * `extras` have its number, name and kind. Triangles on a grid of each face's domain, cut along its
 * trims: for the eye, not for numbers.
 */
#ifndef API_REQUEST_PREVIEW_H
#define API_REQUEST_PREVIEW_H

#include "api/problem.h"
#include "api/sink.h"
#include "request.h"
#include "solver/arena.h"

/* Writes the preview of a definition (not API_SURFACE_NAMED). Problems: API_OUT_OF_MEMORY,
 * API_DEGENERATE_SURFACE when no face has an area, API_UNAVAILABLE when the sink takes no more. */
enum api_problem_id api_preview(const struct api_surface *surface, const struct api_sink *sink,
                                struct arena *arena, struct api_problem *problem) STATUS_MUST_USE;

#endif
