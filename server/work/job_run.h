/* SPDX-License-Identifier: MIT */
/*
 * The run of one job on a worker process, which is one of the job's attempts: sends the job, renews
 * the lease, passes progress and result to the store, watches for cancellation, deadline and
 * shutdown, and at the end reports the outcome to the store. Ending a job early is always a kill of
 * its worker.
 */
#ifndef SERVER_WORK_JOB_RUN_H
#define SERVER_WORK_JOB_RUN_H

#include "child.h"
#include "counters.h"
#include "sandbox.h"
#include "server/job_events.h"
#include "server/store/store.h"
#include "settings.h"
#include <stdatomic.h>

enum {
    JOB_RUN_RETRY_MS = 500, /* between two tries when the store is busy or down */
    JOB_RUN_NO_STOP = -1
};

/* What the runs of one dispatcher have in common. */
struct job_run_shared {
    struct store *store;
    struct job_events *events;
    struct dispatcher_settings settings;
    /* By `clock_ms`: from when jobs that run go back to the queue; JOB_RUN_NO_STOP: go on. */
    atomic_int_fast64_t stop_at_ms;
    struct work_counters counters;
    atomic_int_fast64_t yielded_ms; /* when a job last gave way to another owner's */
};

/* For how long a job may have its worker to itself. On the fast worker so long of a processor, of
 * one that sanitizers slow down more, and so long in any case: on a busy machine a small job takes
 * long, too. Then it goes back to the queue. */
enum {
    JOB_RUN_FAST_MS = SANDBOX_SANITIZED ? 600 : 60,
    JOB_RUN_FAST_MOST_MS = 10 * JOB_RUN_FAST_MS,
    JOB_RUN_TURN_MS = 10000, /* else; then it goes back when another owner has waited, with nothing
                                running, for JOB_RUN_STARVED_MS. Doubled with every attempt, so
                                that each job ends at last. */
    JOB_RUN_STARVED_MS = 2000
};

/* Whether running jobs have had their time after the daemon was asked to stop. */
bool job_run_out_of_time(struct job_run_shared *shared);

/* Bounds the memory of a worker that has just been started, for all its jobs. False: it must not
 * get any. */
bool job_run_bound(const struct job_run_shared *shared, const struct child *child);

/* Works on the claimed job until it is off the worker and the store knows. `child` is running; when
 * it is not afterwards, it had to be killed or died. `wake` is an eventfd, non-blocking: what is
 * written to it makes the run look at once at its claim and at the time. False: the job went
 * back to the queue because it could not be worked on now (not because it gave way); to take it
 * again at once would not help. `next` is what was claimed with its end, if its `sequence` is not
 * 0; NULL for the fast worker.
 */
bool job_run(struct job_run_shared *shared, const struct store_claim *claim, struct child *child,
             int wake, struct store_claim *next);

/* Writes to such an eventfd, an int at `wake`; may be called by the job events. Any thread; never
 * blocks. */
void job_run_wake(void *wake);

#endif
