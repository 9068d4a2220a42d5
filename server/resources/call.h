/* SPDX-License-Identifier: MIT */
/*
 * A call: what a handler of the table in `routes.c` gets, and what handlers share.
 *
 * A handler fills the reply and returns HTTP_DONE. One that has to wait calls `http_watch`, THEN
 * looks at the store, sets `request->wake_at` and returns HTTP_WAIT: it is called again from its
 * beginning after a change or at that time, and must be done when `request->stopping`. What it has
 * to remember between two calls is `request->state`.
 */
#ifndef SERVER_RESOURCES_CALL_H
#define SERVER_RESOURCES_CALL_H

#include "api/format/format.h"
#include "server/http/http.h"
#include "server/store/store.h"

struct config;
struct dispatcher;
struct document_pool;
struct tokens;
struct stored_result;

/* What handlers work with. All of it is borrowed and outlives the front. */
struct services {
    const struct config *config;
    struct store *store;
    struct tokens *tokens;               /* who may call; NULL: everybody */
    struct document_pool *document_pool; /* NULL in the role `worker` */
    struct form_cache *forms;            /* NULL: there are none */
    struct dispatcher *dispatcher;       /* NULL in the role `api`: other machines do the work */
};

struct call {
    const struct services *services;
    struct request *request;
    struct reply *reply;
    enum store_kind kind;      /* of the jobs that the path is about */
    enum store_item_kind item; /* or of the items */
};

typedef enum http_next call_handler(struct call *call);

enum {
    CALL_WAIT_MAX = 60, /* seconds a call may wait */
    CALL_PAGE = 50,     /* entries of a list when the caller does not say */
    CALL_PAGE_MAX = 1000
};

/* Whose things the caller sees, as the store takes it: NULL for everybody's. */
const char *call_owner(const struct call *call);

/* 503 for a store that is busy or down; also for answers that should not occur; 500 for what is
 * altered of what the path names. HTTP_DONE. */
enum http_next call_store_failed(struct call *call, enum store_answer answer);

/* 500: what the store has under that id is not what was written. HTTP_DONE. */
enum http_next call_altered(struct call *call, const char *id);

/* 503 while the service stops. HTTP_DONE. */
enum http_next call_draining(struct call *call);

/* 429 for an owner that has stored as much as it may. HTTP_DONE. */
enum http_next call_bytes_full(struct call *call);

/* Whether the caller may store so many bytes more. False: the reply says why not. */
bool call_has_room(struct call *call, size_t bytes);

/* 404 for the path's id: there is no such `what`. HTTP_DONE. */
enum http_next call_not_found(struct call *call, const char *what);

/* The job of that id; STORE_EMPTY as well for one that the caller does not see, or of another kind
 * than drapes, studies and laminates. To be cleared in any case. */
enum store_answer call_see_job(struct call *call, const char *id, struct store_job *job);

/* Reads the job of the path, which for others than its owner, and under the path of another kind,
 * is not there. False: the reply says why not. Otherwise the caller clears it. */
bool call_find_job(struct call *call, struct store_job *job);

/* A list's `limit` and `cursor` of the query. False: the reply says what is wrong. */
bool call_read_page(struct call *call, int *limit, int64_t *cursor);

/* 410 or 503: why a stored request cannot be read. HTTP_DONE. */
enum http_next call_request_failed(struct call *call, enum store_answer answer);

/* The job's stored request, malloc'ed. NULL: the reply says why not. */
char *call_stored_request(struct call *call, const char *id, size_t *length);

/* Where the job's result is stored. False: the reply says why not (410, 503). */
bool call_stored_result(struct call *call, const char *id, struct stored_result *stored);

/* How the caller wants a document. */
struct call_choice {
    const struct format *format;
    struct format_options options; /* points into the request */
};

/* Reads it of the request: the format by `?format=`, else by Accept. False: the reply says what is
 * wrong (406, 422). */
bool call_choose(struct call *call, enum format_use use, struct call_choice *choice);

/* When a handler that waits since `begun` should look at the store for itself, now being `now`:
 * often at first, more seldom later, because job events report nearly every change. Milliseconds of
 * `clock_ms`. */
int64_t call_poll_at(int64_t begun, int64_t now);

#endif
