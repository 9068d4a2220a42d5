/* SPDX-License-Identifier: MIT */
/*
 * The search that refines. A first round looks everywhere: starts spread over the part with a few
 * angles each, which differ from start to start so that together they leave no gap. From the best
 * of what it found, apart from each other, local searches set out (`refine.c`), then once more from
 * the best of these; with several objectives one for each weight of a set that is spread over them.
 * On a fine net all this is done on a coarser one, and what came out best is draped as it is.
 */
#include "engine.h"

#include "refine.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of the budget what the first round has; angles at a start for each quarter turn, pre-shears;
 * checks on the drape's own net. */
static const double explored = 0.4;
enum { ANGLES_A_QUARTER = 4, PRE_SHEARS = 3, CHECKS = 8 };

/* The rounds of local searches with one objective: from how many of the best with which share of
 * the budget, by which steps to begin with and how far from each other, as shares of the distances
 * in the first round. The last has what is left. With several objectives there is the first of them
 * alone. Found by `make study-quality`. */
static const struct {
    size_t best;
    double share, step, apart;
} searches[] = {{12, 0.35, 0.7, 1}, {4, 0.1, 0.2, 0.5}, {1, 1, 0.05, 0}};
enum { SEARCHES = sizeof searches / sizeof *searches };

/* A net of more nodes than `nodes_fine` is searched on one of `nodes_coarse`. */
static const double nodes_fine = 1800, nodes_coarse = 900;

/* ---- what there is to search ---- */

/* Warp and weft may change places where nothing tells them apart, and either may be reversed where
 * nothing has a side. */
static double angle_period(const struct study_request *r) {
    const struct drape_settings *s = &r->drape.settings;
    bool sided = s->has_extent[0] || s->has_extent[1] ||
                 s->generator[0].kind != DRAPE_GENERATOR_GEODESIC ||
                 s->generator[1].kind != DRAPE_GENERATOR_GEODESIC;
    bool skew = s->pre_shear_deg != 0 || r->pre_shear.count > 0;
    bool alike = s->spacing[0] == s->spacing[1] && !skew && !(vec3_norm2(r->wanted) > 0) &&
                 r->drape.permeability.model != API_PERMEABILITY_KOZENY_CARMAN;
    return sided ? 360 : alike ? 90 : 180;
}

struct optimise_shares optimise_shares(const struct api_study *study) {
    const struct study_request *r = &study->request;
    struct optimise_shares shares = {.coarseness = 1, .each = 1};
    double nodes = study_nodes(study, 1), first = explored * (double)r->budget;
    double period = angle_period(r), range = r->angle.to - r->angle.from;
    if (nodes > nodes_fine)
        shares.coarseness = sqrt(nodes / nodes_coarse);
    if (r->angle.count > 0) {
        /* a range whose ends are a step apart round the period is all of it */
        shares.period = range + r->angle.step >= period * (1 - 1e-9) ? period : 0;
        double turn = shares.period > 0 ? shares.period : range;
        shares.each = (size_t)fmax(ceil(turn / 90 * ANGLES_A_QUARTER), 1);
    }
    if (r->pre_shear.count > 1)
        shares.each *= PRE_SHEARS;
    shares.starts = (size_t)fmax(first / (double)shares.each, 1);
    if (r->starts == STUDY_STARTS_POINTS && shares.starts > r->start_count)
        shares.starts = r->start_count;
    if (r->starts == STUDY_STARTS_KEPT)
        shares.starts = 1;
    size_t most =
        r->starts == STUDY_STARTS_GRID ? shares.each : (size_t)(first / (double)shares.starts);
    shares.each = most > 1 ? most : 1;
    return shares;
}

static double fraction(double x) {
    return x - floor(x);
}

/* Angles are in even steps from one that is another at each start, by the golden section;
 * pre-shears run through their range by the third part of a sequence like it. */
