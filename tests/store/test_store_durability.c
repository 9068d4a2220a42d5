/* SPDX-License-Identifier: MIT */
/*
 * What is acknowledged stays: under kill -9, on a full disk, with a disk that cannot be
 * synchronised. The program has its own fdatasync, which the SQLite library calls: it counts, it
 * can be slow, and it can fail.
 */
#include "scratch.h"
#include <errno.h>
#include <poll.h>
#include <pthread.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

static atomic_int syncs;       /* since it was set to 0 */
static atomic_int sync_ms;     /* how long each takes at the least */
static atomic_bool sync_fails; /* EIO */

int fdatasync(int file) {
    atomic_fetch_add(&syncs, 1);
    if (atomic_load(&sync_ms) > 0)
        scratch_sleep(atomic_load(&sync_ms));
    if (atomic_load(&sync_fails)) {
        errno = EIO;
        return -1;
    }
    return (int)syscall(SYS_fdatasync, file);
}

int fsync(int file) {
    return fdatasync(file);
}

static int set_up(void **state) {
    struct scratch *scratch = malloc(sizeof *scratch);
    atomic_store(&sync_ms, 0);
    atomic_store(&sync_fails, false);
    scratch_open(scratch);
    *state = scratch;
    return 0;
}

/* ------------------------------------------------------------------ when the disk is waited for */

static void test_store_waits_for_the_disk_where_it_must(void **state) {
    struct scratch *scratch = *state;
    char id[ID_SIZE];
    struct store_claim claim;
    atomic_store(&syncs, 0);
    scratch_submit(scratch, "a", id);
    assert_int_equal(atomic_exchange(&syncs, 0), 1);
    assert_int_equal(store_claim(scratch->store, &claim), STORE_OK);
    assert_int_equal(store_renew(scratch->store, &claim, 0.5), STORE_OK);
    assert_int_equal(atomic_exchange(&syncs, 0), 0); /* a power cut ends these jobs anyway */
    assert_int_equal(scratch_commit(scratch, &claim, "result", 6), STORE_OK);
    assert_int_equal(atomic_exchange(&syncs, 0), 1);
    scratch_submit(scratch, "b", id);
    atomic_store(&syncs, 0);
    assert_int_equal(store_cancel(scratch->store, id), STORE_OK);
    assert_int_equal(atomic_exchange(&syncs, 0), 1);
    assert_int_equal(store_delete(scratch->store, id), STORE_OK);
    assert_int_equal(atomic_exchange(&syncs, 0), 1);
    claim = scratch_claimed(scratch, "c");
    atomic_store(&syncs, 0);
    assert_int_equal(store_fail(scratch->store, &claim, "{}"), STORE_OK);
    assert_int_equal(atomic_exchange(&syncs, 0), 1);
}

/* One of which nothing is promised yet waits for the disk when something is, or with its end. */
static void test_store_waits_for_the_disk_when_a_submission_is_promised(void **state) {
    struct scratch *scratch = *state;
    struct store_receipt receipt;
    struct store_claim claim;
    struct store_submission submission = {
        .request = "a", .request_length = 1, .digest = "a", .unpromised = true};
    assert_int_equal(store_flush(scratch->store), STORE_OK); /* the first has the folder, too */
    atomic_store(&syncs, 0);
    assert_int_equal(store_submit(scratch->store, &submission, &receipt), STORE_OK);
    assert_int_equal(atomic_load(&syncs), 0);
    assert_int_equal(store_flush(scratch->store), STORE_OK);
    assert_int_equal(atomic_exchange(&syncs, 0), 1);
    assert_int_equal(store_claim(scratch->store, &claim), STORE_OK);
    assert_int_equal(scratch_commit(scratch, &claim, "result", 6), STORE_OK);
    assert_int_equal(atomic_exchange(&syncs, 0), 1);
    atomic_store(&sync_fails, true);
    assert_int_equal(store_flush(scratch->store), STORE_DOWN);
}

/* A claim that ends a job, because its result is there already, is as good as a completion. */
static void test_store_waits_for_the_disk_when_a_claim_ends_a_job(void **state) {
    struct scratch *scratch = *state;
    char id[ID_SIZE];
    struct store_claim first = scratch_claimed(scratch, "same");
    struct store_claim second;
    scratch_submit(scratch, "same", id);
    assert_int_equal(scratch_commit(scratch, &first, "result", 6), STORE_OK);
    atomic_store(&syncs, 0);
    assert_int_equal(store_claim(scratch->store, &second), STORE_OK);
    assert_true(second.reused);
    assert_int_equal(atomic_load(&syncs), 1);
}

/* ------------------------------------------------------------------ many threads */

enum { THREADS = 8, SUBMITS = 50 };

