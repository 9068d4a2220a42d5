/* SPDX-License-Identifier: MIT */
#include "api/problem.h"
#include "sqlite.h"
#include <stdlib.h>
#include <string.h>

/* How often the death of the whole daemon is not held against the job. Beyond it the attempt is,
 * so that a job which brings the daemon down cannot do so for ever. */
enum { INTERRUPTIONS_EXCUSED = 20 };

/* ------------------------------------------------------------------ claim */

static enum store_answer any_queued(struct sqlite_store *store, struct db *db, void *context) {
    (void)store;
    (void)context;
    struct query query = db_query(db, "SELECT 1 FROM jobs WHERE status = 0 LIMIT 1");
    bool any = query_row(&query);
    enum store_answer answer = query_end(&query);
    return answer == STORE_OK && !any ? STORE_EMPTY : answer;
}

/* The first job of the owner whose turn it is. The owners who wait are found one by one in the
 * index of the queue, so that its length does not matter; nor does what has ended, as long as no
 * index that has that, too, is taken: hence INDEXED BY. */
static const char pick_sql[] =
    "WITH RECURSIVE waiting (owner) AS ("
    " SELECT min(owner) FROM jobs INDEXED BY jobs_queue WHERE status = 0"
    " UNION ALL"
    " SELECT (SELECT min(j.owner) FROM jobs j INDEXED BY jobs_queue"
    "   WHERE j.status = 0 AND j.owner > waiting.owner)"
    "  FROM waiting WHERE waiting.owner IS NOT NULL),"
    " first (owner) AS ("
    " SELECT owner FROM waiting WHERE owner IS NOT NULL"
    "  ORDER BY (SELECT count(*) FROM (SELECT 1 FROM jobs j INDEXED BY jobs_running"
    "    WHERE j.status = 1 AND j.owner = waiting.owner LIMIT 1000)),"
    "   (SELECT min(j.rank) FROM jobs j INDEXED BY jobs_queue"
    "    WHERE j.status = 0 AND j.owner = waiting.owner) LIMIT 1)"
    "SELECT j.sequence, j.id, j.surface, j.token, j.attempts, r.number"
    " FROM first CROSS JOIN jobs j INDEXED BY jobs_queue"
    "  ON j.owner = first.owner AND j.status = 0"
    " LEFT JOIN results r ON r.digest = j.digest AND r.state = 1"
    " ORDER BY j.rank, j.sequence LIMIT 1";

/* The first of the queue, with the complete result of its digest (0: none). */
static enum store_answer pick(struct db *db, struct store_claim *claim, int64_t *result) {
    struct query query = db_query(db, pick_sql);
    bool any = query_row(&query);
    if (any) {
        claim->sequence = query_int(&query, 0);
        query_copy(&query, 1, claim->id, sizeof claim->id);
        query_copy(&query, 2, claim->surface, sizeof claim->surface);
        claim->token = query_int(&query, 3) + 1;
        claim->attempts = (int)query_int(&query, 4);
        *result = query_int(&query, 5);
    }
    enum store_answer answer = query_end(&query);
    return answer == STORE_OK && !any ? STORE_EMPTY : answer;
}

static enum store_answer succeed(const struct sqlite_store *store, struct db *db,
                                 const struct store_claim *claim, int64_t result) {
    struct query query =
        db_query(db, "UPDATE jobs SET status = 2, progress = 1, started = ?1, finished = ?1,"
                     " result = ?2, token = ?3 WHERE sequence = ?4");
    query_bind_int(&query, sqlite_now(store));
    query_bind_int(&query, result);
    query_bind_int(&query, claim->token);
    query_bind_int(&query, claim->sequence);
    return query_run(&query);
}

