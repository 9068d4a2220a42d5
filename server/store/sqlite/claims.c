/* SPDX-License-Identifier: MIT */
#include "server/store/seal.h"
#include "server/store/sql.h"
#include "sqlite.h"
#include <string.h>

/* ------------------------------------------------------------------ claim */

/* The first job of the owner whose turn it is. Owners with an equal turn came since the last claim:
 * of those, up to 64 are compared by their first jobs. So neither the number of owners matters nor
 * what is queued or has ended, as long as no index that has more is taken: hence INDEXED BY. */
static const char pick_sql[] =
    "WITH next (owner, running, turn) AS MATERIALIZED ("
    " SELECT owner, running, turn FROM owners INDEXED BY owners_turn"
    "  WHERE queued > 0 AND running < ?1 AND (NOT ?2 OR turn <= (SELECT n FROM turns) AND EXISTS"
    "   (SELECT 1 FROM jobs j INDEXED BY jobs_queue WHERE j.status = " SQL_QUEUED
    "   AND j.owner = owners.owner AND j.rank < " SQL_BACKGROUND
    "   AND j.attempts = 0)) ORDER BY running, turn LIMIT 64),"
    " first (owner) AS (SELECT owner FROM next"
    "  WHERE (running, turn) = (SELECT running, turn FROM next LIMIT 1)"
    "  ORDER BY (SELECT min(j.rank) FROM jobs j INDEXED BY jobs_queue"
    "   WHERE j.status = " SQL_QUEUED " AND j.owner = next.owner) LIMIT 1)"
    "SELECT j.sequence, j.id, j.surface, j.token + 1, j.attempts, r.number, j.owner, j.origin,"
    " j.kind, j.spent, j.task, (SELECT id FROM jobs p WHERE p.sequence = j.parent), ?3 - j.created"
    " FROM first CROSS JOIN jobs j INDEXED BY jobs_queue"
    "  ON j.owner = first.owner AND j.status = " SQL_QUEUED
    "  AND (NOT ?2 OR j.attempts = 0 AND j.rank < " SQL_BACKGROUND ")"
    " LEFT JOIN results r ON r.owner = j.owner AND r.digest = j.digest AND r.state = " SQL_COMPLETE
    " ORDER BY j.rank, j.sequence LIMIT 1";

/* The first of the queue among owners with fewer running ones than `most`, with the complete result
 * of its digest (0: none). */
static enum store_answer pick_job(const struct sqlite_store *store, struct db *db, int64_t most,
                                  bool fresh, struct store_claim *claim, int64_t *result) {
    struct query query = db_query(db, pick_sql);
    query_bind(&query, of_int(most), of_int(fresh), of_int(sqlite_now(store)));
    bool any = query_row(&query);
    if (any)
        reads_claim(&query, claim, result);
    return query_end_found(&query, any, STORE_EMPTY);
}

static enum store_answer hand_out(struct sqlite_store *store, struct db *db,
                                  const struct store_claim *claim) {
    struct query query = db_query(db, "UPDATE jobs SET status = " SQL_RUNNING
                                      ", progress = 0, attempts = ?2, started ="
                                      " CASE WHEN round > 0 THEN started ELSE ?1 END,"
                                      " token = ?3, lease = ?4, holder = ?5 WHERE sequence = ?6");
    query_bind(&query, of_int(sqlite_now(store)), of_int(claim->attempts), of_int(claim->token),
               of_int(sqlite_steady(store) + sqlite_options(store)->lease_us),
               of_text(process_lock_name(sqlite_process(store))), of_int(claim->sequence));
    return query_run(&query);
}

struct claiming {
    struct store_claim *claim;
    bool fresh;   /* `store_claim_fresh` */
    bool may_end; /* the transaction is durable, as the end of a job has to be */
};

