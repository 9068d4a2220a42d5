/* SPDX-License-Identifier: MIT */
/* Claims: their order, leases, fencing, attempts, and what becomes of them in a restart. */
#include "scratch.h"
#include "server/store/backend.h"
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>
#include <unistd.h>

static const int64_t second = 1000000;

static int attempts_of(struct scratch *scratch, const char *id) {
    struct store_job job;
    assert_int_equal(store_get(scratch->store, id, &job), STORE_OK);
    store_job_clear(&job);
    return job.attempts;
}

/* ------------------------------------------------------------------ order */

static void test_store_claim_takes_the_oldest_first(void **state) {
    struct scratch *scratch = *state;
    struct store_claim claim;
    char ids[3][ID_SIZE];
    static const char *const bodies[] = {"a", "b", "c"};
    assert_int_equal(store_claim(scratch->store, &claim), STORE_EMPTY);
    for (int k = 0; k < 3; k++)
        scratch_submit(scratch, bodies[k], ids[k]);
    for (int k = 0; k < 3; k++) {
        scratch_now += 5 * second;
        assert_int_equal(store_claim(scratch->store, &claim), STORE_OK);
        assert_string_equal(claim.id, ids[k]);
        assert_in_range(claim.waited_us, 5 * (k + 1) * second, (5 * (k + 1) + 4) * second);
        assert_int_equal(claim.attempts, 1);
        assert_false(claim.reused);
        assert_int_equal(scratch_status(scratch, ids[k]), STORE_RUNNING);
    }
    assert_int_equal(store_claim(scratch->store, &claim), STORE_EMPTY);
}

static void submit_priority(struct scratch *scratch, const char *body, int priority) {
    struct store_receipt receipt;
    struct store_submission submission = {
        .request = body, .request_length = 1, .digest = body, .priority = priority};
    assert_int_equal(store_submit(scratch->store, &submission, &receipt), STORE_OK);
}

static void expect_order(struct scratch *scratch, const char *bodies) {
    struct store_claim claim;
    for (; *bodies; bodies++) {
        char *request = NULL;
        size_t length = 0;
        assert_int_equal(store_claim(scratch->store, &claim), STORE_OK);
        assert_int_equal(store_request(scratch->store, claim.id, &request, &length), STORE_OK);
        assert_int_equal(request[0], *bodies);
        free(request);
    }
}

static void test_store_priority_is_worth_a_minute_a_step(void **state) {
    struct scratch *scratch = *state;
    submit_priority(scratch, "a", 0);
    scratch_now += 30 * second;
    submit_priority(scratch, "b", 1); /* as if 30 s older than a */
    submit_priority(scratch, "c", -1);
    scratch_now += 90 * second;
    submit_priority(scratch, "d", 0); /* as if 30 s younger than c */
    expect_order(scratch, "bacd");
}

static void test_store_release_returns_to_the_old_place(void **state) {
    struct scratch *scratch = *state;
    struct store_claim claim = scratch_claimed(scratch, "a");
    char id[ID_SIZE];
    scratch_now += second;
    scratch_submit(scratch, "b", id);
    assert_int_equal(store_release(scratch->store, &claim), STORE_OK);
    assert_int_equal(scratch_status(scratch, claim.id), STORE_QUEUED);
    expect_order(scratch, "ab");
}

/* ------------------------------------------------------------------ with the end of another */

/* Ends the job and claims the next, there or by itself; the answer is that of the end. */
static enum store_answer end_and_claim(struct scratch *scratch, const struct store_claim *claim,
                                       struct store_claim *next) {
    memset(next, -1, sizeof *next);
    enum store_answer answer = scratch_commit_and_claim(scratch, claim, "end", 3, next);
    if (scratch->remote) /* by itself */
        assert_int_equal(next->sequence, 0);
    if (scratch->remote && answer == STORE_OK)
        assert_in_range(store_claim(scratch->store, next), STORE_OK, STORE_EMPTY);
    return answer;
}

