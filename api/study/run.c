/* SPDX-License-Identifier: MIT */
/* A whole study in one process: the tasks of each round on as many threads as are wanted. */
#include "study.h"

#include "api/threads.h"
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { ARENAS_MAX = 64 };

/* What tasks have given, growing. */
struct heap {
    double *values;
    size_t count, room;
};

/* Arenas that threads take turns with; so each has one of its own while it works. */
struct pool {
    struct arena *arena[ARENAS_MAX];
    atomic_flag taken[ARENAS_MAX];
    int count;
};

struct run {
    const struct api_study *study;
    const struct drape_monitor *monitor;
    struct pool pool;
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

static double fraction_done(const struct run *run) {
    double all = (double)run->plan.variants;
    return all > 0 ? (double)(run->plan.done + atomic_load(&run->done)) / all : 0;
}

/* ---- a round ---- */

struct watched {
    struct run *run;
    size_t told; /* variants of the task that were counted */
};

static bool tell(void *context, size_t variant) {
    struct watched *watched = context;
    struct run *run = watched->run;
    atomic_fetch_add(&run->done, variant - watched->told);
    watched->told = variant;
    if (run->monitor && !atomic_flag_test_and_set(&run->telling)) {
        if (!run->monitor->progress(run->monitor->context, fraction_done(run)))
            atomic_store(&run->stopped, true);
        atomic_flag_clear(&run->telling);
    }
    return !atomic_load(&run->stopped);
}

static int take_arena(struct pool *pool) {
    for (int k = 0;; k = (k + 1) % pool->count)
        if (!atomic_flag_test_and_set(&pool->taken[k]))
            return k;
}

static void do_task(void *data, int k) {
    struct run *run = data;
    struct watched watched = {run, 0};
    const struct api_study_monitor monitor = {tell, &watched};
    const struct api_sink sink = {.write = append_numbers, .context = &run->given[k]};
    int own = take_arena(&run->pool);
    if (!atomic_load(&run->stopped) &&
        api_study_run_task(run->study, &run->plan.tasks[k], &monitor, run->pool.arena[own], &sink,
                           &run->problem[k]) != API_OK)
        atomic_store(&run->stopped, true);
    atomic_flag_clear(&run->pool.taken[own]);
}

/* The first task's problem, and all tasks' numbers in their order behind those of before. */
static enum api_problem_id gather_numbers(struct run *run, struct heap *numbers,
                                          struct api_problem *problem) {
    for (size_t k = 0; k < run->plan.count; k++) {
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
    return problem->id;
}

static enum api_problem_id do_round(struct run *run, const struct drape_team *team,
                                    struct heap *numbers, struct api_problem *problem) {
    run->given = calloc(run->plan.count, sizeof *run->given);
    run->problem = calloc(run->plan.count, sizeof *run->problem);
    atomic_store(&run->done, 0);
    if (!run->given || !run->problem) {
        api_problem_no_memory(problem, "the study");
    } else {
        if (team)
            team->run(team->context, (int)run->plan.count, do_task, run);
        for (size_t k = 0; !team && k < run->plan.count; k++)
            do_task(run, (int)k);
        gather_numbers(run, numbers, problem);
    }
    free(run->given);
    free(run->problem);
    return problem->id;
}

/* ---- all rounds ---- */

static double clock_ms(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec * 1e3 + (double)now.tv_nsec * 1e-6;
}

static enum api_problem_id do_rounds(struct run *run, const struct drape_team *team,
                                     const struct api_sink *sink, struct arena *arena,
                                     struct api_problem *problem) {
    struct heap numbers = {0};
    double begin = clock_ms();
    for (;;) {
        struct arena_mark mark = arena_mark(arena);
        const struct api_study_numbers so_far = {numbers.values, numbers.count};
        if (api_study_plan(run->study, &so_far, arena, &run->plan, problem) != API_OK ||
            run->plan.count == 0 || do_round(run, team, &numbers, problem) != API_OK)
            break;
        arena_rewind(arena, mark);
    }
    const struct api_study_numbers all = {numbers.values, numbers.count};
    enum api_problem_id id = problem->id;
    if (id == API_OK)
        id = api_study_finish(run->study, &all, clock_ms() - begin, arena, sink, problem);
    free(numbers.values);
    return id;
}

static bool fill_pool(struct pool *pool, int threads, size_t memory) {
    pool->count = threads < 1 ? 1 : threads > ARENAS_MAX ? ARENAS_MAX : threads;
    bool all = true;
    for (int k = 0; k < pool->count; k++) {
        pool->arena[k] = arena_new(memory);
        all = all && pool->arena[k];
    }
    return all;
}

enum api_problem_id api_study_run(const struct api_input *input, const struct api_limits *limits,
                                  const struct drape_monitor *monitor, const struct api_sink *sink,
                                  struct api_problem *problem) {
    struct api_study *study = api_study_open(input, limits, problem);
    struct arena *arena = study ? arena_new(limits->max_memory) : NULL;
    struct run run = {.study = study, .monitor = monitor, .telling = ATOMIC_FLAG_INIT};
    struct api_threads threads;
    for (int k = 0; k < ARENAS_MAX; k++)
        atomic_flag_clear(&run.pool.taken[k]);
    if (study && (!arena || !fill_pool(&run.pool, limits->threads, limits->max_memory)))
        api_problem_no_memory(problem, "the study");
    else if (study)
        do_rounds(&run, api_threads_make(&threads, run.pool.count), sink, arena, problem);
    for (int k = 0; k < run.pool.count; k++)
        arena_free(run.pool.arena[k]);
    arena_free(arena);
    api_study_close(study);
    return problem->id;
}
