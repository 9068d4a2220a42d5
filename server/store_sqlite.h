/* SPDX-License-Identifier: MIT */
/*
 * Inside the SQLite backend. `store_sqlite.c` is the only file that knows SQLite's own interface:
 * connections, statements, transactions. What is written in SQL is in `store_sqlite_jobs.c`,
 * `_results.c`, `_surfaces.c`, `_sweep.c` and `_schema.c`, in the words of this header.
 *
 * Writing is a matter of one connection. An operation is a function that runs inside a transaction;
 * those that queue up while a commit is under way run together in the next one, so that many
 * callers share one fsync and each still returns only when its change is on disk. Reading uses a
 * few connections of its own and never waits for writers.
 */
#ifndef SERVER_STORE_SQLITE_H
#define SERVER_STORE_SQLITE_H

#include "store_backend.h"

/* A connection with its prepared statements; used by one thread at a time. */
struct db;

/* The state of one execution of a statement. Use: query, binds in order, rows, end. After a failure
 * everything is a no-op until `query_end` tells it. */
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
/* A malloc'ed, zero-terminated copy in `*to` (NULL for null); no memory fails the query. */
void query_duplicate(struct query *query, int column, char **to, size_t *length);

/* STORE_OK, STORE_BUSY or STORE_DOWN (logged). */
enum store_answer query_end(struct query *query);

/* Executes a statement that gives no rows: query_row and query_end. */
enum store_answer query_run(struct query *query);

/* Of the last statement that was run. */
int64_t db_changes(struct db *db);
int64_t db_last_row(struct db *db);

/* Reads a part of `chunks.bytes` without loading the rest. STORE_EMPTY: no such row. */
enum store_answer db_read_chunk(struct db *db, int64_t row, size_t offset, void *bytes,
                                size_t length);

/* Executes statements separated by semicolons. */
enum store_answer db_script(struct db *db, const char *sql);

struct sqlite_store;
struct sqlite_store *sqlite_of(struct store *store);
const struct store_options *sqlite_options(const struct sqlite_store *store);
/* The name under which this process claims. */
const char *sqlite_holder(const struct sqlite_store *store);
/* Whether the process that claimed under this name is gone: its lock is free. */
bool sqlite_holder_dead(const struct sqlite_store *store, const char *holder);

/* An operation. Answering anything but STORE_OK undoes what it wrote. It may run on another
 * caller's thread, and what it put into `context` is true only if the call answers STORE_OK. */
typedef enum store_answer (*sqlite_operation)(struct sqlite_store *store, struct db *db,
                                              void *context);

/* Runs it in a transaction and returns when that is durable. */
enum store_answer sqlite_write(struct store *store, sqlite_operation operation, void *context);
/* Runs it on a reading connection. */
enum store_answer sqlite_read(struct store *store, sqlite_operation operation, void *context);

/* Microseconds since 1970 by this machine's clock, which is also the database's. */
int64_t sqlite_now(void);

/* --- store_sqlite_schema.c */

/* Checks whose the file is and brings it to the current schema; runs in a transaction. False with
 * `why`. */
bool sqlite_migrate(struct db *db, char why[STORE_WHY_SIZE]);

/* --- store_sqlite_jobs.c */

enum store_answer sqlite_submit(struct store *store, const struct store_submission *submission,
                                struct store_receipt *receipt);
enum store_answer sqlite_get(struct store *store, const char *id, struct store_job *job);
enum store_answer sqlite_request(struct store *store, const char *id, char **bytes, size_t *length);
enum store_answer sqlite_list(struct store *store, const struct store_filter *filter,
                              struct store_page *page);
enum store_answer sqlite_cancel(struct store *store, const char *id);
enum store_answer sqlite_remove(struct store *store, const char *id);
enum store_answer sqlite_counts(struct store *store, struct store_counts *counts);

/* --- store_sqlite_claims.c */

enum store_answer sqlite_claim(struct store *store, struct store_claim *claim);
enum store_answer sqlite_renew(struct store *store, const struct store_claim *claim,
                               double progress);
enum store_answer sqlite_check(struct store *store, const struct store_claim *claim);
enum store_answer sqlite_fail(struct store *store, const struct store_claim *claim,
                              const char *error);
enum store_answer sqlite_crashed(struct store *store, const struct store_claim *claim,
                                 const char *detail);
enum store_answer sqlite_release(struct store *store, const struct store_claim *claim);

/* Why a job goes back to the queue. */
enum requeue { REQUEUE_CRASHED, REQUEUE_RELEASED, REQUEUE_INTERRUPTED };

/* Puts the running job back into the queue or, without attempts left, fails it; tells which. For
 * use inside an operation. STORE_CONFLICT when it does not run under that token. */
enum store_answer sqlite_requeue(struct sqlite_store *store, struct db *db, int64_t sequence,
                                 int64_t token, enum requeue cause, const char *detail,
                                 bool *failed);

/* --- store_sqlite_results.c */

enum store_answer sqlite_result_append(struct store *store, struct store_chunk *chunk);
enum store_answer sqlite_result_commit(struct store *store, struct store_chunk *chunk);
enum store_answer sqlite_result_drop(struct store *store, int64_t number);
enum store_answer sqlite_result_find(struct store *store, const char *id,
                                     struct store_result *result);
enum store_answer sqlite_result_read(struct store *store, int64_t number, int64_t index,
                                     size_t offset, void *bytes, size_t length);

/* results.state */
enum { RESULT_BUILDING, RESULT_COMPLETE, RESULT_DOOMED };

/* Dooms the result if no job refers to it: its chunks go by and by. Inside an operation. */
enum store_answer sqlite_result_forget(struct db *db, int64_t number);

/* --- store_sqlite_sweep.c */

enum store_answer sqlite_sweep(struct store *store, struct store_sweep *sweep);

/* --- store_sqlite_surfaces.c */

enum store_answer sqlite_surface_put(struct store *store, const struct store_surface *surface,
                                     bool *created);
enum store_answer sqlite_surface_get(struct store *store, const char *id,
                                     struct store_surface *surface);
enum store_answer sqlite_surface_list(struct store *store, const char *owner, int64_t cursor,
                                      int limit, struct store_surfaces *page);
enum store_answer sqlite_surface_delete(struct store *store, const char *id);

#endif
