/* SPDX-License-Identifier: MIT */
#include "metrics.h"
#include <stdatomic.h>

/* The statuses this service answers with; the first stands for all others. */
static const int statuses[] = {0,   200, 201, 202, 204, 206, 304, 400, 401, 403, 404, 405, 406,
                               408, 409, 410, 413, 414, 415, 416, 422, 429, 431, 500, 503, 505};

enum { STATUS_COUNT = sizeof statuses / sizeof *statuses };

static atomic_long answers[METRICS_ROUTES_MAX][STATUS_COUNT];

static size_t status_index(int status) {
    for (size_t k = 1; k < STATUS_COUNT; k++)
        if (statuses[k] == status)
            return k;
    return 0;
}

void metrics_count(size_t route, int status) {
    if (route < METRICS_ROUTES_MAX)
        atomic_fetch_add_explicit(&answers[route][status_index(status)], 1, memory_order_relaxed);
}

void metrics_each(void (*visit)(void *context, size_t route, int status, long count),
                  void *context) {
    for (size_t route = 0; route < METRICS_ROUTES_MAX; route++) {
        for (size_t k = 0; k < STATUS_COUNT; k++) {
            long count = atomic_load_explicit(&answers[route][k], memory_order_relaxed);
            if (count)
                visit(context, route, statuses[k], count);
        }
    }
}
