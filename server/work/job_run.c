/* SPDX-License-Identifier: MIT */
#include "job_run.h"
#include "api/json/text.h"
#include "api/request/digest.h"
#include "api/study/study.h"
#include "form_cache.h"
#include "frame.h"
#include "sandbox.h"
#include "server/clock.h"
#include "server/log.h"
#include "server/metrics.h"
#include <errno.h>
#include <math.h>
#include <poll.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/resource.h>
#include <unistd.h>

enum {
    CPU_MARGIN_SECONDS = 30,
    TASK_ATTEMPTS = 16, /* of a task, of which any number are not held against it */
    KEPT_MOST = 64 << 20,
    BEST_SIZE = 64 * QUANTITY_COUNT /* of each its name and a number */
};
#define MEMORY_BESIDE_BYTES (UINT64_C(1) << 30)
#define DOCUMENTS_BYTES (UINT64_C(4) << 30) /* more than any request and surface together */

_Static_assert((int)FRAME_TASK_BYTES <= (int)STORE_TASK_BYTES, "a task fits");

/* How a job on a worker ended. */
enum outcome {
    ENDED_NONE,    /* not yet */
    ENDED_DONE,    /* the result is whole, `text` is its summary */
    ENDED_ROUND,   /* a step of a study began a round: its tasks are in `kept` */
    ENDED_PROBLEM, /* `text` is the problem document */
    ENDED_CRASHED, /* the worker died */
    ENDED_BROKEN,  /* the worker said what it must not */
    ENDED_TIMEOUT, /* over its time */
    ENDED_TOO_LARGE,
    ENDED_LOST,     /* cancelled, deleted or given to another */
    ENDED_RELEASED, /* the daemon stops, or the store cannot take the result now */
    ENDED_YIELDED   /* it gave way to other owners' jobs */
};

struct job_run {
    struct job_run_shared *shared;
    const struct store_claim *claim;
    struct child *child;
    int wake;
    struct store_writer *writer;
    enum outcome outcome;
    char *text; /* malloc'ed */
    double progress;
    int64_t written; /* bytes of the result */
    int64_t deadline_ms, renew_at_ms, progress_at_ms, look_at_ms;
    bool fast;                /* nothing is claimed with its end */
    struct store_claim *next; /* what is */
    int64_t processor_us;     /* of the worker, when it began */
    int64_t yield_at_ms;      /* from when it gives way */
    int64_t starved_since_ms; /* as far as this run has seen; 0: nobody waits with nothing */
    int form;                 /* the file with the prepared form; -1: none */
    /* of studies */
    unsigned char *kept; /* malloc'ed: the tasks of a round, or the numbers of a task */
    size_t kept_length;
    struct frame_round round;
    double variant;    /* of a task, that was under way last; -1: not known */
    int64_t solved_us; /* how long the worker took */
};

bool job_run_out_of_time(struct job_run_shared *shared) {
    int64_t stop_at = atomic_load(&shared->stop_at_ms);
    return stop_at != JOB_RUN_NO_STOP && clock_ms() >= stop_at;
}

void job_run_wake(void *wake) {
    uint64_t one = 1;
    (void)!write(*(const int *)wake, &one, sizeof one); /* it only fails when it is awake already */
}

/* The job whose request it is, and whose end would end it: of a task its study. */
static const char *subject_of_run(const struct job_run *run) {
    const struct store_claim *claim = run->claim;
    return claim->kind == STORE_TASK ? claim->parent : claim->id;
}

/* ------------------------------------------------------------------ under way */

static void end_run(struct job_run *run, enum outcome outcome) {
    if (run->outcome == ENDED_NONE)
        run->outcome = outcome;
}

/* Renewal that fails because the store is down is tried again; if it stays down, the claim will
 * turn out to be lost. */
static void renew_lease(struct job_run *run, int64_t now) {
    const struct dispatcher_settings *settings = &run->shared->settings;
    enum store_answer answer = store_renew(run->shared->store, run->claim, run->progress);
    if (answer == STORE_CONFLICT)
        end_run(run, ENDED_LOST);
    run->renew_at_ms = now + (answer == STORE_OK ? settings->renew_ms : JOB_RUN_RETRY_MS);
    run->progress_at_ms = now + settings->progress_ms;
}

