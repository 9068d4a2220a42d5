/* SPDX-License-Identifier: MIT */
/*
 * A few connections to a PostgreSQL database and what runs on them. `pg.c` is the only file that
 * knows libpq; whoever writes SQL for PostgreSQL does it in the words of this header.
 *
 * Each statement is a transaction of its own: what has to happen together is written as one
 * statement. So no transaction is ever open between two calls, nothing of a connection's state
 * matters, and a pooler that hands out connections by the transaction may stand between.
 *
 * A statement is used like this: `pg_query`, the binds in order ($1 first), `pg_run`, the rows,
 * `pg_end`. After a failure there are no rows and `pg_end` tells it, so that only one place has to
 * look.
 *
 * A connection that is lost is replaced and the statement runs once more, though the first time it
 * may have happened: statements are written so that this does no harm. When none can be had, calls
 * fail at once until the next try is due, 0.1 s later at first and 5 s at the most.
 */
#ifndef SERVER_STORE_POSTGRES_PG_H
#define SERVER_STORE_POSTGRES_PG_H

#include "server/store/answer.h"
#include <stddef.h>
#include <stdint.h>

/* The pool. Its functions may be called by any thread at any time between open and close. */
struct pg;

enum {
    PG_LINKS = 8,         /* connections of a pool; opened when needed, closed after a minute */
    PG_PARAMETERS = 24,   /* of a statement, at the most */
    PG_PATIENCE_MS = 5000 /* for a connection, and as a rule for an answer */
};

/* Connects for the first time; a call waits up to `patience_ms` for its answer. NULL with a
 * sentence in `why`, which never holds a password: URL of no sense, no server, wrong user or
 * password, no such database, a server older than 13, a replica that cannot be written. */
struct pg *pg_open(const char *url, int64_t patience_ms, char why[STORE_WHY_SIZE]);

/* No other call may be under way. NULL is allowed. */
void pg_close(struct pg *pg);

/* Executes statements separated by semicolons, all or none of them. On false `why` says the reason
 * and `*taken`, unless NULL, whether it was that something unique was there already. */
bool pg_script(struct pg *pg, const char *sql, bool *taken,
               char why[STORE_WHY_SIZE]) STORE_MUST_USE;

/* ------------------------------------------------------------------ statements */

struct pg_parameter {
    int kind;
    const void *bytes;
    size_t length;
    unsigned char number[8];
};

/* One execution of a statement. The fields belong to this module, but for `taken`. */
struct pg_query {
    struct pg *pg;
    const char *sql;
    int bound; /* parameters so far */
    struct pg_parameter parameters[PG_PARAMETERS];
    void *result;
    enum store_answer answer;
    bool taken; /* STORE_CONFLICT because something unique was there already */
};

/* `sql` must be a literal: its address names the prepared statement. */
struct pg_query pg_query(struct pg *pg, const char *sql);

/* Each sets the next parameter; memory is the caller's until `pg_run` returns. NULL is SQL's null,
 * and so is what `pg_bind_no_int` sets. */
void pg_bind_int(struct pg_query *query, int64_t value);
void pg_bind_no_int(struct pg_query *query);
void pg_bind_real(struct pg_query *query, double value);
void pg_bind_text(struct pg_query *query, const char *value);
void pg_bind_bytes(struct pg_query *query, const void *bytes, size_t length);

/* Executes it; the number of rows, 0 also after a failure. */
size_t pg_run(struct pg_query *query);

/* Columns of a row, both from 0; memory is valid until `pg_end`. Integers of any size and booleans
 * are ints; null is 0, NULL or "". */
int64_t pg_int(const struct pg_query *query, size_t row, int column);
double pg_real(const struct pg_query *query, size_t row, int column);
const char *pg_text(const struct pg_query *query, size_t row, int column);
const void *pg_bytes(const struct pg_query *query, size_t row, int column, size_t *length);

/* Copies a text into an array, cut to its size. */
void pg_copy(const struct pg_query *query, size_t row, int column, char *to, size_t size);

/* A malloc'ed, zero-terminated copy in `*to` (NULL for null); no memory fails the query. `length`
 * may be NULL. */
void pg_duplicate(struct pg_query *query, size_t row, int column, char **to, size_t *length);

/* STORE_OK, STORE_CONFLICT (with `taken`), STORE_BUSY or STORE_DOWN (logged). */
enum store_answer pg_end(struct pg_query *query);

/* ------------------------------------------------------------------ notifications */

/* A connection of its own that hears what is announced on the channel `draped` and announces there.
 * Behind a pooler by the transaction nothing is heard. One thread. */
struct pg_ear;

/* Does not connect yet. NULL without memory. `pg` must outlive it. */
struct pg_ear *pg_ear_new(struct pg *pg);
void pg_ear_free(struct pg_ear *ear);

/* Waits up to `ms`, or until `wake` (an eventfd) can be read, for announcements of others and calls
 * `hear` with the text of each. Connects when it is not connected; false when that fails or the
 * connection is lost: wait before trying again. */
bool pg_ear_wait(struct pg_ear *ear, int wake, int ms,
                 void (*hear)(void *context, const char *text), void *context);

/* Announces a text of at most PG_TEXT_MAX bytes to all others; false when it was not sent. */
bool pg_ear_say(struct pg_ear *ear, const char *text);

enum { PG_TEXT_MAX = 7900 };

#endif
