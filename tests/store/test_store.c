/* SPDX-License-Identifier: MIT */
/* What callers do with jobs and surfaces, and each answer they can get. */
#include "scratch.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const char nowhere[] = "0123456789abcdef0123456789abcdef";

/* ------------------------------------------------------------------ submit and look */

static void test_store_submit_is_found_again(void **state) {
    struct scratch *scratch = *state;
    static const char body[] = "{\"a\":\0 1}"; /* any bytes */
    struct store_submission submission = {.request = body,
                                          .request_length = sizeof body,
                                          .digest = "d1",
                                          .owner = "anna",
                                          .priority = 2};
    struct store_receipt receipt;
    struct store_job job;
    assert_int_equal(store_submit(scratch->store, &submission, &receipt), STORE_OK);
    assert_int_equal(receipt.status, STORE_QUEUED);
    assert_false(receipt.existing);
    assert_int_equal(store_get(scratch->store, receipt.id, &job), STORE_OK);
    assert_string_equal(job.id, receipt.id);
    assert_int_equal(job.status, STORE_QUEUED);
    assert_true(job.created == scratch_now && job.started == 0 && job.finished == 0);
    assert_true(job.attempts == 0 && job.priority == 2 && job.progress == 0 && !job.expired);
    assert_string_equal(job.owner, "anna");
    assert_string_equal(job.surface, "");
    assert_string_equal(job.digest, "d1");
    assert_true(!job.error && !job.summary);
    store_job_clear(&job);

    char *bytes = NULL;
    size_t length = 0;
    assert_int_equal(store_request(scratch->store, receipt.id, &bytes, &length), STORE_OK);
    assert_int_equal(length, sizeof body);
    assert_memory_equal(bytes, body, length);
    assert_int_equal(bytes[length], 0);
    free(bytes);
}

static void test_store_unknown_job_is_empty(void **state) {
    struct scratch *scratch = *state;
    struct store_job job;
    struct store_result result;
    char *bytes = NULL;
    size_t length = 0;
    assert_int_equal(store_get(scratch->store, nowhere, &job), STORE_EMPTY);
    store_job_clear(&job);
    assert_int_equal(store_request(scratch->store, nowhere, &bytes, &length), STORE_EMPTY);
    assert_null(bytes);
    assert_int_equal(store_cancel(scratch->store, nowhere), STORE_EMPTY);
    assert_int_equal(store_delete(scratch->store, nowhere), STORE_EMPTY);
    assert_int_equal(store_result_find(scratch->store, nowhere, &result), STORE_EMPTY);
    assert_int_equal(store_get(scratch->store, "'; DROP TABLE jobs; --", &job), STORE_EMPTY);
    store_job_clear(&job);
}

static void test_store_submit_beyond_the_limit_is_full(void **state) {
    struct scratch *scratch = *state;
    scratch_stop(scratch);
    scratch->options.queue_limit = 2;
    scratch_start(scratch);
    char id[ID_SIZE];
    struct store_claim claim;
    struct store_receipt receipt;
    struct store_counts counts;
    struct store_submission third = {
        .request = "c", .request_length = 1, .digest = "c", .owner = "bert"};
    scratch_submit(scratch, "a", id);
    assert_int_equal(store_submit(scratch->store, &third, &receipt), STORE_OK);
    third.request = third.digest = "d";
    assert_int_equal(store_submit(scratch->store, &third, &receipt), STORE_FULL);
    assert_int_equal(receipt.full, STORE_BOUND_QUEUE);
    assert_int_equal(store_counts(scratch->store, &counts), STORE_OK);
    assert_int_equal(counts.jobs[STORE_QUEUED], 2);
    assert_int_equal(store_claim(scratch->store, &claim), STORE_OK);
    third.owner = "carl";
    assert_int_equal(store_submit(scratch->store, &third, &receipt), STORE_OK);
}

/* ------------------------------------------------------------------ quotas */

static enum store_answer submit_within(struct scratch *scratch, const char *owner, const char *body,
                                       struct store_quota quota, struct store_receipt *receipt) {
    struct store_submission submission = {.request = body,
                                          .request_length = strlen(body),
                                          .digest = body,
                                          .owner = owner,
                                          .quota = quota};
    return store_submit(scratch->store, &submission, receipt);
}

static void expect_usage(struct scratch *scratch, const char *owner, int64_t queued,
                         int64_t running, int64_t bytes) {
    struct store_usage usage;
    assert_int_equal(store_usage(scratch->store, owner, &usage), STORE_OK);
    assert_int_equal(usage.queued, queued);
    assert_int_equal(usage.running, running);
    assert_int_equal(usage.bytes, bytes);
}

