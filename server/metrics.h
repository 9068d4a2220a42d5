/* SPDX-License-Identifier: MIT */
/*
 * What this process has counted, as Prometheus text. Counters are atomics of the process: any
 * thread, no locks.
 */
#ifndef SERVER_METRICS_H
#define SERVER_METRICS_H

#include <stddef.h>

enum { METRICS_ROUTES_MAX = 48 };

/* One more answer of the route with that number; `status` 0: the client was gone before. */
void metrics_count(size_t route, int status);

/* Calls `visit` for every route and status that was counted. */
void metrics_each(void (*visit)(void *context, size_t route, int status, long count),
                  void *context);

#endif
