/* SPDX-License-Identifier: MIT */
/*
 * The search that learns. A first round looks everywhere: starts spread over the part with a few
 * angles each, which differ from start to start so that together they leave no gap. From all that
 * is known the next rounds are proposed (`surrogate_search.c`), ever nearer to the best. On a fine
 * net all this is done on a coarser one, and what came out best is draped as it is.
 */
#include "rounds.h"

#include "surrogate_search.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Of the budget what the first round has, and how many rounds follow; angles at a start for each
 * quarter turn, pre-shears; checks on the drape's own net. Found by `make study-quality`. */
static const double explored = 0.5;
enum { ROUNDS = 16, ANGLES_A_QUARTER = 3, PRE_SHEARS = 3, CHECKS = 8 };

/* A net of more nodes than `nodes_fine` is searched on one of `nodes_coarse`. */
static const double nodes_fine = 1800, nodes_coarse = 900;

/* Variants that differ by less, as a share of `study_range`, are as good: 0.009 degrees. */
static const double as_good = 1e-4;

/* ---- what there is to search ---- */

struct optimise_shares optimise_shares(const struct api_study *study) {
    const struct study_request *r = &study->request;
    const struct drape_settings *s = &r->drape.settings;
    struct optimise_shares shares = {.coarseness = 1, .each = 1};
    double nodes = study_nodes(study, 1), first = explored * (double)r->budget;
    double range = r->angle.to - r->angle.from;
    /* Warp and weft may change places where nothing tells them apart, and either may be reversed
     * where nothing has a side. */
    bool sided = s->has_extent[0] || s->has_extent[1] ||
                 s->generator[0].kind != DRAPE_GENERATOR_GEODESIC ||
                 s->generator[1].kind != DRAPE_GENERATOR_GEODESIC;
    bool skew = s->pre_shear_deg != 0 || r->pre_shear.count > 0;
    bool alike = s->spacing[0] == s->spacing[1] && !skew && !(vec3_norm2(r->wanted) > 0) &&
                 r->drape.permeability.model != API_PERMEABILITY_KOZENY_CARMAN;
    double period = sided ? 360 : alike ? 90 : 180;
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

static double fractional_part(double x) {
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
    double shift = fractional_part((double)(s + 1) * golden);
    struct study_variant variant = {.coarseness = shares.coarseness};
    variant.angle_deg = r->angle.from + width * ((double)turn + shift) / (double)shares.each;
    variant.pre_shear_deg = r->pre_shear.from + (r->pre_shear.to - r->pre_shear.from) *
                                                    fractional_part((double)(k + 1) * third);
    if (study->starts) {
        /* of a list that is longer than the round every so many */
        size_t at = s * study->start_count / shares.starts;
        const struct study_start *start = &study->starts[at < study->start_count ? at : 0];
        variant.start = start->point;
        variant.failure = start->failure;
    }
    return variant;
}

/* ---- aims ---- */

enum { WEIGHTS = 4 };

/* One objective alone, each of several alone, and all pairs of them with weights in between: the
 * greatest of w (q - least) / range is to be small. */
static size_t set_aims(const struct study_request *r, const struct study_row *rows, size_t count,
                       struct search_aim aims[SEARCH_AIMS_MOST]) {
    int ids[QUANTITY_COUNT];
    double least[QUANTITY_COUNT], range[QUANTITY_COUNT];
    size_t objectives = 0, made = 0;
    for (int k = 0; k < QUANTITY_COUNT; k++)
        if (r->objective[k])
            ids[objectives++] = k;
    /* The least of each objective so far, and how far its values among the best of the others reach
     * beyond. */
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
    for (size_t a = 0; a < objectives; a++) {
        aims[made] = (struct search_aim){0};
        aims[made++].factor[ids[a]] = 1;
    }
    for (int w = 1; w <= WEIGHTS; w++) {
        for (size_t a = 0; a < objectives; a++) {
            for (size_t b = a + 1; b < objectives && made < SEARCH_AIMS_MOST; b++) {
                double share = w / (WEIGHTS + 1.0);
                const double weight[2] = {share, 1 - share};
                const size_t pair[2] = {a, b};
                aims[made] = (struct search_aim){0};
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

/* Whether all that was looked at, everywhere, keeps the limits and is as good: on a plane, or where
 * no yarn is sheared. Then there is nothing to find. */
static bool all_as_good(const struct api_study *study, const struct study_row *rows, size_t count) {
    bool alike = true;
    for (size_t k = 0; k < count; k++)
        alike = alike && !(study_violation(study, &rows[k]) > 0);
    for (int id = 0; alike && id < QUANTITY_COUNT; id++) {
        double least = HUGE_VAL, most = -HUGE_VAL;
        for (size_t k = 0; k < count; k++) {
            least = fmin(least, rows[k].quantity[id]);
            most = fmax(most, rows[k].quantity[id]);
        }
        alike = !study->request.objective[id] ||
                most - least <= as_good * study_range(study, (enum quantity_id)id, most);
    }
    return alike;
}

/* The best of each aim on the drape's own net. */
static size_t choose_checks(const struct surrogate_search *search, struct arena *arena,
                            struct study_variant *variants) {
    size_t each = search->aim_count < CHECKS ? CHECKS / search->aim_count : 1, count = 0;
    size_t *order = arena_take(arena, search->count, sizeof *order);
    for (size_t a = 0; a < search->aim_count; a++) {
        size_t rows =
            order ? surrogate_search_order(search, &search->aims[a], arena, order) : SIZE_MAX;
        if (rows == SIZE_MAX)
            return SIZE_MAX;
        for (size_t k = 0, own = 0; k < rows && own < each; k++) {
            struct study_variant variant = search->rows[order[k]].variant;
            bool there = false;
            variant.coarseness = 1;
            for (size_t c = 0; c < count && !there; c++) /* for the model they are the same */
                there = vec3_distance(variant.start.r, variants[c].start.r) == 0 &&
                        variant.angle_deg == variants[c].angle_deg &&
                        variant.pre_shear_deg == variants[c].pre_shear_deg;
            if (there)
                continue;
            variants[count++] = variant;
            own++;
        }
    }
    return count;
}

enum api_problem_id optimise_plan(const struct api_study *study, const struct study_row *rows,
                                  size_t count, struct arena *arena, struct api_study_plan *plan,
                                  struct api_problem *problem) {
    const struct optimise_shares shares = optimise_shares(study);
    struct search_aim aims[SEARCH_AIMS_MOST];
    struct surrogate_search search = {study, shares.period, rows, count, aims, 0, 0};
    size_t budget = study->request.budget, left = budget > count ? budget - count : 0;
    int round = count ? rows[count - 1].round + 1 : 0;
    plan->variants = budget > count ? budget : count;
    if (round == 0) {
        bool few = study->starts && study->start_count < shares.starts;
        size_t starts = few ? study->start_count : shares.starts;
        const struct task_range first = {.kind = STUDY_TASK_OPTIMISE,
                                         .end = starts * shares.each,
                                         .nodes = study_cost(study, shares.coarseness)};
        return task_make_range(&first, arena, plan, problem);
    }
    search.aim_count = set_aims(&study->request, rows, count, aims);
    search.progress = (double)count / (double)budget;
    /* of nets that are coarser than the drape's, as many of each aim */
    size_t checks =
        search.aim_count < CHECKS ? CHECKS / search.aim_count * search.aim_count : search.aim_count;
    checks = shares.coarseness > 1 ? checks : 0;
    size_t wanted = 0;
    left = left > checks ? left - checks : 0;
    if (round <= ROUNDS && !all_as_good(study, rows, count))
        wanted = (left + (size_t)(ROUNDS - round)) / (size_t)(ROUNDS - round + 1);
    struct study_variant *variants = arena_take(arena, wanted + checks, sizeof *variants);
    size_t found = 0;
    if (!variants ||
        (wanted && surrogate_search_next(&search, wanted, arena, variants, &found) != STATUS_OK))
        return api_problem_no_memory(problem, "the study");
    if (found == 0 && checks && rows[count - 1].variant.coarseness > 1)
        found = choose_checks(&search, arena, variants);
    if (found == SIZE_MAX)
        return api_problem_no_memory(problem, "the study");
    if (found == 0)
        plan->variants = count;
    return task_make_list(study, variants, found, round, arena, plan, problem);
}
