/* SPDX-License-Identifier: MIT */
/*
 * Several processes at one store, here as several stores with several threads each: whatever they
 * do at the same moment, each job is handed out once, ends once, and nothing is lost or left over.
 * Also what each owner gets, and databases that the first version made.
 */
#include "scratch.h"
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { STORES = 2, THREADS = 4, WORKERS = STORES * THREADS };

static const int64_t second = 1000000;

/* Two openings of the same database. */
struct shared {
    struct scratch scratch[STORES];
    uint64_t random;
};

static int set_up(void **state) {
    struct shared *shared = calloc(1, sizeof *shared);
    shared->random = check_seed(1);
    scratch_make(&shared->scratch[0]);
    shared->scratch[0].options.shared = true;
    shared->scratch[0].options.busy_ms = 30000; /* SQLite's writers wait in turn */
    shared->scratch[1] = shared->scratch[0];
    scratch_start(&shared->scratch[0]);
    scratch_start(&shared->scratch[1]);
    *state = shared;
    return 0;
}

static int tear_down(void **state) {
    struct shared *shared = *state;
    scratch_stop(&shared->scratch[1]);
    scratch_remove(&shared->scratch[0]);
    free(shared);
    return 0;
}

/* ------------------------------------------------------------------ threads */

struct worker {
    struct scratch *scratch;
    int number;
    atomic_int *wrong; /* answers that must not be */
    atomic_int *done;
    const char *id;
    uint64_t seed;
    void *(*act)(void *context);
    pthread_t thread;
};

/* Runs `act` in WORKERS threads, half of them at each store, and returns the sum of `done`. */
static int run_all(struct shared *shared, void *(*act)(void *context), const char *id) {
    struct worker workers[WORKERS];
    atomic_int wrong = 0, done = 0;
    for (int k = 0; k < WORKERS; k++) {
        workers[k] = (struct worker){.scratch = &shared->scratch[k % STORES],
                                     .number = k,
                                     .wrong = &wrong,
                                     .done = &done,
                                     .id = id,
                                     .seed = scratch_random(&shared->random),
                                     .act = act};
        assert_int_equal(pthread_create(&workers[k].thread, NULL, act, &workers[k]), 0);
    }
    for (int k = 0; k < WORKERS; k++)
        pthread_join(workers[k].thread, NULL);
    assert_int_equal(wrong, 0);
    return done;
}

static int64_t count_of(struct scratch *scratch, enum store_status status) {
    struct store_counts counts;
    assert_int_equal(store_counts(scratch->store, &counts), STORE_OK);
    return counts.jobs[status];
}

static enum store_answer commit(struct scratch *scratch, const struct store_claim *claim) {
    return scratch_commit(scratch, claim, claim->id, ID_SIZE);
}

static void *claim_and_commit(void *context) {
    struct worker *worker = context;
    struct store_claim claim;
    enum store_answer answer;
    while ((answer = store_claim(worker->scratch->store, &claim)) == STORE_OK) {
        *worker->wrong += claim.attempts != 1 || commit(worker->scratch, &claim) != STORE_OK;
        ++*worker->done;
    }
    *worker->wrong += answer != STORE_EMPTY;
    return NULL;
}

static void test_store_concurrent_claims_hand_out_each_job_once(void **state) {
    struct shared *shared = *state;
    enum { JOBS = 300 };
    char ids[JOBS][ID_SIZE];
    for (int k = 0; k < JOBS; k++) {
        char body[32];
        snprintf(body, sizeof body, "job %d", k);
        scratch_submit(&shared->scratch[k % STORES], body, ids[k]);
    }
    int claimed = run_all(shared, claim_and_commit, NULL);
    /* A claim may miss the only job left because another is just taking or giving it. */
    assert_int_equal(claimed, JOBS);
    assert_int_equal(count_of(&shared->scratch[0], STORE_SUCCEEDED), JOBS);
    for (int k = 0; k < JOBS; k++)
        scratch_expect_result(&shared->scratch[k % STORES], ids[k], ids[k], ID_SIZE, ID_SIZE);
}

