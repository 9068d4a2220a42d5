/* SPDX-License-Identifier: MIT */
/*
 * Notifies those that wait that a job has changed, without polling, inside one process. A waiter
 * subscribes to a job's id, THEN reads the job from the store, then waits: a change between the
 * two is not lost. The store notifies after every commit that changes a job (status or progress),
 * so callers of the store never call `job_events_notify` themselves. Of changes made by other
 * processes PostgreSQL reports some, SQLite none: waiters also look at the store every
 * JOB_EVENTS_POLL_MS.
 *
 * All functions are safe from any thread.
 */
#ifndef SERVER_JOB_EVENTS_H
#define SERVER_JOB_EVENTS_H

#include "id.h"
#include <stdbool.h>

struct job_events;

/* How often a waiter looks at the store for itself, in milliseconds. */
enum { JOB_EVENTS_POLL_MS = 250 };

/* The subject notified whenever a job may have become ready to be claimed. */
extern const char job_events_queue[];

/* What is told of a subject. */
enum job_event {
    JOB_CHANGED,         /* it has changed: a job its status, say */
    JOB_RESULT_READABLE, /* its result can be read, though it is not stored yet
                            (`store_uncommitted_take`) */
    JOB_PROGRESSED       /* it is getting on, but has not ended */
};

/* One subscription: memory of the subscriber, not to be moved or freed until unsubscribed. The
 * fields belong to the job events. */
struct job_watch {
    char subject[ID_SIZE];
    void (*wake)(void *context);
    void *context;
    enum job_event least; /* is told of this and of all that is listed before it */
    struct job_watch *next, *previous;
};

/* NULL without memory. The caller frees it with `job_events_free` when there is no subscription any
 * more.
 */
struct job_events *job_events_new(void);
void job_events_free(struct job_events *events);

/* From now until `job_events_unsubscribe`, `wake(context)` is called with all news of `subject` (a
 * job id, or job_events_queue) that are not listed behind `least`, on the thread that made the
 * change and with an internal lock held: it must be short, must not block and must call neither
 * these functions nor the store. MHD_resume_connection, writing an eventfd and signalling a
 * condition are fine. */
void job_events_subscribe(struct job_events *events, struct job_watch *watch, const char *subject,
                          enum job_event least, void (*wake)(void *context), void *context);

/* After it returns, `wake` neither runs nor will run. Only for a subscribed watch. */
void job_events_unsubscribe(struct job_events *events, struct job_watch *watch);

/* Calls every subscriber of `subject` that is told of such news. Without subscribers it costs a
 * lock. */
void job_events_notify(struct job_events *events, const char *subject, enum job_event news);

#endif
