/* SPDX-License-Identifier: MIT */
#include "server/store/sql.h"
#include "sqlite.h"

enum {
    JOBS_A_STEP = 64,   /* ended jobs handled in one transaction */
    CHUNKS_A_STEP = 64, /* chunks deleted in one */
    FREE_PAGES = 2048   /* that the file keeps; some more are given back in one */
};

/* ------------------------------------------------------------------ retention */

static bool over_bytes(const struct sqlite_store *store, struct db *db) {
    int64_t most = sqlite_options(store)->retention_bytes, bytes = 0;
    if (most <= 0)
        return false;
    struct query query = db_query(db, "SELECT bytes FROM stored");
    return query_number(&query, STORE_OK, &bytes) == STORE_OK && bytes > most;
}

struct stepping {
    enum store_step step;
    int64_t *done;
};

/* The oldest jobs that have ended lose their requests and results or, when they have none, their
 * records. While all results are too large it is the oldest job with a result of the owner whose
 * results are largest; one that other jobs share is freed with the last of them. */
static enum store_answer retire(struct sqlite_store *store, struct db *db, void *context) {
    const struct stepping *stepping = context;
    const struct store_options *options = sqlite_options(store);
    const bool excess = stepping->step == STORE_STEP_EXPIRE_EXCESS;
    const bool records = stepping->step == STORE_STEP_REMOVE;
    int64_t before = sqlite_now(store) - (records ? options->records_us : options->retention_us);
    int64_t *done = stepping->done;
    enum store_answer answer = STORE_OK;
    while (*done < JOBS_A_STEP && answer == STORE_OK && (!excess || over_bytes(store, db))) {
        struct query query = db_query(
            db, excess ? "SELECT sequence, result FROM jobs INDEXED BY jobs_owner_result"
                         " WHERE owner = (SELECT owner FROM owners INDEXED BY owners_results"
                         "  ORDER BY results DESC LIMIT 1) AND result IS NOT NULL"
                         " ORDER BY finished LIMIT 1"
                       : "SELECT sequence, result FROM jobs WHERE status >= " SQL_FIRST_ENDED
                         " AND expired = ? AND finished < ? ORDER BY finished LIMIT 1");
        if (!excess)
            query_bind(&query, of_int(records), of_int(before));
        bool found = query_row(&query);
        int64_t sequence = found ? query_int(&query, 0) : 0;
        int64_t result = found ? query_int(&query, 1) : 0;
        answer = query_end_found(&query, found, STORE_EMPTY);
        if (answer == STORE_OK)
            answer = db_run_with(db,
                                 records ? "DELETE FROM jobs WHERE sequence = ?"
                                         : "DELETE FROM requests WHERE job = ?",
                                 sequence);
        if (answer == STORE_OK && !records)
            answer = db_run_with(db,
                                 "UPDATE jobs SET expired = 1, result = NULL,"
                                 " (summary, summary_seal) = (SELECT summary, summary_seal"
                                 " FROM results WHERE number = jobs.result)"
                                 " WHERE sequence = ?",
                                 sequence);
        if (answer == STORE_OK && !records && result)
            answer = sqlite_result_forget(db, result);
        *done += answer == STORE_OK;
    }
    return answer != STORE_OK && answer != STORE_EMPTY ? answer
           : *done > 0                                 ? STORE_OK
                                                       : STORE_EMPTY;
}

/* ------------------------------------------------------------------ remains */

/* Results that were begun by claims that no longer hold. */
static enum store_answer doom(struct sqlite_store *store, struct db *db, void *context) {
    (void)store;
    int64_t *done = ((const struct stepping *)context)->done;
    struct query query =
        db_query(db, "UPDATE results SET state = " SQL_DOOMED " WHERE state <> " SQL_COMPLETE
                     " AND state = " SQL_BUILDING " AND NOT EXISTS"
                     " (SELECT 1 FROM jobs j WHERE j.sequence = results.job"
                     " AND j.token = results.token AND j.status = " SQL_RUNNING ")");
    enum store_answer answer = query_run(&query);
    *done = db_changes(db);
    return answer == STORE_OK && *done == 0 ? STORE_EMPTY : answer;
}

