/* SPDX-License-Identifier: MIT */
/* Jobs that have jobs: studies with their rounds of tasks, laminates with their drapes. */
#include "scratch.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { TASK_BYTES = 16 };
static const int64_t second = 1000000;

/* ------------------------------------------------------------------ words of these tests */

static void submit_as(struct scratch *scratch, enum store_kind kind, const char *owner,
                      const char *body, char id[ID_SIZE]) {
    struct store_receipt receipt;
    struct store_submission submission = {.kind = kind,
                                          .total = 10,
                                          .request = body,
                                          .request_length = strlen(body),
                                          .digest = body,
                                          .owner = owner};
    assert_int_equal(store_submit(scratch->store, &submission, &receipt), STORE_OK);
    assert_int_equal(receipt.status, STORE_QUEUED);
    memcpy(id, receipt.id, ID_SIZE);
}

static struct store_claim claim_next(struct scratch *scratch) {
    struct store_claim claim;
    assert_int_equal(store_claim(scratch->store, &claim), STORE_OK);
    return claim;
}

static void expect_nothing_to_claim(struct scratch *scratch) {
    struct store_claim claim;
    assert_int_equal(store_claim(scratch->store, &claim), STORE_EMPTY);
}

/* Task k is the text `NAME k`, of k + 1 variants. */
static enum store_answer begin(struct scratch *scratch, const struct store_claim *claim,
                               const char *name, size_t count) {
    char *tasks = calloc(count, TASK_BYTES);
    int64_t *variants = calloc(count, sizeof *variants);
    assert_non_null(tasks);
    assert_non_null(variants);
    for (size_t k = 0; k < count; k++) {
        snprintf(tasks + k * TASK_BYTES, TASK_BYTES, "%.6s %hu", name, (unsigned short)k);
        variants[k] = (int64_t)k + 1;
    }
    struct store_round round = {.tasks = tasks,
                                .variants = variants,
                                .length = TASK_BYTES,
                                .count = count,
                                .done = 0,
                                .total = 10,
                                .best = "{\"shear\":3}"};
    enum store_answer answer = store_begin_round(scratch->store, claim, &round);
    free(tasks);
    free(variants);
    return answer;
}

static struct store_claim claim_task(struct scratch *scratch, const char *study, const char *task) {
    struct store_claim claim = claim_next(scratch);
    assert_int_equal(claim.kind, STORE_TASK);
    assert_string_equal(claim.parent, study);
    assert_int_equal(claim.task_length, TASK_BYTES);
    assert_string_equal((const char *)claim.task, task);
    return claim;
}

static enum store_answer end_task(struct scratch *scratch, const struct store_claim *claim,
                                  const char *numbers) {
    return store_end_task(scratch->store, claim, numbers, strlen(numbers), 1000);
}

static void expect_numbers(struct scratch *scratch, const struct store_claim *claim,
                           const char *wanted) {
    void *bytes;
    size_t length;
    assert_int_equal(store_numbers(scratch->store, claim, &bytes, &length), STORE_OK);
    assert_int_equal(length, strlen(wanted));
    assert_memory_equal(bytes, wanted, length);
    free(bytes);
}

/* A study in its first round of so many tasks. */
static void start_study(struct scratch *scratch, const char *body, size_t tasks, char id[ID_SIZE]) {
    submit_as(scratch, STORE_STUDY, NULL, body, id);
    struct store_claim claim = claim_next(scratch);
    assert_string_equal(claim.id, id);
    assert_int_equal(claim.kind, STORE_STUDY);
    assert_int_equal(begin(scratch, &claim, body, tasks), STORE_OK);
}

/* Nothing of any family is left, and no count remembers it. */
static void expect_no_tasks(struct scratch *scratch) {
    struct store_counts counts;
    assert_int_equal(store_counts(scratch->store, &counts), STORE_OK);
    assert_int_equal(counts.tasks[0], 0);
    assert_int_equal(counts.tasks[1], 0);
    assert_int_equal(counts.jobs[STORE_QUEUED], 0);
    assert_int_equal(counts.jobs[STORE_RUNNING], 0);
    assert_int_equal(scratch_number(scratch, "SELECT count(*) FROM draped.task_numbers"), 0);
    assert_int_equal(scratch_number(scratch, "SELECT count(*) FROM draped.jobs WHERE kind = 2"), 0);
    assert_int_equal(scratch_number(scratch,
                                    "SELECT coalesce(sum(abs(queued)) + sum(abs(running)) +"
                                    " sum(abs(tasks)), 0) FROM (SELECT sum(queued) AS"
                                    " queued, sum(running) AS running, sum(tasks) AS tasks"
                                    " FROM draped.owners GROUP BY owner) o"),
                     0);
}

