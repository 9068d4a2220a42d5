/* SPDX-License-Identifier: MIT */
#include "task.h"

#include <endian.h>
#include <math.h>
#include <string.h>

/* Nodes of a task, by their cost: enough that handing it out costs little, few enough that all
 * workers have some, and not so many that a drape which waits for it waits 0.2 s. */
static const double nodes_least = 3e4, nodes_most = 6e4;
enum { VARIANTS_MOST = 512 };

double study_nodes(const struct api_study *study, double coarseness) {
    const double *d = study->request.drape.settings.spacing;
    return 1 + study->part.area / (d[0] * d[1] * coarseness * coarseness);
}

double study_cost(const struct api_study *study, double coarseness) {
    const struct drape_method_traits *method =
        &drape_method_traits[study->request.drape.settings.method];
    double each = method->flat && study->part.geometry.mesh ? 1 : method->cost;
    return each * study_nodes(study, coarseness);
}

enum api_problem_id task_make_range(const struct task_range *range, struct arena *arena,
                                    struct api_study_plan *plan, struct api_problem *problem) {
    size_t variants = range->end - range->first;
    double nodes =
        fmin(fmax(range->nodes * (double)variants / TASK_SHARES, nodes_least), nodes_most);
    size_t each = (size_t)fmin(fmax(nodes / range->nodes, 1), VARIANTS_MOST);
    size_t tasks = (variants + each - 1) / each;
    struct api_study_task *list = arena_alloc(arena, tasks, sizeof *list);
    if (!list)
        return api_problem_no_memory(problem, "the study");
    for (size_t k = 0; k < tasks; k++) {
        size_t left = variants - k * each;
        list[k].kind = (int32_t)range->kind;
        list[k].round = range->round;
        list[k].variants = (int32_t)(left < each ? left : each);
        list[k].first = (int64_t)(range->first + k * each);
    }
    plan->tasks = list;
    plan->count = tasks;
    return API_OK;
}

enum api_problem_id task_make_list(const struct api_study *study,
                                   const struct study_variant *variants, size_t count, int round,
                                   struct arena *arena, struct api_study_plan *plan,
                                   struct api_problem *problem) {
    struct api_study_task *list = arena_alloc(arena, count + 1, sizeof *list);
    size_t tasks = 0, most = 0;
    if (!list)
        return api_problem_no_memory(problem, "the study");
    for (size_t k = 0; k < count; k++) {
        const struct part_point *start = &variants[k].start;
        const double point[] = {start->r.x, start->r.y, start->r.z};
        const double parameters[] = {start->face, start->uv[0], start->uv[1]};
        /* All of a task have one net. */
        bool other = k == 0 || variants[k].coarseness != variants[k - 1].coarseness;
        double cost = study_cost(study, variants[k].coarseness);
        if (other || (size_t)list[tasks - 1].variants == most)
            list[tasks++] = (struct api_study_task){
                .kind = STUDY_TASK_LIST, .round = round, .coarseness = variants[k].coarseness};
        most = (size_t)fmin(fmax(nodes_least / cost, 1), API_STUDY_LISTED);
        struct api_study_task *task = &list[tasks - 1];
        struct api_study_listed *own = &task->listed[task->variants++];
        memcpy(own->start, study->part.geometry.mesh ? point : parameters, sizeof own->start);
        own->angle_deg = variants[k].angle_deg;
        own->pre_shear_deg = variants[k].pre_shear_deg;
    }
    plan->tasks = list;
    plan->count = tasks;
    return API_OK;
}

enum api_problem_id task_join(struct arena *arena, struct api_study_plan *plan,
                              const struct api_study_plan *more, struct api_problem *problem) {
    size_t count = plan->count + more->count;
    struct api_study_task *all = arena_alloc(arena, count + 1, sizeof *all);
    if (!all)
        return api_problem_no_memory(problem, "the study");
    if (plan->count)
        memcpy(all, plan->tasks, plan->count * sizeof *all);
    if (more->count)
        memcpy(all + plan->count, more->tasks, more->count * sizeof *all);
    plan->tasks = all;
    plan->count = count;
    return API_OK;
}

