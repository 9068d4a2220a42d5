/* SPDX-License-Identifier: MIT */
/*
 * The n-th call of the disk fails, for every n, under a life of the store: what is answered OK has
 * happened, what is answered otherwise is BUSY or DOWN and has not, and when the disk is well again
 * the store is too, in the same process and after a restart.
 */
#include "faulty_vfs.h"
#include "scratch.h"
#include "server/clock.h"
#include "server/store/sqlite/db.h"
#include "tests/check.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { JOBS = 4, RESULT_BYTES = 150000, CALLS_MAX = 4000 };

/* What the store has promised. */
struct promise {
    char id[ID_SIZE];
    enum store_status status;
    bool removed;
};

struct life {
    struct scratch *scratch;
    struct promise promises[JOBS];
    int count, bad;
    bool surface;
};

/* An answer is yes, or it is about the disk. */
static bool good(struct life *life, enum store_answer answer) {
    if (answer != STORE_OK && !store_failed(answer))
        fail_msg("the answer is '%s'", store_answer_name(answer));
    life->bad += answer != STORE_OK;
    return answer == STORE_OK;
}

static void submit(struct life *life, int number) {
    char body[4000];
    char digest[32];
    struct store_receipt receipt;
    memset(body, 'a' + number, sizeof body);
    snprintf(digest, sizeof digest, "digest %d", number);
    struct store_submission submission = {
        .request = body, .request_length = sizeof body, .digest = digest, .key = digest};
    if (!good(life, store_submit(life->scratch->store, &submission, &receipt)))
        return;
    struct promise *promise = &life->promises[life->count++];
    memcpy(promise->id, receipt.id, ID_SIZE);
    promise->status = STORE_QUEUED;
}

static struct promise *promise_of(struct life *life, const char *id) {
    for (int k = 0; k < life->count; k++)
        if (!strcmp(life->promises[k].id, id))
            return &life->promises[k];
    fail_msg("a job that nobody was promised");
    return NULL;
}

/* The claim is `out` already, if its sequence is not 0. */
static bool claim(struct life *life, struct store_claim *out, struct promise **promise) {
    enum store_answer answer = out->sequence ? STORE_OK : store_claim(life->scratch->store, out);
    if (answer == STORE_EMPTY || !good(life, answer))
        return false;
    *promise = promise_of(life, out->id);
    (*promise)->status = STORE_RUNNING;
    return true;
}

static void fill(unsigned char *bytes, const char *id) {
    for (size_t k = 0; k < RESULT_BYTES; k++)
        bytes[k] = (unsigned char)id[k % (ID_SIZE - 1)];
}

/* What is claimed with its end is told in `next`. */
static void finish(struct life *life, struct store_claim *next) {
    static unsigned char bytes[RESULT_BYTES];
    struct store_claim held = {0};
    struct promise *promise;
    if (!claim(life, &held, &promise))
        return;
    (void)good(life, store_renew(life->scratch->store, &held, 0.5));
    fill(bytes, held.id);
    if (good(life, scratch_commit_and_claim(life->scratch, &held, bytes, sizeof bytes, next)))
        promise->status = STORE_SUCCEEDED;
}

static void fail_one(struct life *life, struct store_claim *held) {
    struct promise *promise;
    if (claim(life, held, &promise) &&
        good(life, store_fail(life->scratch->store, held, "{\"status\":422}")))
        promise->status = STORE_FAILED;
}

static void cancel_and_remove(struct life *life) {
    struct store *store = life->scratch->store;
    for (int k = 0; k < life->count; k++) {
        struct promise *promise = &life->promises[k];
        if (promise->status == STORE_QUEUED && good(life, store_cancel(store, promise->id)))
            promise->status = STORE_CANCELLED;
        if (promise->status == STORE_FAILED && good(life, store_delete(store, promise->id)))
            promise->removed = true;
    }
}

static void live(struct life *life) {
    struct store *store = life->scratch->store;
    struct store_sweep sweep;
    struct store_counts counts;
    struct store_claim next = {0};
    bool created;
    char definition[] = "{}", description[] = "{\"area\":1}";
    struct store_item surface = {.id = "surface",
                                 .definition = definition,
                                 .definition_length = 2,
                                 .description = description};
    for (int k = 0; k < JOBS; k++)
        submit(life, k);
    finish(life, &next);
    if (good(life, store_item_put(store, STORE_SURFACES, &surface, &created)))
        life->surface = true;
    fail_one(life, &next);
    (void)good(life, store_sweep(store, &sweep));
    cancel_and_remove(life);
    (void)good(life, store_counts(store, &counts));
    (void)good(life, store_sweep(store, &sweep));
}

static void expect_job(struct life *life, const struct promise *promise, bool restarted) {
    static unsigned char bytes[RESULT_BYTES];
    struct store_job job;
    enum store_answer answer = store_get(life->scratch->store, promise->id, &job);
    assert_int_equal(answer, promise->removed ? STORE_EMPTY : STORE_OK);
    store_job_clear(&job);
    if (promise->removed)
        return;
    /* The first sweep after a restart takes up what was interrupted. */
    bool again = restarted && promise->status == STORE_RUNNING;
    assert_int_equal(job.status, again ? STORE_QUEUED : promise->status);
    if (job.status != STORE_SUCCEEDED)
        return;
    fill(bytes, promise->id);
    scratch_expect_result(life->scratch, promise->id, bytes, sizeof bytes, 60000);
}

