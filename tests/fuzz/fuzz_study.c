/* SPDX-License-Identifier: MIT */
/* A whole study within tiny budgets, from any request to its table. */
#include "encode.h"

#include "api/run.h"
#include "api/study/study.h"

enum {
    LOOKS = 1000 /* of the monitor, until the study is given up */
};

static bool go_on(void *context, size_t variant) {
    int *looks = context;
    (void)variant;
    return ++*looks < LOOKS;
}

/* All rounds; false when it was cancelled, or there was no memory. */
static bool run_rounds(const struct api_study *study, struct arena *arena,
                       struct fuzz_bytes *numbers) {
    int looks = 0;
    const struct api_study_monitor monitor = {go_on, &looks};
    const struct api_sink sink = {.write = fuzz_append, .context = numbers};
    struct api_problem problem = {0};
    for (;;) {
        struct arena_mark mark = arena_mark(arena);
        struct api_study_plan plan;
        const struct api_study_numbers so_far = {(const double *)numbers->data,
                                                 numbers->size / sizeof(double)};
        enum api_problem_id id = api_study_plan(study, &so_far, arena, &plan, &problem);
        FUZZ_PROMISE(id == problem.id && id != API_INTERNAL);
        for (size_t k = 0; id == API_OK && k < plan.count; k++)
            id = api_study_run_task(study, &plan.tasks[k], &monitor, arena, &sink, &problem);
        FUZZ_PROMISE(id == problem.id && id != API_INTERNAL);
        if (id != API_OK || plan.count == 0)
            return id == API_OK;
        arena_rewind(arena, mark);
    }
}

static void finish(const struct api_study *study, const struct fuzz_bytes *numbers,
                   struct arena *arena) {
    struct fuzz_bytes container = {0};
    const struct api_sink sink = {.write = fuzz_append, .context = &container};
    const struct api_study_numbers all = {(const double *)numbers->data,
                                          numbers->size / sizeof(double)};
    struct api_problem problem = {0};
    enum api_problem_id id = api_study_finish(study, &all, 0.0, arena, &sink, &problem);
    FUZZ_PROMISE(id == problem.id && id != API_INTERNAL);
    free(container.data);
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
    struct api_problem problem = {0};
    fuzz_prepare();
    const struct api_input input = {.request = (const char *)data, .request_length = size};
    struct api_study *study = api_study_open(&input, &fuzz_limits, &problem);
    FUZZ_PROMISE((study != NULL) == (problem.id == API_OK) && problem.id != API_INTERNAL);
    if (!study)
        return 0;
    struct arena *arena = arena_new(fuzz_limits.max_memory);
    struct fuzz_bytes numbers = {0};
    if (run_rounds(study, arena, &numbers))
        finish(study, &numbers, arena);
    free(numbers.data);
    arena_free(arena);
    api_study_close(study);
    return 0;
}