/* Of the processor, for a job of the fast worker. */
static int64_t fast_left_ms(const struct job_run *run) {
    int64_t used = sandbox_processor_us(run->child->pid) - run->processor_us;
    return JOB_RUN_FAST_MS - used / 1000;
}

/* The duties that do not depend on the worker. A job gives way that has had its turn, when another
 * owner has waited long enough. Of the jobs of this process one at a time gives way: that may be
 * all that is needed. */
static void attend_to_duties(struct job_run *run) {
    struct job_run_shared *shared = run->shared;
    int64_t now = clock_ms();
    if (now >= run->deadline_ms)
        end_run(run, ENDED_TIMEOUT);
    if (job_run_out_of_time(shared))
        end_run(run, ENDED_RELEASED);
    if (now >= run->look_at_ms) {
        bool had_turn = now >= run->yield_at_ms;
        if (store_check(shared->store, run->claim) == STORE_CONFLICT) {
            end_run(run, ENDED_LOST);
        } else if (run->fast && (had_turn || fast_left_ms(run) <= 0)) {
            end_run(run, ENDED_YIELDED);
        } else if (!run->fast && had_turn) {
            bool starved = store_starving(shared->store, false) == STORE_OK;
            int64_t since = run->starved_since_ms ? run->starved_since_ms : now;
            int_fast64_t last = atomic_load(&shared->yielded_ms);
            run->starved_since_ms = starved ? since : 0;
            if (starved && now - since >= JOB_RUN_STARVED_MS && now - last >= JOB_RUN_STARVED_MS &&
                atomic_compare_exchange_strong(&shared->yielded_ms, &last, now))
                end_run(run, ENDED_YIELDED);
        }
        run->look_at_ms = now + (run->fast ? fast_left_ms(run) + 1 : WORK_POLL_MS);
    }
    if (now >= run->renew_at_ms)
        renew_lease(run, now);
}

static int64_t least(int64_t a, int64_t b) {
    return a < b ? a : b;
}

/* Sleeps until the worker's socket is ready, a duty is due, or the thread is woken. */
static void wait_for_worker(struct job_run *run, short events) {
    int64_t stop_at = atomic_load(&run->shared->stop_at_ms);
    int64_t due = least(least(run->deadline_ms, run->look_at_ms), run->renew_at_ms);
    if (stop_at != JOB_RUN_NO_STOP)
        due = least(due, stop_at);
    if (child_wait(run->child, events, run->wake, due - clock_ms()))
        run->look_at_ms = 0;
}

/* Keeps what goes to the store at the end alone. */
static void keep_bytes(struct job_run *run) {
    size_t length = run->child->inbox.head.length;
    unsigned char *kept = NULL;
    if (run->kept_length + length <= KEPT_MOST)
        kept = realloc(run->kept, run->kept_length + length + 1);
    if (!kept) {
        end_run(run, ENDED_TOO_LARGE);
        return;
    }
    memcpy(kept + run->kept_length, run->child->inbox.bytes, length);
    run->kept = kept;
    run->kept_length += length;
}

