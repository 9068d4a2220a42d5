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

/* Variant k of those that look everywhere. */
struct study_variant optimise_variant(const struct api_study *study, size_t k);

/* What it looks through, and on which nets. */
struct optimise_space {
    double turn;       /* of the warp's angle, after which the net is the same: 90, 180 or 360 */
    double period;     /* the same where the study's range is all of it, else 0 */
    double coarseness; /* of the net that it looks everywhere on */
    double fine;       /* share of its proposals that are draped with the drape's own spacing */
};
struct optimise_space optimise_space(const struct api_study *study);

/* A part of the search, whatever the budget: variants from `first` to before `end`. Of them look
 * everywhere: `starts`, with so many angles and pre-shears at each. */
struct optimise_epoch {
    size_t first, end, starts, each;
};
struct optimise_epoch optimise_epoch(const struct api_study *study, size_t number);

/* Sets `study->obvious`: the drape's own start and the place of the part's planes of symmetry next
 * to it, with the drape's own direction, 0, 45, 90 and -45 degrees and those of the planes, as far
 * as the study varies them. Errors: STATUS_OUT_OF_MEMORY. */
enum status obvious_make(struct api_study *study) STATUS_MUST_USE;

#endif
