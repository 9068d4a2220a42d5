/* SPDX-License-Identifier: MIT */
/* The dispatcher with real worker processes, which are this program itself (see engine.h). */
#include "engine.h"
#include "server/clock.h"
#include "server/work/dispatcher.h"
#include "server/work/sandbox.h"
#include "tests/store/scratch.h"
#include <dirent.h>
#include <errno.h>
#include <signal.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

enum { PATIENCE_MS = 20000 }; /* generous: machines are loaded, sanitizers slow */

struct bench {
    struct scratch scratch;
    struct dispatcher_settings settings;
    struct dispatcher *dispatcher;
};

static int set_up(void **state) {
    struct bench *bench = calloc(1, sizeof *bench);
    scratch_open_live(&bench->scratch);
    bench->settings = dispatcher_settings_default();
    bench->settings.renew_ms = 100;
    bench->settings.progress_ms = 10;
    bench->settings.sweep_ms = 50;
    *state = bench;
    return 0;
}

static void start(struct bench *bench) {
    bench->dispatcher =
        dispatcher_start(bench->scratch.store, bench->scratch.events, &bench->settings);
    assert_non_null(bench->dispatcher);
}

static void stop(struct bench *bench, int64_t grace_ms) {
    dispatcher_stop(bench->dispatcher, grace_ms);
    dispatcher_free(bench->dispatcher);
    bench->dispatcher = NULL;
}

static int tear_down(void **state) {
    struct bench *bench = *state;
    stop(bench, 0);
    scratch_remove(&bench->scratch);
    free(bench);
    return 0;
}

static void submit(struct bench *bench, const char *act, char id[ID_SIZE]) {
    scratch_submit(&bench->scratch, act, id);
}

static void wait_for(struct bench *bench, const char *id, enum store_status status) {
    int64_t until = clock_ms() + PATIENCE_MS;
    while (scratch_status(&bench->scratch, id) != status) {
        if (clock_ms() > until)
            fail_msg("the job is not %s but %s", store_status_name(status),
                     store_status_name(scratch_status(&bench->scratch, id)));
        scratch_sleep(2);
    }
}

static void expect_echo(struct bench *bench, const char *id, const char *act) {
    wait_for(bench, id, STORE_SUCCEEDED);
    scratch_expect_result(&bench->scratch, id, act, strlen(act), 1000);
}

/* A job that must go well, whatever was before it. */
static void expect_work(struct bench *bench) {
    static int number;
    char act[32];
    char id[ID_SIZE];
    snprintf(act, sizeof act, "echo %d", number++);
    submit(bench, act, id);
    expect_echo(bench, id, act);
}

static void expect_error(struct bench *bench, const char *id, const char *slug,
                         const char *detail) {
    struct store_job job;
    wait_for(bench, id, STORE_FAILED);
    assert_int_equal(store_get(bench->scratch.store, id, &job), STORE_OK);
    if (!strstr(job.error, slug) || !strstr(job.error, detail))
        fail_msg("%s says neither %s nor %s", job.error, slug, detail);
    store_job_clear(&job);
}

static int attempts_of(struct bench *bench, const char *id) {
    struct store_job job;
    assert_int_equal(store_get(bench->scratch.store, id, &job), STORE_OK);
    store_job_clear(&job);
    return job.attempts;
}

/* Stops the dispatcher first: its counters rise only after the store knows of what they count. */
static struct work_counts final_stats(struct bench *bench) {
    struct work_counts stats;
    dispatcher_stop(bench->dispatcher, PATIENCE_MS);
    dispatcher_stats(bench->dispatcher, &stats);
    dispatcher_free(bench->dispatcher);
    bench->dispatcher = NULL;
    return stats;
}

/* The first process whose parent is `parent`; 0 for none. */
static pid_t child_of(pid_t parent) {
    DIR *processes = opendir("/proc");
    pid_t found = 0;
    for (struct dirent *entry = NULL; !found && (entry = readdir(processes)) != NULL;) {
        char path[300];
        int pid = 0, its_parent = 0;
        snprintf(path, sizeof path, "/proc/%s/stat", entry->d_name);
        FILE *file = fopen(path, "r");
        if (file && fscanf(file, "%d (%*[^)]) %*c %d", &pid, &its_parent) == 2)
            found = its_parent == parent ? pid : 0;
        if (file)
            fclose(file);
    }
    closedir(processes);
    return found;
}