static void test_store_quota_of_queued_jobs_is_the_owners(void **state) {
    struct scratch *scratch = *state;
    const struct store_quota two = {.queued = 2};
    struct store_receipt receipt;
    struct store_claim claim;
    for (int k = 0; k < 2; k++)
        assert_int_equal(submit_within(scratch, "anna", k ? "a" : "b", two, &receipt), STORE_OK);
    assert_int_equal(submit_within(scratch, "anna", "c", two, &receipt), STORE_FULL);
    assert_int_equal(receipt.full, STORE_BOUND_OWNER_QUEUED);
    assert_int_equal(submit_within(scratch, "bert", "c", two, &receipt), STORE_OK);
    expect_usage(scratch, "anna", 2, 0, 2);
    expect_usage(scratch, "bert", 1, 0, 1);
    expect_usage(scratch, "carl", 0, 0, 0);
    assert_int_equal(store_claim(scratch->store, &claim), STORE_OK);
    expect_usage(scratch, "anna", 1, 1, 2);
    assert_int_equal(submit_within(scratch, "anna", "c", two, &receipt), STORE_OK);
    assert_int_equal(store_cancel(scratch->store, receipt.id), STORE_OK);
    expect_usage(scratch, "anna", 1, 1, 3);
    assert_int_equal(store_delete(scratch->store, receipt.id), STORE_OK);
    expect_usage(scratch, "anna", 1, 1, 2);
}

/* One owner after another begins to queue all it can: none gets more than it leaves, and whoever
 * comes then finds a place. */
static void test_store_queue_leaves_a_place_for_who_comes(void **state) {
    enum { LIMIT = 24, OWNERS = 5 };
    struct scratch *scratch = *state;
    static const char *const names[OWNERS] = {"anna", "bert", "carl", "dora", "emil"};
    unsigned seed = 1;
    int number = 0;
    scratch_stop(scratch);
    scratch->options.queue_limit = LIMIT;
    scratch_start(scratch);
    for (int owners = 1; owners < OWNERS; owners++) {
        struct store_receipt receipt;
        struct store_counts counts;
        struct store_usage usage;
        char body[16];
        for (int refused = 0; refused < 10 * owners; number++) {
            snprintf(body, sizeof body, "%d", number);
            enum store_answer answer = submit_within(scratch, names[rand_r(&seed) % owners], body,
                                                     (struct store_quota){0}, &receipt);
            refused = answer == STORE_OK ? 0 : refused + 1;
            if (refused > 0) {
                assert_int_equal(answer, STORE_FULL);
                assert_int_equal(receipt.full, STORE_BOUND_SHARE);
            }
        }
        assert_int_equal(store_counts(scratch->store, &counts), STORE_OK);
        int64_t left = LIMIT - counts.jobs[STORE_QUEUED];
        assert_in_range(left, 1, LIMIT / 2);
        assert_int_equal(store_usage(scratch->store, names[owners - 1], &usage), STORE_OK);
        assert_in_range(usage.queued, left, left + 1);
        assert_int_equal(submit_within(scratch, "new", "new", (struct store_quota){0}, &receipt),
                         STORE_OK);
        assert_int_equal(store_delete(scratch->store, receipt.id), STORE_OK);
    }
}

static void test_store_quota_of_bytes_counts_all_that_is_stored(void **state) {
    struct scratch *scratch = *state;
    const struct store_quota hundred = {.bytes = 100};
    static char bytes[90];
    const struct store_item surface = {.id = "s",
                                       .owner = "anna",
                                       .definition = "0123456",
                                       .definition_length = 7,
                                       .description = "{}"};
    struct store_receipt receipt;
    struct store_claim claim;
    bool created = false;
    assert_int_equal(submit_within(scratch, "anna", "one", hundred, &receipt), STORE_OK);
    assert_int_equal(store_claim(scratch->store, &claim), STORE_OK);
    assert_int_equal(scratch_commit(scratch, &claim, bytes, sizeof bytes), STORE_OK);
    expect_usage(scratch, "anna", 0, 0, 93);
    assert_int_equal(store_item_put(scratch->store, STORE_SURFACES, &surface, &created), STORE_OK);
    expect_usage(scratch, "anna", 0, 0, 100);
    assert_int_equal(submit_within(scratch, "anna", "two", hundred, &receipt), STORE_FULL);
    assert_int_equal(receipt.full, STORE_BOUND_OWNER_BYTES);
    assert_int_equal(submit_within(scratch, "bert", "two", hundred, &receipt), STORE_OK);
    assert_int_equal(store_item_delete(scratch->store, STORE_SURFACES, "anna", "s"), STORE_OK);
    assert_int_equal(submit_within(scratch, "anna", "two", hundred, &receipt), STORE_OK);
    assert_int_equal(store_delete(scratch->store, claim.id), STORE_OK);
    expect_usage(scratch, "anna", 1, 0, 3);
}