static void expect_job(struct scratch *scratch, const char *id, enum store_status status,
                       int64_t done, double progress) {
    struct store_job job;
    assert_int_equal(store_get(scratch->store, id, &job), STORE_OK);
    assert_int_equal(job.status, status);
    assert_int_equal(job.done, done);
    assert_float_equal(job.progress, progress, 1e-12);
    store_job_clear(&job);
}

/* What a study has found so far, then that of its result. */
static void expect_summary(struct scratch *scratch, const char *id, const char *summary) {
    struct store_job job;
    assert_int_equal(store_get(scratch->store, id, &job), STORE_OK);
    assert_non_null(job.summary);
    assert_string_equal(job.summary, summary);
    store_job_clear(&job);
}

/* ------------------------------------------------------------------ rounds */

static void test_store_study_goes_through_its_rounds(void **state) {
    (void)state;
    struct scratch scratch;
    char id[ID_SIZE];
    scratch_open(&scratch);
    start_study(&scratch, "s", 2, id);
    expect_job(&scratch, id, STORE_RUNNING, 0, 0);
    expect_summary(&scratch, id, "{\"shear\":3}");
    struct store_claim first = claim_task(&scratch, id, "s 0");
    struct store_claim other = claim_task(&scratch, id, "s 1");
    expect_nothing_to_claim(&scratch);
    scratch_now += second;
    assert_int_equal(end_task(&scratch, &other, "late "), STORE_OK);
    expect_job(&scratch, id, STORE_RUNNING, 2, 0.2);
    expect_nothing_to_claim(&scratch);
    assert_int_equal(end_task(&scratch, &first, "early "), STORE_OK);
    assert_int_equal(end_task(&scratch, &first, "again "), STORE_CONFLICT);
    expect_job(&scratch, id, STORE_RUNNING, 3, 0.3);
    struct store_claim step = claim_next(&scratch);
    assert_string_equal(step.id, id);
    assert_int_equal(step.kind, STORE_STUDY);
    assert_int_equal(step.spent, 2000);
    expect_job(&scratch, id, STORE_RUNNING, 3, 0.3);
    expect_numbers(&scratch, &step, "early late ");
    assert_int_equal(begin(&scratch, &step, "t", 1), STORE_OK);
    assert_int_equal(begin(&scratch, &step, "t", 1), STORE_CONFLICT);
    struct store_claim third = claim_task(&scratch, id, "t 0");
    assert_int_equal(end_task(&scratch, &third, "last"), STORE_OK);
    step = claim_next(&scratch);
    expect_numbers(&scratch, &step, "early late last");
    assert_int_equal(scratch_commit(&scratch, &step, "result", 6), STORE_OK);
    expect_job(&scratch, id, STORE_SUCCEEDED, 1, 1);
    expect_summary(&scratch, id, "{\"nodes\":1}");
    scratch_expect_result(&scratch, id, "result", 6, 6);
    expect_no_tasks(&scratch);
    scratch_remove(&scratch);
}

