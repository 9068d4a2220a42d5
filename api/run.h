/* SPDX-License-Identifier: MIT */
/*
 * Request bytes in, result bytes out: the one function that worker process, command line, tests and
 * fuzzers share. No files, no clock beyond the solve time it reports, no network.
 */
#ifndef API_RUN_H
#define API_RUN_H

#include "input.h"
#include "limits.h"
#include "problem.h"
#include "sink.h"
#include "solver/drape.h"
#include <stdbool.h>
#include <stddef.h>

/* Once in each process, before any thread, sandbox or call below: seeds the JSON parser's hashing
 * and sets up libsodium, both of which read the system's randomness. False when there is none. */
bool api_prepare(void) STATUS_MUST_USE;

/* Decodes, drapes and writes the result container to `sink`. `monitor` may be NULL. Returns API_OK
 * or the id it set in `problem` (zero-initialised by the caller). */
enum api_problem_id api_run(const struct api_input *input, const struct api_limits *limits,
                            const struct drape_monitor *monitor, const struct api_sink *sink,
                            struct api_problem *problem) STATUS_MUST_USE;

/* The same within an arena of the caller's, instead of a new one of `limits->max_memory`. */
enum api_problem_id api_run_in(struct arena *arena, const struct api_input *input,
                               const struct api_limits *limits, const struct drape_monitor *monitor,
                               const struct api_sink *sink,
                               struct api_problem *problem) STATUS_MUST_USE;

#endif
