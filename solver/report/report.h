/* SPDX-License-Identifier: MIT */
/* The result of a march: the net as sorted columns, its cells, its front and the summary. */
#ifndef SOLVER_REPORT_REPORT_H
#define SOLVER_REPORT_REPORT_H

#include "solver/march/march.h"
#include "solver/result.h"

/* Fills `result` from the grown net, in the march's arena. Errors: STATUS_OUT_OF_MEMORY. */
enum status report_make(struct march *march, struct drape_result *result) STATUS_MUST_USE;

#endif
