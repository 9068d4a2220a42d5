/* SPDX-License-Identifier: MIT */
#include "postgres.h"
#include "server/log.h"
#include <string.h>

enum { STEPS_A_SWEEP = 100, LEASES_A_LOOK = 64 };

/* Records outlive their results by this factor of the retention, to answer 410. */
enum { RECORD_RETENTIONS = 4 };

/* ------------------------------------------------------------------ claims that ended */

static enum store_answer look_at_leases(struct store *store, struct store_claim *held,
                                        size_t *count) {
    struct pg_query query =
        postgres_query_now(store, "SELECT sequence, token, id FROM draped.jobs WHERE status = 1"
                                  " AND lease < " POSTGRES_NOW " ORDER BY lease LIMIT 64");
    *count = pg_run(&query);
    for (size_t row = 0; row < *count; row++) {
        held[row].sequence = pg_int(&query, row, 0);
        held[row].token = pg_int(&query, row, 1);
        pg_copy(&query, row, 2, held[row].id, sizeof held[row].id);
    }
    return pg_end(&query);
}

static void tell(struct store *store, const struct store_claim *held, bool failed) {
    log_warning(log_event("claim_ended"), log_text("job", held->id), log_text("cause", "lease"),
                log_text("then", failed ? "failed" : "queued"));
    store_tell(store, held->id);
    store_tell(store, hub_queue);
}

/* Other processes sweep as well: a conflict means that one of them was first. */
static enum store_answer sweep_claims(struct store *store, struct store_sweep *sweep) {
    struct store_claim held[LEASES_A_LOOK];
    size_t count = 0;
    enum store_answer answer = look_at_leases(store, held, &count);
    for (size_t k = 0; k < count && answer == STORE_OK; k++) {
        bool failed = false;
        answer = postgres_end_lease(store, &held[k], &failed);
        if (answer == STORE_OK) {
            sweep->failed += failed;
            sweep->requeued += !failed;
            tell(store, &held[k], failed);
        }
        if (answer == STORE_CONFLICT)
            answer = STORE_OK;
    }
    sweep->more = sweep->more || count == LEASES_A_LOOK;
    return answer;
}

/* ------------------------------------------------------------------ retention and remains */

/* Each handles some rows that no other process is handling, and gives their number; $2 is the
 * retention. */
static const char expire_sql[] =
    "WITH due AS MATERIALIZED (SELECT sequence, result FROM draped.jobs WHERE status >= 2"
    " AND expired = 0 AND finished < " POSTGRES_NOW " - $2 LIMIT 64 FOR UPDATE SKIP LOCKED),"
    " gone AS (DELETE FROM draped.requests USING due WHERE job = due.sequence),"
    " done AS (UPDATE draped.jobs j SET expired = 1, result = NULL,"
    "  summary = (SELECT r.summary FROM draped.results r WHERE r.number = due.result)"
    "  FROM due WHERE j.sequence = due.sequence RETURNING due.result)"
    " SELECT count(*), draped.forget_results(array_agg(result)) FROM done";

/* $2 is the bound of bytes. The oldest jobs before which too much remains; what others share is
 * freed with the last of them, in a later step. */
static const char excess_sql[] =
    "WITH excess AS MATERIALIZED (SELECT sum(length) - $2 AS bytes FROM draped.results"
    " WHERE $1::bigint IS DISTINCT FROM $2 AND state = 1),"
    " oldest AS (SELECT j.sequence, j.finished, coalesce(r.length, 0) AS length FROM draped.jobs j"
    "  LEFT JOIN draped.results r ON r.number = j.result"
    "  WHERE j.status >= 2 AND j.expired = 0 AND (SELECT bytes FROM excess) > 0"
    "  ORDER BY j.finished, j.sequence LIMIT 64),"
    " chosen AS (SELECT sequence, sum(length) OVER (ORDER BY finished, sequence) - length AS freed"
    "  FROM oldest),"
    " due AS MATERIALIZED (SELECT sequence, result FROM draped.jobs WHERE expired = 0"
    "  AND sequence IN (SELECT sequence FROM chosen, excess WHERE freed < bytes)"
    "  FOR UPDATE SKIP LOCKED),"
    " gone AS (DELETE FROM draped.requests USING due WHERE job = due.sequence),"
    " done AS (UPDATE draped.jobs j SET expired = 1, result = NULL,"
    "  summary = (SELECT r.summary FROM draped.results r WHERE r.number = due.result)"
    "  FROM due WHERE j.sequence = due.sequence RETURNING due.result)"
    " SELECT count(*), draped.forget_results(array_agg(result)) FROM done";

static const char remove_sql[] =
    "WITH due AS MATERIALIZED (SELECT sequence FROM draped.jobs WHERE status >= 2 AND expired = 1"
    " AND finished < " POSTGRES_NOW " - $2 * 4 LIMIT 64 FOR UPDATE SKIP LOCKED),"
    " done AS (DELETE FROM draped.jobs j USING due WHERE j.sequence = due.sequence RETURNING 1)"
    " SELECT count(*) FROM done";

