/* SPDX-License-Identifier: MIT */
#include "study.h"

#include "course_search.h"
#include "cut_search.h"
#include "rounds.h"
#include "sample.h"
#include "score.h"

#include "api/json/value.h"
#include "api/request/prepared_part.h"
#include <math.h>
#include <string.h>

/* ---- opening ---- */

/* The starts of all epochs of a search, one after the other. */
static enum status spread_epochs(struct api_study *study, struct part_point **points) {
    const struct study_part *part = &study->part;
    size_t room = 0, made = 0, budget = study->request.budget;
    struct optimise_epoch epoch = {0};
    for (size_t k = 0; epoch.end < budget; k++) {
        epoch = optimise_epoch(study, k);
        room += epoch.starts;
    }
    *points = arena_alloc(study->arena, room, sizeof **points);
    epoch.end = 0;
    for (size_t k = 0; *points && epoch.end < budget; k++) {
        struct part_point *own;
        size_t count;
        struct arena_mark mark = arena_mark(study->arena);
        epoch = optimise_epoch(study, k);
        enum status status =
            even_points(&part->geometry, part->component, epoch.starts, study->arena, &own, &count);
        if (status != STATUS_OK)
            return status;
        for (size_t n = 0; n < epoch.starts && count > 0; n++)
            (*points)[made++] = own[n % count];
        arena_rewind(study->arena, mark);
    }
    study->start_count = made;
    return *points ? STATUS_OK : STATUS_OUT_OF_MEMORY;
}

/* Those of a grid, or of the caller's list as points of the part. */
static enum status find_starts(struct api_study *study) {
    const struct study_request *r = &study->request;
    const struct study_part *part = &study->part;
    const double *spacing = r->drape.settings.spacing;
    bool grid = r->starts == STUDY_STARTS_GRID, optimise = r->search == STUDY_SEARCH_OPTIMISE;
    struct part_point *points = NULL;
    enum status status = STATUS_OK;
    study->start_count = 1;
    if (!grid && r->starts != STUDY_STARTS_POINTS)
        return STATUS_OK;
    study->start_count = r->start_count;
    if (grid && optimise)
        status = spread_epochs(study, &points);
    else if (grid)
        status = even_points(&part->geometry, part->component, r->start_count, study->arena,
                             &points, &study->start_count);
    if (status != STATUS_OK)
        return status;
    study->starts = arena_alloc(study->arena, study->start_count, sizeof *study->starts);
    if (!study->starts)
        return STATUS_OUT_OF_MEMORY;
    for (size_t k = 0; k < study->start_count; k++) {
        const struct study_point *listed = grid ? NULL : &r->points[k];
        struct study_start *start = &study->starts[k];
        bool found = true;
        if (!listed) {
            start->point = points[k];
        } else if (listed->kind == DRAPE_START_POINT) {
            double distance;
            study_part_nearest(part, listed->point, &start->point, &distance);
            found = distance <= fmax(spacing[0], spacing[1]);
        } else {
            start->point.r = listed->point;
            memcpy(start->point.uv, listed->uv, sizeof listed->uv);
            found = part->geometry.surface != NULL;
            for (size_t face = 0; !found && face < part->shell.count; face++) {
                found = part->shell.numbers[face] == listed->face;
                start->point.face = found ? (int32_t)face : 0;
            }
        }
        start->failure = found ? FAILURE_NONE : FAILURE_START_OFF_SURFACE;
    }
    return STATUS_OK;
}