static void test_store_owner_without_anything_is_forgotten(void **state) {
    struct scratch *scratch = *state;
    struct store_receipt receipt;
    assert_int_equal(submit_within(scratch, "anna", "a", (struct store_quota){0}, &receipt),
                     STORE_OK);
    struct store_claim claim;
    assert_int_equal(store_claim(scratch->store, &claim), STORE_OK);
    assert_int_equal(scratch_commit(scratch, &claim, "r", 1), STORE_OK);
    assert_int_equal(store_delete(scratch->store, claim.id), STORE_OK);
    for (int k = 0; k < 3; k++)
        scratch_sweep(scratch);
    assert_int_equal(scratch_number(scratch, "SELECT count(*) FROM draped.owners"), 0);
}

/* ------------------------------------------------------------------ idempotency keys */

static enum store_answer submit_key(struct scratch *scratch, const char *owner, const char *key,
                                    const char *body, struct store_receipt *receipt) {
    struct store_submission submission = {.request = body,
                                          .request_length = strlen(body),
                                          .digest = body,
                                          .owner = owner,
                                          .key = key};
    return store_submit(scratch->store, &submission, receipt);
}

static void test_store_key_gives_the_same_job(void **state) {
    struct scratch *scratch = *state;
    struct store_receipt first, again;
    assert_int_equal(submit_key(scratch, NULL, "k", "body", &first), STORE_OK);
    assert_int_equal(submit_key(scratch, NULL, "k", "body", &again), STORE_OK);
    assert_true(again.existing);
    assert_string_equal(again.id, first.id);

    scratch_stop(scratch);
    scratch_start(scratch);
    assert_int_equal(submit_key(scratch, NULL, "k", "body", &again), STORE_OK);
    assert_true(again.existing);
    assert_int_equal(store_cancel(scratch->store, first.id), STORE_OK);
    assert_int_equal(submit_key(scratch, NULL, "k", "body", &again), STORE_OK);
    assert_int_equal(again.status, STORE_CANCELLED);
}

static void test_store_key_with_another_body_is_a_conflict(void **state) {
    struct scratch *scratch = *state;
    struct store_receipt first, other;
    assert_int_equal(submit_key(scratch, "anna", "k", "body", &first), STORE_OK);
    assert_int_equal(submit_key(scratch, "anna", "k", "other", &other), STORE_CONFLICT);
    assert_int_equal(submit_key(scratch, "bert", "k", "other", &other), STORE_OK);
    assert_false(other.existing);
    assert_int_equal(store_delete(scratch->store, first.id), STORE_OK);
    assert_int_equal(submit_key(scratch, "anna", "k", "other", &other), STORE_OK);
    assert_false(other.existing);
}

/* ------------------------------------------------------------------ cancel and delete */

static void test_store_cancel_ends_once(void **state) {
    struct scratch *scratch = *state;
    char id[ID_SIZE];
    scratch_submit(scratch, "a", id);
    assert_int_equal(store_cancel(scratch->store, id), STORE_OK);
    assert_int_equal(scratch_status(scratch, id), STORE_CANCELLED);
    assert_int_equal(store_cancel(scratch->store, id), STORE_CONFLICT);

    struct store_claim claim = scratch_claimed(scratch, "b");
    assert_int_equal(store_check(scratch->store, &claim), STORE_OK);
    assert_int_equal(store_cancel(scratch->store, claim.id), STORE_OK);
    assert_int_equal(store_check(scratch->store, &claim), STORE_CONFLICT);
    assert_int_equal(store_claim(scratch->store, &claim), STORE_EMPTY);
}

static void test_store_delete_removes_in_every_state(void **state) {
    struct scratch *scratch = *state;
    char queued[ID_SIZE];
    struct store_job job;
    struct store_claim done = scratch_claimed(scratch, "done");
    assert_int_equal(scratch_commit(scratch, &done, "x", 1), STORE_OK);
    struct store_claim running = scratch_claimed(scratch, "running");
    scratch_submit(scratch, "queued", queued);
    const char *const ids[] = {done.id, running.id, queued};
    for (size_t k = 0; k < 3; k++) {
        assert_int_equal(store_delete(scratch->store, ids[k]), STORE_OK);
        assert_int_equal(store_get(scratch->store, ids[k], &job), STORE_EMPTY);
        assert_int_equal(store_delete(scratch->store, ids[k]), STORE_EMPTY);
    }
    assert_int_equal(store_renew(scratch->store, &running, 0.5), STORE_CONFLICT);
    assert_int_equal(scratch_commit(scratch, &running, "x", 1), STORE_CONFLICT);
    assert_int_equal(store_claim(scratch->store, &running), STORE_EMPTY);
}