static void wait_for_death(pid_t pid) {
    int64_t until = clock_ms() + PATIENCE_MS;
    while (kill(pid, 0) == 0 && clock_ms() < until)
        scratch_sleep(2);
    assert_int_not_equal(kill(pid, 0), 0);
}

/* ------------------------------------------------------------------ jobs that go well */

static void test_dispatcher_runs_a_job(void **state) {
    struct bench *bench = *state;
    struct store_job job;
    char id[ID_SIZE];
    start(bench);
    submit(bench, "echo hello", id);
    expect_echo(bench, id, "echo hello");
    assert_int_equal(store_get(bench->scratch.store, id, &job), STORE_OK);
    assert_string_equal(job.summary, "{\"act\":\"echo\"}");
    assert_true(job.attempts == 1 && job.progress == 1.0);
    assert_true(job.created <= job.started && job.started <= job.finished);
    store_job_clear(&job);
    assert_int_equal(final_stats(bench).succeeded, 1);
}

static void test_dispatcher_takes_what_was_queued_before(void **state) {
    struct bench *bench = *state;
    char id[ID_SIZE];
    submit(bench, "echo early", id);
    start(bench);
    expect_echo(bench, id, "echo early");
}

static void test_dispatcher_hands_over_the_surface(void **state) {
    struct bench *bench = *state;
    static char definition[] = "{\"degree\":2}";
    bool created = false;
    struct store_receipt receipt;
    struct store_item surface = {.id = "s",
                                 .definition = definition,
                                 .definition_length = sizeof definition - 1,
                                 .description = definition};
    struct store_submission submission = {
        .request = "surface", .request_length = 7, .digest = "x", .surface = "s"};
    assert_int_equal(store_item_put(bench->scratch.store, STORE_SURFACES, &surface, &created),
                     STORE_OK);
    start(bench);
    assert_int_equal(store_submit(bench->scratch.store, &submission, &receipt), STORE_OK);
    expect_echo(bench, receipt.id, definition);
}

static void test_dispatcher_stores_progress(void **state) {
    struct bench *bench = *state;
    char id[ID_SIZE];
    double last = 0;
    int steps = 0;
    start(bench);
    submit(bench, "sleep 400", id);
    int64_t until = clock_ms() + PATIENCE_MS;
    while (scratch_status(&bench->scratch, id) != STORE_SUCCEEDED && clock_ms() < until) {
        struct store_job job;
        assert_int_equal(store_get(bench->scratch.store, id, &job), STORE_OK);
        assert_true(job.progress >= last);
        steps += job.progress > last && job.progress < 1;
        last = job.progress;
        store_job_clear(&job);
        scratch_sleep(5);
    }
    expect_echo(bench, id, "sleep 400");
    assert_true(steps > 0);
}

static void test_dispatcher_stores_a_large_result(void **state) {
    struct bench *bench = *state;
    enum { LENGTH = 9000001 };
    unsigned char *bytes = malloc(LENGTH);
    char id[ID_SIZE];
    for (size_t k = 0; k < LENGTH; k++)
        bytes[k] = engine_byte(k);
    start(bench);
    submit(bench, "large 9000001", id);
    wait_for(bench, id, STORE_SUCCEEDED);
    scratch_expect_result(&bench->scratch, id, bytes, LENGTH, 100000);
    free(bytes);
}

static void test_dispatcher_shares_the_work_among_workers(void **state) {
    struct bench *bench = *state;
    enum { JOBS = 60 };
    char ids[JOBS][ID_SIZE];
    char acts[JOBS][32];
    bench->settings.workers = 4;
    start(bench);
    for (int k = 0; k < JOBS; k++) {
        snprintf(acts[k], sizeof acts[k], "sleep 10 %d", k);
        submit(bench, acts[k], ids[k]);
    }
    for (int k = 0; k < JOBS; k++)
        expect_echo(bench, ids[k], acts[k]);
    struct work_counts stats = final_stats(bench);
    assert_int_equal(stats.succeeded, JOBS);
    assert_int_equal(stats.busy, 0);
}

