/* SPDX-License-Identifier: MIT */
/*
 * One HTTP answer: a status, a few headers and a body of bytes or of a stream. The reply owns its
 * body from the moment it is given, also when something fails later.
 */
#ifndef SERVER_HTTP_REPLY_H
#define SERVER_HTTP_REPLY_H

#include "api/problem.h"
#include <stdbool.h>
#include <stddef.h>
#include <sys/types.h>

enum { REPLY_HEADERS_MAX = 20, REPLY_VALUE_SIZE = 200 };

/* What a stream's `next` may return beside a number of bytes. */
enum {
    REPLY_WAIT = 0,   /* nothing now: call again after `http_watch`'s subject or `wake_at` */
    REPLY_END = -1,   /* complete */
    REPLY_BROKEN = -2 /* give up: the client sees that the body is cut */
};

/* A body that is pulled. One thread at a time, not always the same one. */
struct reply_stream {
    ssize_t (*next)(void *context, char *buffer, size_t size); /* size > 0 */
    void (*free)(void *context);
    void *context;
    size_t block; /* bytes asked for at a time, which a waiting stream keeps; 0: for throughput */
};

struct reply_header {
    const char *name; /* a literal */
    char value[REPLY_VALUE_SIZE];
};

struct reply {
    const char *request_id; /* borrowed: for problem documents */
    int status;             /* 0: nothing is set yet */
    struct reply_header headers[REPLY_HEADERS_MAX];
    size_t header_count;
    char *body;          /* malloc'ed, or NULL */
    const char *literal; /* borrowed for good, in place of `body` */
    size_t length;       /* of the body; of a stream 0 when it is not known */
    bool streamed;
    struct reply_stream stream;
};

/* Frees what the reply holds and empties it. */
void reply_clear(struct reply *reply);

/* Adds a header; a value that is too long or has a control character is left out, so that nothing
 * a caller sent can split a header. */
void reply_header(struct reply *reply, const char *name, const char *format, ...)
    __attribute__((format(printf, 3, 4)));

/* Whether there is such a header; `name` as it was given. */
bool reply_has_header(const struct reply *reply, const char *name);

/* A body of text that the reply takes over and frees; NULL (no memory) becomes a problem. */
void reply_text(struct reply *reply, int status, const char *type, char *text);

/* A body of bytes, malloc'ed, that the reply takes over and frees. */
void reply_bytes(struct reply *reply, int status, const char *type, char *bytes, size_t length);

/* A body that lives for good. */
void reply_literal(struct reply *reply, int status, const char *type, const char *text,
                   size_t length);

/* No body: 204, 304. */
void reply_empty(struct reply *reply, int status);

/* A stream of `length` bytes, 0 when that is not known. */
void reply_stream(struct reply *reply, int status, const char *type, struct reply_stream stream,
                  size_t length);

/* A problem with its own status. The request's id goes into the document. */
void reply_problem(struct reply *reply, const struct api_problem *problem);

/* The same for a problem of one sentence that points to nothing in the body. */
void reply_refuse(struct reply *reply, enum api_problem_id problem, const char *detail, ...)
    __attribute__((format(printf, 3, 4)));

/* The same, and when to come back: `seconds` as Retry-After. */
void reply_refuse_for(struct reply *reply, int seconds, enum api_problem_id problem,
                      const char *detail, ...) __attribute__((format(printf, 4, 5)));

/* 503 where there is no memory for what is asked. */
void reply_no_memory(struct reply *reply);

/* Answers with a problem on the socket itself, for where there is no other way left; the connection
 * has to be closed after it. Does not block: an answer that finds no room is lost. Returns the
 * status. */
int reply_on_socket(int socket, const char *request_id, enum api_problem_id problem,
                    const char *detail);

#endif