static enum store_answer claim_operation(struct sqlite_store *store, struct db *db, void *context) {
    const struct claiming *claiming = context;
    struct store_claim *claim = claiming->claim;
    int64_t result = 0;
    int64_t most = sqlite_options(store)->owner_running;
    enum store_answer answer = pick_job(store, db,
                                        claiming->fresh ? 1
                                        : most > 0      ? most
                                                        : INT64_MAX,
                                        claiming->fresh, claim, &result);
    if (answer != STORE_OK)
        return answer;
    claim->reused = result != 0;
    if (!claim->reused) {
        claim->attempts++;
        return hand_out(store, db, claim);
    }
    if (!claiming->may_end)
        return STORE_CONFLICT;
    struct query query = db_query(db, "UPDATE jobs SET status = " SQL_SUCCEEDED
                                      ", progress = 1, started = ?1, finished = ?1,"
                                      " result = ?2, token = ?3 WHERE sequence = ?4");
    query_bind(&query, of_int(sqlite_now(store)), of_int(result), of_int(claim->token),
               of_int(claim->sequence));
    return query_run(&query);
}

/* Looks into the index of what waits: left to itself SQLite looks through one of all jobs that ever
 * ended. */
static const char any_queued_sql[] =
    "SELECT 1 FROM jobs INDEXED BY jobs_queue WHERE status = " SQL_QUEUED " LIMIT 1";

/* An idle dispatcher asks often; only a reader is bothered by that. That a job runs is not worth
 * waiting for the disk: a power cut ends its worker too. */
enum store_answer sqlite_claim(struct store *store, bool fresh, struct store_claim *claim) {
    struct claiming claiming = {.claim = claim, .fresh = fresh};
    struct query query = sqlite_read(store, any_queued_sql);
    enum store_answer answer = query_find(&query, STORE_EMPTY);
    if (answer == STORE_OK)
        answer = sqlite_write(store, DB_LAZY, claim_operation, &claiming);
    if (answer != STORE_CONFLICT)
        return answer;
    claiming.may_end = true;
    return sqlite_write(store, DB_DURABLE, claim_operation, &claiming);
}

enum store_answer sqlite_claim_too(struct sqlite_store *store, struct db *db,
                                   struct store_claim *claim) {
    struct claiming claiming = {.claim = claim, .may_end = true};
    struct query query = db_query(db, any_queued_sql);
    enum store_answer answer = query_find(&query, STORE_EMPTY);
    if (answer == STORE_OK)
        answer = claim_operation(store, db, &claiming);
    return answer == STORE_EMPTY ? STORE_OK : answer;
}

/* No owner has fewer than none running, and no job has that number. */
enum store_answer sqlite_try_claim(struct sqlite_store *store, struct db *db) {
    struct store_claim claim = {.sequence = -1};
    int64_t result = 0;
    enum store_answer answer = pick_job(store, db, 0, false, &claim, &result);
    return answer == STORE_EMPTY ? hand_out(store, db, &claim) : answer;
}

enum store_answer sqlite_starving(struct store *store, bool fresh) {
    struct query query = sqlite_read(
        store, "SELECT 1 FROM owners INDEXED BY owners_turn WHERE queued > 0 AND running = 0"
               " AND (NOT ? OR queued > tasks AND turn <= (SELECT n FROM turns)) LIMIT 1");
    query_bind(&query, of_int(fresh));
    return query_find(&query, STORE_EMPTY);
}

/* ------------------------------------------------------------------ holding */

enum store_answer sqlite_renew(struct store *store, const struct store_claim *claim,
                               double progress) {
    const struct sqlite_store *own = sqlite_of(store);
    struct query query = {.sql = "UPDATE jobs SET lease = ?, progress = max(progress, ?)"
                                 " WHERE sequence = ? AND token = ? AND status = " SQL_RUNNING};
    query_bind(&query, of_int(sqlite_steady(own) + sqlite_options(own)->lease_us),
               of_real(progress), of_int(claim->sequence), of_int(claim->token));
    return sqlite_change(store, DB_LAZY, &query, STORE_CONFLICT);
}

/* ------------------------------------------------------------------ giving up */

enum store_answer sqlite_fail(struct store *store, const struct store_claim *claim,
                              const char *error) {
    struct query query = {.sql = "UPDATE jobs SET status = " SQL_FAILED
                                 ", finished = ?, error = ?, error_seal = ?,"
                                 " lease = NULL, holder = NULL WHERE sequence = ? AND token = ? "
                                 "AND status = " SQL_RUNNING};
    query_bind(&query, of_int(sqlite_now(sqlite_of(store))), of_text(error),
               of_int(seal_of_text(error)), of_int(claim->sequence), of_int(claim->token));
    return sqlite_change(store, DB_DURABLE, &query, STORE_CONFLICT);
}