/* Nobody sees a task, and what runs or waits within a study is a study that runs. */
static void test_store_shows_studies_and_no_tasks(void **state) {
    (void)state;
    struct scratch scratch;
    struct store_page page;
    struct store_counts counts;
    char id[ID_SIZE], drape[ID_SIZE];
    scratch_open(&scratch);
    scratch_submit(&scratch, "drape", drape);
    struct store_claim claim = claim_next(&scratch);
    start_study(&scratch, "s", 3, id);
    static const enum store_status seen[] = {STORE_RUNNING, STORE_QUEUED};
    for (enum store_kind kind = STORE_DRAPE; kind <= STORE_STUDY; kind++) {
        for (int k = 0; k < 5; k++) {
            struct store_filter filter = {.kind = kind,
                                          .has_status = k > 0,
                                          .status = seen[k / 3],
                                          .owner = k % 2 ? "" : NULL,
                                          .limit = 10};
            assert_int_equal(store_list(scratch.store, &filter, &page), STORE_OK);
            assert_int_equal(page.count, k < 3);
            if (page.count)
                assert_string_equal(page.jobs[0].id, kind == STORE_DRAPE ? drape : id);
            store_page_clear(&page);
        }
    }
    assert_int_equal(store_counts(scratch.store, &counts), STORE_OK);
    assert_int_equal(counts.jobs[STORE_RUNNING], 2);
    assert_int_equal(counts.jobs[STORE_QUEUED], 0);
    assert_int_equal(counts.tasks[0], 3);
    assert_int_equal(counts.oldest_queued, 0);
    struct store_claim task = claim_task(&scratch, id, "s 0");
    assert_int_equal(store_counts(scratch.store, &counts), STORE_OK);
    assert_int_equal(counts.tasks[0], 2);
    assert_int_equal(counts.tasks[1], 1);
    assert_int_equal(store_release(scratch.store, &task), STORE_OK);
    assert_int_equal(scratch_commit(&scratch, &claim, "r", 1), STORE_OK);
    assert_int_equal(store_delete(scratch.store, id), STORE_OK);
    expect_no_tasks(&scratch);
    scratch_remove(&scratch);
}

/* ------------------------------------------------------------------ what is lost */

static void test_store_task_is_done_again_when_its_worker_died(void **state) {
    (void)state;
    struct scratch scratch;
    char id[ID_SIZE];
    scratch_open(&scratch);
    start_study(&scratch, "s", 1, id);
    struct store_claim lost = claim_task(&scratch, id, "s 0");
    scratch_now += 61 * second;
    assert_int_equal(scratch_sweep(&scratch).requeued, 1);
    struct store_claim again = claim_task(&scratch, id, "s 0");
    assert_int_equal(again.attempts, 2);
    assert_int_equal(end_task(&scratch, &lost, "lost"), STORE_CONFLICT);
    assert_int_equal(end_task(&scratch, &again, "kept"), STORE_OK);
    struct store_claim step = claim_next(&scratch);
    expect_numbers(&scratch, &step, "kept");
    assert_int_equal(store_crashed(scratch.store, &step, "signal 11"), STORE_OK);
    expect_job(&scratch, id, STORE_RUNNING, 1, 0.1);
    step = claim_next(&scratch);
    assert_int_equal(step.attempts, 2);
    expect_numbers(&scratch, &step, "kept");
    scratch_remove(&scratch);
}

/* Each step of a study has all its attempts, however many it had before. */
static void test_store_study_steps_count_attempts_of_their_own(void **state) {
    (void)state;
    struct scratch scratch;
    char id[ID_SIZE];
    scratch_open(&scratch);
    submit_as(&scratch, STORE_STUDY, NULL, "s", id);
    for (int round = 0; round < 4; round++) {
        struct store_claim step = claim_next(&scratch);
        assert_int_equal(store_crashed(scratch.store, &step, "signal 11"), STORE_OK);
        step = claim_next(&scratch);
        assert_int_equal(step.kind, STORE_STUDY);
        assert_int_equal(step.attempts, 2);
        assert_int_equal(begin(&scratch, &step, "t", 1), STORE_OK);
        struct store_claim task = claim_next(&scratch);
        assert_int_equal(end_task(&scratch, &task, "n"), STORE_OK);
    }
    for (int k = 0; k < 3; k++) {
        struct store_claim step = claim_next(&scratch);
        assert_int_equal(store_crashed(scratch.store, &step, "signal 11"), STORE_OK);
    }
    expect_job(&scratch, id, STORE_FAILED, 1, 0);
    expect_no_tasks(&scratch);
    scratch_remove(&scratch);
}

