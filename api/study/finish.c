/* SPDX-License-Identifier: MIT */
/* What all variants of a study say together: which keep its limits, which are the best, which no
 * other beats in everything; and its result as columns. */
#include "course_search.h"
#include "cut_search.h"
#include "sample.h"
#include "score.h"

#include "api/request/normalise.h"
#include "api/result/warnings.h"
#include "solver/angle.h"
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* A study's rows while they are judged. */
struct verdict {
    const struct api_study *study;
    const struct study_row *rows;
    size_t count;
    double *violation; /* of each row */
    uint8_t *pareto;
    struct api_study_summary summary;
};

/* Whether a row may be the best: it was draped with the drape's own spacing. */
static bool is_eligible(const struct study_row *row) {
    return row->failure == FAILURE_NONE && !(row->variant.coarseness > 1);
}

/* ---- the front ---- */

/* The objectives of a row, for sorting. */
struct point {
    double value[QUANTITY_COUNT];
    size_t row;
};

static int compare_points(const void *a, const void *b) {
    const struct point *x = a, *y = b;
    for (int k = 0; k < QUANTITY_COUNT; k++)
        if (x->value[k] != y->value[k])
            return x->value[k] < y->value[k] ? -1 : 1;
    return (x->row > y->row) - (x->row < y->row);
}

/* In the order of the first objective, then the next, a point is dominated only by one before it,
 * and then by one of the front so far. */
static bool find_front(struct verdict *v, struct arena *arena) {
    struct point *points = arena_take(arena, v->count, sizeof *points);
    size_t count = 0, front = 0;
    if (!points)
        return false;
    for (size_t k = 0; k < v->count; k++) {
        if (!is_eligible(&v->rows[k]) || v->violation[k] > 0)
            continue;
        struct point *point = &points[count++];
        point->row = k;
        for (int id = 0; id < QUANTITY_COUNT; id++)
            point->value[id] = v->study->request.objective[id] ? v->rows[k].quantity[id] : 0;
    }
    qsort(points, count, sizeof *points, compare_points);
    for (size_t k = 0; k < count; k++) {
        bool beaten = false; /* as good in all objectives and better in one */
        for (size_t f = 0; f < front && !beaten; f++) {
            bool worse = false;
            for (int id = 0; id < QUANTITY_COUNT && !worse; id++) {
                worse = points[f].value[id] > points[k].value[id];
                beaten = beaten || points[f].value[id] < points[k].value[id];
            }
            beaten = beaten && !worse;
        }
        if (beaten)
            continue;
        v->pareto[points[k].row] = 1;
        points[front++] = points[k];
    }
    v->summary.pareto = front;
    return true;
}

/* ---- the summary ---- */

/* Where no variant keeps all limits: the limit that the fewest keep, of equals that which is missed
 * by the most at the least, and what the variants have of it. */
static void find_hardest(struct verdict *v) {
    struct api_study_summary *s = &v->summary;
    double hardest = -1, low = HUGE_VAL, high = -HUGE_VAL;
    char pointer[40];
    size_t fewest = SIZE_MAX;
    s->hardest = -1;
    for (int id = 0; id < QUANTITY_COUNT && s->feasible == 0; id++) {
        const struct study_limit *limit = &v->study->request.limit[id];
        double least = HUGE_VAL;
        size_t keep = 0;
        for (size_t k = 0; k < v->count; k++) {
            if (!is_eligible(&v->rows[k]))
                continue;
            double missed = study_limit_violation(v->study, &v->rows[k], (enum quantity_id)id);
            keep += missed <= 0;
            least = fmin(least, missed);
        }
        if (!(limit->has_min || limit->has_max) || isinf(least))
            continue;
        if (keep < fewest || (keep == fewest && least > hardest)) {
            fewest = keep;
            hardest = least;
            s->hardest = id;
        }
    }
    if (s->hardest < 0)
        return;
    const char *name = quantities[s->hardest].name;
    const struct study_limit *limit = &v->study->request.limit[s->hardest];
    for (size_t k = 0; k < v->count; k++) {
        if (!is_eligible(&v->rows[k]))
            continue;
        low = fmin(low, v->rows[k].quantity[s->hardest]);
        high = fmax(high, v->rows[k].quantity[s->hardest]);
    }
    (void)snprintf(pointer, sizeof pointer, "/limits/%s", name);
    warnings_add(&s->warnings, "infeasible", pointer,
                 "no variant keeps all limits; the hardest is that of %s: the variants have %.6g "
                 "to %.6g, and the limit is %s%.6g",
                 name, low, high, limit->has_max ? "at most " : "at least ",
                 limit->has_max ? limit->max : limit->min);
}