/* ------------------------------------------------------------------ lists */

/* Reads all pages and returns how many jobs there were; checks that they descend. */
static size_t walk(struct scratch *scratch, struct store_filter filter) {
    size_t seen = 0;
    int64_t last = INT64_MAX;
    for (int pages = 0; pages < 100; pages++) {
        struct store_page page;
        assert_int_equal(store_list(scratch->store, &filter, &page), STORE_OK);
        assert_true(page.count <= (size_t)filter.limit);
        assert_true(page.next == 0 || page.count == (size_t)filter.limit);
        for (size_t k = 0; k < page.count; k++) {
            assert_true(page.jobs[k].sequence < last);
            assert_true(!filter.has_status || page.jobs[k].status == filter.status);
            assert_true(!filter.owner || !strcmp(page.jobs[k].owner, filter.owner));
            last = page.jobs[k].sequence;
        }
        seen += page.count;
        filter.cursor = page.next;
        store_page_clear(&page);
        if (filter.cursor == 0)
            return seen;
    }
    fail_msg("the pages do not end");
    return 0;
}

static void test_store_list_pages_newest_first(void **state) {
    struct scratch *scratch = *state;
    char id[ID_SIZE];
    char body[32];
    assert_int_equal(walk(scratch, (struct store_filter){.limit = 10}), 0);
    for (int k = 0; k < 30; k++) {
        snprintf(body, sizeof body, "body %d", k);
        scratch_submit(scratch, body, id);
        if (k % 3 == 0)
            assert_int_equal(store_cancel(scratch->store, id), STORE_OK);
    }
    struct store_receipt receipt;
    assert_int_equal(submit_key(scratch, "anna", NULL, "hers", &receipt), STORE_OK);
    assert_int_equal(walk(scratch, (struct store_filter){.limit = 1}), 31);
    assert_int_equal(walk(scratch, (struct store_filter){.limit = 10}), 31);
    assert_int_equal(walk(scratch, (struct store_filter){.limit = 1000}), 31);
    assert_int_equal(walk(scratch, (struct store_filter){.limit = 7, .owner = "anna"}), 1);
    assert_int_equal(walk(scratch, (struct store_filter){.limit = 5, .owner = ""}), 30);
    struct store_filter cancelled = {.limit = 5, .has_status = true, .status = STORE_CANCELLED};
    assert_int_equal(walk(scratch, cancelled), 10);
    cancelled.owner = "anna";
    assert_int_equal(walk(scratch, cancelled), 0);
}

static void test_store_list_is_not_shifted_by_new_jobs(void **state) {
    struct scratch *scratch = *state;
    char ids[4][ID_SIZE];
    char id[ID_SIZE];
    struct store_page page;
    static const char *const bodies[] = {"a", "b", "c", "d"};
    for (int k = 0; k < 4; k++)
        scratch_submit(scratch, bodies[k], ids[k]);
    struct store_filter filter = {.limit = 2};
    assert_int_equal(store_list(scratch->store, &filter, &page), STORE_OK);
    assert_string_equal(page.jobs[1].id, ids[2]);
    filter.cursor = page.next;
    store_page_clear(&page);
    scratch_submit(scratch, "e", id);
    assert_int_equal(store_list(scratch->store, &filter, &page), STORE_OK);
    assert_int_equal(page.count, 2);
    assert_string_equal(page.jobs[0].id, ids[1]);
    assert_string_equal(page.jobs[1].id, ids[0]);
    assert_int_equal(page.next, 0);
    store_page_clear(&page);
}

/* The cursor of the second page of the owner, who has three jobs. */
static int64_t second_page(struct scratch *scratch, const char *owner, int64_t *position) {
    struct store_page page;
    const struct store_filter filter = {.limit = 1, .owner = owner};
    assert_int_equal(store_list(scratch->store, &filter, &page), STORE_OK);
    assert_int_equal(page.count, 1);
    int64_t next = page.next;
    *position = page.jobs[0].sequence;
    store_page_clear(&page);
    return next;
}

/* From a cursor nobody can tell where in the list of all it is, nor by two of them how many came
 * between; it means the same after a restart. */
static void test_store_list_cursors_tell_nothing(void **state) {
    struct scratch *scratch = *state;
    struct store_receipt receipt;
    struct store_page page;
    int64_t at[2], position;
    for (int k = 0; k < 6; k++)
        assert_int_equal(
            submit_key(scratch, k % 2 ? "eve" : "anna", NULL, k % 2 ? "e" : "a", &receipt),
            STORE_OK);
    int64_t anna = second_page(scratch, "anna", &at[0]), eve = second_page(scratch, "eve", &at[1]);
    assert_int_equal(at[1], at[0] + 1);
    assert_true(llabs(anna - eve) > 1000000 && anna > 1000000 && eve > 1000000);
    assert_true(second_page(scratch, NULL, &position) != eve);
    assert_int_equal(second_page(scratch, "anna", &position), anna);
    scratch_stop(scratch);
    scratch_start(scratch);
    const struct store_filter filter = {.limit = 5, .owner = "anna", .cursor = anna};
    assert_int_equal(store_list(scratch->store, &filter, &page), STORE_OK);
    assert_int_equal(page.count, 2);
    assert_true(page.jobs[0].sequence == at[0] - 2);
    store_page_clear(&page);
}

