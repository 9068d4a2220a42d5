/* SPDX-License-Identifier: MIT */
/*
 * The dispatcher: as many threads as workers, each with one worker process (`child.h`). A thread
 * claims a job, sends it to its worker, renews the lease, passes progress and result to the store,
 * and kills the worker when the job is cancelled, deleted, lost to another or over its time. A
 * worker that dies costs the job one attempt and is replaced; so is one whose next job is another
 * owner's. New jobs are seen at once through `job_events.h`; those of other processes within
 * WORK_POLL_MS. One further thread sweeps the store.
 *
 * No owner waits for the end of another's long jobs. Beside the workers there is a fast worker,
 * started when it is needed first: while all others are busy, and none has ended a job for some
 * milliseconds, it takes jobs of owners who have nothing running and whose jobs were not too long
 * for it lately (`store_yield`), each for JOB_RUN_FAST_MS of a processor at the most. What is not
 * done by then goes back to the queue, and waits for one of the others. There a job that has had
 * its turn gives way to an owner who has nothing running (`job_run.h`). Work that gave way is begun
 * anew; that costs a job half of its time again at the most, since each turn is twice as long as
 * the one before.
 */
#ifndef SERVER_WORK_DISPATCHER_H
#define SERVER_WORK_DISPATCHER_H

#include "counters.h"
#include "server/job_events.h"
#include "server/store/store.h"
#include "settings.h"

struct dispatcher;

/* Starts the threads; workers start with their thread, so that the first job finds one. `store` and
 * `events` must outlive it. NULL when the threads cannot be had. */
struct dispatcher *dispatcher_start(struct store *store, struct job_events *events,
                                    const struct dispatcher_settings *settings);

/* Claims nothing more, gives running jobs `grace_ms` to finish, puts the rest back into the queue
 * and ends the workers and threads. NULL is allowed. */
void dispatcher_stop(struct dispatcher *dispatcher, int64_t grace_ms);

/* After `dispatcher_stop`. NULL is allowed. */
void dispatcher_free(struct dispatcher *dispatcher);

/* What was counted since the start. Any thread, until the dispatcher is freed. */
void dispatcher_stats(struct dispatcher *dispatcher, struct work_counts *counts);

#endif
