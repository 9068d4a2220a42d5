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
#ifndef SERVER_HTTP_SLOW_CALLS_H
#define SERVER_HTTP_SLOW_CALLS_H

#include <stdbool.h>
#include <stdint.h>

enum {
    SLOW_CALLS_THREADS = 16, /* their changes share a wait for the disk */
    SLOW_CALLS_READERS = 4,  /* of them, at the most, read at a time: changes need the store too */
    SLOW_CALLS_SLOW_US =
        5 * 1000 /* longer than what a connection's own thread may be kept from others */
};

/* What a call does. */
enum slow_calls_kind { SLOW_CALLS_CHANGES, SLOW_CALLS_READS, SLOW_CALLS_KINDS };

struct slow_calls;
struct exchange;

/* `attend` is called with each exchange on one of the threads. NULL without memory or threads. */
struct slow_calls *slow_calls_start(void (*attend)(struct exchange *exchange));

/* Ends the threads after all that was handed over has been attended to. NULL is allowed. */
void slow_calls_stop(struct slow_calls *slow_calls);

/* After `slow_calls_stop`. NULL is allowed. */
void slow_calls_free(struct slow_calls *slow_calls);

/* A call of that kind took `us`. */
void slow_calls_note(struct slow_calls *slow_calls, enum slow_calls_kind kind, int64_t us);

/* Whether such calls take long now. */
bool slow_calls_are_slow(struct slow_calls *slow_calls, enum slow_calls_kind kind);

/* The exchange, from now on not the caller's, is attended to soon. Not after `slow_calls_stop`. */
void slow_calls_hand_over(struct slow_calls *slow_calls, enum slow_calls_kind kind,
                          struct exchange *exchange);

#endif