static void *submit_with_one_key(void *context) {
    struct worker *worker = context;
    struct store_receipt receipt;
    struct store_submission submission = {
        .request = "body", .request_length = 4, .digest = "d", .owner = "anna", .key = worker->id};
    *worker->wrong += store_submit(worker->scratch->store, &submission, &receipt) != STORE_OK;
    *worker->done += !receipt.existing;
    submission.request = "other";
    submission.request_length = 5;
    *worker->wrong += store_submit(worker->scratch->store, &submission, &receipt) != STORE_CONFLICT;
    return NULL;
}

static void test_store_concurrent_submissions_of_a_key_make_one_job(void **state) {
    struct shared *shared = *state;
    for (int k = 1; k <= 20; k++) {
        char key[32];
        snprintf(key, sizeof key, "key %d", k);
        assert_int_equal(run_all(shared, submit_with_one_key, key), 1);
        assert_int_equal(count_of(&shared->scratch[1], STORE_QUEUED), k);
    }
}

/* ------------------------------------------------------------------ races for one job */

static struct store_claim contested; /* the claim that all threads know */
static atomic_int commits, cancels, failures, requeues;

static void *end_somehow(void *context) {
    struct worker *worker = context;
    struct store *store = worker->scratch->store;
    struct store_sweep sweep;
    uint64_t seed = worker->seed;
    scratch_sleep((int)(scratch_random(&seed) % 6));
    switch (worker->number / STORES) {
    case 0:
        commits += commit(worker->scratch, &contested) == STORE_OK;
        break;
    case 1:
        cancels += store_cancel(store, contested.id) == STORE_OK;
        break;
    case 2:
        failures += store_fail(store, &contested, "{}") == STORE_OK;
        break;
    default:
        *worker->wrong += store_sweep(store, &sweep) != STORE_OK;
        requeues += sweep.requeued;
    }
    return NULL;
}

/* Its lease is over, so that a sweep takes it, but its holder does not know that yet. */
static void test_store_job_ends_once_whoever_is_first(void **state) {
    struct shared *shared = *state;
    int won[4] = {0};
    for (int k = 0; k < 100; k++) {
        char body[32];
        snprintf(body, sizeof body, "race %d", k);
        contested = scratch_claimed(&shared->scratch[0], body);
        commits = cancels = failures = requeues = 0;
        scratch_now += 61 * second;
        run_all(shared, end_somehow, NULL);
        enum store_status status = scratch_status(&shared->scratch[1], contested.id);
        /* What was back in the queue may have been cancelled there. */
        assert_int_equal(commits + failures + (requeues || cancels), 1);
        assert_true(cancels <= 1 && requeues <= 1);
        assert_int_equal(status, commits    ? STORE_SUCCEEDED
                                 : failures ? STORE_FAILED
                                 : cancels  ? STORE_CANCELLED
                                            : STORE_QUEUED);
        assert_int_equal(commit(&shared->scratch[0], &contested), STORE_CONFLICT);
        won[0] += commits, won[1] += failures, won[2] += cancels, won[3] += requeues;
        if (status == STORE_QUEUED)
            assert_int_equal(store_delete(shared->scratch[0].store, contested.id), STORE_OK);
    }
    print_message("%d committed, %d failed, %d cancelled, %d returned\n", won[0], won[1], won[2],
                  won[3]);
}

/* ------------------------------------------------------------------ races for results, surfaces */

