/* SPDX-License-Identifier: MIT */
#include "sample.h"

#include "seeded.h"

#include "api/json/text.h"
#include "api/map/map.h"
#include "api/result/cell_corners.h"
#include "api/result/fields.h"
#include "solver/angle.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- a drape as a stored result in memory ---- */

static bool append_to_text(void *context, const void *bytes, size_t length) {
    struct api_text *text = context;
    api_text_bytes(text, bytes, length);
    return !text->failed;
}

/* Keeps all fields of a drape. */
static enum api_problem_id store_drape(const struct api_study *study,
                                       const struct drape_settings *settings,
                                       const struct api_fields *fields, struct arena *arena,
                                       struct api_memory *memory, struct api_problem *problem) {
    size_t room = API_HEADER_MAX;
    for (size_t k = 0; k < fields->count; k++)
        room += fields->source[k].rows * sizeof(double);
    char *bytes = arena_take(arena, room, 1);
    struct api_text text = api_text_over(bytes, bytes ? room : 0);
    const struct api_sink sink = {.write = append_to_text, .context = &text};
    struct api_columns header = {.grid = {.spacing = {settings->spacing[0], settings->spacing[1]}},
                                 .unit = study->request.drape.length_unit};
    *memory = (struct api_memory){0};
    if (api_columns_write(&header, fields->source, fields->count, &sink, arena, problem) != API_OK)
        return problem->id;
    *memory = (struct api_memory){text.bytes, text.length};
    return API_OK;
}

/* ---- the nominal drape ---- */

/* The middles of the cells, the mean of their corners, and the names of what is known of them. */
static bool find_cells(const struct api_reader *reader, const struct api_columns *columns,
                       const struct drape_nodes *nodes, struct arena *arena,
                       struct sample_nominal *nominal) {
    size_t count = api_columns_rows(columns, API_TABLE_CELLS);
    nominal->count = count;
    nominal->names = arena_alloc(arena, columns->count, sizeof *nominal->names);
    nominal->places = arena_take(arena, count, sizeof *nominal->places);
    nominal->middles = arena_take(arena, count, sizeof *nominal->middles);
    int32_t(*corners)[4] = arena_take(arena, count, sizeof *corners);
    struct cell_corners *quads = arena_take(arena, 1, sizeof *quads);
    if (!nominal->names || !nominal->places || !nominal->middles || !corners || !quads ||
        !cell_corners_begin(quads, reader, columns) ||
        !cell_corners_next(quads, count, corners, nominal->places))
        return false;
    for (size_t k = 0; k < columns->count; k++) {
        const struct api_column *column = &columns->column[k];
        if (column->table == API_TABLE_CELLS && strcmp(column->name, "i") != 0 &&
            strcmp(column->name, "j") != 0)
            memcpy(nominal->names[nominal->field_count++], column->name, API_COLUMN_NAME_SIZE);
    }
    for (size_t k = 0; k < count; k++) {
        struct vec3 sum = {0, 0, 0};
        for (int c = 0; c < 4; c++) {
            size_t node = (size_t)corners[k][c];
            sum = vec3_add(sum, vec3_make(nodes->x[node], nodes->y[node], nodes->z[node]));
        }
        nominal->middles[k] = vec3_scale(0.25, sum);
    }
    return true;
}

enum api_problem_id sample_prepare(struct api_study *study, const struct api_limits *limits,
                                   struct api_problem *problem) {
    const struct drape_settings *settings = &study->request.drape.settings;
    struct sample_nominal *nominal = arena_alloc(study->arena, 1, sizeof *nominal);
    struct drape_result *result = arena_alloc(study->arena, 1, sizeof *result);
    struct api_fields fields;
    struct api_memory memory;
    struct api_columns columns;
    if (!nominal || !result)
        return api_problem_no_memory(problem, "the study");
    if (drape_solve(&study->part.geometry, settings, NULL, study->arena, result) != STATUS_OK ||
        api_fields_list(&fields, &study->request.drape, result, study->arena) != STATUS_OK ||
        result->cells.count == 0)
        return api_problem_set_at(
            problem, API_INVALID_REQUEST, "/drape",
            "must be a drape that succeeds and has cells, because samples are drawn about it");
    const struct api_reader reader = api_reader_of(&memory);
    if (store_drape(study, settings, &fields, study->arena, &memory, problem) != API_OK ||
        api_columns_open(&reader, &columns, problem) != API_OK)
        return problem->id;
    if (!find_cells(&reader, &columns, &result->nodes, study->arena, nominal))
        return api_problem_no_memory(problem, "the study");
    nominal->variant = (struct study_variant){
        .start = study_start_of(result), .angle_deg = settings->direction_deg, .coarseness = 1};
    study_note_direction(study, settings, result, &nominal->variant);
    nominal->axis[0] = result->start_warp;
    nominal->axis[1] = vec3_unit(vec3_axpy(-vec3_dot(result->start_weft, result->start_warp),
                                           result->start_warp, result->start_weft));
    study->nominal = nominal;
    study->field_numbers = nominal->count * nominal->field_count;
    /* The last step has all fields of all samples and the rows beside them; it is better to say
     * before the first that it will not have the memory. */
    double each = (double)(study->field_numbers + 2 * STUDY_ROW_NUMBERS) * sizeof(double);
    double most = (double)limits->max_memory / each;
    if ((double)study->request.sample > most)
        return api_problem_set_at(
            problem, API_TOO_LARGE, "/sample",
            "must be at most %.0f with the %zu cells and %zu fields of this drape "
            "in %zu bytes of memory: draw fewer samples, or use a wider spacing",
            floor(most), nominal->count, nominal->field_count, limits->max_memory);
    return API_OK;
}

