/* SPDX-License-Identifier: MIT */
/*
 * What could not be done, as the caller will read it (RFC 9457). One list names every problem of
 * the service; the solver's statuses are mapped onto it in `run.c`. The first one wins: setting a
 * problem that is already set changes nothing.
 *
 * How the functions of api/ tell that they failed:
 * - One that can fail for a reason of the caller's has `struct api_problem *problem` as its last
 *   argument, says there what is wrong, and returns its id: API_OK when all is well. Written in one
 *   line: `return api_problem_set(problem, API_CONFLICT, "...")`.
 * - A step of reading or writing a document (the decoder of a member, the reader of a mesh's line,
 *   a hook of a format) reports to the problem of the whole, a decoder with a pointer to the value
 *   (`json/value.h`), and returns whether all was well. Decoders go on after an error, so that one
 *   answer lists all of them.
 * - One without a problem can fail in one way, which its header names (memory, nothing found): it
 *   returns NULL or false.
 */
#ifndef API_PROBLEM_H
#define API_PROBLEM_H

#include <stdbool.h>
#include <stddef.h>

/* X(id, slug, HTTP status, title) */
#define API_PROBLEM_LIST(X)                                                                        \
    X(MALFORMED_JSON, "malformed-json", 400, "The body is not JSON")                               \
    X(BAD_REQUEST, "bad-request", 400, "The request is not well-formed HTTP")                      \
    X(UNAUTHORIZED, "unauthorized", 401, "A token is needed")                                      \
    X(FORBIDDEN, "forbidden", 403, "This is not allowed")                                          \
    X(NOT_FOUND, "not-found", 404, "No such resource")                                             \
    X(RESULT_NOT_READY, "result-not-ready", 404, "The drape has not ended yet")                    \
    X(METHOD_NOT_ALLOWED, "method-not-allowed", 405, "The resource does not take this method")     \
    X(NOT_ACCEPTABLE, "not-acceptable", 406, "The result is not available in this format")         \
    X(TIMEOUT, "request-timeout", 408, "The request took too long to arrive")                      \
    X(CONFLICT, "conflict", 409, "The resource is in use")                                         \
    X(GONE, "gone", 410, "The result has expired")                                                 \
    X(TOO_LARGE, "too-large", 413, "The request is over a limit")                                  \
    X(TARGET_TOO_LONG, "target-too-long", 414, "The path and query are too long")                  \
    X(UNSUPPORTED_MEDIA_TYPE, "unsupported-media-type", 415, "The body is of another kind")        \
    X(RANGE, "range-not-satisfiable", 416, "The result has no such bytes")                         \
    X(INVALID_REQUEST, "invalid-request", 422, "The request cannot be understood")                 \
    X(IDEMPOTENCY_MISMATCH, "idempotency-mismatch", 422, "The key was used with another body")     \
    X(START_OFF_SURFACE, "start-off-surface", 422, "The start is not on the surface")              \
    X(DEGENERATE_SURFACE, "degenerate-surface", 422, "The surface has no tangent plane there")     \
    X(UNREADABLE_FILE, "unreadable-file", 422, "The file cannot be imported")                      \
    X(QUEUE_FULL, "queue-full", 429, "Too many drapes are waiting")                                \
    X(QUOTA, "quota-exceeded", 429, "A quota of the caller is used up")                            \
    X(HEADERS_TOO_LARGE, "headers-too-large", 431, "The headers are too large")                    \
    X(CANCELLED, "cancelled", 409, "The drape was cancelled")                                      \
    X(SOLVER_CRASHED, "solver-crashed", 500, "The solver crashed on this drape")                   \
    X(JOB_TIMEOUT, "job-timeout", 500, "The drape took longer than allowed")                       \
    X(OUT_OF_MEMORY, "out-of-memory", 500, "The drape needs more memory than allowed")             \
    X(INTERNAL, "internal", 500, "The service failed")                                             \
    X(DAMAGED, "damaged", 500, "What is stored is not what was written")                           \
    X(UNAVAILABLE, "unavailable", 503, "The service cannot answer now")                            \
    X(HTTP_VERSION, "http-version-not-supported", 505, "The service speaks HTTP/1.1")

enum api_problem_id {
    API_OK = 0,
#define X(id, slug, status, title) API_##id,
    API_PROBLEM_LIST(X)
#undef X
        API_PROBLEM_COUNT
};

enum {
    API_POINTER_MAX = 128,
    API_DETAIL_MAX = 256,
    API_ERRORS_MAX = 16 /* independent errors reported at once */
};

struct api_problem_error {
    char pointer[API_POINTER_MAX]; /* JSON pointer (RFC 6901); "" is the whole document */
    char detail[API_DETAIL_MAX];   /* a sentence: what is wrong and what would be right */
};

struct api_problem {
    enum api_problem_id id;                         /* API_OK: nothing is wrong */
    bool has_pointer;                               /* whether error[0].pointer means something */
    size_t count;                                   /* errors used, 1.. once set */
    struct api_problem_error error[API_ERRORS_MAX]; /* the first is the problem's own */
};

const char *api_problem_slug(enum api_problem_id id);
const char *api_problem_title(enum api_problem_id id);
int api_problem_status(enum api_problem_id id); /* the HTTP status */

/* The id whose slug this is; API_INTERNAL for an unknown one. */
enum api_problem_id api_problem_from_slug(const char *slug);

/* Sets the problem with a printf-style detail. Returns the problem's id: `id`, or that of the
 * problem that was set before; so `return !api_problem_set(...)` answers false. */
enum api_problem_id api_problem_set(struct api_problem *problem, enum api_problem_id id,
                                    const char *detail, ...) __attribute__((format(printf, 3, 4)));

/* The same with a pointer to the value that is wrong. */
enum api_problem_id api_problem_set_at(struct api_problem *problem, enum api_problem_id id,
                                       const char *pointer, const char *detail, ...)
    __attribute__((format(printf, 4, 5)));

/* Adds an error at a value: a problem that was API_OK becomes `invalid-request`. Errors beyond
 * API_ERRORS_MAX are dropped. Returns the problem's id. */
enum api_problem_id api_problem_add(struct api_problem *problem, const char *pointer,
                                    const char *detail, ...) __attribute__((format(printf, 3, 4)));

/* Sets API_OUT_OF_MEMORY; `what` ("the surface") is what the memory was for. */
enum api_problem_id api_problem_no_memory(struct api_problem *problem, const char *what);

/* The problem+json document, without request_id when that is NULL. A malloc'ed string that the
 * caller frees; NULL without memory. */
char *api_problem_json(const struct api_problem *problem, const char *request_id);

#endif
