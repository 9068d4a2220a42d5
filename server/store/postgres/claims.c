/* SPDX-License-Identifier: MIT */
#include "postgres.h"
#include "server/store/seal.h"
#include "server/store/sql.h"

/* ------------------------------------------------------------------ claim */

/* The owners who wait are found one by one in the index of the queue, then ordered by what runs of
 * theirs, by their last turn and by their first job; of the first owner whose first job nobody else
 * is just taking that one is taken. The row that is read last is the only one that is locked. The
 * token is the time, so that it is a new one even if the server has crashed and forgotten the claim
 * before: the holder of that lives on elsewhere. Everything is asked for in the order of an index,
 * because walking along an index clears what has left it out of the way, which collecting a bitmap
 * from it does not. */
static const char claim_sql[] =
    "WITH RECURSIVE waiting (owner) AS ("
    " (SELECT owner FROM draped.jobs WHERE status = " SQL_QUEUED " ORDER BY owner LIMIT 1)"
    " UNION ALL"
    " SELECT (SELECT j.owner FROM draped.jobs j WHERE j.status = " SQL_QUEUED
    "   AND j.owner > w.owner ORDER BY j.owner LIMIT 1)"
    "  FROM waiting w WHERE w.owner IS NOT NULL),"
    " turns AS MATERIALIZED ("
    " SELECT w.owner, had.running, had.turn,"
    "  (SELECT j.rank FROM draped.jobs j WHERE j.status = " SQL_QUEUED " AND j.owner = w.owner"
    "   ORDER BY j.rank LIMIT 1) AS rank"
    "  FROM waiting w CROSS JOIN LATERAL"
    "  (SELECT sum(o.running) AS running, max(o.turn) AS turn FROM draped.owners o"
    "   WHERE o.owner = w.owner) had"
    "  WHERE w.owner IS NOT NULL AND ($3 = 0 OR had.running < $3) AND ($4 = 0 OR"
    "   had.turn <= pg_sequence_last_value('draped.turns') AND EXISTS"
    "   (SELECT 1 FROM draped.jobs j WHERE j.status = " SQL_QUEUED " AND j.owner = w.owner"
    "    AND j.rank < " SQL_BACKGROUND " AND j.attempts = 0)) ORDER BY 2, 3, 4),"
    " first AS MATERIALIZED ("
    " SELECT q.sequence FROM turns t CROSS JOIN LATERAL"
    "  (SELECT j.sequence FROM draped.jobs j WHERE j.status = " SQL_QUEUED " AND j.owner = t.owner"
    "   AND ($4 = 0 OR j.attempts = 0 AND j.rank < " SQL_BACKGROUND ")"
    "   ORDER BY j.rank, j.sequence LIMIT 1 FOR UPDATE SKIP LOCKED) q LIMIT 1)"
    " UPDATE draped.jobs j SET status = " SQL_RUNNING ", progress = 0,"
    "  started = CASE WHEN j.round > 0 THEN j.started ELSE " POSTGRES_NOW " END,"
    "  attempts = j.attempts + 1, token = greatest(j.token + 1, " POSTGRES_NOW
    "), lease = " POSTGRES_NOW " + $2"
    " FROM first WHERE j.sequence = first.sequence"
    " RETURNING j.sequence, j.id, j.surface, j.token, j.attempts,"
    "  (SELECT r.number FROM draped.results r WHERE r.owner = j.owner AND r.digest = j.digest"
    "   AND r.state = " SQL_COMPLETE "), j.owner, j.origin,"
    "  j.kind, j.spent, j.task, (SELECT p.id FROM draped.jobs p WHERE p.sequence = j.parent),"
    "  j.started - j.created, " POSTGRES_LAZY;

/* A claimed job whose result is there already. */
static const char reuse_sql[] =
    "WITH twin AS MATERIALIZED (SELECT r.number FROM draped.jobs j"
    " JOIN draped.results r ON r.owner = j.owner AND r.digest = j.digest"
    " AND r.state = " SQL_COMPLETE " WHERE j.sequence = $2 FOR SHARE OF r)"
    " UPDATE draped.jobs SET status = " SQL_SUCCEEDED ", progress = 1, started = " POSTGRES_NOW ","
    " finished = " POSTGRES_NOW ", attempts = attempts - 1, result = twin.number,"
    " lease = NULL FROM twin WHERE sequence = $2 AND token = $3 AND status = " SQL_RUNNING
    " RETURNING 1";

enum store_answer postgres_starving(struct store *store, bool fresh) {
    struct query query =
        postgres_query(store, "SELECT 1 FROM draped.owners GROUP BY owner"
                              " HAVING sum(queued) > 0 AND sum(running) = 0"
                              " AND ($1 = 0 OR sum(queued) > sum(tasks) AND"
                              "  max(turn) <= pg_sequence_last_value('draped.turns')) LIMIT 1");
    query_bind(&query, of_int(fresh));
    return query_find(&query, STORE_EMPTY);
}

