/* SPDX-License-Identifier: MIT */
/*
 * The search that learns. It begins with the variants that an engineer would try first
 * (`obvious.c`). Then it goes on in epochs, each at least as long as all before. Half of an epoch
 * looks everywhere, with starts spread over the part and a few angles each, which differ from start
 * to start so that together they leave no gap; the other half are variants proposed from all that
 * is known (`surrogate_search.c`), in each epoch ever nearer to the best.
 *
 * Nothing but its end depends on the budget: of two budgets the larger finds all that the smaller
 * found, and so never less.
 *
 * A net of very many nodes is too slow to look everywhere on. There the search looks on a coarser
 * one, on which a part without its small radii is another part; so a share of the proposals is
 * draped as it is, and the model learns what the nets differ by.
 */
#include "rounds.h"

#include "surrogate_search.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Where the first two epochs end; each later one ends at twice that. Of an epoch what looks
 * everywhere, and how many rounds follow; angles at a start for each quarter turn, pre-shears.
 * Found by `make study-quality`. */
enum { FIRST_END = 100, SECOND_END = 500 };
static const double explored = 0.5;
enum { ROUNDS = 16, ANGLES_A_QUARTER = 3, PRE_SHEARS = 3 };

/* Nets of up to `nodes_fine` are searched as they are, larger ones on nets of `nodes_coarse`; then
 * the nets of all proposals have about `nodes_proposed` on the mean, but this share of them is
 * draped as it is. */
static const double nodes_fine = 6000, nodes_coarse = 2500, nodes_proposed = 25000,
                    least_share = 1 / 32.0;

/* Variants that differ by less, as a share of `study_range`, are as good: 0.009 degrees. */
static const double as_good = 1e-4;

/* ---- what there is to search ---- */

struct optimise_space optimise_space(const struct api_study *study) {
    const struct study_request *r = &study->request;
    const struct drape_settings *s = &r->drape.settings;
    double nodes = study_nodes(study, 1), range = r->angle.to - r->angle.from;
    /* Warp and weft may change places where nothing tells them apart, and either may be reversed
     * where nothing has a side. */
    bool sided = s->has_extent[0] || s->has_extent[1] ||
                 s->generator[0].kind != DRAPE_GENERATOR_GEODESIC ||
                 s->generator[1].kind != DRAPE_GENERATOR_GEODESIC;
    bool skew = s->pre_shear_deg != 0 || r->pre_shear.count > 0;
    bool alike = s->spacing[0] == s->spacing[1] && !skew && !(vec3_norm2(r->wanted) > 0) &&
                 r->drape.permeability.model != API_PERMEABILITY_KOZENY_CARMAN;
    struct optimise_space space = {.turn = sided   ? 360
                                           : alike ? 90
                                                   : 180,
                                   .coarseness = 1,
                                   .fine = 1};
    if (nodes > nodes_fine) {
        space.coarseness = sqrt(nodes / nodes_coarse);
        space.fine = fmin(fmax(nodes_proposed / nodes, least_share), 1);
    }
    /* a range whose ends are a step apart round the period is all of it */
    if (r->angle.count > 0 && range + r->angle.step >= space.turn * (1 - 1e-9))
        space.period = space.turn;
    return space;
}

struct optimise_epoch optimise_epoch(const struct api_study *study, size_t number) {
    const struct study_request *r = &study->request;
    const struct optimise_space space = optimise_space(study);
    struct optimise_epoch epoch = {.each = 1};
    epoch.end = number ? (size_t)SECOND_END << (number - 1) : FIRST_END;
    epoch.first = number == 0   ? study->obvious_count
                  : number == 1 ? FIRST_END
                                : (size_t)SECOND_END << (number - 2);
    size_t before = number ? epoch.first : 0;
    double first = explored * (double)(epoch.end - before) - (double)(epoch.first - before);
    if (r->angle.count > 0) {
        double turn = space.period > 0 ? space.period : r->angle.to - r->angle.from;
        epoch.each = (size_t)fmax(ceil(turn / 90 * ANGLES_A_QUARTER), 1);
    }
    if (r->pre_shear.count > 1)
        epoch.each *= PRE_SHEARS;
    epoch.starts = (size_t)fmax(first / (double)epoch.each, 1);
    if (r->starts == STUDY_STARTS_POINTS && epoch.starts > r->start_count)
        epoch.starts = r->start_count;
    if (r->starts == STUDY_STARTS_KEPT)
        epoch.starts = 1;
    if (r->starts != STUDY_STARTS_GRID)
        epoch.each = (size_t)fmax(first / (double)epoch.starts, 1);
    return epoch;
}

static double fractional_part(double x) {
    return x - floor(x);
}

/* The number that comes in place of k below count, each once: by steps of about the golden section,
 * so that those up to any k are spread over all. */
static size_t scattered(size_t k, size_t count) {
    size_t step = (size_t)(0.6180339887498949 * (double)count) | 1, a = step, b = count;
    while (b > 0) { /* made coprime to the count */
        size_t rest = a % b;
        a = b;
        b = rest;
        if (b == 0 && a > 1) {
            a = step += 2;
            b = count;
        }
    }
    return k * step % count;
}

/* Angles are in even steps from one that is another at each start, by the golden section;
 * pre-shears run through their range by the third part of a sequence like it. */
