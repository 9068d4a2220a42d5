/* SPDX-License-Identifier: MIT */
#include "dispatcher.h"
#include "child.h"
#include "job_run.h"
#include "server/clock.h"
#include "server/config.h"
#include "server/log.h"
#include "worker.h"
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <unistd.h>

enum {
    START_RETRY_MS = 1000, /* between two tries to start a worker */
    HELD_UP_MS = 5,        /* the fast worker looks when no other has ended a job for so long */
    NICENESS = 5 /* of the workers but the fast one: callers are answered before they go on */
};

/* A thread with its worker process. */
struct worker_thread {
    struct dispatcher *dispatcher;
    pthread_t thread;
    struct child child;
    int wake;                     /* eventfd of its runs */
    bool used;                    /* a worker has run here before */
    bool fast;                    /* takes short jobs that the others are too busy for */
    bool served;                  /* this worker has had a job, of this owner */
    char owner[STORE_OWNER_SIZE]; /* "" is one too */
    struct store_claim next;      /* claimed with the end of its last job; sequence 0: none */
};

struct dispatcher {
    struct job_run_shared shared;
    struct worker_thread *workers;
    int worker_count; /* threads that run */
    pthread_t sweeper;
    bool sweeping; /* the sweeper runs */
    struct job_watch watch;

    pthread_mutex_t lock;
    pthread_cond_t idle;      /* workers without a job wait here */
    pthread_cond_t all_busy;  /* the fast worker waits here */
    int busy;                 /* workers but the fast one with a job */
    unsigned ended;           /* jobs that these have ended */
    pthread_cond_t sweep_now; /* the sweeper waits here */
    int hints;                /* jobs that may be there, at most one a worker */
    bool quiet;               /* no new claims */
    bool stopping;
};

/* Called for news of the queue: there may be a job. */
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

/* ------------------------------------------------------------------ a worker */

/* Starts the thread's process when it has none; false when that has to wait. An idle one says
 * nothing: what can be received of it is its end. */
static bool ready_worker(struct worker_thread *worker) {
    struct child *child = &worker->child;
    char why[CHILD_WHY_SIZE];
    if (child_running(child) && frame_poll(child->socket, &child->inbox) != FRAME_LATER) {
        child_reap(child, why);
        log_warning(log_event("idle_worker_died"), log_text("worker", why));
    }
    if (child_running(child))
        return true;
    if (!child_start(child, NULL, WORKER_ARGUMENT))
        return false;
    if (!job_run_bound(&worker->dispatcher->shared, child)) {
        child_kill(child);
        return false;
    }
    if (!worker->fast)
        child_lower(child, NICENESS);
    if (worker->used)
        atomic_fetch_add(&worker->dispatcher->shared.counters.restarts, 1);
    worker->used = true;
    worker->served = false;
    return true;
}

/* A worker but the fast one has got a job, or is done with it. */
static void count_busy(struct worker_thread *worker, int more) {
    struct dispatcher *dispatcher = worker->dispatcher;
    if (worker->fast)
        return;
    pthread_mutex_lock(&dispatcher->lock);
    dispatcher->busy += more;
    dispatcher->ended += more < 0;
    if (dispatcher->busy == dispatcher->shared.settings.workers)
        pthread_cond_signal(&dispatcher->all_busy);
    pthread_mutex_unlock(&dispatcher->lock);
}

/* Whether there is nothing to do for what was claimed: it has ended by the result of another. */
static bool was_reused(struct job_run_shared *shared, const struct store_claim *claim) {
    bool reused = claim->sequence != 0 && claim->reused;
    atomic_fetch_add(&shared->counters.reused, reused);
    return reused;
}

/* One turn: how long to wait for the next (0: not at all), and whether a hint ends the wait. The
 * fast worker's process is started with its first job; for it, a read is enough to find out that it
 * is not needed. Where there is one task there are more: whoever claims one has the next worker
 * look. A process serves one owner: should a request take it over, it has nothing of another's to
 * tell, and no other's result to falsify. */