struct submitter {
    struct scratch *scratch;
    int number;
    char ids[SUBMITS][ID_SIZE];
    pthread_t thread;
};

static void *submit_many(void *context) {
    struct submitter *submitter = context;
    for (int k = 0; k < SUBMITS; k++) {
        char body[64];
        struct store_receipt receipt;
        int length = snprintf(body, sizeof body, "thread %d body %d", submitter->number, k);
        struct store_submission submission = {
            .request = body, .request_length = (size_t)length, .digest = body};
        if (store_submit(submitter->scratch->store, &submission, &receipt) == STORE_OK)
            memcpy(submitter->ids[k], receipt.id, ID_SIZE);
    }
    return NULL;
}

static void expect_request(struct scratch *scratch, const char *id, const char *body) {
    char *bytes = NULL;
    size_t length = 0;
    assert_int_equal(store_request(scratch->store, id, &bytes, &length), STORE_OK);
    assert_int_equal(length, strlen(body));
    assert_string_equal(bytes, body);
    free(bytes);
}

static void test_store_threads_share_a_commit(void **state) {
    struct scratch *scratch = *state;
    struct submitter *submitters = calloc(THREADS, sizeof *submitters);
    atomic_store(&sync_ms, 3);
    atomic_store(&syncs, 0);
    for (int k = 0; k < THREADS; k++) {
        submitters[k] = (struct submitter){.scratch = scratch, .number = k};
        assert_int_equal(pthread_create(&submitters[k].thread, NULL, submit_many, &submitters[k]),
                         0);
    }
    for (int k = 0; k < THREADS; k++)
        pthread_join(submitters[k].thread, NULL);
    int commits = atomic_load(&syncs);
    atomic_store(&sync_ms, 0);
    print_message("%d submissions, %d commits\n", THREADS * SUBMITS, commits);
    assert_true(commits < THREADS * SUBMITS / 3);
    scratch_stop(scratch);
    scratch_start(scratch);
    for (int k = 0; k < THREADS; k++) {
        for (int n = 0; n < SUBMITS; n++) {
            char body[64];
            snprintf(body, sizeof body, "thread %d body %d", k, n);
            expect_request(scratch, submitters[k].ids[n], body);
        }
    }
    free(submitters);
}

/* A submission on a thread of its own. */
struct lone {
    struct scratch *scratch;
    const char *body;
    pthread_t thread;
};

static void *submit_one(void *context) {
    struct lone *lone = context;
    char id[ID_SIZE];
    scratch_submit(lone->scratch, lone->body, id);
    return NULL;
}

/* Begins two submissions. The first waits for the disk; the second begins the next transaction,
 * which takes up what is written until the first is through. */
static void begin_a_batch(struct scratch *scratch, struct lone lone[2]) {
    atomic_store(&syncs, 0);
    atomic_store(&sync_ms, 300);
    for (int k = 0; k < 2; k++) {
        lone[k] = (struct lone){.scratch = scratch, .body = k ? "second" : "first"};
        assert_int_equal(pthread_create(&lone[k].thread, NULL, submit_one, &lone[k]), 0);
        scratch_sleep(50);
    }
}

static void end_a_batch(struct lone lone[2]) {
    for (int k = 0; k < 2; k++)
        pthread_join(lone[k].thread, NULL);
    atomic_store(&sync_ms, 0);
}

/* What needs no disk does not take it from those whose transaction it shares. */
static void test_store_waits_for_the_disk_for_one_of_a_batch(void **state) {
    struct scratch *scratch = *state;
    struct lone lone[2];
    struct store_claim claim = scratch_claimed(scratch, "a");
    begin_a_batch(scratch, lone);
    assert_int_equal(store_renew(scratch->store, &claim, 0.5), STORE_OK);
    end_a_batch(lone);
    assert_int_equal(atomic_load(&syncs), 2);
}

/* What one caller must not do does not hurt those whose changes share its transaction. */
struct mixed {
    struct scratch *scratch;
    int wrong;
    pthread_t thread;
};

static void *submit_and_be_refused(void *context) {
    struct mixed *mixed = context;
    struct store_receipt receipt;
    for (int k = 0; k < SUBMITS; k++) {
        char body[64];
        int length = snprintf(body, sizeof body, "%p %d", context, k);
        struct store_submission submission = {
            .request = body, .request_length = (size_t)length, .digest = body};
        mixed->wrong += store_submit(mixed->scratch->store, &submission, &receipt) != STORE_OK;
        submission.surface = "missing";
        mixed->wrong += store_submit(mixed->scratch->store, &submission, &receipt) != STORE_EMPTY;
        submission.surface = NULL;
        submission.key = "shared key"; /* the first comes in, all others have other bodies */
        enum store_answer answer = store_submit(mixed->scratch->store, &submission, &receipt);
        mixed->wrong += answer != STORE_OK && answer != STORE_CONFLICT;
    }
    return NULL;
}

