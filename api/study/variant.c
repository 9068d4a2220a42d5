/* SPDX-License-Identifier: MIT */
#include "variant.h"

#include "course_search.h"

#include "api/result/fields.h"
#include "api/result/shear_limit.h"
#include "api/result/verdict.h"
#include "solver/angle.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- rows ---- */

void study_row_store(const struct study_row *row, double numbers[STUDY_ROW_NUMBERS]) {
    const struct study_variant *v = &row->variant;
    const double own[] = {row->round,       v->start.face, v->start.uv[0], v->start.uv[1],
                          v->start.r.x,     v->start.r.y,  v->start.r.z,   v->angle_deg,
                          v->pre_shear_deg, v->coarseness, row->failure,   row->bare,
                          row->placed,      row->at.x,     row->at.y,      row->at.z,
                          row->shear_deg,   row->limit_deg};
    memcpy(numbers, own, sizeof own);
    memcpy(numbers + sizeof own / sizeof *own, row->quantity, sizeof row->quantity);
}

void study_row_store_cuts(const struct study_row *row, double numbers[STUDY_CUT_NUMBERS]) {
    const void *ends[] = {row->variant.cuts, row->ridges};
    const size_t count[] = {row->variant.cut_count, row->ridge_count};
    memset(numbers, 0, STUDY_CUT_NUMBERS * sizeof *numbers);
    for (int k = 0; k < 2; k++) {
        double *own = numbers + k * (STUDY_CUT_NUMBERS / 2);
        own[0] = (double)count[k];
        if (count[k])
            memcpy(own + 1, ends[k], count[k] * sizeof(struct study_cut));
    }
}

/* The cuts or ridges, as two ends each, at half of such numbers; NULL where there are more than can
 * be. */
static const void *read_ends(const double *numbers, size_t *count) {
    bool good = numbers[0] >= 0 && numbers[0] <= API_STUDY_CUTS;
    *count = good ? (size_t)numbers[0] : 0;
    return good ? numbers + 1 : NULL;
}

/* A search of the largest budget has fewer rounds. */
enum { ROUNDS_MOST = 1000 };

/* A whole number from 0 to below `most`. */
static bool is_whole_below(double x, double most) {
    return x >= 0 && x < most && x == floor(x);
}

static size_t study_row_stride(const struct api_study *study) {
    const struct study_request *r = &study->request;
    size_t cuts = r->splits ? STUDY_CUT_NUMBERS : 0;
    size_t unknowns = r->courses.base ? course_plan_unknowns(&r->courses) : 0;
    return STUDY_ROW_NUMBERS + study->divisions + cuts + unknowns + study->field_numbers;
}

enum api_problem_id study_rows(const struct api_study *study,
                               const struct api_study_numbers *numbers, struct arena *arena,
                               const struct study_row **rows, size_t *count,
                               struct api_problem *problem) {
    size_t divisions = study->divisions;
    size_t stride = study_row_stride(study);
    *count = numbers->count / stride;
    struct study_row *made = arena_take(arena, *count, sizeof *made);
    *rows = made;
    if (!made)
        return api_problem_no_memory(problem, "the study");
    bool good = *count * stride == numbers->count;
    for (size_t k = 0; good && k < *count; k++) { /* numbers that no row has are refused */
        const double *n = numbers->values + k * stride;
        for (int i = 0; i < STUDY_ROW_NUMBERS; i++)
            good = good && isfinite(n[i]);
        good = good && is_whole_below(n[0], ROUNDS_MOST) && is_whole_below(n[1], INT32_MAX) &&
               is_whole_below(n[10], FAILURE_COUNT);
        if (!good)
            break;
        made[k] = (struct study_row){
            .variant = {.start = {(int32_t)n[1], {n[2], n[3]}, vec3_make(n[4], n[5], n[6])},
                        .angle_deg = n[7],
                        .pre_shear_deg = n[8],
                        .coarseness = n[9]},
            .round = (int)n[0],
            .failure = (enum failure)n[10],
            .bare = n[11] > 0,
            .placed = n[12] > 0,
            .at = vec3_make(n[13], n[14], n[15]),
            .shear_deg = n[16],
            .limit_deg = n[17]};
        memcpy(made[k].quantity, n + STUDY_ROW_NUMBERS - QUANTITY_COUNT, sizeof made[k].quantity);
        memcpy(made[k].most, n + STUDY_ROW_NUMBERS, divisions * sizeof *n);
        const double *cuts = n + STUDY_ROW_NUMBERS + divisions;
        made[k].variant.unknowns = study->request.courses.base ? cuts : NULL;
        if (!study->request.splits)
            continue;
        made[k].variant.cuts = read_ends(cuts, &made[k].variant.cut_count);
        made[k].ridges = read_ends(cuts + STUDY_CUT_NUMBERS / 2, &made[k].ridge_count);
        good = made[k].variant.cuts && made[k].ridges;
    }
    return good ? API_OK
                : api_problem_set(problem, API_INTERNAL, "these are not numbers of a study");
}

