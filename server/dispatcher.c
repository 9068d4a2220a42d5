/* SPDX-License-Identifier: MIT */
#include "dispatcher.h"
#include "child.h"
#include "log.h"
#include <errno.h>
#include <poll.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <time.h>
#include <unistd.h>

enum {
    STORE_RETRY_MS = 500,  /* between two tries when the store is busy or down */
    START_RETRY_MS = 1000, /* between two tries to start a worker */
    NO_GRACE = -1
};

/* How a job on a worker ended. */
enum outcome {
    OUTCOME_NONE,    /* not yet */
    OUTCOME_DONE,    /* the result is whole, `text` is its summary */
    OUTCOME_PROBLEM, /* `text` is the problem document */
    OUTCOME_CRASHED, /* the worker died */
    OUTCOME_BROKEN,  /* the worker said what it must not */
    OUTCOME_TIMEOUT, /* over its time */
    OUTCOME_TOO_LARGE,
    OUTCOME_LOST,    /* cancelled, deleted or given to another */
    OUTCOME_RELEASED /* the daemon stops, or the store cannot take the result now */
};

/* A thread with its worker. */
struct lane {
    struct dispatcher *dispatcher;
    pthread_t thread;
    struct child child;
    int wake;  /* eventfd: look at the claim again, or stop */
    bool used; /* a worker has run here before */

    /* The job under way. */
    struct store_claim claim;
    struct store_writer *writer;
    enum outcome outcome;
    char *text; /* malloc'ed */
    double progress;
    int64_t written; /* bytes of the result */
    int64_t deadline_ms, renew_at_ms, progress_at_ms, look_at_ms;
};

struct counters {
    atomic_int_fast64_t busy, succeeded, failed, reused, stopped, crashes, timeouts, restarts;
};

struct dispatcher {
    struct store *store;
    struct hub *hub;
    struct dispatcher_settings settings;
    struct lane *lanes;
    int lane_count; /* threads that run */
    pthread_t sweeper;
    bool sweeping; /* the sweeper runs */
    struct hub_watch watch;

    pthread_mutex_t lock;
    pthread_cond_t idle;      /* lanes without a job wait here */
    pthread_cond_t sweep_now; /* the sweeper waits here */
    int hints;                /* jobs that may be there, at most one a lane */
    bool quiet;               /* no new claims */
    bool stopping;
    atomic_int_fast64_t stop_at_ms; /* when running jobs are released; NO_GRACE: not yet known */

    struct counters counters;
};

struct dispatcher_settings dispatcher_settings_default(void) {
    return (struct dispatcher_settings){
        .workers = 1,
        .job_timeout_ms = 600 * 1000,
        .renew_ms = 15 * 1000,
        .progress_ms = 200,
        .sweep_ms = 2000,
        .max_result = INT64_C(64) << 30,
        .limits = api_limits_default,
    };
}

static int64_t now_ms(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (int64_t)now.tv_sec * 1000 + now.tv_nsec / 1000000;
}

static struct timespec after_ms(int64_t ms) {
    struct timespec then;
    clock_gettime(CLOCK_MONOTONIC, &then);
    int64_t nanoseconds = then.tv_nsec + ms % 1000 * 1000000;
    then.tv_sec += ms / 1000 + nanoseconds / 1000000000;
    then.tv_nsec = nanoseconds % 1000000000;
    return then;
}

/* ------------------------------------------------------------------ waiting */

static void wake_lane(void *context) {
    struct lane *lane = context;
    uint64_t one = 1;
    ssize_t written = write(lane->wake, &one, sizeof one);
    (void)written; /* it only fails when it is awake already */
}

/* Called by the hub: there may be a job. */
static void hint(void *context) {
    struct dispatcher *dispatcher = context;
    pthread_mutex_lock(&dispatcher->lock);
    if (dispatcher->hints < dispatcher->settings.workers)
        dispatcher->hints++;
    pthread_cond_signal(&dispatcher->idle);
    pthread_mutex_unlock(&dispatcher->lock);
}