static void test_store_refusals_do_not_undo_the_others(void **state) {
    struct scratch *scratch = *state;
    struct mixed mixed[THREADS];
    struct store_counts counts;
    atomic_store(&sync_ms, 2);
    for (int k = 0; k < THREADS; k++) {
        mixed[k] = (struct mixed){.scratch = scratch};
        assert_int_equal(pthread_create(&mixed[k].thread, NULL, submit_and_be_refused, &mixed[k]),
                         0);
    }
    for (int k = 0; k < THREADS; k++) {
        pthread_join(mixed[k].thread, NULL);
        assert_int_equal(mixed[k].wrong, 0);
    }
    assert_int_equal(store_counts(scratch->store, &counts), STORE_OK);
    assert_int_equal(counts.jobs[STORE_QUEUED], THREADS * SUBMITS + 1);
}

/* ------------------------------------------------------------------ kill -9 */

/* What the process that is killed tells through a pipe after each acknowledgement. */
struct acknowledged {
    char id[ID_SIZE];
    bool finished; /* with a result: its id, again and again */
};

struct victim {
    struct scratch *scratch;
    int pipe;
};

static void write_result(struct scratch *scratch, const struct store_claim *claim) {
    static _Thread_local unsigned char bytes[200000];
    for (size_t k = 0; k < sizeof bytes; k++)
        bytes[k] = (unsigned char)claim->id[k % (ID_SIZE - 1)];
    if (scratch_commit(scratch, claim, bytes, sizeof bytes) != STORE_OK)
        abort();
}

static void *write_until_killed(void *context) {
    struct victim *victim = context;
    for (int k = 0;; k++) {
        char body[64];
        struct store_claim claim;
        struct store_receipt receipt;
        int length = snprintf(body, sizeof body, "%d %p %d", getpid(), (void *)&claim, k);
        struct store_submission submission = {
            .request = body, .request_length = (size_t)length, .digest = body};
        if (store_submit(victim->scratch->store, &submission, &receipt) != STORE_OK)
            abort();
        struct acknowledged told = {.finished = false};
        memcpy(told.id, receipt.id, ID_SIZE);
        if (write(victim->pipe, &told, sizeof told) != sizeof told)
            abort();
        if (k % 2 == 0 && store_claim(victim->scratch->store, &claim) == STORE_OK) {
            write_result(victim->scratch, &claim);
            told.finished = true;
            memcpy(told.id, claim.id, ID_SIZE);
            if (write(victim->pipe, &told, sizeof told) != sizeof told)
                abort();
        }
    }
}

static pid_t start_victim(struct scratch *scratch, int pipe_end) {
    pid_t pid = fork();
    if (pid != 0)
        return pid;
    alarm(30); /* never outlive the test */
    struct victim victim = {.scratch = scratch, .pipe = pipe_end};
    pthread_t threads[4];
    scratch_start(scratch);
    for (int k = 0; k < 4; k++)
        pthread_create(&threads[k], NULL, write_until_killed, &victim);
    pause();
    _exit(0);
}

static int expect_acknowledged(struct scratch *scratch, int pipe_end) {
    struct acknowledged told;
    unsigned char bytes[200000];
    int count = 0;
    for (; read(pipe_end, &told, sizeof told) == sizeof told; count++) {
        enum store_status status = scratch_status(scratch, told.id);
        if (!told.finished)
            continue;
        assert_int_equal(status, STORE_SUCCEEDED);
        for (size_t k = 0; k < sizeof bytes; k++)
            bytes[k] = (unsigned char)told.id[k % (ID_SIZE - 1)];
        scratch_expect_result(scratch, told.id, bytes, sizeof bytes, 50000);
    }
    return count;
}

static void test_store_loses_nothing_to_kill_9(void **state) {
    struct scratch *scratch = *state;
    uint64_t seed = check_seed(1);
    int total = 0;
    scratch_stop(scratch);
    for (int round = 0; round < 8; round++) {
        int ends[2];
        assert_int_equal(pipe(ends), 0);
        pid_t victim = start_victim(scratch, ends[1]);
        assert_true(victim > 0);
        close(ends[1]);
        struct pollfd first = {.fd = ends[0], .events = POLLIN};
        (void)poll(&first, 1, 20000); /* its first acknowledgement, however busy the machine is */
        scratch_sleep((int)(scratch_random(&seed) % 100));
        kill(victim, SIGKILL);
        waitpid(victim, NULL, 0);
        scratch_start(scratch);
        total += expect_acknowledged(scratch, ends[0]);
        (void)scratch_sweep(scratch);
        close(ends[0]);
        scratch_stop(scratch);
    }
    print_message("%d acknowledgements kept\n", total);
    assert_true(total > 0);
    scratch_start(scratch);
}