static void test_store_task_that_fails_ends_its_study(void **state) {
    (void)state;
    struct scratch scratch;
    struct store_job job;
    struct store_counts counts;
    char id[ID_SIZE];
    scratch_open(&scratch);
    start_study(&scratch, "s", 3, id);
    struct store_claim task = claim_task(&scratch, id, "s 0");
    struct store_claim other = claim_task(&scratch, id, "s 1");
    assert_int_equal(store_fail(scratch.store, &task, "{\"status\":500}"), STORE_OK);
    assert_int_equal(store_check(scratch.store, &other), STORE_CONFLICT);
    assert_int_equal(end_task(&scratch, &other, "n"), STORE_CONFLICT);
    assert_int_equal(store_get(scratch.store, id, &job), STORE_OK);
    assert_int_equal(job.status, STORE_FAILED);
    assert_string_equal(job.error, "{\"status\":500}");
    assert_int_equal(job.finished, scratch_now);
    store_job_clear(&job);
    expect_nothing_to_claim(&scratch);
    expect_no_tasks(&scratch);
    assert_int_equal(store_counts(scratch.store, &counts), STORE_OK);
    assert_int_equal(counts.ended[STORE_FAILED], 1);
    scratch_remove(&scratch);
}

static void test_store_task_is_changed_without_cost(void **state) {
    (void)state;
    struct scratch scratch;
    char id[ID_SIZE], changed[TASK_BYTES] = "";
    scratch_open(&scratch);
    start_study(&scratch, "s", 1, id);
    struct store_claim task = claim_task(&scratch, id, "s 0");
    for (int k = 0; k < 5; k++) {
        snprintf(changed, sizeof changed, "changed %c", '0' + k);
        assert_int_equal(store_change_task(scratch.store, &task, changed), STORE_OK);
        assert_int_equal(store_change_task(scratch.store, &task, changed), STORE_CONFLICT);
        task = claim_task(&scratch, id, changed);
    }
    assert_int_equal(store_crashed(scratch.store, &task, "signal 11"), STORE_OK);
    task = claim_task(&scratch, id, changed);
    assert_int_equal(end_task(&scratch, &task, "n"), STORE_OK);
    scratch_remove(&scratch);
}

/* ------------------------------------------------------------------ the end by the caller */

static void test_store_study_takes_its_tasks_with_it(void **state) {
    (void)state;
    struct scratch scratch;
    char id[ID_SIZE];
    scratch_open(&scratch);
    for (int k = 0; k < 2; k++) {
        start_study(&scratch, "s", 3, id);
        struct store_claim ended = claim_task(&scratch, id, "s 0");
        struct store_claim task = claim_task(&scratch, id, "s 1");
        assert_int_equal(end_task(&scratch, &ended, "n"), STORE_OK);
        if (k == 0) {
            assert_int_equal(store_cancel(scratch.store, id), STORE_OK);
            expect_job(&scratch, id, STORE_CANCELLED, 1, 0);
            assert_int_equal(store_cancel(scratch.store, id), STORE_CONFLICT);
        } else {
            assert_int_equal(store_delete(scratch.store, id), STORE_OK);
        }
        assert_int_equal(store_check(scratch.store, &task), STORE_CONFLICT);
        assert_int_equal(store_renew(scratch.store, &task, 0.5), STORE_CONFLICT);
        assert_int_equal(end_task(&scratch, &task, "n"), STORE_CONFLICT);
        expect_nothing_to_claim(&scratch);
        expect_no_tasks(&scratch);
    }
    scratch_remove(&scratch);
}

/* ------------------------------------------------------------------ whose turn it is */

/* Drapes come before what studies have begun, and studies one after the other. */
static void test_store_drapes_come_before_tasks(void **state) {
    (void)state;
    struct scratch scratch;
    char first[ID_SIZE], second_study[ID_SIZE], drape[ID_SIZE];
    scratch_open(&scratch);
    start_study(&scratch, "a", 2, first);
    scratch_now += second;
    submit_as(&scratch, STORE_STUDY, NULL, "b", second_study);
    scratch_now += second;
    scratch_submit(&scratch, "drape", drape);
    struct store_claim claim = claim_next(&scratch);
    assert_string_equal(claim.id, drape);
    claim_task(&scratch, first, "a 0");
    claim_task(&scratch, first, "a 1");
    claim = claim_next(&scratch);
    assert_string_equal(claim.id, second_study);
    scratch_remove(&scratch);
}

