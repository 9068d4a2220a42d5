/* SPDX-License-Identifier: MIT */
/*
 * From the bytes of a request to `struct api_request`. Nothing is guessed: an unknown key, a wrong
 * type, a missing key or a value out of its range is an `invalid-request` whose places are JSON
 * pointers into the document as it was sent; independent errors are reported together, up to
 * API_ERRORS_MAX. Bytes that are no JSON are `malformed-json`, with line and column in the detail;
 * documents over a limit are `too-large` before they are parsed.
 *
 * Ranges that the contract leaves open: coordinates and knots lie within +-1e12; lengths, weights
 * and the length of the parameter domain within 1e-12..1e12, so that no product of them overflows.
 */
#ifndef API_REQUEST_DECODE_H
#define API_REQUEST_DECODE_H

#include "api/input.h"
#include "api/limits.h"
#include "api/problem.h"
#include "request.h"
#include "solver/arena.h"

/*
 * Decodes `input->request` into `request`, whose arrays lie in `arena`. A surface given by id is
 * taken from `input->surface`; when that is empty the request is still checked as far as possible
 * and its surface is API_SURFACE_NAMED, so that the caller can look the id up and decode again.
 * Returns API_OK, API_MALFORMED_JSON, API_TOO_LARGE, API_INVALID_REQUEST or API_OUT_OF_MEMORY, with
 * `problem` (which must be zero-initialised or unset) saying where.
 */
enum api_problem_id api_decode(const struct api_input *input, const struct api_limits *limits,
                               struct arena *arena, struct api_request *request,
                               struct api_problem *problem) STATUS_MUST_USE;

/* The same for a surface alone, as `POST /v1/surfaces` takes it; pointers start at the surface. */
enum api_problem_id api_decode_surface(const char *bytes, size_t length,
                                       const struct api_limits *limits, struct arena *arena,
                                       struct api_surface *surface,
                                       struct api_problem *problem) STATUS_MUST_USE;

/* A permeability, alone or as that member of a document: of the rest nothing is looked at. */
enum api_problem_id api_decode_permeability(const char *bytes, size_t length,
                                            const struct api_limits *limits, struct arena *arena,
                                            struct api_permeability *permeability,
                                            struct api_problem *problem) STATUS_MUST_USE;

#endif