/* ---- doing one ---- */

bool task_is_sound(const struct api_study_task *task) {
    bool listed = task->kind == STUDY_TASK_LIST;
    if (task->kind == STUDY_TASK_CUTS && !(task->variants == 1 && task->first <= API_STUDY_CUTS))
        return false;
    if (task->kind == STUDY_TASK_COURSES &&
        !(task->variants == 1 && task->first <= API_STUDY_UNKNOWNS && task->coarseness >= 1))
        return false;
    return task->kind >= 0 && task->kind < STUDY_TASK_KINDS && task->first >= 0 &&
           task->variants >= 0 && task->variants <= (listed ? API_STUDY_LISTED : VARIANTS_MOST) &&
           task->crash_count >= 0 && task->crash_count <= API_STUDY_CRASHES;
}

struct study_variant task_variant(const struct api_study *study, const struct api_study_task *task,
                                  size_t k) {
    const struct api_study_listed *own = &task->listed[k];
    const double *start = own->start;
    struct study_variant variant = {.angle_deg = own->angle_deg,
                                    .pre_shear_deg = own->pre_shear_deg,
                                    .coarseness = task->coarseness};
    double distance;
    if (study->part.geometry.mesh)
        study_part_nearest(&study->part, vec3_make(start[0], start[1], start[2]), &variant.start,
                           &distance);
    else
        variant.start = study_part_at(&study->part, (int32_t)start[0], start + 1);
    return variant;
}

void api_study_task_crashed(struct api_study_task *task, size_t k) {
    if (task->crash_count < API_STUDY_CRASHES)
        task->crashed[task->crash_count++] = (int32_t)k;
}

enum api_problem_id task_send(const struct task_run *run, const double *numbers, size_t count,
                              struct api_problem *problem) {
    enum { BLOCK = 512 };
    uint64_t bits[BLOCK];
    for (size_t first = 0; first < count; first += BLOCK) {
        size_t left = count - first, own = left < BLOCK ? left : BLOCK;
        memcpy(bits, numbers + first, own * sizeof *bits);
        for (size_t k = 0; k < own; k++)
            bits[k] = htole64(bits[k]);
        if (!run->sink->write(run->sink->context, bits, own * sizeof *bits))
            return api_problem_set(problem, API_CANCELLED, "the study was cancelled");
    }
    return API_OK;
}

enum api_problem_id task_drape(const struct task_run *run, size_t k,
                               const struct study_variant *variant, struct study_row *row,
                               struct api_problem *problem) {
    const struct drape_monitor *monitor = run->monitor;
    struct study_variant tried = *variant;
    struct study_ridge ridges[API_STUDY_CUTS];
    double numbers[STUDY_ROW_NUMBERS], cuts[STUDY_CUT_NUMBERS];
    /* What is known to crash is not tried again. */
    const struct api_study_task *task = run->task;
    bool known =
        task->crash_count == API_STUDY_CRASHES && (int32_t)k > task->crashed[API_STUDY_CRASHES - 1];
    for (int n = 0; n < task->crash_count; n++)
        known = known || task->crashed[n] == (int32_t)k;
    if (known)
        tried.failure = FAILURE_CRASHED;
    if ((monitor && !monitor->progress(monitor->context, 0)) ||
        study_variant_drape(run->study, &tried, monitor, run->arena, ridges, row) != STATUS_OK)
        return api_problem_set(problem, API_CANCELLED, "the study was cancelled");
    row->round = task->round;
    study_row_store(row, numbers);
    if (task_send(run, numbers, STUDY_ROW_NUMBERS, problem) != API_OK)
        return problem->id;
    if (task_send(run, row->most, run->study->divisions, problem) != API_OK)
        return problem->id;
    const struct study_request *r = &run->study->request;
    if (r->courses.base)
        return task_send(run, row->variant.unknowns, course_plan_unknowns(&r->courses), problem);
    if (r->splits == 0)
        return problem->id;
    study_row_store_cuts(row, cuts);
    return task_send(run, cuts, STUDY_CUT_NUMBERS, problem);
}