static void summarise_rows(struct verdict *v, double solve_ms) {
    const struct study_request *r = &v->study->request;
    struct api_study_summary *s = &v->summary;
    size_t each[FAILURE_COUNT] = {0};
    double least = DRAPE_COMPLETE_COVERAGE;
    int most = FAILURE_NONE + 1, worst = -1;
    s->variants = v->count;
    s->solve_ms = solve_ms;
    strncpy(s->solver_version, DRAPE_VERSION, sizeof s->solver_version - 1);
    for (size_t k = 0; k < v->count; k++) {
        each[v->rows[k].failure]++;
        s->coarse += v->rows[k].variant.coarseness > 1;
        s->feasible += is_eligible(&v->rows[k]) && !(v->violation[k] > 0);
    }
    s->failed = v->count - each[FAILURE_NONE];
    /* The best of each objective, of the rows that may be it: that which misses the limits by less,
     * then that with less of the objective; the first of equals. */
    for (int id = 0; id < QUANTITY_COUNT; id++) {
        int *best = &s->best[id];
        *best = -1;
        s->objective[id] = r->objective[id];
        for (size_t a = 0; s->objective[id] && a < v->count; a++) {
            size_t b = *best < 0 ? a : (size_t)*best;
            bool better = v->rows[a].quantity[id] < v->rows[b].quantity[id];
            if (v->violation[a] != v->violation[b])
                better = v->violation[a] < v->violation[b];
            if (is_eligible(&v->rows[a]) && (*best < 0 || better))
                *best = (int)a;
        }
        double coverage = *best < 0 ? 1 : v->rows[*best].quantity[QUANTITY_CLOTH_COVERAGE];
        worst = coverage < least ? id : worst;
        least = fmin(coverage, least);
    }
    find_hardest(v);
    /* A drape that ends soon has little shear and little waste: what is best by them may cover
     * little of the part unless the study asks for that. */
    if (worst >= 0 && !r->objective[QUANTITY_UNCOVERED_AREA] &&
        !r->limit[QUANTITY_CLOTH_COVERAGE].has_min && !r->limit[QUANTITY_UNCOVERED_AREA].has_max)
        warnings_add(&s->warnings, "uncovered", "/limits",
                     "the best by %s covers %.3g of the part: with the limit \"cloth_coverage\": "
                     "{\"min\": 0.99} only variants that cover it count",
                     quantities[worst].name, least);
    /* How many failed, and what for the most of them. */
    for (int k = most; k < FAILURE_COUNT; k++)
        most = each[k] > each[most] ? k : most;
    if (s->failed > 0)
        warnings_add(
            &s->warnings, "failed", "",
            "%zu of %zu variants could not be draped, %zu of them because of %s; the column "
            "failure has the reason of each",
            s->failed, v->count, each[most], failure_names[most]);
    /* a hand is not that far off, but a length in another unit is */
    if (r->starts == STUDY_STARTS_DISC && ANGLE_PI * r->radius * r->radius > v->study->part.area)
        warnings_add(&s->warnings, "disc", "/vary/start/radius",
                     "the disc of the starts is larger than the part; starts beyond the part are "
                     "moved to its rim");
}

/* ---- whether the part can be draped ---- */

/* What a row leaves to be wished: the limits that it misses, what is bare beyond what a limit
 * allows, the shear beyond what the fabric bears. */
struct shortfall {
    double part[3], value;
};