/* Passes on what the worker has sent. */
static void take_frame(struct job_run *run) {
    const struct frame_inbox *inbox = &run->child->inbox;
    bool task = run->claim->kind == STORE_TASK, study = run->claim->kind == STORE_STUDY;
    bool good = true;
    double fraction;
    enum store_answer answer = STORE_OK;
    switch (inbox->head.type) {
    case FRAME_PROGRESS:
        good = inbox->head.length == sizeof fraction;
        if (!good)
            break;
        memcpy(&fraction, inbox->bytes, sizeof fraction);
        if (task)
            run->variant = fraction;
        else if (fraction > run->progress && fraction <= 1.0)
            run->progress = fraction;
        if (!task && clock_ms() >= run->progress_at_ms)
            renew_lease(run, clock_ms());
        break;
    case FRAME_RESULT:
        if (task) {
            keep_bytes(run);
            break;
        }
        run->written += (int64_t)inbox->head.length;
        if (run->written > run->shared->settings.max_result)
            end_run(run, ENDED_TOO_LARGE);
        else
            answer = store_writer_append(run->writer, inbox->bytes, inbox->head.length);
        if (answer != STORE_OK)
            end_run(run, answer == STORE_CONFLICT ? ENDED_LOST : ENDED_RELEASED);
        break;
    case FRAME_TASKS:
        good = study;
        if (good)
            keep_bytes(run);
        break;
    case FRAME_ROUND:
        good = study && run->kept_length > 0 && run->kept_length % sizeof(struct frame_task) == 0 &&
               inbox->head.length == sizeof run->round;
        if (!good)
            break;
        memcpy(&run->round, inbox->bytes, sizeof run->round);
        end_run(run, ENDED_ROUND);
        break;
    case FRAME_DONE:
    case FRAME_PROBLEM:
        run->text = strndup((const char *)inbox->bytes, inbox->head.length);
        end_run(run, !run->text                       ? ENDED_RELEASED
                     : inbox->head.type == FRAME_DONE ? ENDED_DONE
                                                      : ENDED_PROBLEM);
        break;
    default:
        good = false;
    }
    if (!good)
        end_run(run, ENDED_BROKEN);
}

bool job_run_bound(const struct job_run_shared *shared, const struct child *child) {
    uint64_t memory = (uint64_t)shared->settings.limits.max_memory + MEMORY_BESIDE_BYTES;
    if (sandbox_bound_for_good(child->pid, RLIMIT_AS, memory + DOCUMENTS_BYTES))
        return true;
    log_error(log_event("worker_not_bounded"), log_text("detail", strerror(errno)));
    return false;
}

/* Bounds the worker, sends it the job and receives the result. One that dies while it is sent the
 * job is noticed by receiving. Its memory is the job's own budget, and beside it the program
 * itself, the documents, and the JSON tree of a body at its limits. The processor's bound is for
 * the case that nothing watches the deadline. */
static void have_done(struct job_run *run, struct frame_job *job, const void *bytes,
                      const struct api_input *input) {
    const struct dispatcher_settings *settings = &run->shared->settings;
    /* a study is kept beside its task */
    uint64_t budgets = run->claim->kind == STORE_DRAPE ? 1 : 2;
    uint64_t memory = budgets * (uint64_t)settings->limits.max_memory + MEMORY_BESIDE_BYTES +
                      budgets * (input->request_length + input->surface_length) + job->form_length;
    uint64_t threads = settings->limits.threads > 1 ? (uint64_t)settings->limits.threads : 1;
    uint64_t seconds = (uint64_t)(settings->job_timeout_ms / 1000 + CPU_MARGIN_SECONDS) * threads;
    struct frame_outbox outbox;
    job->limits = settings->limits;
    frame_outbox_fill(&outbox, job, bytes, input, &run->form);
    if (!child_bound(run->child, RLIMIT_AS, memory) ||
        !sandbox_bound_processor(run->child->pid, seconds))
        end_run(run, ENDED_RELEASED);
    while (run->outcome == ENDED_NONE && frame_push(run->child->socket, &outbox) == FRAME_LATER) {
        wait_for_worker(run, POLLOUT);
        attend_to_duties(run);
    }
    while (run->outcome == ENDED_NONE) {
        switch (frame_poll(run->child->socket, &run->child->inbox)) {
        case FRAME_READY:
            take_frame(run);
            break;
        case FRAME_LATER:
            wait_for_worker(run, POLLIN);
            break;
        case FRAME_CLOSED:
            end_run(run, ENDED_CRASHED);
            break;
        case FRAME_BROKEN:
            end_run(run, ENDED_BROKEN);
            break;
        }
        attend_to_duties(run);
    }
}

/* ------------------------------------------------------------------ its end */

/* A problem document in `run->text`; without memory the job goes back to the queue. */
static void set_problem(struct job_run *run, enum api_problem_id id, const char *detail,
                        long long number) {
    struct api_problem problem = {0};
    api_problem_set(&problem, id, "%s %lld.", detail, number);
    free(run->text);
    run->text = api_problem_json(&problem, NULL);
    run->outcome = run->text ? ENDED_PROBLEM : ENDED_RELEASED;
}

