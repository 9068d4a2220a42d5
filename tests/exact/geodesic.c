/* SPDX-License-Identifier: MIT */
#include "geodesic.h"
#include "chebyshev.h"
#include <assert.h>
#include <math.h>
#include <stdbool.h>
#include <stdlib.h>

enum {
    PICARD_MAX = 200,
    BISECTIONS = 60,
    KNOT_ROUNDS = 8,
    SHOTS_MAX = 20,
    SHOT_BLOCKS = 2,
    SHOT_ORDER = 16
};
static const double PICARD_GOAL = 1e-12; /* relative to the block's step */
static const double KNOT_GOAL = 1e-14;   /* relative to the span */
static const double SHORTEST = 1e-3;     /* block tried, relative to the usual */
static const double SHOT_GOAL = 1e-14;   /* relative to the parameters */

/* x = (u, v) and p = x' at the points of one block. */
struct block {
    double from, length;
    int span[2];
    double x[CHEBYSHEV_MAX][2], p[CHEBYSHEV_MAX][2];
};

struct exact_geodesic {
    const struct shape *shape;
    struct chebyshev rule;
    int count, capacity;
    struct block *block;
};

/* Where the line is and which polynomials hold there. */
struct tip {
    double x[2], p[2];
    int span[2];
};

void jet_connection(const struct surface_jet *jet, const double a[2], const double b[2],
                    double out[2]) {
    struct vec3 bend = vec3_scale(a[0] * b[0], jet->uu);
    bend = vec3_axpy(a[0] * b[1] + a[1] * b[0], jet->uv, bend);
    bend = vec3_axpy(a[1] * b[1], jet->vv, bend);
    jet_pull_back(jet, vec3_scale(-1, bend), out);
}

/* One sweep of x = x0 + integral of p, p = p0 + integral of F; the change relative to the step. */
static double picard_sweep(const struct exact_geodesic *g, const struct tip *start,
                           struct block *block) {
    const struct chebyshev *rule = &g->rule;
    double f[CHEBYSHEV_MAX][2], h = block->length, change = 0;
    double size = fabs(start->p[0]) + fabs(start->p[1]);
    for (int i = 0; i < rule->n; i++) {
        struct surface_jet jet;
        shape_evaluate_in(g->shape, block->span, block->x[i][0], block->x[i][1], &jet);
        jet_connection(&jet, block->p[i], block->p[i], f[i]);
    }
    for (int i = 0; i < rule->n; i++) {
        for (int k = 0; k < 2; k++) {
            double p = start->p[k], x = start->x[k];
            for (int j = 0; j < rule->n; j++) {
                p += h * rule->integral[i][j] * f[j][k];
                x += h * rule->integral[i][j] * block->p[j][k];
            }
            double here = (fabs(x - block->x[i][k]) / h + fabs(p - block->p[i][k])) / size;
            change = isnan(here) ? HUGE_VAL : fmax(change, here);
            block->p[i][k] = p;
            block->x[i][k] = x;
        }
    }
    return change;
}

/* False when the block is too long: its polynomials may have a pole beyond their span. */
static bool integrate_block(const struct exact_geodesic *g, const struct tip *start,
                            struct block *block) {
    double change = HUGE_VAL, before;
    for (int i = 0; i < g->rule.n; i++) {
        for (int k = 0; k < 2; k++) {
            block->x[i][k] = start->x[k];
            block->p[i][k] = start->p[k];
            block->span[k] = start->span[k];
        }
    }
    for (int sweep = 0; sweep < PICARD_MAX; sweep++) {
        before = change;
        change = picard_sweep(g, start, block);
        if (change < PICARD_GOAL && change >= before / 2) { /* only rounding is left */
            return true;
        }
        if (!isfinite(change)) {
            return false;
        }
    }
    return false;
}

static void block_at(const struct exact_geodesic *g, const struct block *block, double rest,
                     double x[2], double p[2]) {
    double weight[CHEBYSHEV_MAX];
    chebyshev_weights(&g->rule, rest, weight);
    for (int k = 0; k < 2; k++) {
        x[k] = 0;
        p[k] = 0;
        for (int i = 0; i < g->rule.n; i++) {
            x[k] += weight[i] * block->x[i][k];
            p[k] += weight[i] * block->p[i][k];
        }
    }
}

/* How far x[k] is beyond the block's span; never when that is an end of the domain. */
static double beyond(const struct shape *shape, const struct block *block, int k, double x) {
    int span = block->span[k];
    const double *knots = shape->knots[k];
    double below = span > shape->degree[k] ? knots[span] - x : -HUGE_VAL;
    double above = knots[span + 1] < knots[shape->size[k]] ? x - knots[span + 1] : -HUGE_VAL;
    return fmax(below, above);
}

