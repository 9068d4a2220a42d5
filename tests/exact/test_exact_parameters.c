/* SPDX-License-Identifier: MIT */
/*
 * Parameters measure nothing: however a surface is parametrised, moved and scaled, its net is the
 * same to 1e-9 of its size. Random changes of all kinds at once; DRAPED_SEED sets the seed and
 * DRAPED_ROUNDS the number of surfaces, and what fails says its seed.
 */
#include "disguise.h"
#include "measure.h"
#include "tests/check.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { ROUNDS = 60 };
static const uint64_t SEED = 20261121;
static const double SAME = 1e-9; /* of the surface's size */
static const double SAME_SHEAR =
    0.05; /* degrees: 12 to 30 cells across; the rim is right to 1e-3 */

/* A surface in disguise: what was done to it. */
struct disguise {
    struct shape shape;
    struct motion motion;
    double scale;
    int flips; /* of the normal */
};

static void disguise(struct disguise *d, uint64_t *seed) {
    struct vec3 axis = vec3_make(random_between(seed, -1, 1), random_between(seed, -1, 1), 1);
    struct vec3 shift = vec3_make(random_between(seed, -1, 1), random_between(seed, -1, 1), 0.3);
    d->flips = 0;
    d->flips += disguise_direction(&d->shape, 0, seed);
    d->flips += disguise_direction(&d->shape, 1, seed);
    if (random_unit(seed) < 0.5) {
        shape_transpose(&d->shape);
        d->flips++;
    }
    double weight = disguise_spread(seed, 1e6);
    for (int i = 0; i < d->shape.size[0] * d->shape.size[1]; i++)
        for (int n = 0; n < 4; n++)
            d->shape.h[i][n] *= weight;
    d->scale = disguise_spread(seed, 1000);
    d->motion =
        motion_similar(d->scale, axis, random_between(seed, -3, 3), vec3_scale(d->scale, shift));
    shape_move(&d->shape, &d->motion);
}

static void make_base(struct shape *shape, uint64_t *seed) {
    double r = random_unit(seed), low[2], high[2];
    for (int k = 0; k < 2; k++) {
        low[k] = random_between(seed, -0.6, -0.3);
        high[k] = random_between(seed, 0.3, 0.6);
    }
    const double u[2] = {low[0], high[0]}, v[2] = {low[1], high[1]};
    if (r < 0.4)
        shape_stereographic(shape, 1, u, v);
    else if (r < 0.7)
        shape_quadric(shape, random_between(seed, -2, 2), random_between(seed, -2, 2), u, v);
    else if (r < 0.85)
        shape_freeform(shape);
    else
        shape_bezier(shape);
}

/* Node for node, (i, j) being (i, -j) where the normal is flipped; the largest gap. */
static double gap_between(const struct drape_run *plain, const struct drape_run *other,
                          const struct disguise *d) {
    const struct drape_nodes *nodes = &plain->result.nodes;
    double worst = 0;
    for (size_t k = 0; k < nodes->count; k++) {
        int j = d->flips % 2 ? -nodes->j[k] : nodes->j[k];
        int at = grid_find(&other->grid, nodes->i[k], j);
        if (at < 0)
            return HUGE_VAL;
        struct vec3 wanted = motion_point(&d->motion, node_point(nodes, (int)k));
        worst = fmax(worst, vec3_distance(wanted, node_point(&other->result.nodes, at)));
    }
    return worst / d->scale;
}

