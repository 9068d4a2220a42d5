/* SPDX-License-Identifier: MIT */
/* The search that looks at all: every start with every angle and every pre-shear, in this order. */
#include "engine.h"

#include <math.h>

/* Nodes of a task, by their cost: enough that handing it out costs little, few enough that all
 * workers have some, and not so many that a drape which waits for it waits 0.2 s. */
static const double nodes_least = 3e4, nodes_most = 6e4;
enum { SHARES = 64, VARIANTS_MOST = 512 };

/* Nodes of the first round. */
static const double nodes_round = 7.68e6;

static size_t at_least_one(size_t count) {
    return count ? count : 1;
}

static size_t variant_count(const struct api_study *study) {
    return study->start_count * at_least_one(study->request.angle.count) *
           at_least_one(study->request.pre_shear.count);
}

static struct study_variant variant_at(const struct api_study *study, size_t k) {
    const struct study_request *r = &study->request;
    size_t shears = at_least_one(r->pre_shear.count), angles = at_least_one(r->angle.count);
    struct study_variant variant = {.coarseness = 1};
    if (r->pre_shear.count)
        variant.pre_shear_deg = study_angle(&r->pre_shear, k % shears);
    if (r->angle.count)
        variant.angle_deg = study_angle(&r->angle, k / shears % angles);
    if (study->starts) {
        variant.start = study->starts[k / (shears * angles)].place;
        variant.hopeless = study->starts[k / (shears * angles)].hopeless;
    }
    return variant;
}

static size_t variants_of_a_task(size_t variants, double nodes) {
    double share = fmin(fmax(nodes * (double)variants / SHARES, nodes_least), nodes_most);
    return (size_t)fmin(fmax(share / nodes, 1), VARIANTS_MOST);
}

enum api_problem_id grid_tasks(const struct grid_range *range, struct arena *arena,
                               struct api_study_plan *plan, struct api_problem *problem) {
    size_t variants = range->end - range->first;
    size_t each = variants_of_a_task(variants, range->nodes);
    size_t tasks = (variants + each - 1) / each;
    struct api_study_task *list = arena_alloc(arena, tasks, sizeof *list);
    if (!list) {
        api_problem_set(problem, API_OUT_OF_MEMORY, "the study needs more memory than allowed");
        return problem->id;
    }
    for (size_t k = 0; k < tasks; k++) {
        size_t left = variants - k * each;
        list[k].STUDY_TASK_WORK = range->work;
        list[k].STUDY_TASK_ROUND = range->round;
        list[k].STUDY_TASK_VARIANTS = (double)(left < each ? left : each);
        list[k].value[STUDY_OWN_AT] = (double)(range->first + k * each);
    }
    plan->tasks = list;
    plan->count = tasks;
    return API_OK;
}

/* Rounds, after each of which the best so far is told: the first of as much as a round is worth,
 * then each as large as all before, so that there are few of them. */
enum api_problem_id grid_plan(const struct api_study *study, const struct study_row *rows,
                              size_t count, struct arena *arena, struct api_study_plan *plan,
                              struct api_problem *problem) {
    double nodes = study_cost(study, 1);
    size_t all = plan->variants = variant_count(study);
    size_t size = (size_t)fmax(nodes_round / nodes, SHARES);
    size = count > size ? count : size;
    const struct grid_range range = {.work = STUDY_WORK_GRID,
                                     .first = count,
                                     .end = count + size < all ? count + size : all,
                                     .nodes = nodes,
                                     .round = count ? rows[count - 1].round + 1 : 0};
    return count >= all ? API_OK : grid_tasks(&range, arena, plan, problem);
}

bool grid_chunk(struct study_chunk *chunk) {
    const struct api_study *study = chunk->study;
    bool optimise = study->request.search == STUDY_SEARCH_OPTIMISE;
    size_t first = (size_t)chunk->task->value[STUDY_OWN_AT];
    size_t count = api_study_task_variants(chunk->task);
    struct study_row row;
    for (size_t k = first; k < first + count; k++) {
        struct study_variant variant = optimise ? optimise_variant(study, k) : variant_at(study, k);
        if (!study_chunk_drape(chunk, &variant, &row))
            return false;
    }
    return true;
}
