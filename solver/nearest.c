/* SPDX-License-Identifier: MIT */
/*
 * The nearest point of a surface: every span that could hold it (its box is not further than the
 * best distance so far) is sampled, and the best samples are polished by Newton's method on
 * f(u, v) = |r(u, v) - q|^2 / 2 inside the domain.
 */
#include "surface_spans.h"

#include <float.h>

enum {
    SEEDS = 6,       /* best samples that are polished */
    SAMPLES = 5,     /* per span and direction */
    NEWTON_MAX = 60, /* far more than ever needed: quadratic from a good sample */
    HALVINGS_MAX = 40
};

struct seed {
    double uv[2], distance;
};

struct search {
    const struct surface *surface;
    struct vec3 target;
    struct surface_cursor cursor;
    struct seed seed[SEEDS]; /* nearest first */
};

static void keep_seed(struct search *search, struct seed seed) {
    for (int k = 0; k < SEEDS; k++)
        if (seed.distance < search->seed[k].distance) {
            struct seed next = search->seed[k];
            search->seed[k] = seed;
            seed = next;
        }
}

/* A lower bound of the distance to a span: that to the box of its control points, which holds the
 * span because the weights are positive. */
static double distance_to_box(const struct surface *surface, size_t span, struct vec3 q) {
    const vec4 *p = surface->points + span * surface->points_per_span;
    double low[3] = {DBL_MAX, DBL_MAX, DBL_MAX}, high[3] = {-DBL_MAX, -DBL_MAX, -DBL_MAX};
    const double at[3] = {q.x, q.y, q.z};
    double sum = 0;
    for (size_t i = 0; i < surface->points_per_span; i++)
        for (int k = 0; k < 3; k++) {
            low[k] = fmin(low[k], p[i][k] / p[i][3]);
            high[k] = fmax(high[k], p[i][k] / p[i][3]);
        }
    for (int k = 0; k < 3; k++) {
        double outside = fmax(0, fmax(low[k] - at[k], at[k] - high[k]));
        sum += outside * outside;
    }
    return sqrt(sum);
}

static void sample_span(struct search *search, int su, int sv) {
    const double *bu = &search->surface->axis[0].breaks[su];
    const double *bv = &search->surface->axis[1].breaks[sv];
    for (int a = 0; a < SAMPLES; a++)
        for (int b = 0; b < SAMPLES; b++) {
            struct seed seed = {.uv = {bu[0] + (bu[1] - bu[0]) * a / (SAMPLES - 1),
                                       bv[0] + (bv[1] - bv[0]) * b / (SAMPLES - 1)}};
            struct surface_jet jet;
            surface_evaluate_span(search->surface, su, sv, seed.uv[0], seed.uv[1], &jet);
            seed.distance = vec3_distance(jet.r, search->target);
            keep_seed(search, seed);
        }
}

static double clamp_to_axis(const struct surface_axis *axis, double x) {
    x = surface_axis_wrap(axis, x);
    return fmin(fmax(x, surface_axis_lower(axis)), surface_axis_upper(axis));
}

/* Whether the descent step -g points out of the domain at a bound that x lies on. */
static bool blocked(const struct surface_axis *axis, double x, double gradient) {
    if (axis->closed)
        return false;
    return (x <= surface_axis_lower(axis) && gradient > 0) ||
           (x >= surface_axis_upper(axis) && gradient < 0);
}

/* Newton's step for f: H step = -g, with H = I + II-terms where that is positive definite, else
 * the first fundamental form alone (Gauss-Newton); a blocked direction stays where it is. */
static void descent_step(const struct surface_jet *jet, struct vec3 offset, const bool fixed[2],
                         double step[2]) {
    double gu = vec3_dot(offset, jet->u), gv = vec3_dot(offset, jet->v);
    double e = vec3_norm2(jet->u), f = vec3_dot(jet->u, jet->v), g = vec3_norm2(jet->v);
    double a = e + vec3_dot(offset, jet->uu), b = f + vec3_dot(offset, jet->uv);
    double c = g + vec3_dot(offset, jet->vv);
    if (!(a > 0.1 * e && c > 0.1 * g && a * c - b * b > 1e-3 * e * g)) {
        a = e;
        b = f;
        c = g;
    }
    if (fixed[0] || fixed[1])
        b = 0;
    double determinant = a * c - b * b;
    bool regular = determinant > 1e-14 * a * c;
    step[0] = fixed[0] || !(a > 0) ? 0 : regular ? -(c * gu - b * gv) / determinant : -gu / a;
    step[1] = fixed[1] || !(c > 0) ? 0 : regular ? -(a * gv - b * gu) / determinant : -gv / c;
}

/* Moves the seed to the local minimum; each step is halved until it helps. */
static void polish(struct search *search, struct seed *seed) {
    const struct surface_axis *axis = search->surface->axis;
    struct surface_jet jet, tried;
    surface_evaluate(search->surface, &search->cursor, seed->uv[0], seed->uv[1], &jet);
    for (int round = 0; round < NEWTON_MAX; round++) {
        struct vec3 offset = vec3_sub(jet.r, search->target);
        bool fixed[2] = {blocked(&axis[0], seed->uv[0], vec3_dot(offset, jet.u)),
                         blocked(&axis[1], seed->uv[1], vec3_dot(offset, jet.v))};
        double step[2], uv[2] = {0, 0}, distance = DBL_MAX;
        descent_step(&jet, offset, fixed, step);
        for (int h = 0; h < HALVINGS_MAX && !(distance < seed->distance); h++) {
            double share = ldexp(1, -h);
            uv[0] = clamp_to_axis(&axis[0], seed->uv[0] + share * step[0]);
            uv[1] = clamp_to_axis(&axis[1], seed->uv[1] + share * step[1]);
            surface_evaluate(search->surface, &search->cursor, uv[0], uv[1], &tried);
            distance = vec3_distance(tried.r, search->target);
        }
        if (!(distance < seed->distance))
            return;
        *seed = (struct seed){.uv = {uv[0], uv[1]}, .distance = distance};
        jet = tried;
    }
}

void surface_nearest(const struct surface *surface, struct vec3 point, double uv[2],
                     double *distance) {
    struct search search = {.surface = surface, .target = point};
    for (int k = 0; k < SEEDS; k++)
        search.seed[k].distance = DBL_MAX;
    int nu = surface->axis[0].span_count, nv = surface->axis[1].span_count;
    for (int su = 0; su < nu; su++)
        for (int sv = 0; sv < nv; sv++)
            if (distance_to_box(surface, (size_t)su * (size_t)nv + (size_t)sv, point) <=
                search.seed[SEEDS - 1].distance)
                sample_span(&search, su, sv);
    struct seed best = {.distance = DBL_MAX};
    for (int k = 0; k < SEEDS; k++) {
        if (search.seed[k].distance < DBL_MAX)
            polish(&search, &search.seed[k]);
        if (search.seed[k].distance < best.distance)
            best = search.seed[k];
    }
    uv[0] = best.uv[0];
    uv[1] = best.uv[1];
    *distance = best.distance;
}