static enum api_problem_id prepare_study(struct api_study *study, const struct api_input *input,
                                         const struct api_limits *limits,
                                         struct api_problem *problem) {
    struct drape_settings *own = &study->request.drape.settings;
    const struct study_part *part = &study->part;
    if (study_decode(input, limits, study->arena, &study->request, problem) != API_OK)
        return problem->id;
    if (study->request.drape.surface.kind == API_SURFACE_NAMED)
        return api_problem_add(problem, "/drape/surface/id", "no surface is stored under this id");
    if (study_part_make(&study->request, limits, study->arena, &study->part, problem) != API_OK)
        return problem->id;
    if (study->request.courses.base)
        return API_OK;
    bool optimise = study->request.search == STUDY_SEARCH_OPTIMISE;
    if (study_find_k1(study) != STATUS_OK || (optimise && obvious_make(study) != STATUS_OK) ||
        find_starts(study) != STATUS_OK)
        return api_problem_no_memory(problem, "the study");
    /* A search for a small largest shear has that of each of so many divisions of the part. */
    if (optimise && study_judges(&study->request, QUANTITY_MAX_SHEAR)) {
        struct part_point *points;
        struct vec3 *middle = arena_take(study->arena, DRAPE_DIVISIONS, sizeof *middle);
        if (!middle || even_points(&part->geometry, part->component, DRAPE_DIVISIONS, study->arena,
                                   &points, &study->divisions) != STATUS_OK)
            return api_problem_no_memory(problem, "the study");
        for (size_t k = 0; k < study->divisions; k++)
            middle[k] = points[k].r;
        study->middle = middle;
    }
    /* What the drapes share, for the spacing that most variants have. Where there can be none, each
     * variant says so. */
    struct drape_settings settings = *own;
    double coarseness = optimise ? optimise_space(study).coarseness : 1;
    for (int k = 0; k < 2; k++)
        settings.spacing[k] *= coarseness;
    enum status status =
        drape_prepare(&part->geometry, part->component, &settings, study->arena, &own->prepared);
    if (status == STATUS_OUT_OF_MEMORY)
        return api_problem_no_memory(problem, "the study");
    if (status != STATUS_OK)
        own->prepared = NULL;
    if (study->request.splits > 0 && cut_search_prepare(study) != STATUS_OK)
        return api_problem_no_memory(problem, "the study");
    return study->request.sample > 0 ? sample_prepare(study, limits, problem) : API_OK;
}

struct api_study *api_study_open(const struct api_input *input, const struct api_limits *limits,
                                 struct api_problem *problem) {
    struct arena *arena = arena_new(limits->max_memory);
    struct api_study *study = arena ? arena_alloc(arena, 1, sizeof *study) : NULL;
    if (study) {
        study->arena = arena;
        if (prepare_study(study, input, limits, problem) == API_OK)
            return study;
    } else {
        api_problem_no_memory(problem, "the study");
    }
    arena_free(arena);
    return NULL;
}

void api_study_close(struct api_study *study) {
    if (study)
        arena_free(study->arena);
}

bool api_study_digest(const struct api_study *study, struct arena *arena, char id[API_ID_SIZE]) {
    return study_digest(&study->request, arena, id);
}

bool api_study_lays_courses(const struct api_study *study) {
    return study->request.courses.base != NULL;
}

/* Everything that `api_study_open` does but the starts, of which there may be many. */
enum api_problem_id api_check_study(const struct api_input *input, const struct api_limits *limits,
                                    const struct api_sink *forms, struct api_check *check,
                                    struct api_problem *problem) {
    struct arena *arena = arena_new(limits->max_memory);
    struct study_request request;
    struct study_part part = {0};
    *check = (struct api_check){0};
    if (arena && forms)
        arena_clear(arena);
    if (!arena) {
        api_problem_no_memory(problem, "the study");
    } else if (study_decode(input, limits, arena, &request, problem) == API_OK &&
               api_check_names(input, &request.drape, arena, check, problem) == API_OK) {
        check->variants = study_variants(&request);
        bool large = prepared_part_is_large(&request.drape.surface);
        bool wanted = forms && !large && !check->needs_surface &&
                      api_check_expects_form(&request.drape, arena);
        bool sound = !check->needs_surface &&
                     (large || study_part_make(&request, limits, arena, &part, problem) == API_OK);
        const struct prepared_part made = {.part = part.geometry, .shell = part.shell};
        if (sound && wanted)
            api_check_write_form(&request.drape, &made, arena, forms, check);
        if (sound && !study_digest(&request, arena, check->digest))
            api_problem_no_memory(problem, "the study");
    }
    arena_free(arena);
    return problem->id;
}

enum api_problem_id api_study_normalise(const struct api_input *input,
                                        const struct api_limits *limits,
                                        const struct api_sink *sink, struct api_problem *problem) {
    struct study_request request;
    struct arena *arena = arena_new(limits->max_memory);
    const char *text = NULL;
    if (arena && study_decode(input, limits, arena, &request, problem) == API_OK)
        text = study_normalise(&request, arena);
    if (problem->id == API_OK && (!text || !sink->write(sink->context, text, strlen(text))))
        api_problem_no_memory(problem, "the study");
    arena_free(arena);
    return problem->id;
}

