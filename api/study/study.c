/* SPDX-License-Identifier: MIT */
#include "engine.h"

#include "sample.h"

#include "api/json/value.h"
#include "api/request/prepared_surface.h"
#include <endian.h>
#include <math.h>
#include <string.h>

static enum api_problem_id no_memory(struct api_problem *problem) {
    api_problem_set(problem, API_OUT_OF_MEMORY, "the study needs more memory than allowed");
    return problem->id;
}

bool api_is_study(const char *bytes, size_t length, const struct api_limits *limits) {
    struct api_problem problem = {0};
    struct json_tree tree;
    bool found = false;
    struct arena *arena = arena_new(limits->max_memory);
    if (arena && json_tree_parse(&tree, bytes, length, limits, arena, &problem) == API_OK) {
        struct json_value root = value_root(&tree), drape = value_member(&root, "drape");
        found = value_given(&drape);
        json_tree_free(&tree);
    }
    arena_free(arena);
    return found;
}

/* ---- opening ---- */

/* A start of the caller's list as a place of the part. */
static struct study_start find_start(const struct api_study *study,
                                     const struct study_point *point) {
    const struct study_shape *shape = &study->shape;
    const struct drape_settings *s = &study->request.drape.settings;
    struct study_start start = {.place = {.r = point->point}};
    double distance;
    if (point->kind == DRAPE_START_POINT) {
        study_shape_nearest(shape, point->point, &start.place, &distance);
        if (!(distance <= fmax(s->spacing[0], s->spacing[1])))
            start.hopeless = FAILURE_START_OFF_SURFACE;
        return start;
    }
    memcpy(start.place.uv, point->uv, sizeof point->uv);
    if (shape->part.surface)
        return start;
    start.hopeless = FAILURE_START_OFF_SURFACE;
    for (size_t k = 0; k < shape->shell.count; k++) {
        if (shape->shell.numbers[k] == point->face) {
            start.place.face = (int32_t)k;
            start.hopeless = FAILURE_NONE;
        }
    }
    return start;
}

static enum status find_starts(struct api_study *study) {
    const struct study_request *r = &study->request;
    struct spread_place *places;
    enum status status = STATUS_OK;
    study->start_count = 1;
    if (r->starts != STUDY_STARTS_GRID && r->starts != STUDY_STARTS_POINTS)
        return STATUS_OK;
    study->start_count = r->start_count;
    if (r->starts == STUDY_STARTS_GRID) {
        bool optimise = r->search == STUDY_SEARCH_OPTIMISE;
        size_t wanted = optimise ? optimise_shares(study).starts : r->start_count;
        status = spread_over(&study->shape.part, study->shape.component, wanted, study->arena,
                             &places, &study->start_count);
    }
    study->starts = arena_alloc(study->arena, study->start_count, sizeof *study->starts);
    if (status != STATUS_OK || !study->starts)
        return STATUS_OUT_OF_MEMORY;
    for (size_t k = 0; k < study->start_count; k++)
        study->starts[k] = r->starts == STUDY_STARTS_GRID ? (struct study_start){.place = places[k]}
                                                          : find_start(study, &r->points[k]);
    return STATUS_OK;
}

/* A search for a small largest shear has that of each of so many divisions of the part. */
static enum status find_divisions(struct api_study *study) {
    struct spread_place *places;
    if (study->request.search != STUDY_SEARCH_OPTIMISE ||
        !study_judges(&study->request, QUANTITY_MAX_SHEAR))
        return STATUS_OK;
    struct vec3 *middle = arena_take(study->arena, DRAPE_DIVISIONS, sizeof *middle);
    if (!middle || spread_over(&study->shape.part, study->shape.component, DRAPE_DIVISIONS,
                               study->arena, &places, &study->bench.divisions) != STATUS_OK)
        return STATUS_OUT_OF_MEMORY;
    for (size_t k = 0; k < study->bench.divisions; k++)
        middle[k] = places[k].r;
    study->bench.middle = middle;
    return STATUS_OK;
}

