/* SPDX-License-Identifier: MIT */
#include "surrogate_search.h"

#include "seeded.h"
#include "solver/angle.h"
#include "surrogate.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Rows that a model is made of at the most; candidates for each variant; where they are drawn, in
 * so many ways; valleys at the most, the best of each from this share of the rows, this far apart.
 * Found by `make study-quality`. */
enum { MODELLED = 300, CANDIDATES = 128, WAYS = 3, VALLEYS = 20, GOOD = 4 };
static const double apart = 0.08;

/* Steps that the best candidate then takes downwards: the first of this share of the greatest
 * distance of candidates, each longer by a third after one that leads down, else a little shorter.
 */
enum { DESCENT = 100 };
static const double stride = 0.25, longer = 1.3, shorter = 0.95;

/* How far from there at first, as a share of the part's length (the root of its area), of a quarter
 * turn and of the range of the pre-shears; candidates are at 1, 1/2, .. 1/16 of it, and all of that
 * shrinks as the budget is used. */
static const double reach = 0.1;
enum { SCALES = 5 };

/* From when on all are drawn about the best; the model's weights. */
static const double settled = 0.8, weights[] = {0.3, 0.5, 0.8, 0.95};
enum { WEIGHTS = sizeof weights / sizeof *weights };

/* The model's lengths: the part is about 1 long, all directions are a circle of this radius, all
 * pre-shears that long. */
static const double circle = 0.25, shears = 0.5;

/* Variants on the drape's own net are this far from those on a coarser one: nearer than others that
 * differ by much, further than those that differ by little. */
static const double between_nets = 0.1;

static double search_aim_value(const struct search_aim *aim,
                               const double quantity[QUANTITY_COUNT]) {
    double most = -HUGE_VAL;
    for (int k = 0; k < QUANTITY_COUNT; k++)
        if (aim->factor[k] > 0)
            most = fmax(most, aim->factor[k] * quantity[k] + aim->shift[k]);
    return most;
}

/* ---- the space of variants ---- */

/* What the model measures by. */
struct space {
    const struct study_request *request;
    const struct study_part *part;
    double length, period;
    struct vec3 origin, axis; /* directions are measured from what the axis is in the tangent plane,
                                 which is the same way everywhere */
};

/* A variant as a point of it. */
struct trial {
    struct part_point start;
    double turn; /* of the warp, in degrees: from the axis where the angle has a period, else its
                    angle */
    double pre_shear_deg;
    bool coarse; /* not on the drape's own net */
};

/* The axis of x, y and z that lies the most along the part. */
static struct space make_space(const struct surrogate_search *search) {
    const struct study_part *part = &search->study->part;
    struct space space = {.request = &search->study->request,
                          .part = part,
                          .length = sqrt(part->area),
                          .period = search->period,
                          .origin = search->rows[0].variant.start.r};
    struct vec3 normal, along, across = {0, 0, 0};
    for (size_t k = 0; k < search->count; k++)
        if (study_part_axes(part, &search->rows[k].variant.start, &normal, &along))
            across = vec3_add(
                across, vec3_make(normal.x * normal.x, normal.y * normal.y, normal.z * normal.z));
    space.axis = across.x <= across.y && across.x <= across.z ? vec3_make(1, 0, 0)
                 : across.y <= across.z                       ? vec3_make(0, 1, 0)
                                                              : vec3_make(0, 0, 1);
    return space;
}

/* The axis' angle, measured as the warp's is. */
static double axis_angle(const struct space *space, const struct part_point *at) {
    struct vec3 normal, along;
    if (!(space->period > 0) || !study_part_axes(space->part, at, &normal, &along))
        return 0;
    return angle_atan2_deg(vec3_dot(space->axis, vec3_cross(normal, along)),
                           vec3_dot(space->axis, along));
}

static struct trial trial_of(const struct space *space, const struct study_variant *variant) {
    return (struct trial){variant->start, variant->angle_deg - axis_angle(space, &variant->start),
                          variant->pre_shear_deg, variant->coarseness > 1};
}

