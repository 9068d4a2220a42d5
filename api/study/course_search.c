/* SPDX-License-Identifier: MIT */
#include "course_search.h"

#include "score.h"
#include "seeded.h"

#include "api/laminate/course_limits.h"
#include "api/laminate/courses.h"
#include "api/result/fields.h"
#include "api/result/verdict.h"
#include "solver/power.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Strategies; candidates of a generation, the best of which it learns from; nets of the search; and
 * how many are laid at the end as they are asked for. */
enum { SEARCHES = 2, SAMPLES = 10, PARENTS = 5, GENERATION = SEARCHES * SAMPLES, FINALISTS = 6 };
enum { NETS = 2 };

/* Of each net its part of the generations, and the first step in shares of the ranges. */
static const double part_of_budget[NETS] = {0.7, 0.3}, first_step[NETS] = {0.15, 0.05};

/* The coarsest net: so many times the spacing, if a course is so many cells wide. */
static const double coarsest = 4, cells_across = 6;

/* A net whose spacing is d leaves so much of a part bare at the ends of courses of the width w that
 * is not, times (d / w)^4; as measured on the blade of `tests/validation`. */
static const double net_lacks = 4;

/* What limits are missed by, as a share of a range, counts so many times as much as the aim. */
static const double limit_weight = 10;

typedef double unknown_list[API_STUDY_UNKNOWNS];

/* ---- the strategy ---- */

struct candidate {
    unknown_list y; /* a place of the unit cube, which is mirrored at its faces */
    double cost;
};

struct strategy {
    unknown_list mean, variance, path, walk;
    double weight[PARENTS], mu, sigma;
    size_t count; /* of unknowns */
};

static void strategy_begin(struct strategy *s, size_t count, const double *mean, double step) {
    double sum = 0, sum2 = 0;
    *s = (struct strategy){.sigma = step, .count = count};
    memcpy(s->mean, mean, count * sizeof *mean);
    for (size_t k = 0; k < count; k++)
        s->variance[k] = 1;
    for (int k = 0; k < PARENTS; k++)
        sum += s->weight[k] = power_log(PARENTS + 0.5) - power_log(k + 1.0);
    for (int k = 0; k < PARENTS; k++) {
        s->weight[k] /= sum;
        sum2 += s->weight[k] * s->weight[k];
    }
    s->mu = 1 / sum2;
}

/* By candidates, the best ones first. */
static void strategy_learn(struct strategy *s, const struct candidate *candidates) {
    const double n = (double)s->count, mu = s->mu, wide = n + sqrt(2);
    const double cs = (mu + 2) / (n + mu + 3), cc = 4 / (n + 4);
    const double expected = sqrt(n) * (1 - 1 / (4 * n) + 1 / (21 * n * n));
    double rate =
        2 / (mu * wide * wide) + (1 - 1 / mu) * fmin(1, (2 * mu - 1) / ((n + 2) * (n + 2) + mu));
    double length2 = 0;
    rate = fmin(rate * (n + 2) / 3, 1);
    for (size_t k = 0; k < s->count; k++) {
        double next = 0, spread = 0;
        for (int c = 0; c < PARENTS; c++) {
            double away = (candidates[c].y[k] - s->mean[k]) / s->sigma;
            next += s->weight[c] * candidates[c].y[k];
            spread += s->weight[c] * away * away;
        }
        double step = (next - s->mean[k]) / s->sigma;
        s->walk[k] = (1 - cs) * s->walk[k] + sqrt(cs * (2 - cs) * mu) * step / sqrt(s->variance[k]);
        s->path[k] = (1 - cc) * s->path[k] + sqrt(cc * (2 - cc) * mu) * step;
        s->variance[k] = (1 - rate) * s->variance[k] + rate / mu * s->path[k] * s->path[k] +
                         rate * (1 - 1 / mu) * spread;
        s->mean[k] = next;
        length2 += s->walk[k] * s->walk[k];
    }
    s->sigma *= power_exp(cs / (1 + cs) * (sqrt(length2) / expected - 1));
}

