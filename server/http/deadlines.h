/* SPDX-License-Identifier: MIT */
/*
 * Keeps slow clients from holding connections. libmicrohttpd closes a connection on which nothing
 * happens for a while, but one byte a second keeps it open for ever. So every connection has a time
 * by which its client must have got on. A request that is not complete by then is answered 408,
 * straight to the socket, since libmicrohttpd takes no answer before it has all headers; then the
 * connection is cut. A reply that its client does not fetch is just cut.
 *
 * Any thread; the calls for one client come one at a time.
 */
#ifndef SERVER_HTTP_DEADLINES_H
#define SERVER_HTTP_DEADLINES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    PACE_HEAD_MS = 10000,  /* for all headers of a request */
    PACE_IDLE_MS = 60000,  /* between two requests of a connection */
    PACE_BODY_MS = 10000,  /* how far a body may fall behind its least rate */
    PACE_BODY_RATE = 1000, /* bytes a second; Apache and nginx ask for as much */
    PACE_REPLY_MS = 60000  /* for each piece of a reply, and again the rate above */
};

struct pace;

/* A connection: memory of the caller, not to be moved while it is in. The fields belong to pace. */
struct pace_client {
    int socket;
    bool replying, cut;
    int64_t due; /* `request_clock_ms` */
    struct pace_client *next, *previous;
};

/* NULL without memory. */
struct pace *pace_new(void);
/* Nobody may be in. NULL is allowed. */
void pace_free(struct pace *pace);

/* A new connection, which now has to send a request's headers. */
void pace_enter(struct pace *pace, struct pace_client *client, int socket);
/* Before its socket is closed. */
void pace_leave(struct pace *pace, struct pace_client *client);

/* Each of these is false when the client was cut: the request is over. */

/* The reply has been sent; another request may follow. */
bool pace_idle(struct pace *pace, struct pace_client *client);
/* All headers are here, a body may come. */
bool pace_body(struct pace *pace, struct pace_client *client);
/* So many bytes of it have come. */
bool pace_received(struct pace *pace, struct pace_client *client, size_t length);
/* It is our turn, for as long as it takes. */
bool pace_hold(struct pace *pace, struct pace_client *client);
/* So many bytes of the reply are the client's to fetch. */
bool pace_reply(struct pace *pace, struct pace_client *client, size_t length);

/* Cuts who is due at `now`; to be called about every second. How many there were. */
int pace_reap(struct pace *pace, int64_t now);

#endif
