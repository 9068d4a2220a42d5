/* SPDX-License-Identifier: MIT */
/*
 * The dispatcher: as many threads as workers, each with one worker process (`child.h`). A thread
 * claims a job, sends it to its worker, renews the lease, passes progress and result to the store,
 * and kills the worker when the job is cancelled, deleted, lost to another or over its time. A
 * worker that dies costs the job one attempt and is replaced. New jobs are seen at once through the
 * hub; those of other processes within DISPATCHER_POLL_MS. One further thread sweeps the store.
 */
#ifndef SERVER_WORK_DISPATCHER_H
#define SERVER_WORK_DISPATCHER_H

#include "api/limits.h"
#include "server/hub.h"
#include "server/store/store.h"
#include <stdint.h>

struct dispatcher;

enum { DISPATCHER_POLL_MS = 500 };

struct dispatcher_settings {
    int workers;              /* threads and processes; 0 only sweeps */
    int64_t job_timeout_ms;   /* one attempt; then the job fails as `job-timeout` */
    int64_t renew_ms;         /* lease renewal, well below the store's lease */
    int64_t progress_ms;      /* progress is stored at most this often */
    int64_t sweep_ms;         /* between two sweeps */
    int64_t max_result;       /* bytes; a job with more fails as `too-large` */
    struct api_limits limits; /* of one job */
};

/* One worker, 600 s, 15 s, 200 ms, 250 ms, 64 GiB, api_limits_default. */
struct dispatcher_settings dispatcher_settings_default(void);

/* For /metrics: since the start. */
struct dispatcher_stats {
    int64_t busy;      /* workers that are solving now */
    int64_t succeeded; /* jobs by the way they ended here */
    int64_t failed;
    int64_t reused;   /* answered by a result that was there already */
    int64_t stopped;  /* cancelled, deleted or lost while running */
    int64_t crashes;  /* workers that died on their own */
    int64_t timeouts; /* workers killed for taking too long */
    int64_t restarts; /* workers started in place of another */
};

/* Starts the threads; workers start with their thread, so that the first job finds one. `store` and
 * `hub` must outlive it. NULL when the threads cannot be had. */
struct dispatcher *dispatcher_start(struct store *store, struct hub *hub,
                                    const struct dispatcher_settings *settings);

/* Claims nothing more, gives running jobs `grace_ms` to finish, puts the rest back into the queue
 * and ends the workers and threads. NULL is allowed. */
void dispatcher_stop(struct dispatcher *dispatcher, int64_t grace_ms);

/* After `dispatcher_stop`. NULL is allowed. */
void dispatcher_free(struct dispatcher *dispatcher);

/* Any thread, until the dispatcher is freed. */
void dispatcher_stats(struct dispatcher *dispatcher, struct dispatcher_stats *stats);

#endif