/* By how much its shear is beyond the limit of the study or, without one, what the fabric bears. */
static double excess_shear(const struct verdict *v, const struct study_row *row) {
    const struct study_limit *limit = &v->study->request.limit[QUANTITY_MAX_SHEAR];
    return limit->has_max ? row->quantity[QUANTITY_MAX_SHEAR] - limit->max
                          : row->shear_deg - row->limit_deg;
}

static struct shortfall shortfall_of(const struct verdict *v, size_t k) {
    const struct study_row *row = &v->rows[k];
    const struct study_limit *cover = &v->study->request.limit[QUANTITY_CLOTH_COVERAGE];
    double covered = row->quantity[QUANTITY_CLOTH_COVERAGE];
    bool bare = row->bare && !(cover->has_min && covered >= cover->min);
    struct shortfall s = {{v->violation[k], bare ? 1 - covered : 0, fmax(excess_shear(v, row), 0)},
                          0};
    for (int id = QUANTITY_COUNT; id-- > 0;)
        s.value = v->study->request.objective[id] ? row->quantity[id] : s.value;
    return s;
}

static int compare_shortfalls(const struct shortfall *a, const struct shortfall *b) {
    for (int k = 0; k < 3; k++)
        if (a->part[k] != b->part[k])
            return a->part[k] < b->part[k] ? -1 : 1;
    return a->value != b->value ? (a->value < b->value ? -1 : 1) : 0;
}

/* What was tried of cuts, to no avail. */
static void describe_cuts(const struct verdict *v, char *text, size_t size) {
    size_t most = 0;
    for (size_t k = 0; k < v->count; k++)
        most = v->rows[k].variant.cut_count > most ? v->rows[k].variant.cut_count : most;
    (void)snprintf(text, size, "%zu nets with up to %zu cuts were tried, so divide the ply there",
                   v->count, most);
}

/* By the variant that leaves the least to be wished. Hands lay any of the samples, so of samples by
 * the worst. */
static void judge_rows(struct verdict *v) {
    const struct study_request *r = &v->study->request;
    const struct study_limit *limit = &r->limit[QUANTITY_MAX_SHEAR];
    struct api_verdict *verdict = &v->summary.verdict;
    struct shortfall chosen = {{0}, 0};
    int row = -1;
    for (size_t k = 0; k < v->count; k++) {
        if (!is_eligible(&v->rows[k]))
            continue;
        struct shortfall own = shortfall_of(v, k);
        int order = row < 0 ? -1 : compare_shortfalls(&own, &chosen);
        if (row < 0 || (r->sample > 0 ? order > 0 : order < 0)) {
            chosen = own;
            row = (int)k;
        }
    }
    *verdict = (struct api_verdict){.obstacle = VERDICT_FAILED, .variant = -1};
    (void)snprintf(verdict->detail, sizeof verdict->detail, "no variant could be draped");
    if (row < 0)
        return;
    char cuts[128];
    describe_cuts(v, cuts, sizeof cuts);
    const struct study_row *best = &v->rows[row];
    const struct verdict_case judged = {
        .bare = chosen.part[1] > 0,
        .coverage = best->quantity[QUANTITY_CLOTH_COVERAGE],
        .shear_deg = limit->has_max ? best->quantity[QUANTITY_MAX_SHEAR] : best->shear_deg,
        .limit_deg = limit->has_max ? limit->max : best->limit_deg,
        .placed = best->placed,
        .courses = r->courses.base != NULL,
        .at = best->at,
        .remedy = r->sample > 0     ? "that is the worst sample"
                  : r->courses.base ? "give more courses values of their own, or wider ranges"
                  : r->splits > 0   ? cuts
                  : r->search == STUDY_SEARCH_OPTIMISE && r->starts == STUDY_STARTS_GRID
                      ? "no variant does better, so cut the cloth there"
                      : "vary more starts and directions, or cut the cloth there"};
    verdict_judge(&judged, verdict);
    if (verdict->obstacle == VERDICT_DRAPABLE && chosen.part[0] > 0) {
        verdict->obstacle = VERDICT_LIMIT;
        const char *name = v->summary.hardest < 0 ? NULL : quantities[v->summary.hardest].name;
        (void)snprintf(verdict->detail, sizeof verdict->detail,
                       name ? "no variant keeps all limits; the hardest is that of %s"
                            : "the worst sample breaks a limit",
                       name);
    }
    verdict->variant = row;
}