/* The share of the block where the line first leaves the span in direction k, else 1. */
static double crossing(const struct exact_geodesic *g, const struct block *block, int k) {
    int i = 1;
    while (i < g->rule.n && beyond(g->shape, block, k, block->x[i][k]) <= 0) {
        i++;
    }
    if (i == g->rule.n) {
        return 1;
    }
    double low = g->rule.x[i - 1], high = g->rule.x[i];
    for (int round = 0; round < BISECTIONS; round++) {
        double middle = (low + high) / 2, x[2], p[2];
        block_at(g, block, middle, x, p);
        *(beyond(g->shape, block, k, x[k]) > 0 ? &high : &low) = middle;
    }
    return high;
}

/* The span next to `span` on the side that p points to. */
static int next_span(const struct shape *shape, int k, int span, double p) {
    const double *knots = shape->knots[k];
    if (p > 0) {
        return shape_span(shape, k, knots[span + 1]);
    }
    for (span--; knots[span] == knots[span + 1];) {
        span--;
    }
    return span;
}

/* Over the knot of direction k: the component along the common edge stays, that across turns into
 * the new tangent plane. */
static void cross_knot(const struct shape *shape, struct tip *tip, int k) {
    struct surface_jet old, new;
    bool up = tip->p[k] > 0;
    tip->x[k] = shape->knots[k][tip->span[k] + up];
    shape_evaluate_in(shape, tip->span, tip->x[0], tip->x[1], &old);
    tip->span[k] = next_span(shape, k, tip->span[k], tip->p[k]);
    shape_evaluate_in(shape, tip->span, tip->x[0], tip->x[1], &new);
    struct vec3 edge = vec3_unit(k ? new.u : new.v), from = k ? old.v : old.u;
    struct vec3 to = k ? new.v : new.u;
    from = vec3_unit(vec3_axpy(-vec3_dot(from, edge), edge, from));
    to = vec3_unit(vec3_axpy(-vec3_dot(to, edge), edge, to));
    struct vec3 t = vec3_axpy(tip->p[0], old.u, vec3_scale(tip->p[1], old.v));
    t = vec3_axpy(vec3_dot(t, from), to, vec3_scale(vec3_dot(t, edge), edge));
    jet_pull_back(&new, t, tip->p);
}

static struct block *add_block(struct exact_geodesic *g) {
    if (g->count == g->capacity) {
        g->capacity = 2 * g->capacity + 8;
        g->block = realloc(g->block, (size_t)g->capacity * sizeof *g->block);
        assert(g->block);
    }
    return &g->block[g->count++];
}

/* Makes the block end on the knot of direction k that lies near its end: Newton on its length. */
static void end_on_knot(const struct exact_geodesic *g, const struct tip *start,
                        struct block *block, int k) {
    const double *end = block->x[g->rule.n - 1], *slope = block->p[g->rule.n - 1];
    double low = g->shape->knots[k][block->span[k]], high = g->shape->knots[k][block->span[k] + 1];
    for (int round = 0; round < KNOT_ROUNDS; round++) {
        (void)integrate_block(g, start, block);
        double knot = slope[k] > 0 ? high : low, miss = knot - end[k];
        if (fabs(miss) < KNOT_GOAL * (high - low)) {
            break;
        }
        block->length += miss / slope[k];
    }
}

/* One block of at most h from the tip at s; returns its length. */
static double advance(struct exact_geodesic *g, struct tip *tip, double s, double h) {
    struct block *block = add_block(g);
    block->from = s;
    block->length = h;
    while (!integrate_block(g, tip, block) && block->length > h * SHORTEST) {
        block->length /= 2;
    }
    double share[2] = {crossing(g, block, 0), crossing(g, block, 1)};
    int k = share[1] < share[0];
    if (share[k] < 1) {
        block->length *= share[k];
        end_on_knot(g, tip, block, k);
    }
    for (int c = 0; c < 2; c++) {
        tip->x[c] = block->x[g->rule.n - 1][c];
        tip->p[c] = block->p[g->rule.n - 1][c];
    }
    if (share[k] < 1) {
        cross_knot(g->shape, tip, k);
    }
    return block->length;
}

struct exact_geodesic *exact_geodesic_make(const struct exact_geodesic_setup *setup) {
    struct exact_geodesic *g = calloc(1, sizeof *g);
    assert(g);
    g->shape = setup->shape;
    chebyshev_make(&g->rule, setup->order);
    struct tip tip = {.x = {setup->uv[0], setup->uv[1]}};
    struct surface_jet jet;
    shape_evaluate(setup->shape, setup->uv[0], setup->uv[1], &jet);
    jet_pull_back(&jet, setup->direction, tip.p);
    for (int k = 0; k < 2; k++) {
        int span = shape_span(setup->shape, k, tip.x[k]);
        bool back = tip.x[k] == setup->shape->knots[k][span] && tip.p[k] < 0;
        bool inner = span > setup->shape->degree[k];
        tip.span[k] = back && inner ? next_span(setup->shape, k, span, -1) : span;
    }
    double step = setup->length / setup->blocks, s = 0;
    while (s < setup->length * (1 - 1e-15)) {
        s += advance(g, &tip, s, fmin(step, setup->length - s));
    }
    return g;
}

