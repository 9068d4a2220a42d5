/* SPDX-License-Identifier: MIT */
#include "server/log.h"
#include "sqlite.h"
#include <string.h>

enum {
    JOBS_A_STEP = 64,    /* ended jobs handled in one transaction */
    CHUNKS_A_STEP = 256, /* chunks deleted in one */
    STEPS_A_SWEEP = 100, /* of each kind: then `more` is set */
    PAGES_A_STEP = 2048, /* free pages given back to the file system in one */
    HOLDERS = 64         /* processes looked at */
};

/* Records outlive their results by this factor of the retention, to answer 410. */
enum { RECORD_RETENTIONS = 4 };

/* What a step does. */
struct step {
    struct store_sweep *sweep;
    const char *holder; /* interrupted jobs: of this one */
    char id[ID_SIZE];   /* the job that changed */
    bool failed;
    int64_t done;
};

/* ------------------------------------------------------------------ claims that ended */

static enum store_answer requeue_found(struct sqlite_store *store, struct db *db, struct step *step,
                                       struct query *query, enum requeue cause,
                                       const char *detail) {
    bool found = query_row(query);
    int64_t sequence = found ? query_int(query, 0) : 0;
    int64_t token = found ? query_int(query, 1) : 0;
    if (found)
        query_copy(query, 2, step->id, sizeof step->id);
    enum store_answer answer = query_end(query);
    if (answer != STORE_OK || !found)
        return answer != STORE_OK ? answer : STORE_EMPTY;
    return sqlite_requeue(store, db, sequence, token, cause, detail, &step->failed);
}

static enum store_answer end_lease(struct sqlite_store *store, struct db *db, void *context) {
    struct query query = db_query(db, "SELECT sequence, token, id FROM jobs"
                                      " WHERE status = 1 AND lease < ? ORDER BY lease LIMIT 1");
    query_bind_int(&query, sqlite_now(store));
    return requeue_found(store, db, context, &query, REQUEUE_CRASHED,
                         "its dispatcher did not renew the lease");
}

static enum store_answer end_holder(struct sqlite_store *store, struct db *db, void *context) {
    struct step *step = context;
    struct query query = db_query(db, "SELECT sequence, token, id FROM jobs"
                                      " WHERE status = 1 AND holder = ? LIMIT 1");
    query_bind_text(&query, step->holder);
    return requeue_found(store, db, step, &query, REQUEUE_INTERRUPTED,
                         "the service itself died each time");
}

/* Repeats a step that handles one job, and tells who waits for it. */
static enum store_answer repeat_claims(struct store *store, sqlite_operation operation,
                                       struct step *step) {
    enum store_answer answer = STORE_OK;
    while ((answer = sqlite_write(store, operation, step)) == STORE_OK) {
        step->sweep->failed += step->failed;
        step->sweep->requeued += !step->failed;
        log_warning(log_event("claim_ended"), log_text("job", step->id),
                    log_text("cause", step->holder ? "process gone" : "lease"),
                    log_text("then", step->failed ? "failed" : "queued"));
        hub_notify(store->hub, step->id);
        hub_notify(store->hub, hub_queue);
    }
    return answer == STORE_EMPTY ? STORE_OK : answer;
}

struct holders {
    char names[HOLDERS][ID_SIZE];
    size_t count;
    bool leases; /* some lease has ended */
};

static enum store_answer look_at_claims(struct sqlite_store *store, struct db *db, void *context) {
    (void)store;
    struct holders *holders = context;
    int64_t now = sqlite_now(store);
    struct query query = db_query(db, "SELECT holder, min(lease) FROM jobs WHERE status = 1"
                                      " GROUP BY holder");
    while (query_row(&query)) {
        holders->leases = holders->leases || query_int(&query, 1) < now;
        if (holders->count < HOLDERS)
            query_copy(&query, 0, holders->names[holders->count++], ID_SIZE);
    }
    return query_end(&query);
}

static enum store_answer sweep_claims(struct store *store, struct store_sweep *sweep) {
    struct holders holders = {.count = 0};
    enum store_answer answer = sqlite_read(store, look_at_claims, &holders);
    for (size_t k = 0; k < holders.count && answer == STORE_OK; k++) {
        struct step step = {.sweep = sweep, .holder = holders.names[k]};
        if (holder_dead(sqlite_holder(sqlite_of(store)), step.holder))
            answer = repeat_claims(store, end_holder, &step);
    }
    struct step step = {.sweep = sweep};
    if (answer == STORE_OK && holders.leases)
        answer = repeat_claims(store, end_lease, &step);
    return answer;
}

/* ------------------------------------------------------------------ retention */

