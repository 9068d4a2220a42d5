/* SPDX-License-Identifier: MIT */
#include "dispatcher.h"
#include "child.h"
#include "job_run.h"
#include "server/clock.h"
#include "server/config.h"
#include "server/log.h"
#include "worker.h"
#include <poll.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

enum {
    START_RETRY_MS = 1000, /* between two tries to start a worker */
    EXPRESS_MS = 5,        /* the express lane looks when no other has ended a job for so long */
    NICENESS = 5 /* of the workers but the express one: callers are answered before they go on */
};

/* A thread with its worker. */
struct lane {
    struct dispatcher *dispatcher;
    pthread_t thread;
    struct child child;
    int wake;                     /* eventfd of its attempts */
    bool used;                    /* a worker has run here before */
    bool express;                 /* takes what the others are too busy for */
    bool served;                  /* this worker has had a job, of this owner */
    char owner[STORE_OWNER_SIZE]; /* "" is one too */
};

struct dispatcher {
    struct job_run_shared shared;
    struct lane *lanes;
    int lane_count; /* threads that run */
    pthread_t sweeper;
    bool sweeping; /* the sweeper runs */
    struct job_watch watch;

    pthread_mutex_t lock;
    pthread_cond_t idle;      /* lanes without a job wait here */
    pthread_cond_t all_busy;  /* the express lane waits here */
    int busy;                 /* lanes but the express one with a job */
    unsigned ended;           /* jobs that these have ended */
    pthread_cond_t sweep_now; /* the sweeper waits here */
    int hints;                /* jobs that may be there, at most one a lane */
    bool quiet;               /* no new claims */
    bool stopping;
};

/* ------------------------------------------------------------------ waiting */

/* Called by the job events: there may be a job. */
static void hint(void *context) {
    struct dispatcher *dispatcher = context;
    pthread_mutex_lock(&dispatcher->lock);
    if (dispatcher->hints < dispatcher->shared.settings.workers)
        dispatcher->hints++;
    pthread_cond_signal(&dispatcher->idle);
    if (dispatcher->busy == dispatcher->shared.settings.workers)
        pthread_cond_signal(&dispatcher->all_busy);
    pthread_mutex_unlock(&dispatcher->lock);
}

