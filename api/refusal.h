/* SPDX-License-Identifier: MIT */
/* What the solver did not accept, as a problem with the member of the request that is at fault. */
#ifndef API_REFUSAL_H
#define API_REFUSAL_H

#include "problem.h"
#include "solver/drape.h"

/* The problem of a drape's status; `result` says which cut, or which generator. API_OK of
 * STATUS_OK. */
enum api_problem_id refusal_of_status(struct api_problem *problem, enum status status,
                                      const struct drape_settings *settings,
                                      const struct drape_result *result);

#endif
