/* SPDX-License-Identifier: MIT */
#include "refine.h"

#include "engine.h"
#include "solver/angle.h"
#include <math.h>
#include <nlopt.h>
#include <string.h>

/* ---- as tasks ---- */

enum { FROM = STUDY_OWN_AT, STEPS = FROM + 9, FACTORS = STEPS + 4, OBJECTIVES = 8 };
_Static_assert(FACTORS + 2 * OBJECTIVES <= API_STUDY_TASK, "an order fits in a task");

double refine_value(const struct refine_aim *aim, const double quantity[QUANTITY_COUNT]) {
    double most = -HUGE_VAL;
    for (int k = 0; k < QUANTITY_COUNT; k++)
        if (aim->factor[k] > 0)
            most = fmax(most, aim->factor[k] * quantity[k] + aim->shift[k]);
    return most;
}

void refine_store(const struct refine_order *order, struct api_study_task *task) {
    const struct study_variant *v = &order->from;
    const double own[] = {v->start.face, v->start.uv[0], v->start.uv[1], v->start.r.x,
                          v->start.r.y,  v->start.r.z,   v->angle_deg,   v->pre_shear_deg,
                          v->coarseness, order->step[0], order->step[1], order->step[2],
                          order->period};
    *task = (struct api_study_task){0};
    task->STUDY_TASK_WORK = STUDY_WORK_REFINE;
    task->STUDY_TASK_VARIANTS = (double)order->variants;
    memcpy(task->value + FROM, own, sizeof own);
    memcpy(task->value + FACTORS, order->aim.factor, OBJECTIVES * sizeof(double));
    memcpy(task->value + FACTORS + OBJECTIVES, order->aim.shift, OBJECTIVES * sizeof(double));
}

void refine_load(const struct api_study_task *task, struct refine_order *order) {
    const double *v = task->value + FROM;
    *order = (struct refine_order){
        .from = {.start = {(int32_t)v[0], {v[1], v[2]}, vec3_make(v[3], v[4], v[5])},
                 .angle_deg = v[6],
                 .pre_shear_deg = v[7],
                 .coarseness = v[8]},
        .variants = api_study_task_variants(task),
        .step = {v[9], v[10], v[11]},
        .period = v[12]};
    memcpy(order->aim.factor, task->value + FACTORS, OBJECTIVES * sizeof(double));
    memcpy(order->aim.shift, task->value + FACTORS + OBJECTIVES, OBJECTIVES * sizeof(double));
}

/* ---- the search ---- */

/* Unknowns: the start's shift along two directions of the tangent plane, the angle, the pre-shear;
 * each in units of its first step; then, with several objectives, the aim's value. */
enum { SHIFT, TURN = 2, SHEAR, AIM, UNKNOWNS_MOST };

struct search {
    struct study_chunk *chunk;
    struct refine_order order;
    int unknown[UNKNOWNS_MOST]; /* which of them each variable is */
    unsigned count;
    bool turns_with_start; /* the angle is measured from directions that differ from place to place
                            */
    struct vec3 axis[2];   /* at the start that it sets out from */
    enum quantity_id terms[QUANTITY_COUNT], limits[2 * QUANTITY_COUNT];
    bool lower[2 * QUANTITY_COUNT]; /* of a limit */
    int term_count, limit_count;
    nlopt_opt optimiser;
    double at[UNKNOWNS_MOST]; /* where the row is of */
    bool drawn, stopped;
    struct study_row row;
    double worst; /* value so far, which failures are taken to have */
};

/* The angle from the reference direction at a place of what is `angle_deg` from that at the start,
 * carried over in space. */
static double carry_angle(const struct search *search, const struct spread_place *to,
                          double angle_deg) {
    struct vec3 normal, along;
    if (!search->turns_with_start ||
        !study_shape_axes(&search->chunk->study->shape, to, &normal, &along))
        return angle_deg;
    return angle_deg + angle_atan2_deg(vec3_dot(vec3_cross(along, search->axis[0]), normal),
                                       vec3_dot(along, search->axis[0]));
}