/* Everything that was promised and nothing else. */
static void expect_promises(struct life *life, bool restarted) {
    struct store_counts counts;
    struct store_item surface;
    int64_t expected = 0, found = 0;
    assert_int_equal(store_ping(life->scratch->store), STORE_OK);
    for (int k = 0; k < life->count; k++) {
        expect_job(life, &life->promises[k], restarted);
        expected += !life->promises[k].removed;
    }
    assert_int_equal(store_counts(life->scratch->store, &counts), STORE_OK);
    for (int k = 0; k < STORE_STATUS_COUNT; k++)
        found += counts.jobs[k];
    assert_int_equal(found, expected);
    enum store_answer answer =
        store_item_get(life->scratch->store, STORE_SURFACES, NULL, "surface", &surface);
    store_item_clear(&surface);
    assert_int_equal(answer, life->surface ? STORE_OK : STORE_EMPTY);
}

/* One life with the n-th call failing; how many failed. */
static long live_with(enum faulty_kind kind, long n, bool lasting, int *bad) {
    struct scratch scratch;
    struct life life = {.scratch = &scratch};
    char id[ID_SIZE];
    scratch_open(&scratch);
    faulty_set(kind, n, lasting);
    live(&life);
    long failures = faulty_failures();
    faulty_set(kind, 0, false);
    expect_promises(&life, false);
    scratch_stop(&scratch);
    scratch_start(&scratch);
    (void)scratch_sweep(&scratch);
    expect_promises(&life, true);
    scratch_submit(&scratch, "afterwards", id);
    scratch_remove(&scratch);
    *bad += life.bad;
    return failures;
}

/* In short runs every third call, from another one on for each of the ways. */
static void live_with_each(enum faulty_kind kind, bool lasting, int first) {
    int bad = 0, step = check_stride(3);
    long n = step == 1 ? 1 : first;
    while (n < CALLS_MAX && live_with(kind, n, lasting, &bad) > 0)
        n += step;
    print_message("%ld places to fail, %d answers that were not ok\n", n - 1, bad);
    assert_true(n > 10 && n < CALLS_MAX && bad > 0);
}

static void test_store_tells_the_truth_on_an_io_error(void **state) {
    (void)state;
    live_with_each(FAULTY_IO_ERROR, false, 1);
}

static void test_store_tells_the_truth_on_lasting_io_errors(void **state) {
    (void)state;
    live_with_each(FAULTY_IO_ERROR, true, 2);
}

static void test_store_tells_the_truth_when_a_write_finds_no_space(void **state) {
    (void)state;
    live_with_each(FAULTY_DISK_FULL, false, 3);
}

static void test_store_tells_the_truth_on_a_full_disk(void **state) {
    (void)state;
    live_with_each(FAULTY_DISK_FULL, true, 1);
}

/* A store with a job in it opens as it is, or says why not; the next time it opens. */
static void test_store_open_survives_every_io_error(void **state) {
    struct scratch scratch;
    char id[ID_SIZE];
    int refused = 0;
    long n = 0;
    (void)state;
    scratch_open(&scratch);
    scratch_submit(&scratch, "kept", id);
    scratch_stop(&scratch);
    for (bool hit = true; hit && n < CALLS_MAX;) {
        char why[STORE_WHY_SIZE] = "";
        scratch.events = job_events_new();
        faulty_set(FAULTY_IO_ERROR, ++n, false);
        scratch.store = store_open(scratch.path, &scratch.options, scratch.events, why);
        hit = faulty_failures() > 0;
        faulty_set(FAULTY_IO_ERROR, 0, false);
        refused += !scratch.store;
        assert_true(scratch.store || strlen(why) > 10);
        scratch_stop(&scratch);
        scratch_start(&scratch);
        assert_int_equal(scratch_status(&scratch, id), STORE_QUEUED);
        scratch_stop(&scratch);
    }
    print_message("%ld places to fail, %d refusals to open\n", n - 1, refused);
    assert_true(refused > 3 && n < CALLS_MAX);
    scratch_start(&scratch);
    scratch_remove(&scratch);
}

/* Who waited in vain for the lock of another process does so once: then writes fail at once, until
 * the lock is free. */
static void test_store_waits_for_a_lock_once(void **state) {
    enum { BUSY_MS = 1000, TRIES = 3 };
    struct scratch scratch;
    struct store_receipt receipt;
    const struct store_submission submission = {
        .request = "r", .request_length = 1, .digest = "digest"};
    int64_t took[TRIES];
    char id[ID_SIZE], why[STORE_WHY_SIZE] = "";
    (void)state;
    scratch_make(&scratch);
    scratch.options.busy_ms = BUSY_MS;
    scratch_start(&scratch);
    scratch_submit(&scratch, "first", id);
    struct db *other = db_open(scratch.path, BUSY_MS, why);
    assert_non_null(other);
    assert_int_equal(db_script(other, "BEGIN IMMEDIATE"), STORE_OK);
    for (int k = 0; k < TRIES; k++) {
        took[k] = -clock_ms();
        assert_int_equal(store_submit(scratch.store, &submission, &receipt), STORE_BUSY);
        took[k] += clock_ms();
    }
    assert_int_equal(db_script(other, "ROLLBACK"), STORE_OK);
    db_close(other);
    scratch_submit(&scratch, "second", id);
    check_at_least(took[0], BUSY_MS * 0.8);
    check_at_most(took[1], BUSY_MS / 2);
    check_at_most(took[2], BUSY_MS / 2);
    scratch_remove(&scratch);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_store_tells_the_truth_on_an_io_error),
        cmocka_unit_test(test_store_tells_the_truth_on_lasting_io_errors),
        cmocka_unit_test(test_store_tells_the_truth_when_a_write_finds_no_space),
        cmocka_unit_test(test_store_tells_the_truth_on_a_full_disk),
        cmocka_unit_test(test_store_open_survives_every_io_error),
        cmocka_unit_test(test_store_waits_for_a_lock_once),
    };
    faulty_install();
    return cmocka_run_group_tests_name("store faults", tests, NULL, NULL);
}