/* ---- drawing ---- */

static double normal_deviate(uint32_t seed, size_t k, unsigned first) {
    enum { SUMMANDS = 12 };
    double sum = -SUMMANDS / 2.0;
    for (unsigned d = 0; d < SUMMANDS; d++)
        sum += seeded_uniform(seed, k, first + d);
    return sum;
}

/* Dimensions: a start has two, its place among a number of them one, each angle twelve. */
enum { PLACE = 0, RADIUS = 1, TURN = 2, ANGLE = 8, PRE_SHEAR = 20, COMMON = 32 };

struct study_variant sample_variant(const struct api_study *study, size_t k) {
    const struct study_request *r = &study->request;
    const struct sample_nominal *n = study->nominal;
    struct study_variant variant = n->variant;
    if (r->starts == STUDY_STARTS_DISC) {
        size_t place = k; /* or one of so many places that all samples share */
        unsigned more = 0;
        double sine, cosine;
        if (r->start_count) {
            place = (size_t)(seeded_uniform(r->seed, k, PLACE) * (double)r->start_count);
            more = COMMON;
        }
        double distance = r->radius * sqrt(seeded_uniform(r->seed, place, more + RADIUS));
        angle_sincos_deg(360 * seeded_uniform(r->seed, place, more + TURN), &sine, &cosine);
        struct vec3 way = vec3_axpy(sine, n->axis[1], vec3_scale(cosine, n->axis[0]));
        variant.start = study_part_shift(&study->part, &variant.start, vec3_scale(distance, way));
    }
    if (r->angle.deviation > 0)
        variant.angle_deg += r->angle.deviation * normal_deviate(r->seed, k, ANGLE);
    if (r->pre_shear.deviation > 0) {
        variant.pre_shear_deg += r->pre_shear.deviation * normal_deviate(r->seed, k, PRE_SHEAR);
        variant.pre_shear_deg = fmin(fmax(variant.pre_shear_deg, -80), 80);
    }
    return variant;
}

/* ---- tasks ---- */

enum api_problem_id sample_plan(const struct api_study *study, size_t count, struct arena *arena,
                                struct api_study_plan *plan, struct api_problem *problem) {
    enum { DRAPES = 4 }; /* that one sample takes as long as */
    plan->variants = study->request.sample;
    const struct task_range range = {
        .kind = STUDY_TASK_SAMPLE, .end = plan->variants, .nodes = DRAPES * study_cost(study, 1)};
    return count ? API_OK : task_make_range(&range, arena, plan, problem);
}

enum api_problem_id sample_send_fields(const struct task_run *run, const struct study_row *row,
                                       struct api_problem *problem) {
    const struct api_study *study = run->study;
    const struct sample_nominal *n = study->nominal;
    const struct map_target target = {.vertices = n->middles,
                                      .vertex_count = n->count,
                                      .element_count = n->count,
                                      .cloth = &study->request.drape};
    struct arena *arena = run->arena;
    double *values = arena_alloc(arena, study->field_numbers, sizeof *values);
    struct drape_result *result = arena_alloc(arena, 1, sizeof *result);
    struct api_map *map = arena_alloc(arena, 1, sizeof *map);
    if (!values || !result || !map)
        return api_problem_no_memory(problem, "the study");
    if (row->failure == FAILURE_NONE) {
        struct drape_settings settings = study_variant_settings(study, &row->variant);
        struct api_fields fields;
        struct api_memory memory;
        const struct api_reader reader = api_reader_of(&memory);
        if (drape_solve(&study->part.geometry, &settings, run->monitor, arena, result) !=
                STATUS_OK ||
            api_fields_list(&fields, &study->request.drape, result, arena) != STATUS_OK)
            return api_problem_set(problem, API_CANCELLED, "the study was cancelled");
        if (store_drape(study, &settings, &fields, arena, &memory, problem) != API_OK ||
            api_map_make(&reader, &target, run->monitor, arena, map, problem) != API_OK)
            return problem->id;
        for (size_t f = 0; f < n->field_count; f++)
            for (size_t c = 0; c < map->fields.column_count; c++)
                if (strcmp(map->columns[c].name, n->names[f]) == 0)
                    map->columns[c].fill(map->columns[c].context, 0, n->count,
                                         values + f * n->count);
    }
    return task_send(run, values, study->field_numbers, problem);
}

