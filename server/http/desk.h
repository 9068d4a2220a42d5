/* SPDX-License-Identifier: MIT */
/*
 * Threads for handlers that take long. A change that a caller asks for is on the disk before it is
 * answered, and while the disk is busy that takes longer than other connections of the same thread
 * should wait; so does a look into a database on another machine that has much to do. As long as
 * such calls are quick they are made on the connection's own thread, which costs least; when those
 * of a kind have become slow they are made here, and the connection is suspended meanwhile. Changes
 * come first: streams that are all woken by one event must not keep a submission waiting. Among
 * calls of a kind the owner with the fewest under way comes first.
 */
#ifndef SERVER_HTTP_DESK_H
#define SERVER_HTTP_DESK_H

#include <stdbool.h>
#include <stdint.h>

enum {
    DESK_THREADS = 16,      /* their changes share a wait for the disk */
    DESK_READERS = 4,       /* of them, at the most, read at a time: changes need the store too */
    DESK_SLOW_US = 5 * 1000 /* longer than what a connection's own thread may be kept from others */
};

/* What a call does. */
enum desk_kind { DESK_CHANGES, DESK_READS, DESK_KINDS };

struct desk;
struct exchange;

/* `attend` is called with each exchange on a thread of the desk. NULL without memory or threads. */
struct desk *desk_start(void (*attend)(struct exchange *exchange));

/* Ends the threads after all that was handed over has been attended to. NULL is allowed. */
void desk_stop(struct desk *desk);

/* After `desk_stop`. NULL is allowed. */
void desk_free(struct desk *desk);

/* A call of that kind took `us`. */
void desk_note(struct desk *desk, enum desk_kind kind, int64_t us);

/* Whether such calls take long now. */
bool desk_needed(struct desk *desk, enum desk_kind kind);

/* The exchange, from now on not the caller's, is attended to soon. Not after `desk_stop`. */
void desk_hand_over(struct desk *desk, enum desk_kind kind, struct exchange *exchange);

#endif