/* Ends the worker unless it can go on with the next job, and turns what was the worker's fault into
 * what is to be reported to the store. `why` is set for ENDED_CRASHED. */
static void end_worker(struct job_run *run, char why[CHILD_WHY_SIZE]) {
    struct job_run_shared *shared = run->shared;
    const struct dispatcher_settings *settings = &shared->settings;
    if (run->outcome == ENDED_DONE || run->outcome == ENDED_ROUND || run->outcome == ENDED_PROBLEM)
        return;
    if (run->outcome == ENDED_CRASHED)
        child_reap(run->child, why);
    child_kill(run->child);
    if (run->outcome == ENDED_CRASHED || run->outcome == ENDED_BROKEN)
        atomic_fetch_add(&shared->counters.crashes, 1);
    if (run->outcome == ENDED_BROKEN) {
        snprintf(why, CHILD_WHY_SIZE, "it sent an invalid frame");
        run->outcome = ENDED_CRASHED;
    } else if (run->outcome == ENDED_TIMEOUT) {
        atomic_fetch_add(&shared->counters.timeouts, 1);
        if (run->claim->kind == STORE_TASK) { /* one of its drapes is to blame */
            snprintf(why, CHILD_WHY_SIZE, "it took longer than a job may");
            run->outcome = ENDED_CRASHED;
            return;
        }
        set_problem(run, API_JOB_TIMEOUT, "The longest a drape may take, in seconds:",
                    (long long)settings->job_timeout_ms / 1000);
    } else if (run->outcome == ENDED_TOO_LARGE) {
        set_problem(run, API_TOO_LARGE,
                    "The most a result may hold, in bytes:", (long long)settings->max_result);
    }
}

/* Stores the tasks of a study's next round, and what the study has found so far: an object of its
 * objectives. */
static enum store_answer begin_round(struct job_run *run) {
    char best[BEST_SIZE];
    struct api_text text = api_text_over(best, sizeof best);
    const struct frame_task *tasks = (const void *)run->kept; /* malloc'ed */
    size_t count = run->kept_length / sizeof *tasks;
    size_t length = tasks->length < STORE_TASK_BYTES ? tasks->length : STORE_TASK_BYTES;
    unsigned char *bytes = calloc(count, STORE_TASK_BYTES);
    int64_t *variants = calloc(count, sizeof *variants);
    for (int k = 0; k < QUANTITY_COUNT; k++) {
        if (!isfinite(run->round.best[k]))
            continue;
        api_text_raw(&text, text.length == 0 ? "{" : "");
        api_text_key_number(&text, quantities[k].name, run->round.best[k]);
    }
    bool any = text.length > 0;
    api_text_raw(&text, any ? "}" : "");
    for (size_t k = 0; bytes && variants && k < count; k++) {
        memcpy(bytes + k * length, tasks[k].bytes, length);
        variants[k] = (int64_t)tasks[k].variants;
    }
    struct store_round round = {.tasks = bytes,
                                .variants = variants,
                                .length = length,
                                .count = count,
                                .done = (int64_t)run->round.done,
                                .total = (int64_t)run->round.total,
                                .best = any ? api_text_finish(&text) : NULL};
    enum store_answer answer = bytes && variants
                                   ? store_begin_round(run->shared->store, run->claim, &round)
                                   : store_release(run->shared->store, run->claim);
    free(bytes);
    free(variants);
    return answer;
}

/* Where to put what is claimed with the end; NULL where nothing may be, as when the daemon stops.
 */
static struct store_claim *next_wanted(const struct job_run *run) {
    return atomic_load(&run->shared->stop_at_ms) == JOB_RUN_NO_STOP ? run->next : NULL;
}

/* A task whose worker died before, and again now, while it looked at a variant that is known: that
 * one is to blame and marked, and costs the task no attempt. There is an end to that (study.h). */