/* Candidate c of generation g: the first of each net is where the strategy begins. */
static void strategy_draw(const struct strategy *s, uint32_t seed, size_t generation, size_t c,
                          bool begins, struct candidate *candidate) {
    size_t draw = (generation * SAMPLES + c) * API_STUDY_UNKNOWNS;
    for (size_t k = 0; k < s->count; k++) {
        double by = begins && c == 0 ? 0 : seeded_bell(seed, draw + k, 0);
        candidate->y[k] = s->mean[k] + s->sigma * sqrt(s->variance[k]) * by;
    }
}

static int compare_candidates(const void *a, const void *b) {
    const struct candidate *p = a, *q = b;
    if (p->cost != q->cost)
        return p->cost < q->cost ? -1 : 1;
    return memcmp(p->y, q->y, sizeof p->y); /* the same order on every machine */
}

/* ---- what is searched ---- */

/* The unknowns of a place of the unit cube. */
static void to_unknowns(const struct study_courses *courses, const double *y, size_t count,
                        double *unknowns) {
    for (size_t k = 0; k < count; k++) {
        struct study_span span = course_plan_span(courses, k);
        double t = fabs(fmod(y[k], 2));
        unknowns[k] = span.from + (t > 1 ? 2 - t : t) * (span.to - span.from);
    }
}

static double narrowest(const struct study_courses *c) {
    const struct courses_settings *lay = &c->base->lay;
    const double *widths = c->widths ? c->widths : lay->widths;
    size_t count = c->widths ? c->width_count : lay->width_count;
    double least = HUGE_VAL;
    for (size_t k = 0; k < count; k++)
        least = fmin(least, widths[k]);
    return c->width.points && !c->widths ? c->width.from : least;
}

static double coarseness_of(const struct api_study *study, int net) {
    double width = narrowest(&study->request.courses);
    double most = width / (cells_across * study->request.drape.settings.spacing[0]);
    most = fmin(fmax(most, 1), coarsest);
    return net == 0 ? most : sqrt(most);
}

/* What is to be small: the aim as a share of its range, and what limits are missed by beyond what
 * its net lacks, unless `strict`. */
static double cost_of_courses(const struct api_study *study, const struct study_row *row,
                              bool strict) {
    const struct study_request *r = &study->request;
    double spacing = r->drape.settings.spacing[0] * row->variant.coarseness, cost = 0;
    double cells = spacing / narrowest(&r->courses),
           lacks = strict ? 0 : net_lacks * (cells * cells) * (cells * cells);
    struct study_row mended = *row;
    if (row->failure != FAILURE_NONE)
        return HUGE_VAL;
    for (int k = 0; k < QUANTITY_COUNT; k++)
        if (r->objective[k])
            cost += row->quantity[k] / study_range(study, (enum quantity_id)k, row->quantity[k]);
    mended.quantity[QUANTITY_CLOTH_COVERAGE] += lacks;
    mended.quantity[QUANTITY_LAID_COVERAGE] += lacks;
    mended.quantity[QUANTITY_UNCOVERED_AREA] -= lacks * study->part.area;
    return cost + limit_weight * study_violation(study, &mended);
}

/* A search done again from its rows, as far as they go. */
struct course_search {
    const struct api_study *study;
    size_t unknowns;
    const struct study_row *rows;
    size_t count, used; /* rows, and those that were taken */
    struct strategy strategy[SEARCHES];
    struct candidate best[SEARCHES];         /* of the net */
    struct candidate candidates[GENERATION]; /* of the next round */
};

static bool draw_generation(struct course_search *s, size_t generation, bool begins) {
    for (size_t k = 0; k < GENERATION; k++)
        strategy_draw(&s->strategy[k / SAMPLES], (uint32_t)(k / SAMPLES), generation, k % SAMPLES,
                      begins, &s->candidates[k]);
    return s->count - s->used >= GENERATION;
}