static enum store_answer next_ended(struct db *db, bool expired, int64_t before, int64_t *sequence,
                                    int64_t *result) {
    struct query query = db_query(db, "SELECT sequence, result FROM jobs WHERE status >= 2"
                                      " AND expired = ? AND finished < ? ORDER BY finished"
                                      " LIMIT 1");
    query_bind_int(&query, expired);
    query_bind_int(&query, before);
    bool found = query_row(&query);
    *sequence = found ? query_int(&query, 0) : 0;
    *result = found ? query_int(&query, 1) : 0;
    enum store_answer answer = query_end(&query);
    return answer == STORE_OK && !found ? STORE_EMPTY : answer;
}

static enum store_answer run_with(struct db *db, const char *sql, int64_t sequence) {
    struct query query = db_query(db, sql);
    query_bind_int(&query, sequence);
    return query_run(&query);
}

static enum store_answer expire_one(struct db *db, int64_t before) {
    int64_t sequence = 0;
    int64_t result = 0;
    enum store_answer answer = next_ended(db, false, before, &sequence, &result);
    if (answer == STORE_OK)
        answer = run_with(db, "DELETE FROM requests WHERE job = ?", sequence);
    if (answer == STORE_OK)
        answer = run_with(db,
                          "UPDATE jobs SET expired = 1, result = NULL, summary ="
                          " (SELECT summary FROM results WHERE number = jobs.result)"
                          " WHERE sequence = ?",
                          sequence);
    return answer == STORE_OK && result ? sqlite_result_forget(db, result) : answer;
}

static enum store_answer remove_one(struct db *db, int64_t before) {
    int64_t sequence = 0;
    int64_t result = 0;
    enum store_answer answer = next_ended(db, true, before, &sequence, &result);
    return answer == STORE_OK ? run_with(db, "DELETE FROM jobs WHERE sequence = ?", sequence)
                              : answer;
}

static enum store_answer several(struct db *db, enum store_answer (*one)(struct db *, int64_t),
                                 int64_t before, struct step *step) {
    step->done = 0;
    while (step->done < JOBS_A_STEP) {
        enum store_answer answer = one(db, before);
        if (answer == STORE_EMPTY && step->done > 0)
            return STORE_OK;
        if (answer != STORE_OK)
            return answer;
        step->done++;
    }
    return STORE_OK;
}

static enum store_answer expire(struct sqlite_store *store, struct db *db, void *context) {
    return several(db, expire_one, sqlite_now(store) - sqlite_options(store)->retention_us,
                   context);
}

static bool over_bytes(const struct sqlite_store *store, struct db *db) {
    int64_t most = sqlite_options(store)->retention_bytes;
    struct query query = db_query(db, "SELECT bytes FROM stored");
    bool over = most > 0 && query_row(&query) && query_int(&query, 0) > most;
    return query_end(&query) == STORE_OK && over;
}

/* The oldest, until the rest is within the bound. What others share is freed with the last. */
static enum store_answer expire_excess(struct sqlite_store *store, struct db *db, void *context) {
    struct step *step = context;
    enum store_answer answer = STORE_OK;
    for (step->done = 0; step->done < JOBS_A_STEP && over_bytes(store, db); step->done++) {
        answer = expire_one(db, INT64_MAX);
        if (answer != STORE_OK)
            break;
    }
    return answer == STORE_OK || answer == STORE_EMPTY ? (step->done ? STORE_OK : STORE_EMPTY)
                                                       : answer;
}

static enum store_answer remove_records(struct sqlite_store *store, struct db *db, void *context) {
    int64_t age = sqlite_options(store)->retention_us * RECORD_RETENTIONS;
    return several(db, remove_one, sqlite_now(store) - age, context);
}

/* ------------------------------------------------------------------ remains */

/* Results that were begun by claims that no longer hold. */
static enum store_answer doom(struct sqlite_store *store, struct db *db, void *context) {
    (void)store;
    struct step *step = context;
    struct query query =
        db_query(db, "UPDATE results SET state = 2 WHERE state <> 1 AND state = 0 AND NOT EXISTS"
                     " (SELECT 1 FROM jobs j WHERE j.sequence = results.job"
                     " AND j.token = results.token AND j.status = 1)");
    enum store_answer answer = query_run(&query);
    step->done = db_changes(db);
    return answer == STORE_OK && step->done == 0 ? STORE_EMPTY : answer;
}

static enum store_answer delete_chunks(struct db *db, int64_t number) {
    struct query query = db_query(
        db, "DELETE FROM chunks WHERE id IN"
            " (SELECT id FROM chunks WHERE id >= ?1 << ?2 AND id < (?1 + 1) << ?2 LIMIT ?3)");
    query_bind_int(&query, number);
    query_bind_int(&query, STORE_CHUNKS_BITS);
    query_bind_int(&query, CHUNKS_A_STEP);
    return query_run(&query);
}