/* Waits for a hint or `ms`; false when no more work is to be taken. */
static bool wait_idle(struct dispatcher *dispatcher, int64_t ms, bool hints) {
    struct timespec then = after_ms(ms);
    int code = 0;
    pthread_mutex_lock(&dispatcher->lock);
    while (!dispatcher->quiet && !(hints && dispatcher->hints > 0) && code == 0)
        code = pthread_cond_timedwait(&dispatcher->idle, &dispatcher->lock, &then);
    if (hints && dispatcher->hints > 0)
        dispatcher->hints--;
    bool go_on = !dispatcher->quiet;
    pthread_mutex_unlock(&dispatcher->lock);
    return go_on;
}

static bool over_grace(struct dispatcher *dispatcher, int64_t now) {
    int64_t stop_at = atomic_load(&dispatcher->stop_at_ms);
    return stop_at != NO_GRACE && now >= stop_at;
}

/* ------------------------------------------------------------------ a job under way */

static void conclude(struct lane *lane, enum outcome outcome) {
    if (lane->outcome == OUTCOME_NONE)
        lane->outcome = outcome;
}

/* What the store answered to a write under the claim. */
static void conclude_answer(struct lane *lane, enum store_answer answer) {
    if (answer == STORE_CONFLICT)
        conclude(lane, OUTCOME_LOST);
    else if (answer != STORE_OK)
        conclude(lane, OUTCOME_RELEASED);
}

/* Renewal that fails because the store is down is tried again; if it stays down, the claim will
 * turn out to be lost. */
static void renew(struct lane *lane, int64_t now) {
    const struct dispatcher_settings *settings = &lane->dispatcher->settings;
    enum store_answer answer = store_renew(lane->dispatcher->store, &lane->claim, lane->progress);
    if (answer == STORE_CONFLICT)
        conclude(lane, OUTCOME_LOST);
    lane->renew_at_ms = now + (answer == STORE_OK ? settings->renew_ms : STORE_RETRY_MS);
    lane->progress_at_ms = now + settings->progress_ms;
}

static void look_at_claim(struct lane *lane, int64_t now) {
    if (store_check(lane->dispatcher->store, &lane->claim) == STORE_CONFLICT)
        conclude(lane, OUTCOME_LOST);
    lane->look_at_ms = now + DISPATCHER_POLL_MS;
}

/* The duties that do not depend on the worker. */
static void attend(struct lane *lane) {
    int64_t now = now_ms();
    if (now >= lane->deadline_ms)
        conclude(lane, OUTCOME_TIMEOUT);
    if (over_grace(lane->dispatcher, now))
        conclude(lane, OUTCOME_RELEASED);
    if (now >= lane->look_at_ms)
        look_at_claim(lane, now);
    if (now >= lane->renew_at_ms)
        renew(lane, now);
}

static int64_t least(int64_t a, int64_t b) {
    return a < b ? a : b;
}

/* Sleeps until the worker's socket is ready, a duty is due, or the lane is woken. */
static void wait_for_worker(struct lane *lane, short events) {
    struct pollfd files[2] = {{.fd = lane->child.socket, .events = events},
                              {.fd = lane->wake, .events = POLLIN}};
    int64_t due = least(least(lane->deadline_ms, lane->look_at_ms), lane->renew_at_ms);
    int64_t wait = due - now_ms();
    if (poll(files, 2, wait < 0 ? 0 : (int)least(wait, 60000)) <= 0)
        return;
    if (files[1].revents) {
        uint64_t count = 0;
        ssize_t got = read(lane->wake, &count, sizeof count);
        (void)got;
        lane->look_at_ms = 0;
    }
}

static void take_progress(struct lane *lane) {
    double fraction = 0;
    if (lane->child.inbox.head.length != sizeof fraction) {
        conclude(lane, OUTCOME_BROKEN);
        return;
    }
    memcpy(&fraction, lane->child.inbox.bytes, sizeof fraction);
    if (fraction > lane->progress && fraction <= 1.0)
        lane->progress = fraction;
    int64_t now = now_ms();
    if (now >= lane->progress_at_ms)
        renew(lane, now);
}