struct giving_up {
    const struct store_claim *claim;
    bool excused;
    int64_t later;
    const void *task; /* it becomes another; NULL: the same */
};

static enum store_answer requeue_operation(struct sqlite_store *store, struct db *db,
                                           void *context) {
    (void)store;
    const struct giving_up *giving_up = context;
    struct query query = db_query(
        db, "UPDATE jobs SET status = " SQL_QUEUED ", progress = 0, lease = NULL, holder = NULL,"
            " started = CASE WHEN round > 0 THEN started ELSE 0 END, excused = excused + ?,"
            " task = coalesce(?, task) WHERE sequence = ? AND token = ? AND status = " SQL_RUNNING);
    query_bind(&query, of_int(giving_up->excused),
               giving_up->task ? of_bytes(giving_up->task, giving_up->claim->task_length)
                               : of_text(NULL),
               of_int(giving_up->claim->sequence), of_int(giving_up->claim->token));
    enum store_answer answer = db_change(&query, STORE_CONFLICT);
    if (answer != STORE_OK || !giving_up->later)
        return answer;
    query = db_query(db, "UPDATE owners SET turn = (SELECT n FROM turns) + ?1 WHERE owner ="
                         " (SELECT owner FROM jobs WHERE sequence = ?2)");
    query_bind(&query, of_int(giving_up->later), of_int(giving_up->claim->sequence));
    return query_run(&query);
}

/* Not worth waiting for the disk, like the claim: after a power cut it is in the queue anyway. */
enum store_answer sqlite_requeue(struct store *store, const struct store_claim *claim, bool excused,
                                 int64_t later) {
    struct giving_up giving_up = {.claim = claim, .excused = excused, .later = later};
    return sqlite_write(store, DB_LAZY, requeue_operation, &giving_up);
}

enum store_answer sqlite_change_task(struct store *store, const struct store_claim *claim,
                                     const void *task) {
    struct giving_up giving_up = {.claim = claim, .excused = true, .task = task};
    return sqlite_write(store, DB_LAZY, requeue_operation, &giving_up);
}

/* ------------------------------------------------------------------ claims that ended */

/* Each process is looked at once. */
enum store_answer sqlite_find_ended(struct store *base, struct store_ended *ended, size_t most,
                                    size_t *count) {
    const struct sqlite_store *store = sqlite_of(base);
    int64_t now = sqlite_steady(store);
    char holder[ID_SIZE] = "";
    bool gone = false;
    struct query query = sqlite_read(base, "SELECT sequence, token, id, holder, lease FROM jobs"
                                           " WHERE status = " SQL_RUNNING " ORDER BY holder");
    while (*count < most && query_row(&query)) {
        const char *name = query_text(&query, 3);
        if (name && strcmp(name, holder) != 0) {
            query_copy(&query, 3, holder, sizeof holder);
            gone = process_lock_gone(sqlite_process(store), holder);
        }
        if (!gone && query_int(&query, 4) >= now)
            continue;
        struct store_claim *claim = &ended[*count].claim;
        claim->sequence = query_int(&query, 0);
        claim->token = query_int(&query, 1);
        query_copy(&query, 2, claim->id, sizeof claim->id);
        ended[(*count)++].holder_gone = gone;
    }
    return query_end(&query);
}

enum store_answer sqlite_take_over(struct store *base, const struct store_ended *ended,
                                   int64_t *token) {
    const struct sqlite_store *store = sqlite_of(base);
    int64_t now = sqlite_steady(store);
    struct query query = {.sql = "UPDATE jobs SET token = token + 1, lease = ?, holder = ?"
                                 " WHERE sequence = ? AND token = ? AND status = " SQL_RUNNING
                                 " AND (? OR lease < ?)"};
    query_bind(&query, of_int(now + sqlite_options(store)->lease_us),
               of_text(process_lock_name(sqlite_process(store))), of_int(ended->claim.sequence),
               of_int(ended->claim.token), of_int(ended->holder_gone), of_int(now));
    *token = ended->claim.token + 1;
    return sqlite_change(base, DB_LAZY, &query, STORE_CONFLICT);
}