struct study_variant optimise_variant(const struct api_study *study, size_t k) {
    static const double golden = 0.6180339887498949, third = 0.3819660112501051;
    const struct study_request *r = &study->request;
    const struct optimise_shares shares = optimise_shares(study);
    size_t s = k / shares.each, turn = k % shares.each;
    double width = shares.period > 0 ? shares.period : r->angle.to - r->angle.from;
    double shift = fraction((double)(s + 1) * golden);
    struct study_variant variant = {.coarseness = shares.coarseness};
    variant.angle_deg = r->angle.from + width * ((double)turn + shift) / (double)shares.each;
    variant.pre_shear_deg = r->pre_shear.from + (r->pre_shear.to - r->pre_shear.from) *
                                                    fraction((double)(k + 1) * third);
    if (study->starts) {
        /* of a list that is longer than the round every so many */
        size_t at = s * study->start_count / shares.starts;
        variant.start = study->starts[at < study->start_count ? at : 0].place;
        variant.hopeless = study->starts[at < study->start_count ? at : 0].hopeless;
    }
    return variant;
}

static size_t first_round(const struct api_study *study) {
    const struct optimise_shares shares = optimise_shares(study);
    size_t starts =
        study->starts && study->start_count < shares.starts ? study->start_count : shares.starts;
    return starts * shares.each;
}

/* ---- choosing where to go on ---- */

/* How far apart the places of the first round are. */
struct scales {
    double start, angle, pre_shear; /* 0: not varied */
    double period;
};

static struct scales scales_of(const struct api_study *study) {
    const struct study_request *r = &study->request;
    const struct optimise_shares shares = optimise_shares(study);
    double width = shares.period > 0 ? shares.period : r->angle.to - r->angle.from;
    struct scales scales = {.period = shares.period};
    if (r->starts == STUDY_STARTS_GRID)
        scales.start = sqrt(study->shape.area / (double)shares.starts);
    if (r->angle.count > 0)
        scales.angle = width / fmax(fmin((double)shares.each, 8), 1);
    if (r->pre_shear.count > 0)
        scales.pre_shear = (r->pre_shear.to - r->pre_shear.from) / PRE_SHEARS;
    return scales;
}

/* Whether two variants are about the same: nearer to each other than those of the first round. */
static bool are_close(const struct scales *scales, const struct study_variant *a,
                      const struct study_variant *b) {
    double d[3] = {vec3_distance(a->start.r, b->start.r), fabs(a->angle_deg - b->angle_deg),
                   fabs(a->pre_shear_deg - b->pre_shear_deg)};
    const double by[3] = {scales->start, scales->angle, scales->pre_shear};
    double sum = 0;
    if (scales->period > 0) {
        d[1] -= scales->period * floor(d[1] / scales->period);
        d[1] = fmin(d[1], scales->period - d[1]);
    }
    if (!(by[0] > 0) && d[0] > 0)
        return false;
    for (int k = 0; k < 3; k++)
        sum += by[k] > 0 ? (d[k] / by[k]) * (d[k] / by[k]) : 0;
    return sum < 1;
}

/* Rows by how good they are for one aim. */
struct choice {
    double violation, value;
    size_t row;
};

static int compare_choices(const void *a, const void *b) {
    const struct choice *x = a, *y = b;
    if (x->violation != y->violation)
        return x->violation < y->violation ? -1 : 1;
    if (x->value != y->value)
        return x->value < y->value ? -1 : 1;
    return (x->row > y->row) - (x->row < y->row);
}

/* The best rows for an aim that are not close to each other, `most` of them; how many, or SIZE_MAX
 * without memory. */
static size_t choose(const struct api_study *study, const struct study_row *rows, size_t count,
                     const struct refine_aim *aim, double apart, size_t most, struct arena *arena,
                     size_t *chosen) {
    struct scales scales = scales_of(study);
    struct choice *choices = arena_take(arena, count, sizeof *choices);
    size_t tried = 0, found = 0;
    if (!choices)
        return SIZE_MAX;
    for (size_t k = 0; k < count; k++)
        if (rows[k].failure == FAILURE_NONE)
            choices[tried++] = (struct choice){study_violation(study, &rows[k]),
                                               refine_value(aim, rows[k].quantity), k};
    qsort(choices, tried, sizeof *choices, compare_choices);
    scales.start *= apart;
    scales.angle *= apart;
    scales.pre_shear *= apart;
    for (size_t k = 0; k < tried && found < most; k++) {
        const struct study_variant *variant = &rows[choices[k].row].variant;
        bool close = false;
        for (size_t f = 0; f < found && !close; f++)
            close = are_close(&scales, variant, &rows[chosen[f]].variant);
        if (!close)
            chosen[found++] = choices[k].row;
    }
    return found;
}