void exact_geodesic_free(struct exact_geodesic *geodesic) {
    if (geodesic) {
        free(geodesic->block);
        free(geodesic);
    }
}

void exact_geodesic_at(const struct exact_geodesic *geodesic, double s, double uv[2],
                       double duv[2]) {
    int low = 0, high = geodesic->count - 1;
    double p[2];
    while (low < high) {
        int middle = (low + high + 1) / 2;
        *(geodesic->block[middle].from <= s ? &low : &high) =
            geodesic->block[middle].from <= s ? middle : middle - 1;
    }
    const struct block *block = &geodesic->block[low];
    block_at(geodesic, block, (s - block->from) / block->length, uv, duv ? duv : p);
}

/* A shot from a point: the velocity that would reach the goal in unit time, and what it misses. */
struct shot {
    double p[2], miss[2], arrival[2], length;
};

static void shoot(const struct shape *shape, const double from[2], const double to[2],
                  struct shot *shot) {
    struct surface_jet jet;
    shape_evaluate(shape, from[0], from[1], &jet);
    struct vec3 t = vec3_axpy(shot->p[0], jet.u, vec3_scale(shot->p[1], jet.v));
    struct exact_geodesic_setup setup = {.shape = shape,
                                         .uv = {from[0], from[1]},
                                         .direction = vec3_unit(t),
                                         .length = vec3_norm(t),
                                         .blocks = SHOT_BLOCKS,
                                         .order = SHOT_ORDER};
    struct exact_geodesic *g = exact_geodesic_make(&setup);
    double reached[2];
    exact_geodesic_at(g, setup.length, reached, shot->arrival);
    exact_geodesic_free(g);
    shot->length = setup.length;
    shot->miss[0] = to[0] - reached[0];
    shot->miss[1] = to[1] - reached[1];
}

/* Broyden's update of the inverse Jacobian after a step that changed the miss by -change. */
static void learn(double inverse[2][2], const double step[2], const double change[2]) {
    double by[2], row[2];
    for (int k = 0; k < 2; k++) {
        by[k] = inverse[k][0] * change[0] + inverse[k][1] * change[1];
        row[k] = step[0] * inverse[0][k] + step[1] * inverse[1][k];
    }
    double scale = step[0] * by[0] + step[1] * by[1];
    for (int k = 0; k < 4 && scale != 0; k++) {
        inverse[k / 2][k % 2] += (step[k / 2] - by[k / 2]) * row[k % 2] / scale;
    }
}

/* The exponential map is nearly the identity in (u, v) for near points. */
double exact_geodesic_distance(const struct shape *shape, const double from[2], const double to[2],
                               struct vec3 *first, struct vec3 *last) {
    struct shot shot = {.p = {to[0] - from[0], to[1] - from[1]}};
    double inverse[2][2] = {{1, 0}, {0, 1}}, size = fabs(shot.p[0]) + fabs(shot.p[1]);
    double goal = SHOT_GOAL * (size + fabs(to[0]) + fabs(to[1]));
    shoot(shape, from, to, &shot);
    for (int round = 0; round < SHOTS_MAX && fabs(shot.miss[0]) + fabs(shot.miss[1]) > goal;
         round++) {
        double step[2], before[2] = {shot.miss[0], shot.miss[1]};
        for (int k = 0; k < 2; k++) {
            step[k] = inverse[k][0] * before[0] + inverse[k][1] * before[1];
            shot.p[k] += step[k];
        }
        shoot(shape, from, to, &shot);
        learn(inverse, step, (double[2]){before[0] - shot.miss[0], before[1] - shot.miss[1]});
    }
    struct surface_jet jet;
    shape_evaluate(shape, from[0], from[1], &jet);
    struct vec3 t = vec3_unit(vec3_axpy(shot.p[0], jet.u, vec3_scale(shot.p[1], jet.v)));
    if (first) {
        *first = t;
    }
    if (last) {
        shape_evaluate(shape, to[0], to[1], &jet);
        *last = vec3_unit(vec3_axpy(shot.arrival[0], jet.u, vec3_scale(shot.arrival[1], jet.v)));
    }
    return fabs(shot.miss[0]) + fabs(shot.miss[1]) <= 10 * goal ? shot.length : HUGE_VAL;
}