/* ---- k1 by shear ---- */

static int compare_k1(const void *a, const void *b) {
    const struct study_k1_ratio *x = a, *y = b;
    return x->ratio != y->ratio ? (x->ratio > y->ratio) - (x->ratio < y->ratio)
                                : (x->bin > y->bin) - (x->bin < y->bin);
}

static double k1_of(const struct api_request *request, double shear_deg) {
    double vf = api_fields_fiber_volume_fraction(request, shear_deg);
    return api_permeability_at(&request->permeability, vf, shear_deg, request->settings.slide, NULL)
        .k1;
}

enum status study_find_k1(struct api_study *study) {
    const struct api_request *drape = &study->request.drape;
    double most = quantities[QUANTITY_K1_RATIO].most;
    if (!study_judges(&study->request, QUANTITY_K1_RATIO))
        return STATUS_OK;
    study->k1 = arena_take(study->arena, DRAPE_SHEAR_BINS, sizeof *study->k1);
    if (!study->k1)
        return STATUS_OUT_OF_MEMORY;
    double unsheared = k1_of(drape, 0);
    for (int bin = 0; bin < DRAPE_SHEAR_BINS; bin++) {
        double ratio = k1_of(drape, fmin((bin + 0.5) * DRAPE_SHEAR_BIN, 90)) / unsheared;
        double factor = ratio < 1 ? 1 / ratio : ratio;
        study->k1[bin] = (struct study_k1_ratio){factor < most ? factor : most, bin};
    }
    qsort(study->k1, DRAPE_SHEAR_BINS, sizeof *study->k1, compare_k1);
    return STATUS_OK;
}

/* ---- from a drape to numbers ---- */

/* The ratio of k1 that 95 % of the area has less than, straight between the bins. */
static double k1_quantile(const struct study_k1_ratio *k1,
                          const struct drape_statistics *statistics) {
    double all = 0, sum = 0;
    for (int bin = 0; bin < DRAPE_SHEAR_BINS; bin++)
        all += statistics->area[bin];
    for (int k = 0; k < DRAPE_SHEAR_BINS; k++) {
        double own = statistics->area[k1[k].bin], wanted = 0.95 * all - sum;
        if (own > 0 && own >= wanted) {
            double next = k1[k + 1 < DRAPE_SHEAR_BINS ? k + 1 : k].ratio;
            return k1[k].ratio + fmax(wanted / own, 0) * (next - k1[k].ratio);
        }
        sum += own;
    }
    return 1;
}

/* The area of a bin whose shear is negative, or positive. */
static double area_of_sign(const struct drape_statistics *statistics, int bin, bool negative) {
    double area = statistics->negative[bin];
    return negative ? area : fmax(statistics->area[bin] - area, 0);
}

/* The area beyond a shear of one sign, its bin shared out evenly. */
static double area_beyond(const struct drape_statistics *statistics, double shear_deg,
                          bool negative) {
    double at = shear_deg / DRAPE_SHEAR_BIN, sum = 0;
    int first = (int)at;
    if (first >= DRAPE_SHEAR_BINS)
        return 0;
    for (int bin = DRAPE_SHEAR_BINS - 1; bin > first; bin--)
        sum += area_of_sign(statistics, bin, negative);
    return sum + area_of_sign(statistics, first, negative) * (first + 1 - at);
}

/* The area, each bin times its severity. */
static double severity_area(const struct api_fabric *fabric,
                            const struct drape_statistics *statistics) {
    double sum = 0;
    for (int bin = 0; bin < DRAPE_SHEAR_BINS; bin++)
        for (int negative = 0; negative < 2 && statistics->area[bin] > 0; negative++) {
            double shear_deg = (negative ? -1 : 1) * (bin + 0.5) * DRAPE_SHEAR_BIN;
            sum +=
                area_of_sign(statistics, bin, negative) * shear_limit_severity(fabric, shear_deg);
        }
    return sum;
}

