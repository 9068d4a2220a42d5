/* SPDX-License-Identifier: MIT */
/*
 * What a worker does for a study: `api/study/study.h` by the orders of a dispatcher. The study that
 * was made ready last is kept, since nearly always the next order is about the same.
 */
#ifndef SERVER_WORK_STUDY_H
#define SERVER_WORK_STUDY_H

#include "worker.h"

/* As in `struct worker_engine`. */
enum api_problem_id study_step(const struct worker_order *order, struct worker_round *round,
                               const struct api_sink *sink, struct api_problem *problem);
enum api_problem_id study_task(const struct worker_order *order,
                               const struct drape_monitor *monitor, const struct api_sink *sink,
                               struct api_problem *problem);

#endif