/* What the drapes share, for the spacing that most variants have. Where there can be none, each
 * variant says so. */
static bool prepare_part(struct api_study *study) {
    struct drape_settings *own = &study->request.drape.settings;
    struct drape_settings settings = *own;
    const struct study_shape *shape = &study->shape;
    bool optimise = study->request.search == STUDY_SEARCH_OPTIMISE;
    double coarseness = optimise ? optimise_shares(study).coarseness : 1;
    for (int k = 0; k < 2; k++)
        settings.spacing[k] *= coarseness;
    enum status status =
        drape_prepare(&shape->part, shape->component, &settings, study->arena, &own->prepared);
    if (status != STATUS_OK)
        own->prepared = NULL;
    return status != STATUS_OUT_OF_MEMORY;
}

static enum api_problem_id open_in(struct api_study *study, const struct api_input *input,
                                   const struct api_limits *limits, struct api_problem *problem) {
    if (study_decode(input, limits, study->arena, &study->request, problem) != API_OK)
        return problem->id;
    if (study->request.drape.surface.kind == API_SURFACE_NAMED) {
        api_problem_add(problem, "/drape/surface/id", "no surface is stored under this id");
        return problem->id;
    }
    if (study_shape_make(&study->request, limits, study->arena, &study->shape, problem) != API_OK)
        return problem->id;
    if (study_bench_make(&study->request, &study->shape, study->arena, &study->bench) !=
            STATUS_OK ||
        find_starts(study) != STATUS_OK || find_divisions(study) != STATUS_OK ||
        !prepare_part(study))
        return no_memory(problem);
    return study->request.sample > 0 ? sample_prepare(study, limits, problem) : API_OK;
}

struct api_study *api_study_open(const struct api_input *input, const struct api_limits *limits,
                                 struct api_problem *problem) {
    struct arena *arena = arena_new(limits->max_memory);
    struct api_study *study = arena ? arena_alloc(arena, 1, sizeof *study) : NULL;
    if (study) {
        study->arena = arena;
        if (open_in(study, input, limits, problem) == API_OK)
            return study;
    } else {
        no_memory(problem);
    }
    arena_free(arena);
    return NULL;
}

void api_study_close(struct api_study *study) {
    if (study)
        arena_free(study->arena);
}

/* Everything that `api_study_open` does but the starts, of which there may be many. */
static void check(const struct api_input *input, const struct api_limits *limits,
                  struct arena *arena, struct api_check *check, struct api_problem *problem) {
    struct study_request request;
    struct study_shape shape;
    if (study_decode(input, limits, arena, &request, problem) != API_OK)
        return;
    const struct api_surface *surface = &request.drape.surface;
    memcpy(check->surface, surface->id, sizeof check->surface);
    check->needs_surface = surface->kind == API_SURFACE_NAMED;
    check->variants = study_variants(&request);
    if (check->needs_surface ||
        (!prepared_surface_is_large(surface) &&
         study_shape_make(&request, limits, arena, &shape, problem) != API_OK))
        return;
    if (!study_digest(&request, arena, check->digest))
        no_memory(problem);
}

enum api_problem_id api_check_study(const struct api_input *input, const struct api_limits *limits,
                                    struct api_check *result, struct api_problem *problem) {
    struct arena *arena = arena_new(limits->max_memory);
    *result = (struct api_check){0};
    if (arena)
        check(input, limits, arena, result, problem);
    else
        no_memory(problem);
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
        no_memory(problem);
    arena_free(arena);
    return problem->id;
}

/* ---- tasks ---- */

size_t api_study_task_variants(const struct api_study_task *task) {
    return (size_t)task->STUDY_TASK_VARIANTS;
}

void api_study_task_crashed(struct api_study_task *task, size_t k) {
    int crashed = (int)task->STUDY_TASK_CRASHED;
    if (crashed >= API_STUDY_CRASHES)
        return;
    task->value[STUDY_CRASHES_AT + crashed] = (double)k;
    task->STUDY_TASK_CRASHED = crashed + 1;
}

