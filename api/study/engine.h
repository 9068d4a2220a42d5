/* SPDX-License-Identifier: MIT */
/* Inside of a study: what its rounds and tasks have in common. */
#ifndef API_STUDY_ENGINE_H
#define API_STUDY_ENGINE_H

#include "request.h"
#include "shape.h"
#include "study.h"
#include "variant.h"

struct api_study {
    struct arena *arena; /* that holds all of it */
    struct study_request request;
    struct study_shape shape;
    struct study_bench bench;
    struct study_start {
        struct spread_place place;
        enum failure hopeless;      /* why it cannot be draped from; FAILURE_NONE: it can */
    } * starts;                     /* those of a grid, or of a list */
    size_t start_count;             /* 1 where the drape's own is kept, which is not in `starts` */
    struct sample_nominal *nominal; /* of a study that draws samples, else NULL */
};

/* A task as `struct api_study_task` holds it. */
enum study_work { STUDY_WORK_GRID, STUDY_WORK_LIST, STUDY_WORK_SAMPLE, STUDY_WORK_KINDS };
enum { STUDY_CRASHES_AT = 4, STUDY_OWN_AT = STUDY_CRASHES_AT + API_STUDY_CRASHES };
#define STUDY_TASK_WORK value[0]
#define STUDY_TASK_VARIANTS value[1] /* at the most */
#define STUDY_TASK_ROUND value[2]
#define STUDY_TASK_CRASHED value[3] /* how many crashes follow */

/* A task while it is done. */
struct study_chunk {
    const struct api_study *study;
    const struct api_study_task *task;
    const struct api_study_monitor *monitor;
    struct arena *arena;
    const struct api_sink *sink;
    struct api_problem *problem;
    size_t k; /* the variant that comes next */
};

/* Drapes the next variant of a task, unless it is known to crash, and sends its row. False with the
 * problem set when the task has to stop. */
bool study_chunk_drape(struct study_chunk *chunk, const struct study_variant *variant,
                       struct study_row *row) STATUS_MUST_USE;

/* All rows of a study's numbers, in `arena`; NULL with the problem set. */
struct study_row *study_rows(const struct api_study *study, const struct api_study_numbers *numbers,
                             struct arena *arena, size_t *count, struct api_problem *problem);

/* Nodes that a variant's net will have, about. */
double study_nodes(const struct api_study *study, double coarseness);

/* What such a net costs, in nodes of the method `gib`, each of which takes 1 to 2 us. */
double study_cost(const struct api_study *study, double coarseness);

/* What a quantity ranges over on this part, by which its differences are compared; for one without
 * an end how large `value` is. */
double study_range(const struct api_study *study, enum quantity_id id, double value);

/* How far a row is from keeping the study's limits: the largest share of the quantity's range by
 * which one is missed, 0 where all are kept; infinite for a failure. */
double study_violation(const struct api_study *study, const struct study_row *row);

/* By how much, as a share of its range, a quantity is beyond a limit's lower or upper end; negative
 * within. */
double study_limit_excess(const struct api_study *study, const struct study_row *row,
                          enum quantity_id id, bool lower);

/* The same of one limit. */
double study_limit_violation(const struct api_study *study, const struct study_row *row,
                             enum quantity_id id);

/* Sends numbers of a task. */
bool study_chunk_send(const struct study_chunk *chunk, const double *numbers, size_t count);

/* ---- searches: the next round's tasks, and one of them ---- */

enum api_problem_id grid_plan(const struct api_study *study, const struct study_row *rows,
                              size_t count, struct arena *arena, struct api_study_plan *plan,
                              struct api_problem *problem) STATUS_MUST_USE;
bool grid_chunk(struct study_chunk *chunk) STATUS_MUST_USE;

/* What a search is to make small, at most so many things. */
enum { STUDY_AIMS_MOST = 16 };

/* How an optimisation shares its budget out; in `optimise.c`. */
struct optimise_shares {
    size_t starts; /* of the first round, which looks everywhere */
    size_t each;   /* angles and pre-shears at each of them */
    double period; /* of the warp's angle; 0: it is bounded by the study's range */
    double coarseness;
};
struct optimise_shares optimise_shares(const struct api_study *study);

/* Variant k of the first round. */
struct study_variant optimise_variant(const struct api_study *study, size_t k);

/* Lists tasks of the variants, in `list.c`. */
enum api_problem_id list_tasks(const struct study_variant *variants, size_t count, int round,
                               bool mesh, struct arena *arena, struct api_study_plan *plan,
                               struct api_problem *problem) STATUS_MUST_USE;

enum api_problem_id optimise_plan(const struct api_study *study, const struct study_row *rows,
                                  size_t count, struct arena *arena, struct api_study_plan *plan,
                                  struct api_problem *problem) STATUS_MUST_USE;
bool list_chunk(struct study_chunk *chunk) STATUS_MUST_USE;

/* Tasks of one kind for variants that are numbered, each of which costs `nodes` (`study_cost`): of
 * those from `first` to `end - 1`. */
struct grid_range {
    enum study_work work;
    size_t first, end;
    double nodes;
    int round;
};
enum api_problem_id grid_tasks(const struct grid_range *range, struct arena *arena,
                               struct api_study_plan *plan,
                               struct api_problem *problem) STATUS_MUST_USE;

#endif