static enum store_answer hand_out(struct sqlite_store *store, struct db *db,
                                  const struct store_claim *claim) {
    int64_t now = sqlite_now(store);
    struct query query =
        db_query(db, "UPDATE jobs SET status = 1, progress = 0, started = ?, attempts = ?,"
                     " token = ?, lease = ?, holder = ? WHERE sequence = ?");
    query_bind_int(&query, now);
    query_bind_int(&query, claim->attempts);
    query_bind_int(&query, claim->token);
    query_bind_int(&query, now + sqlite_options(store)->lease_us);
    query_bind_text(&query, holder_name(sqlite_holder(store)));
    query_bind_int(&query, claim->sequence);
    return query_run(&query);
}

struct claiming {
    struct store_claim *claim;
    bool may_end; /* the transaction is durable, as the end of a job has to be */
};

static enum store_answer claim_operation(struct sqlite_store *store, struct db *db, void *context) {
    const struct claiming *claiming = context;
    struct store_claim *claim = claiming->claim;
    int64_t result = 0;
    enum store_answer answer = pick(db, claim, &result);
    if (answer != STORE_OK)
        return answer;
    claim->reused = result != 0;
    if (claim->reused)
        return claiming->may_end ? succeed(store, db, claim, result) : STORE_CONFLICT;
    claim->attempts++;
    return hand_out(store, db, claim);
}

/* An idle dispatcher asks often; only a reader is bothered by that. That a job runs is not worth
 * waiting for the disk: a power cut ends its worker too. */
enum store_answer sqlite_claim(struct store *store, struct store_claim *claim) {
    struct claiming claiming = {.claim = claim};
    enum store_answer answer = sqlite_read(store, any_queued, NULL);
    if (answer == STORE_OK)
        answer = sqlite_write_lazy(store, claim_operation, &claiming);
    if (answer != STORE_CONFLICT)
        return answer;
    claiming.may_end = true;
    return sqlite_write(store, claim_operation, &claiming);
}

/* ------------------------------------------------------------------ holding */

struct holding {
    const struct store_claim *claim;
    double progress;
    const char *text; /* the error, or the detail of a crash */
    enum requeue cause;
};

static enum store_answer changed(struct db *db, struct query *query) {
    enum store_answer answer = query_run(query);
    return answer == STORE_OK && db_changes(db) == 0 ? STORE_CONFLICT : answer;
}

static enum store_answer renew_operation(struct sqlite_store *store, struct db *db, void *context) {
    struct holding *holding = context;
    struct query query = db_query(db, "UPDATE jobs SET lease = ?, progress = max(progress, ?)"
                                      " WHERE sequence = ? AND token = ? AND status = 1");
    query_bind_int(&query, sqlite_now(store) + sqlite_options(store)->lease_us);
    query_bind_real(&query, holding->progress);
    query_bind_int(&query, holding->claim->sequence);
    query_bind_int(&query, holding->claim->token);
    return changed(db, &query);
}

enum store_answer sqlite_renew(struct store *store, const struct store_claim *claim,
                               double progress) {
    struct holding holding = {.claim = claim, .progress = progress};
    return sqlite_write_lazy(store, renew_operation, &holding);
}

static enum store_answer check_operation(struct sqlite_store *store, struct db *db, void *context) {
    (void)store;
    struct holding *holding = context;
    struct query query =
        db_query(db, "SELECT 1 FROM jobs WHERE sequence = ? AND token = ? AND status = 1");
    query_bind_int(&query, holding->claim->sequence);
    query_bind_int(&query, holding->claim->token);
    bool holds = query_row(&query);
    enum store_answer answer = query_end(&query);
    return answer == STORE_OK && !holds ? STORE_CONFLICT : answer;
}

enum store_answer sqlite_check(struct store *store, const struct store_claim *claim) {
    struct holding holding = {.claim = claim};
    return sqlite_read(store, check_operation, &holding);
}

/* ------------------------------------------------------------------ giving up */