static void test_store_counts_follow_every_change(void **state) {
    struct scratch *scratch = *state;
    struct store_counts counts;
    char id[ID_SIZE];
    struct store_claim done = scratch_claimed(scratch, "a");
    assert_int_equal(scratch_commit(scratch, &done, "x", 1), STORE_OK);
    struct store_claim failed = scratch_claimed(scratch, "b");
    assert_int_equal(store_fail(scratch->store, &failed, "{}"), STORE_OK);
    struct store_claim running = scratch_claimed(scratch, "c");
    (void)running;
    scratch_submit(scratch, "d", id);
    assert_int_equal(store_cancel(scratch->store, id), STORE_OK);
    scratch_now += 1000;
    int64_t oldest = scratch_now;
    scratch_submit(scratch, "e", id);
    scratch_now += 1000;
    struct store_submission urgent = {
        .request = "f", .request_length = 1, .digest = "f", .priority = 9};
    struct store_receipt receipt;
    assert_int_equal(store_submit(scratch->store, &urgent, &receipt), STORE_OK);
    assert_int_equal(store_counts(scratch->store, &counts), STORE_OK);
    assert_int_equal(counts.jobs[STORE_QUEUED], 2);
    assert_int_equal(counts.jobs[STORE_RUNNING], 1);
    assert_int_equal(counts.jobs[STORE_SUCCEEDED], 1);
    assert_int_equal(counts.jobs[STORE_FAILED], 1);
    assert_int_equal(counts.jobs[STORE_CANCELLED], 1);
    assert_true(counts.oldest_queued == oldest);
}

/* ------------------------------------------------------------------ surfaces */

static enum store_answer put_for(struct scratch *scratch, const char *owner, const char *id,
                                 char *definition, bool *created) {
    static char description[] = "{\"area\":1}";
    struct store_item surface = {.definition = definition,
                                 .definition_length = strlen(definition),
                                 .description = description};
    snprintf(surface.id, sizeof surface.id, "%s", id);
    snprintf(surface.owner, sizeof surface.owner, "%s", owner);
    return store_item_put(scratch->store, STORE_SURFACES, &surface, created);
}

static enum store_answer put(struct scratch *scratch, const char *id, char *definition,
                             bool *created) {
    return put_for(scratch, "", id, definition, created);
}

static void test_store_surface_is_stored_once(void **state) {
    struct scratch *scratch = *state;
    struct store_item surface;
    char first[] = "{\"degree\":2}";
    char other[] = "{\"degree\":3}";
    bool created = false;
    assert_int_equal(store_item_get(scratch->store, STORE_SURFACES, NULL, "s", &surface),
                     STORE_EMPTY);
    store_item_clear(&surface);
    assert_int_equal(put(scratch, "s", first, &created), STORE_OK);
    assert_true(created);
    assert_int_equal(put(scratch, "s", other, &created), STORE_OK);
    assert_false(created);
    assert_int_equal(store_item_get(scratch->store, STORE_SURFACES, NULL, "s", &surface), STORE_OK);
    assert_string_equal(surface.definition, first);
    assert_int_equal(surface.definition_length, strlen(first));
    assert_string_equal(surface.description, "{\"area\":1}");
    assert_true(surface.created == scratch_now);
    store_item_clear(&surface);
}