static void test_store_tasks_leave_others_their_share(void **state) {
    (void)state;
    struct scratch scratch;
    struct store_claim claim;
    char study[ID_SIZE], drape[ID_SIZE];
    scratch_open(&scratch);
    submit_as(&scratch, STORE_STUDY, "anna", "s", study);
    claim = claim_next(&scratch);
    assert_int_equal(begin(&scratch, &claim, "s", 50), STORE_OK);
    for (int k = 0; k < 3; k++)
        claim_next(&scratch);
    assert_int_equal(store_starving(scratch.store, false), STORE_EMPTY);
    submit_as(&scratch, STORE_DRAPE, "berta", "d", drape);
    assert_int_equal(store_starving(scratch.store, false), STORE_OK);
    claim = claim_next(&scratch);
    assert_string_equal(claim.id, drape);
    assert_int_equal(store_release(scratch.store, &claim), STORE_OK);
    scratch_remove(&scratch);
}

/* The fast worker is for what is short and has not run: not for studies. */
static void test_store_tasks_take_no_express_lane(void **state) {
    (void)state;
    struct scratch scratch;
    struct store_claim claim;
    char study[ID_SIZE], drape[ID_SIZE];
    scratch_open(&scratch);
    start_study(&scratch, "s", 2, study);
    assert_int_equal(store_starving(scratch.store, false), STORE_OK);
    assert_int_equal(store_starving(scratch.store, true), STORE_EMPTY);
    assert_int_equal(store_claim_fresh(scratch.store, &claim), STORE_EMPTY);
    scratch_submit(&scratch, "drape", drape);
    assert_int_equal(store_starving(scratch.store, true), STORE_OK);
    assert_int_equal(store_claim_fresh(scratch.store, &claim), STORE_OK);
    assert_string_equal(claim.id, drape);
    scratch_remove(&scratch);
}

/* Limits count studies that have not begun, and no task. */
static void test_store_limits_do_not_count_tasks(void **state) {
    (void)state;
    struct scratch scratch;
    struct store_receipt receipt;
    struct store_usage usage;
    char study[ID_SIZE];
    scratch_make(&scratch);
    scratch.options.queue_limit = 2;
    scratch_start(&scratch);
    struct store_submission submission = {
        .request = "d", .request_length = 1, .digest = "d", .quota = {.queued = 1}};
    start_study(&scratch, "s", 5, study);
    assert_int_equal(store_usage(scratch.store, "", &usage), STORE_OK);
    assert_int_equal(usage.queued, 0);
    assert_int_equal(store_submit(scratch.store, &submission, &receipt), STORE_OK);
    assert_int_equal(store_submit(scratch.store, &submission, &receipt), STORE_FULL);
    assert_int_equal(receipt.full, STORE_BOUND_OWNER_QUEUED);
    submission.quota.queued = 0;
    submission.kind = STORE_STUDY;
    submission.digest = "e";
    submission.owner = "another";
    assert_int_equal(store_submit(scratch.store, &submission, &receipt), STORE_OK);
    assert_int_equal(store_submit(scratch.store, &submission, &receipt), STORE_FULL);
    assert_int_equal(receipt.full, STORE_BOUND_QUEUE);
    scratch_remove(&scratch);
}

/* ------------------------------------------------------------------ keys, results, retention */

static void test_store_key_is_of_one_kind(void **state) {
    (void)state;
    struct scratch scratch;
    struct store_receipt receipt, again;
    scratch_open(&scratch);
    struct store_submission submission = {
        .kind = STORE_STUDY, .request = "s", .request_length = 1, .digest = "s", .key = "key"};
    assert_int_equal(store_submit(scratch.store, &submission, &receipt), STORE_OK);
    assert_int_equal(store_submit(scratch.store, &submission, &again), STORE_OK);
    assert_true(again.existing);
    assert_string_equal(again.id, receipt.id);
    submission.kind = STORE_DRAPE;
    assert_int_equal(store_submit(scratch.store, &submission, &again), STORE_CONFLICT);
    scratch_remove(&scratch);
}

