/* SPDX-License-Identifier: MIT */
/*
 * A local search: the start moved on the surface, the warp turned, the pre-shear changed, until an
 * aim is as small as it gets and the study's limits are kept, by NLopt's COBYLA (Powell's linear
 * approximations), which needs no derivatives and takes limits as limits.
 */
#ifndef API_STUDY_REFINE_H
#define API_STUDY_REFINE_H

#include "study.h"
#include "variant.h"

/* What is to be small: the greatest of factor q + shift over the quantities q whose factor is not
 * 0. */
struct refine_aim {
    double factor[QUANTITY_COUNT], shift[QUANTITY_COUNT];
};

double refine_value(const struct refine_aim *aim, const double quantity[QUANTITY_COUNT]);

/* A search as a task has it. */
struct refine_order {
    struct study_variant from;
    struct refine_aim aim;
    size_t variants; /* at the most */
    double step[3]; /* to begin with: of the start in space, of the angle, of the pre-shear; 0: kept
                     */
    double period;  /* of the angle; 0: bounded by the study's range */
};

void refine_store(const struct refine_order *order, struct api_study_task *task);
void refine_load(const struct api_study_task *task, struct refine_order *order);

#endif