/* ---- columns ---- */

struct column {
    const struct verdict *verdict;
    enum column_id id;
};

/* What the columns have of a variant, all of them numbers. */
static const struct {
    enum column_id id;
    size_t offset; /* in `struct study_variant` */
} variant_columns[] = {
    {COLUMN_VARIANTS_start_u, offsetof(struct study_variant, start.uv[0])},
    {COLUMN_VARIANTS_start_v, offsetof(struct study_variant, start.uv[1])},
    {COLUMN_VARIANTS_x, offsetof(struct study_variant, start.r.x)},
    {COLUMN_VARIANTS_y, offsetof(struct study_variant, start.r.y)},
    {COLUMN_VARIANTS_z, offsetof(struct study_variant, start.r.z)},
    {COLUMN_VARIANTS_angle_deg, offsetof(struct study_variant, angle_deg)},
    {COLUMN_VARIANTS_pre_shear_deg, offsetof(struct study_variant, pre_shear_deg)},
    {COLUMN_VARIANTS_coarseness, offsetof(struct study_variant, coarseness)}};
enum { VARIANT_COLUMNS = sizeof variant_columns / sizeof *variant_columns };

static bool fill_variants(const void *context, size_t first, size_t count, double *values) {
    const struct column *column = context;
    const struct verdict *v = column->verdict;
    const int32_t *numbers = v->study->part.shell.numbers;
    int own = 0;
    while (own < VARIANT_COLUMNS && variant_columns[own].id != column->id)
        own++;
    for (size_t n = 0; n < count; n++) {
        size_t k = first + n;
        const struct study_row *row = &v->rows[k];
        if (own < VARIANT_COLUMNS)
            values[n] =
                *(const double *)((const char *)&row->variant + variant_columns[own].offset);
        else if (column->id == COLUMN_VARIANTS_face)
            values[n] = numbers ? numbers[row->variant.start.face] : 0;
        else if (column->id == COLUMN_VARIANTS_feasible)
            values[n] = row->failure == FAILURE_NONE && !(v->violation[k] > 0);
        else if (column->id == COLUMN_VARIANTS_pareto)
            values[n] = v->pareto[k];
        else if (column->id == COLUMN_VARIANTS_failure)
            values[n] = row->failure;
        else
            values[n] = row->quantity[column->id - COLUMN_VARIANTS_max_shear_deg];
    }
    return true;
}

static enum api_problem_id write_study_columns(const struct verdict *v,
                                               const struct api_study_numbers *numbers,
                                               struct arena *arena, const struct api_sink *sink,
                                               struct api_problem *problem) {
    enum { FIRST = COLUMN_VARIANTS_start_u, LAST = COLUMN_VARIANTS_failure };
    struct column columns[LAST - FIRST + 1];
    struct api_column_source sources[API_COLUMNS_MAX];
    struct api_columns header = {.document = API_DOCUMENT_STUDY,
                                 .study = v->summary,
                                 .unit = v->study->request.drape.length_unit};
    size_t count = 0;
    for (int id = FIRST; id <= LAST; id++) {
        const struct column_spec *spec = &column_specs[id];
        bool judged = spec->need == COLUMN_JUDGED; /* a quantity */
        if ((spec->need == COLUMN_FACES && !v->study->part.geometry.shell) ||
            (judged && !study_judges(&v->study->request,
                                     (enum quantity_id)(id - COLUMN_VARIANTS_max_shear_deg))))
            continue;
        columns[count] = (struct column){v, (enum column_id)id};
        sources[count] = (struct api_column_source){.table = spec->table,
                                                    .name = spec->name,
                                                    .integer = column_kind_is_integer(spec->kind),
                                                    .rows = v->count,
                                                    .fill = fill_variants,
                                                    .context = &columns[count]};
        count++;
    }
    if (v->study->nominal) {
        size_t more = sample_bands(v->study, numbers, v->rows, v->count, arena, sources + count);
        if (more == SIZE_MAX)
            return api_problem_no_memory(problem, "the study");
        count += more;
    }
    if (v->study->request.splits > 0) {
        size_t more = cut_search_columns(v->rows, v->count, arena, sources + count);
        if (more == SIZE_MAX)
            return api_problem_no_memory(problem, "the study");
        count += more;
    }
    if (v->study->request.courses.base) {
        size_t more = course_search_columns(v->study, v->rows, v->count, arena, sources + count);
        if (more == SIZE_MAX)
            return api_problem_no_memory(problem, "the study");
        count += more;
    }
    return api_columns_write(&header, sources, count, sink, arena, problem);
}