static void test_dispatcher_reuses_results(void **state) {
    struct bench *bench = *state;
    char first[ID_SIZE], second[ID_SIZE];
    submit(bench, "pid", first);
    submit(bench, "pid", second);
    start(bench);
    wait_for(bench, first, STORE_SUCCEEDED);
    wait_for(bench, second, STORE_SUCCEEDED);
    assert_int_equal(final_stats(bench).reused, 1);
}

/* ------------------------------------------------------------------ jobs that go wrong */

static void test_dispatcher_passes_the_problem_on(void **state) {
    struct bench *bench = *state;
    char id[ID_SIZE];
    start(bench);
    submit(bench, "problem", id);
    expect_error(bench, id, "/problems/start-off-surface", "too far away");
    expect_work(bench);
    assert_int_equal(final_stats(bench).restarts, 0); /* that worker was not to blame */
}

static void test_dispatcher_gives_a_crash_three_attempts(void **state) {
    struct bench *bench = *state;
    char id[ID_SIZE];
    start(bench);
    submit(bench, "crash", id);
    expect_error(bench, id, "/problems/solver-crashed", "signal 11");
    assert_int_equal(attempts_of(bench, id), 3);
    expect_work(bench);
    assert_int_equal(final_stats(bench).crashes, 3);
}

static void test_dispatcher_succeeds_in_the_second_attempt(void **state) {
    struct bench *bench = *state;
    char id[ID_SIZE];
    start(bench);
    expect_work(bench);
    submit(bench, "crash-used", id);
    expect_echo(bench, id, "crash-used");
    assert_int_equal(attempts_of(bench, id), 2);
}

static void test_dispatcher_names_the_exit_code(void **state) {
    struct bench *bench = *state;
    char id[ID_SIZE];
    start(bench);
    submit(bench, "exit 7", id);
    expect_error(bench, id, "/problems/solver-crashed", "exit with code 7");
    expect_work(bench);
}

static void test_dispatcher_does_not_believe_a_babbling_worker(void **state) {
    struct bench *bench = *state;
    char id[ID_SIZE];
    start(bench);
    submit(bench, "babble", id);
    expect_error(bench, id, "/problems/solver-crashed", "an invalid frame");
    submit(bench, "oversized", id);
    expect_error(bench, id, "/problems/solver-crashed", "an invalid frame");
    submit(bench, "headless", id);
    expect_error(bench, id, "/problems/internal", "no summary");
    expect_work(bench);
}

static void test_dispatcher_ends_what_takes_too_long(void **state) {
    struct bench *bench = *state;
    char hanging[ID_SIZE], spinning[ID_SIZE];
    bench->settings.workers = 2;
    bench->settings.job_timeout_ms = SANDBOX_SANITIZED ? 3000 : 300; /* a worker starts in it */
    start(bench);
    submit(bench, "hang", hanging);
    submit(bench, "spin", spinning);
    expect_error(bench, hanging, "/problems/job-timeout", "seconds");
    expect_error(bench, spinning, "/problems/job-timeout", "seconds");
    assert_int_equal(attempts_of(bench, hanging), 1); /* it would take as long again */
    expect_work(bench);
    assert_int_equal(final_stats(bench).timeouts, 2);
}

static void test_dispatcher_refuses_too_large_a_result(void **state) {
    struct bench *bench = *state;
    char id[ID_SIZE];
    bench->settings.max_result = 1000000;
    start(bench);
    submit(bench, "large 1000001", id);
    expect_error(bench, id, "/problems/too-large", "1000000");
    submit(bench, "large 1000000", id);
    wait_for(bench, id, STORE_SUCCEEDED);
}

