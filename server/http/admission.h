/* SPDX-License-Identifier: MIT */
/*
 * Which connections are served. The configuration says how many there may be. An owner (by the
 * peer's address: whose requests come over a connection is not known yet) may have as many as are
 * left (`quotas.h`), or as another has, and no more than `owner_most`.
 *
 * One more closes an idle one of the same owner; when none at all are left, one of the owner who
 * has most, if that has more. A connection is idle when for a moment no request has been under way
 * and nothing has arrived, read or not; the one that has been idle longest is closed. When none is
 * idle either, the owner who has most gives up the one that was heard longest ago, if it then has
 * no fewer than the new one's. Otherwise the new connection is in reserve: probes are answered on
 * it, all else is refused, and it is closed soon. ADMISSION_RESERVE connections may be in reserve;
 * the one that has been idle there longest makes room for the next.
 *
 * Peers that are trusted proxies carry many owners' requests: they may have all connections, and
 * give up idle ones alone.
 *
 * Any thread; the calls for one connection come one at a time.
 */
#ifndef SERVER_HTTP_ADMISSION_H
#define SERVER_HTTP_ADMISSION_H

#include "quotas.h"
#include "request.h"
#include <stdatomic.h>
#include <stdbool.h>
#include <stdint.h>

enum {
    ADMISSION_RESERVE = 32,
    ADMISSION_CLOSING = 64 /* that have been told to close but are not gone yet, at the most */
};

/* How a connection was taken. */
enum admission {
    ADMISSION_SERVED,
    ADMISSION_OWNER_FULL, /* in reserve: its owner has as many as it may now */
    ADMISSION_FULL        /* in reserve: all are taken */
};

struct admissions;

/* A connection: memory of the caller, not to be moved while it is in. The fields belong to
 * admissions, but `how` may be read. */
struct admission_client {
    enum admission how;
    char owner[REQUEST_CALLER_SIZE];
    int socket;
    bool shared;                   /* with other owners: a proxy's */
    bool busy, closing;            /* a request is under way; it was shut down */
    atomic_int_fast64_t active_us; /* `clock_us` when it came, was read from, or ended a request */
    struct admission_client *next, *previous;
};

/* Counts connections in `quotas`, which is borrowed. NULL without memory. */
struct admissions *admissions_new(struct quotas *quotas, int64_t owner_most);
/* Nobody may be in. NULL is allowed. */
void admissions_free(struct admissions *admissions);

/* A new, idle connection of that owner; `shared`: of a proxy. False: it cannot even be in
 * reserve; it has to be closed and is not in. */
bool admission_enter(struct admissions *admissions, struct admission_client *client,
                     const char *owner, bool shared, int socket);
/* Before its socket is closed. */
void admission_leave(struct admissions *admissions, struct admission_client *client);

/* A request begins, or has ended. */
void admission_busy(struct admissions *admissions, struct admission_client *client, bool busy);

/* Something was read from it: of a request that has not begun yet, perhaps. */
void admission_heard(struct admission_client *client);

#endif