static void test_store_end_claims_the_next_and_all_of_its_twins(void **state) {
    struct scratch *scratch = *state;
    struct store_claim first = scratch_claimed(scratch, "a"), second_claim, twin, none;
    char ids[2][ID_SIZE];
    scratch_submit(scratch, "b", ids[0]);
    scratch_submit(scratch, "b", ids[1]);
    assert_int_equal(end_and_claim(scratch, &first, &second_claim), STORE_OK);
    assert_int_equal(scratch_status(scratch, first.id), STORE_SUCCEEDED);
    assert_string_equal(second_claim.id, ids[0]);
    assert_int_equal(second_claim.attempts, 1);
    assert_false(second_claim.reused);
    assert_int_equal(scratch_status(scratch, ids[0]), STORE_RUNNING);
    assert_int_equal(scratch_status(scratch, ids[1]), STORE_QUEUED);
    assert_int_equal(end_and_claim(scratch, &second_claim, &twin), STORE_OK);
    assert_string_equal(twin.id, ids[1]);
    assert_true(twin.reused);
    assert_int_equal(scratch_status(scratch, ids[1]), STORE_SUCCEEDED);
    struct store_claim last = scratch_claimed(scratch, "c");
    assert_int_equal(end_and_claim(scratch, &last, &none), STORE_OK);
    assert_int_equal(none.sequence, 0);
}

static void test_store_end_under_a_lost_claim_claims_nothing(void **state) {
    struct scratch *scratch = *state;
    struct store_claim claim = scratch_claimed(scratch, "a"), next;
    char id[ID_SIZE];
    scratch_submit(scratch, "b", id);
    assert_int_equal(store_cancel(scratch->store, claim.id), STORE_OK);
    assert_int_equal(end_and_claim(scratch, &claim, &next), STORE_CONFLICT);
    assert_int_equal(next.sequence, 0);
    assert_int_equal(scratch_status(scratch, id), STORE_QUEUED);
    assert_int_equal(attempts_of(scratch, id), 0);
}

/* Neither when the claim is lost between the first bytes stored of the result and its end. */
static void test_store_end_of_a_result_begun_before_claims_nothing(void **state) {
    struct scratch *scratch = *state;
    struct store_claim claim = scratch_claimed(scratch, "a"), next = {.sequence = 0};
    static const char bytes[2 * STORE_SEGMENT_BYTES];
    char id[ID_SIZE];
    scratch_submit(scratch, "b", id);
    struct store_writer *writer = store_writer_new(scratch->store, &claim);
    assert_int_equal(store_writer_append(writer, bytes, sizeof bytes), STORE_OK);
    assert_int_equal(store_cancel(scratch->store, claim.id), STORE_OK);
    assert_int_equal(store_writer_commit_and_claim(writer, "{}", &next), STORE_CONFLICT);
    store_writer_free(writer);
    assert_int_equal(next.sequence, 0);
    assert_int_equal(scratch_status(scratch, id), STORE_QUEUED);
}

/* ------------------------------------------------------------------ leases and fencing */

static void test_store_renew_keeps_the_progress_from_going_back(void **state) {
    struct scratch *scratch = *state;
    struct store_claim claim = scratch_claimed(scratch, "a");
    static const double told[] = {0.25, 0.5, 0.1};
    static const double kept[] = {0.25, 0.5, 0.5};
    for (int k = 0; k < 3; k++) {
        struct store_job job;
        assert_int_equal(store_renew(scratch->store, &claim, told[k]), STORE_OK);
        assert_int_equal(store_get(scratch->store, claim.id, &job), STORE_OK);
        assert_true(job.progress == kept[k]);
        store_job_clear(&job);
    }
}

/* Every act under a claim that is lost. */
static void expect_lost(struct scratch *scratch, const struct store_claim *claim) {
    assert_int_equal(store_check(scratch->store, claim), STORE_CONFLICT);
    assert_int_equal(store_renew(scratch->store, claim, 0.9), STORE_CONFLICT);
    assert_int_equal(store_fail(scratch->store, claim, "{}"), STORE_CONFLICT);
    assert_int_equal(store_crashed(scratch->store, claim, "x"), STORE_CONFLICT);
    assert_int_equal(store_release(scratch->store, claim), STORE_CONFLICT);
    assert_int_equal(scratch_commit(scratch, claim, "stale", 5), STORE_CONFLICT);
}