static void test_dispatcher_limits_the_memory(void **state) {
    struct bench *bench = *state;
    char id[ID_SIZE];
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    skip(); /* their own memory cannot be limited */
#endif
    bench->settings.limits.max_memory = 512 << 20;
    start(bench);
    submit(bench, "memory", id);
    expect_error(bench, id, "/problems/out-of-memory", "pieces");
    expect_work(bench);
    assert_int_equal(final_stats(bench).restarts, 0);
}

static void test_worker_has_nothing_but_its_socket(void **state) {
    struct bench *bench = *state;
    char id[ID_SIZE];
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
    skip(); /* they need files to report */
#endif
    start(bench);
    submit(bench, "inside", id);
    expect_echo(bench, id, "files 1 variables 0 open no socket no");
}

/* ------------------------------------------------------------------ stopping jobs */

static void expect_stopped(struct bench *bench, bool delete) {
    char id[ID_SIZE];
    bench->settings.renew_ms = 600000; /* by which it would learn of it, too */
    start(bench);
    submit(bench, "hang", id);
    wait_for(bench, id, STORE_RUNNING);
    pid_t worker = child_of(getpid());
    assert_true(worker > 0);
    int64_t before = clock_ms();
    if (delete)
        assert_int_equal(store_delete(bench->scratch.store, id), STORE_OK);
    else
        assert_int_equal(store_cancel(bench->scratch.store, id), STORE_OK);
    wait_for_death(worker);
    print_message("stopped after %lld ms\n", (long long)(clock_ms() - before));
    expect_work(bench);
}

static void test_dispatcher_stops_a_cancelled_job(void **state) {
    struct bench *bench = *state;
    expect_stopped(bench, false);
    assert_int_equal(final_stats(bench).stopped, 1);
}

static void test_dispatcher_stops_a_deleted_job(void **state) {
    struct bench *bench = *state;
    expect_stopped(bench, true);
}

/* Job events are only of this process; of others the dispatcher learns by looking. */
static void test_dispatcher_sees_what_another_process_cancels(void **state) {
    struct bench *bench = *state;
    char id[ID_SIZE];
    scratch_stop(&bench->scratch);
    bench->scratch.options.shared = true;
    scratch_start(&bench->scratch);
    bench->settings.renew_ms = 600000;
    start(bench);
    submit(bench, "hang", id);
    wait_for(bench, id, STORE_RUNNING);
    pid_t worker = child_of(getpid());
    struct scratch other = bench->scratch;
    scratch_start(&other);
    assert_int_equal(store_cancel(other.store, id), STORE_OK);
    wait_for_death(worker);
    scratch_submit(&other, "echo other", id);
    expect_echo(bench, id, "echo other");
    scratch_stop(&other);
}

static void test_dispatcher_survives_a_killed_worker(void **state) {
    struct bench *bench = *state;
    char id[ID_SIZE];
    start(bench);
    submit(bench, "sleep 300", id);
    wait_for(bench, id, STORE_RUNNING);
    assert_int_equal(kill(child_of(getpid()), SIGKILL), 0);
    expect_echo(bench, id, "sleep 300");
    assert_int_equal(attempts_of(bench, id), 2);
}

/* From outside, where the worker cannot undo it. */
static void test_dispatcher_bounds_its_worker(void **state) {
    struct bench *bench = *state;
    char id[ID_SIZE];
    struct rlimit memory, processor;
    bench->settings.limits.max_memory = 123 << 20;
    bench->settings.job_timeout_ms = 7000;
    start(bench);
    submit(bench, "sleep 300", id);
    wait_for(bench, id, STORE_RUNNING);
    scratch_sleep(50);
    pid_t worker = child_of(getpid());
    assert_int_equal(prlimit(worker, RLIMIT_AS, NULL, &memory), 0);
    assert_int_equal(prlimit(worker, RLIMIT_CPU, NULL, &processor), 0);
    assert_true(processor.rlim_cur >= 7 && processor.rlim_cur < 60);
    if (!SANDBOX_SANITIZED) {
        assert_int_equal(memory.rlim_cur, (123U << 20) + (1U << 30) + strlen("sleep 300"));
        assert_int_equal(memory.rlim_max, (123U << 20) + (UINT64_C(5) << 30));
    }
    expect_echo(bench, id, "sleep 300");
}