static double compare(uint64_t seed, double *size, double *shear_gap_deg) {
    static const enum drape_method every[] = {DRAPE_GIB, DRAPE_BASIC, DRAPE_GIB4, DRAPE_GIB,
                                              DRAPE_GEODESIC};
    static struct shape base;
    static struct disguise other;
    struct drape_run plain, run;
    struct surface_jet jet;
    enum drape_method method = every[seed % 5];
    make_base(&base, &seed);
    double lower[2], upper[2], at[2];
    shape_domain(&base, lower, upper);
    for (int k = 0; k < 2; k++)
        at[k] = lower[k] + random_between(&seed, 0.3, 0.7) * (upper[k] - lower[k]);
    shape_evaluate(&base, at[0], at[1], &jet);
    double d = sqrt(shape_area(&base)) / (method == DRAPE_GEODESIC ? 12 : 30);
    struct drape_settings settings = {.method = method,
                                      .spacing = {d, d},
                                      .start_kind = DRAPE_START_POINT,
                                      .start_point = jet.r,
                                      .direction_kind = DRAPE_DIRECTION_VECTOR,
                                      .max_nodes = 20000};
    settings.direction_vector = vec3_axpy(random_between(&seed, -2, 2), jet.v, jet.u);
    drape_begin(&plain, &base, &settings);
    other.shape = base;
    disguise(&other, &seed);
    settings.start_point = motion_point(&other.motion, settings.start_point);
    settings.direction_vector = motion_vector(&other.motion, settings.direction_vector);
    settings.spacing[0] = settings.spacing[1] = d * other.scale;
    double gap = HUGE_VAL;
    if (drape_try(&run, &other.shape, &settings) == STATUS_OK &&
        run.result.nodes.count == plain.result.nodes.count)
        gap = gap_between(&plain, &run, &other);
    *shear_gap_deg = fabs(plain.result.summary.max_shear_deg - run.result.summary.max_shear_deg);
    struct vec3 low, high;
    surface_bounds(plain.surface, &low, &high);
    *size = vec3_distance(low, high);
    drape_end(&run);
    drape_end(&plain);
    return gap;
}

static void test_exact_parameters_measure_nothing(void **state) {
    const char *rounds_text = getenv("DRAPED_ROUNDS");
    uint64_t first = check_seed(SEED);
    int rounds = rounds_text ? atoi(rounds_text) : ROUNDS, bad = 0;
    double worst = 0, worst_shear = 0;
    (void)state;
    for (int round = 0; round < rounds; round++) {
        double size, shear_gap, gap = compare(first + (uint64_t)round, &size, &shear_gap);
        worst = fmax(worst, gap / size);
        worst_shear = fmax(worst_shear, shear_gap);
        if (shear_gap > SAME_SHEAR) {
            printf("  seed %llu: largest shear %.1e deg apart\n",
                   (unsigned long long)(first + (uint64_t)round), shear_gap);
            bad++;
        }
        if (gap > SAME * size) {
            printf("  seed %llu: nets %.1e of the size apart\n",
                   (unsigned long long)(first + (uint64_t)round), gap / size);
            bad++;
        }
    }
    printf("  largest difference %.1e of the size, of the largest shear %.1e deg\n", worst,
           worst_shear);
    assert_int_equal(bad, 0);
}

/* A sheet whose left half lies in a billionth of its domain: its net is the square grid, and ends
 * at its edge. */
static void test_exact_parameters_narrow_span(void **state) {
    (void)state;
    static struct shape shape;
    const double side[2] = {0, 1}, half[6] = {0, 0, 1e-9, 1, 1}, d = 0.07, angle = M_PI / 6;
    shape_plane(&shape, side, side);
    shape.size[0] = 3;
    memcpy(shape.knots[0], half, sizeof half);
    for (int k = 0; k < 6; k++) {
        const double at[4] = {0.5 * (k / 2), k % 2, 0, 1};
        memcpy(shape.h[k], at, sizeof at);
    }
    struct drape_settings settings = {.method = DRAPE_GIB,
                                      .spacing = {d, d},
                                      .start_kind = DRAPE_START_POINT,
                                      .start_point = {0.6, 0.5, 0},
                                      .direction_kind = DRAPE_DIRECTION_VECTOR,
                                      .direction_vector = {cos(angle), sin(angle), 0},
                                      .max_nodes = 10000};
    struct drape_run run;
    drape_begin(&run, &shape, &settings);
    const struct drape_nodes *n = &run.result.nodes;
    for (size_t k = 0; k < n->count; k++) {
        struct vec3 r = node_point(n, (int)k);
        double x = n->i[k] * d, y = n->j[k] * d;
        check_below(fabs(r.x - (0.6 + cos(angle) * x - sin(angle) * y)), SAME);
        check_below(fabs(r.y - (0.5 + sin(angle) * x + cos(angle) * y)), SAME);
    }
    check_at_least(run.result.summary.cloth_coverage, 0.999);
    drape_end(&run);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_exact_parameters_measure_nothing),
        cmocka_unit_test(test_exact_parameters_narrow_span),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
