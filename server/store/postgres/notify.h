/* SPDX-License-Identifier: MIT */
/*
 * Carries notifications between processes that share a database: a thread listens on the channel
 * `draped` and passes on as job events what other processes announce, and announces there what
 * changes here. They are only hints: what is missed is found by looking. Behind a pooler by the
 * transaction nothing is received.
 */
#ifndef SERVER_STORE_POSTGRES_NOTIFY_H
#define SERVER_STORE_POSTGRES_NOTIFY_H

#include "server/job_events.h"

struct pool;
struct notify;

/* NULL without memory or threads. Both must outlive it. */
struct notify *notify_start(struct pool *pool, struct job_events *events);

/* NULL is allowed. */
void notify_stop(struct notify *notify);

/* How long it waits for the next try to connect when so many before it have failed, not counting
 * the last: 250 ms, twice as long each time, and 8 s at the most. */
int notify_pause_ms(int failures);

/* Announces `subject` (a job's id, or job_events_queue) soon. Any thread; never waits. */
void notify_announce(struct notify *notify, const char *subject);

#endif
