/* SPDX-License-Identifier: MIT */
/*
 * Request bytes in, result bytes out: the one function that worker process, command line, tests and
 * fuzzers share. No files, no clock beyond the solve time it reports, no network.
 */
#ifndef API_RUN_H
#define API_RUN_H

#include "../solver/drape.h"
#include "problem.h"
#include <stdbool.h>
#include <stddef.h>

/* What one job may cost. Zero-initialised fields are not allowed: see `api_limits_default`. */
struct api_limits {
    size_t max_nodes;          /* nodes in one net */
    size_t max_memory;         /* bytes the job's arena may hold */
    size_t max_elements;       /* JSON values in the body, counted before parsing: `prescan.h` */
    size_t max_control_points; /* of one surface */
    int max_depth;             /* JSON nesting */
    int threads;               /* threads on one drape */
};

/* 4e6 nodes, 4 GiB, 4e6 elements, 1e6 control points, depth 32, one thread. */
extern const struct api_limits api_limits_default;

/* The documents of one job, not zero-terminated, owned by the caller. `surface` is the stored
 * surface the request names by id; length 0 when the request carries its own. */
struct api_input {
    const char *request;
    size_t request_length;
    const char *surface;
    size_t surface_length;
};

/* Takes the result's bytes (the container of `columns.h`) in order; false stops the run. */
struct api_sink {
    bool (*write)(void *context, const void *bytes, size_t length);
    void *context;
};

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