static void *submit_and_delete(void *context) {
    struct worker *worker = context;
    struct store *store = worker->scratch->store;
    struct store_submission submission = {.request = "same", .request_length = 4, .digest = "same"};
    for (int k = 0; k < 40; k++) {
        struct store_receipt receipt;
        struct store_result result;
        struct store_claim claim;
        char byte;
        *worker->wrong += store_submit(store, &submission, &receipt) != STORE_OK;
        while (store_claim(store, &claim) == STORE_OK) {
            enum store_answer answer = claim.reused ? STORE_OK : commit(worker->scratch, &claim);
            *worker->wrong += answer != STORE_OK && answer != STORE_CONFLICT; /* deleted */
        }
        /* Whoever has a job that has succeeded can read its result, whoever deletes his. */
        if (store_result_find(store, receipt.id, &result) == STORE_OK)
            *worker->wrong += store_result_read(store, &result, 0, &byte, 1) != STORE_OK;
        else
            *worker->wrong += scratch_status(worker->scratch, receipt.id) == STORE_SUCCEEDED &&
                              store_result_find(store, receipt.id, &result) != STORE_OK;
        struct store_sweep sweep;
        *worker->wrong += store_delete(store, receipt.id) != STORE_OK;
        *worker->wrong += store_sweep(store, &sweep) != STORE_OK;
        ++*worker->done;
    }
    return NULL;
}

static void test_store_shared_result_stays_while_somebody_needs_it(void **state) {
    struct shared *shared = *state;
    assert_int_equal(run_all(shared, submit_and_delete, NULL), 40 * WORKERS);
    for (int k = 0; k < 3; k++)
        (void)scratch_sweep(&shared->scratch[0]);
    assert_int_equal(scratch_number(&shared->scratch[0], "SELECT count(*) FROM draped.jobs"), 0);
    assert_int_equal(scratch_number(&shared->scratch[0], "SELECT count(*) FROM draped.results"), 0);
    assert_int_equal(scratch_number(&shared->scratch[0], "SELECT count(*) FROM draped.chunks"), 0);
    for (int status = 0; status < STORE_STATUS_COUNT; status++)
        assert_int_equal(count_of(&shared->scratch[1], (enum store_status)status), 0);
}

/* All stand in the way of all: where a machine is slow, one may wait too long for its turn. */
static bool is_wrong(enum store_answer answer) {
    return answer != STORE_OK && answer != STORE_DOWN;
}

static void *use_or_delete_surface(void *context) {
    static char text[] = "{}";
    struct worker *worker = context;
    struct store *store = worker->scratch->store;
    struct store_item surface = {
        .id = "s", .definition = text, .definition_length = 2, .description = text};
    struct store_submission submission = {.request = "x", .request_length = 1, .surface = "s"};
    for (int k = 0; k < 40; k++) {
        char digest[32];
        bool created = false;
        struct store_receipt receipt;
        struct store_item found;
        snprintf(digest, sizeof digest, "%d of %d", k, worker->number);
        submission.digest = digest;
        *worker->wrong += is_wrong(store_item_put(store, STORE_SURFACES, &surface, &created));
        enum store_answer answer = worker->number < WORKERS / 2
                                       ? store_item_delete(store, STORE_SURFACES, NULL, "s")
                                       : store_submit(store, &submission, &receipt);
        if (worker->number < WORKERS / 2 || answer != STORE_OK)
            continue;
        *worker->wrong += is_wrong(store_item_get(store, STORE_SURFACES, NULL, "s", &found));
        store_item_clear(&found);
        *worker->wrong += is_wrong(store_delete(store, receipt.id));
        ++*worker->done;
    }
    return NULL;
}

static void test_store_surface_is_not_deleted_under_a_job(void **state) {
    struct shared *shared = *state;
    int used = run_all(shared, use_or_delete_surface, NULL);
    print_message("%d used it\n", used);
    assert_true(used > 0);
}

/* ------------------------------------------------------------------ several at the start */

static void *open_and_close(void *context) {
    struct worker *worker = context;
    char why[STORE_WHY_SIZE];
    struct job_events *events = job_events_new();
    struct store *store = store_open(worker->scratch->path, &worker->scratch->options, events, why);
    *worker->wrong += !store || store_ping(store) != STORE_OK;
    *worker->done += store != NULL;
    store_close(store);
    job_events_free(events);
    return NULL;
}

static void test_store_several_may_start_at_once(void **state) {
    struct shared *shared = *state;
    scratch_stop(&shared->scratch[1]);
    scratch_stop(&shared->scratch[0]);
    scratch_forget(&shared->scratch[0]);
    assert_int_equal(run_all(shared, open_and_close, NULL), WORKERS);
    scratch_start(&shared->scratch[0]);
    scratch_start(&shared->scratch[1]);
    assert_int_equal(
        scratch_number(&shared->scratch[0], "SELECT count(*) FROM draped.schema_version"), 1);
}