static void test_store_lease_holds_while_it_is_renewed(void **state) {
    struct scratch *scratch = *state;
    struct store_claim claim = scratch_claimed(scratch, "a");
    for (int k = 0; k < 10; k++) {
        scratch_now += 59 * second;
        assert_int_equal(scratch_sweep(scratch).requeued, 0);
        assert_int_equal(store_renew(scratch->store, &claim, 0), STORE_OK);
    }
    scratch_now += 61 * second;
    assert_int_equal(scratch_sweep(scratch).requeued, 1);
    expect_lost(scratch, &claim);
}

static void test_store_stale_claim_is_refused(void **state) {
    struct scratch *scratch = *state;
    struct store_claim stale = scratch_claimed(scratch, "a");
    struct store_claim fresh;
    struct store_result result;
    scratch_now += 61 * second;
    assert_int_equal(scratch_sweep(scratch).requeued, 1);
    assert_int_equal(store_claim(scratch->store, &fresh), STORE_OK);
    assert_string_equal(fresh.id, stale.id);
    assert_true(fresh.token > stale.token);
    assert_int_equal(fresh.attempts, 2);
    expect_lost(scratch, &stale);
    assert_int_equal(store_check(scratch->store, &fresh), STORE_OK);
    assert_int_equal(scratch_commit(scratch, &fresh, "fresh", 5), STORE_OK);
    expect_lost(scratch, &stale);
    assert_int_equal(store_result_find(scratch->store, fresh.id, &result), STORE_OK);
    scratch_expect_result(scratch, fresh.id, "fresh", 5, 5);
}

/* With the result of its digest there already nothing is written but the end of the job. */
static void test_store_stale_claim_does_not_end_by_a_twin(void **state) {
    struct scratch *scratch = *state;
    struct store_claim stale = scratch_claimed(scratch, "a"), twin, fresh;
    char id[ID_SIZE];
    scratch_submit(scratch, "a", id);
    assert_int_equal(store_claim(scratch->store, &twin), STORE_OK);
    scratch_now += 40 * second;
    assert_int_equal(store_renew(scratch->store, &twin, 0), STORE_OK);
    scratch_now += 21 * second;
    assert_int_equal(scratch_sweep(scratch).requeued, 1);
    assert_int_equal(store_claim(scratch->store, &fresh), STORE_OK);
    assert_string_equal(fresh.id, stale.id);
    assert_int_equal(scratch_commit(scratch, &twin, "twin", 4), STORE_OK);
    expect_lost(scratch, &stale);
    assert_int_equal(store_check(scratch->store, &fresh), STORE_OK);
}

static void test_store_claim_is_lost_by_cancel_and_end(void **state) {
    struct scratch *scratch = *state;
    struct store_claim claim = scratch_claimed(scratch, "a");
    assert_int_equal(store_cancel(scratch->store, claim.id), STORE_OK);
    expect_lost(scratch, &claim);
    claim = scratch_claimed(scratch, "b");
    assert_int_equal(store_fail(scratch->store, &claim, "{\"x\":1}"), STORE_OK);
    expect_lost(scratch, &claim);
    struct store_job job;
    assert_int_equal(store_get(scratch->store, claim.id, &job), STORE_OK);
    assert_string_equal(job.error, "{\"x\":1}");
    store_job_clear(&job);
}

/* ------------------------------------------------------------------ clocks that are set */

/* By an hour, forward or back: the holder is alive and goes on renewing. */
static void expect_kept_through_jump(struct scratch *scratch, int64_t jump) {
    struct store_claim claim = scratch_claimed(scratch, jump > 0 ? "forward" : "back");
    scratch_sweep(scratch);
    scratch_now += second;
    scratch_jump += jump;
    for (int k = 0; k < 300; k++) {
        struct store_sweep sweep = scratch_sweep(scratch);
        assert_int_equal(sweep.requeued + sweep.failed, 0);
        scratch_now += second;
        if (k % 15 == 0)
            assert_int_equal(store_renew(scratch->store, &claim, 0), STORE_OK);
    }
    assert_int_equal(scratch_commit(scratch, &claim, "r", 1), STORE_OK);
}

static void test_store_clock_set_takes_no_job_from_its_holder(void **state) {
    expect_kept_through_jump(*state, 3600 * second);
    expect_kept_through_jump(*state, -3600 * second);
}