static enum store_answer tell_store(struct job_run *run, const char *why) {
    struct store *store = run->shared->store;
    const struct store_claim *claim = run->claim;
    struct api_study_task task;
    bool to_blame = claim->kind == STORE_TASK && claim->attempts > 1 && run->variant >= 0 &&
                    claim->attempts < TASK_ATTEMPTS && claim->task_length == sizeof task;
    switch (run->outcome) {
    case ENDED_DONE:
        return claim->kind == STORE_TASK
                   ? store_end_task(store, claim, run->kept, run->kept_length, run->solved_us)
                   : store_writer_commit_and_claim(run->writer, run->text, next_wanted(run));
    case ENDED_ROUND:
        return begin_round(run);
    case ENDED_PROBLEM:
        return store_fail(store, claim, run->text);
    case ENDED_CRASHED:
        if (!to_blame)
            return store_crashed(store, claim, why);
        memcpy(&task, claim->task, sizeof task);
        api_study_task_crashed(&task, (size_t)run->variant);
        return store_change_task(store, claim, &task);
    case ENDED_RELEASED:
        return store_release(store, claim);
    case ENDED_YIELDED:
        return store_yield(store, claim);
    default:
        return STORE_CONFLICT;
    }
}

/* Reports to the store, again and again while it is down: the work is done and must not be lost.
 * When the daemon stops meanwhile, the lease will end by itself. */
static void report_outcome(struct job_run *run) {
    static const char *const names[] = {"none",    "done",     "round",   "problem",
                                        "crashed", "broken",   "timeout", "too large",
                                        "lost",    "released", "yielded"};
    const struct timespec pause = {.tv_nsec = JOB_RUN_RETRY_MS * 1000000L};
    struct work_counters *counters = &run->shared->counters;
    char why[CHILD_WHY_SIZE] = "";
    bool task = run->claim->kind == STORE_TASK;
    enum outcome seen = run->outcome;
    end_worker(run, why);
    enum store_answer answer = tell_store(run, why);
    while (store_failed(answer) && !job_run_out_of_time(run->shared)) {
        nanosleep(&pause, NULL);
        answer = tell_store(run, why);
    }
    if (task)
        atomic_fetch_add(&counters->tasks, answer == STORE_OK && run->outcome == ENDED_DONE);
    else if (answer == STORE_CONFLICT)
        atomic_fetch_add(&counters->stopped, 1);
    else if (run->outcome == ENDED_DONE)
        atomic_fetch_add(&counters->succeeded, 1);
    else if (run->outcome == ENDED_PROBLEM)
        atomic_fetch_add(&counters->failed, 1);
    bool harmed = seen == ENDED_CRASHED || seen == ENDED_BROKEN || seen == ENDED_TIMEOUT;
    if (task && !harmed && !store_failed(answer))
        return; /* there are many */
    log_write(harmed || store_failed(answer) ? LOG_LEVEL_WARNING : LOG_LEVEL_INFO,
              LOG_FIELDS(log_event("job_left_worker"),
                         log_text(run->claim->kind == STORE_DRAPE ? "drape" : "study",
                                  subject_of_run(run)),
                         log_word("request_id", run->claim->origin),
                         log_text("outcome", names[seen]), log_text("worker", why),
                         log_int("attempt", run->claim->attempts),
                         log_text("store", store_answer_name(answer))));
}

/* ------------------------------------------------------------------ from claim to end */

/* The form that the check of the request has made, or that of the surface that it names: with it
 * the worker needs no definition. Returns its length. */
static size_t find_form(struct job_run *run, const char *request, size_t length) {
    const struct store_claim *claim = run->claim;
    struct form_cache *forms = run->shared->settings.forms;
    char text[API_ID_SIZE];
    size_t form_length = 0;
    api_digest_bytes(request, length, text);
    run->form = form_cache_get(forms, claim->owner, text, &form_length);
    if (run->form < 0 && claim->surface[0])
        run->form = form_cache_get(forms, claim->owner, claim->surface, &form_length);
    return run->form >= 0 ? form_length : 0;
}

/* The request, the surface or what tasks have found is not what was written: no try mends it. */
static void set_altered(struct job_run *run) {
    struct api_problem problem = {0};
    api_problem_set(&problem, API_DAMAGED,
                    "What the store has of this job, or of its surface, is damaged: post both "
                    "again, or restore a back-up of before.");
    run->text = api_problem_json(&problem, NULL);
    end_run(run, run->text ? ENDED_PROBLEM : ENDED_RELEASED);
}

