/* SPDX-License-Identifier: MIT */
/* How good a row is: how far it is from keeping the study's limits. */
#ifndef API_STUDY_SCORE_H
#define API_STUDY_SCORE_H

#include "variant.h"

/* What a quantity ranges over on this part, by which its differences are compared; for one without
 * an end how large `value` is. */
double study_range(const struct api_study *study, enum quantity_id id, double value);

/* How far a row is from keeping the study's limits: the largest share of the quantity's range by
 * which one is missed, 0 where all are kept; infinite for a failure. */
double study_violation(const struct api_study *study, const struct study_row *row);

/* The same of one limit, of a row that is no failure. */
double study_limit_violation(const struct api_study *study, const struct study_row *row,
                             enum quantity_id id);

#endif