static void take_result(struct lane *lane) {
    size_t length = lane->child.inbox.head.length;
    lane->written += (int64_t)length;
    if (lane->written > lane->dispatcher->settings.max_result)
        conclude(lane, OUTCOME_TOO_LARGE);
    else
        conclude_answer(lane, store_writer_append(lane->writer, lane->child.inbox.bytes, length));
}

static void take_text(struct lane *lane, enum outcome outcome) {
    lane->text = strndup((const char *)lane->child.inbox.bytes, lane->child.inbox.head.length);
    conclude(lane, lane->text ? outcome : OUTCOME_RELEASED);
}

static void take_frame(struct lane *lane) {
    switch (lane->child.inbox.head.type) {
    case FRAME_PROGRESS:
        take_progress(lane);
        break;
    case FRAME_RESULT:
        take_result(lane);
        break;
    case FRAME_DONE:
        take_text(lane, OUTCOME_DONE);
        break;
    case FRAME_PROBLEM:
        take_text(lane, OUTCOME_PROBLEM);
        break;
    default:
        conclude(lane, OUTCOME_BROKEN);
    }
}

/* Sends the job; a worker that dies while it is sent is noticed by receiving. */
static void send_job(struct lane *lane, const struct api_input *input) {
    struct frame_outbox outbox;
    frame_outbox_fill(&outbox, input, &lane->dispatcher->settings.limits);
    while (lane->outcome == OUTCOME_NONE &&
           frame_push(lane->child.socket, &outbox) == FRAME_LATER) {
        wait_for_worker(lane, POLLOUT);
        attend(lane);
    }
}

static void receive_result(struct lane *lane) {
    while (lane->outcome == OUTCOME_NONE) {
        switch (frame_poll(lane->child.socket, &lane->child.inbox)) {
        case FRAME_READY:
            take_frame(lane);
            break;
        case FRAME_LATER:
            wait_for_worker(lane, POLLIN);
            break;
        case FRAME_CLOSED:
            conclude(lane, OUTCOME_CRASHED);
            break;
        case FRAME_BROKEN:
            conclude(lane, OUTCOME_BROKEN);
            break;
        }
        attend(lane);
    }
}

/* ------------------------------------------------------------------ its end */

/* A problem document in `lane->text`; without memory the job goes back to the queue. */
static void set_problem(struct lane *lane, enum api_problem_id id, const char *detail,
                        long long number) {
    struct api_problem problem = {0};
    char text[API_DETAIL_MAX];
    snprintf(text, sizeof text, "%s %lld.", detail, number);
    api_problem_set(&problem, id, "%s", text);
    free(lane->text);
    lane->text = api_problem_json(&problem, NULL);
    lane->outcome = lane->text ? OUTCOME_PROBLEM : OUTCOME_RELEASED;
}

/* Ends the worker unless it can go on with the next job, and turns what was the worker's fault into
 * what the store is to be told. `why` is set for OUTCOME_CRASHED. */
static void settle_worker(struct lane *lane, char why[CHILD_WHY_SIZE]) {
    struct dispatcher *dispatcher = lane->dispatcher;
    const struct dispatcher_settings *settings = &dispatcher->settings;
    if (lane->outcome == OUTCOME_DONE || lane->outcome == OUTCOME_PROBLEM)
        return;
    if (lane->outcome == OUTCOME_CRASHED)
        child_bury(&lane->child, why);
    child_kill(&lane->child);
    if (lane->outcome == OUTCOME_CRASHED || lane->outcome == OUTCOME_BROKEN)
        atomic_fetch_add(&dispatcher->counters.crashes, 1);
    if (lane->outcome == OUTCOME_BROKEN) {
        snprintf(why, CHILD_WHY_SIZE, "it sent what it must not");
        lane->outcome = OUTCOME_CRASHED;
    } else if (lane->outcome == OUTCOME_TIMEOUT) {
        atomic_fetch_add(&dispatcher->counters.timeouts, 1);
        set_problem(lane, API_JOB_TIMEOUT, "The longest a drape may take, in seconds:",
                    (long long)settings->job_timeout_ms / 1000);
    } else if (lane->outcome == OUTCOME_TOO_LARGE) {
        set_problem(lane, API_TOO_LARGE,
                    "The most a result may hold, in bytes:", (long long)settings->max_result);
    }
}