/* A form is read and changed by itself, counts as bytes of its owner, and goes with the surface. */
static void test_store_surface_has_a_form(void **state) {
    struct scratch *scratch = *state;
    char definition[] = "{\"degree\":2}", form[] = "0123\0456789", *got = NULL;
    const int64_t bytes = (int64_t)strlen(definition);
    struct store_item surface = {.id = "s",
                                 .owner = "anna",
                                 .definition = definition,
                                 .definition_length = strlen(definition),
                                 .description = definition,
                                 .form = form,
                                 .form_length = sizeof form};
    size_t length = 0;
    bool created = false;
    assert_int_equal(store_form_get(scratch->store, NULL, "s", NULL, NULL), STORE_EMPTY);
    assert_int_equal(store_form_put(scratch->store, NULL, "s", form, 3), STORE_EMPTY);
    assert_int_equal(store_item_put(scratch->store, STORE_SURFACES, &surface, &created), STORE_OK);
    expect_usage(scratch, "anna", 0, 0, bytes + (int64_t)sizeof form);
    assert_int_equal(store_form_get(scratch->store, "bert", "s", NULL, NULL), STORE_EMPTY);
    assert_int_equal(store_form_get(scratch->store, "anna", "s", &got, &length), STORE_OK);
    assert_int_equal(length, sizeof form);
    assert_memory_equal(got, form, sizeof form);
    free(got);
    assert_int_equal(store_form_put(scratch->store, "bert", "s", form, 3), STORE_EMPTY);
    assert_int_equal(store_form_put(scratch->store, "anna", "s", form, 3), STORE_OK);
    expect_usage(scratch, "anna", 0, 0, bytes + 3);
    assert_int_equal(store_form_get(scratch->store, NULL, "s", &got, &length), STORE_OK);
    assert_int_equal(length, 3);
    free(got);
    assert_int_equal(store_item_delete(scratch->store, STORE_SURFACES, "anna", "s"), STORE_OK);
    expect_usage(scratch, "anna", 0, 0, 0);
    assert_int_equal(store_form_get(scratch->store, "anna", "s", NULL, NULL), STORE_EMPTY);
}

static void test_store_surface_list_pages(void **state) {
    struct scratch *scratch = *state;
    struct store_items page;
    char definition[] = "{}";
    char id[16];
    bool created = false;
    for (int k = 0; k < 5; k++) {
        snprintf(id, sizeof id, "s%d", k);
        assert_int_equal(put(scratch, id, definition, &created), STORE_OK);
    }
    int64_t cursor = 0;
    for (int seen = 0; seen < 5;) {
        assert_int_equal(store_item_list(scratch->store, STORE_SURFACES, NULL, cursor, 2, &page),
                         STORE_OK);
        for (size_t k = 0; k < page.count; k++, seen++) {
            snprintf(id, sizeof id, "s%d", 4 - seen);
            assert_string_equal(page.items[k].id, id);
            assert_null(page.items[k].definition);
        }
        cursor = page.next;
        assert_true((cursor == 0) == (seen == 5));
        store_items_clear(&page);
    }
    assert_int_equal(store_item_list(scratch->store, STORE_SURFACES, "anna", 0, 2, &page),
                     STORE_OK);
    assert_int_equal(page.count, 0);
    store_items_clear(&page);
}

static void test_store_surface_in_use_stays(void **state) {
    struct scratch *scratch = *state;
    char definition[] = "{}";
    bool created = false;
    struct store_claim claim;
    struct store_receipt receipt;
    struct store_submission submission = {
        .request = "x", .request_length = 1, .digest = "x", .surface = "s"};
    assert_int_equal(store_submit(scratch->store, &submission, &receipt), STORE_EMPTY);
    assert_int_equal(put(scratch, "s", definition, &created), STORE_OK);
    assert_int_equal(store_submit(scratch->store, &submission, &receipt), STORE_OK);
    assert_int_equal(store_item_delete(scratch->store, STORE_SURFACES, NULL, "s"), STORE_CONFLICT);
    assert_int_equal(store_claim(scratch->store, &claim), STORE_OK);
    assert_string_equal(claim.surface, "s");
    assert_int_equal(store_item_delete(scratch->store, STORE_SURFACES, NULL, "s"), STORE_CONFLICT);
    assert_int_equal(scratch_commit(scratch, &claim, "x", 1), STORE_OK);
    assert_int_equal(store_item_delete(scratch->store, STORE_SURFACES, NULL, "s"), STORE_OK);
    assert_int_equal(store_item_delete(scratch->store, STORE_SURFACES, NULL, "s"), STORE_EMPTY);
}

static enum store_answer get_of(struct scratch *scratch, const char *owner) {
    struct store_item surface;
    enum store_answer answer = store_item_get(scratch->store, STORE_SURFACES, owner, "s", &surface);
    if (answer == STORE_OK && owner)
        assert_string_equal(surface.owner, owner);
    store_item_clear(&surface);
    return answer;
}