static void test_store_equal_studies_share_a_result(void **state) {
    (void)state;
    struct scratch scratch;
    struct store_receipt receipt;
    char id[ID_SIZE];
    scratch_open(&scratch);
    start_study(&scratch, "s", 1, id);
    struct store_claim claim = claim_next(&scratch);
    assert_int_equal(end_task(&scratch, &claim, "n"), STORE_OK);
    claim = claim_next(&scratch);
    assert_int_equal(scratch_commit(&scratch, &claim, "result", 6), STORE_OK);
    struct store_submission submission = {
        .kind = STORE_STUDY, .total = 10, .request = "s", .request_length = 1, .digest = "s"};
    assert_int_equal(store_submit(scratch.store, &submission, &receipt), STORE_OK);
    assert_int_equal(receipt.status, STORE_SUCCEEDED);
    scratch_expect_result(&scratch, receipt.id, "result", 6, 3);
    scratch_remove(&scratch);
}

static void test_store_reopens_in_the_midst_of_a_study(void **state) {
    (void)state;
    struct scratch scratch;
    char id[ID_SIZE];
    scratch_open(&scratch);
    start_study(&scratch, "s", 2, id);
    struct store_claim ended = claim_task(&scratch, id, "s 0");
    claim_task(&scratch, id, "s 1");
    assert_int_equal(end_task(&scratch, &ended, "first "), STORE_OK);
    scratch_stop(&scratch);
    scratch_now += 61 * second;
    scratch_start(&scratch);
    assert_int_equal(scratch_sweep(&scratch).requeued, 1);
    struct store_claim task = claim_task(&scratch, id, "s 1");
    assert_int_equal(end_task(&scratch, &task, "second"), STORE_OK);
    struct store_claim step = claim_next(&scratch);
    expect_numbers(&scratch, &step, "first second");
    scratch_remove(&scratch);
}

/* A study expires and goes as any job; one that waits does not, however old. */
static void test_store_studies_expire(void **state) {
    (void)state;
    struct scratch scratch;
    struct store_result result;
    char id[ID_SIZE], waiting[ID_SIZE], *bytes;
    size_t length;
    scratch_open(&scratch);
    start_study(&scratch, "s", 1, id);
    struct store_claim claim = claim_next(&scratch);
    assert_int_equal(end_task(&scratch, &claim, "n"), STORE_OK);
    claim = claim_next(&scratch);
    assert_int_equal(scratch_commit(&scratch, &claim, "result", 6), STORE_OK);
    start_study(&scratch, "w", 1, waiting);
    scratch_now += scratch.options.retention_us + second;
    while (scratch_sweep(&scratch).more)
        continue;
    assert_int_equal(store_result_find(scratch.store, id, &result), STORE_EMPTY);
    assert_int_equal(store_request(scratch.store, id, &bytes, &length), STORE_EMPTY);
    scratch_now += scratch.options.records_us;
    while (scratch_sweep(&scratch).more)
        continue;
    struct store_job job;
    assert_int_equal(store_get(scratch.store, id, &job), STORE_EMPTY);
    store_job_clear(&job);
    expect_job(&scratch, waiting, STORE_RUNNING, 0, 0);
    claim_task(&scratch, waiting, "w 0");
    scratch_remove(&scratch);
}

/* ------------------------------------------------------------------ laminates */

static void submit_laminate(struct scratch *scratch, const char *key, char id[ID_SIZE]) {
    static const struct store_member members[] = {{"ply a", 5, "a"}, {"b", 1, "b"}, {"", 0, "c"}};
    struct store_receipt receipt;
    struct store_family family = {.parent = {.kind = STORE_LAMINATE,
                                             .request = "stack",
                                             .request_length = 5,
                                             .digest = "stack",
                                             .key = key},
                                  .count = 3,
                                  .members = members};
    assert_int_equal(store_submit_family(scratch->store, &family, &receipt), STORE_OK);
    assert_int_equal(receipt.status, STORE_RUNNING);
    assert_false(receipt.existing);
    memcpy(id, receipt.id, ID_SIZE);
    assert_int_equal(store_submit_family(scratch->store, &family, &receipt), STORE_OK);
    assert_int_equal(receipt.existing, key != NULL);
    if (key)
        assert_string_equal(receipt.id, id);
    else
        assert_int_equal(store_delete(scratch->store, receipt.id), STORE_OK);
}