/* Waits for a hint or `ms`; false when no more work is to be taken. */
static bool wait_idle(struct dispatcher *dispatcher, int64_t ms, bool hints) {
    struct timespec then = clock_after_ms(ms);
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

/* ------------------------------------------------------------------ a lane */

/* Starts the lane's worker when it has none; false when that has to wait. */
static bool ready_worker(struct lane *lane) {
    char why[CHILD_WHY_SIZE];
    struct pollfd file = {.fd = lane->child.socket, .events = POLLIN};
    /* An idle worker says nothing: what can be read is its end. */
    if (child_running(&lane->child) && poll(&file, 1, 0) > 0) {
        child_reap(&lane->child, why);
        log_warning(log_event("idle_worker_died"), log_text("worker", why));
    }
    if (child_running(&lane->child))
        return true;
    if (!child_start(&lane->child, NULL, WORKER_ARGUMENT))
        return false;
    if (!job_run_bound(&lane->dispatcher->shared, &lane->child)) {
        child_kill(&lane->child);
        return false;
    }
    if (!lane->express)
        child_lower(&lane->child, NICENESS);
    if (lane->used)
        atomic_fetch_add(&lane->dispatcher->shared.counters.restarts, 1);
    lane->used = true;
    lane->served = false;
    return true;
}

/* A worker serves one owner: should a request take it over, it has nothing of another's to tell,
 * and no other's result to falsify. */
static bool take_owner(struct lane *lane, const char *owner) {
    if (lane->served && strcmp(lane->owner, owner) != 0)
        child_kill(&lane->child);
    if (!child_running(&lane->child) && !ready_worker(lane))
        return false;
    lane->served = true;
    snprintf(lane->owner, sizeof lane->owner, "%s", owner);
    return true;
}

/* A lane but the express one has got a job, or is done with it. */
static void count_busy(struct lane *lane, int more) {
    struct dispatcher *dispatcher = lane->dispatcher;
    if (lane->express)
        return;
    pthread_mutex_lock(&dispatcher->lock);
    dispatcher->busy += more;
    dispatcher->ended += more < 0;
    if (dispatcher->busy == dispatcher->shared.settings.workers)
        pthread_cond_signal(&dispatcher->all_busy);
    pthread_mutex_unlock(&dispatcher->lock);
}

/* Works on the claimed job: how long to wait then. Where there is one task there are more: whoever
 * claims one has the next lane look. */
static int64_t work(struct lane *lane, const struct store_claim *claim) {
    struct job_run_shared *shared = &lane->dispatcher->shared;
    if (claim->kind == STORE_TASK)
        hint(lane->dispatcher);
    if (claim->reused) {
        atomic_fetch_add(&shared->counters.reused, 1);
        return 0;
    }
    if (!take_owner(lane, claim->owner)) {
        enum store_answer answer = store_release(shared->store, claim);
        (void)answer; /* failed: the lease ends */
        return START_RETRY_MS;
    }
    count_busy(lane, 1);
    bool good = job_run(shared, claim, &lane->child, lane->wake, lane->express);
    count_busy(lane, -1);
    return good ? 0 : JOB_RUN_RETRY_MS;
}

/* One turn: how long to wait for the next (0: not at all), and whether a hint ends the wait. The
 * express lane's worker is started with its first job. */
static int64_t take_turn(struct lane *lane, bool *hints) {
    struct store *store = lane->dispatcher->shared.store;
    struct store_claim claim;
    *hints = false;
    if (!lane->express && !ready_worker(lane))
        return START_RETRY_MS;
    enum store_answer answer =
        lane->express ? store_starving(store, true) : store_claim(store, &claim);
    if (lane->express &&
        answer == STORE_OK) /* a read is enough to find out that it is not needed */
        answer = store_claim_fresh(store, &claim);
    if (answer == STORE_EMPTY) {
        *hints = true;
        return WORK_POLL_MS;
    }
    return answer == STORE_OK ? work(lane, &claim) : JOB_RUN_RETRY_MS;
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

/* With the lock, but for the time: whether all other lanes keep the jobs they have for EXPRESS_MS.
 * As long as they end some they look themselves at who waits. */
static bool are_held_up(struct dispatcher *dispatcher) {
    const struct timespec time = {.tv_nsec = EXPRESS_MS * 1000000};
    unsigned ended = dispatcher->ended;
    pthread_mutex_unlock(&dispatcher->lock);
    nanosleep(&time, NULL);
    pthread_mutex_lock(&dispatcher->lock);
    return dispatcher->ended == ended;
}

/* Waits for `ms` or a hint, then until all other lanes are busy and held up. False when no more
 * work is to be taken. */
static bool wait_all_busy(struct dispatcher *dispatcher, int64_t ms) {
    struct timespec then = clock_after_ms(ms);
    pthread_mutex_lock(&dispatcher->lock);
    if (ms > 0 && !dispatcher->quiet)
        pthread_cond_timedwait(&dispatcher->all_busy, &dispatcher->lock, &then);
    do
        while (!dispatcher->quiet && dispatcher->busy < dispatcher->shared.settings.workers)
            pthread_cond_wait(&dispatcher->all_busy, &dispatcher->lock);
    while (!dispatcher->quiet && !are_held_up(dispatcher));
    bool go_on = !dispatcher->quiet;
    pthread_mutex_unlock(&dispatcher->lock);
    return go_on;
}

static void *serve_express(void *context) {
    struct lane *lane = context;
    int64_t wait = 0;
    bool hints;
    while (wait_all_busy(lane->dispatcher, wait)) {
        /* Its worker may have ended since: what is idle is looked at before it gets a job. */
        if (child_running(&lane->child) && !ready_worker(lane))
            wait = START_RETRY_MS;
        else
            wait = take_turn(lane, &hints);
    }
    child_kill(&lane->child);
    return NULL;
}

/* ------------------------------------------------------------------ the sweeper */

static void sweep_once(struct dispatcher *dispatcher) {
    struct store_sweep sweep;
    do {
        enum store_answer answer = store_sweep(dispatcher->shared.store, &sweep);
        if (answer != STORE_OK)
            return;
        if (sweep.requeued + sweep.failed + sweep.expired + sweep.removed > 0)
            log_info(log_event("store_swept"), log_int("requeued", sweep.requeued),
                     log_int("failed", sweep.failed), log_int("expired", sweep.expired),
                     log_int("removed", sweep.removed));
    } while (sweep.more && !job_run_out_of_time(&dispatcher->shared));
}

/* While it fails the store takes nothing, so that it is tried again soon. */
static void show_life(struct dispatcher *dispatcher, int64_t *next_ms) {
    struct store *store = dispatcher->shared.store;
    const struct dispatcher_settings *settings = &dispatcher->shared.settings;
    struct store_host host = {.workers = settings->workers,
                              .busy = atomic_load(&dispatcher->shared.counters.busy),
                              .version = DRAPED_VERSION};
    if (clock_ms() < *next_ms)
        return;
    gethostname(host.host, sizeof host.host - 1);
    snprintf(host.role, sizeof host.role, "%s", settings->role);
    store_introduce(store, &host);
    *next_ms = clock_ms() + (store_beat(store) == STORE_OK ? settings->beat_ms : 0);
}

static void *sweep(void *context) {
    struct dispatcher *dispatcher = context;
    int64_t beat_at_ms = 0;
    pthread_mutex_lock(&dispatcher->lock);
    while (!dispatcher->stopping) {
        pthread_mutex_unlock(&dispatcher->lock);
        show_life(dispatcher, &beat_at_ms);
        sweep_once(dispatcher);
        struct timespec then = clock_after_ms(dispatcher->shared.settings.sweep_ms);
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
    lane->express = dispatcher->lane_count == dispatcher->shared.settings.workers;
    lane->child.socket = -1;
    lane->wake = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    if (lane->wake < 0)
        return false;
    if (pthread_create(&lane->thread, NULL, lane->express ? serve_express : serve, lane) != 0) {
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
    pthread_cond_init(&dispatcher->all_busy, &monotonic);
    pthread_cond_init(&dispatcher->sweep_now, &monotonic);
    pthread_condattr_destroy(&monotonic);
}

struct dispatcher *dispatcher_start(struct store *store, struct job_events *events,
                                    const struct dispatcher_settings *settings) {
    struct dispatcher *dispatcher = calloc(1, sizeof *dispatcher);
    int lane_count = settings->workers ? settings->workers + 1 : 0; /* with the express lane */
    struct lane *lanes = calloc((size_t)lane_count + 1, sizeof *lanes);
    if (!dispatcher || !lanes) {
        free(dispatcher);
        free(lanes);
        return NULL;
    }
    dispatcher->shared.store = store;
    dispatcher->shared.events = events;
    dispatcher->shared.settings = *settings;
    dispatcher->lanes = lanes;
    atomic_init(&dispatcher->shared.stop_at_ms, JOB_RUN_NO_STOP);
    init_locks(dispatcher);
    job_events_subscribe(events, &dispatcher->watch, job_events_queue, JOB_CHANGED, hint,
                         dispatcher);
    dispatcher->sweeping = pthread_create(&dispatcher->sweeper, NULL, sweep, dispatcher) == 0;
    while (dispatcher->lane_count < lane_count && start_lane(dispatcher))
        continue;
    if (dispatcher->sweeping && dispatcher->lane_count == lane_count)
        return dispatcher;
    log_error(log_event("dispatcher_start_failed"), log_int("threads", dispatcher->lane_count));
    dispatcher_stop(dispatcher, 0);
    dispatcher_free(dispatcher);
    return NULL;
}

/* The sweeper goes last: leases that end meanwhile are its business. */
void dispatcher_stop(struct dispatcher *dispatcher, int64_t grace_ms) {
    if (!dispatcher)
        return;
    pthread_mutex_lock(&dispatcher->lock);
    dispatcher->quiet = true;
    pthread_cond_broadcast(&dispatcher->idle);
    pthread_cond_broadcast(&dispatcher->all_busy);
    pthread_mutex_unlock(&dispatcher->lock);
    atomic_store(&dispatcher->shared.stop_at_ms, clock_ms() + grace_ms);
    for (int k = 0; k < dispatcher->lane_count; k++) {
        job_run_wake(dispatcher->lanes[k].wake);
        pthread_join(dispatcher->lanes[k].thread, NULL);
        close(dispatcher->lanes[k].wake);
    }
    pthread_mutex_lock(&dispatcher->lock);
    dispatcher->stopping = true;
    pthread_cond_broadcast(&dispatcher->sweep_now);
    pthread_mutex_unlock(&dispatcher->lock);
    if (dispatcher->sweeping)
        pthread_join(dispatcher->sweeper, NULL);
    job_events_unsubscribe(dispatcher->shared.events, &dispatcher->watch);
}

void dispatcher_free(struct dispatcher *dispatcher) {
    if (!dispatcher)
        return;
    pthread_mutex_destroy(&dispatcher->lock);
    pthread_cond_destroy(&dispatcher->idle);
    pthread_cond_destroy(&dispatcher->all_busy);
    pthread_cond_destroy(&dispatcher->sweep_now);
    free(dispatcher->lanes);
    free(dispatcher);
}

void dispatcher_stats(struct dispatcher *dispatcher, struct work_counts *counts) {
    const struct work_counters *counters = &dispatcher->shared.counters;
#define X(name, help) counts->name = atomic_load(&counters->name);
    X(busy, "")
    WORK_OUTCOMES(X)
    WORK_EVENTS(X)
#undef X
}