static void take_generation(struct course_search *s) {
    for (size_t w = 0; w < SEARCHES; w++) {
        struct candidate *own = s->candidates + w * SAMPLES;
        for (size_t c = 0; c < SAMPLES; c++)
            own[c].cost = cost_of_courses(s->study, &s->rows[s->used++], false);
        qsort(own, SAMPLES, sizeof *own, compare_candidates);
        if (own[0].cost < s->best[w].cost)
            s->best[w] = own[0];
        strategy_learn(&s->strategy[w], own);
    }
}

/* A task for the courses of one variant. */
static struct api_study_task make_task(const struct course_search *s, const double *unknowns,
                                       int round, double coarseness) {
    struct api_study_task task = {.kind = STUDY_TASK_COURSES,
                                  .variants = 1,
                                  .round = round,
                                  .first = (int64_t)s->unknowns,
                                  .coarseness = coarseness};
    memcpy(task.courses, unknowns, s->unknowns * sizeof *unknowns);
    return task;
}

/* The best rows of the last net: in turn of those that keep limits for certain, and of those that
 * may keep them on a closer one. */
static size_t choose_finalists(const struct course_search *s, size_t first, const double **chosen) {
    size_t made = 0;
    for (bool more = true; more && made < FINALISTS;) {
        const struct study_row *best = NULL;
        double least = HUGE_VAL;
        for (size_t k = first; k < s->used; k++) {
            double cost = cost_of_courses(s->study, &s->rows[k], made % 2 == 0);
            bool known = false;
            for (size_t n = 0; n < made && cost < least; n++)
                known = known || memcmp(chosen[n], s->rows[k].variant.unknowns,
                                        s->unknowns * sizeof **chosen) == 0;
            if (known || !(cost < least))
                continue;
            least = cost;
            best = &s->rows[k];
        }
        more = best != NULL;
        if (more)
            chosen[made++] = best->variant.unknowns;
    }
    return made;
}

/* The generations of each net. */
static void share_budget(const struct api_study *study, size_t generations[NETS]) {
    size_t all = (study->request.budget - 1 - FINALISTS) / GENERATION;
    generations[0] = (size_t)(part_of_budget[0] * (double)all + 0.5);
    generations[1] = all - generations[0];
}

/* The tasks of the next round; none at the end. */
static size_t next_round(struct course_search *s, struct api_study_task *tasks) {
    const struct study_courses *courses = &s->study->request.courses;
    size_t generations[NETS], first = 0, total = 0, made = 0;
    unknown_list unknowns;
    course_plan_begin(courses, unknowns);
    for (size_t w = 0; w < SEARCHES; w++)
        for (size_t k = 0; k < s->unknowns; k++) {
            struct study_span span = course_plan_span(courses, k);
            double width = span.to - span.from;
            s->best[w].y[k] = width > 0 ? (unknowns[k] - span.from) / width : 0;
        }
    share_budget(s->study, generations);
    if (s->count == 0)
        tasks[made++] = make_task(s, unknowns, 0, 1);
    s->used = s->count > 0;
    for (int net = 0; net < NETS; net++) {
        first = s->used;
        for (size_t w = 0; w < SEARCHES; w++) {
            strategy_begin(&s->strategy[w], s->unknowns, s->best[w].y, first_step[net]);
            s->best[w].cost = HUGE_VAL;
        }
        for (size_t g = 0; g < generations[net]; g++, total++) {
            if (draw_generation(s, total, g == 0)) {
                take_generation(s);
                continue;
            }
            for (size_t k = 0; k < GENERATION; k++) {
                to_unknowns(courses, s->candidates[k].y, s->unknowns, unknowns);
                tasks[made++] = make_task(s, unknowns, (int)total, coarseness_of(s->study, net));
            }
            return made;
        }
    }
    const double *chosen[FINALISTS];
    if (s->count > s->used || !(coarseness_of(s->study, NETS - 1) > 1))
        return 0;
    size_t count = choose_finalists(s, first, chosen);
    for (; made < count; made++)
        tasks[made] = make_task(s, chosen[made], (int)total, 1);
    return made;
}