static enum store_answer tell_store(struct lane *lane, const char *why) {
    struct store *store = lane->dispatcher->store;
    switch (lane->outcome) {
    case OUTCOME_DONE:
        return store_writer_commit(lane->writer, lane->text);
    case OUTCOME_PROBLEM:
        return store_fail(store, &lane->claim, lane->text);
    case OUTCOME_CRASHED:
        return store_crashed(store, &lane->claim, why);
    case OUTCOME_RELEASED:
        return store_release(store, &lane->claim);
    default:
        return STORE_CONFLICT;
    }
}

static void count_outcome(struct lane *lane, enum store_answer answer) {
    struct counters *counters = &lane->dispatcher->counters;
    if (answer == STORE_CONFLICT)
        atomic_fetch_add(&counters->stopped, 1);
    else if (lane->outcome == OUTCOME_DONE)
        atomic_fetch_add(&counters->succeeded, 1);
    else if (lane->outcome == OUTCOME_PROBLEM)
        atomic_fetch_add(&counters->failed, 1);
}

static const char *outcome_name(enum outcome outcome) {
    static const char *const names[] = {"none",    "done",      "problem", "crashed", "broken",
                                        "timeout", "too large", "lost",    "released"};
    return names[outcome];
}

/* Tells the store, again and again while it is down: the work is done and must not be lost. When
 * the daemon stops meanwhile, the lease will end by itself. */
static void settle(struct lane *lane) {
    char why[CHILD_WHY_SIZE] = "";
    enum outcome seen = lane->outcome;
    settle_worker(lane, why);
    enum store_answer answer = tell_store(lane, why);
    while (answer == STORE_BUSY || answer == STORE_DOWN) {
        const struct timespec pause = {.tv_nsec = STORE_RETRY_MS * 1000000L};
        if (over_grace(lane->dispatcher, now_ms()))
            break;
        nanosleep(&pause, NULL);
        answer = tell_store(lane, why);
    }
    count_outcome(lane, answer);
    log_write(seen == OUTCOME_DONE ? LOG_LEVEL_DEBUG : LOG_LEVEL_INFO,
              LOG_FIELDS(log_event("job_left_worker"), log_text("job", lane->claim.id),
                         log_text("outcome", outcome_name(seen)), log_text("worker", why),
                         log_int("attempt", lane->claim.attempts),
                         log_text("store", store_answer_name(answer))));
}

/* ------------------------------------------------------------------ from claim to end */

/* The documents of the job; false when it cannot be worked on, with the outcome set. */
static bool load(struct lane *lane, struct api_input *input, char **request,
                 struct store_surface *surface) {
    struct store *store = lane->dispatcher->store;
    enum store_answer answer =
        store_request(store, lane->claim.id, request, &input->request_length);
    if (answer == STORE_OK && lane->claim.surface[0])
        answer = store_surface_get(store, lane->claim.surface, surface);
    input->request = *request;
    input->surface = surface->definition;
    input->surface_length = surface->definition_length;
    /* Neither can be missing while the job is running: it was deleted. */
    if (answer == STORE_EMPTY)
        conclude(lane, OUTCOME_LOST);
    else if (answer != STORE_OK)
        conclude(lane, OUTCOME_RELEASED);
    return answer == STORE_OK;
}

static void begin(struct lane *lane) {
    const struct dispatcher_settings *settings = &lane->dispatcher->settings;
    int64_t now = now_ms();
    lane->outcome = OUTCOME_NONE;
    lane->text = NULL;
    lane->progress = 0;
    lane->written = 0;
    lane->deadline_ms = now + settings->job_timeout_ms;
    lane->renew_at_ms = now + settings->renew_ms;
    lane->progress_at_ms = now + settings->progress_ms;
    lane->look_at_ms = now + DISPATCHER_POLL_MS;
    lane->writer = store_writer_new(lane->dispatcher->store, &lane->claim);
    if (!lane->writer)
        conclude(lane, OUTCOME_RELEASED);
}

