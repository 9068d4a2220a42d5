/* SPDX-License-Identifier: MIT */
/*
 * Inside the SQLite backend. `sqlite.c` opens the database and runs transactions. What is
 * written in SQL is in `jobs.c`, `claims.c`, `rounds.c`, `results.c`, `items.c`, `sweep.c` and
 * `schema.c`, in the words of `db.h`.
 *
 * Writing is a matter of one connection. An operation is a function that runs inside a transaction;
 * those that queue up while a commit is under way run together in the next one, so that many
 * callers share one fsync and each still returns only when its change is on disk. Reading uses a
 * few connections of its own and never waits for writers.
 */
#ifndef SERVER_STORE_SQLITE_SQLITE_H
#define SERVER_STORE_SQLITE_SQLITE_H

#include "db.h"
#include "server/store/backend.h"
#include "server/store/process_lock.h"

struct sqlite_store;
struct sqlite_store *sqlite_of(struct store *store);
const struct store_options *sqlite_options(const struct sqlite_store *store);

/* Microseconds since 1970 by the store's clock. */
int64_t sqlite_now(const struct sqlite_store *store);

/* The clock of leases: microseconds of the machine's monotonic clock, since all holders are on it.
 * When it starts anew, with the machine, all holders from before are gone. */
int64_t sqlite_steady(const struct sqlite_store *store);

/* The process that claims here, and whether others that claimed are gone. */
const struct process_lock *sqlite_process(const struct sqlite_store *store);

/* An operation. Answering anything but STORE_OK undoes what it wrote. It may run on another
 * caller's thread, and what it put into `context` is true only if the call answers STORE_OK. */
typedef enum store_answer (*sqlite_operation)(struct sqlite_store *store, struct db *db,
                                              void *context);

/* Runs it in a transaction and returns when that is kept so. DB_LAZY is for what means nothing once
 * the machine has stopped, such as that a process on it holds a lease. */
enum store_answer sqlite_write(struct store *store, enum db_durability durability,
                               sqlite_operation operation, void *context);

/* The same for an operation of one statement: of `query` its text, a literal, and its parameters.
 * `none` when it has changed no row. */
enum store_answer sqlite_change(struct store *store, enum db_durability durability,
                                const struct query *query, enum store_answer none);

/* Whether the disk takes so many bytes and has some left for the small changes that put a job back
 * into the queue and drop what has no room: else STORE_NO_SPACE, logged. */
enum store_answer sqlite_room_for(struct store *store, size_t bytes);

/* A connection to read with, which never waits for writers; to be given back soon. */
struct db *sqlite_take_reader(struct store *store);

/* A statement on one that is taken, and given back when the query ends. */
struct query sqlite_read(void *store, const char *sql);

/* Gives it back; returns `answer`. */
enum store_answer sqlite_give_reader(struct store *store, struct db *db, enum store_answer answer);

/* For reads on a connection, by a look from outside. */
struct reader sqlite_reader(struct db *db);

/* Takes the write-ahead log into the database. Writers and readers go on meanwhile. */
enum store_answer sqlite_take_log(struct store *store);

/* To be called by who writes much without waiting for the disk, after each so many bytes: has them
 * written to the disk, and from time to time into the database, on the caller's time. Else those
 * who wait for a small change of theirs would wait for all of it. */
enum store_answer sqlite_pace(struct store *store, int64_t bytes);

/* Whether the last write, or taking of the log, failed. */
bool sqlite_broken(struct sqlite_store *store);

/* --- hosts.c */

enum store_answer sqlite_beat(struct store *store, const struct store_host *host);
void sqlite_leave(struct store *store, const char *name);

/* --- schema.c */

/* Marks a file as ours: "drap". */
enum { SQLITE_APPLICATION = 0x64726170 };

/* Whether the file is empty, or has the tables of this version; else false with `why`. */
bool sqlite_check_tables(struct db *db, bool *empty, char why[STORE_WHY_SIZE]);

/* Makes the tables in an empty file; checks whose they are, and of which version, in another. Runs
 * in a transaction. False with `why`. */
bool sqlite_prepare_tables(struct db *db, char why[STORE_WHY_SIZE]);

/* --- jobs.c */

enum store_answer sqlite_submit(struct store *store, const struct store_submission *submission,
                                struct store_receipt *receipt);
enum store_answer sqlite_submit_family(struct store *store, const struct store_family *family,
                                       struct store_receipt *receipt);
enum store_answer sqlite_cancel(struct store *store, const char *id);
enum store_answer sqlite_remove(struct store *store, const char *id);

/* --- claims.c */

enum store_answer sqlite_claim(struct store *store, bool fresh, struct store_claim *claim);
enum store_answer sqlite_starving(struct store *store, bool fresh);
/* Claims the first of the queue, if any, inside an operation that is durable. */
enum store_answer sqlite_claim_too(struct sqlite_store *store, struct db *db,
                                   struct store_claim *claim);
/* Runs what claims and ends run, on no job. Inside an operation. */
enum store_answer sqlite_try_claim(struct sqlite_store *store, struct db *db);
enum store_answer sqlite_renew(struct store *store, const struct store_claim *claim,
                               double progress);
enum store_answer sqlite_fail(struct store *store, const struct store_claim *claim,
                              const char *error);
enum store_answer sqlite_requeue(struct store *store, const struct store_claim *claim, bool excused,
                                 int64_t later);
enum store_answer sqlite_change_task(struct store *store, const struct store_claim *claim,
                                     const void *task);
enum store_answer sqlite_find_ended(struct store *store, struct store_ended *ended, size_t most,
                                    size_t *count);
enum store_answer sqlite_take_over(struct store *store, const struct store_ended *ended,
                                   int64_t *token);

/* --- rounds.c */

enum store_answer sqlite_begin_round(struct store *store, const struct store_claim *claim,
                                     const struct store_round *round);
enum store_answer sqlite_end_task(struct store *store, const struct store_claim *claim,
                                  const void *numbers, size_t length, int64_t spent);

/* --- results.c */

enum store_answer sqlite_result_append(struct store *store, struct store_segment *segment);
enum store_answer sqlite_result_commit(struct store *store, struct store_segment *segment);
enum store_answer sqlite_result_drop(struct store *store, int64_t number);

/* results.state */
enum { RESULT_BUILDING, RESULT_COMPLETE };

/* Dooms the result if no job refers to it: its chunks go by and by. Inside an operation. */
enum store_answer sqlite_result_forget(struct db *db, int64_t number);

/* --- sweep.c */

enum store_answer sqlite_find_due(struct store *store, bool due[STORE_STEP_COUNT], int64_t *time);
enum store_answer sqlite_step(struct store *store, enum store_step step, int64_t *done);

/* --- items.c */

enum store_answer sqlite_item_put(struct store *store, enum store_item_kind kind,
                                  const struct store_item *item, bool *created);
enum store_answer sqlite_form_put(struct store *store, const char *owner, const char *id,
                                  const void *form, size_t length);
enum store_answer sqlite_item_delete(struct store *store, enum store_item_kind kind,
                                     const char *owner, const char *id);

#endif