/* Vf of the greatest less that of the least shear: in a rigid cavity it grows with the shear. */
static double fraction_range(const struct api_request *request,
                             const struct drape_statistics *statistics, double most) {
    int bin = 0;
    while (bin < DRAPE_SHEAR_BINS - 1 && !(statistics->area[bin] > 0))
        bin++;
    double least = fmin(bin * DRAPE_SHEAR_BIN, most);
    double range = api_fields_fiber_volume_fraction(request, most) -
                   api_fields_fiber_volume_fraction(request, least);
    return fmin(fmax(range, 0), quantities[QUANTITY_FRACTION_RANGE].most);
}

/* ---- one drape ---- */

static const enum failure failures[] = {
    [STATUS_OK] = FAILURE_NONE,
    [STATUS_OUT_OF_MEMORY] = FAILURE_OUT_OF_MEMORY,
    [STATUS_CANCELLED] = FAILURE_CRASHED,
    [STATUS_INVALID] = FAILURE_DIRECTION,
    [STATUS_TOO_MANY_NODES] = FAILURE_TOO_MANY_NODES,
    [STATUS_START_OFF_SURFACE] = FAILURE_START_OFF_SURFACE,
    [STATUS_START_STUCK] = FAILURE_START_STUCK,
    [STATUS_DEGENERATE_SURFACE] = FAILURE_DEGENERATE_SURFACE,
    [STATUS_GENERATOR_OFF_START] = FAILURE_GENERATOR,
    [STATUS_GENERATOR_PARALLEL] = FAILURE_GENERATOR,
    [STATUS_CUT] = FAILURE_CUT,
    [STATUS_NO_CONVERGENCE] = FAILURE_DEGENERATE_SURFACE,
};

struct drape_settings study_variant_settings(const struct api_study *study,
                                             const struct study_variant *variant) {
    const struct study_request *r = &study->request;
    struct drape_settings s = r->drape.settings;
    for (int k = 0; k < 2; k++)
        s.spacing[k] *= variant->coarseness;
    if (r->starts != STUDY_STARTS_KEPT) {
        s.start_kind = study->part.geometry.mesh ? DRAPE_START_POINT : DRAPE_START_UV;
        s.start_face = study->part.geometry.mesh ? 0 : variant->start.face;
        memcpy(s.start_uv, variant->start.uv, sizeof s.start_uv);
        s.start_point = variant->start.r;
    }
    if (r->angle.count > 0 || r->angle.deviation > 0) {
        s.direction_kind = DRAPE_DIRECTION_ANGLE;
        s.direction_deg = variant->angle_deg;
    }
    if (r->pre_shear.count > 0 || r->pre_shear.deviation > 0)
        s.pre_shear_deg = variant->pre_shear_deg;
    if (variant->lines) {
        s.cuts = variant->lines;
        s.cut_count += variant->cut_count;
    }
    return s;
}

void study_note_direction(const struct api_study *study, const struct drape_settings *settings,
                          const struct drape_result *result, struct study_variant *variant) {
    struct vec3 normal, along;
    variant->pre_shear_deg = settings->pre_shear_deg;
    if (settings->direction_kind == DRAPE_DIRECTION_ANGLE)
        variant->angle_deg = settings->direction_deg;
    else if (study_part_axes(&study->part, &variant->start, &normal, &along))
        variant->angle_deg =
            angle_atan2_deg(vec3_dot(vec3_cross(along, result->start_warp), normal),
                            vec3_dot(along, result->start_warp));
}

/* Along which the net of a drape asks for cuts. */
static enum status find_ridges(const struct api_study *study, const struct drape_result *result,
                               struct study_ridge ridges[API_STUDY_CUTS], struct arena *arena,
                               struct study_row *row) {
    const double *d = study->request.drape.settings.spacing;
    const struct proposal_case c = {.part = &study->part,
                                    .edge = &study->edge,
                                    .result = result,
                                    .limit_deg = study->request.limit[QUANTITY_MAX_SHEAR].max,
                                    .bare = row->bare && row->placed,
                                    .at = row->at,
                                    .spacing = fmax(d[0], d[1])};
    row->ridges = ridges;
    return proposal_find(&c, ridges, study->request.splits, arena, &row->ridge_count);
}