static void expect_ends_in_spite_of_jump(struct scratch *scratch, int64_t jump) {
    struct store_claim claim = scratch_claimed(scratch, jump > 0 ? "forward" : "back");
    scratch_sweep(scratch);
    scratch_now += second;
    scratch_jump += jump;
    int requeued = 0;
    for (int k = 0; k < 130 && !requeued; k++) {
        requeued = scratch_sweep(scratch).requeued;
        scratch_now += second;
    }
    assert_int_equal(requeued, 1);
    assert_int_equal(store_cancel(scratch->store, claim.id), STORE_OK);
}

/* It does not hide for ever that a holder is dead. */
static void test_store_lease_ends_after_the_clock_was_set(void **state) {
    expect_ends_in_spite_of_jump(*state, 3600 * second);
    expect_ends_in_spite_of_jump(*state, -3600 * second);
}

/* ------------------------------------------------------------------ attempts */

static void expect_crashed(struct scratch *scratch, const char *id, const char *detail) {
    struct store_job job;
    assert_int_equal(store_get(scratch->store, id, &job), STORE_OK);
    assert_int_equal(job.status, STORE_FAILED);
    assert_non_null(strstr(job.error, "/problems/solver-crashed"));
    assert_non_null(strstr(job.error, detail));
    store_job_clear(&job);
}

static void test_store_third_crash_fails_the_job(void **state) {
    struct scratch *scratch = *state;
    char id[ID_SIZE];
    struct store_claim claim;
    scratch_submit(scratch, "a", id);
    for (int k = 1; k <= 3; k++) {
        assert_int_equal(store_claim(scratch->store, &claim), STORE_OK);
        assert_int_equal(claim.attempts, k);
        assert_int_equal(store_crashed(scratch->store, &claim, "signal 11"), STORE_OK);
        assert_int_equal(scratch_status(scratch, id), k < 3 ? STORE_QUEUED : STORE_FAILED);
        assert_int_equal(attempts_of(scratch, id), k);
    }
    assert_int_equal(store_claim(scratch->store, &claim), STORE_EMPTY);
    expect_crashed(scratch, id, "signal 11");
    expect_crashed(scratch, id, "3 attempts");
}

static void test_store_third_lost_lease_fails_the_job(void **state) {
    struct scratch *scratch = *state;
    char id[ID_SIZE];
    struct store_claim claim;
    scratch_submit(scratch, "a", id);
    for (int k = 1; k <= 3; k++) {
        assert_int_equal(store_claim(scratch->store, &claim), STORE_OK);
        scratch_now += 61 * second;
        struct store_sweep sweep = scratch_sweep(scratch);
        assert_int_equal(sweep.requeued, k < 3);
        assert_int_equal(sweep.failed, k == 3);
    }
    expect_crashed(scratch, id, "lease");
}

static void test_store_release_is_not_held_against_the_job(void **state) {
    struct scratch *scratch = *state;
    char id[ID_SIZE];
    struct store_claim claim;
    scratch_submit(scratch, "a", id);
    for (int k = 1; k <= 5; k++) {
        assert_int_equal(store_claim(scratch->store, &claim), STORE_OK);
        assert_int_equal(claim.attempts, k);
        assert_int_equal(store_release(scratch->store, &claim), STORE_OK);
    }
    for (int k = 1; k <= 3; k++) {
        assert_int_equal(scratch_status(scratch, id), STORE_QUEUED);
        assert_int_equal(store_claim(scratch->store, &claim), STORE_OK);
        assert_int_equal(store_crashed(scratch->store, &claim, "x"), STORE_OK);
    }
    expect_crashed(scratch, id, "3 attempts");
    assert_int_equal(attempts_of(scratch, id), 8);
}

static void submit_of(struct scratch *scratch, const char *owner, const char *digest) {
    struct store_receipt receipt;
    const struct store_submission submission = {
        .request = "{}", .request_length = 2, .digest = digest, .owner = owner};
    assert_int_equal(store_submit(scratch->store, &submission, &receipt), STORE_OK);
}

