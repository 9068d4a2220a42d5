/* SPDX-License-Identifier: MIT */
/*
 * The HTTP front: sockets, framing, limits and waiting. It turns bytes into `struct request`, hands
 * that to the handler it was started with and sends the reply; it knows no resource.
 *
 * Threads: libmicrohttpd's own (epoll) call the handler; a request that has to wait is suspended
 * and holds no thread, and one timer thread resumes those whose time is up. A request that waits
 * and whose client has closed its side of the connection ends within about a second, unanswered.
 * All functions but `http_watch` are called from the main thread.
 *
 * The order of a shutdown: `http_drain`, then the dispatcher's own draining, then `http_stop`, then
 * the store may be closed.
 */
#ifndef SERVER_HTTP_HTTP_H
#define SERVER_HTTP_HTTP_H

#include "reply.h"
#include "request.h"
#include "server/job_events.h"
#include <stdbool.h>
#include <stdint.h>

struct config;
struct http;

enum http_next {
    HTTP_DONE, /* the reply is complete */
    HTTP_WAIT  /* call again after a change of what `http_watch` names, or at `request->wake_at` */
};

/* What answers requests. Any thread; the calls for one request come one at a time. */
struct http_handler {
    void *context; /* first argument of every function; borrowed */

    /* Called with the head, before the body: checks all that can be checked without the body. May
     * set the request's `limit` and `quiet`. True: the reply is complete, the body is not needed.*/
    bool (*check_head)(void *context, struct request *request, struct reply *reply);

    /* Called with the whole request if `check_head` was false. After HTTP_WAIT it is called again
     * from its beginning; with `request->stopping` it must be done. */
    enum http_next (*handle)(void *context, struct request *request, struct reply *reply);

    /* Called once for every request that is over, `us` microseconds after it began; `request` NULL
     * for one that was never complete, `status` 0 when there was no answer. */
    void (*count)(void *context, const struct request *request, int status, int64_t us);
};

/* All of it is borrowed and must outlive the front. */
struct http_settings {
    const struct config *config;
    struct job_events *events; /* what `http_watch` subscribes to */
    struct http_handler handler;
};

/* Binds, listens and serves. On false nothing runs, and the reason was logged. */
bool http_start(const struct http_settings *settings, struct http **http)
    __attribute__((warn_unused_result));

/* The port in use; the one the system chose when the configuration said 0. */
uint16_t http_port(const struct http *http);

/* Takes no new connections (those to an inherited socket wait for the next daemon) and marks
 * requests as `draining`; what is under way goes on, waiting requests as well. */
void http_drain(struct http *http);

/* Makes every waiting request answer with what there is now, gives answers under way two seconds to
 * be sent, closes all connections and frees `http`. NULL is allowed. */
void http_stop(struct http *http);

/* For handlers: counts the request as one of its owner's event streams and waiting calls until it
 * is over. False when the owner has as many as it may: the reply says so, 429. More than once is as
 * once. */
bool http_take_stream(struct request *request, struct reply *reply);

/* For handlers: from now until the request is over, news of `subject` (a job's id) that are not
 * listed behind `least` make a handler or stream that waits be called again. Call it before the
 * look at the store that decides whether to wait. One subject a request: a later one takes the
 * place of the one before. */
void http_watch(struct request *request, const char *subject, enum job_event least);

#endif
