/* SPDX-License-Identifier: MIT */
/* A whole study in one process: the tasks of each round on as many threads as are wanted. */
#include "study.h"

#include "api/threads.h"
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

/* Arenas that are kept for the next tasks: their pages are there already. */
enum { SPARE_MOST = 64 };

/* What tasks have given, growing. */
struct heap {
    double *values;
    size_t count, room;
};

struct run {
    const struct api_study *study;
    const struct drape_monitor *monitor;
    size_t memory;                           /* that each task may take */
    struct arena *_Atomic spare[SPARE_MOST]; /* arenas of tasks that are done, or NULL */
    struct api_study_plan plan;
    struct heap *given;          /* of each task */
    struct api_problem *problem; /* of each task */
    atomic_size_t done;          /* variants, in this round */
    atomic_flag telling;
    atomic_bool stopped;
};

static bool append_numbers(void *context, const void *bytes, size_t length) {
    struct heap *heap = context;
    size_t count = length / sizeof *heap->values;
    if (heap->count + count > heap->room) {
        size_t room = 2 * heap->room + count + 256;
        double *values = realloc(heap->values, room * sizeof *values);
        if (!values)
            return false;
        heap->values = values;
        heap->room = room;
    }
    memcpy(heap->values + heap->count, bytes, length);
    heap->count += count;
    return true;
}

/* ---- a round ---- */

struct task_watch {
    struct run *run;
    size_t counted; /* variants of the task that were counted */
};

static bool tell_progress(void *context, size_t variant) {
    struct task_watch *watch = context;
    struct run *run = watch->run;
    size_t done = run->plan.done + atomic_fetch_add(&run->done, variant - watch->counted) +
                  variant - watch->counted;
    double all = (double)run->plan.variants;
    watch->counted = variant;
    if (run->monitor && !atomic_flag_test_and_set(&run->telling)) {
        if (!run->monitor->progress(run->monitor->context, all > 0 ? (double)done / all : 0))
            atomic_store(&run->stopped, true);
        atomic_flag_clear(&run->telling);
    }
    return !atomic_load(&run->stopped);
}

static void do_task(void *data, int k) {
    struct run *run = data;
    struct task_watch watch = {run, 0};
    const struct api_study_monitor monitor = {tell_progress, &watch};
    const struct api_sink sink = {.write = append_numbers, .context = &run->given[k]};
    struct api_problem *problem = &run->problem[k];
    if (atomic_load(&run->stopped))
        return;
    struct arena *arena = NULL, *none = NULL;
    for (int n = 0; n < SPARE_MOST && !arena; n++)
        arena = atomic_exchange(&run->spare[n], NULL);
    arena = arena ? arena : arena_new(run->memory);
    if (!arena)
        api_problem_no_memory(problem, "the study");
    else
        (void)!api_study_run_task(run->study, &run->plan.tasks[k], &monitor, arena, &sink, problem);
    if (problem->id != API_OK)
        atomic_store(&run->stopped, true);
    for (int n = 0; n < SPARE_MOST && arena; n++, none = NULL)
        if (atomic_compare_exchange_strong(&run->spare[n], &none, arena))
            arena = NULL;
    arena_free(arena);
}

/* Does the tasks of the plan: the first task's problem, and all tasks' numbers in their order
 * behind those of before. */
static enum api_problem_id do_round(struct run *run, const struct drape_team *team,
                                    struct heap *numbers, struct api_problem *problem) {
    size_t count = run->plan.count;
    run->given = calloc(count, sizeof *run->given);
    run->problem = calloc(count, sizeof *run->problem);
    atomic_store(&run->done, 0);
    if (!run->given || !run->problem) {
        api_problem_no_memory(problem, "the study");
    } else {
        if (team)
            team->run(team->context, (int)count, do_task, run);
        for (size_t k = 0; !team && k < count; k++)
            do_task(run, (int)k);
        for (size_t k = 0; k < count; k++) {
            struct heap *given = &run->given[k];
            if (problem->id == API_OK && run->problem[k].id != API_OK)
                *problem = run->problem[k];
            if (problem->id == API_OK && given->count &&
                !append_numbers(numbers, given->values, given->count * sizeof *given->values))
                api_problem_no_memory(problem, "the study");
            free(given->values);
        }
        if (problem->id == API_OK && atomic_load(&run->stopped))
            api_problem_set(problem, API_CANCELLED, "the study was cancelled");
    }
    free(run->given);
    free(run->problem);
    return problem->id;
}

/* ---- all rounds ---- */

enum api_problem_id api_study_run(const struct api_study *study, const struct api_limits *limits,
                                  const struct drape_monitor *monitor, const struct api_sink *sink,
                                  struct api_problem *problem) {
    struct arena *arena = arena_new(limits->max_memory);
    struct run run = {.study = study,
                      .monitor = monitor,
                      .memory = limits->max_memory,
                      .telling = ATOMIC_FLAG_INIT};
    struct heap numbers = {0};
    struct api_threads threads;
    const struct drape_team *team = api_threads_make(&threads, limits->threads);
    struct timespec begin, end;
    clock_gettime(CLOCK_MONOTONIC, &begin);
    if (!arena)
        api_problem_no_memory(problem, "the study");
    for (bool more = arena != NULL; more;) {
        struct arena_mark mark = arena_mark(arena);
        const struct api_study_numbers so_far = {numbers.values, numbers.count};
        more = api_study_plan(study, &so_far, arena, &run.plan, problem) == API_OK &&
               run.plan.count > 0 && do_round(&run, team, &numbers, problem) == API_OK;
        if (more)
            arena_rewind(arena, mark);
    }
    clock_gettime(CLOCK_MONOTONIC, &end);
    const struct api_study_numbers all = {numbers.values, numbers.count};
    double ms =
        (double)(end.tv_sec - begin.tv_sec) * 1e3 + (double)(end.tv_nsec - begin.tv_nsec) * 1e-6;
    if (problem->id == API_OK)
        (void)!api_study_finish(study, &all, ms, arena, sink, problem);
    free(numbers.values);
    for (int k = 0; k < SPARE_MOST; k++)
        arena_free(run.spare[k]);
    arena_free(arena);
    return problem->id;
}
