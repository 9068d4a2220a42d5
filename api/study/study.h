/* SPDX-License-Identifier: MIT */
/*
 * Studies: many drapes of one part that differ in start, direction and pre-shear, in their cuts or
 * in the courses of a ply, and of each a few numbers instead of a result.
 *
 * A study proceeds in rounds. A round has tasks that do not depend on each other, each of about
 * 0.1 s at the most unless one drape takes longer; a task gives numbers. What the tasks of a round
 * are follows from the study and the numbers of all rounds before, and what a task gives follows
 * from the study and the task alone: so the result has the same bits wherever the tasks were done,
 * in whatever order, and however often. The end is put together from all numbers.
 *
 *     study = api_study_open(request)
 *     while ((plan = api_study_plan(study, numbers)).count > 0)
 *         numbers += api_study_run_task(study, plan.tasks[k]) for k = 0 .. plan.count - 1, in order
 *     container = api_study_finish(study, numbers)
 *
 * No files, no clock, no network; nothing is kept between calls but in what they return. Problems
 * are those of `run.h`, their pointers into the study's document.
 */
#ifndef API_STUDY_STUDY_H
#define API_STUDY_STUDY_H

#include "api/check.h"
#include "api/input.h"
#include "api/limits.h"
#include "api/problem.h"
#include "api/result/columns.h"
#include "api/result/quantity.h"
#include "api/sink.h"
#include "solver/arena.h"
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/*
 * What can be said of a study before any work: that it is sound, its digest, the stored surface
 * that its drape names, and in `check->variants` how many variants it will look at, at the most.
 * As `api_check_drape`; API_INVALID_REQUEST also for more than `limits->max_variants`.
 */
enum api_problem_id api_check_study(const struct api_input *input, const struct api_limits *limits,
                                    const struct api_sink *forms, struct api_check *check,
                                    struct api_problem *problem) STATUS_MUST_USE;

/* Writes the study as it was understood, with every default filled in. */
enum api_problem_id api_study_normalise(const struct api_input *input,
                                        const struct api_limits *limits,
                                        const struct api_sink *sink,
                                        struct api_problem *problem) STATUS_MUST_USE;

/* A study with its surface made ready. It is not changed by any call below, so that threads may
 * share it. */
struct api_study;

/* NULL with the problem set. The caller gives it back with `api_study_close`; `input` need not
 * outlive the call. Its memory counts against a budget of `limits->max_memory` of its own. */
struct api_study *api_study_open(const struct api_input *input, const struct api_limits *limits,
                                 struct api_problem *problem);

/* NULL is allowed. */
void api_study_close(struct api_study *study);

/* One piece of work, to be stored and sent as these bytes: without padding, and little-endian on
 * all machines that the service runs on. */
enum {
    API_STUDY_CRASHES = 4,
    API_STUDY_LISTED = 7,
    API_STUDY_CUTS = 8,
    API_STUDY_UNKNOWNS = 56 /* of courses */
};
struct api_study_task {
    int32_t kind;        /* `enum study_task_kind` */
    int32_t variants;    /* that it looks at, at the most */
    int32_t round;       /* counted from 0 */
    int32_t crash_count; /* of the variants that crashed the process, by their number in the task */
    int32_t crashed[API_STUDY_CRASHES];
    int64_t first; /* of numbered variants: the number of the first; of one with cuts, or courses:
                      how many cuts, or unknowns */
    double coarseness; /* of listed ones */
    union {
        struct api_study_listed {
            double start[3]; /* the face and its parameters u and v; on a mesh x, y and z */
            double angle_deg, pre_shear_deg;
        } listed[API_STUDY_LISTED];
        double cuts[API_STUDY_CUTS][6];     /* mouth and tip of each */
        double courses[API_STUDY_UNKNOWNS]; /* as `course_plan.h` has them */
    };
};

/* Notes that variant `k` of the task (as its monitor counts them) crashed the process: when the
 * task is done again it is marked and not tried. After API_STUDY_CRASHES of them nothing of the
 * task from the last on is tried. */
void api_study_task_crashed(struct api_study_task *task, size_t k);

/* What tasks have given so far: all of their numbers, in the order of the rounds and in each of its
 * tasks. */
struct api_study_numbers {
    const double *values;
    size_t count;
};

/* The next round. */
struct api_study_plan {
    const struct api_study_task *tasks; /* in the arena of the call */
    size_t count;                       /* 0: there is nothing left to do but `api_study_finish` */
    size_t done;                        /* variants looked at in the rounds before */
    size_t variants;                    /* in the whole study, as far as can be told by now */
    double
        best[QUANTITY_COUNT]; /* the least of each objective in the rounds before, of the variants
                                 that miss the limits by the least, coarse ones too; NaN: none */
};

/* Plans the round after those that gave `numbers`. Problems: API_OUT_OF_MEMORY, API_INTERNAL for
 * numbers that no round can have given. */
enum api_problem_id api_study_plan(const struct api_study *study,
                                   const struct api_study_numbers *numbers, struct arena *arena,
                                   struct api_study_plan *plan,
                                   struct api_problem *problem) STATUS_MUST_USE;

/* Watches a task: called before each of its variants, counted from 0, and now and then during long
 * ones; false stops it with API_CANCELLED. */
struct api_study_monitor {
    bool (*progress)(void *context, size_t variant);
    void *context;
};

/* Does one task and writes its numbers, little-endian float64, to `sink`. A variant that cannot be
 * draped is no problem but has its reason among the numbers. `monitor` may be NULL; scratch comes
 * from `arena` and is given back. Problems: API_CANCELLED (also when the sink refuses),
 * API_OUT_OF_MEMORY (the arena holds not even one variant), API_INTERNAL. */
enum api_problem_id api_study_run_task(const struct api_study *study,
                                       const struct api_study_task *task,
                                       const struct api_study_monitor *monitor, struct arena *arena,
                                       const struct api_sink *sink,
                                       struct api_problem *problem) STATUS_MUST_USE;

/* Writes the container (`columns.h`) of the study: the table `variants` and a header that has the
 * best of each objective. `solve_ms` is the time of all tasks, for the summary. Scratch comes from
 * `arena` and is given back. */
enum api_problem_id api_study_finish(const struct api_study *study,
                                     const struct api_study_numbers *numbers, double solve_ms,
                                     struct arena *arena, const struct api_sink *sink,
                                     struct api_problem *problem) STATUS_MUST_USE;

/* Whether its variants are laminates, of one ply that is laid in courses, and no drapes. */
bool api_study_lays_courses(const struct api_study *study);

/* Writes the request of variant k of a finished study, of a drape or a laminate: with the same
 * numbers in its summary, to the last bit but for coarse courses; `arena` is for what goes on
 * meanwhile. API_NOT_FOUND beyond the last. */
enum api_problem_id api_study_variant_request(const struct api_study *study,
                                              const struct api_reader *result, size_t k,
                                              struct arena *arena, const struct api_sink *sink,
                                              struct api_problem *problem) STATUS_MUST_USE;

/* The id of what it asks for, as `api_check_study` has it. False without memory; scratch comes from
 * `arena` and is given back. */
bool api_study_digest(const struct api_study *study, struct arena *arena, char id[API_ID_SIZE]);

/* All rounds in this process, with `limits->threads` threads, container out. `monitor` (may be
 * NULL) is called with the fraction done, never at the same time. */
enum api_problem_id api_study_run(const struct api_study *study, const struct api_limits *limits,
                                  const struct drape_monitor *monitor, const struct api_sink *sink,
                                  struct api_problem *problem) STATUS_MUST_USE;

#endif
