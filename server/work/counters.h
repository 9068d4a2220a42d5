/* SPDX-License-Identifier: MIT */
/*
 * What a dispatcher and its attempts count, said once: the list below makes the atomic counters,
 * their plain copy for readers, and the lines of GET /metrics.
 */
#ifndef SERVER_WORK_COUNTERS_H
#define SERVER_WORK_COUNTERS_H

#include <stdatomic.h>
#include <stdint.h>

/* Jobs by the way they ended in this process. X(name, meaning) */
#define WORK_OUTCOMES(X)                                                                           \
    X(succeeded, "")                                                                               \
    X(failed, "")                                                                                  \
    X(reused, "answered by a result that was there already")                                       \
    X(stopped, "cancelled, deleted or lost while running")

/* What happened to workers. X(name, help) */
#define WORK_EVENTS(X)                                                                             \
    X(crashes, "Workers that died on their own.")                                                  \
    X(timeouts, "Workers killed for taking too long.")                                             \
    X(tasks, "Tasks of studies that were done.")                                                   \
    X(restarts, "Workers started to replace another.")

/* Since the start; `busy`: workers that are solving now. */
struct work_counters {
#define X(name, help) atomic_int_fast64_t name;
    X(busy, "")
    WORK_OUTCOMES(X)
    WORK_EVENTS(X)
#undef X
};

/* A copy at one moment. */
struct work_counts {
#define X(name, help) int64_t name;
    X(busy, "")
    WORK_OUTCOMES(X)
    WORK_EVENTS(X)
#undef X
};

#endif
