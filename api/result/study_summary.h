/* SPDX-License-Identifier: MIT */
/* What the header of a study's result says of all its variants together. */
#ifndef API_RESULT_STUDY_SUMMARY_H
#define API_RESULT_STUDY_SUMMARY_H

#include "quantity.h"
#include "summary.h"
#include <stdbool.h>
#include <stddef.h>

struct api_study_summary {
    size_t variants; /* rows */
    size_t coarse;   /* of them on a coarser net than the drape's own: none of these is `best` */
    size_t failed, feasible, pareto;
    bool objective[QUANTITY_COUNT];
    int best[QUANTITY_COUNT]; /* the variant with the least of an objective; of those that keep the
                                 limits or, where none does, that which comes nearest; -1: none */
    int hardest; /* the limit that the fewest variants keep, where none keeps all; else -1 */
    struct api_verdict verdict; /* by the variant that is nearest to it; of samples the worst */
    struct api_warnings warnings;
    double solve_ms;
    char solver_version[API_VERSION_SIZE];
};

struct api_text;
struct json_value;

/* The object `summary` of a study's document, with `queue_ms` of waiting unless that is negative.
 */
void study_summary_write(struct api_text *text, const struct api_study_summary *summary,
                         double queue_ms);

/* The object `best`: the index of each objective, or null. */
void study_summary_write_best(struct api_text *text, const struct api_study_summary *summary);

/* Reads both from one object; what is wrong is reported to the place's problem. */
void study_summary_read(const struct json_value *json, struct api_study_summary *summary);

#endif