/* Two who store the same surface have one each. */
static void test_store_surface_of_two_owners(void **state) {
    struct scratch *scratch = *state;
    struct store_items page;
    char definition[] = "{}";
    bool created = false;
    assert_int_equal(put_for(scratch, "anna", "s", definition, &created), STORE_OK);
    assert_true(created);
    assert_int_equal(get_of(scratch, "bert"), STORE_EMPTY);
    assert_int_equal(store_item_delete(scratch->store, STORE_SURFACES, "bert", "s"), STORE_EMPTY);
    assert_int_equal(put_for(scratch, "bert", "s", definition, &created), STORE_OK);
    assert_true(created);
    assert_int_equal(put_for(scratch, "bert", "s", definition, &created), STORE_OK);
    assert_false(created);
    assert_int_equal(store_item_delete(scratch->store, STORE_SURFACES, "anna", "s"), STORE_OK);
    assert_int_equal(get_of(scratch, "anna"), STORE_EMPTY);
    assert_int_equal(get_of(scratch, "bert"), STORE_OK);
    assert_int_equal(get_of(scratch, NULL), STORE_OK);
    assert_int_equal(store_item_list(scratch->store, STORE_SURFACES, "bert", 0, 9, &page),
                     STORE_OK);
    assert_int_equal(page.count, 1);
    store_items_clear(&page);
    assert_int_equal(put_for(scratch, "anna", "s", definition, &created), STORE_OK);
    assert_int_equal(store_item_list(scratch->store, STORE_SURFACES, NULL, 0, 9, &page), STORE_OK);
    assert_int_equal(page.count, 2);
    store_items_clear(&page);
    assert_int_equal(store_item_delete(scratch->store, STORE_SURFACES, NULL, "s"), STORE_OK);
    assert_int_equal(get_of(scratch, NULL), STORE_EMPTY);
}

/* Materials are items of their own kind, are the owner's bytes, and no job keeps them. */
static void test_store_materials_are_kept_apart(void **state) {
    struct scratch *scratch = *state;
    struct store_items page;
    struct store_usage before, usage;
    struct store_item found;
    char surface[] = "{}", definition[] = "{\"name\":\"s\"}";
    char description[] = "{\"about\":1}";
    bool created = false;
    struct store_item item = {.id = "s",
                              .owner = "anna",
                              .definition = definition,
                              .definition_length = strlen(definition),
                              .description = description};
    assert_int_equal(put_for(scratch, "anna", "s", surface, &created), STORE_OK);
    assert_int_equal(store_usage(scratch->store, "anna", &before), STORE_OK);
    for (int again = 0; again < 2; again++) {
        assert_int_equal(store_item_put(scratch->store, STORE_MATERIALS, &item, &created),
                         STORE_OK);
        assert_int_equal(created, !again);
    }
    assert_int_equal(store_usage(scratch->store, "anna", &usage), STORE_OK);
    assert_int_equal(usage.bytes - before.bytes, strlen(definition));
    assert_int_equal(store_item_get(scratch->store, STORE_MATERIALS, "anna", "s", &found),
                     STORE_OK);
    assert_string_equal(found.definition, definition);
    assert_string_equal(found.description, description);
    store_item_clear(&found);
    assert_int_equal(store_item_get(scratch->store, STORE_MATERIALS, "bert", "s", &found),
                     STORE_EMPTY);
    assert_int_equal(store_item_list(scratch->store, STORE_MATERIALS, NULL, 0, 9, &page), STORE_OK);
    assert_int_equal(page.count, 1);
    assert_string_equal(page.items[0].description, description);
    store_items_clear(&page);
    struct store_submission submission = {
        .request = "x", .request_length = 1, .digest = "x", .surface = "s", .owner = "anna"};
    struct store_receipt receipt;
    assert_int_equal(store_submit(scratch->store, &submission, &receipt), STORE_OK);
    assert_int_equal(store_item_delete(scratch->store, STORE_MATERIALS, "bert", "s"), STORE_EMPTY);
    assert_int_equal(store_item_delete(scratch->store, STORE_MATERIALS, "anna", "s"), STORE_OK);
    assert_int_equal(store_item_delete(scratch->store, STORE_MATERIALS, "anna", "s"), STORE_EMPTY);
    assert_int_equal(store_item_delete(scratch->store, STORE_SURFACES, "anna", "s"),
                     STORE_CONFLICT);
    assert_int_equal(store_usage(scratch->store, "anna", &usage), STORE_OK);
    assert_int_equal(usage.bytes - before.bytes, 1);
}

/* A job keeps the surface of its owner, and the last one whoever has it. */
static void test_store_surface_that_owners_jobs_need(void **state) {
    struct scratch *scratch = *state;
    char definition[] = "{}";
    bool created = false;
    struct store_receipt receipt;
    struct store_submission submission = {
        .request = "x", .request_length = 1, .digest = "x", .surface = "s", .owner = "anna"};
    assert_int_equal(put_for(scratch, "anna", "s", definition, &created), STORE_OK);
    assert_int_equal(put_for(scratch, "bert", "s", definition, &created), STORE_OK);
    assert_int_equal(store_submit(scratch->store, &submission, &receipt), STORE_OK);
    assert_int_equal(store_item_delete(scratch->store, STORE_SURFACES, "anna", "s"),
                     STORE_CONFLICT);
    assert_int_equal(store_item_delete(scratch->store, STORE_SURFACES, NULL, "s"), STORE_CONFLICT);
    assert_int_equal(store_item_delete(scratch->store, STORE_SURFACES, "bert", "s"), STORE_OK);
    assert_int_equal(store_delete(scratch->store, receipt.id), STORE_OK);
    submission.owner = "the administrator";
    assert_int_equal(store_submit(scratch->store, &submission, &receipt), STORE_OK);
    assert_int_equal(store_item_delete(scratch->store, STORE_SURFACES, "anna", "s"),
                     STORE_CONFLICT);
    assert_int_equal(store_cancel(scratch->store, receipt.id), STORE_OK);
    assert_int_equal(store_item_delete(scratch->store, STORE_SURFACES, "anna", "s"), STORE_OK);
}