static void run_job(struct lane *lane) {
    struct dispatcher *dispatcher = lane->dispatcher;
    struct hub_watch watch;
    struct api_input input = {0};
    struct store_surface surface = {0};
    char *request = NULL;
    begin(lane);
    atomic_fetch_add(&dispatcher->counters.busy, 1);
    hub_subscribe(dispatcher->hub, &watch, lane->claim.id, wake_lane, lane);
    if (lane->outcome == OUTCOME_NONE && load(lane, &input, &request, &surface)) {
        send_job(lane, &input);
        receive_result(lane);
    }
    hub_unsubscribe(dispatcher->hub, &watch);
    free(request);
    store_surface_clear(&surface);
    settle(lane);
    store_writer_free(lane->writer);
    free(lane->text);
    atomic_fetch_sub(&dispatcher->counters.busy, 1);
}

/* Sees to it that the lane has a worker; false when that has to wait. */
static bool ready_worker(struct lane *lane) {
    char why[CHILD_WHY_SIZE];
    struct pollfd file = {.fd = lane->child.socket, .events = POLLIN};
    /* An idle worker says nothing: what can be read is its end. */
    if (child_running(&lane->child) && poll(&file, 1, 0) > 0) {
        child_bury(&lane->child, why);
        log_warning(log_event("idle_worker_died"), log_text("worker", why));
    }
    if (child_running(&lane->child))
        return true;
    if (!child_start(&lane->child))
        return false;
    if (lane->used)
        atomic_fetch_add(&lane->dispatcher->counters.restarts, 1);
    lane->used = true;
    return true;
}

/* One turn: how long to wait for the next (0: not at all), and whether a hint ends the wait. */
static int64_t take_turn(struct lane *lane, bool *hints) {
    struct dispatcher *dispatcher = lane->dispatcher;
    *hints = false;
    if (!ready_worker(lane))
        return START_RETRY_MS;
    enum store_answer answer = store_claim(dispatcher->store, &lane->claim);
    if (answer == STORE_EMPTY) {
        *hints = true;
        return DISPATCHER_POLL_MS;
    }
    if (answer != STORE_OK)
        return STORE_RETRY_MS;
    if (lane->claim.reused)
        atomic_fetch_add(&dispatcher->counters.reused, 1);
    else
        run_job(lane);
    return 0;
}

static void *serve(void *context) {
    struct lane *lane = context;
    bool hints = false;
    int64_t wait = 0;
    do
        wait = take_turn(lane, &hints);
    while (wait_idle(lane->dispatcher, wait, hints));
    child_kill(&lane->child);
    return NULL;
}

/* ------------------------------------------------------------------ the sweeper */

static void sweep_once(struct dispatcher *dispatcher) {
    struct store_sweep sweep;
    do {
        enum store_answer answer = store_sweep(dispatcher->store, &sweep);
        if (answer != STORE_OK)
            return;
        if (sweep.requeued + sweep.failed + sweep.expired + sweep.removed > 0)
            log_info(log_event("store_swept"), log_int("requeued", sweep.requeued),
                     log_int("failed", sweep.failed), log_int("expired", sweep.expired),
                     log_int("removed", sweep.removed));
    } while (sweep.more && !over_grace(dispatcher, now_ms()));
}

static void *sweep(void *context) {
    struct dispatcher *dispatcher = context;
    pthread_mutex_lock(&dispatcher->lock);
    while (!dispatcher->stopping) {
        pthread_mutex_unlock(&dispatcher->lock);
        sweep_once(dispatcher);
        struct timespec then = after_ms(dispatcher->settings.sweep_ms);
        int code = 0;
        pthread_mutex_lock(&dispatcher->lock);
        while (!dispatcher->stopping && code == 0)
            code = pthread_cond_timedwait(&dispatcher->sweep_now, &dispatcher->lock, &then);
    }
    pthread_mutex_unlock(&dispatcher->lock);
    return NULL;
}

/* ------------------------------------------------------------------ start and stop */