static struct study_variant variant_at(const struct search *search, const double *x) {
    const struct study_request *r = &search->chunk->study->request;
    const struct refine_order *order = &search->order;
    struct study_variant variant = order->from;
    double shift[2] = {0, 0}, turn = 0;
    for (unsigned k = 0; k < search->count; k++) {
        int which = search->unknown[k];
        if (which < TURN)
            shift[which] = x[k] * order->step[0];
        else if (which == TURN)
            turn = x[k] * order->step[1];
        else if (which == SHEAR)
            variant.pre_shear_deg = order->from.pre_shear_deg + x[k] * order->step[2];
    }
    if (order->step[0] > 0)
        variant.start = study_shape_shift(
            r, &search->chunk->study->shape, &order->from.start,
            vec3_axpy(shift[0], search->axis[0], vec3_scale(shift[1], search->axis[1])));
    variant.angle_deg = carry_angle(search, &variant.start, order->from.angle_deg + turn);
    if (order->period > 0)
        variant.angle_deg -=
            order->period * floor((variant.angle_deg - r->angle.from) / order->period);
    if (r->angle.count > 0 && !(order->period > 0))
        variant.angle_deg = fmin(fmax(variant.angle_deg, r->angle.from), r->angle.to);
    return variant;
}

/* The row at x, draped unless it is the one before once more. */
static const struct study_row *row_at(struct search *search, const double *x) {
    bool same = search->drawn;
    for (unsigned k = 0; k < search->count; k++)
        same = same && (search->unknown[k] == AIM || search->at[k] == x[k]);
    if (same || search->stopped)
        return &search->row;
    struct study_variant variant = variant_at(search, x);
    memcpy(search->at, x, search->count * sizeof *x);
    search->drawn = true;
    if (!study_chunk_drape(search->chunk, &variant, &search->row) ||
        search->chunk->k >= search->order.variants) {
        search->stopped = true;
        nlopt_force_stop(search->optimiser);
    }
    if (search->row.failure == FAILURE_NONE)
        search->worst = fmax(search->worst, refine_value(&search->order.aim, search->row.quantity));
    return &search->row;
}

static double objective(unsigned n, const double *x, double *gradient, void *data) {
    struct search *search = data;
    const struct study_row *row = row_at(search, x);
    (void)gradient;
    if (search->unknown[n - 1] == AIM)
        return x[n - 1];
    return row->failure == FAILURE_NONE ? refine_value(&search->order.aim, row->quantity)
                                        : search->worst;
}

/* What has to be at most 0: limits, as shares of their range, and the terms of the aim less the
 * value that is to be small. */
static void constraints(unsigned m, double *result, unsigned n, const double *x, double *gradient,
                        void *data) {
    struct search *search = data;
    const struct study_row *row = row_at(search, x);
    bool failed = row->failure != FAILURE_NONE;
    (void)gradient;
    for (int k = 0; k < search->limit_count; k++)
        result[k] = failed ? 1
                           : study_limit_excess(search->chunk->study, row, search->limits[k],
                                                search->lower[k]);
    for (unsigned k = (unsigned)search->limit_count; k < m; k++) {
        int id = (int)search->terms[k - (unsigned)search->limit_count];
        const struct refine_aim *aim = &search->order.aim;
        double value = aim->factor[id] * row->quantity[id] + aim->shift[id];
        result[k] = (failed ? search->worst + 1 : value) - x[n - 1];
    }
}