/* The worker that served the job of this owner; the number of workers is one. */
static pid_t worker_of(struct bench *bench, const char *owner, const char *act) {
    struct store_receipt receipt;
    struct store_submission submission = {
        .request = act, .request_length = strlen(act), .digest = act, .owner = owner};
    assert_int_equal(store_submit(bench->scratch.store, &submission, &receipt), STORE_OK);
    expect_echo(bench, receipt.id, act);
    return child_of(getpid());
}

static void test_dispatcher_gives_each_owner_a_new_worker(void **state) {
    struct bench *bench = *state;
    start(bench);
    pid_t first = worker_of(bench, "anna", "echo 1");
    assert_int_equal(worker_of(bench, "anna", "echo 2"), first);
    pid_t second = worker_of(bench, "bert", "echo 3");
    assert_int_not_equal(second, first);
    assert_int_equal(kill(first, 0), -1); /* gone, not put aside */
    assert_int_equal(worker_of(bench, "bert", "echo 4"), second);
    assert_int_not_equal(worker_of(bench, "", "echo 5"), second);
    assert_int_equal(final_stats(bench).crashes, 0);
}

static void test_dispatcher_replaces_a_worker_killed_at_rest(void **state) {
    struct bench *bench = *state;
    start(bench);
    expect_work(bench);
    pid_t worker = child_of(getpid());
    siginfo_t ended;
    assert_int_equal(kill(worker, SIGKILL), 0);
    assert_int_equal(waitid(P_PID, (id_t)worker, &ended, WEXITED | WNOWAIT), 0);
    expect_work(bench);
    assert_int_equal(final_stats(bench).crashes, 0); /* it cost no job an attempt */
}

/* The lease is the dispatcher's to renew: a worker that does nothing for long loses nothing. */
static void test_dispatcher_renews_the_lease_of_a_stopped_worker(void **state) {
    enum { LEASE_MS = 500 };
    struct bench *bench = *state;
    char id[ID_SIZE];
    scratch_stop(&bench->scratch);
    bench->scratch.options.lease_us = LEASE_MS * 1000;
    scratch_start(&bench->scratch);
    start(bench);
    submit(bench, "sleep 200", id);
    wait_for(bench, id, STORE_RUNNING);
    pid_t worker = child_of(getpid());
    assert_int_equal(kill(worker, SIGSTOP), 0);
    scratch_sleep(3 * LEASE_MS);
    assert_int_equal(scratch_status(&bench->scratch, id), STORE_RUNNING);
    assert_int_equal(kill(worker, SIGCONT), 0);
    expect_echo(bench, id, "sleep 200");
    assert_int_equal(attempts_of(bench, id), 1);
}

/* ------------------------------------------------------------------ shutdown and restart */

static void test_dispatcher_stop_lets_jobs_finish(void **state) {
    struct bench *bench = *state;
    char running[ID_SIZE], queued[ID_SIZE];
    start(bench);
    submit(bench, "sleep 300", running);
    submit(bench, "echo later", queued);
    wait_for(bench, running, STORE_RUNNING);
    stop(bench, PATIENCE_MS);
    assert_int_equal(scratch_status(&bench->scratch, running), STORE_SUCCEEDED);
    assert_int_equal(scratch_status(&bench->scratch, queued), STORE_QUEUED);
    start(bench);
    expect_echo(bench, queued, "echo later");
}

static void test_dispatcher_stop_returns_jobs_after_the_grace(void **state) {
    struct bench *bench = *state;
    char id[ID_SIZE];
    bench->settings.workers = 2;
    start(bench);
    submit(bench, "hang", id);
    wait_for(bench, id, STORE_RUNNING);
    int64_t before = clock_ms();
    stop(bench, 100);
    print_message("stopped after %lld ms\n", (long long)(clock_ms() - before));
    assert_int_equal(scratch_status(&bench->scratch, id), STORE_QUEUED);
    assert_int_equal(child_of(getpid()), 0);
}