static void expect_request(struct scratch *scratch, const char *id, const char *wanted) {
    char *bytes;
    size_t length;
    assert_int_equal(store_request(scratch->store, id, &bytes, &length), STORE_OK);
    assert_string_equal(bytes, wanted);
    free(bytes);
}

static void test_store_laminate_ends_with_its_drapes(void **state) {
    (void)state;
    struct scratch scratch;
    struct store_page page;
    struct store_job job;
    char id[ID_SIZE];
    static const char *const requests[] = {"ply a", "b", ""};
    scratch_open(&scratch);
    submit_laminate(&scratch, "key", id);
    expect_request(&scratch, id, "stack");
    expect_job(&scratch, id, STORE_RUNNING, 0, 0);
    assert_int_equal(store_members(scratch.store, id, &page), STORE_OK);
    assert_int_equal(page.count, 3);
    for (int k = 0; k < 3; k++) {
        assert_int_equal(page.jobs[k].kind, STORE_DRAPE);
        assert_int_equal(page.jobs[k].position, k);
        assert_int_equal(page.jobs[k].status, STORE_QUEUED);
        expect_request(&scratch, page.jobs[k].id, requests[k]);
    }
    struct store_claim claim = claim_next(&scratch);
    assert_string_equal(claim.id, page.jobs[0].id);
    assert_string_equal(claim.parent, id);
    assert_int_equal(scratch_commit(&scratch, &claim, "r", 1), STORE_OK);
    expect_job(&scratch, id, STORE_RUNNING, 1, 1.0 / 3);
    claim = claim_next(&scratch);
    assert_int_equal(store_fail(scratch.store, &claim, "{}"), STORE_OK);
    expect_job(&scratch, id, STORE_RUNNING, 2, 2.0 / 3);
    scratch_now += second;
    assert_int_equal(store_cancel(scratch.store, page.jobs[2].id), STORE_OK);
    assert_int_equal(store_get(scratch.store, id, &job), STORE_OK);
    assert_int_equal(job.status, STORE_SUCCEEDED);
    assert_int_equal(job.finished, scratch_now);
    store_job_clear(&job);
    store_page_clear(&page);
    expect_no_tasks(&scratch);
    scratch_remove(&scratch);
}

static void test_store_laminate_takes_its_drapes_with_it(void **state) {
    (void)state;
    struct scratch scratch;
    struct store_page page, gone;
    char id[ID_SIZE];
    scratch_open(&scratch);
    submit_laminate(&scratch, NULL, id);
    struct store_claim ended = claim_next(&scratch), running = claim_next(&scratch);
    assert_int_equal(scratch_commit(&scratch, &ended, "r", 1), STORE_OK);
    assert_int_equal(store_members(scratch.store, id, &page), STORE_OK);
    assert_int_equal(store_cancel(scratch.store, id), STORE_OK);
    assert_int_equal(store_check(scratch.store, &running), STORE_CONFLICT);
    assert_int_equal(scratch_status(&scratch, page.jobs[0].id), STORE_SUCCEEDED);
    assert_int_equal(scratch_status(&scratch, page.jobs[1].id), STORE_CANCELLED);
    assert_int_equal(scratch_status(&scratch, page.jobs[2].id), STORE_CANCELLED);
    expect_no_tasks(&scratch);
    assert_int_equal(store_delete(scratch.store, id), STORE_OK);
    assert_int_equal(store_members(scratch.store, id, &gone), STORE_OK);
    assert_int_equal(gone.count, 0);
    scratch_sweep(&scratch);
    static const char *const tables[] = {
        "SELECT count(*) FROM draped.jobs", "SELECT count(*) FROM draped.requests",
        "SELECT count(*) FROM draped.results", "SELECT count(*) FROM draped.chunks"};
    for (int k = 0; k < 4; k++)
        assert_int_equal(scratch_number(&scratch, tables[k]), 0);
    store_page_clear(&gone);
    store_page_clear(&page);
    scratch_remove(&scratch);
}

