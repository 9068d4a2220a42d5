/* SPDX-License-Identifier: MIT */
/*
 * Keeps slow clients from holding connections. libmicrohttpd closes a connection on which nothing
 * happens for a while, but one byte a second keeps it open for ever. So every connection has a time
 * by which its client must have got on. A request that is not complete by then is answered 408,
 * straight to the socket, since libmicrohttpd takes no answer before it has all headers; then the
 * connection is cut. A reply that its client does not fetch is just cut. Only the client's own time
 * counts: while what it has sent lies unread, or it has fetched all that it was given, it is not
 * late, we are.
 *
 * Any thread; the calls for one client come one at a time.
 */
#ifndef SERVER_HTTP_DEADLINES_H
#define SERVER_HTTP_DEADLINES_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    DEADLINES_HEAD_MS = 10000,   /* for all headers of a request */
    DEADLINES_RESERVE_MS = 2000, /* the same on a connection in reserve */
    DEADLINES_IDLE_MS = 60000,   /* between two requests of a connection */
    DEADLINES_BODY_MS = 10000,   /* how far a body may fall behind its least rate */
    DEADLINES_BODY_RATE = 1000,  /* bytes a second; Apache and nginx ask for as much */
    DEADLINES_REPLY_MS = 60000   /* for each piece of a reply, and again the rate above */
};

struct deadlines;

/* A connection: memory of the caller, not to be moved while it is in. The fields belong to
 * deadlines. */
struct deadlines_client {
    int socket;
    bool replying, cut;
    int64_t due; /* `clock_ms` */
    struct deadlines_client *next, *previous;
};

/* Called for a request that has not arrived in time, with a lock held: answers on the socket, which
 * is shut down for writing after it. */
typedef void deadlines_late(void *context, int socket);

/* NULL without memory. */
struct deadlines *deadlines_new(deadlines_late *late, void *context);
/* Nobody may be in. NULL is allowed. */
void deadlines_free(struct deadlines *deadlines);

/* A new connection, which now has to send a request's headers within `ms`. */
void deadlines_add(struct deadlines *deadlines, struct deadlines_client *client, int socket,
                   int64_t ms);
/* Before its socket is closed. */
void deadlines_remove(struct deadlines *deadlines, struct deadlines_client *client);

/* Whose turn it is, and for what. */
enum deadlines_turn {
    DEADLINES_IDLE,     /* the reply has been sent; another request may follow */
    DEADLINES_BODY,     /* all headers are here, a body may come */
    DEADLINES_RECEIVED, /* so many bytes of it have come */
    DEADLINES_OURS,     /* for as long as it takes */
    DEADLINES_REPLY     /* so many bytes of the reply are the client's to fetch */
};

/* `length` is of DEADLINES_RECEIVED and DEADLINES_REPLY. False when the client was cut: the request
 * is over. */
bool deadlines_turn(struct deadlines *deadlines, struct deadlines_client *client,
                    enum deadlines_turn turn, size_t length);

/* The last answer has been sent: the client gets a short while to read it. */
void deadlines_cut(struct deadlines *deadlines, struct deadlines_client *client);

/* Cuts the clients that are due at `now`; to be called about every second. How many there were. */
int deadlines_reap(struct deadlines *deadlines, int64_t now);

#endif