/* A process with a store and a dispatcher, as the daemon is one. */
static pid_t start_daemon(struct bench *bench) {
    pid_t pid = fork();
    if (pid != 0)
        return pid;
    alarm(60);
    scratch_start(&bench->scratch);
    start(bench);
    pause();
    _exit(0);
}

static void test_dispatcher_restart_takes_up_what_a_killed_daemon_left(void **state) {
    struct bench *bench = *state;
    char running[ID_SIZE], queued[ID_SIZE];
    submit(bench, "sleep 1500", running);
    submit(bench, "echo queued", queued);
    scratch_stop(&bench->scratch);
    pid_t daemon = start_daemon(bench);
    int64_t until = clock_ms() + PATIENCE_MS;
    while (scratch_number(&bench->scratch, "SELECT count(*) FROM jobs WHERE status = 1") == 0 &&
           clock_ms() < until)
        scratch_sleep(5);
    pid_t worker = child_of(daemon);
    kill(daemon, SIGKILL);
    waitpid(daemon, NULL, 0);
    wait_for_death(worker);
    scratch_start(&bench->scratch);
    assert_int_equal(scratch_status(&bench->scratch, running), STORE_RUNNING);
    int64_t before = clock_ms();
    start(bench);
    expect_echo(bench, running, "sleep 1500");
    expect_echo(bench, queued, "echo queued");
    print_message("both done after %lld ms\n", (long long)(clock_ms() - before));
    assert_int_equal(attempts_of(bench, running), 2);
}

/* Stops a process that shares our database, though not within a transaction: that would keep all
 * others from writing until it goes on. */
static void stop_between_writes(struct bench *bench, pid_t daemon) {
    struct store_receipt receipt;
    struct store_submission submission = {.request = "echo", .request_length = 4, .digest = "echo"};
    enum store_answer answer = STORE_BUSY;
    for (int tries = 0; tries < 100 && answer != STORE_OK; tries++) {
        kill(daemon, SIGCONT);
        scratch_sleep(10);
        assert_int_equal(kill(daemon, SIGSTOP), 0);
        answer = store_submit(bench->scratch.store, &submission, &receipt);
    }
    assert_int_equal(answer, STORE_OK);
}

/* A whole process stands still beyond its lease, as a machine that was suspended: another takes its
 * job, and what it still says afterwards is not heard. */
static void test_dispatcher_takes_over_from_a_stopped_process(void **state) {
    enum { LEASE_MS = 1000 };
    struct bench *bench = *state;
    char id[ID_SIZE];
    struct store_job job;
    scratch_stop(&bench->scratch);
    bench->scratch.options.shared = true;
    bench->scratch.options.lease_us = LEASE_MS * 1000;
    bench->scratch.options.busy_ms = 300;
    pid_t daemon = start_daemon(bench);
    scratch_start(&bench->scratch);
    submit(bench, "sleep 1500", id);
    wait_for(bench, id, STORE_RUNNING);
    stop_between_writes(bench, daemon); /* its worker goes on, and has its result ready */
    start(bench);
    expect_echo(bench, id, "sleep 1500");
    assert_int_equal(attempts_of(bench, id), 2);
    assert_int_equal(store_get(bench->scratch.store, id, &job), STORE_OK);
    int64_t finished = job.finished;
    store_job_clear(&job);
    kill(daemon, SIGCONT);
    scratch_sleep(500);
    assert_int_equal(store_get(bench->scratch.store, id, &job), STORE_OK);
    assert_int_equal(job.status, STORE_SUCCEEDED);
    assert_int_equal(job.attempts, 2);
    assert_true(job.finished == finished);
    store_job_clear(&job);
    kill(daemon, SIGKILL);
    waitpid(daemon, NULL, 0);
}

#define WITH_BENCH(name) cmocka_unit_test_setup_teardown(name, set_up, tear_down)

/* ------------------------------------------------------------------ studies */