enum api_problem_id course_search_plan(const struct api_study *study, const struct study_row *rows,
                                       size_t count, struct arena *arena,
                                       struct api_study_plan *plan, struct api_problem *problem) {
    struct arena_mark mark = arena_mark(arena);
    struct api_study_task *tasks = arena_alloc(arena, GENERATION + 1, sizeof *tasks);
    struct course_search *s = arena_alloc(arena, 1, sizeof *s);
    if (!tasks || !s) {
        arena_rewind(arena, mark);
        return api_problem_no_memory(problem, "the study");
    }
    s->study = study;
    s->unknowns = course_plan_unknowns(&study->request.courses);
    s->rows = rows;
    s->count = count;
    plan->tasks = tasks;
    plan->count = next_round(s, tasks);
    plan->variants = plan->count ? study->request.budget : count;
    return API_OK;
}

/* ---- one variant ---- */

enum status course_search_lay(const struct api_study *study, const struct drape_monitor *monitor,
                              struct arena *arena, struct study_row *row) {
    const struct study_request *r = &study->request;
    struct course_plan *plan = arena_alloc(arena, 1, sizeof *plan);
    struct courses_result laid;
    double limit_deg[2], *q = row->quantity, area = study->part.area;
    if (!plan)
        return STATUS_OUT_OF_MEMORY;
    course_plan_make(&r->courses, row->variant.unknowns, plan);
    struct drape_settings drape = study_variant_settings(study, &row->variant);
    course_limits_settle(&plan->lay, &drape, &plan->lay);
    plan->lay.exponent = r->exponent;
    plan->lay.rough = row->variant.coarseness > 1;
    enum status status = courses_lay(&study->part.geometry, &plan->lay, monitor, arena, &laid);
    if (status != STATUS_OK)
        return status;
    if (!(laid.net_area > 0))
        return STATUS_START_STUCK;
    const struct drape_result *first = &laid.courses[0].net;
    drape.direction_kind = DRAPE_DIRECTION_VECTOR; /* so that the angle is measured */
    row->variant.start = study_start_of(first);
    study_note_direction(study, &drape, first, &row->variant);
    verdict_shear_limits(&r->drape, limit_deg);
    q[QUANTITY_MAX_SHEAR] = row->shear_deg = laid.max_shear_deg;
    q[QUANTITY_MEAN_SHEAR] = laid.mean_shear_deg;
    q[QUANTITY_CLOTH_COVERAGE] = fmin(laid.cloth_coverage, 1);
    q[QUANTITY_UNCOVERED_AREA] = area * (1 - q[QUANTITY_CLOTH_COVERAGE]);
    q[QUANTITY_LAID_COVERAGE] = fmin(laid.cloth_coverage + laid.gap_area / area, 1);
    q[QUANTITY_WASTE_AREA] = laid.trim_area;
    q[QUANTITY_GAP_WIDTH] = laid.gap_most;
    if (vec3_norm2(r->wanted) > 0) {
        q[QUANTITY_ANGLE_DEVIATION] = laid.wanted_deg;
        q[QUANTITY_ANGLE_DEVIATION_MAX] = laid.wanted_most_deg;
    }
    row->limit_deg = fmin(limit_deg[0], limit_deg[1]);
    row->bare = q[QUANTITY_LAID_COVERAGE] < DRAPE_COMPLETE_COVERAGE;
    return STATUS_OK;
}

/* ---- the table `courses` ---- */

/* Its columns: the variant, the number of the course and of the value from 1, the value, and what
 * else the course has. */
enum { VARIANT, COURSE, POINT, DISTANCE, WIDTH, ORIGIN, COLUMNS };

/* The distances of course n of a plan: from the line, or from the course before. */
static struct courses_offset distances_of(const struct course_plan *plan, size_t n) {
    static const double none = 0;
    struct courses_offset own = n == 0 ? plan->lay.first : plan->lay.gaps[n - 1];
    return own.count ? own : (struct courses_offset){&none, 1};
}

