/* SPDX-License-Identifier: MIT */
/* Tasks that have their variants with them. */
#include "engine.h"

#include <string.h>

/* Of a variant: face and parameters, or the point of a mesh; the angle, the pre-shear. */
enum { COARSENESS = STUDY_OWN_AT, FIRST, NUMBERS = 5, EACH = (API_STUDY_TASK - FIRST) / NUMBERS };

static void store(const struct study_variant *variant, bool mesh, double *number) {
    const struct spread_place *start = &variant->start;
    const double place[] = {start->face, start->uv[0], start->uv[1]};
    memcpy(number, mesh ? (const double[]){start->r.x, start->r.y, start->r.z} : place,
           sizeof place);
    number[3] = variant->angle_deg;
    number[4] = variant->pre_shear_deg;
}

enum api_problem_id list_tasks(const struct study_variant *variants, size_t count, int round,
                               bool mesh, struct arena *arena, struct api_study_plan *plan,
                               struct api_problem *problem) {
    size_t tasks = (count + EACH - 1) / EACH;
    struct api_study_task *list = arena_alloc(arena, tasks ? tasks : 1, sizeof *list);
    if (!list) {
        api_problem_set(problem, API_OUT_OF_MEMORY, "the study needs more memory than allowed");
        return problem->id;
    }
    for (size_t k = 0; k < count; k++) {
        struct api_study_task *task = &list[k * tasks / count];
        size_t held = api_study_task_variants(task);
        task->STUDY_TASK_WORK = STUDY_WORK_LIST;
        task->STUDY_TASK_ROUND = round;
        task->STUDY_TASK_VARIANTS = (double)(held + 1);
        task->value[COARSENESS] = variants[k].coarseness;
        store(&variants[k], mesh, &task->value[FIRST + NUMBERS * held]);
    }
    plan->tasks = list;
    plan->count = tasks;
    return API_OK;
}

bool list_chunk(struct study_chunk *chunk) {
    const struct study_shape *shape = &chunk->study->shape;
    const double *number = chunk->task->value + FIRST;
    size_t count = api_study_task_variants(chunk->task);
    for (size_t k = 0; k < count && k < EACH; k++, number += NUMBERS) {
        struct study_variant variant = {.angle_deg = number[3],
                                        .pre_shear_deg = number[4],
                                        .coarseness = chunk->task->value[COARSENESS]};
        struct study_row row;
        double distance;
        if (shape->part.mesh)
            study_shape_nearest(shape, vec3_make(number[0], number[1], number[2]), &variant.start,
                                &distance);
        else
            variant.start = study_shape_at(shape, (int32_t)number[0], number + 1);
        if (!study_chunk_drape(chunk, &variant, &row))
            return false;
    }
    return true;
}