/* A job that gave way takes its owner behind as many turns of others as a long one is worth. */
static void test_store_yield_lets_others_have_their_turns(void **state) {
    struct scratch *scratch = *state;
    struct store_claim claim;
    submit_of(scratch, "long", "long");
    assert_int_equal(store_claim(scratch->store, &claim), STORE_OK);
    assert_int_equal(store_yield(scratch->store, &claim), STORE_OK);
    assert_int_equal(store_yield(scratch->store, &claim), STORE_CONFLICT);
    submit_of(scratch, "long", "another");
    assert_int_equal(store_starving(scratch->store, false), STORE_OK);
    assert_int_equal(store_starving(scratch->store, true), STORE_EMPTY);
    assert_int_equal(store_claim_fresh(scratch->store, &claim), STORE_EMPTY);
    for (int k = 0; k < STORE_LATER_TURNS; k++) {
        submit_of(scratch, "small", "small");
        assert_int_equal(store_claim(scratch->store, &claim), STORE_OK);
        assert_string_equal(claim.owner, "small");
        assert_int_equal(store_fail(scratch->store, &claim, "{}"), STORE_OK);
    }
    submit_of(scratch, "small", "small");
    submit_of(scratch, "small", "small");
    int turns = 0; /* one or two later, by how the numbers of turns are given out */
    do {
        assert_int_equal(store_claim(scratch->store, &claim), STORE_OK);
        assert_int_equal(store_fail(scratch->store, &claim, "{}"), STORE_OK);
    } while (strcmp(claim.owner, "long") != 0 && ++turns);
    assert_in_range(turns, 0, 2);
}

/* ------------------------------------------------------------------ restarts */

/* Who shares a database with other machines cannot know that a process is gone: the lease ends. */
static void test_store_claim_of_a_process_that_is_gone_ends_with_its_lease(void **state) {
    struct scratch *scratch = *state;
    struct store_claim claim;
    struct store_claim old = scratch_claimed(scratch, "a");
    scratch_stop(scratch);
    scratch_start(scratch);
    scratch_now += 61 * second;
    assert_int_equal(scratch_sweep(scratch).requeued, 1);
    assert_int_equal(scratch_sweep(scratch).requeued, 0);
    assert_int_equal(store_claim(scratch->store, &claim), STORE_OK);
    assert_string_equal(claim.id, old.id);
    assert_int_equal(claim.attempts, 2);
    expect_lost(scratch, &old);
}

/* A store that is closed with jobs running looks to the next like one whose process was killed. */
static void test_store_restart_takes_up_interrupted_jobs_at_once(void **state) {
    struct scratch *scratch = *state;
    char id[ID_SIZE];
    struct store_claim old = scratch_claimed(scratch, "a");
    struct store_claim claim;
    scratch_submit(scratch, "b", id);
    scratch_stop(scratch);
    scratch_start(scratch);
    assert_int_equal(scratch_sweep(scratch).requeued, 1);
    assert_int_equal(store_claim(scratch->store, &claim), STORE_OK);
    assert_string_equal(claim.id, old.id);
    assert_int_equal(claim.attempts, 2);
    expect_lost(scratch, &old);
    assert_int_equal(store_claim(scratch->store, &claim), STORE_OK);
    assert_string_equal(claim.id, id);
}

/* Claims a job in a process of its own, which then waits to be killed. */
static pid_t claim_elsewhere(struct scratch *scratch) {
    int ends[2];
    char ready = 0;
    struct store_claim claim;
    assert_int_equal(pipe(ends), 0);
    pid_t pid = fork();
    assert_true(pid >= 0);
    if (pid == 0) {
        alarm(60);
        scratch_start(scratch);
        if (store_claim(scratch->store, &claim) == STORE_OK && write(ends[1], "r", 1) == 1)
            pause();
        _exit(1);
    }
    assert_int_equal(read(ends[0], &ready, 1), 1);
    close(ends[0]);
    close(ends[1]);
    return pid;
}

/* A process that shares the database is killed: the others see it at once, long before the lease
 * ends, and the job is not blamed. */
