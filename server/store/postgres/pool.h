/* SPDX-License-Identifier: MIT */
/*
 * A few connections to a PostgreSQL database. Only `pool.c`, `statement.c`, `notify.c` and
 * `backup.c` know libpq.
 *
 * A connection that is lost is replaced by the next call. When none can be had, calls fail at once
 * until the next try is due, 0.1 s later at first and 5 s at the most, so that the threads which
 * serve callers do not all wait. The functions may be called by any thread at any time between open
 * and close.
 */
#ifndef SERVER_STORE_POSTGRES_POOL_H
#define SERVER_STORE_POSTGRES_POOL_H

#include "server/store/answer.h"
#include <stddef.h>
#include <stdint.h>

enum {
    POOL_CONNECTIONS = 8,    /* opened when needed, closed after a minute without use */
    POOL_PATIENCE_MS = 5000, /* for a connection, and as a rule for an answer */
    POOL_STATEMENTS = 64     /* prepared ones a connection; the backend has about 50 */
};

/* libpq's own, whose header its users include. */
typedef struct pg_conn PGconn;
typedef struct pg_result PGresult;

struct pool;

/* One connection, of the thread that has taken it. */
struct pool_connection {
    PGconn *libpq;
    size_t count;
    const char *prepared[POOL_STATEMENTS]; /* by the address of their text */
    unsigned generation;                   /* of the pool when it was made */
    int64_t used_ms;                       /* when it was given back */
};

/* Connects for the first time; a call waits up to `patience_ms` for its answer. NULL with a
 * sentence in `why`, which never holds a password: invalid URL, no server, wrong user or password,
 * no such database, a server older than 13. */
struct pool *pool_open(const char *url, int64_t patience_ms, char why[STORE_WHY_SIZE]);

/* No other call may be under way. NULL is allowed. */
void pool_close(struct pool *pool);

int64_t pool_patience_ms(const struct pool *pool);

/* A pooler by the transaction between us and the server does not keep prepared statements. */
bool pool_nameless(struct pool *pool);
void pool_set_nameless(struct pool *pool);

/* A connection, to be given back; NULL with an answer: STORE_BUSY or STORE_DOWN. */
struct pool_connection *pool_take(struct pool *pool, enum store_answer *answer);

/* `lost`: it is not to be used again, nor are those that were made before it. */
void pool_give(struct pool *pool, struct pool_connection *connection, bool lost);

/* A connection outside the pool, in whatever state; the caller finishes it. */
PGconn *pool_connect(const struct pool *pool);

/* The last result of what was sent, or the first that failed; NULL: the connection is lost, or the
 * time (`clock_ms`) is over. The caller clears it. */
PGresult *pool_receive(PGconn *libpq, int64_t until_ms);

/* Formats one line without the end of line that libpq adds. */
void pool_say(char why[STORE_WHY_SIZE], const char *format, ...)
    __attribute__((format(printf, 2, 3)));

/* The password of the URL becomes asterisks: a server may quote what it was sent. */
void pool_hide_password(const struct pool *pool, char *text);

#endif
