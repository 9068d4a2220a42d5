/* SPDX-License-Identifier: MIT */
/*
 * One HTTP request as handlers see it: method, decoded path segments and query, headers, body.
 * It is plain memory, filled by `exchange.c` on one thread at a time; the strings live as long as
 * it.
 */
#ifndef SERVER_HTTP_REQUEST_H
#define SERVER_HTTP_REQUEST_H

#include "server/id.h"
#include "wire.h"
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    REQUEST_SEGMENTS_MAX = 8,
    REQUEST_QUERY_MAX = 32,
    REQUEST_HEADERS_MAX = WIRE_FIELDS_MAX,
    REQUEST_OWNED_MAX = 16, /* values in several lines, or with blanks behind them */
    REQUEST_CALLER_SIZE = 65,
    REQUEST_ID_SIZE = 65, /* a caller's own X-Request-Id: at most 64 characters */
    REQUEST_FAULT_SIZE = 128,
    REQUEST_BODY_IN_HEAP = 32 * 1024 /* bytes; longer ones lie in a memory file */
};

struct request_field {
    const char *name, *value;
};

/* The largest body that a request may have, and the setting that says so. */
struct request_limit {
    int64_t bytes;
    const char *flag;
};

struct route;

struct request {
    char id[REQUEST_ID_SIZE]; /* of X-Request-Id */
    const char *method;
    bool http_1_0;
    char *target;    /* as it was sent; for the log */
    char *authority; /* of an absolute target; else NULL */
    const char *segments[REQUEST_SEGMENTS_MAX];
    size_t segment_count;
    struct request_field query[REQUEST_QUERY_MAX];
    size_t query_count;
    struct request_field headers[REQUEST_HEADERS_MAX];
    size_t header_count;
    char *owned[REQUEST_OWNED_MAX]; /* memory of values that are not as they were sent */
    size_t owned_count;
    char fault[REQUEST_FAULT_SIZE]; /* of the target or the headers; "" for none */

    char *body; /* zero-terminated beyond its length, read-only once it is complete; NULL without */
    size_t body_length, body_capacity;
    int body_file; /* the memory file that a long one is in; -1: none */

    char drape[ID_SIZE];              /* that the call is about, for the log; "" */
    char caller[REQUEST_CALLER_SIZE]; /* whose token it has; "" */
    char owner[REQUEST_CALLER_SIZE];  /* whom it counts for, and what it stores: `owner.h` */
    bool sees_all;                    /* what others own, too */
    const char *link;                 /* the token of a link that it has instead; NULL: none */

    bool local; /* from this machine, and not passed on by a proxy */

    struct request_limit limit; /* of the body */
    bool quiet;                 /* not worth a line of the log each: probes and scrapes */

    void *transport; /* the front's own */
    bool draining;   /* the daemon takes no new work */
    bool stopping;   /* no more waiting: answer now */

    /* The routes' own. */
    const struct route *route;
    const char *parameter;           /* the path's {id} */
    void *state;                     /* between two calls of a handler that waits */
    void (*state_free)(void *state); /* how it is freed; NULL: `free` */
    int64_t wake_at;                 /* `clock_ms` at which to call again a handler that waits */
    int64_t woken_us; /* `clock_us`: what was read since then is what it is called to look at */
    char *decoded;    /* memory of segments and query */
};

/* A new request for a target that `wire_check` passed. What is wrong with its encoding is in
 * `fault`. NULL without memory. */
struct request *request_new(const char *target);
void request_free(struct request *request);

/* Adds a header whose strings live as long as the request; blanks behind the value are left out.
 * Several lines of Accept, Accept-Encoding, If-None-Match or Prefer become one. */
void request_add_header(struct request *request, const char *name, const char *value);

/* Sets `id` from the caller's X-Request-Id if that is 1 to 64 letters, digits, or any of "._:-",
 * else makes a new one. */
void request_choose_id(struct request *request);

/* The value of the first header of that name, in any case of letters, or NULL. */
const char *request_header(const struct request *request, const char *name);

/* The decoded value of the query parameter, or NULL. */
const char *request_query(const struct request *request, const char *name);

/* Whether a body is announced; its length if that is known, else -1. */
bool request_has_body(const struct request *request, int64_t *length);

/* Appends to the body. False without memory. */
bool request_append_body(struct request *request, const char *bytes, size_t length);

/* The body is complete: one in a memory file is sealed, so that it can be given to another process.
 * False without memory. */
bool request_complete_body(struct request *request);

/* Reads a decimal integer of [low, high] that fills the text. */
bool request_parse_int(const char *text, int64_t low, int64_t high, int64_t *value);

#endif
