/* SPDX-License-Identifier: MIT */
/*
 * What the files of the front share: the front itself, a connection and the request under way on
 * it. Private to them; what others may use is in `http.h`.
 *
 *     http.c        starts and stops, takes libmicrohttpd's notices
 *     client.c      a connection: its beginning, its end, refusals past the library
 *     exchange.c    a request from its first line to the last byte of the reply
 *     suspension.c  requests that wait, and the timer that resumes them
 *     slow_calls.c        threads for calls of the handler that take long
 */
#ifndef SERVER_HTTP_CLIENT_H
#define SERVER_HTTP_CLIENT_H

#include "admission.h"
#include "deadlines.h"
#include "http.h"
#include "quotas.h"
#include "server/job_events.h"
#include "slow_calls.h"
#include "wire.h"
#include <pthread.h>
#include <stdatomic.h>
#include <sys/socket.h>

/* Of the library's memory for a connection: a head with its table, and room for trailers or the
 * reply's headers. */
enum { CLIENT_POOL_BYTES = WIRE_HEAD_BYTES + 16 * 1024 };

struct MHD_Connection;
struct exchange;

struct http {
    struct http_settings settings;
    struct MHD_Daemon *daemon;
    int socket;
    struct lingering_close *linger;
    struct deadlines *deadlines;
    struct quotas *quotas;
    struct admissions *admissions;
    struct slow_calls *slow_calls;
    atomic_bool draining;
    atomic_long exchanges; /* requests that have begun and are not over */

    pthread_mutex_t
        lock; /* of what is below; taken inside the lock of the job events, outside of MHD's own */
    pthread_cond_t changed;
    pthread_t timer;
    bool ticking, stopping;
    struct exchange *suspended; /* a list */
    int64_t wake_at;            /* when the timer looks next */
};

/* A connection. */
struct client {
    struct deadlines_client deadline; /* with its socket */
    struct admission_client admission;
    struct sockaddr_storage peer;
    struct http *http;
    struct exchange *exchange; /* the request under way, or NULL */
    struct wire wire;          /* what was read */
    uint64_t ended;            /* requests that the library has ended */
    bool refused;              /* nothing is read any more */
};

/* A request, its reply, and how far they are. */
struct exchange {
    struct request *request;
    struct reply reply;
    struct http *http;
    struct client *client;
    struct MHD_Connection *connection;
    int64_t begun_us;
    int64_t held;     /* bytes of body in `http->quotas` */
    int64_t received; /* bytes of body, kept or not */
    int64_t sent;     /* bytes of a stream */
    struct {          /* the next piece of a stream, when a thread of `slow_calls` has fetched it */
        char *bytes;  /* malloc'ed; NULL: none */
        size_t used;
        ssize_t length; /* or what `next` gave in place of it */
    } ahead;
    enum slow_calls_kind kind;
    bool known;    /* the head was looked at */
    bool unread;   /* answered before the body was here */
    bool complete; /* the whole body is here */
    bool streams;  /* it counts in the owner's quota of streams */
    bool watching;
    struct job_watch watch;

    /* Under the lock. */
    bool notified;    /* since the handler was called last */
    int64_t woken_us; /* of `request` */
    bool suspended;
    bool away; /* suspended as well, and a thread of `slow_calls` has it */
    bool gone; /* the client is: the answer has no reader any more */
    struct exchange *next, *previous;
};

/* A new connection; NULL without memory or when there are too many: its requests will be refused.
 */
struct client *client_open(struct http *http, int socket, const struct sockaddr *peer);

/* Before the socket is closed, without a request under way. */
void client_close(struct client *client);

/* For `interpose_hooks`: checks what was read from the socket of the client, which is the context.
 * What is malformed is refused once the requests before it are answered. */
ssize_t client_received(void *context, const char *bytes, size_t length);

/* Whether the request that the library has now, its head or all of it, is one that passed the
 * check: both must count the same messages. */
bool client_checked(const struct client *client, bool whole);

/* After the end of a request: what `client_received` put off. */
void client_ended(struct client *client);

/* Answers on the socket and shuts it down for writing, when the library takes no answer because it
 * has not got the whole request, and will not. */
void client_refuse(struct client *client, enum api_problem_id problem, const char *detail);

/* The same for a status that the library would answer with. */
void client_refuse_status(struct client *client, unsigned status);

/* For `deadlines_new`: answers 408 on the socket; the context is the front. */
void client_refuse_late(void *context, int socket);

/* The beginning of a request, with the target as it was sent; NULL without memory. */
struct exchange *exchange_new(struct client *client, struct MHD_Connection *connection,
                              const char *target);

/* The next step, as the library's access handler: called once with the head, once for each piece
 * of the body (`*size` > 0, and 0 afterwards), once at its end, and again after each suspension.
 * False: the connection is to be closed. */
bool exchange_step(struct exchange *exchange, const char *method, const char *version,
                   const char *data, size_t *size);

/* For `slow_calls_start`: calls the handler, or the stream of its reply for the next piece, until
 * there is an answer or a reason to wait. */
void exchange_attend(struct exchange *exchange);

/* Logs, counts and frees it. */
void exchange_end(struct exchange *exchange);

/* Starts the timer thread. */
bool suspension_start(struct http *http);

/* Resumes all; from now on nothing is suspended, and `request->stopping` is set. */
void suspension_stop(struct http *http);

/* Before every call of the handler or of a stream: sets the request's `draining` and `stopping`,
 * and forgets earlier notices. False when the client is gone. */
bool suspension_refresh(struct exchange *exchange);

/* Suspends the connection until the subject changes or `request->wake_at`. False when there is no
 * need to wait: the subject has changed since `suspension_refresh`, or the front is stopping. */
bool suspension_begin(struct exchange *exchange);

/* Suspends the connection and hands the exchange over to `slow_calls`, whose thread ends that by
 * `suspension_begin` or `suspension_return`. False when the front is stopping. */
bool suspension_hand_over(struct exchange *exchange, enum slow_calls_kind kind);

/* Resumes the connection. */
void suspension_return(struct exchange *exchange);

#endif
