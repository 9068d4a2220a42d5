/* SPDX-License-Identifier: MIT */
#include "metrics.h"
#include <dirent.h>
#include <math.h>
#include <stdatomic.h>
#include <stdio.h>
#include <unistd.h>

/* The statuses this service answers with; the first stands for all others. */
static const int statuses[] = {0,   200, 201, 202, 204, 206, 304, 400, 401, 403, 404, 405, 406,
                               408, 409, 410, 413, 414, 415, 416, 422, 429, 431, 500, 503, 505};

enum { STATUS_COUNT = sizeof statuses / sizeof *statuses };

static atomic_long answers[METRICS_ROUTES_MAX][STATUS_COUNT];

/* From what an idle service takes for a status to the longest drapes. */
static const double bounds[METRICS_BOUNDS] = {0.0005, 0.001, 0.0025, 0.005, 0.01, 0.025, 0.05,
                                              0.1,    0.5,   2.5,    10,    60,   600,   INFINITY};

static struct {
    atomic_long counts[METRICS_BOUNDS]; /* of each bucket alone */
    atomic_int_fast64_t sum_us;
} histograms[METRICS_TIMES_COUNT];

static atomic_long refusals[API_PROBLEM_COUNT];
static atomic_long store_failures[2], store_alterations;

void metrics_time(size_t times, int64_t us) {
    size_t bucket = 0;
    if (times >= METRICS_TIMES_COUNT)
        return;
    while (bucket < METRICS_BOUNDS - 1 && (double)us > bounds[bucket] * 1e6)
        bucket++;
    atomic_fetch_add_explicit(&histograms[times].counts[bucket], 1, memory_order_relaxed);
    atomic_fetch_add_explicit(&histograms[times].sum_us, us, memory_order_relaxed);
}

int metrics_histogram(size_t times, struct metrics_histogram *histogram) {
    long total = 0;
    for (size_t k = 0; k < METRICS_BOUNDS; k++) {
        total += atomic_load_explicit(&histograms[times].counts[k], memory_order_relaxed);
        histogram->bounds[k] = bounds[k];
        histogram->counts[k] = total;
    }
    histogram->sum =
        (double)atomic_load_explicit(&histograms[times].sum_us, memory_order_relaxed) / 1e6;
    return total > 0;
}

void metrics_count(size_t route, int status, int64_t us) {
    size_t index = STATUS_COUNT - 1;
    if (route >= METRICS_ROUTES_MAX)
        return;
    while (index > 0 && statuses[index] != status)
        index--;
    atomic_fetch_add_explicit(&answers[route][index], 1, memory_order_relaxed);
    metrics_time(METRICS_ROUTE + route, us);
}

void metrics_refuse(enum api_problem_id problem) {
    atomic_fetch_add_explicit(&refusals[problem], 1, memory_order_relaxed);
}

long metrics_refused(enum api_problem_id problem) {
    return atomic_load_explicit(&refusals[problem], memory_order_relaxed);
}

void metrics_store_failed(int busy) {
    atomic_fetch_add_explicit(&store_failures[busy != 0], 1, memory_order_relaxed);
}

long metrics_store_failures(int busy) {
    return atomic_load_explicit(&store_failures[busy != 0], memory_order_relaxed);
}

void metrics_store_altered(void) {
    atomic_fetch_add_explicit(&store_alterations, 1, memory_order_relaxed);
}

long metrics_store_alterations(void) {
    return atomic_load_explicit(&store_alterations, memory_order_relaxed);
}

int64_t metrics_resident(void) {
    long long pages = 0;
    FILE *file = fopen("/proc/self/statm", "re");
    if (!file)
        return 0;
    if (fscanf(file, "%*s %lld", &pages) != 1)
        pages = 0;
    fclose(file);
    return pages * sysconf(_SC_PAGESIZE);
}

int64_t metrics_descriptors(void) {
    int64_t count = -3; /* ".", ".." and the one of the folder itself */
    DIR *folder = opendir("/proc/self/fd");
    if (!folder)
        return 0;
    while (readdir(folder))
        count++;
    closedir(folder);
    return count;
}

bool metrics_answers(size_t route, size_t number, int *status, long *count) {
    if (number >= STATUS_COUNT)
        return false;
    *status = statuses[number];
    *count = atomic_load_explicit(&answers[route][number], memory_order_relaxed);
    return true;
}
