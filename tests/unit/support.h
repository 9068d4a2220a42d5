/* SPDX-License-Identifier: MIT */
/* What the unit tests share: random numbers with a printed seed, files, requests as text, and
 * result containers in memory. Paths are relative to the project's folder. */
#ifndef UNIT_SUPPORT_H
#define UNIT_SUPPORT_H

#include "api/problem.h"
#include "api/request/request.h"
#include "api/result/columns.h"
#include "api/run.h"
#include "solver/arena.h"
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* ---- random numbers ---- */

struct random {
    uint64_t state;
};

/* Seeded by `check_seed`. */
struct random random_begin(const char *test);
uint64_t random_bits(struct random *random);
double random_between(struct random *random, double low, double high);
int random_index(struct random *random, int count); /* 0 .. count - 1 */

/* ---- bytes ---- */

/* A growing block of the heap, zero-terminated behind its length. */
struct bytes {
    char *data;
    size_t length, capacity;
};

void bytes_add(struct bytes *bytes, const void *data, size_t length);
void bytes_format(struct bytes *bytes, const char *format, ...)
    __attribute__((format(printf, 2, 3)));
void bytes_free(struct bytes *bytes);

/* The whole file; the test fails when it cannot be read. */
struct bytes file_read(const char *path);

/* `text` with the first `what` in it replaced; the test fails when it is not there. */
struct bytes text_replace(const char *text, const char *what, const char *with);

/* ---- requests ---- */

/* The document tests/unit/requests/NAME.json, one line; the text lives as long as the program.
 * `saddle` is a drape request for z = (x^2 - y^2) / 2 over [-2, 2]^2, `saddle_surface` that surface
 * alone. */
const char *request_text(const char *name);

/* Prepares the library once; to be called by every test that decodes. */
void prepare(void);

/* Decodes a request given as text, without a stored surface. */
enum api_problem_id decode_text(const char *text, struct arena *arena, struct api_request *request,
                                struct api_problem *problem);

/* The description of a surface, made anew, as `prepared_part_describe` gives it. */
const char *describe_text(const struct api_surface *surface, struct arena *arena,
                          struct api_problem *problem);

/* ---- containers ---- */

/* Writes to and reads from a `struct bytes`. */
struct api_sink sink_into(struct bytes *bytes);
struct api_reader reader_over(struct bytes *bytes);

/* Runs a request; the container goes to `bytes`. */
enum api_problem_id run_text(const char *text, struct bytes *bytes, struct api_problem *problem);

#endif
