/* SPDX-License-Identifier: MIT */
/*
 * Which resource answers which method and path: one table, from which 404, 405 with `Allow`,
 * OPTIONS, HEAD, the check of media types and of query parameters follow.
 *
 * A handler fills the reply and returns ROUTES_DONE. One that has to wait calls `http_watch`, THEN
 * looks at the store, sets `request->wake_at` and returns ROUTES_WAIT: it is called again from its
 * beginning after a change or at that time, and must be done when `request->stopping`. What it has
 * to remember between two calls is `request->state`.
 */
#ifndef SERVER_RESOURCES_ROUTES_H
#define SERVER_RESOURCES_ROUTES_H

#include "server/http/http.h"
#include "server/http/reply.h"
#include "server/http/request.h"
#include <stdbool.h>

enum routes_next { ROUTES_DONE, ROUTES_WAIT };

/* Called with the headers, before the body: finds the route and checks all that can be checked
 * without the body. True: the reply says what is wrong and the body is not needed. */
bool routes_screen(const struct http_services *services, struct request *request,
                   struct reply *reply);

/* The largest body that the request may have, and the flag that says so. */
struct routes_limit {
    int64_t bytes;
    const char *flag;
};

/* After `routes_screen`; also for a request without a route. */
struct routes_limit routes_limit(const struct http_services *services,
                                 const struct request *request);

/* The answer to a request that was not screened out, with its body. */
enum routes_next routes_handle(const struct http_services *services, struct request *request,
                               struct reply *reply);

/* Counts a request that is over, for /metrics; NULL for one that never was whole; `status` 0 when
 * there was no answer; `us` microseconds after it began. */
void routes_count(const struct request *request, int status, int64_t us);

/* Whether its access log line is of little interest: probes and scrapes. */
bool routes_quiet(const struct request *request);

#endif
