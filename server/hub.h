/* SPDX-License-Identifier: MIT */
/*
 * Notifies those that wait that a job has changed, without polling, inside one process. A waiter
 * subscribes to a job's id, THEN reads the job from the store, then waits: a change between the
 * two is not lost. The store notifies after every commit that changes a job (status or progress),
 * so callers of the store never call `hub_notify` themselves. Of changes made by other processes
 * PostgreSQL reports some, SQLite none: waiters also look at the store every HUB_POLL_MS.
 *
 * All functions are safe from any thread.
 */
#ifndef SERVER_HUB_H
#define SERVER_HUB_H

#include "id.h"
#include <stdbool.h>

struct hub;

/* How often a waiter looks at the store for itself, in milliseconds. */
enum { HUB_POLL_MS = 250 };

/* The subject notified whenever a job may have become ready to be claimed. */
extern const char hub_queue[];

/* What is told of a subject. */
enum hub_news {
    HUB_CHANGE,  /* it has changed: a job its status, say */
    HUB_DRAFT,   /* its result can be read, though it is not stored yet (`store_draft_take`) */
    HUB_PROGRESS /* it is getting on, but has not ended */
};

/* One subscription: memory of the subscriber, not to be moved or freed until unsubscribed. The
 * fields belong to the hub. */
struct hub_watch {
    char subject[ID_SIZE];
    void (*wake)(void *context);
    void *context;
    enum hub_news least; /* is told of this and of all that is listed before it */
    struct hub_watch *next, *previous;
};

/* NULL without memory. The caller frees it with `hub_free` when there is no subscription any more.
 */
struct hub *hub_new(void);
void hub_free(struct hub *hub);

/* From now until `hub_unsubscribe`, `wake(context)` is called with all news of `subject` (a job id,
 * or hub_queue) that are not listed behind `least`, on the thread that made the change and with a
 * lock of the hub held: it must be short, must not block and must not call the hub or the store.
 * MHD_resume_connection, writing an eventfd and signalling a condition are fine. */
void hub_subscribe(struct hub *hub, struct hub_watch *watch, const char *subject,
                   enum hub_news least, void (*wake)(void *context), void *context);

/* After it returns, `wake` neither runs nor will run. Only for a subscribed watch. */
void hub_unsubscribe(struct hub *hub, struct hub_watch *watch);

/* Calls every subscriber of `subject` that is told of such news. Without subscribers it costs a
 * lock. */
void hub_notify(struct hub *hub, const char *subject, enum hub_news news);

#endif