static struct surrogate_point model_point(const struct space *space, const struct trial *trial) {
    const struct study_request *r = space->request;
    struct vec3 at = vec3_scale(1 / space->length, vec3_sub(trial->start.r, space->origin));
    struct surrogate_point point = {{0}};
    double width = r->angle.to - r->angle.from, sheared = r->pre_shear.to - r->pre_shear.from;
    if (r->starts != STUDY_STARTS_KEPT)
        memcpy(point.x, (double[]){at.x, at.y, at.z}, 3 * sizeof(double));
    if (space->period > 0) {
        angle_sincos_deg(360 / space->period * trial->turn, &point.x[4], &point.x[3]);
        point.x[3] *= circle;
        point.x[4] *= circle;
    } else if (width > 0) {
        point.x[3] = 2 * ANGLE_PI * circle / 90 * (trial->turn - r->angle.from);
    }
    if (sheared > 0)
        point.x[5] = shears * (trial->pre_shear_deg - r->pre_shear.from) / sheared;
    point.x[6] = trial->coarse ? between_nets : 0;
    return point;
}

/* ---- the model ---- */

struct model {
    struct space space;
    struct surrogate surrogate;
    enum quantity_id id[QUANTITY_COUNT]; /* of each of its first functions */
    size_t judged;                       /* how many; behind come the divisions' largest shears */
};

