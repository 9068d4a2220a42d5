/* SPDX-License-Identifier: MIT */
/*
 * However many jobs have ended, each operation costs the same: counted in the steps of SQLite's
 * machine, so that a statement that reads what it need not is found whatever the computer does
 * besides.
 */
#include "scratch.h"
#include <sqlite3.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { FEW = 50, MANY = 3000, OPERATIONS_MAX = 64 };

/* ------------------------------------------------------------------ counting */

static _Atomic int64_t steps;

static int statement_ended(unsigned event, void *context, void *statement, void *time) {
    (void)event;
    (void)context;
    (void)time;
    atomic_fetch_add(&steps, sqlite3_stmt_status(statement, SQLITE_STMTSTATUS_VM_STEP, 1));
    return 0;
}

static int connection_opened(sqlite3 *db) {
    return sqlite3_trace_v2(db, SQLITE_TRACE_PROFILE, statement_ended, NULL);
}

struct counted {
    const char *operation[OPERATIONS_MAX];
    int64_t steps[OPERATIONS_MAX];
    int count;
};

static void note(struct counted *counted, const char *operation, enum store_answer answer) {
    assert_int_equal(answer, STORE_OK);
    assert_true(counted->count < OPERATIONS_MAX);
    counted->operation[counted->count] = operation;
    counted->steps[counted->count++] = atomic_exchange(&steps, 0);
}

/* Of an operation that finds nothing: what an idle daemon does all day. */
static void note_empty(struct counted *counted, const char *operation, enum store_answer answer) {
    assert_int_equal(answer, STORE_EMPTY);
    note(counted, operation, STORE_OK);
}

/* ------------------------------------------------------------------ the operations */

static enum store_answer submit(struct store *store, const char *digest, const char *key) {
    struct store_receipt receipt;
    struct store_submission submission = {
        .request = "r", .request_length = 1, .digest = digest, .key = key};
    return store_submit(store, &submission, &receipt);
}

static void list(struct scratch *scratch, struct counted *counted, const char *operation,
                 struct store_filter filter) {
    struct store_page page = {0};
    filter.limit = 20;
    note(counted, operation, store_list(scratch->store, &filter, &page));
    assert_int_equal(page.count, 20);
    store_page_clear(&page);
}

static void find_nothing(struct store *store, struct counted *counted) {
    struct store_claim claim;
    struct store_job job;
    char *request = NULL;
    size_t length = 0;
    note_empty(counted, "claim of nothing", store_claim(store, &claim));
    note_empty(counted, "fresh claim of nothing", store_claim_fresh(store, &claim));
    note_empty(counted, "starving", store_starving(store, false));
    note_empty(counted, "starving with something fresh", store_starving(store, true));
    note_empty(counted, "get of nothing", store_get(store, "x", &job));
    note_empty(counted, "request of nothing", store_request(store, "x", &request, &length));
}

static void list_none(struct store *store, struct counted *counted, const char *operation,
                      struct store_filter filter) {
    struct store_page page = {0};
    filter.limit = 20;
    note(counted, operation, store_list(store, &filter, &page));
    assert_int_equal(page.count, 0);
    store_page_clear(&page);
}

/* A sweep while a result too large for one piece is being written. */
static void sweep_beside_writer(struct scratch *scratch, const char *digest,
                                struct counted *counted) {
    static const char bytes[3 << 20];
    struct store *store = scratch->store;
    struct store_claim claim;
    struct store_sweep sweep;
    note(counted, "submit a large one", submit(store, digest, NULL));
    note(counted, "claim a large one", store_claim(store, &claim));
    struct store_writer *writer = store_writer_new(store, &claim);
    assert_non_null(writer);
    note(counted, "append", store_writer_append(writer, bytes, sizeof bytes));
    note(counted, "sweep beside a writer", store_sweep(store, &sweep));
    note(counted, "commit a large one", store_writer_commit(writer, "{}"));
    store_writer_free(writer);
}