/* What is unknown, and the bounds. */
static void set_unknowns(struct search *search, double *low, double *high, double *step) {
    const struct study_request *r = &search->chunk->study->request;
    const struct refine_order *order = &search->order;
    for (int which = SHIFT; which <= AIM; which++) {
        double by = order->step[which < TURN ? 0 : which == TURN ? 1 : 2];
        if (which == AIM ? search->term_count < 2 : !(by > 0))
            continue;
        low[search->count] = -HUGE_VAL;
        high[search->count] = HUGE_VAL;
        if (which == TURN && !(order->period > 0) && !search->turns_with_start) {
            low[search->count] = (r->angle.from - order->from.angle_deg) / by;
            high[search->count] = (r->angle.to - order->from.angle_deg) / by;
        } else if (which == SHEAR) {
            low[search->count] = (r->pre_shear.from - order->from.pre_shear_deg) / by;
            high[search->count] = (r->pre_shear.to - order->from.pre_shear_deg) / by;
        }
        step[search->count] = which == AIM ? 0.1 : 1;
        search->unknown[search->count++] = which;
    }
}

static void set_constraints(struct search *search) {
    const struct study_request *r = &search->chunk->study->request;
    for (int k = 0; k < QUANTITY_COUNT; k++) {
        if (search->order.aim.factor[k] > 0)
            search->terms[search->term_count++] = (enum quantity_id)k;
        for (int side = 0; side < 2; side++) {
            if (!(side ? r->limit[k].has_min : r->limit[k].has_max))
                continue;
            search->lower[search->limit_count] = side;
            search->limits[search->limit_count++] = (enum quantity_id)k;
        }
    }
}

static bool set_axes(struct search *search) {
    const struct spread_place *from = &search->order.from.start;
    const struct study_shape *shape = &search->chunk->study->shape;
    struct vec3 normal;
    search->turns_with_start =
        search->order.step[0] > 0 && !shape->mesh && search->chunk->study->request.angle.count > 0;
    if (!(search->order.step[0] > 0))
        return true;
    if (!study_shape_axes(shape, from, &normal, &search->axis[0]))
        return false;
    search->axis[1] = vec3_cross(normal, search->axis[0]);
    return true;
}

/* Smaller than this share of the first steps nothing is worth a drape. */
static const double finest = 1e-3;

bool refine_chunk(struct study_chunk *chunk) {
    struct search search = {.chunk = chunk, .worst = -HUGE_VAL};
    double low[UNKNOWNS_MOST], high[UNKNOWNS_MOST], step[UNKNOWNS_MOST], x[UNKNOWNS_MOST] = {0};
    double least;
    refine_load(chunk->task, &search.order);
    set_constraints(&search);
    if (!set_axes(&search))
        search.order.step[0] = 0;
    set_unknowns(&search, low, high, step);
    if (search.count == 0 || search.unknown[0] == AIM)
        return study_chunk_drape(chunk, &search.order.from, &search.row);
    if (search.unknown[search.count - 1] == AIM) {
        (void)row_at(&search, x);
        x[search.count - 1] = refine_value(&search.order.aim, search.row.quantity);
    }
    unsigned held = (unsigned)search.limit_count;
    held += search.unknown[search.count - 1] == AIM ? (unsigned)search.term_count : 0;
    search.optimiser = nlopt_create(NLOPT_LN_COBYLA, search.count);
    if (!search.optimiser)
        return false;
    nlopt_set_min_objective(search.optimiser, objective, &search);
    nlopt_set_lower_bounds(search.optimiser, low);
    nlopt_set_upper_bounds(search.optimiser, high);
    nlopt_set_initial_step(search.optimiser, step);
    nlopt_set_xtol_rel(search.optimiser, 0);
    nlopt_set_xtol_abs1(search.optimiser, finest);
    if (held)
        nlopt_add_inequality_mconstraint(search.optimiser, held, constraints, &search, NULL);
    nlopt_set_maxeval(search.optimiser, 10 * (int)search.order.variants);
    if (!search.stopped)
        (void)nlopt_optimize(search.optimiser, x, &least);
    nlopt_destroy(search.optimiser);
    return chunk->problem->id == API_OK;
}