/* ---- bands ---- */

/* Brings the value number k in rising order to its place, none greater before it and none less
 * behind (C. A. R. Hoare, Algorithm 65). */
static void select_at(double *values, ptrdiff_t count, ptrdiff_t k) {
    ptrdiff_t low = 0, high = count - 1;
    while (low < high) {
        double pivot = values[k];
        ptrdiff_t i = low, j = high;
        while (i <= j) {
            while (values[i] < pivot)
                i++;
            while (pivot < values[j])
                j--;
            if (i > j)
                break;
            double swapped = values[i];
            values[i++] = values[j];
            values[j--] = swapped;
        }
        low = j < k ? i : low;
        high = k < i ? j : high;
    }
}

/* What a share of all that could be drawn is less than, straight between the values, of which
 * number k of n in rising order has k / (n + 1) below it on the mean (W. Weibull, 1939); beyond the
 * first or last nothing is known. Changes their order. */
static double weibull_quantile(double *values, size_t count, double share) {
    double last = (double)(count - 1);
    double at = fmin(fmax(share * (double)(count + 1) - 1, 0), last), next = HUGE_VAL;
    size_t low = (size_t)at;
    select_at(values, (ptrdiff_t)count, (ptrdiff_t)low);
    for (size_t k = low + 1; k < count; k++)
        next = fmin(next, values[k]);
    return low + 1 < count ? values[low] + (at - (double)low) * (next - values[low]) : values[low];
}

static bool add_band(const struct sample_nominal *n, const char *name, const char *suffix,
                     const double *values, struct arena *arena, struct api_column_source *source) {
    char *own = arena_alloc(arena, API_COLUMN_NAME_SIZE, 1);
    if (!own || !values)
        return false;
    (void)snprintf(own, API_COLUMN_NAME_SIZE, "%.24s%s", name, suffix);
    *source = (struct api_column_source){.table = API_TABLE_BANDS,
                                         .name = own,
                                         .integer = suffix[0] == '\0' && name[1] == '\0' &&
                                                    (name[0] == 'i' || name[0] == 'j'),
                                         .rows = n->count,
                                         .fill = api_fields_copy,
                                         .context = values};
    return true;
}

size_t sample_bands(const struct api_study *study, const struct api_study_numbers *numbers,
                    const struct study_row *rows, size_t count, struct arena *arena,
                    struct api_column_source *sources) {
    static const char *const places[] = {"i", "j", "x", "y", "z"};
    static const char *const suffixes[] = {"_mean", "_p05", "_p95"};
    enum { PLACES = sizeof places / sizeof *places, BANDS = sizeof suffixes / sizeof *suffixes };
    const struct sample_nominal *n = study->nominal;
    size_t stride = STUDY_ROW_NUMBERS + study->field_numbers, made = 0;
    double *samples = arena_take(arena, count, sizeof *samples), *values[PLACES];
    for (int c = 0; c < PLACES; c++) {
        values[c] = arena_take(arena, n->count, sizeof *values[c]);
        if (!add_band(n, places[c], "", values[c], arena, &sources[made++]))
            return SIZE_MAX;
    }
    if (!samples)
        return SIZE_MAX;
    for (size_t k = 0; k < n->count; k++) {
        const struct vec3 *m = &n->middles[k];
        const double own[PLACES] = {n->places[k][0], n->places[k][1], m->x, m->y, m->z};
        for (int c = 0; c < PLACES; c++)
            values[c][k] = own[c];
    }
    for (size_t f = 0; f < n->field_count; f++) {
        for (int b = 0; b < BANDS; b++) {
            values[b] = arena_take(arena, n->count, sizeof *values[b]);
            if (!add_band(n, n->names[f], suffixes[b], values[b], arena, &sources[made++]))
                return SIZE_MAX;
        }
        for (size_t cell = 0; cell < n->count; cell++) {
            const double *own = numbers->values + STUDY_ROW_NUMBERS + f * n->count + cell;
            size_t held = 0;
            double sum = 0;
            for (size_t k = 0; k < count; k++)
                if (rows[k].failure == FAILURE_NONE)
                    samples[held++] = own[k * stride];
            for (size_t k = 0; k < held; k++)
                sum += samples[k];
            values[0][cell] = held ? sum / (double)held : 0;
            values[1][cell] = held ? weibull_quantile(samples, held, 0.05) : 0;
            values[2][cell] = held ? weibull_quantile(samples, held, 0.95) : 0;
        }
    }
    return made;
}