static int64_t take_turn(struct worker_thread *worker, bool *hints) {
    struct job_run_shared *shared = &worker->dispatcher->shared;
    struct store *store = shared->store;
    struct store_claim claim = worker->next;
    bool claimed = claim.sequence != 0;
    *hints = false;
    worker->next.sequence = 0;
    if (!worker->fast && !ready_worker(worker)) {
        if (claimed)
            (void)!store_release(store, &claim); /* failed: the lease ends */
        return START_RETRY_MS;
    }
    enum store_answer answer = claimed        ? STORE_OK
                               : worker->fast ? store_starving(store, true)
                                              : store_claim(store, &claim);
    if (worker->fast && answer == STORE_OK)
        answer = store_claim_fresh(store, &claim);
    if (answer == STORE_EMPTY) {
        *hints = true;
        return WORK_POLL_MS;
    }
    if (answer != STORE_OK)
        return JOB_RUN_RETRY_MS;
    if (claim.kind == STORE_TASK)
        hint(worker->dispatcher);
    if (was_reused(shared, &claim))
        return 0;
    if (worker->served && strcmp(worker->owner, claim.owner) != 0)
        child_kill(&worker->child);
    if (!child_running(&worker->child) && !ready_worker(worker)) {
        (void)!store_release(store, &claim); /* failed: the lease ends */
        return START_RETRY_MS;
    }
    worker->served = true;
    snprintf(worker->owner, sizeof worker->owner, "%s", claim.owner);
    count_busy(worker, 1);
    bool good =
        job_run(shared, &claim, &worker->child, worker->wake, worker->fast ? NULL : &worker->next);
    count_busy(worker, -1);
    if (was_reused(shared, &worker->next))
        worker->next.sequence = 0;
    return good ? 0 : JOB_RUN_RETRY_MS;
}

/* The thread of a worker: takes turns, and waits in between for a hint or its time, until no more
 * work is to be taken. */
static void *serve_jobs(void *context) {
    struct worker_thread *worker = context;
    struct dispatcher *dispatcher = worker->dispatcher;
    bool go_on = true, hints;
    while (go_on) {
        struct timespec then = clock_after_ms(take_turn(worker, &hints));
        int code = 0;
        pthread_mutex_lock(&dispatcher->lock);
        while (!dispatcher->quiet && !(hints && dispatcher->hints > 0) && code == 0)
            code = pthread_cond_timedwait(&dispatcher->idle, &dispatcher->lock, &then);
        if (hints && dispatcher->hints > 0)
            dispatcher->hints--;
        go_on = !dispatcher->quiet;
        pthread_mutex_unlock(&dispatcher->lock);
    }
    if (worker->next.sequence)
        (void)!store_release(dispatcher->shared.store, &worker->next);
    child_kill(&worker->child);
    return NULL;
}

/* The thread of the fast worker. It waits for its time or a hint, then until all other workers are
 * busy and keep the jobs they have for HELD_UP_MS: as long as they end some they look themselves at
 * who waits. Its process may have ended since its last job: what is idle is looked at before it
 * gets another. */
static void *serve_short_jobs(void *context) {
    const struct timespec pause = {.tv_nsec = HELD_UP_MS * 1000000};
    struct worker_thread *worker = context;
    struct dispatcher *dispatcher = worker->dispatcher;
    int64_t wait = 0;
    pthread_mutex_lock(&dispatcher->lock);
    while (!dispatcher->quiet) {
        struct timespec then = clock_after_ms(wait);
        bool held_up = false, hints;
        if (wait > 0)
            pthread_cond_timedwait(&dispatcher->all_busy, &dispatcher->lock, &then);
        while (!dispatcher->quiet && !held_up) {
            if (dispatcher->busy < dispatcher->shared.settings.workers) {
                pthread_cond_wait(&dispatcher->all_busy, &dispatcher->lock);
                continue;
            }
            unsigned ended = dispatcher->ended;
            pthread_mutex_unlock(&dispatcher->lock);
            nanosleep(&pause, NULL);
            pthread_mutex_lock(&dispatcher->lock);
            held_up = dispatcher->ended == ended;
        }
        if (dispatcher->quiet)
            break;
        pthread_mutex_unlock(&dispatcher->lock);
        wait = child_running(&worker->child) && !ready_worker(worker) ? START_RETRY_MS
                                                                      : take_turn(worker, &hints);
        pthread_mutex_lock(&dispatcher->lock);
    }
    pthread_mutex_unlock(&dispatcher->lock);
    child_kill(&worker->child);
    return NULL;
}

/* ------------------------------------------------------------------ the sweeper */

/* Tells the store now and then that this daemon is alive, and sweeps. While the store fails it
 * takes nothing, so that it is told again soon. */
