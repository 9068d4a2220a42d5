/* SPDX-License-Identifier: MIT */
/*
 * What became of the plies of a laminate: what each covers, and of one that is divided how its
 * pieces meet, or what its courses take. The ply book prints it, the command line tells it, and it
 * is a document of its own.
 */
#ifndef API_LAMINATE_ACCOUNT_H
#define API_LAMINATE_ACCOUNT_H

#include "api/json/text.h"
#include "flat_plies.h"
#include "seams.h"

/* Of a ply of the request; lengths and areas in the laminate's unit. */
struct ply_account {
    size_t first, count; /* its entries among the plies of the laminate: 1, or its pieces */
    const struct flat_ply *shapes[LAMINATE_SIBLINGS_MAX]; /* of each; NULL: it has no cloth */
    double covered; /* share of what it is to cover that at least one piece covers; NaN: no cloth */
    const struct seam *seams; /* between its pieces along splits, in the arena */
    size_t seam_count;
    double courses[COURSE_FIGURES]; /* of all, as `courses_sum_up`; NaN: it is not laid in them */
};

/* Accounts for the ply whose first entry is `first`, by its shapes, which outlive the account.
 * Problems: as `seams_make`; the account then has no seams. */
enum api_problem_id ply_account_make(const struct laminate *laminate,
                                     const struct flat_plies *shapes, size_t first,
                                     struct arena *arena, struct ply_account *account,
                                     struct api_problem *problem) STATUS_MUST_USE;

/* Writes the account of all plies: `LaminateAccount` in the description of the interface. `nets`
 * as for patterns; `problems` has why nets are NULL, or is NULL itself. What cannot be found out of
 * a ply stands among its warnings. Problems: API_INTERNAL for a damaged net. */
enum api_problem_id laminate_account_write(const struct laminate *laminate,
                                           const struct api_reader *const *nets,
                                           const struct api_problem *problems,
                                           struct api_text *text,
                                           struct api_problem *problem) STATUS_MUST_USE;

#endif
