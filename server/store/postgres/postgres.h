/* SPDX-License-Identifier: MIT */
/*
 * Inside the PostgreSQL backend. `postgres.c` opens the database; what is written in SQL is in
 * `jobs.c`, `claims.c`, `rounds.c`, `results.c`, `items.c`, `sweep.c` and `schema.c`, in the words
 * of `server/store/query.h`; `statement.c` runs it, `pool.c` keeps the connections, and `notify.c`
 * carries hints between processes.
 *
 * SQLite's backend is sure to be the only writer and takes its time over several statements in one
 * transaction. Here others write at the same moment and every statement costs a way to another
 * machine, so that an operation is one statement, written so that it is right beside any other:
 * what decides is locked (FOR SHARE, FOR UPDATE) or is a condition of the very row that changes.
 * That is why the two share no SQL that writes; they share the reads (`reads.c`) and the tests.
 */
#ifndef SERVER_STORE_POSTGRES_POSTGRES_H
#define SERVER_STORE_POSTGRES_POSTGRES_H

#include "server/store/backend.h"
#include "statement.h"

/* A statement on the store's database. */
struct query postgres_query(struct store *store, const char *sql);

/* The same, with the time by the test's clock as $1, or null. */
struct query postgres_query_now(struct store *store, const char *sql);

/* The same for what a claim holds, whose sequence and token are $2 and $3. */
struct query postgres_held_query(struct store *store, const char *sql,
                                 const struct store_claim *claim);
#define POSTGRES_HELD " sequence = $2 AND token = $3 AND status = " SQL_RUNNING

/* In such statements: the time, in microseconds since 1970 UTC by the database's clock. */
#define POSTGRES_NOW "coalesce($1, (extract(epoch FROM clock_timestamp()) * 1000000)::bigint)"

/* Among the columns of a statement: its commit does not wait for the disk. For what means nothing
 * once the database's machine has stopped, or is done again. */
#define POSTGRES_LAZY "set_config('synchronous_commit', 'off', true)"

/* For reads, on the pool of a store or of a look from outside. */
struct reader postgres_reader(struct pool *pool);

/* --- schema.c */

/* Makes the tables where there are none; checks their version, and the user's privileges. Any
 * number of processes may do so at once. False with `why`. */
bool postgres_prepare_tables(struct pool *pool, char why[STORE_WHY_SIZE]);

/* --- hosts.c */

enum store_answer postgres_beat(struct store *store, const struct store_host *host);
void postgres_leave(struct store *store, const char *name);

/* Whether the database takes another megabyte: STORE_OK or STORE_NO_SPACE. Nothing of it stays. */
enum store_answer postgres_grow(struct store *store);

/* A part of a statement, "usable AS (...)": what a job needs from its submission to its end. A
 * statement that has it fails when any of these columns is gone; it is not executed. */
#define POSTGRES_USABLE                                                                            \
    "usable AS (SELECT j.sequence, j.status, j.rank, j.owner, j.digest, j.surface, j.started,"     \
    " j.finished, j.progress, j.attempts, j.excused, j.token, j.lease, j.result, j.summary,"       \
    " j.error, j.expired, j.origin, j.kind, j.parent, j.round, j.open, j.task, m.bytes, o.owner, " \
    "o.queued, o.running, o.turn, r.number, r.digest,"                                             \
    " r.state, r.job, r.token, r.length, r.summary, r.owner, c.result, c.index, c.bytes, q.job,"   \
    " q.bytes, s.id, s.owner, s.definition FROM draped.jobs j, draped.owners o,"                   \
    " draped.results r, draped.chunks c, draped.requests q, draped.surfaces s, "                   \
    "draped.task_numbers m"                                                                        \
    " WHERE false)"

/* --- jobs.c */

enum store_answer postgres_submit(struct store *store, const struct store_submission *submission,
                                  struct store_receipt *receipt);
enum store_answer postgres_submit_family(struct store *store, const struct store_family *family,
                                         struct store_receipt *receipt);
enum store_answer postgres_cancel(struct store *store, const char *id);
enum store_answer postgres_remove(struct store *store, const char *id);

/* --- claims.c */

enum store_answer postgres_claim(struct store *store, bool fresh, struct store_claim *claim);
enum store_answer postgres_starving(struct store *store, bool fresh);
/* Runs the statement of claims so that it finds nothing. */
enum store_answer postgres_try_claim(struct store *store);
enum store_answer postgres_renew(struct store *store, const struct store_claim *claim,
                                 double progress);
enum store_answer postgres_fail(struct store *store, const struct store_claim *claim,
                                const char *error);
enum store_answer postgres_requeue(struct store *store, const struct store_claim *claim,
                                   bool excused, int64_t later);
enum store_answer postgres_change_task(struct store *store, const struct store_claim *claim,
                                       const void *task);
enum store_answer postgres_find_ended(struct store *store, struct store_ended *ended, size_t most,
                                      size_t *count);
enum store_answer postgres_take_over(struct store *store, const struct store_ended *ended,
                                     int64_t *token);

/* --- rounds.c */

enum store_answer postgres_begin_round(struct store *store, const struct store_claim *claim,
                                       const struct store_round *round);
enum store_answer postgres_end_task(struct store *store, const struct store_claim *claim,
                                    const void *numbers, size_t length, int64_t spent);

/* --- results.c */

enum store_answer postgres_result_append(struct store *store, struct store_segment *segment);
enum store_answer postgres_result_commit(struct store *store, struct store_segment *segment);
enum store_answer postgres_result_drop(struct store *store, int64_t number);

/* --- sweep.c */

enum store_answer postgres_find_due(struct store *store, bool due[STORE_STEP_COUNT], int64_t *now);
enum store_answer postgres_step(struct store *store, enum store_step step, int64_t *done);

/* --- items.c */

enum store_answer postgres_item_put(struct store *store, enum store_item_kind kind,
                                    const struct store_item *item, bool *created);
enum store_answer postgres_form_put(struct store *store, const char *owner, const char *id,
                                    const void *form, size_t length);
enum store_answer postgres_item_delete(struct store *store, enum store_item_kind kind,
                                       const char *owner, const char *id);

#endif