static void *sweep_store(void *context) {
    struct dispatcher *dispatcher = context;
    struct store *store = dispatcher->shared.store;
    const struct dispatcher_settings *settings = &dispatcher->shared.settings;
    int64_t beat_at_ms = 0;
    pthread_mutex_lock(&dispatcher->lock);
    while (!dispatcher->stopping) {
        struct store_sweep sweep = {.more = true};
        pthread_mutex_unlock(&dispatcher->lock);
        if (clock_ms() >= beat_at_ms) {
            struct store_host host = {.workers = settings->workers,
                                      .busy = atomic_load(&dispatcher->shared.counters.busy),
                                      .version = DRAPE_VERSION};
            gethostname(host.host, sizeof host.host - 1);
            snprintf(host.role, sizeof host.role, "%s", settings->role);
            store_introduce(store, &host);
            beat_at_ms = clock_ms() + (store_beat(store) == STORE_OK ? settings->beat_ms : 0);
        }
        while (sweep.more && store_sweep(store, &sweep) == STORE_OK) {
            if (sweep.requeued + sweep.failed + sweep.expired + sweep.removed > 0)
                log_info(log_event("store_swept"), log_int("requeued", sweep.requeued),
                         log_int("failed", sweep.failed), log_int("expired", sweep.expired),
                         log_int("removed", sweep.removed));
            if (job_run_out_of_time(&dispatcher->shared))
                break;
        }
        struct timespec then = clock_after_ms(settings->sweep_ms);
        int code = 0;
        pthread_mutex_lock(&dispatcher->lock);
        while (!dispatcher->stopping && code == 0)
            code = pthread_cond_timedwait(&dispatcher->sweep_now, &dispatcher->lock, &then);
    }
    pthread_mutex_unlock(&dispatcher->lock);
    return NULL;
}

/* ------------------------------------------------------------------ start and stop */

struct dispatcher *dispatcher_start(struct store *store, struct job_events *events,
                                    const struct dispatcher_settings *settings) {
    struct dispatcher *dispatcher = calloc(1, sizeof *dispatcher);
    int worker_count = settings->workers ? settings->workers + 1 : 0; /* with the fast one */
    struct worker_thread *workers = calloc((size_t)worker_count + 1, sizeof *workers);
    pthread_condattr_t monotonic;
    if (!dispatcher || !workers) {
        free(dispatcher);
        free(workers);
        return NULL;
    }
    dispatcher->shared.store = store;
    dispatcher->shared.events = events;
    dispatcher->shared.settings = *settings;
    dispatcher->workers = workers;
    atomic_init(&dispatcher->shared.stop_at_ms, JOB_RUN_NO_STOP);
    pthread_condattr_init(&monotonic);
    pthread_condattr_setclock(&monotonic, CLOCK_MONOTONIC);
    pthread_mutex_init(&dispatcher->lock, NULL);
    pthread_cond_init(&dispatcher->idle, &monotonic);
    pthread_cond_init(&dispatcher->all_busy, &monotonic);
    pthread_cond_init(&dispatcher->sweep_now, &monotonic);
    pthread_condattr_destroy(&monotonic);
    job_events_subscribe(events, &dispatcher->watch, job_events_queue, JOB_CHANGED, hint,
                         dispatcher);
    dispatcher->sweeping = pthread_create(&dispatcher->sweeper, NULL, sweep_store, dispatcher) == 0;
    bool good = true;
    while (good && dispatcher->worker_count < worker_count) {
        struct worker_thread *worker = &workers[dispatcher->worker_count];
        worker->dispatcher = dispatcher;
        worker->fast = dispatcher->worker_count == settings->workers; /* the last one */
        worker->child.socket = -1;
        worker->wake = eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
        good = worker->wake >= 0 &&
               pthread_create(&worker->thread, NULL, worker->fast ? serve_short_jobs : serve_jobs,
                              worker) == 0;
        if (!good && worker->wake >= 0)
            close(worker->wake);
        dispatcher->worker_count += good;
    }
    if (dispatcher->sweeping && good)
        return dispatcher;
    log_error(log_event("dispatcher_start_failed"), log_int("threads", dispatcher->worker_count));
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
    for (int k = 0; k < dispatcher->worker_count; k++) {
        job_run_wake(&dispatcher->workers[k].wake);
        pthread_join(dispatcher->workers[k].thread, NULL);
        close(dispatcher->workers[k].wake);
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
    free(dispatcher->workers);
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
