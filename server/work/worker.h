/* SPDX-License-Identifier: MIT */
/*
 * The worker process: reads jobs from the socket on WORKER_FD, runs them one after the other, sends
 * progress and result back, and ends when the socket closes. It has no store, is locked in
 * (`sandbox.h`), and holds no more memory than its job may; what harms it harms one attempt of one
 * job. It is the same binary (`child.h`), with WORKER_ARGUMENT.
 */
#ifndef SERVER_WORK_WORKER_H
#define SERVER_WORK_WORKER_H

#include "api/result/quantity.h"
#include "api/run.h"

enum { WORKER_FD = 3 };
#define WORKER_ARGUMENT "worker"

/* A step or a task of a study. */
struct worker_order {
    const struct api_input *input;
    const struct api_limits *limits;
    const void *bytes; /* of a step: the numbers of all rounds so far; aligned as doubles */
    size_t length;
    double spent_ms; /* of a step: the time of all tasks */
};

/* What a step gives when the study goes on. */
struct worker_round {
    /* Takes the next task, of at most FRAME_TASK_BYTES; false: give up. */
    bool (*add)(void *context, const void *task, size_t length, size_t variants);
    void *context;
    size_t count;                /* tasks; 0: the container was written instead */
    size_t done, total;          /* variants, in the rounds before and altogether */
    double best[QUANTITY_COUNT]; /* of each objective so far; NaN: none */
};

/* What a worker does with a job. The daemon's is `api_run` and `study.h`; tests have their own. */
struct worker_engine {
    /* Writes the container, with its summary. */
    enum api_problem_id (*run)(const struct api_input *input, const struct api_limits *limits,
                               const struct drape_monitor *monitor, const struct api_sink *sink,
                               struct api_problem *problem);
    /* Begins the next round of a study, or writes its container. */
    enum api_problem_id (*step)(const struct worker_order *order, struct worker_round *round,
                                const struct api_sink *sink, struct api_problem *problem);
    /* Writes the numbers of a task; the monitor is told which variant comes next. */
    enum api_problem_id (*task)(const struct worker_order *order,
                                const struct drape_monitor *monitor, const struct api_sink *sink,
                                struct api_problem *problem);
};

/* Serves WORKER_FD with the engine until it closes. Returns the process's exit code. */
int worker_serve(const struct worker_engine *engine);

/* Serves as the daemon's worker: what `draped worker` does. Readies `api_run` itself. */
int worker_main(void);

#endif