/* ------------------------------------------------------------------ shares */

static void submit_as(struct scratch *scratch, const char *owner, const char *body, int priority) {
    struct store_receipt receipt;
    struct store_submission submission = {.request = body,
                                          .request_length = strlen(body),
                                          .digest = body,
                                          .owner = owner,
                                          .priority = priority};
    scratch_now += 1000;
    assert_int_equal(store_submit(scratch->store, &submission, &receipt), STORE_OK);
}

static struct store_claim expect_next(struct scratch *scratch, const char *body) {
    struct store_claim claim;
    char *request = NULL;
    size_t length = 0;
    assert_int_equal(store_claim(scratch->store, &claim), STORE_OK);
    assert_int_equal(store_request(scratch->store, claim.id, &request, &length), STORE_OK);
    assert_string_equal(request, body);
    free(request);
    return claim;
}

static void test_store_owners_take_turns(void **state) {
    struct shared *shared = *state;
    struct scratch *scratch = shared->scratch;
    static const char *const annas[] = {"a1", "a2", "a3", "a4", "a5"};
    for (size_t k = 0; k < 5; k++)
        submit_as(scratch, "anna", annas[k], 0);
    submit_as(scratch, "bert", "b1", 0);
    submit_as(scratch, "bert", "b2", 0);
    submit_as(scratch, "bert", "b3 is urgent", 1);
    submit_as(scratch, "", "nobody's", 0);
    expect_next(scratch, "b3 is urgent"); /* none has had a turn: priority and age decide */
    expect_next(scratch, "a1");
    expect_next(scratch, "nobody's"); /* the only one of whom nothing runs */
    struct store_claim b1 =
        expect_next(scratch, "b1"); /* of both one runs: his turn is longer ago */
    struct store_claim a2 = expect_next(scratch, "a2");
    assert_int_equal(store_fail(scratch->store, &b1, "{}"), STORE_OK);
    expect_next(scratch, "b2"); /* one of his runs, two of hers */
    assert_int_equal(store_release(scratch->store, &a2), STORE_OK);
    expect_next(scratch, "a2");
    expect_next(scratch, "a3");
    expect_next(scratch, "a4");
    expect_next(scratch, "a5");
}

/* Also where there is only one worker, so that nothing runs when a job is claimed. Who comes later
 * joins at the end of the round. */
static void test_store_one_worker_serves_owners_in_turn(void **state) {
    struct shared *shared = *state;
    struct scratch *scratch = shared->scratch;
    static const char *const bodies[] = {"a1", "a2", "a3", "a4", "b1", "b2", "b3"};
    static const char *const turns[] = {"a1", "b1", "a2", "b2", "a3", "b3", "c1", "a4"};
    for (size_t k = 0; k < 7; k++)
        submit_as(scratch, bodies[k][0] == 'a' ? "anna" : "bert", bodies[k], 0);
    for (size_t k = 0; k < 8; k++) {
        if (k == 4)
            submit_as(scratch, "carl", "c1", 0);
        struct store_claim claim = expect_next(scratch, turns[k]);
        assert_int_equal(store_fail(scratch->store, &claim, "{}"), STORE_OK);
    }
}

static void test_store_owner_runs_no_more_than_allowed(void **state) {
    struct shared *shared = *state;
    struct scratch *scratch = shared->scratch;
    struct store_claim claim;
    scratch_stop(scratch);
    scratch->options.owner_running = 2;
    scratch_start(scratch);
    for (size_t k = 0; k < 4; k++)
        submit_as(scratch, "anna", (const char *[]){"a1", "a2", "a3", "a4"}[k], 0);
    expect_next(scratch, "a1");
    struct store_claim a2 = expect_next(scratch, "a2");
    assert_int_equal(store_claim(scratch->store, &claim), STORE_EMPTY);
    submit_as(scratch, "bert", "b1", 0);
    expect_next(scratch, "b1");
    assert_int_equal(store_claim(scratch->store, &claim), STORE_EMPTY);
    assert_int_equal(store_fail(scratch->store, &a2, "{}"), STORE_OK);
    expect_next(scratch, "a3");
    assert_int_equal(store_claim(scratch->store, &claim), STORE_EMPTY);
}