/* A slice of one doomed result; its row goes with the last slice. */
static enum store_answer clear(struct sqlite_store *store, struct db *db, void *context) {
    (void)store;
    (void)context;
    struct query query = db_query(db, "SELECT number FROM results WHERE state <> " SQL_COMPLETE
                                      " AND state = " SQL_DOOMED " LIMIT 1");
    int64_t number = 0;
    enum store_answer answer = query_number(&query, STORE_EMPTY, &number);
    if (answer != STORE_OK)
        return answer;
    query = db_query(
        db, "DELETE FROM chunks WHERE id IN"
            " (SELECT id FROM chunks WHERE id >= ?1 << ?2 AND id < (?1 + 1) << ?2 LIMIT ?3)");
    query_bind(&query, of_int(number), of_int(STORE_CHUNKS_BITS), of_int(CHUNKS_A_STEP));
    answer = query_run(&query);
    if (answer == STORE_OK && db_changes(db) < CHUNKS_A_STEP)
        answer = db_run_with(db, "DELETE FROM results WHERE number = ?", number);
    return answer;
}

/* Gives pages back when more than a quarter of the file is free. */
static enum store_answer shrink(struct sqlite_store *store, struct db *db, void *context) {
    (void)store;
    (void)context;
    struct query query = db_query(db, "SELECT f.freelist_count, p.page_count"
                                      " FROM pragma_freelist_count f, pragma_page_count p");
    bool any = query_row(&query);
    bool worth =
        any && query_int(&query, 0) > FREE_PAGES && query_int(&query, 0) > query_int(&query, 1) / 4;
    enum store_answer answer = query_end(&query);
    if (answer != STORE_OK || !worth)
        return answer != STORE_OK ? answer : STORE_EMPTY;
    query = db_query(db, "PRAGMA incremental_vacuum(256)");
    while (query_row(&query))
        continue;
    return query_end(&query);
}

/* ------------------------------------------------------------------ the sweep */

static bool any(struct db *db, const char *sql, int64_t value) {
    struct query query = db_query(db, sql);
    query_bind(&query, of_int(value));
    return query_find(&query, STORE_EMPTY) == STORE_OK;
}

enum store_answer sqlite_find_due(struct store *base, bool due[STORE_STEP_COUNT], int64_t *time) {
    const struct sqlite_store *store = sqlite_of(base);
    int64_t retention = sqlite_options(store)->retention_us;
    int64_t now = *time = sqlite_now(store);
    struct db *db = sqlite_take_reader(base);
    due[STORE_STEP_EXPIRE] =
        any(db,
            "SELECT 1 FROM jobs WHERE status >= " SQL_FIRST_ENDED " AND expired = 0"
            " AND finished < ? LIMIT 1",
            now - retention);
    due[STORE_STEP_EXPIRE_EXCESS] = over_bytes(store, db);
    due[STORE_STEP_REMOVE] =
        any(db,
            "SELECT 1 FROM jobs WHERE status >= " SQL_FIRST_ENDED " AND expired = 1"
            " AND finished < ? LIMIT 1",
            now - sqlite_options(store)->records_us);
    due[STORE_STEP_DOOM] = any(db,
                               "SELECT 1 FROM results WHERE state <> " SQL_COMPLETE
                               " AND state = " SQL_BUILDING " LIMIT ?",
                               1);
    due[STORE_STEP_CLEAR] = any(db,
                                "SELECT 1 FROM results WHERE state <> " SQL_COMPLETE
                                " AND state = " SQL_DOOMED " LIMIT ?",
                                1);
    due[STORE_STEP_SHRINK] =
        any(db, "SELECT 1 FROM pragma_freelist_count WHERE freelist_count > ?", FREE_PAGES);
    return sqlite_give_reader(base, db, STORE_OK);
}

enum store_answer sqlite_step(struct store *store, enum store_step step, int64_t *done) {
    static const sqlite_operation operations[STORE_STEP_COUNT] = {
        [STORE_STEP_EXPIRE] = retire, [STORE_STEP_EXPIRE_EXCESS] = retire,
        [STORE_STEP_REMOVE] = retire, [STORE_STEP_DOOM] = doom,
        [STORE_STEP_CLEAR] = clear,   [STORE_STEP_SHRINK] = shrink};
    struct stepping stepping = {step, done};
    *done = 0;
    return sqlite_write(store, DB_LAZY, operations[step], &stepping);
}