/* Whether variant k is not to be tried again. */
static bool is_blamed(const struct api_study_task *task, size_t k) {
    int crashed = (int)task->STUDY_TASK_CRASHED;
    bool blamed = false;
    for (int i = 0; i < crashed; i++)
        blamed = blamed || task->value[STUDY_CRASHES_AT + i] == (double)k;
    return blamed || (crashed == API_STUDY_CRASHES &&
                      (double)k > task->value[STUDY_CRASHES_AT + API_STUDY_CRASHES - 1]);
}

double study_nodes(const struct api_study *study, double coarseness) {
    const double *d = study->request.drape.settings.spacing;
    return 1 + study->shape.area / (d[0] * d[1] * coarseness * coarseness);
}

/* Against gib's: about what was measured on free-form parts. */
static double cost_of_a_node(const struct api_study *study) {
    const struct drape_method_traits *method =
        &drape_method_traits[study->request.drape.settings.method];
    return method->flat && study->shape.part.mesh ? 1 : method->cost;
}

double study_cost(const struct api_study *study, double coarseness) {
    return cost_of_a_node(study) * study_nodes(study, coarseness);
}

static bool keep_going(void *context, double fraction) {
    const struct study_chunk *chunk = context;
    (void)fraction;
    return chunk->monitor->progress(chunk->monitor->context, chunk->k);
}

bool study_chunk_send(const struct study_chunk *chunk, const double *numbers, size_t count) {
    enum { BLOCK = 512 };
    uint64_t bits[BLOCK];
    for (size_t first = 0; first < count; first += BLOCK) {
        size_t left = count - first, own = left < BLOCK ? left : BLOCK;
        memcpy(bits, numbers + first, own * sizeof *bits);
        for (size_t k = 0; k < own; k++)
            bits[k] = htole64(bits[k]);
        if (!chunk->sink->write(chunk->sink->context, bits, own * sizeof *bits))
            return false;
    }
    return true;
}

static bool send_row(const struct study_chunk *chunk, const struct study_row *row) {
    double numbers[STUDY_ROW_NUMBERS];
    study_row_store(row, numbers);
    return study_chunk_send(chunk, numbers, STUDY_ROW_NUMBERS) &&
           study_chunk_send(chunk, row->most, chunk->study->bench.divisions);
}

bool study_chunk_drape(struct study_chunk *chunk, const struct study_variant *variant,
                       struct study_row *row) {
    const struct drape_monitor monitor = {keep_going, chunk};
    struct study_variant tried = *variant;
    bool wanted = !chunk->monitor || keep_going(chunk, 0);
    if (is_blamed(chunk->task, chunk->k))
        tried.hopeless = FAILURE_CRASHED;
    if (wanted)
        wanted = study_variant_drape(&chunk->study->bench, &tried, chunk->monitor ? &monitor : NULL,
                                     chunk->arena, row) == STATUS_OK;
    row->round = (int)chunk->task->STUDY_TASK_ROUND;
    chunk->k++;
    if (!wanted || !send_row(chunk, row))
        api_problem_set(chunk->problem, API_CANCELLED, "the study was cancelled");
    return chunk->problem->id == API_OK;
}

enum api_problem_id api_study_run_task(const struct api_study *study,
                                       const struct api_study_task *task,
                                       const struct api_study_monitor *monitor, struct arena *arena,
                                       const struct api_sink *sink, struct api_problem *problem) {
    static bool (*const works[STUDY_WORK_KINDS])(struct study_chunk *) = {
        [STUDY_WORK_GRID] = grid_chunk,
        [STUDY_WORK_LIST] = list_chunk,
        [STUDY_WORK_SAMPLE] = sample_chunk};
    struct study_chunk chunk = {study, task, monitor, arena, sink, problem, 0};
    struct arena_mark mark = arena_mark(arena);
    double work = task->STUDY_TASK_WORK;
    if (!(work >= 0 && work < STUDY_WORK_KINDS) || work != floor(work))
        api_problem_set(problem, API_INTERNAL, "the task is none of a study's");
    else if (!works[(int)work](&chunk) && problem->id == API_OK)
        no_memory(problem);
    arena_rewind(arena, mark);
    return problem->id;
}

