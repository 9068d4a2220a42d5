/* SPDX-License-Identifier: MIT */
#include "postgres.h"
#include "server/store/sql.h"

/* ------------------------------------------------------------------ retention and remains */

/* What is `due` keeps its summary alone. */
#define EXPIRE_DUE                                                                                 \
    " gone AS (DELETE FROM draped.requests USING due WHERE job = due.sequence),"                   \
    " done AS (UPDATE draped.jobs j SET expired = 1, result = NULL,"                               \
    "  (summary, summary_seal) = (SELECT r.summary, r.summary_seal FROM draped.results r"          \
    "   WHERE r.number = due.result)"                                                              \
    "  FROM due WHERE j.sequence = due.sequence RETURNING due.result)"                             \
    " SELECT count(*), draped.forget_results(array_agg(result)) FROM done"

/* Each handles some rows that no other process is handling, and gives their number; $2 is the age.
 */
static const char expire_sql[] =
    "WITH due AS MATERIALIZED (SELECT sequence, result FROM draped.jobs"
    " WHERE status >= " SQL_FIRST_ENDED " AND expired = 0 AND finished < " POSTGRES_NOW
    " - $2 LIMIT 64 FOR UPDATE SKIP LOCKED)," EXPIRE_DUE;

/* $2 is the bound of bytes. The oldest jobs of the owner whose results are largest, until they are
 * no larger than the next owner's, or all are within the bound; what jobs share is freed with the
 * last of them, in a later step. */
static const char excess_sql[] =
    "WITH sums AS MATERIALIZED (SELECT owner, sum(results) AS results FROM draped.owners"
    "  WHERE $1::bigint IS DISTINCT FROM $2 GROUP BY owner),"
    " largest AS MATERIALIZED (SELECT owner, least((SELECT sum(results) FROM sums) - $2,"
    "   greatest(1, results - lead(results, 1, 0) OVER (ORDER BY results DESC))) AS bytes"
    "  FROM sums ORDER BY results DESC LIMIT 1),"
    " oldest AS (SELECT j.sequence, j.finished, r.length FROM largest"
    "  JOIN draped.jobs j ON j.owner = largest.owner AND j.result IS NOT NULL"
    "  JOIN draped.results r ON r.number = j.result WHERE largest.bytes > 0"
    "  ORDER BY j.finished, j.sequence LIMIT 64),"
    " chosen AS (SELECT sequence, sum(length) OVER (ORDER BY finished, sequence) - length AS freed"
    "  FROM oldest),"
    " due AS MATERIALIZED (SELECT sequence, result FROM draped.jobs WHERE expired = 0"
    "  AND sequence IN (SELECT sequence FROM chosen, largest WHERE freed < bytes)"
    "  FOR UPDATE SKIP LOCKED)," EXPIRE_DUE;

static const char remove_sql[] =
    "WITH due AS MATERIALIZED (SELECT sequence FROM draped.jobs WHERE status >= " SQL_FIRST_ENDED
    " AND expired = 1 AND finished < " POSTGRES_NOW " - $2 LIMIT 64 FOR UPDATE SKIP LOCKED),"
    " done AS (DELETE FROM draped.jobs j USING due WHERE j.sequence = due.sequence RETURNING 1)"
    " SELECT count(*) FROM done";

/* Results that were begun by claims that no longer hold. */
#define ABANDONED                                                                                  \
    "r.state = " SQL_BUILDING                                                                      \
    " AND NOT EXISTS (SELECT 1 FROM draped.jobs j WHERE j.sequence = r.job"                        \
    " AND j.token = r.token AND j.status = " SQL_RUNNING ")"

static const char doom_sql[] =
    "WITH done AS (UPDATE draped.results r SET state = " SQL_DOOMED
    " WHERE $1::bigint IS DISTINCT FROM $2 AND " ABANDONED " RETURNING 1)"
    " SELECT count(*), " POSTGRES_LAZY " FROM done";

/* A slice of the chunks of some doomed results; with the last slice go their rows. */
static const char clear_sql[] =
    "WITH doomed AS MATERIALIZED (SELECT number FROM draped.results"
    " WHERE $1::bigint IS DISTINCT FROM $2 AND state <> " SQL_COMPLETE " AND state = " SQL_DOOMED
    " ORDER BY number LIMIT 64 FOR UPDATE SKIP LOCKED),"
    " slice AS MATERIALIZED (SELECT c.result, c.index FROM draped.chunks c"
    " JOIN doomed ON c.result = doomed.number LIMIT 256),"
    " cut AS (DELETE FROM draped.chunks c USING slice"
    " WHERE c.result = slice.result AND c.index = slice.index),"
    " gone AS (DELETE FROM draped.results r USING doomed WHERE r.number = doomed.number"
    " AND (SELECT count(*) FROM slice) < 256)"
    " SELECT count(*), " POSTGRES_LAZY " FROM doomed";

/* Vacuuming is the server's own business. */
static const char shrink_sql[] =
    "SELECT draped.forget_owners() WHERE $1::bigint IS DISTINCT FROM $2";

enum store_answer postgres_step(struct store *store, enum store_step step, int64_t *done) {
    const struct {
        const char *sql;
        int64_t bound;
    } steps[STORE_STEP_COUNT] = {
        [STORE_STEP_EXPIRE] = {expire_sql, store->options.retention_us},
        [STORE_STEP_EXPIRE_EXCESS] = {excess_sql, store->options.retention_bytes},
        [STORE_STEP_REMOVE] = {remove_sql, store->options.records_us},
        [STORE_STEP_DOOM] = {doom_sql, 0},
        [STORE_STEP_CLEAR] = {clear_sql, 0},
        [STORE_STEP_SHRINK] = {shrink_sql, 0},
    };
    struct query query = postgres_query_now(store, steps[step].sql);
    query_bind(&query, of_int(steps[step].bound));
    *done = query_row(&query) ? query_int(&query, 0) : 0;
    return query_end_found(&query, *done > 0, STORE_EMPTY);
}

enum store_answer postgres_find_due(struct store *store, bool due[STORE_STEP_COUNT], int64_t *now) {
    static const enum store_step columns[] = {STORE_STEP_EXPIRE, STORE_STEP_REMOVE, STORE_STEP_DOOM,
                                              STORE_STEP_CLEAR};
    struct query query = postgres_query_now(
        store, "SELECT EXISTS (SELECT 1 FROM draped.jobs WHERE status >= " SQL_FIRST_ENDED
               " AND expired = 0 AND finished < " POSTGRES_NOW " - $2),"
               " EXISTS (SELECT 1 FROM draped.jobs WHERE status >= " SQL_FIRST_ENDED
               " AND expired = 1 AND finished < " POSTGRES_NOW " - $3),"
               " EXISTS (SELECT 1 FROM draped.results r WHERE r.state <> " SQL_COMPLETE
               " AND " ABANDONED "),"
               " EXISTS (SELECT 1 FROM draped.results WHERE state <> " SQL_COMPLETE
               " AND state = " SQL_DOOMED "), " POSTGRES_NOW);
    query_bind(&query, of_int(store->options.retention_us), of_int(store->options.records_us));
    if (query_row(&query)) {
        for (int k = 0; k < 4; k++)
            due[columns[k]] = query_int(&query, k) != 0;
        *now = query_int(&query, 4);
    }
    due[STORE_STEP_EXPIRE_EXCESS] = store->options.retention_bytes > 0;
    return query_end(&query);
}