static int compare_quantities(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

/* What the model says of a variant, and the square of its distance to the nearest that it knows. */
static void predict_row(const struct model *model, const struct surrogate_point *point,
                        struct study_row *row, double *nearest) {
    double value[SURROGATE_VALUES_MOST];
    surrogate_at(&model->surrogate, point, value, nearest);
    for (size_t v = 0; v < model->judged; v++)
        row->quantity[model->id[v]] = value[v];
    double *largest = &row->quantity[QUANTITY_MAX_SHEAR];
    for (size_t v = model->judged; v < model->surrogate.values; v++)
        *largest = v == model->judged ? value[v] : fmax(*largest, value[v]);
}

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

/* The numbers of rows by how good they are for an aim, in `order`: those that miss the limits by
 * less first. With `model` (may be NULL) those of a coarser net are judged by what it says that
 * they are on the drape's own. How many: all but failures; SIZE_MAX without memory. */
static size_t order_rows(const struct surrogate_search *search, const struct search_aim *aim,
                         const struct model *model, struct arena *arena, size_t *order) {
    struct arena_mark mark = arena_mark(arena);
    struct choice *choices = arena_take(arena, search->count, sizeof *choices);
    size_t count = 0;
    if (!choices)
        return SIZE_MAX;
    for (size_t k = 0; k < search->count; k++) {
        struct study_row row = search->rows[k];
        double nearest;
        if (row.failure != FAILURE_NONE)
            continue;
        if (model && row.variant.coarseness > 1) {
            struct trial trial = trial_of(&model->space, &row.variant);
            trial.coarse = false;
            const struct surrogate_point point = model_point(&model->space, &trial);
            predict_row(model, &point, &row, &nearest);
        }
        choices[count++] = (struct choice){study_violation(search->study, &row),
                                           search_aim_value(aim, row.quantity), k};
    }
    qsort(choices, count, sizeof *choices, compare_choices);
    for (size_t k = 0; k < count; k++)
        order[k] = choices[k].row;
    arena_rewind(arena, mark);
    return count;
}

/* The rows of a model: all, or the best of each aim on each net, and of the others every so many.
 */
static size_t choose_rows(const struct surrogate_search *search, size_t *const *orders,
                          const size_t *ordered, size_t *chosen, bool *taken) {
    size_t count = 0, each = MODELLED / 2 / search->aim_count;
    each = search->coarseness > 1 ? each / 2 : each;
    if (search->count <= MODELLED) {
        for (size_t k = 0; k < search->count; k++)
            chosen[k] = k;
        return search->count;
    }
    for (size_t a = 0; a < search->aim_count; a++) {
        size_t left[2] = {each, each}; /* of both nets */
        for (size_t k = 0; k < ordered[a]; k++) {
            size_t row = orders[a][k], net = search->rows[row].variant.coarseness > 1;
            taken[row] = taken[row] || left[net] > 0;
            left[net] -= left[net] > 0;
        }
    }
    for (size_t k = 0; k < search->count; k++)
        count += taken[k];
    size_t others = search->count - count, wanted = MODELLED - count, passed = 0;
    count = 0;
    for (size_t k = 0; k < search->count; k++) {
        bool take = taken[k] || passed * wanted / others != (passed + 1) * wanted / others;
        passed += !taken[k];
        if (take)
            chosen[count++] = k;
    }
    return count;
}

/* What a quantity is modelled up to: what this share of the rows keeps below, or what a limit or an
 * aim asks of it if that is more. What is far from good has steep walls that the model would follow
 * for nothing. */
static const double capped = 0.3;
static double cap_of(const struct surrogate_search *search, enum quantity_id id, double *scratch) {
    const struct study_limit *limit = &search->study->request.limit[id];
    double cap = -HUGE_VAL, most = -HUGE_VAL;
    for (int net = 0; net < 2; net++) { /* that of the drape, and the coarser one */
        size_t count = 0;
        for (size_t k = 0; k < search->count; k++)
            if (search->rows[k].failure == FAILURE_NONE &&
                (search->rows[k].variant.coarseness > 1) == net)
                scratch[count++] = search->rows[k].quantity[id];
        if (count == 0)
            continue;
        qsort(scratch, count, sizeof *scratch, compare_quantities);
        cap = fmax(cap, scratch[(size_t)(capped * (double)count)]);
        most = fmax(most, scratch[count - 1]);
    }
    if (limit->has_min || most == -HUGE_VAL)
        return HUGE_VAL;
    if (limit->has_max)
        cap = fmax(cap, limit->max + 0.1 * (most - limit->max));
    for (size_t a = 0; a < search->aim_count; a++) {
        const struct search_aim *aim = &search->aims[a];
        if (aim->shift[id] < 0) /* where the aim is 1: all of the range of a front */
            cap = fmax(cap, (1 - aim->shift[id]) / aim->factor[id]);
    }
    return cap;
}

static enum status make_model(const struct surrogate_search *search, const size_t *chosen,
                              size_t count, struct arena *arena, struct model *model) {
    struct surrogate_point *points = arena_take(arena, count, sizeof *points);
    double *value = arena_take(arena, count * SURROGATE_VALUES_MOST, sizeof *value);
    double *scratch = arena_take(arena, search->count, sizeof *scratch);
    size_t judged = 0;
    if (!points || !value || !scratch)
        return STATUS_OUT_OF_MEMORY;
    for (int id = 0; id < QUANTITY_COUNT; id++)
        if (study_judges(&search->study->request, (enum quantity_id)id))
            model->id[judged++] = (enum quantity_id)id;
    size_t values = judged + search->study->divisions;
    for (size_t v = 0; v < judged; v++) { /* failures have what is worst */
        enum quantity_id id = model->id[v];
        double cap = cap_of(search, id, scratch), least = HUGE_VAL, most = -HUGE_VAL;
        for (size_t i = 0; i < count; i++) {
            const struct study_row *row = &search->rows[chosen[i]];
            if (row->failure != FAILURE_NONE)
                continue;
            value[i * values + v] = fmin(row->quantity[id], cap);
            least = fmin(least, value[i * values + v]);
            most = fmax(most, value[i * values + v]);
        }
        for (size_t i = 0; i < count; i++)
            if (search->rows[chosen[i]].failure != FAILURE_NONE)
                value[i * values + v] = search->study->request.limit[id].has_min ? least : most;
    }
    /* The largest shear of each division, and of failures the largest of all. */
    double cap = values > judged ? cap_of(search, QUANTITY_MAX_SHEAR, scratch) : 0;
    for (size_t v = judged; v < values; v++) {
        double most = 0;
        for (size_t i = 0; i < count; i++) {
            value[i * values + v] = fmin(search->rows[chosen[i]].most[v - judged], cap);
            most = fmax(most, value[i * values + v]);
        }
        for (size_t i = 0; i < count; i++)
            if (search->rows[chosen[i]].failure != FAILURE_NONE)
                value[i * values + v] = most;
    }
    model->judged = judged;
    for (size_t k = 0; k < count; k++) {
        struct trial trial = trial_of(&model->space, &search->rows[chosen[k]].variant);
        points[k] = model_point(&model->space, &trial);
    }
    return surrogate_make(points, value, count, values, arena, &model->surrogate);
}

/* ---- candidates ---- */

struct candidate {
    struct trial trial;
    struct surrogate_point point;
    double value, violation; /* as modelled */
    double nearest;          /* distance to what is known */
};

static double clamp(double x, double low, double high) {
    return fmin(fmax(x, low), high);
}

/* What candidates are compared by: value and nearness as shares of the ranges that they have. */
struct scale {
    double least, most, near, far, weight;
};

/* The less the better; those that keep the limits come first. */
static double rate_candidate(const struct scale *s, const struct candidate *c) {
    double value = s->most > s->least ? (c->value - s->least) / (s->most - s->least) : 0;
    double nearness = s->far > s->near ? fmax(s->far - c->nearest, 0) / (s->far - s->near) : 0;
    if (c->violation > 0)
        value = 1 + c->violation;
    return s->weight * value + (1 - s->weight) * nearness;
}

/* The search for the variants of a round. */
struct round_search {
    const struct surrogate_search *search;
    struct model model;
    struct candidate list[CANDIDATES], *made; /* those chosen so far */
    size_t count;                             /* of them */
    uint32_t seed;
};

/* A candidate about a trial; false where the part has none. */
static bool draw_candidate(struct round_search *p, const struct search_aim *aim,
                           const struct trial *about, double size, uint32_t seed, size_t draw,
                           struct candidate *candidate) {
    const struct model *model = &p->model;
    const struct space *space = &model->space;
    const struct study_request *r = space->request;
    struct trial *trial = &candidate->trial;
    struct study_row row = {.failure = FAILURE_NONE};
    double by[4];
    for (unsigned c = 0; c < 4; c++)
        by[c] = size * seeded_bell(seed, draw, 3 * c + 1);
    *trial = *about;
    trial->coarse = false;
    if (r->starts == STUDY_STARTS_GRID &&
        !study_part_nudge(space->part, &about->start,
                          (double[]){by[0] * space->length, by[1] * space->length}, &trial->start))
        return false;
    if (r->angle.count > 0)
        trial->turn += 90 * by[2];
    if (r->angle.count > 0 && !(space->period > 0))
        trial->turn = clamp(trial->turn, r->angle.from, r->angle.to);
    if (r->pre_shear.count > 0)
        trial->pre_shear_deg =
            clamp(trial->pre_shear_deg + by[3] * (r->pre_shear.to - r->pre_shear.from),
                  r->pre_shear.from, r->pre_shear.to);
    /* What the model says of it. */
    candidate->point = model_point(space, trial);
    predict_row(model, &candidate->point, &row, &candidate->nearest);
    candidate->value = search_aim_value(aim, row.quantity);
    candidate->violation = study_violation(p->search->study, &row);
    for (size_t k = 0; k < p->count; k++)
        candidate->nearest =
            fmin(candidate->nearest, surrogate_distance2(&candidate->point, &p->made[k].point));
    candidate->nearest = sqrt(candidate->nearest);
    return true;
}

static double farthest(const struct surrogate_search *search) {
    return reach * (1 - search->progress) + 1e-4;
}

/* Candidates of the next variant, each about one of some rows. */
static size_t draw_candidates(struct round_search *p, const struct search_aim *aim,
                              const size_t *rows, size_t number) {
    enum { PLACE = 0, SCALE = 13 };
    size_t count = 0;
    for (size_t c = 0; c < CANDIDATES; c++) {
        size_t draw = p->count * CANDIDATES + c;
        size_t row = rows[(size_t)(seeded_uniform(p->seed, draw, PLACE) * (double)number)];
        double size = farthest(p->search);
        for (int k = (int)(seeded_uniform(p->seed, draw, SCALE) * SCALES); k > 0; k--)
            size *= 0.5;
        struct trial about = trial_of(&p->model.space, &p->search->rows[row].variant);
        count += draw_candidate(p, aim, &about, size, p->seed, draw, &p->list[count]);
    }
    return count;
}

/* About the best row, about the best of one valley, of ever fewer, and about those of all valleys,
 * in turns; at last about the best alone. */
static size_t draw_in_turn(struct round_search *p, const struct search_aim *aim,
                           const size_t *order, size_t ordered, size_t turn) {
    struct surrogate_point taken[VALLEYS];
    size_t valley[VALLEYS], count = 0;
    size_t good = ordered / GOOD > 5 ? ordered / GOOD : ordered < 5 ? ordered : 5;
    /* The best of each valley, the best of all first: of the good rows those that none of the
     * better ones is near. */
    for (size_t k = 0; k < good && count < VALLEYS; k++) {
        struct trial trial = trial_of(&p->model.space, &p->search->rows[order[k]].variant);
        taken[count] = model_point(&p->model.space, &trial);
        bool near = false;
        for (size_t v = 0; v < count && !near; v++)
            near = surrogate_distance2(&taken[count], &taken[v]) < apart * apart;
        if (!near)
            valley[count++] = order[k];
    }
    double left = fmax(1 - p->search->progress / settled, 0);
    size_t most = 1 + (size_t)((double)(count - 1) * left), way = left > 0 ? turn % WAYS : 0;
    size_t which = way == 1 ? (p->seed + turn) % most : 0;
    size_t drawn = draw_candidates(p, aim, &valley[which], way == 2 ? count : 1);
    return drawn ? drawn /* at a pole there is no tangent plane to draw in */
                 : draw_candidates(p, aim, order, ordered);
}

/* From the best of the candidates on downwards, by steps of random directions that become shorter
 * where none leads down: the least of a greatest of many functions lies at the bottom of bent and
 * narrow valleys, which no number of candidates about one trial follows. */
static struct candidate descend_from_best(struct round_search *p, const struct search_aim *aim,
                                          size_t drawn, double weight) {
    struct scale scale = {HUGE_VAL, -HUGE_VAL, HUGE_VAL, 0, weight};
    for (size_t k = 0; k < drawn; k++) {
        scale.least = fmin(scale.least, p->list[k].value);
        scale.most = fmax(scale.most, p->list[k].value);
        scale.near = fmin(scale.near, p->list[k].nearest);
        scale.far = fmax(scale.far, p->list[k].nearest);
    }
    struct candidate best = p->list[0], next;
    double least = rate_candidate(&scale, &best), size = stride * farthest(p->search);
    for (size_t k = 1; k < drawn; k++) {
        double own = rate_candidate(&scale, &p->list[k]);
        best = own < least ? p->list[k] : best;
        least = fmin(own, least);
    }
    for (size_t k = 0; k < DESCENT; k++) {
        if (!draw_candidate(p, aim, &best.trial, size, ~p->seed, p->count * DESCENT + k, &next))
            continue;
        double own = rate_candidate(&scale, &next);
        size *= own < least ? longer : shorter;
        best = own < least ? next : best;
        least = fmin(own, least);
    }
    return best;
}

enum status surrogate_search_next(const struct surrogate_search *search, size_t wanted,
                                  struct arena *arena, struct study_variant *variants,
                                  size_t *found) {
    struct arena_mark mark = arena_mark(arena);
    struct round_search *p = arena_alloc(arena, 1, sizeof *p);
    size_t *orders[SEARCH_AIMS_MOST], ordered[SEARCH_AIMS_MOST];
    size_t *chosen = arena_take(arena, search->count, sizeof *chosen);
    bool *taken = arena_alloc(arena, search->count, sizeof *taken);
    *found = 0;
    if (!p || !chosen || !taken)
        return STATUS_OUT_OF_MEMORY;
    for (size_t a = 0; a < search->aim_count; a++) {
        orders[a] = arena_take(arena, search->count, sizeof **orders);
        ordered[a] =
            orders[a] ? order_rows(search, &search->aims[a], NULL, arena, orders[a]) : SIZE_MAX;
        if (ordered[a] == SIZE_MAX)
            return STATUS_OUT_OF_MEMORY;
        if (ordered[a] == 0)
            return STATUS_OK;
    }
    p->search = search;
    p->seed = (uint32_t)search->rows[search->count - 1].round + 1;
    p->model.space = make_space(search);
    const struct space *space = &p->model.space;
    const double from = space->request->angle.from;
    p->made = arena_take(arena, wanted, sizeof *p->made);
    size_t count = choose_rows(search, orders, ordered, chosen, taken);
    if (!p->made || make_model(search, chosen, count, arena, &p->model) != STATUS_OK)
        return STATUS_OUT_OF_MEMORY;
    for (size_t a = 0; a < search->aim_count && search->coarseness > 1; a++)
        if (order_rows(search, &search->aims[a], &p->model, arena, orders[a]) == SIZE_MAX)
            return STATUS_OUT_OF_MEMORY;
    for (size_t k = 0; k < wanted; k++) {
        size_t own = k % search->aim_count, turn = k / search->aim_count;
        const struct search_aim *aim = &search->aims[own];
        size_t drawn = draw_in_turn(p, aim, orders[own], ordered[own], turn);
        if (drawn == 0)
            continue;
        const struct candidate best = descend_from_best(p, aim, drawn, weights[turn % WEIGHTS]);
        double before = search->fine * (double)(search->count + p->count);
        bool fine = floor(before + search->fine) > floor(before);
        p->made[p->count] = best;
        struct study_variant *variant = &variants[p->count++];
        *variant = (struct study_variant){.start = best.trial.start,
                                          .angle_deg = best.trial.turn +
                                                       axis_angle(space, &best.trial.start),
                                          .pre_shear_deg = best.trial.pre_shear_deg,
                                          .coarseness = fine ? 1 : search->coarseness};
        if (space->period > 0)
            variant->angle_deg -=
                space->period * floor((variant->angle_deg - from) / space->period);
    }
    *found = p->count;
    arena_rewind(arena, mark);
    return STATUS_OK;
}
