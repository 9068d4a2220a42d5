/* SPDX-License-Identifier: MIT */
/*
 * A connection to an SQLite database and its prepared statements. `db.c` is the only file that
 * knows SQLite's own interface; the rest of the backend writes SQL in the words of this header.
 *
 * A statement is used like this: `db_query`, the binds in order, `query_row` while there are rows,
 * `query_end`. After a failure everything is a no-op until `query_end` reports it, so that only one
 * place has to look.
 */
#ifndef SERVER_STORE_SQLITE_DB_H
#define SERVER_STORE_SQLITE_DB_H

#include "server/store/answer.h"
#include <stddef.h>
#include <stdint.h>

/* A connection; used by one thread at a time. */
struct db;

/* How a commit is kept. */
enum db_durability {
    DB_DURABLE, /* survives a power cut: the commit waits for the disk */
    DB_LAZY     /* survives the death of the process; on disk with the next durable commit */
};

/* Opens or creates the file, waiting up to `busy_ms` for locks of other processes. NULL with a
 * sentence in `why`. */
struct db *db_open(const char *path, int64_t busy_ms, char why[STORE_WHY_SIZE]);

/* From now on waits up to `ms` for them. */
void db_wait_for_locks(struct db *db, int64_t ms);

/* NULL is allowed. */
void db_close(struct db *db);

/* Of the file, as it was opened. */
const char *db_path(const struct db *db);

/* Why the last call failed, as a sentence that names the file. */
void db_explain(const struct db *db, char why[STORE_WHY_SIZE]);

/* Whether the file can be read only. */
bool db_read_only(struct db *db);

/* Executes statements separated by semicolons; on false `why` names the file and the reason. */
bool db_set_up(struct db *db, const char *sql, char why[STORE_WHY_SIZE]) STORE_MUST_USE;

/* Executes statements separated by semicolons. */
enum store_answer db_script(struct db *db, const char *sql) STORE_MUST_USE;

/* Runs PRAGMA quick_check on a table; `sql` is the pragma. On false `why` says what it found. */
bool db_check(struct db *db, const char *sql, char why[STORE_WHY_SIZE]) STORE_MUST_USE;

/* Whether a transaction is open. A failed statement may have ended it (disk full, I/O error). */
bool db_in_transaction(struct db *db);

/* How later transactions are kept; DB_DURABLE at first. Not inside a transaction. */
enum store_answer db_keep(struct db *db, enum db_durability durability) STORE_MUST_USE;

/* Copies what the write-ahead log holds into the database as far as no reader needs it, without
 * waiting for other connections. `*all`: nothing is left, so that the next writer may begin the log
 * anew. The connection must have read something before. */
enum store_answer db_checkpoint(struct db *db, bool *all) STORE_MUST_USE;

/* Puts on the disk what has been written to the log. The connection must have read something. */
enum store_answer db_sync_log(struct db *db) STORE_MUST_USE;

/* ------------------------------------------------------------------ statements */

/* One execution of a statement. The fields belong to this module. */
struct query {
    struct db *db;
    void *statement;
    int code;  /* SQLite's */
    int bound; /* parameters so far */
};

/* `sql` must be a literal: its address names the prepared statement. */
struct query db_query(struct db *db, const char *sql);

/* Each sets the next parameter; memory is the caller's until `query_end`. NULL is SQL's null. */
void query_bind_int(struct query *query, int64_t value);
void query_bind_real(struct query *query, double value);
void query_bind_text(struct query *query, const char *value);
void query_bind_bytes(struct query *query, const void *bytes, size_t length);

/* Goes on to the next row, or executes; false at the end and at a failure. */
bool query_row(struct query *query);

/* Columns of the current row, from 0; memory is valid until the next row. */
int64_t query_int(const struct query *query, int column);
double query_real(const struct query *query, int column);
const char *query_text(const struct query *query, int column); /* NULL for null */
const void *query_bytes(const struct query *query, int column, size_t *length);

/* Copies a text into an array, cut to its size; null becomes "". */
void query_copy(const struct query *query, int column, char *to, size_t size);

/* A malloc'ed, zero-terminated copy in `*to` (NULL for null); no memory fails the query. `length`
 * may be NULL. */
void query_duplicate(struct query *query, int column, char **to, size_t *length);

/* STORE_OK, or how the database failed (logged). */
enum store_answer query_end(struct query *query);

/* Executes a statement that gives no rows: query_row and query_end. */
enum store_answer query_run(struct query *query);

/* The same for a statement without parameters. */
enum store_answer db_run(struct db *db, const char *sql);

/* Of the last statement that was run. */
int64_t db_changes(struct db *db);
int64_t db_last_row(struct db *db);

#endif