_Static_assert(RECORD_RETENTIONS == 4, "as in remove_sql");

/* Results that were begun by claims that no longer hold. */
#define ABANDONED                                                                                  \
    "r.state = 0 AND NOT EXISTS (SELECT 1 FROM draped.jobs j WHERE j.sequence = r.job"             \
    " AND j.token = r.token AND j.status = 1)"

static const char doom_sql[] =
    "WITH done AS (UPDATE draped.results r SET state = 2"
    " WHERE $1::bigint IS DISTINCT FROM $2 AND " ABANDONED " RETURNING 1)"
    " SELECT count(*), " POSTGRES_LAZY " FROM done";

/* A slice of the chunks of some doomed results; with the last slice go their rows. */
static const char clear_sql[] =
    "WITH doomed AS MATERIALIZED (SELECT number FROM draped.results"
    " WHERE $1::bigint IS DISTINCT FROM $2 AND state <> 1 AND state = 2"
    " ORDER BY number LIMIT 64 FOR UPDATE SKIP LOCKED),"
    " slice AS MATERIALIZED (SELECT c.result, c.index FROM draped.chunks c"
    " JOIN doomed ON c.result = doomed.number LIMIT 256),"
    " cut AS (DELETE FROM draped.chunks c USING slice"
    " WHERE c.result = slice.result AND c.index = slice.index),"
    " gone AS (DELETE FROM draped.results r USING doomed WHERE r.number = doomed.number"
    " AND (SELECT count(*) FROM slice) < 256)"
    " SELECT count(*), " POSTGRES_LAZY " FROM doomed";

static struct pg_query retention_query(struct store *store, const char *sql) {
    const struct store_options *options = postgres_options(store);
    struct pg_query query = postgres_query_now(store, sql);
    pg_bind_int(&query, sql == excess_sql ? options->retention_bytes : options->retention_us);
    return query;
}

/* Repeats a step until it finds nothing more; adds what it did to `*done`, which may be NULL. */
static enum store_answer repeat(struct store *store, const char *sql, struct store_sweep *sweep,
                                int *done) {
    for (int n = 0; n < STEPS_A_SWEEP; n++) {
        struct pg_query query = retention_query(store, sql);
        int64_t count = pg_run(&query) ? pg_int(&query, 0, 0) : 0;
        enum store_answer answer = pg_end(&query);
        if (answer != STORE_OK || count == 0)
            return answer;
        if (done)
            *done += (int)count;
    }
    sweep->more = true;
    return STORE_OK;
}

/* ------------------------------------------------------------------ the sweep */

struct work {
    bool leases, expire, excess, remove, doom, clear;
};

static enum store_answer look_at_work(struct store *store, struct work *work) {
    struct pg_query query = retention_query(
        store,
        "SELECT EXISTS (SELECT 1 FROM draped.jobs WHERE status = 1 AND lease < " POSTGRES_NOW "),"
        " EXISTS (SELECT 1 FROM draped.jobs WHERE status >= 2 AND expired = 0"
        "  AND finished < " POSTGRES_NOW " - $2),"
        " EXISTS (SELECT 1 FROM draped.jobs WHERE status >= 2 AND expired = 1"
        "  AND finished < " POSTGRES_NOW " - $2 * 4),"
        " EXISTS (SELECT 1 FROM draped.results r WHERE r.state <> 1 AND " ABANDONED "),"
        " EXISTS (SELECT 1 FROM draped.results WHERE state <> 1 AND state = 2)");
    work->excess = postgres_options(store)->retention_bytes > 0;
    if (pg_run(&query)) {
        work->leases = pg_int(&query, 0, 0) != 0;
        work->expire = pg_int(&query, 0, 1) != 0;
        work->remove = pg_int(&query, 0, 2) != 0;
        work->doom = pg_int(&query, 0, 3) != 0;
        work->clear = pg_int(&query, 0, 4) != 0;
    }
    return pg_end(&query);
}

/* Vacuuming is the server's own business. */
enum store_answer postgres_sweep(struct store *store, struct store_sweep *sweep) {
    struct work work = {0};
    enum store_answer answer = look_at_work(store, &work);
    if (answer == STORE_OK && work.leases)
        answer = sweep_claims(store, sweep);
    if (answer == STORE_OK && work.expire)
        answer = repeat(store, expire_sql, sweep, &sweep->expired);
    if (answer == STORE_OK && work.excess)
        answer = repeat(store, excess_sql, sweep, &sweep->expired);
    if (answer == STORE_OK && work.remove)
        answer = repeat(store, remove_sql, sweep, &sweep->removed);
    if (answer == STORE_OK && (work.doom || work.leases))
        answer = repeat(store, doom_sql, sweep, NULL);
    if (answer == STORE_OK && (work.clear || work.doom || work.leases || sweep->expired > 0))
        answer = repeat(store, clear_sql, sweep, NULL);
    return answer;
}