/* ---- aims ---- */

enum { AIMS_MOST = 16, WEIGHTS = 4 };

static size_t objectives_of(const struct study_request *r, int *ids) {
    size_t count = 0;
    for (int k = 0; k < QUANTITY_COUNT; k++)
        if (r->objective[k])
            ids[count++] = k;
    return count;
}

/* The least of each objective so far, and how far its values among the best of the others reach
 * beyond. */
static void find_ranges(const struct study_row *rows, size_t count, const int *ids,
                        size_t objectives, double *least, double *range) {
    for (size_t a = 0; a < objectives; a++) {
        least[a] = HUGE_VAL;
        range[a] = 0;
        for (size_t k = 0; k < count; k++)
            if (rows[k].failure == FAILURE_NONE)
                least[a] = fmin(least[a], rows[k].quantity[ids[a]]);
    }
    for (size_t b = 0; b < objectives; b++) {
        size_t best = SIZE_MAX;
        for (size_t k = 0; k < count; k++)
            if (rows[k].failure == FAILURE_NONE &&
                (best == SIZE_MAX || rows[k].quantity[ids[b]] < rows[best].quantity[ids[b]]))
                best = k;
        for (size_t a = 0; a < objectives && best != SIZE_MAX; a++)
            range[a] = fmax(range[a], rows[best].quantity[ids[a]] - least[a]);
    }
}

/* One objective alone, each of several alone, and all pairs of them with weights in between: the
 * greatest of w (q - least) / range is to be small. */
static size_t set_aims(const struct study_request *r, const struct study_row *rows, size_t count,
                       struct refine_aim aims[AIMS_MOST]) {
    int ids[QUANTITY_COUNT];
    double least[QUANTITY_COUNT], range[QUANTITY_COUNT];
    size_t objectives = objectives_of(r, ids), made = 0;
    find_ranges(rows, count, ids, objectives, least, range);
    for (size_t a = 0; a < objectives; a++) {
        aims[made] = (struct refine_aim){0};
        aims[made++].factor[ids[a]] = 1;
    }
    for (int w = 1; w <= WEIGHTS; w++) {
        for (size_t a = 0; a < objectives; a++) {
            for (size_t b = a + 1; b < objectives && made < AIMS_MOST; b++) {
                double share = w / (WEIGHTS + 1.0);
                const double weight[2] = {share, 1 - share};
                const size_t pair[2] = {a, b};
                aims[made] = (struct refine_aim){0};
                for (int k = 0; k < 2; k++) {
                    double by = range[pair[k]] > 0 ? weight[k] / range[pair[k]] : weight[k];
                    aims[made].factor[ids[pair[k]]] = by;
                    aims[made].shift[ids[pair[k]]] = -by * least[pair[k]];
                }
                made++;
            }
        }
    }
    return made;
}

/* ---- rounds ---- */

/* Steps to begin with, as shares of the first round's. */
static struct refine_order order_of(const struct api_study *study, const struct study_row *row,
                                    const struct refine_aim *aim, size_t variants, double step) {
    const struct scales scales = scales_of(study);
    return (struct refine_order){
        .from = row->variant,
        .aim = *aim,
        .variants = variants,
        .step = {step * scales.start, step * scales.angle, step * scales.pre_shear},
        .period = scales.period};
}

static enum api_problem_id no_memory(struct api_problem *problem) {
    api_problem_set(problem, API_OUT_OF_MEMORY, "the study needs more memory than allowed");
    return problem->id;
}