static bool start_lane(struct dispatcher *dispatcher) {
    struct lane *lane = &dispatcher->lanes[dispatcher->lane_count];
    lane->dispatcher = dispatcher;
    lane->child.socket = -1;
    lane->wake = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    if (lane->wake < 0)
        return false;
    if (pthread_create(&lane->thread, NULL, serve, lane) != 0) {
        close(lane->wake);
        return false;
    }
    dispatcher->lane_count++;
    return true;
}

static void init_locks(struct dispatcher *dispatcher) {
    pthread_condattr_t monotonic;
    pthread_condattr_init(&monotonic);
    pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC);
    pthread_mutex_init(&dispatcher->lock, NULL);
    pthread_cond_init(&dispatcher->idle, &monotonic);
    pthread_cond_init(&dispatcher->sweep_now, &monotonic);
    pthread_condattr_destroy(&monotonic);
}

struct dispatcher *dispatcher_start(struct store *store, struct hub *hub,
                                    const struct dispatcher_settings *settings) {
    struct dispatcher *dispatcher = calloc(1, sizeof *dispatcher);
    struct lane *lanes = calloc((size_t)settings->workers + 1, sizeof *lanes);
    if (!dispatcher || !lanes) {
        free(dispatcher);
        free(lanes);
        return NULL;
    }
    dispatcher->store = store;
    dispatcher->hub = hub;
    dispatcher->settings = *settings;
    dispatcher->lanes = lanes;
    atomic_init(&dispatcher->stop_at_ms, NO_GRACE);
    init_locks(dispatcher);
    hub_subscribe(hub, &dispatcher->watch, hub_queue, hint, dispatcher);
    dispatcher->sweeping = pthread_create(&dispatcher->sweeper, NULL, sweep, dispatcher) == 0;
    while (dispatcher->lane_count < settings->workers && start_lane(dispatcher))
        continue;
    if (dispatcher->sweeping && dispatcher->lane_count == settings->workers)
        return dispatcher;
    log_error(log_event("dispatcher_start_failed"), log_int("threads", dispatcher->lane_count));
    dispatcher_stop(dispatcher, 0);
    return NULL;
}

void dispatcher_quiesce(struct dispatcher *dispatcher) {
    pthread_mutex_lock(&dispatcher->lock);
    dispatcher->quiet = true;
    pthread_cond_broadcast(&dispatcher->idle);
    pthread_mutex_unlock(&dispatcher->lock);
}

static void stop_sweeper(struct dispatcher *dispatcher) {
    pthread_mutex_lock(&dispatcher->lock);
    dispatcher->stopping = true;
    pthread_cond_broadcast(&dispatcher->sweep_now);
    pthread_mutex_unlock(&dispatcher->lock);
    if (dispatcher->sweeping)
        pthread_join(dispatcher->sweeper, NULL);
}

void dispatcher_stop(struct dispatcher *dispatcher, int64_t grace_ms) {
    if (!dispatcher)
        return;
    dispatcher_quiesce(dispatcher);
    atomic_store(&dispatcher->stop_at_ms, now_ms() + grace_ms);
    for (int k = 0; k < dispatcher->lane_count; k++) {
        wake_lane(&dispatcher->lanes[k]);
        pthread_join(dispatcher->lanes[k].thread, NULL);
        close(dispatcher->lanes[k].wake);
    }
    stop_sweeper(dispatcher);
    hub_unsubscribe(dispatcher->hub, &dispatcher->watch);
    pthread_mutex_destroy(&dispatcher->lock);
    pthread_cond_destroy(&dispatcher->idle);
    pthread_cond_destroy(&dispatcher->sweep_now);
    free(dispatcher->lanes);
    free(dispatcher);
}

void dispatcher_stats(struct dispatcher *dispatcher, struct dispatcher_stats *stats) {
    struct counters *counters = &dispatcher->counters;
    stats->busy = atomic_load(&counters->busy);
    stats->succeeded = atomic_load(&counters->succeeded);
    stats->failed = atomic_load(&counters->failed);
    stats->reused = atomic_load(&counters->reused);
    stats->stopped = atomic_load(&counters->stopped);
    stats->crashes = atomic_load(&counters->crashes);
    stats->timeouts = atomic_load(&counters->timeouts);
    stats->restarts = atomic_load(&counters->restarts);
}