/* Jobs go through their life; the digests say which round it is. */
static void live(struct scratch *scratch, const char *round, struct counted *counted) {
    struct store *store = scratch->store;
    struct store_claim claim;
    struct store_job job;
    struct store_counts counts;
    struct store_usage usage;
    struct store_sweep sweep;
    char digest[5][32];
    for (int k = 0; k < 5; k++)
        snprintf(digest[k], sizeof digest[k], "%s %d", round, k);
    atomic_store(&steps, 0);
    note(counted, "submit", submit(store, digest[0], digest[0]));
    note(counted, "claim", store_claim(store, &claim));
    note(counted, "renew", store_renew(store, &claim, 0.5));
    note(counted, "check", store_check(store, &claim));
    note(counted, "release", store_release(store, &claim));
    note(counted, "claim again", store_claim(store, &claim));
    note(counted, "commit", scratch_commit(scratch, &claim, "abc", 3));
    note(counted, "get", store_get(store, claim.id, &job));
    store_job_clear(&job);
    note(counted, "submit the same", submit(store, digest[0], digest[1]));
    note(counted, "delete", store_delete(store, claim.id));
    note(counted, "submit another", submit(store, digest[2], NULL));
    note(counted, "claim another", store_claim(store, &claim));
    note(counted, "crash", store_crashed(store, &claim, "signal 11"));
    note(counted, "claim after a crash", store_claim(store, &claim));
    note(counted, "fail", store_fail(store, &claim, "{}"));
    note(counted, "submit a third", submit(store, digest[3], NULL));
    note(counted, "claim a third", store_claim(store, &claim));
    note(counted, "cancel", store_cancel(store, claim.id));
    sweep_beside_writer(scratch, digest[4], counted);
    note(counted, "counts", store_counts(store, &counts));
    list(scratch, counted, "list", (struct store_filter){0});
    list(scratch, counted, "list of an owner", (struct store_filter){.owner = ""});
    list(scratch, counted, "list by status",
         (struct store_filter){.has_status = true, .status = STORE_SUCCEEDED});
    list_none(store, counted, "list of the queue",
              (struct store_filter){.has_status = true, .status = STORE_QUEUED});
    list_none(store, counted, "list of the studies", (struct store_filter){.kind = STORE_STUDY});
    list_none(store, counted, "list of a stranger", (struct store_filter){.owner = "stranger"});
    find_nothing(store, counted);
    note(counted, "usage", store_usage(store, "", &usage));
    note(counted, "beat", store_beat(store));
    note(counted, "sweep", store_sweep(store, &sweep));
}

/* ------------------------------------------------------------------ beside others */

/* Jobs that have ended, with their results, all of the owner who goes on. */
static void add_ended(struct scratch *scratch, int from, int to) {
    char sql[2048];
    snprintf(sql, sizeof sql,
             "BEGIN;"
             "INSERT INTO results (digest, state, job, token, length, summary)"
             " WITH RECURSIVE n (k) AS (SELECT %d UNION ALL SELECT k + 1 FROM n WHERE k < %d)"
             " SELECT 'ended ' || k, 1, 0, 0, 1, '{}' FROM n;"
             "INSERT INTO jobs (id, status, rank, priority, owner, digest, created, started,"
             " finished, progress, attempts, token, result)"
             " SELECT lower(hex(randomblob(16))), 2, 1, 0, '', digest, 1, 1, %lld, 1, 1, 1, number"
             " FROM results WHERE job = 0;"
             "UPDATE results SET job = 1 WHERE job = 0;"
             "COMMIT",
             from, to - 1, (long long)scratch_now);
    scratch_script(scratch, sql);
}

static void test_store_steps_do_not_grow_with_what_has_ended(void **state) {
    (void)state;
    struct scratch scratch;
    struct counted few = {.count = 0}, many = {.count = 0};
    scratch_open(&scratch);
    add_ended(&scratch, 0, FEW);
    live(&scratch, "few", &few);
    add_ended(&scratch, FEW, MANY);
    live(&scratch, "many", &many);
    assert_int_equal(few.count, many.count);
    for (int k = 0; k < few.count; k++) {
        if (many.steps[k] > few.steps[k] + 100)
            fail_msg("'%s' takes %lld steps beside %d ended jobs, %lld beside %d", few.operation[k],
                     (long long)few.steps[k], FEW, (long long)many.steps[k], MANY);
        assert_true(few.steps[k] > 0);
    }
    scratch_remove(&scratch);
}

/* One job each of owners who wait, all with the same turn. */
static void add_owners(struct scratch *scratch, int from, int to) {
    char sql[1024];
    snprintf(sql, sizeof sql,
             "INSERT INTO jobs (id, status, rank, priority, owner, digest, created)"
             " WITH RECURSIVE n (k) AS (SELECT %d UNION ALL SELECT k + 1 FROM n WHERE k < %d)"
             " SELECT lower(hex(randomblob(16))), 0, k, 0, 'owner ' || k, 'd' || k, 1 FROM n",
             from, to - 1);
    scratch_script(scratch, sql);
}

static int64_t steps_of_a_claim(struct scratch *scratch) {
    struct store_claim claim;
    atomic_store(&steps, 0);
    assert_int_equal(store_claim(scratch->store, &claim), STORE_OK);
    return atomic_exchange(&steps, 0);
}

static void test_store_steps_of_a_claim_do_not_grow_with_the_owners(void **state) {
    (void)state;
    struct scratch scratch;
    scratch_open(&scratch);
    add_owners(&scratch, 0, 100);
    int64_t few = steps_of_a_claim(&scratch);
    add_owners(&scratch, 100, MANY);
    int64_t many = steps_of_a_claim(&scratch);
    if (many > few + 100)
        fail_msg("a claim takes %lld steps beside 100 owners, %lld beside %d", (long long)few,
                 (long long)many, MANY);
    scratch_remove(&scratch);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_store_steps_do_not_grow_with_what_has_ended),
        cmocka_unit_test(test_store_steps_of_a_claim_do_not_grow_with_the_owners),
    };
    sqlite3_auto_extension((void (*)(void))connection_opened);
    return cmocka_run_group_tests_name("store steps", tests, NULL, NULL);
}
