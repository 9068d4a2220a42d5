/* SPDX-License-Identifier: MIT */
/*
 * Statements on a PostgreSQL database.
 *
 * Each statement is a transaction of its own: what has to happen together is written as one
 * statement. So no transaction is ever open between two calls, nothing of a connection's state
 * matters, and a pooler that hands out connections by the transaction may stand between.
 *
 * Where the connection is lost the statement runs once more, though the first time it may have
 * happened: statements are written so that this does no harm.
 */
#ifndef SERVER_STORE_POSTGRES_STATEMENT_H
#define SERVER_STORE_POSTGRES_STATEMENT_H

#include "server/store/query.h"

struct pool;

/* Executes statements separated by semicolons, all or none of them. On false `why` says the reason
 * and `*taken`, unless NULL, whether it was that something unique was there already. */
bool pg_script(struct pool *pool, const char *sql, bool *taken,
               char why[STORE_WHY_SIZE]) STORE_MUST_USE;

/* A statement on a `struct pool`, used as `server/store/query.h` says; the rows come all at once.
 * `sql` must be a literal: its address names the prepared statement. */
struct query pg_query(void *pool, const char *sql);

#endif