static void test_store_killed_process_is_noticed_before_its_lease_ends(void **state) {
    struct scratch *scratch = *state;
    char id[ID_SIZE];
    struct store_claim claim;
    scratch_submit(scratch, "a", id);
    scratch_stop(scratch);
    scratch->options.shared = true;
    scratch->options.max_attempts = 1;
    pid_t other = claim_elsewhere(scratch);
    scratch_start(scratch);
    assert_int_equal(scratch_sweep(scratch).requeued, 0);
    assert_int_equal(scratch_status(scratch, id), STORE_RUNNING);
    assert_int_equal(kill(other, SIGKILL), 0);
    assert_int_equal(waitpid(other, NULL, 0), other);
    assert_int_equal(scratch_sweep(scratch).requeued, 1);
    assert_int_equal(store_claim(scratch->store, &claim), STORE_OK);
    assert_int_equal(claim.attempts, 2);
}

/* The daemon is killed again and again: no fault of the job, up to a limit that keeps a job which
 * kills the daemon from doing so for ever. */
static void test_store_interruptions_are_forgiven_but_not_for_ever(void **state) {
    struct scratch *scratch = *state;
    char id[ID_SIZE];
    struct store_claim claim;
    scratch_submit(scratch, "a", id);
    int restarts = 0;
    for (; restarts < 50 && scratch_status(scratch, id) == STORE_QUEUED; restarts++) {
        assert_int_equal(store_claim(scratch->store, &claim), STORE_OK);
        scratch_stop(scratch);
        scratch_start(scratch);
        (void)scratch_sweep(scratch);
    }
    assert_int_equal(restarts, 23);
    expect_crashed(scratch, id, "the service itself died");
}

static void test_store_shared_leaves_the_claims_of_the_living(void **state) {
    struct scratch *scratch = *state;
    scratch_stop(scratch);
    scratch->options.shared = true;
    scratch_start(scratch);
    struct store_claim claim = scratch_claimed(scratch, "a");
    struct scratch other = *scratch;
    scratch_start(&other);
    assert_int_equal(scratch_sweep(&other).requeued, 0);
    assert_int_equal(store_check(other.store, &claim), STORE_OK);
    scratch_stop(scratch); /* now its claims are void */
    assert_int_equal(scratch_sweep(&other).requeued, 1);
    assert_int_equal(store_claim(other.store, &claim), STORE_OK);
    *scratch = other;
}

#define WITH_STORE(name) cmocka_unit_test_setup_teardown(name, scratch_set_up, scratch_tear_down)

int main(void) {
    const struct CMUnitTest tests[] = {
        WITH_STORE(test_store_claim_takes_the_oldest_first),
        WITH_STORE(test_store_priority_is_worth_a_minute_a_step),
        WITH_STORE(test_store_release_returns_to_the_old_place),
        WITH_STORE(test_store_end_claims_the_next_and_all_of_its_twins),
        WITH_STORE(test_store_end_under_a_lost_claim_claims_nothing),
        WITH_STORE(test_store_end_of_a_result_begun_before_claims_nothing),
        WITH_STORE(test_store_renew_keeps_the_progress_from_going_back),
        WITH_STORE(test_store_lease_holds_while_it_is_renewed),
        WITH_STORE(test_store_stale_claim_is_refused),
        WITH_STORE(test_store_stale_claim_does_not_end_by_a_twin),
        WITH_STORE(test_store_claim_is_lost_by_cancel_and_end),
        WITH_STORE(test_store_clock_set_takes_no_job_from_its_holder),
        WITH_STORE(test_store_lease_ends_after_the_clock_was_set),
        WITH_STORE(test_store_third_crash_fails_the_job),
        WITH_STORE(test_store_third_lost_lease_fails_the_job),
        WITH_STORE(test_store_release_is_not_held_against_the_job),
        WITH_STORE(test_store_yield_lets_others_have_their_turns),
        WITH_STORE(test_store_claim_of_a_process_that_is_gone_ends_with_its_lease),
    };
    const struct CMUnitTest only_sqlite[] = {
        WITH_STORE(test_store_restart_takes_up_interrupted_jobs_at_once),
        WITH_STORE(test_store_killed_process_is_noticed_before_its_lease_ends),
        WITH_STORE(test_store_interruptions_are_forgiven_but_not_for_ever),
        WITH_STORE(test_store_shared_leaves_the_claims_of_the_living),
    };
    return scratch_run("store claims", tests, only_sqlite,
                       sizeof only_sqlite / sizeof *only_sqlite);
}