/* ------------------------------------------------------------------ a disk that fails */

static void limit_file_size(rlim_t bytes) {
    struct rlimit limit;
    getrlimit(RLIMIT_FSIZE, &limit);
    limit.rlim_cur = bytes < limit.rlim_max ? bytes : limit.rlim_max;
    assert_int_equal(setrlimit(RLIMIT_FSIZE, &limit), 0);
}

static void test_store_full_disk_is_down_and_then_up_again(void **state) {
    struct scratch *scratch = *state;
    char id[ID_SIZE];
    char body[4000];
    struct store_receipt receipt;
    struct store_counts counts;
    enum store_answer answer = STORE_OK;
    int kept = 0;
    memset(body, 'b', sizeof body);
    struct store_submission submission = {
        .request = body, .request_length = sizeof body, .digest = "full"};
    signal(SIGXFSZ, SIG_IGN);
    limit_file_size(512 * 1024);
    for (; kept < 1000 && answer == STORE_OK; kept += answer == STORE_OK)
        answer = store_submit(scratch->store, &submission, &receipt);
    enum store_answer reading = store_counts(scratch->store, &counts);
    limit_file_size(RLIM_INFINITY);
    assert_int_equal(answer, STORE_DOWN);
    assert_int_equal(reading, STORE_OK); /* who only reads is not concerned */
    assert_int_equal(counts.jobs[STORE_QUEUED], kept);
    assert_int_equal(store_ping(scratch->store), STORE_OK);
    scratch_submit(scratch, "again", id);
    assert_int_equal(store_counts(scratch->store, &counts), STORE_OK);
    assert_int_equal(counts.jobs[STORE_QUEUED], kept + 1);
}

static void test_store_full_disk_during_a_result_can_be_tried_again(void **state) {
    struct scratch *scratch = *state;
    enum { LENGTH = 700 * 1024 };
    unsigned char *bytes = calloc(1, LENGTH);
    struct store_claim claim = scratch_claimed(scratch, "a");
    struct store_writer *writer = store_writer_new(scratch->store, &claim);
    assert_int_equal(store_writer_append(writer, bytes, LENGTH), STORE_OK);
    signal(SIGXFSZ, SIG_IGN);
    limit_file_size(512 * 1024);
    enum store_answer full = store_writer_commit(writer, "{}");
    limit_file_size(RLIM_INFINITY);
    assert_int_equal(full, STORE_DOWN);
    assert_int_equal(scratch_status(scratch, claim.id), STORE_RUNNING);
    assert_int_equal(store_writer_commit(writer, "{}"), STORE_OK);
    store_writer_free(writer);
    scratch_expect_result(scratch, claim.id, bytes, LENGTH, LENGTH);
    free(bytes);
}

static void test_store_disk_that_cannot_sync_is_down(void **state) {
    struct scratch *scratch = *state;
    char id[ID_SIZE];
    struct store_receipt receipt;
    struct store_submission submission = {.request = "a", .request_length = 1, .digest = "a"};
    atomic_store(&sync_fails, true);
    assert_int_equal(store_submit(scratch->store, &submission, &receipt), STORE_DOWN);
    assert_int_equal(store_ping(scratch->store), STORE_DOWN);
    atomic_store(&sync_fails, false);
    assert_int_equal(store_ping(scratch->store), STORE_OK);
    scratch_submit(scratch, "b", id);
    scratch_stop(scratch);
    scratch_start(scratch);
    struct store_counts counts;
    assert_int_equal(store_counts(scratch->store, &counts), STORE_OK);
    assert_int_equal(counts.jobs[STORE_QUEUED], 1); /* what was answered DOWN has not happened */
}

#define WITH_STORE(name) cmocka_unit_test_setup_teardown(name, set_up, scratch_tear_down)

int main(void) {
    const struct CMUnitTest tests[] = {
        WITH_STORE(test_store_waits_for_the_disk_where_it_must),
        WITH_STORE(test_store_waits_for_the_disk_when_a_submission_is_promised),
        WITH_STORE(test_store_waits_for_the_disk_when_a_claim_ends_a_job),
        WITH_STORE(test_store_threads_share_a_commit),
        WITH_STORE(test_store_waits_for_the_disk_for_one_of_a_batch),
        WITH_STORE(test_store_refusals_do_not_undo_the_others),
        WITH_STORE(test_store_loses_nothing_to_kill_9),
        WITH_STORE(test_store_full_disk_is_down_and_then_up_again),
        WITH_STORE(test_store_full_disk_during_a_result_can_be_tried_again),
        WITH_STORE(test_store_disk_that_cannot_sync_is_down),
    };
    return cmocka_run_group_tests_name("store durability", tests, NULL, NULL);
}
