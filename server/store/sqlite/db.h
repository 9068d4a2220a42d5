/* SPDX-License-Identifier: MIT */
/*
 * A connection to an SQLite database and its prepared statements. `db.c` is the only file that
 * knows SQLite's own interface; the rest of the backend writes SQL in the words of this header and
 * of `query.h`.
 */
#ifndef SERVER_STORE_SQLITE_DB_H
#define SERVER_STORE_SQLITE_DB_H

#include "server/store/query.h"
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

/* On a `struct db`. `sql` must be a literal: its address names the prepared statement. */
struct query db_query(void *db, const char *sql);

/* Executes a statement; `none` when it has changed no row. */
enum store_answer db_change(struct query *query, enum store_answer none);

/* Executes a statement without rows, and without parameters or with that one. */
enum store_answer db_run(struct db *db, const char *sql);
enum store_answer db_run_with(struct db *db, const char *sql, int64_t parameter);

/* Of the last statement that was run. */
int64_t db_changes(struct db *db);
int64_t db_last_row(struct db *db);

#endif
