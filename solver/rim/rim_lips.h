/* SPDX-License-Identifier: MIT */
/* What the lips of cuts come to in the flat cloth. */
#ifndef SOLVER_RIM_RIM_LIPS_H
#define SOLVER_RIM_RIM_LIPS_H

#include "rim.h"
#include "solver/result.h"

/* Measures the cuts of the march by the rim, in the march's arena. Errors: STATUS_OUT_OF_MEMORY. */
enum status rim_lips_measure(struct march *march, struct rim *rim,
                             struct drape_cuts *cuts) STATUS_MUST_USE;

#endif