/* ------------------------------------------------------------------ job events */

static void count_call(void *context) {
    ++*(int *)context;
}

static void test_store_tells_the_hub_of_every_change(void **state) {
    struct scratch *scratch = *state;
    struct job_watch queue, job, ends;
    int queued = 0, changes = 0, news = 0;
    char id[ID_SIZE];
    struct store_claim claim;
    job_events_subscribe(scratch->events, &queue, job_events_queue, JOB_CHANGED, count_call,
                         &queued);
    scratch_submit(scratch, "a", id);
    assert_int_equal(queued, 1);
    job_events_subscribe(scratch->events, &job, id, JOB_PROGRESSED, count_call, &changes);
    job_events_subscribe(scratch->events, &ends, id, JOB_CHANGED, count_call, &news);
    assert_int_equal(store_claim(scratch->store, &claim), STORE_OK);
    assert_int_equal(changes, 1);
    assert_int_equal(store_renew(scratch->store, &claim, 0.5), STORE_OK);
    assert_int_equal(changes, 2);
    assert_int_equal(news, 0);
    assert_int_equal(store_release(scratch->store, &claim), STORE_OK);
    assert_int_equal(changes, 3);
    assert_int_equal(queued, 2);
    assert_int_equal(store_cancel(scratch->store, id), STORE_OK);
    assert_int_equal(changes, 4);
    assert_int_equal(store_cancel(scratch->store, id), STORE_CONFLICT);
    assert_int_equal(changes, 4);
    assert_int_equal(news, 2);
    job_events_unsubscribe(scratch->events, &ends);
    job_events_unsubscribe(scratch->events, &job);
    job_events_unsubscribe(scratch->events, &queue);
}

static void test_store_status_names_read_back(void **state) {
    (void)state;
    enum store_status status = STORE_QUEUED;
    for (int k = 0; k < STORE_STATUS_COUNT; k++) {
        assert_true(store_status_from_name(store_status_name((enum store_status)k), &status));
        assert_int_equal(status, k);
        assert_int_equal(store_status_ended(status), k >= STORE_SUCCEEDED);
    }
    assert_false(store_status_from_name("done", &status));
}

#define WITH_STORE(name) cmocka_unit_test_setup_teardown(name, scratch_set_up, scratch_tear_down)

int main(void) {
    const struct CMUnitTest tests[] = {
        WITH_STORE(test_store_submit_is_found_again),
        WITH_STORE(test_store_unknown_job_is_empty),
        WITH_STORE(test_store_submit_beyond_the_limit_is_full),
        WITH_STORE(test_store_quota_of_queued_jobs_is_the_owners),
        WITH_STORE(test_store_queue_leaves_a_place_for_who_comes),
        WITH_STORE(test_store_quota_of_bytes_counts_all_that_is_stored),
        WITH_STORE(test_store_owner_without_anything_is_forgotten),
        WITH_STORE(test_store_key_gives_the_same_job),
        WITH_STORE(test_store_key_with_another_body_is_a_conflict),
        WITH_STORE(test_store_cancel_ends_once),
        WITH_STORE(test_store_delete_removes_in_every_state),
        WITH_STORE(test_store_list_pages_newest_first),
        WITH_STORE(test_store_list_is_not_shifted_by_new_jobs),
        WITH_STORE(test_store_list_cursors_tell_nothing),
        WITH_STORE(test_store_counts_follow_every_change),
        WITH_STORE(test_store_surface_is_stored_once),
        WITH_STORE(test_store_surface_has_a_form),
        WITH_STORE(test_store_surface_list_pages),
        WITH_STORE(test_store_surface_in_use_stays),
        WITH_STORE(test_store_surface_of_two_owners),
        WITH_STORE(test_store_surface_that_owners_jobs_need),
        WITH_STORE(test_store_materials_are_kept_apart),
        WITH_STORE(test_store_tells_the_hub_of_every_change),
        cmocka_unit_test(test_store_status_names_read_back),
    };
    return scratch_run("store", tests, NULL, 0);
}