static enum store_answer set_failed(const struct sqlite_store *store, struct db *db,
                                    int64_t sequence, int64_t token, const char *error) {
    struct query query = db_query(
        db, "UPDATE jobs SET status = 3, finished = ?, error = ?, lease = NULL, holder = NULL"
            " WHERE sequence = ? AND token = ? AND status = 1");
    query_bind_int(&query, sqlite_now(store));
    query_bind_text(&query, error);
    query_bind_int(&query, sequence);
    query_bind_int(&query, token);
    return changed(db, &query);
}

static enum store_answer fail_operation(struct sqlite_store *store, struct db *db, void *context) {
    struct holding *holding = context;
    return set_failed(store, db, holding->claim->sequence, holding->claim->token, holding->text);
}

enum store_answer sqlite_fail(struct store *store, const struct store_claim *claim,
                              const char *error) {
    struct holding holding = {.claim = claim, .text = error};
    return sqlite_write(store, fail_operation, &holding);
}

static enum store_answer fail_as_crashed(const struct sqlite_store *store, struct db *db,
                                         int64_t sequence, int64_t token, int64_t crashes,
                                         const char *detail) {
    struct api_problem problem = {0};
    api_problem_set(&problem, API_SOLVER_CRASHED,
                    "The solver died in %lld attempts, the most there are; the last time: %s.",
                    (long long)crashes, detail);
    char *json = api_problem_json(&problem, NULL);
    if (!json)
        return STORE_DOWN;
    enum store_answer answer = set_failed(store, db, sequence, token, json);
    free(json);
    return answer;
}

static enum store_answer set_queued(struct db *db, int64_t sequence, int64_t token, bool excused) {
    struct query query =
        db_query(db, "UPDATE jobs SET status = 0, progress = 0, started = 0, lease = NULL,"
                     " holder = NULL, excused = excused + ?"
                     " WHERE sequence = ? AND token = ? AND status = 1");
    query_bind_int(&query, excused);
    query_bind_int(&query, sequence);
    query_bind_int(&query, token);
    return changed(db, &query);
}

enum store_answer sqlite_requeue(struct sqlite_store *store, struct db *db, int64_t sequence,
                                 int64_t token, enum requeue cause, const char *detail,
                                 bool *failed) {
    struct query query = db_query(db, "SELECT attempts, excused FROM jobs"
                                      " WHERE sequence = ? AND token = ? AND status = 1");
    query_bind_int(&query, sequence);
    query_bind_int(&query, token);
    bool holds = query_row(&query);
    int64_t attempts = holds ? query_int(&query, 0) : 0;
    int64_t excuses = holds ? query_int(&query, 1) : 0;
    enum store_answer answer = query_end(&query);
    if (answer != STORE_OK || !holds)
        return answer != STORE_OK ? answer : STORE_CONFLICT;
    bool excused = cause == REQUEUE_RELEASED ||
                   (cause == REQUEUE_INTERRUPTED && excuses < INTERRUPTIONS_EXCUSED);
    int64_t crashes = attempts - excuses;
    *failed = !excused && crashes >= sqlite_options(store)->max_attempts;
    return *failed ? fail_as_crashed(store, db, sequence, token, crashes, detail)
                   : set_queued(db, sequence, token, excused);
}

static enum store_answer requeue_operation(struct sqlite_store *store, struct db *db,
                                           void *context) {
    struct holding *holding = context;
    bool failed = false;
    return sqlite_requeue(store, db, holding->claim->sequence, holding->claim->token,
                          holding->cause, holding->text, &failed);
}

enum store_answer sqlite_crashed(struct store *store, const struct store_claim *claim,
                                 const char *detail) {
    struct holding holding = {.claim = claim, .text = detail, .cause = REQUEUE_CRASHED};
    return sqlite_write(store, requeue_operation, &holding);
}

enum store_answer sqlite_release(struct store *store, const struct store_claim *claim) {
    struct holding holding = {.claim = claim, .text = "", .cause = REQUEUE_RELEASED};
    return sqlite_write(store, requeue_operation, &holding);
}
