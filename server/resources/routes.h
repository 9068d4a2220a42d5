/* SPDX-License-Identifier: MIT */
/*
 * Which resource answers which method and path: one table, from which 404, 405 with `Allow`,
 * OPTIONS, HEAD, the check of media types and of query parameters follow.
 */
#ifndef SERVER_RESOURCES_ROUTES_H
#define SERVER_RESOURCES_ROUTES_H

#include "call.h"

/* What the front calls. The services are borrowed. */
struct http_handler routes_handler(const struct services *services);

/* Method and pattern of the route with that number of `metrics_count`; the last stands for requests
 * without a route. False beyond it. */
bool routes_describe(size_t route, const char **method, const char **pattern);

#endif
