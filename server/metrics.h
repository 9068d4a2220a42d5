/* SPDX-License-Identifier: MIT */
/*
 * What this process has counted, for GET /metrics. Counters are atomics of the process: any thread,
 * no locks.
 */
#ifndef SERVER_METRICS_H
#define SERVER_METRICS_H

#include "api/problem.h"
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum { METRICS_ROUTES_MAX = 64 };

/* Times of one kind, counted by their size. */
enum metrics_times {
    METRICS_QUEUE,  /* of a drape from its submission to a worker */
    METRICS_SOLVE,  /* of an attempt on a worker that gave a result */
    METRICS_ENCODE, /* of a result, from the first to the last byte made */
    METRICS_ROUTE   /* of the answers of a route; others follow up to METRICS_TIMES_COUNT */
};
enum { METRICS_TIMES_COUNT = METRICS_ROUTE + METRICS_ROUTES_MAX };

/* One more answer of the route with that number, `us` microseconds after the request had begun;
 * `status` 0: the client was gone before. */
void metrics_count(size_t route, int status, int64_t us);

/* One more time, in microseconds. */
void metrics_time(size_t times, int64_t us);

/* One more refusal. */
void metrics_refuse(enum api_problem_id problem);

/* One more answer of the database that it is busy or cannot be used. */
void metrics_store_failed(int busy);

/* One more look at something stored that is not what was written. */
void metrics_store_altered(void);

/* How many answers of the route had the status of that number, from 0; false after the last. */
bool metrics_answers(size_t route, size_t number, int *status, long *count);

/* Counts up to each bound, in seconds and ascending; the last is infinite. */
enum { METRICS_BOUNDS = 14 };
struct metrics_histogram {
    double bounds[METRICS_BOUNDS];
    long counts[METRICS_BOUNDS]; /* of times up to that bound: the last is of all */
    double sum;                  /* seconds */
};

/* Of the times; true if there are any. */
int metrics_histogram(size_t times, struct metrics_histogram *histogram);

long metrics_refused(enum api_problem_id problem);
long metrics_store_failures(int busy);
long metrics_store_alterations(void);

/* Bytes of memory that the process has in use now; 0 when the system does not report it. */
int64_t metrics_resident(void);

/* Descriptors that are open. */
int64_t metrics_descriptors(void);

#endif