struct study_variant optimise_variant(const struct api_study *study, size_t k) {
    static const double golden = 0.6180339887498949, third = 0.3819660112501051;
    const struct study_request *r = &study->request;
    const struct optimise_space space = optimise_space(study);
    struct optimise_epoch epoch = optimise_epoch(study, 0);
    size_t number = 0, passed = 0, own = k; /* starts of the epochs before; number in the epoch */
    while (own >= epoch.starts * epoch.each) {
        own -= epoch.starts * epoch.each;
        passed += epoch.starts;
        epoch = optimise_epoch(study, ++number);
    }
    size_t s = own / epoch.each, turn = own % epoch.each;
    double width = space.period > 0 ? space.period : r->angle.to - r->angle.from;
    double shift = fractional_part((double)(passed + s + 1) * golden);
    struct study_variant variant = {.coarseness = space.coarseness};
    variant.angle_deg = r->angle.from + width * ((double)turn + shift) / (double)epoch.each;
    variant.pre_shear_deg = r->pre_shear.from + (r->pre_shear.to - r->pre_shear.from) *
                                                    fractional_part((double)(k + 1) * third);
    if (study->starts) {
        /* of a list that is longer than the epoch every so many, others in each */
        size_t at = r->starts == STUDY_STARTS_GRID
                        ? passed + scattered(s, epoch.starts)
                        : (s * study->start_count / epoch.starts + number) % study->start_count;
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

/* What comes after so many variants. */
struct stage {
    size_t first_look,
        looks;        /* the numbers of those that look everywhere, for `optimise_variant` */
    size_t proposals; /* that follow them */
    double progress;  /* share of the epoch that is done */
    bool begins;      /* the first proposals of all */
};

/* The first epoch looks everywhere before it proposes anything; in the rounds of later ones both
 * take turns, so that a budget which ends within one is used as well. */
static struct stage find_stage(const struct api_study *study, size_t count) {
    struct stage stage = {0};
    struct optimise_epoch epoch = optimise_epoch(study, 0);
    size_t number = 0;
    while (count >= epoch.end) {
        stage.first_look += epoch.starts * epoch.each;
        epoch = optimise_epoch(study, ++number);
    }
    size_t done = count - epoch.first, all = epoch.end - epoch.first;
    size_t looks = epoch.starts * epoch.each, proposals = all - looks;
    size_t looked = 0, proposed = 0; /* before the round, and with it */
    for (size_t round = 0; round <= ROUNDS; round++) {
        size_t rest = ROUNDS - round;
        size_t more = number == 0 ? looks : looks - looks * rest * rest / (ROUNDS * ROUNDS);
        size_t next = proposals * round / ROUNDS;
        if (done < more + next) { /* this one; a part of it may be done */
            size_t begun = done - looked - proposed, own = more - looked;
            stage.looks = begun < own ? own - begun : 0;
            stage.first_look += more - stage.looks;
            stage.proposals = next - proposed - (begun > own ? begun - own : 0);
            break;
        }
        looked = more;
        proposed = next;
    }
    stage.progress = (double)done / (double)all;
    stage.begins = number == 0 && done == looks;
    return stage;
}

enum api_problem_id optimise_plan(const struct api_study *study, const struct study_row *rows,
                                  size_t count, struct arena *arena, struct api_study_plan *plan,
                                  struct api_problem *problem) {
    const struct optimise_space space = optimise_space(study);
    const size_t budget = study->request.budget;
    const int round = count ? rows[count - 1].round + 1 : 0;
    plan->variants = budget;
    if (count < study->obvious_count)
        return task_make_list(study, study->obvious + count, study->obvious_count - count, round,
                              arena, plan, problem);
    const struct stage stage = find_stage(study, count);
    size_t looks = stage.looks, wanted = stage.proposals, found = 0;
    if (count >= budget || (stage.begins && all_as_good(study, rows, count))) {
        plan->variants = count;
        return API_OK;
    }
    looks = looks < budget - count ? looks : budget - count;
    wanted = wanted < budget - count - looks ? wanted : budget - count - looks;
    const struct task_range range = {.kind = STUDY_TASK_OPTIMISE,
                                     .first = stage.first_look,
                                     .end = stage.first_look + looks,
                                     .nodes = study_cost(study, space.coarseness),
                                     .round = round};
    struct search_aim aims[SEARCH_AIMS_MOST];
    const struct surrogate_search search = {.study = study,
                                            .period = space.period,
                                            .coarseness = space.coarseness,
                                            .fine = space.fine,
                                            .rows = rows,
                                            .count = count,
                                            .aims = aims,
                                            .aim_count =
                                                set_aims(&study->request, rows, count, aims),
                                            .progress = stage.progress};
    struct study_variant *variants = arena_take(arena, wanted, sizeof *variants);
    if (!variants ||
        (wanted && surrogate_search_next(&search, wanted, arena, variants, &found) != STATUS_OK))
        return api_problem_no_memory(problem, "the study");
    struct api_study_plan proposed = {0};
    if ((looks && task_make_range(&range, arena, plan, problem) != API_OK) ||
        task_make_list(study, variants, found, round, arena, &proposed, problem) != API_OK)
        return problem->id;
    if (looks + found == 0)
        plan->variants = count;
    return task_join(arena, plan, &proposed, problem);
}
