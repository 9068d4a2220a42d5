/* SPDX-License-Identifier: MIT */
/* The error estimate of gib4 against the error itself, measured by a net four times as fine, on
 * random surfaces and awkward ones that nothing was made for. */
#include "measure.h"
#include "tests/check.h"
#include <stdio.h>
#include <stdlib.h>

enum { RANDOM = 200, FINER = 4 };

static const double CONTAINED = 0.99;
static const double MEDIAN_TIGHTNESS = 30;
/* Rounding: shares of the spacing that are no errors. */
static const double LEAST = 1e-9;

/* What estimates say of errors: nodes, those contained, and estimate / error where that counts. */
struct tally {
    size_t nodes, held, ratios, room;
    double *ratio;
};

static void add_ratio(struct tally *tally, double ratio) {
    if (tally->ratios == tally->room) {
        tally->room = tally->room ? 2 * tally->room : 1024;
        tally->ratio = realloc(tally->ratio, tally->room * sizeof *tally->ratio);
        assert_non_null(tally->ratio);
    }
    tally->ratio[tally->ratios++] = ratio;
}

static int compare(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static double median(struct tally *tally) {
    if (!tally->ratios)
        return 0;
    qsort(tally->ratio, tally->ratios, sizeof *tally->ratio, compare);
    return tally->ratio[tally->ratios / 2];
}

/* Compares a net of `n` cells a side with the fine one of the same generators; what a free edge's
 * yarns do is a choice of each net's own, and not an error. */
static void measure(struct shape *shape, const double uv[2], double angle_deg, double d, int n,
                    struct tally *tally) {
    struct drape_settings settings = {.method = DRAPE_GIB4,
                                      .spacing = {d, d},
                                      .start_kind = DRAPE_START_UV,
                                      .start_uv = {uv[0], uv[1]},
                                      .direction_deg = angle_deg,
                                      .has_extent = {true, true},
                                      .extent = {{-n, n}, {-n, n}},
                                      .max_nodes = 1000000};
    struct drape_run coarse, fine;
    drape_begin(&coarse, shape, &settings);
    for (int k = 0; k < 2; k++) {
        settings.spacing[k] = d / FINER;
        settings.extent[k][0] = -FINER * n;
        settings.extent[k][1] = FINER * n;
    }
    drape_begin(&fine, shape, &settings);
    const struct drape_nodes *some = &coarse.result.nodes, *all = &fine.result.nodes;
    for (size_t k = 0; k < some->count; k++) {
        int at = grid_find(&fine.grid, FINER * some->i[k], FINER * some->j[k]);
        if (at < 0 || some->grown[k] || all->grown[at]) {
            continue;
        }
        double error = vec3_distance(node_point(some, (int)k), node_point(all, at));
        tally->nodes++;
        tally->held += error <= some->error_estimate[k] + LEAST * d;
        if (error > LEAST * d) {
            add_ratio(tally, some->error_estimate[k] / error);
        }
    }
    drape_end(&coarse);
    drape_end(&fine);
}

static double contained(const struct tally *tally) {
    return (double)tally->held / (double)tally->nodes;
}

static void test_exact_estimates_random(void **state) {
    static struct shape shape;
    static const int cells[] = {8, 16, 32};
    (void)state;
    for (int level = 0; level < 3; level++) {
        struct tally tally = {0};
        uint64_t seed = 20261121 + (uint64_t)level;
        int rounds = check_sized(RANDOM, 12);
        for (int round = 0; round < rounds; round++) {
            shape_random(&shape, &seed);
            double uv[2] = {random_between(&seed, 0.3, 0.7), random_between(&seed, 0.3, 0.7)};
            measure(&shape, uv, random_between(&seed, 0, 90), 0.5 / cells[level], cells[level] / 2,
                    &tally);
        }
        double tight = median(&tally);
        printf("  %d random surfaces, d = 0.5 / %d: %.4f of %zu nodes contained, median tightness "
               "%.1f\n",
               rounds, cells[level], contained(&tally), tally.nodes, tight);
        check_at_least(contained(&tally), CONTAINED);
        check_below(tight, MEDIAN_TIGHTNESS);
        free(tally.ratio);
    }
}

static void make_sphere(struct shape *shape) {
    shape_stereographic(shape, 1, (double[2]){-0.6, 0.6}, (double[2]){-0.6, 0.6});
}

static void make_octant(struct shape *shape) {
    shape_sphere(shape, 1, (double[2]){0, M_PI / 2}, (double[2]){0, M_PI / 2}, M_PI / 2);
}

static void make_torus(struct shape *shape) {
    shape_torus(shape, 2, 0.7, (double[2]){0, 2}, (double[2]){-2, 2}, M_PI / 2);
}

static void make_inner_torus(struct shape *shape) {
    shape_torus(shape, 2, 1.2, (double[2]){0, 2}, (double[2]){2, 4.2}, M_PI / 2);
}

static void make_cone(struct shape *shape) {
    shape_frustum(shape, (double[2]){0, 3}, (double[2]){1, 0}, (double[2]){2, 1.5}, M_PI / 2);
}

static void make_saddle(struct shape *shape) {
    shape_quadric(shape, 1.5, -1, (double[2]){-1, 1}, (double[2]){-1, 1});
}

static void make_bowl(struct shape *shape) {
    shape_quadric(shape, 1.2, 0.4, (double[2]){-1, 1}, (double[2]){-1, 1});
}

static void make_roof(struct shape *shape) {
    shape_crease(shape, 1, M_PI / 3);
}

static const struct named {
    const char *name;
    void (*make)(struct shape *shape);
    double uv[2], angle_deg, d;
} named[] = {
    {"sphere", make_sphere, {0, 0}, 20, 0.06},
    {"octant near its pole", make_octant, {0.4, 0.6}, 30, 0.05},
    {"torus, outside", make_torus, {0.5, 0.5}, 45, 0.08},
    {"torus, inside", make_inner_torus, {0.5, 0.5}, 10, 0.08},
    {"cone", make_cone, {0.5, 0.5}, 33, 0.1},
    {"saddle, coarse", make_saddle, {0.1, 0.2}, 15, 0.12},
    {"bowl", make_bowl, {-0.2, 0.1}, 60, 0.06},
    {"roof", make_roof, {0.4, 0.45}, 25, 0.1},
    {"free form", shape_freeform, {0.5, 0.5}, 40, 0.06},
    {"rational bicubic", shape_bezier, {0.5, 0.5}, 70, 0.06},
};

static void test_exact_estimates_named(void **state) {
    static struct shape shape;
    (void)state;
    for (size_t k = 0; k < sizeof named / sizeof *named; k++) {
        const struct named *n = &named[k];
        struct tally tally = {0};
        for (int fine = 1; fine <= 4; fine *= 2) {
            n->make(&shape);
            measure(&shape, n->uv, n->angle_deg, n->d / fine, 10 * fine, &tally);
        }
        printf("  %-22s %.4f of %6zu nodes contained, median tightness %.1f\n", n->name,
               contained(&tally), tally.nodes, median(&tally));
        check_at_least(contained(&tally), CONTAINED);
        free(tally.ratio);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_exact_estimates_random),
        cmocka_unit_test(test_exact_estimates_named),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