/* A slice of one doomed result; its row goes with the last slice. */
static enum store_answer clear(struct sqlite_store *store, struct db *db, void *context) {
    (void)store;
    (void)context;
    struct query query =
        db_query(db, "SELECT number FROM results WHERE state <> 1 AND state = 2 LIMIT 1");
    bool found = query_row(&query);
    int64_t number = found ? query_int(&query, 0) : 0;
    enum store_answer answer = query_end(&query);
    if (answer == STORE_OK && !found)
        return STORE_EMPTY;
    if (answer == STORE_OK)
        answer = delete_chunks(db, number);
    if (answer == STORE_OK && db_changes(db) < CHUNKS_A_STEP)
        answer = run_with(db, "DELETE FROM results WHERE number = ?", number);
    return answer;
}

/* Gives pages back when more than a quarter of the file is free. */
static enum store_answer shrink(struct sqlite_store *store, struct db *db, void *context) {
    (void)store;
    (void)context;
    struct query query = db_query(db, "SELECT f.freelist_count, p.page_count"
                                      " FROM pragma_freelist_count f, pragma_page_count p");
    bool any = query_row(&query);
    bool worth = any && query_int(&query, 0) > PAGES_A_STEP &&
                 query_int(&query, 0) > query_int(&query, 1) / 4;
    enum store_answer answer = query_end(&query);
    if (answer != STORE_OK || !worth)
        return answer != STORE_OK ? answer : STORE_EMPTY;
    query = db_query(db, "PRAGMA incremental_vacuum(2048)");
    while (query_row(&query))
        continue;
    return query_end(&query);
}

/* ------------------------------------------------------------------ the sweep */

struct work {
    bool expire, excess, remove, doom, clear, shrink;
};

static bool any(struct db *db, const char *sql, int64_t value) {
    struct query query = db_query(db, sql);
    query_bind_int(&query, value);
    bool found = query_row(&query);
    return query_end(&query) == STORE_OK && found;
}

/* Finds out by reading what there is to do, so that an idle store is not written to. */
static enum store_answer look_at_work(struct sqlite_store *store, struct db *db, void *context) {
    struct work *work = context;
    int64_t retention = sqlite_options(store)->retention_us;
    int64_t now = sqlite_now(store);
    work->expire = any(db,
                       "SELECT 1 FROM jobs WHERE status >= 2 AND expired = 0"
                       " AND finished < ? LIMIT 1",
                       now - retention);
    work->excess = over_bytes(store, db);
    work->remove = any(db,
                       "SELECT 1 FROM jobs WHERE status >= 2 AND expired = 1"
                       " AND finished < ? LIMIT 1",
                       now - retention * RECORD_RETENTIONS);
    work->doom = any(db, "SELECT 1 FROM results WHERE state <> 1 AND state = ?", RESULT_BUILDING);
    work->clear = any(db, "SELECT 1 FROM results WHERE state <> 1 AND state = ?", RESULT_DOOMED);
    work->shrink =
        any(db, "SELECT 1 FROM pragma_freelist_count WHERE freelist_count > ?", PAGES_A_STEP);
    return STORE_OK;
}

/* Repeats a step until it finds nothing more; adds what it did to `*done`, which may be NULL. */
static enum store_answer repeat(struct store *store, sqlite_operation operation,
                                struct store_sweep *sweep, int *done) {
    struct step step = {.sweep = sweep};
    for (int n = 0; n < STEPS_A_SWEEP; n++) {
        enum store_answer answer = sqlite_write_lazy(store, operation, &step);
        if (answer != STORE_OK)
            return answer == STORE_EMPTY ? STORE_OK : answer;
        if (done)
            *done += (int)step.done;
    }
    sweep->more = true;
    return STORE_OK;
}

enum store_answer sqlite_sweep(struct store *store, struct store_sweep *sweep) {
    struct work work = {0};
    enum store_answer answer = sweep_claims(store, sweep);
    if (answer == STORE_OK)
        answer = sqlite_read(store, look_at_work, &work);
    if (answer == STORE_OK && work.expire)
        answer = repeat(store, expire, sweep, &sweep->expired);
    if (answer == STORE_OK && work.excess)
        answer = repeat(store, expire_excess, sweep, &sweep->expired);
    if (answer == STORE_OK && work.remove)
        answer = repeat(store, remove_records, sweep, &sweep->removed);
    if (answer == STORE_OK && work.doom)
        answer = repeat(store, doom, sweep, NULL);
    if (answer == STORE_OK && (work.clear || work.doom || sweep->expired > 0))
        answer = repeat(store, clear, sweep, NULL);
    if (answer == STORE_OK && (work.shrink || work.clear))
        answer = repeat(store, shrink, sweep, NULL);
    return answer == STORE_OK ? sqlite_take_log(store) : answer;
}