/* A course behind the first is listed even where all are alike: it has the gap. */
static size_t listed_courses(const struct course_plan *plan) {
    return plan->count > 1 ? plan->count : 2;
}

size_t course_search_columns(const struct api_study *study, const struct study_row *rows,
                             size_t count, struct arena *arena, struct api_column_source *sources) {
    struct course_plan *plan = arena_alloc(arena, 1, sizeof *plan);
    size_t all = 0;
    double *values[COLUMNS];
    if (!plan)
        return SIZE_MAX;
    for (size_t k = 0; k < count; k++) {
        course_plan_make(&study->request.courses, rows[k].variant.unknowns, plan);
        for (size_t n = 0; n < listed_courses(plan); n++)
            all += distances_of(plan, n).count;
    }
    if (!api_fields_columns(COLUMN_COURSES_variant, COLUMNS, all, arena, values, sources))
        return SIZE_MAX;
    for (size_t k = 0, row = 0; k < count; k++) {
        course_plan_make(&study->request.courses, rows[k].variant.unknowns, plan);
        for (size_t n = 0; n < listed_courses(plan); n++) {
            struct courses_offset own = distances_of(plan, n);
            size_t at = n < plan->count ? n : plan->count - 1;
            for (size_t p = 0; p < own.count; p++, row++) {
                const double line[COLUMNS] = {
                    [VARIANT] = (double)k,     [COURSE] = (double)(n + 1),
                    [POINT] = (double)(p + 1), [DISTANCE] = own.values[p],
                    [WIDTH] = plan->width[at], [ORIGIN] = plan->origin[at]};
                for (int c = 0; c < COLUMNS; c++)
                    values[c][row] = line[c];
            }
        }
    }
    return COLUMNS;
}

/* Puts a row of the table into a plan; false where it is none of a study. */
static bool take_plan_line(const double line[COLUMNS], struct course_plan *plan) {
    size_t n = (size_t)line[COURSE] - 1, p = (size_t)line[POINT] - 1;
    if (!(line[COURSE] >= 1 && n < STUDY_COURSES_MAX && line[POINT] >= 1 && p < COURSES_VALUES_MAX))
        return false;
    (n == 0 ? plan->first : plan->gap[n - 1])[p] = line[DISTANCE];
    if (n == 0)
        plan->lay.first = (struct courses_offset){plan->first, p + 1};
    else
        plan->gaps[n - 1] = (struct courses_offset){plan->gap[n - 1], p + 1};
    plan->lay.gap_count = n;
    plan->width[n] = line[WIDTH];
    plan->origin[n] = line[ORIGIN];
    plan->count = n + 1;
    return true;
}

const char *course_search_request(const struct api_study *study, const struct api_request *drape,
                                  const struct api_reader *result,
                                  const struct api_columns *columns, size_t k, struct arena *arena,
                                  struct api_problem *problem) {
    const struct study_request *r = &study->request;
    size_t rows = api_columns_rows(columns, API_TABLE_COURSES);
    struct course_plan *plan = arena_alloc(arena, 1, sizeof *plan);
    const char *text = NULL;
    if (!plan) {
        api_problem_no_memory(problem, "the study");
        return NULL;
    }
    plan->lay = r->courses.base->lay;
    plan->lay.wanted = r->wanted;
    for (size_t row = 0; row < rows; row++) {
        double line[COLUMNS];
        if (!api_fields_read_row(result, columns, COLUMN_COURSES_variant, COLUMNS, row, line) ||
            (line[VARIANT] == (double)k && !take_plan_line(line, plan))) {
            api_problem_set(problem, API_INTERNAL, "the stored result is damaged");
            return NULL;
        }
    }
    plan->lay.gaps = plan->gaps;
    plan->lay.widths = plan->width;
    plan->lay.origins = plan->origin;
    plan->lay.width_count = plan->lay.origin_count = plan->count;
    text = courses_document(drape, &plan->lay, arena);
    if (!text)
        api_problem_no_memory(problem, "the study");
    return text;
}
