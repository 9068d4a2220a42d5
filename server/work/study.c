/* SPDX-License-Identifier: MIT */
#include "study.h"
#include "api/study/study.h"
#include "frame.h"
#include <stdlib.h>
#include <string.h>

_Static_assert(sizeof(struct api_study_task) <= FRAME_TASK_BYTES, "a task fits");

/* ------------------------------------------------------------------ the study that is ready */

/* Of a process: the study, and the documents and limits that it was made from. */
static struct {
    struct api_study *study;
    char *documents; /* the request, then the surface */
    size_t request_length, length;
    struct api_limits limits;
} ready;

/* The study of the order, made ready unless it is. NULL with the problem. Without memory to know it
 * by, it is made again for the next order. */
static const struct api_study *get_ready(const struct worker_order *order,
                                         struct api_problem *problem) {
    const struct api_input *input = order->input;
    size_t length = input->request_length + input->surface_length;
    if (ready.study && ready.request_length == input->request_length && ready.length == length &&
        !memcmp(&ready.limits, order->limits, sizeof ready.limits) &&
        !memcmp(ready.documents, input->request, input->request_length) &&
        !memcmp(ready.documents + ready.request_length, input->surface, input->surface_length))
        return ready.study;
    api_study_close(ready.study);
    free(ready.documents);
    memset(&ready, 0, sizeof ready);
    ready.study = api_study_open(input, order->limits, problem);
    ready.documents = malloc(length + 1);
    if (ready.documents) {
        memcpy(ready.documents, input->request, input->request_length);
        memcpy(ready.documents + input->request_length, input->surface, input->surface_length);
        ready.request_length = input->request_length;
        ready.length = length;
        memcpy(&ready.limits, order->limits, sizeof ready.limits);
    }
    return ready.study;
}

static struct arena *make_arena(const struct worker_order *order, struct api_problem *problem) {
    struct arena *arena = arena_new(order->limits->max_memory);
    if (!arena)
        api_problem_set(problem, API_OUT_OF_MEMORY, "there is no memory for the study");
    return arena;
}

/* ------------------------------------------------------------------ orders */

enum api_problem_id study_step(const struct worker_order *order, struct worker_round *round,
                               const struct api_sink *sink, struct api_problem *problem) {
    struct arena *arena = make_arena(order, problem);
    const struct api_study *study = arena ? get_ready(order, problem) : NULL;
    const struct api_study_numbers numbers = {order->bytes, order->length / sizeof(double)};
    struct api_study_plan plan = {0};
    enum api_problem_id id =
        study ? api_study_plan(study, &numbers, arena, &plan, problem) : problem->id;
    if (study && id == API_OK && plan.count == 0) {
        id = api_study_finish(study, &numbers, order->spent_ms, arena, sink, problem);
    } else if (study && id == API_OK) {
        round->count = plan.count;
        round->done = plan.done;
        round->total = plan.variants;
        memcpy(round->best, plan.best, sizeof round->best);
        for (size_t k = 0; k < plan.count && id == API_OK; k++) {
            const struct api_study_task *task = &plan.tasks[k];
            if (!round->add(round->context, task, sizeof *task, (size_t)task->variants))
                id = API_CANCELLED;
        }
    }
    arena_free(arena);
    return id;
}

static bool tell_variant(void *context, size_t variant) {
    const struct drape_monitor *monitor = context;
    return monitor->progress(monitor->context, (double)variant);
}

enum api_problem_id study_task(const struct worker_order *order,
                               const struct drape_monitor *monitor, const struct api_sink *sink,
                               struct api_problem *problem) {
    struct drape_monitor told = *monitor;
    const struct api_study_monitor variants = {tell_variant, &told};
    struct api_study_task task;
    struct arena *arena = make_arena(order, problem);
    const struct api_study *study = arena ? get_ready(order, problem) : NULL;
    if (study && order->length == sizeof task) {
        memcpy(&task, order->bytes, sizeof task);
        (void)!api_study_run_task(study, &task, &variants, arena, sink, problem);
    } else if (study) {
        api_problem_set(problem, API_INTERNAL, "the task has the wrong size");
    }
    arena_free(arena);
    return problem->id;
}
