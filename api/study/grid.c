/* SPDX-License-Identifier: MIT */
/* The search that looks at all: every start with every angle and every pre-shear, in this order. */
#include "rounds.h"

#include <math.h>

/* Nodes of the first round. */
static const double nodes_round = 7.68e6;

struct study_variant grid_variant(const struct api_study *study, size_t k) {
    const struct study_request *r = &study->request;
    size_t shears = r->pre_shear.count ? r->pre_shear.count : 1;
    size_t angles = r->angle.count ? r->angle.count : 1;
    struct study_variant variant = {.coarseness = 1};
    if (r->pre_shear.count)
        variant.pre_shear_deg = study_angle(&r->pre_shear, k % shears);
    if (r->angle.count)
        variant.angle_deg = study_angle(&r->angle, k / shears % angles);
    if (study->starts) {
        variant.start = study->starts[k / (shears * angles)].point;
        variant.failure = study->starts[k / (shears * angles)].failure;
    }
    return variant;
}

/* Rounds, after each of which the best so far is told: the first of as much as a round is worth,
 * then each as large as all before, so that there are few of them. */
enum api_problem_id grid_plan(const struct api_study *study, const struct study_row *rows,
                              size_t count, struct arena *arena, struct api_study_plan *plan,
                              struct api_problem *problem) {
    const struct study_request *r = &study->request;
    double nodes = study_cost(study, 1);
    size_t all = study->start_count * (r->angle.count ? r->angle.count : 1) *
                 (r->pre_shear.count ? r->pre_shear.count : 1);
    size_t size = (size_t)fmax(nodes_round / nodes, TASK_SHARES);
    size = count > size ? count : size;
    const struct task_range range = {.kind = STUDY_TASK_GRID,
                                     .first = count,
                                     .end = count + size < all ? count + size : all,
                                     .nodes = nodes,
                                     .round = count ? rows[count - 1].round + 1 : 0};
    plan->variants = all;
    return count >= all ? API_OK : task_make_range(&range, arena, plan, problem);
}