enum store_answer postgres_claim(struct store *store, bool fresh, struct store_claim *claim) {
    struct query query = postgres_query_now(store, claim_sql);
    int64_t result = 0;
    query_bind(&query, of_int(store->options.lease_us),
               of_int(fresh ? 1 : store->options.owner_running), of_int(fresh));
    bool found = query_row(&query);
    if (found)
        reads_claim(&query, claim, &result);
    enum store_answer answer = query_end_found(&query, found, STORE_EMPTY);
    if (answer == STORE_OK && result) { /* which may have gone meanwhile */
        query = postgres_held_query(store, reuse_sql, claim);
        claim->reused = query_find(&query, STORE_CONFLICT) == STORE_OK;
    }
    return answer;
}

/* No owner has fewer than none running. */
enum store_answer postgres_try_claim(struct store *store) {
    struct query query = postgres_query_now(store, claim_sql);
    query_bind(&query, of_int(store->options.lease_us), of_int(-1), of_int(false));
    return query_run(&query);
}

/* ------------------------------------------------------------------ holding */

enum store_answer postgres_renew(struct store *store, const struct store_claim *claim,
                                 double progress) {
    struct query query = postgres_held_query(
        store,
        "UPDATE draped.jobs SET lease = " POSTGRES_NOW " + $4,"
        " progress = greatest(progress, $5) WHERE" POSTGRES_HELD " RETURNING " POSTGRES_LAZY,
        claim);
    query_bind(&query, of_int(store->options.lease_us), of_real(progress));
    return query_find(&query, STORE_CONFLICT);
}

/* ------------------------------------------------------------------ giving up */

enum store_answer postgres_fail(struct store *store, const struct store_claim *claim,
                                const char *error) {
    struct query query = postgres_held_query(
        store,
        "UPDATE draped.jobs SET status = " SQL_FAILED ", error = $4, error_seal = $5, lease = NULL,"
        " finished = " POSTGRES_NOW " WHERE" POSTGRES_HELD " RETURNING 1",
        claim);
    query_bind(&query, of_text(error), of_int(seal_of_text(error)));
    return query_find(&query, STORE_CONFLICT);
}

static enum store_answer requeue(struct store *store, const struct store_claim *claim, bool excused,
                                 int64_t later, const void *task) {
    struct query query = postgres_query(
        store,
        "UPDATE draped.jobs SET status = " SQL_QUEUED ", progress = 0, lease = NULL,"
        " started = CASE WHEN round > 0 THEN started ELSE 0 END,"
        " task = coalesce(nullif($5, ''), task), excused = excused + $3::integer"
        " WHERE sequence = $1 AND token = $2 AND status = " SQL_RUNNING " RETURNING " POSTGRES_LAZY
        ", CASE WHEN $4 > 0 THEN draped.count_owner(owner, 0, 0, 0, 0, 0,"
        "  pg_sequence_last_value('draped.turns') + $4)::text END");
    query_bind(&query, of_int(claim->sequence), of_int(claim->token), of_int(excused),
               of_int(later), of_bytes(task, task ? claim->task_length : 0));
    return query_find(&query, STORE_CONFLICT);
}

enum store_answer postgres_requeue(struct store *store, const struct store_claim *claim,
                                   bool excused, int64_t later) {
    return requeue(store, claim, excused, later, NULL);
}

enum store_answer postgres_change_task(struct store *store, const struct store_claim *claim,
                                       const void *task) {
    return requeue(store, claim, true, 0, task);
}

/* ------------------------------------------------------------------ claims that ended */

/* A lease that ends so much later than a new one would is of before the clock was set back. Live
 * holders have renewed theirs when the clock has been right for a lease's time: what is left is
 * nobody's. (A factor, because the `--lease` of other hosts may be longer.) */
static int64_t far_ahead(const struct store *store) {
    const struct clock_check clocks = store_clocks(store);
    return clock_check_agreed_us(&clocks) > store->options.lease_us ? 10 * store->options.lease_us
                                                                    : INT64_MAX / 2;
}

enum store_answer postgres_find_ended(struct store *store, struct store_ended *ended, size_t most,
                                      size_t *count) {
    struct query query = postgres_query_now(
        store, "SELECT sequence, token, id FROM draped.jobs WHERE status = " SQL_RUNNING
               " AND (lease < " POSTGRES_NOW " OR lease > " POSTGRES_NOW " + $3)"
               " ORDER BY lease LIMIT $2");
    query_bind(&query, of_int((int64_t)most), of_int(far_ahead(store)));
    for (; *count < most && query_row(&query); ++*count) {
        struct store_claim *claim = &ended[*count].claim;
        claim->sequence = query_int(&query, 0);
        claim->token = query_int(&query, 1);
        query_copy(&query, 2, claim->id, sizeof claim->id);
        ended[*count].holder_gone = false;
    }
    return query_end(&query);
}

enum store_answer postgres_take_over(struct store *store, const struct store_ended *ended,
                                     int64_t *token) {
    struct query query = postgres_held_query(
        store,
        "UPDATE draped.jobs SET token = token + 1, lease = " POSTGRES_NOW " + $4"
        " WHERE" POSTGRES_HELD " AND (lease < " POSTGRES_NOW " OR lease > " POSTGRES_NOW " + $5)"
        " RETURNING token, " POSTGRES_LAZY,
        &ended->claim);
    query_bind(&query, of_int(store->options.lease_us), of_int(far_ahead(store)));
    return query_number(&query, STORE_CONFLICT, token);
}