static void submit_study(struct bench *bench, const char *act, char id[ID_SIZE]) {
    struct store_receipt receipt;
    struct store_submission submission = {
        .kind = STORE_STUDY, .request = act, .request_length = strlen(act), .digest = act};
    assert_int_equal(store_submit(bench->scratch.store, &submission, &receipt), STORE_OK);
    memcpy(id, receipt.id, ID_SIZE);
}

/* The numbers of all tasks, in order; `marked` is the variant of the first task of the second round
 * that is marked, -1 for none. */
static void expect_numbers(struct bench *bench, const char *id, int marked) {
    double wanted[ENGINE_ROUNDS][ENGINE_TASKS][2 + ENGINE_VARIANTS];
    wait_for(bench, id, STORE_SUCCEEDED);
    for (int round = 0; round < ENGINE_ROUNDS; round++) {
        for (int task = 0; task < ENGINE_TASKS; task++) {
            double *numbers = wanted[round][task];
            numbers[0] = round;
            numbers[1] = task;
            for (int k = 0; k < ENGINE_VARIANTS; k++)
                numbers[2 + k] = round == 1 && task == 0 && k == marked ? 0 : 1;
        }
    }
    scratch_expect_result(&bench->scratch, id, wanted, sizeof wanted, 100);
}

static void test_dispatcher_does_a_study_in_rounds(void **state) {
    struct bench *bench = *state;
    char id[ID_SIZE];
    for (int workers = 1; workers <= 3; workers += 2) {
        bench->settings.workers = workers;
        start(bench);
        submit_study(bench, workers == 1 ? "well" : "slow 20", id);
        expect_numbers(bench, id, -1);
        struct work_counts stats = final_stats(bench);
        assert_int_equal(stats.tasks, ENGINE_ROUNDS * ENGINE_TASKS);
        assert_int_equal(stats.crashes, 0);
        assert_int_equal(stats.succeeded, 1);
    }
}

/* The first death costs an attempt, at the second it is known which variant it was. */
static void test_dispatcher_marks_the_variant_that_crashes(void **state) {
    struct bench *bench = *state;
    char id[ID_SIZE];
    bench->settings.workers = 2;
    start(bench);
    submit_study(bench, "die 3", id);
    expect_numbers(bench, id, 3);
    expect_work(bench);
    assert_int_equal(final_stats(bench).crashes, 2);
}

static void test_dispatcher_marks_the_variant_that_hangs(void **state) {
    struct bench *bench = *state;
    char id[ID_SIZE];
    bench->settings.workers = 2;
    bench->settings.job_timeout_ms = SANDBOX_SANITIZED ? 3000 : 500;
    start(bench);
    submit_study(bench, "stall 0", id);
    expect_numbers(bench, id, 0);
    assert_int_equal(final_stats(bench).timeouts, 2);
}

static void test_dispatcher_ends_a_study_with_the_problem_of_a_task(void **state) {
    struct bench *bench = *state;
    struct store_counts counts;
    char id[ID_SIZE];
    bench->settings.workers = 2;
    start(bench);
    submit_study(bench, "fail", id);
    expect_error(bench, id, "/problems/out-of-memory", "not even one variant");
    submit_study(bench, "die-early", id);
    expect_error(bench, id, "/problems/solver-crashed", "died in all 3 attempts");
    assert_int_equal(store_counts(bench->scratch.store, &counts), STORE_OK);
    assert_int_equal(counts.tasks[0] + counts.tasks[1], 0);
    expect_work(bench);
}

/* Its workers are killed, not waited for. */
static void test_dispatcher_stops_the_tasks_of_a_cancelled_study(void **state) {
    struct bench *bench = *state;
    char id[ID_SIZE];
    struct store_counts counts = {0};
    bench->settings.workers = 2;
    start(bench);
    submit_study(bench, "slow 60000", id);
    for (int64_t until = clock_ms() + PATIENCE_MS; counts.tasks[1] < 2 && clock_ms() < until;)
        assert_int_equal(store_counts(bench->scratch.store, &counts), STORE_OK);
    assert_int_equal(counts.tasks[1], 2);
    assert_int_equal(store_cancel(bench->scratch.store, id), STORE_OK);
    expect_work(bench);
    assert_int_equal(scratch_status(&bench->scratch, id), STORE_CANCELLED);
}