enum api_problem_id api_study_finish(const struct api_study *study,
                                     const struct api_study_numbers *numbers, double solve_ms,
                                     struct arena *arena, const struct api_sink *sink,
                                     struct api_problem *problem) {
    struct arena_mark mark = arena_mark(arena);
    struct verdict v = {.study = study};
    if (study_rows(study, numbers, arena, &v.rows, &v.count, problem) == API_OK) {
        v.violation = arena_take(arena, v.count, sizeof *v.violation);
        v.pareto = arena_alloc(arena, v.count, sizeof *v.pareto);
        bool room = v.violation && v.pareto;
        for (size_t k = 0; room && k < v.count; k++)
            v.violation[k] = study_violation(study, &v.rows[k]);
        if (room && find_front(&v, arena)) {
            summarise_rows(&v, solve_ms);
            judge_rows(&v);
            (void)!write_study_columns(&v, numbers, arena, sink, problem);
        } else {
            api_problem_no_memory(problem, "the study");
        }
    }
    arena_rewind(arena, mark);
    return problem->id;
}

/* ---- the request of one variant ---- */

enum api_problem_id api_study_variant_request(const struct api_study *study,
                                              const struct api_reader *result, size_t k,
                                              struct arena *arena, const struct api_sink *sink,
                                              struct api_problem *problem) {
    struct api_columns columns;
    struct study_variant variant = {.coarseness = 1};
    struct api_request request = study->request.drape;
    double face = 0;
    if (api_columns_open(result, &columns, problem) != API_OK)
        return problem->id;
    size_t count = api_columns_rows(&columns, API_TABLE_VARIANTS);
    if (k >= count)
        return api_problem_set(problem, API_NOT_FOUND, "the study has %zu variants, counted from 0",
                               count);
    for (int n = 0; n <= VARIANT_COLUMNS; n++) { /* row k of the result */
        bool last = n == VARIANT_COLUMNS;
        enum column_id id = last ? COLUMN_VARIANTS_face : variant_columns[n].id;
        double *value = last ? &face : (double *)((char *)&variant + variant_columns[n].offset);
        const struct api_column *column =
            api_columns_find(&columns, API_TABLE_VARIANTS, column_specs[id].name);
        *value = 0;
        if (column && !api_columns_read(result, column, k, 1, value))
            return api_problem_set(problem, API_INTERNAL, "the stored result is damaged");
    }
    variant.start.face = (int32_t)face; /* by the number in the part */
    struct arena_mark mark = arena_mark(arena);
    if (study->request.splits > 0 &&
        !(cut_search_read(study, result, &columns, k, arena, &variant, problem) == API_OK &&
          cut_search_name(study, &variant, arena, &request, problem) == API_OK))
        return problem->id;
    request.settings = study_variant_settings(study, &variant);
    if (study->request.starts != STUDY_STARTS_KEPT)
        request.start_on_face = study->part.geometry.shell != NULL;
    else if (request.start_on_face)
        request.settings.start_face = study->part.shell.numbers[request.settings.start_face];
    const char *text =
        study->request.courses.base
            ? course_search_request(study, &request, result, &columns, k, arena, problem)
            : api_normalise(&request, NULL, arena);
    if (problem->id != API_OK)
        return problem->id;
    if (!text)
        api_problem_no_memory(problem, "the study");
    else if (!sink->write(sink->context, text, strlen(text)))
        api_problem_set(problem, API_CANCELLED, "the request is no longer wanted");
    arena_rewind(arena, mark);
    return problem->id;
}
