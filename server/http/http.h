/* SPDX-License-Identifier: MIT */
/*
 * The HTTP front: sockets, framing, limits and waiting. It turns bytes into `struct http_request`,
 * asks `routes_handle` for the answer and sends it; what the answers are is `routes.h`'s business.
 * `http.c` is the only file that includes microhttpd.h.
 *
 * Threads: libmicrohttpd's own (epoll) call the routes; a call that has to wait is suspended and
 * holds no thread, and one timer thread wakes those whose time is up. A call that waits and whose
 * client has closed its side of the connection ends within about a second, unanswered. All
 * functions here are called from the main thread.
 *
 * The order of a shutdown: `http_drain`, then the dispatcher's own draining, then `http_stop`, then
 * the store may be closed.
 */
#ifndef SERVER_HTTP_HTTP_H
#define SERVER_HTTP_HTTP_H

#include <stdbool.h>
#include <stdint.h>

struct config;
struct store;
struct hub;
struct dispatcher;
struct tokens;
struct mapper;
struct http;

/* What the routes work with. All of it is borrowed and must outlive the front. */
struct http_services {
    const struct config *config;
    struct store *store;
    struct hub *hub;
    struct tokens *tokens;         /* who may call; NULL: everybody */
    struct mapper *mapper;         /* NULL in the role `worker` */
    struct dispatcher *dispatcher; /* NULL in the role `api`: other machines do the work */
};

/* Binds, listens and serves. On false nothing runs, and why was logged. */
bool http_start(const struct http_services *services, struct http **http)
    __attribute__((warn_unused_result));

/* The port in use; the one the system chose when the configuration said 0. */
uint16_t http_port(const struct http *http);

/* Returns when the front's timer and calls can go on, and never when they are stuck in a lock: for
 * who has to know that the front is alive. */
void http_touch(struct http *http);

/* Takes no new connections (those to an inherited socket wait for the next daemon) and refuses new
 * drapes and surfaces (503); everything else goes on: who waits for a running drape still gets it.
 */
void http_drain(struct http *http);

/* Lets every waiting call answer with what there is now, gives answers under way two seconds to
 * leave, closes all connections and frees `http`. NULL is allowed. */
void http_stop(struct http *http);

struct request;

/* For handlers: from now until the request is over, a change of `subject` (a job's id) makes a
 * handler or stream that waits be called again. Call it before the look at the store that decides
 * whether to wait. One subject a request; later calls change nothing. */
void http_watch(struct request *request, const char *subject);

#endif