/* ---- tasks ---- */

/* Who watches a task, while one of its variants is draped. */
struct variant_watch {
    const struct api_study_monitor *monitor;
    size_t variant;
};

static bool watch_variant(void *context, double fraction) {
    const struct variant_watch *watch = context;
    (void)fraction;
    return watch->monitor->progress(watch->monitor->context, watch->variant);
}

enum api_problem_id api_study_run_task(const struct api_study *study,
                                       const struct api_study_task *task,
                                       const struct api_study_monitor *monitor, struct arena *arena,
                                       const struct api_sink *sink, struct api_problem *problem) {
    static struct study_variant (*const numbered[STUDY_TASK_KINDS])(
        const struct api_study *, size_t) = {[STUDY_TASK_GRID] = grid_variant,
                                             [STUDY_TASK_OPTIMISE] = optimise_variant,
                                             [STUDY_TASK_SAMPLE] = sample_variant};
    struct variant_watch watch = {monitor, 0};
    const struct drape_monitor drapes = {watch_variant, &watch};
    const struct study_courses *courses = &study->request.courses;
    const struct task_run run = {study, task, monitor ? &drapes : NULL, arena, sink};
    if (!task_is_sound(task) || (task->kind == STUDY_TASK_COURSES) != (courses->base != NULL) ||
        (courses->base && (size_t)task->first != course_plan_unknowns(courses)))
        return api_problem_set(problem, API_INTERNAL, "this is not a task of a study");
    for (size_t k = 0; problem->id == API_OK && k < (size_t)task->variants; k++) {
        struct arena_mark mark = arena_mark(arena);
        struct study_variant variant = {.coarseness = 1};
        struct study_row row;
        if (task->kind == STUDY_TASK_LIST)
            variant = task_variant(study, task, k);
        else if (task->kind == STUDY_TASK_COURSES)
            variant =
                (struct study_variant){.coarseness = task->coarseness, .unknowns = task->courses};
        else if (task->kind != STUDY_TASK_CUTS)
            variant = numbered[task->kind](study, (size_t)task->first + k);
        else if (cut_search_lay(study, (const struct study_cut *)(const void *)task->cuts,
                                (size_t)task->first, arena, &variant) != STATUS_OK)
            return api_problem_no_memory(problem, "the study");
        watch.variant = k;
        if (task_drape(&run, k, &variant, &row, problem) == API_OK &&
            task->kind == STUDY_TASK_SAMPLE)
            (void)!sample_send_fields(&run, &row, problem);
        arena_rewind(arena, mark);
    }
    return problem->id;
}

/* ---- rounds ---- */

enum api_problem_id api_study_plan(const struct api_study *study,
                                   const struct api_study_numbers *numbers, struct arena *arena,
                                   struct api_study_plan *plan, struct api_problem *problem) {
    const struct study_row *rows;
    size_t count;
    double least = HUGE_VAL;
    *plan = (struct api_study_plan){0};
    if (study_rows(study, numbers, arena, &rows, &count, problem) != API_OK)
        return problem->id;
    plan->done = count;
    /* The least of each objective, of the variants that miss the limits by the least. */
    for (int id = 0; id < QUANTITY_COUNT; id++)
        plan->best[id] = NAN;
    for (size_t k = 0; k < count; k++) {
        double missed = study_violation(study, &rows[k]);
        if (rows[k].failure != FAILURE_NONE || missed > least)
            continue;
        for (int id = 0; id < QUANTITY_COUNT; id++)
            if (study->request.objective[id] &&
                !(missed == least && plan->best[id] <= rows[k].quantity[id]))
                plan->best[id] = rows[k].quantity[id];
        least = missed;
    }
    if (study->nominal)
        return sample_plan(study, count, arena, plan, problem);
    if (study->request.splits > 0)
        return cut_search_plan(study, rows, count, arena, plan, problem);
    if (study->request.courses.base)
        return course_search_plan(study, rows, count, arena, plan, problem);
    bool optimise = study->request.search == STUDY_SEARCH_OPTIMISE;
    return (optimise ? optimise_plan : grid_plan)(study, rows, count, arena, plan, problem);
}