/* Fetches the documents of the job, and of a study the numbers so far, and has the worker do it. */
static void solve_job(struct job_run *run) {
    struct store *store = run->shared->store;
    const struct store_claim *claim = run->claim;
    bool drape = claim->kind == STORE_DRAPE, task = claim->kind == STORE_TASK;
    struct frame_job order = {.kind = drape  ? FRAME_DRAPE
                                      : task ? FRAME_TASK
                                             : FRAME_STEP,
                              .careful = task && claim->attempts > 1,
                              .spent_ms = (double)claim->spent / 1000};
    struct api_input input = {0};
    struct store_item surface = {0};
    char *request = NULL;
    void *numbers = NULL;
    size_t length = 0;
    if (drape && claim->attempts == 1 && claim->waited_us >= 0)
        metrics_time(METRICS_QUEUE, claim->waited_us);
    enum store_answer answer =
        store_request(store, subject_of_run(run), &request, &input.request_length);
    if (answer == STORE_OK && claim->kind == STORE_STUDY)
        answer = store_numbers(store, claim, &numbers, &length);
    if (answer == STORE_OK)
        order.form_length = find_form(run, request, input.request_length);
    order.form_kept = claim->surface[0] != '\0';
    if (answer == STORE_OK && claim->surface[0] && run->form < 0)
        answer = store_item_get(store, STORE_SURFACES, NULL, claim->surface, &surface);
    /* None can be missing while the job is running: it was deleted. */
    if (answer == STORE_EMPTY)
        end_run(run, ENDED_LOST);
    else if (answer == STORE_ALTERED)
        set_altered(run);
    else if (answer != STORE_OK)
        end_run(run, ENDED_RELEASED);
    if (answer == STORE_OK) {
        int64_t begun = clock_us();
        order.length = task ? claim->task_length : length;
        input.request = request;
        input.surface = surface.definition;
        input.surface_length = surface.definition_length;
        have_done(run, &order, task ? claim->task : numbers, &input);
        run->solved_us = clock_us() - begun;
        if (drape && run->outcome == ENDED_DONE)
            metrics_time(METRICS_SOLVE, run->solved_us);
    }
    free(numbers);
    free(request);
    store_item_clear(&surface);
}

bool job_run(struct job_run_shared *shared, const struct store_claim *claim, struct child *child,
             int wake, struct store_claim *next) {
    const bool fast = next == NULL;
    int doublings = claim->attempts < 16 ? claim->attempts - 1 : 15;
    int64_t now = clock_ms();
    struct job_watch watch;
    struct job_run run = {
        .shared = shared,
        .claim = claim,
        .child = child,
        .wake = wake,
        .writer = store_writer_new(shared->store, claim),
        .deadline_ms = now + shared->settings.job_timeout_ms,
        .renew_at_ms = now + shared->settings.renew_ms,
        .progress_at_ms = now + shared->settings.progress_ms,
        .look_at_ms = now + (fast ? JOB_RUN_FAST_MS : WORK_POLL_MS),
        .fast = fast,
        .next = next,
        .variant = -1,
        .form = -1,
        .processor_us = sandbox_processor_us(child->pid),
        .yield_at_ms = now + (fast ? JOB_RUN_FAST_MOST_MS : (int64_t)JOB_RUN_TURN_MS << doublings),
    };
    atomic_fetch_add(&shared->counters.busy, 1);
    job_events_subscribe(shared->events, &watch, subject_of_run(&run), JOB_CHANGED, job_run_wake,
                         &run.wake);
    if (run.writer)
        solve_job(&run);
    else
        end_run(&run, ENDED_RELEASED);
    job_events_unsubscribe(shared->events, &watch);
    report_outcome(&run);
    store_writer_free(run.writer);
    if (run.form >= 0)
        close(run.form);
    free(run.text);
    free(run.kept);
    atomic_fetch_sub(&shared->counters.busy, 1);
    return run.outcome != ENDED_RELEASED;
}
