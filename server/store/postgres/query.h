/* SPDX-License-Identifier: MIT */
/*
 * Statements on a PostgreSQL database.
 *
 * Each statement is a transaction of its own: what has to happen together is written as one
 * statement. So no transaction is ever open between two calls, nothing of a connection's state
 * matters, and a pooler that hands out connections by the transaction may stand between.
 *
 * A statement is used like this: `pg_query`, the binds in order ($1 first), `pg_run`, the rows,
 * `pg_end`. After a failure there are no rows and `pg_end` says so, so that only one place has to
 * look. Where the connection is lost the statement runs once more, though the first time it may
 * have happened: statements are written so that this does no harm.
 */
#ifndef SERVER_STORE_POSTGRES_QUERY_H
#define SERVER_STORE_POSTGRES_QUERY_H

#include "server/store/answer.h"
#include <stddef.h>
#include <stdint.h>

struct pool;

enum { PG_PARAMETERS = 24 }; /* of a statement, at the most */

/* Executes statements separated by semicolons, all or none of them. On false `why` says the reason
 * and `*taken`, unless NULL, whether it was that something unique was there already. */
bool pg_script(struct pool *pool, const char *sql, bool *taken,
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
    struct pool *pool;
    const char *sql;
    int bound; /* parameters so far */
    struct pg_parameter parameters[PG_PARAMETERS];
    void *result;
    enum store_answer answer;
    bool taken; /* STORE_CONFLICT because something unique was there already */
};

/* `sql` must be a literal: its address names the prepared statement. */
struct pg_query pg_query(struct pool *pool, const char *sql);

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

#endif
