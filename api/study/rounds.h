/* SPDX-License-Identifier: MIT */
/* The rounds of a grid and of an optimisation; those of samples are in `sample.h`. Each plans the
 * tasks of the next round, from the rows of all rounds before, and makes its numbered variants. */
#ifndef API_STUDY_ROUNDS_H
#define API_STUDY_ROUNDS_H

#include "task.h"

/* Every start with every angle and every pre-shear. */
enum api_problem_id grid_plan(const struct api_study *study, const struct study_row *rows,
                              size_t count, struct arena *arena, struct api_study_plan *plan,
                              struct api_problem *problem) STATUS_MUST_USE;
struct study_variant grid_variant(const struct api_study *study, size_t k);

/* The search that learns (`optimise.c`). */
enum api_problem_id optimise_plan(const struct api_study *study, const struct study_row *rows,
                                  size_t count, struct arena *arena, struct api_study_plan *plan,
                                  struct api_problem *problem) STATUS_MUST_USE;

/* Variant k of its first round. */
struct study_variant optimise_variant(const struct api_study *study, size_t k);

/* How it shares its budget out. */
struct optimise_shares {
    size_t starts; /* of the first round, which looks everywhere */
    size_t each;   /* angles and pre-shears at each of them */
    double period; /* of the warp's angle; 0: it is bounded by the study's range */
    double coarseness;
};
struct optimise_shares optimise_shares(const struct api_study *study);

#endif