enum status study_variant_drape(const struct api_study *study, const struct study_variant *variant,
                                const struct drape_monitor *monitor, struct arena *arena,
                                struct study_ridge ridges[API_STUDY_CUTS], struct study_row *row) {
    struct drape_statistics statistics = {.wanted = study->request.wanted,
                                          .exponent = study->request.exponent,
                                          .middle = study->middle,
                                          .divisions = study->divisions};
    struct drape_settings settings = study_variant_settings(study, variant);
    struct drape_result result = {0};
    *row = (struct study_row){.variant = *variant, .failure = variant->failure};
    for (int k = 0; k < QUANTITY_COUNT; k++)
        row->quantity[k] = -1;
    if (variant->failure != FAILURE_NONE)
        return STATUS_OK;
    struct arena_mark mark = arena_mark(arena);
    if (study->request.courses.base) {
        enum status laid = course_search_lay(study, monitor, arena, row);
        arena_rewind(arena, mark);
        row->failure = failures[laid];
        return laid == STATUS_CANCELLED ? laid : STATUS_OK;
    }
    settings.statistics = &statistics;
    enum status status = drape_solve(&study->part.geometry, &settings, monitor, arena, &result);
    bool bare = status == STATUS_OK && result.cells.count == 0;
    row->failure = bare ? FAILURE_NO_CLOTH : failures[status];
    if (status == STATUS_OK && study->request.starts == STUDY_STARTS_KEPT)
        row->variant.start = study_start_of(&result);
    if (status == STATUS_OK)
        study_note_direction(study, &settings, &result, &row->variant);
    if (row->failure == FAILURE_NONE) {
        const struct api_request *drape = &study->request.drape;
        const struct drape_summary *s = &result.summary;
        const double *low = statistics.lower, *high = statistics.upper;
        double width = (high[0] - low[0]) * settings.spacing[0], *q = row->quantity;
        double limit_deg[2];
        verdict_shear_limits(drape, limit_deg);
        const struct verdict_case judged = verdict_case_of(&result, limit_deg);
        row->bare = judged.bare;
        row->placed = judged.placed;
        row->at = judged.at;
        row->shear_deg = judged.shear_deg;
        row->limit_deg = judged.limit_deg;
        memcpy(row->most, statistics.most, sizeof row->most);
        q[QUANTITY_MAX_SHEAR] = s->max_shear_deg;
        q[QUANTITY_P95_SHEAR] = s->p95_shear_deg;
        q[QUANTITY_MEAN_SHEAR] = s->mean_shear_deg;
        q[QUANTITY_CLOTH_COVERAGE] = s->cloth_coverage;
        q[QUANTITY_UNCOVERED_AREA] = fmax(s->part_area * (1 - s->cloth_coverage), 0);
        /* a rectangle round the flat pattern, along the yarns, less the pattern */
        q[QUANTITY_WASTE_AREA] =
            fmax(width * (high[1] - low[1]) * settings.spacing[1] - s->flat_area, 0);
        if (study_judges(&study->request, QUANTITY_LOCKED_AREA))
            q[QUANTITY_LOCKED_AREA] =
                area_beyond(&statistics, drape->fabric.locking_angle_deg[0], false) +
                area_beyond(&statistics, drape->fabric.locking_angle_deg[1], true);
        if (study_judges(&study->request, QUANTITY_SEVERITY_AREA))
            q[QUANTITY_SEVERITY_AREA] = severity_area(&drape->fabric, &statistics);
        if (study_judges(&study->request, QUANTITY_ANGLE_DEVIATION))
            q[QUANTITY_ANGLE_DEVIATION] = statistics.wanted_deg;
        if (study_judges(&study->request, QUANTITY_FRACTION_RANGE))
            q[QUANTITY_FRACTION_RANGE] = fraction_range(drape, &statistics, s->max_shear_deg);
        if (study->k1)
            q[QUANTITY_K1_RATIO] = k1_quantile(study->k1, &statistics);
        q[QUANTITY_CUT_LENGTH] = 0;
        for (size_t k = 0; k < result.cuts.count; k++)
            q[QUANTITY_CUT_LENGTH] += result.cuts.length[k];
    }
    if (row->failure == FAILURE_NONE && study->request.splits > 0 &&
        find_ridges(study, &result, ridges, arena, row) != STATUS_OK)
        row->failure = FAILURE_OUT_OF_MEMORY;
    arena_rewind(arena, mark);
    return status == STATUS_CANCELLED ? status : STATUS_OK;
}
