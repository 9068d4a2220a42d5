/* SPDX-License-Identifier: MIT */
/* Tasks: the variants that are draped one after the other, and how their numbers are sent. */
#ifndef API_STUDY_TASK_H
#define API_STUDY_TASK_H

#include "variant.h"

/* What the variants of a task are: numbered ones, or listed in it. */
enum study_task_kind {
    STUDY_TASK_GRID,     /* `grid_variant` */
    STUDY_TASK_OPTIMISE, /* `optimise_variant`, of the first round */
    STUDY_TASK_SAMPLE,   /* `sample_variant` */
    STUDY_TASK_LIST,     /* `task_variant` */
    STUDY_TASK_CUTS,     /* one, with cuts */
    STUDY_TASK_COURSES,  /* one, of courses */
    STUDY_TASK_KINDS
};

/* ---- making them ---- */

/* Shares that the variants of a round are cut into at the least, if each is worth a task. */
enum { TASK_SHARES = 64 };

/* Numbered variants, from `first` to `end - 1`. */
struct task_range {
    enum study_task_kind kind;
    size_t first, end;
    double nodes; /* what each costs (`study_cost`) */
    int round;
};

/* The tasks of a round, in `arena`; with STUDY_TASK_LIST of variants that they list. Problems:
 * API_OUT_OF_MEMORY. */
enum api_problem_id task_make_range(const struct task_range *range, struct arena *arena,
                                    struct api_study_plan *plan,
                                    struct api_problem *problem) STATUS_MUST_USE;
enum api_problem_id task_make_list(const struct api_study *study,
                                   const struct study_variant *variants, size_t count, int round,
                                   struct arena *arena, struct api_study_plan *plan,
                                   struct api_problem *problem) STATUS_MUST_USE;

/* Puts the tasks of `more` behind those of the plan. Problems: API_OUT_OF_MEMORY. */
enum api_problem_id task_join(struct arena *arena, struct api_study_plan *plan,
                              const struct api_study_plan *more,
                              struct api_problem *problem) STATUS_MUST_USE;

/* Nodes that a variant's net will have, about. */
double study_nodes(const struct api_study *study, double coarseness);

/* What such a net costs, in nodes of the method `gib`, each of which takes 1 to 2 us. */
double study_cost(const struct api_study *study, double coarseness);

/* ---- doing one ---- */

/* Whether these are the bytes of a task. */
bool task_is_sound(const struct api_study_task *task);

/* Variant k of a task that lists them. */
struct study_variant task_variant(const struct api_study *study, const struct api_study_task *task,
                                  size_t k);

/* A task while it is done. */
struct task_run {
    const struct api_study *study;
    const struct api_study_task *task;
    const struct drape_monitor *monitor; /* of the drapes; NULL: nobody watches */
    struct arena *arena;
    const struct api_sink *sink;
};

/* Drapes variant k of the task, unless it is known to crash, and sends its row. API_CANCELLED. */
enum api_problem_id task_drape(const struct task_run *run, size_t k,
                               const struct study_variant *variant, struct study_row *row,
                               struct api_problem *problem) STATUS_MUST_USE;

/* Sends numbers of the task; API_CANCELLED when the sink refuses. */
enum api_problem_id task_send(const struct task_run *run, const double *numbers, size_t count,
                              struct api_problem *problem) STATUS_MUST_USE;

#endif