/* What has been done when the daemon stops is not done again. */
static void test_dispatcher_goes_on_with_a_study_after_a_restart(void **state) {
    struct bench *bench = *state;
    struct store_job job = {0};
    char id[ID_SIZE];
    bench->settings.workers = 1;
    start(bench);
    submit_study(bench, "slow 30", id);
    for (int64_t until = clock_ms() + PATIENCE_MS; job.done < 3 && clock_ms() < until;) {
        assert_int_equal(store_get(bench->scratch.store, id, &job), STORE_OK);
        store_job_clear(&job);
    }
    assert_int_equal(job.status, STORE_RUNNING);
    int64_t done = final_stats(bench).tasks;
    assert_true(done > 0);
    start(bench);
    expect_numbers(bench, id, -1);
    assert_int_equal(final_stats(bench).tasks, ENGINE_ROUNDS * ENGINE_TASKS - done);
}

int main(int argc, char **argv) {
    engine_serve_if_worker(argc, argv);
    signal(SIGPIPE, SIG_IGN);
    const struct CMUnitTest tests[] = {
        WITH_BENCH(test_dispatcher_runs_a_job),
        WITH_BENCH(test_dispatcher_takes_what_was_queued_before),
        WITH_BENCH(test_dispatcher_hands_over_the_surface),
        WITH_BENCH(test_dispatcher_stores_progress),
        WITH_BENCH(test_dispatcher_stores_a_large_result),
        WITH_BENCH(test_dispatcher_shares_the_work_among_workers),
        WITH_BENCH(test_dispatcher_reuses_results),
        WITH_BENCH(test_dispatcher_passes_the_problem_on),
        WITH_BENCH(test_dispatcher_gives_a_crash_three_attempts),
        WITH_BENCH(test_dispatcher_succeeds_in_the_second_attempt),
        WITH_BENCH(test_dispatcher_names_the_exit_code),
        WITH_BENCH(test_dispatcher_does_not_believe_a_babbling_worker),
        WITH_BENCH(test_dispatcher_ends_what_takes_too_long),
        WITH_BENCH(test_dispatcher_refuses_too_large_a_result),
        WITH_BENCH(test_dispatcher_limits_the_memory),
        WITH_BENCH(test_worker_has_nothing_but_its_socket),
        WITH_BENCH(test_dispatcher_stops_a_cancelled_job),
        WITH_BENCH(test_dispatcher_stops_a_deleted_job),
        WITH_BENCH(test_dispatcher_sees_what_another_process_cancels),
        WITH_BENCH(test_dispatcher_survives_a_killed_worker),
        WITH_BENCH(test_dispatcher_bounds_its_worker),
        WITH_BENCH(test_dispatcher_gives_each_owner_a_new_worker),
        WITH_BENCH(test_dispatcher_replaces_a_worker_killed_at_rest),
        WITH_BENCH(test_dispatcher_renews_the_lease_of_a_stopped_worker),
        WITH_BENCH(test_dispatcher_stop_lets_jobs_finish),
        WITH_BENCH(test_dispatcher_stop_returns_jobs_after_the_grace),
        WITH_BENCH(test_dispatcher_restart_takes_up_what_a_killed_daemon_left),
        WITH_BENCH(test_dispatcher_takes_over_from_a_stopped_process),
    };
    const struct CMUnitTest studies[] = {
        WITH_BENCH(test_dispatcher_does_a_study_in_rounds),
        WITH_BENCH(test_dispatcher_marks_the_variant_that_crashes),
        WITH_BENCH(test_dispatcher_marks_the_variant_that_hangs),
        WITH_BENCH(test_dispatcher_ends_a_study_with_the_problem_of_a_task),
        WITH_BENCH(test_dispatcher_stops_the_tasks_of_a_cancelled_study),
        WITH_BENCH(test_dispatcher_goes_on_with_a_study_after_a_restart),
    };
    return scratch_run("dispatcher", studies, tests, sizeof tests / sizeof *tests);
}