/* A drape that is deleted by itself is none the laminate waits for. */
static void test_store_laminate_does_not_wait_for_the_deleted(void **state) {
    (void)state;
    struct scratch scratch;
    struct store_page page;
    char id[ID_SIZE];
    scratch_open(&scratch);
    submit_laminate(&scratch, NULL, id);
    assert_int_equal(store_members(scratch.store, id, &page), STORE_OK);
    for (int k = 0; k < 3; k++) {
        expect_job(&scratch, id, STORE_RUNNING, k, k / 3.0);
        assert_int_equal(store_delete(scratch.store, page.jobs[k].id), STORE_OK);
    }
    expect_job(&scratch, id, STORE_SUCCEEDED, 3, 0);
    store_page_clear(&page);
    expect_no_tasks(&scratch);
    scratch_remove(&scratch);
}

static void test_store_laminate_counts_as_its_drapes(void **state) {
    (void)state;
    struct scratch scratch;
    struct store_receipt receipt;
    static const struct store_member members[] = {{"a", 1, "a"}, {"b", 1, "b"}};
    struct store_family family = {.parent = {.kind = STORE_LAMINATE,
                                             .request = "l",
                                             .request_length = 1,
                                             .digest = "l",
                                             .quota = {.queued = 3}},
                                  .count = 2,
                                  .members = members};
    scratch_make(&scratch);
    scratch.options.queue_limit = 5;
    scratch_start(&scratch);
    assert_int_equal(store_submit_family(scratch.store, &family, &receipt), STORE_OK);
    assert_int_equal(store_submit_family(scratch.store, &family, &receipt), STORE_FULL);
    assert_int_equal(receipt.full, STORE_BOUND_OWNER_QUEUED);
    family.parent.quota = (struct store_quota){.bytes = 5};
    assert_int_equal(store_submit_family(scratch.store, &family, &receipt), STORE_FULL);
    assert_int_equal(receipt.full, STORE_BOUND_OWNER_BYTES);
    family.parent.quota.bytes = 6;
    assert_int_equal(store_submit_family(scratch.store, &family, &receipt), STORE_FULL);
    assert_int_equal(receipt.full, STORE_BOUND_SHARE);
    family.parent.owner = "another";
    assert_int_equal(store_submit_family(scratch.store, &family, &receipt), STORE_OK);
    family.parent.quota.bytes = 0;
    family.parent.owner = "yet another";
    assert_int_equal(store_submit_family(scratch.store, &family, &receipt), STORE_FULL);
    assert_int_equal(receipt.full, STORE_BOUND_QUEUE);
    family.parent.surface = "none";
    assert_int_equal(store_submit_family(scratch.store, &family, &receipt), STORE_EMPTY);
    scratch_remove(&scratch);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_store_study_goes_through_its_rounds),
        cmocka_unit_test(test_store_shows_studies_and_no_tasks),
        cmocka_unit_test(test_store_task_is_done_again_when_its_worker_died),
        cmocka_unit_test(test_store_study_steps_count_attempts_of_their_own),
        cmocka_unit_test(test_store_task_that_fails_ends_its_study),
        cmocka_unit_test(test_store_task_is_changed_without_cost),
        cmocka_unit_test(test_store_study_takes_its_tasks_with_it),
        cmocka_unit_test(test_store_drapes_come_before_tasks),
        cmocka_unit_test(test_store_tasks_leave_others_their_share),
        cmocka_unit_test(test_store_tasks_take_no_express_lane),
        cmocka_unit_test(test_store_limits_do_not_count_tasks),
        cmocka_unit_test(test_store_key_is_of_one_kind),
        cmocka_unit_test(test_store_equal_studies_share_a_result),
        cmocka_unit_test(test_store_reopens_in_the_midst_of_a_study),
        cmocka_unit_test(test_store_studies_expire),
        cmocka_unit_test(test_store_laminate_ends_with_its_drapes),
        cmocka_unit_test(test_store_laminate_takes_its_drapes_with_it),
        cmocka_unit_test(test_store_laminate_does_not_wait_for_the_deleted),
        cmocka_unit_test(test_store_laminate_counts_as_its_drapes),
    };
    return scratch_run("store families", tests, NULL, 0);
}