static void test_store_priority_does_not_buy_the_share_of_another(void **state) {
    struct shared *shared = *state;
    struct scratch *scratch = shared->scratch;
    submit_as(scratch, "anna", "a1", 1000);
    submit_as(scratch, "anna", "a2", 1000);
    submit_as(scratch, "bert", "b1", -1000);
    expect_next(scratch, "a1");
    expect_next(scratch, "b1");
    expect_next(scratch, "a2");
}

/* ------------------------------------------------------------------ databases of other versions */

static void expect_refused(const struct scratch *scratch, const char *why_wanted) {
    char why[STORE_WHY_SIZE] = "";
    struct job_events *events = job_events_new();
    assert_null(store_open(scratch->path, &scratch->options, events, why));
    if (!strstr(why, why_wanted))
        fail_msg("'%s' does not say '%s'", why, why_wanted);
    job_events_free(events);
}

/* And left as they are. */
static void test_store_tables_of_another_version_are_refused(void **state) {
    struct shared *shared = *state;
    struct scratch *scratch = shared->scratch;
    scratch_stop(&shared->scratch[1]);
    scratch_stop(scratch);
    scratch_script(scratch, scratch->remote ? "UPDATE draped.schema_version SET version = 1000"
                                            : "UPDATE schema_version SET version = 1000");
    expect_refused(scratch, "has schema 1000, and this version of draped uses 13: use a newer one");
    scratch_forget(scratch);
    scratch_script(scratch,
                   scratch->remote
                       ? "CREATE SCHEMA draped;"
                         "CREATE TABLE draped.schema_version (version integer PRIMARY KEY);"
                         "INSERT INTO draped.schema_version VALUES (8);"
                         "CREATE TABLE draped.jobs (id text); INSERT INTO draped.jobs VALUES ('a')"
                       : "PRAGMA application_id = 0x64726170;"
                         "CREATE TABLE schema_version (version INTEGER NOT NULL);"
                         "INSERT INTO schema_version VALUES (8);"
                         "CREATE TABLE jobs (id TEXT); INSERT INTO jobs VALUES ('a')");
    expect_refused(scratch, "use the older version that made it");
    assert_int_equal(scratch_number(scratch,
                                    "SELECT count(*) FROM draped.jobs j, draped.schema_version v"
                                    " WHERE j.id = 'a' AND v.version = 8"),
                     1);
    assert_int_equal(scratch_number(scratch, scratch->remote
                                                 ? "SELECT count(*) FROM pg_class WHERE"
                                                   " relnamespace = 'draped'::regnamespace"
                                                   " AND relkind = 'r'"
                                                 : "SELECT count(*) FROM sqlite_schema"),
                     2);
    scratch_forget(scratch);
    scratch_start(scratch);
    scratch_start(&shared->scratch[1]);
}

#define WITH_STORES(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

int main(void) {
    const struct CMUnitTest tests[] = {
        WITH_STORES(test_store_concurrent_claims_hand_out_each_job_once),
        WITH_STORES(test_store_concurrent_submissions_of_a_key_make_one_job),
        WITH_STORES(test_store_job_ends_once_whoever_is_first),
        WITH_STORES(test_store_shared_result_stays_while_somebody_needs_it),
        WITH_STORES(test_store_surface_is_not_deleted_under_a_job),
        WITH_STORES(test_store_several_may_start_at_once),
        WITH_STORES(test_store_owners_take_turns),
        WITH_STORES(test_store_one_worker_serves_owners_in_turn),
        WITH_STORES(test_store_owner_runs_no_more_than_allowed),
        WITH_STORES(test_store_priority_does_not_buy_the_share_of_another),
        WITH_STORES(test_store_tables_of_another_version_are_refused),
    };
    return scratch_run("store shared", tests, NULL, 0);
}