/* ---- rounds ---- */

struct study_row *study_rows(const struct api_study *study, const struct api_study_numbers *numbers,
                             struct arena *arena, size_t *count, struct api_problem *problem) {
    size_t divisions = study->bench.divisions;
    size_t stride = STUDY_ROW_NUMBERS + divisions + sample_fields(study);
    *count = numbers->count / stride;
    struct study_row *rows = arena_take(arena, *count, sizeof *rows);
    if (!rows) {
        no_memory(problem);
        return NULL;
    }
    bool good = *count * stride == numbers->count;
    for (size_t k = 0; good && k < *count; k++) {
        const double *own = numbers->values + k * stride;
        good = study_row_load(own, &rows[k]);
        memcpy(rows[k].most, own + STUDY_ROW_NUMBERS, divisions * sizeof *own);
    }
    if (good)
        return rows;
    api_problem_set(problem, API_INTERNAL, "the numbers are none of a study's");
    return NULL;
}

static void find_best(const struct api_study *study, const struct study_row *rows, size_t count,
                      double best[QUANTITY_COUNT]) {
    double least = HUGE_VAL;
    for (int id = 0; id < QUANTITY_COUNT; id++)
        best[id] = NAN;
    for (size_t k = 0; k < count; k++) {
        double missed = study_violation(study, &rows[k]);
        if (rows[k].failure != FAILURE_NONE || missed > least)
            continue;
        for (int id = 0; id < QUANTITY_COUNT; id++)
            if (study->request.objective[id] &&
                !(missed == least && best[id] <= rows[k].quantity[id]))
                best[id] = rows[k].quantity[id];
        least = missed;
    }
}

enum api_problem_id api_study_plan(const struct api_study *study,
                                   const struct api_study_numbers *numbers, struct arena *arena,
                                   struct api_study_plan *plan, struct api_problem *problem) {
    size_t count;
    *plan = (struct api_study_plan){0};
    const struct study_row *rows = study_rows(study, numbers, arena, &count, problem);
    if (!rows)
        return problem->id;
    plan->done = count;
    find_best(study, rows, count, plan->best);
    if (study->nominal)
        return sample_plan(study, count, arena, plan, problem);
    bool optimise = study->request.search == STUDY_SEARCH_OPTIMISE;
    return (optimise ? optimise_plan : grid_plan)(study, rows, count, arena, plan, problem);
}

/* ---- limits ---- */

double study_range(const struct api_study *study, enum quantity_id id, double value) {
    switch (id) {
    case QUANTITY_LOCKED_AREA:
    case QUANTITY_UNCOVERED_AREA:
    case QUANTITY_WASTE_AREA:
        return study->shape.area;
    case QUANTITY_FRACTION_RANGE:
    case QUANTITY_K1_RATIO:
        return fmax(fabs(value), 1);
    default:
        return quantities[id].most - quantities[id].least;
    }
}

double study_limit_excess(const struct api_study *study, const struct study_row *row,
                          enum quantity_id id, bool lower) {
    const struct study_limit *limit = &study->request.limit[id];
    double value = row->quantity[id];
    return lower ? (limit->min - value) / study_range(study, id, limit->min)
                 : (value - limit->max) / study_range(study, id, limit->max);
}

double study_limit_violation(const struct api_study *study, const struct study_row *row,
                             enum quantity_id id) {
    const struct study_limit *limit = &study->request.limit[id];
    double low = limit->has_min ? study_limit_excess(study, row, id, true) : 0;
    double high = limit->has_max ? study_limit_excess(study, row, id, false) : 0;
    return fmax(fmax(low, high), 0);
}

double study_violation(const struct api_study *study, const struct study_row *row) {
    double most = 0;
    if (row->failure != FAILURE_NONE)
        return HUGE_VAL;
    for (int k = 0; k < QUANTITY_COUNT; k++)
        most = fmax(most, study_limit_violation(study, row, (enum quantity_id)k));
    return most;
}