/* Local searches from the best of each aim, in round 1 and those after it. */
static enum api_problem_id plan_refine(const struct api_study *study, const struct study_row *rows,
                                       size_t count, int round, struct arena *arena,
                                       struct api_study_plan *plan, struct api_problem *problem) {
    struct refine_aim aims[AIMS_MOST];
    size_t aim_count = set_aims(&study->request, rows, count, aims);
    size_t each = aim_count > 1 ? 1 : searches[round - 1].best;
    size_t budget = study->request.budget, left = budget > count ? budget - count : 0;
    size_t checks = optimise_shares(study).coarseness > 1 ? CHECKS : 0;
    left = left > checks ? left - checks : 0;
    if (aim_count == 1)
        left = (size_t)fmin(searches[round - 1].share * (double)budget, (double)left);
    struct api_study_task *list = arena_alloc(arena, each * aim_count, sizeof *list);
    size_t *chosen = arena_take(arena, each * aim_count, sizeof *chosen), found = 0;
    size_t *aim_of = arena_take(arena, each * aim_count, sizeof *aim_of);
    if (!list || !chosen || !aim_of)
        return no_memory(problem);
    for (size_t a = 0; a < aim_count; a++) {
        size_t more = choose(study, rows, count, &aims[a], searches[round - 1].apart, each, arena,
                             chosen + found);
        if (more == SIZE_MAX)
            return no_memory(problem);
        for (size_t k = 0; k < more; k++)
            aim_of[found + k] = a;
        found += more;
    }
    size_t own = found ? left / found : 0;
    for (size_t k = 0; k < found && own > 2; k++) {
        struct refine_order order =
            order_of(study, &rows[chosen[k]], &aims[aim_of[k]], own, searches[round - 1].step);
        refine_store(&order, &list[k]);
        list[k].STUDY_TASK_ROUND = round;
        plan->count = k + 1;
    }
    plan->tasks = list;
    return API_OK;
}

/* The best of each aim on the drape's own net. */
static enum api_problem_id plan_checks(const struct api_study *study, const struct study_row *rows,
                                       size_t count, int round, struct arena *arena,
                                       struct api_study_plan *plan, struct api_problem *problem) {
    struct refine_aim aims[AIMS_MOST];
    size_t aim_count = set_aims(&study->request, rows, count, aims);
    size_t each = aim_count < CHECKS ? CHECKS / aim_count : 1, chosen[CHECKS];
    struct api_study_task *list = arena_alloc(arena, each * aim_count, sizeof *list);
    if (!list)
        return no_memory(problem);
    plan->tasks = list;
    for (size_t a = 0; a < aim_count; a++) {
        size_t found = choose(study, rows, count, &aims[a], 0.02, each, arena, chosen);
        if (found == SIZE_MAX)
            return no_memory(problem);
        for (size_t k = 0; k < found; k++) {
            struct refine_order order = order_of(study, &rows[chosen[k]], &aims[a], 1, 0);
            order.from.coarseness = 1;
            refine_store(&order, &list[plan->count]);
            list[plan->count].STUDY_TASK_WORK = STUDY_WORK_CHECK;
            list[plan->count++].STUDY_TASK_ROUND = round;
        }
    }
    return API_OK;
}

enum api_problem_id optimise_plan(const struct api_study *study, const struct study_row *rows,
                                  size_t count, struct arena *arena, struct api_study_plan *plan,
                                  struct api_problem *problem) {
    int ids[QUANTITY_COUNT], round = count ? rows[count - 1].round + 1 : 0;
    bool coarse = optimise_shares(study).coarseness > 1;
    int refinements = objectives_of(&study->request, ids) > 1 ? 1 : SEARCHES;
    plan->variants = study->request.budget > count ? study->request.budget : count;
    if (round == 0)
        return grid_tasks(STUDY_WORK_GRID, first_round(study),
                          study_nodes(study, optimise_shares(study).coarseness), arena, plan,
                          problem);
    while (round <= refinements) {
        if (plan_refine(study, rows, count, round, arena, plan, problem) != API_OK || plan->count)
            return problem->id;
        round++;
    }
    if (coarse && rows[count - 1].variant.coarseness > 1)
        return plan_checks(study, rows, count, round, arena, plan, problem);
    return API_OK;
}

bool check_chunk(struct study_chunk *chunk) {
    struct refine_order order;
    struct study_row row;
    refine_load(chunk->task, &order);
    return study_chunk_drape(chunk, &order.from, &row);
}
