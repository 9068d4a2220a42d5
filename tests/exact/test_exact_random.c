/* SPDX-License-Identifier: MIT */
/* Random rational surfaces, starts, directions and spacings. DRAPED_SEED sets the seed and
 * DRAPED_ROUNDS the number of surfaces; each line that fails says which seed it had. */
#include "march.h"
#include "measure.h"
#include "tests/check.h"
#include <stdio.h>
#include <stdlib.h>

enum { COVER_ROUNDS = 2000, ROUNDS = 100, DEEP_ROUNDS = 20 };
static const uint64_t SEED = 20240229;

static const double SAME_NODES = 1e-9; /* two programs, the same equations; in spacings */

/* What to drape, and what it was made from. */
struct trial {
    uint64_t seed;
    struct shape shape;
    struct drape_settings settings;
    struct vec3 warp, weft;
};

static uint64_t first_seed(void) {
    const char *text = getenv("DRAPED_SEED");
    return text ? strtoull(text, NULL, 10) : SEED;
}

static int rounds_of(int usual) {
    const char *text = getenv("DRAPED_ROUNDS");
    return text ? atoi(text) : check_sized(usual, 4);
}

static void trial_make(struct trial *trial, uint64_t seed) {
    trial->seed = seed;
    shape_random(&trial->shape, &seed);
    struct motion steep = motion_stretch(1, 1, random_between(&seed, 0.5, 4));
    shape_move(&trial->shape, &steep);
    double d = random_between(&seed, 0.04, 0.12);
    struct drape_settings settings = {
        .method = random_unit(&seed) < 0.5 ? DRAPE_BASIC : DRAPE_GIB,
        .spacing = {d, d * random_between(&seed, 0.6, 1.5)},
        .start_kind = DRAPE_START_UV,
        .start_uv = {random_between(&seed, 0.05, 0.95), random_between(&seed, 0.05, 0.95)},
        .direction_deg = random_between(&seed, -180, 180),
        .pre_shear_deg = random_between(&seed, -25, 25),
        .max_nodes = 20000,
    };
    trial->settings = settings;
    shape_frame(&trial->shape, settings.start_uv, settings.direction_deg, settings.pre_shear_deg,
                &trial->warp, &trial->weft);
}

#define CHECK(trial, truth)                                                                        \
    do {                                                                                           \
        if (!(truth)) {                                                                            \
            fail_msg("seed %llu: not %s", (unsigned long long)(trial)->seed, #truth);              \
        }                                                                                          \
    } while (0)

/* Every edge of a basic net is the chord asked for, whoever pinned it; but in cells that are bent
 * as over a fold, which are few, yarns have that length, and chords are less. Returns by how much
 * the worst chord is longer, or 1 when more than one in twenty is shorter. */
static double chord_error(const struct drape_run *run, const double spacing[2]) {
    const struct drape_nodes *nodes = &run->result.nodes;
    double longest = 0;
    size_t edges = 0, shorter = 0;
    for (size_t k = 0; k < 2 * nodes->count; k++) {
        size_t at = k / 2;
        int along = (int)(k % 2);
        int next = grid_find(&run->grid, nodes->i[at] + !along, nodes->j[at] + along);
        if (next >= 0) {
            double edge = vec3_distance(node_point(nodes, (int)at), node_point(nodes, next));
            edges++;
            shorter += edge / spacing[along] < 1 - 1e-11;
            longest = fmax(longest, edge / spacing[along] - 1);
        }
    }
    return 20 * shorter > edges ? 1 : longest;
}

/* The whole surface: it ends, holds together, and does not lie on itself. */
static void test_exact_random_covers(void **state) {
    static struct trial trial;
    static const enum drape_method every[] = {DRAPE_BASIC, DRAPE_GIB, DRAPE_GIB4, DRAPE_GIB,
                                              DRAPE_BASIC, DRAPE_GIB, DRAPE_GIB4, DRAPE_GEODESIC};
    enum { METHODS = sizeof every / sizeof *every };
    double least = 1, mean = 0;
    int rounds = rounds_of(COVER_ROUNDS);
    size_t nodes = 0, lost = 0;
    (void)state;
    printf("  seed %llu\n", (unsigned long long)first_seed());
    for (int round = 0; round < rounds; round++) {
        struct drape_run run;
        trial_make(&trial, first_seed() + (uint64_t)round);
        trial.settings.method = every[round % METHODS];
        drape_begin(&run, &trial.shape, &trial.settings);
        double share = cells_area(&run) / shape_area(&trial.shape);
        double coverage = run.result.summary.coverage;
        CHECK(&trial, fabs(share - coverage) < 0.02);
        CHECK(&trial, share < 1.01);
        CHECK(&trial, trial.settings.method != DRAPE_BASIC ||
                          chord_error(&run, trial.settings.spacing) < 1e-11);
        nodes += run.result.nodes.count;
        lost += run.result.summary.front_reasons[DRAPE_REASON_NO_CONVERGENCE];
        least = fmin(least, coverage);
        mean += coverage / rounds;
        drape_end(&run);
    }
    printf("  coverage: mean %.3f, least %.3f; without convergence %zu of %zu nodes\n", mean, least,
           lost, nodes);
    check_below((double)lost, 1e-4 * (double)nodes);
}

static struct drape_nodes *plain_of(const struct trial *trial, double share, int n) {
    const struct drape_settings *settings = &trial->settings;
    struct plain_setup setup = {
        .shape = &trial->shape,
        .uv = {settings->start_uv[0], settings->start_uv[1]},
        .warp = trial->warp,
        .weft = trial->weft,
        .method = settings->method,
        .spacing = {settings->spacing[0] * share, settings->spacing[1] * share},
        .n = {n, n},
    };
    return plain_make(&setup);
}

/* Whether all nodes lie well inside the domain, where the plain march can go. */
static bool all_inside(const struct drape_nodes *nodes) {
    for (size_t k = 0; k < nodes->count; k++) {
        double least = fmin(fmin(nodes->u[k], 1 - nodes->u[k]), fmin(nodes->v[k], 1 - nodes->v[k]));
        if (!(least > 0.01)) {
            return false;
        }
    }
    return true;
}

/* Makes a trial whose square of n cells to all sides fits the surface: the start in the middle. */
static void trial_make_inside(struct trial *trial, uint64_t seed, int n) {
    uint64_t more = seed + 77;
    trial_make(trial, seed);
    double d = 0.5 / n;
    trial->settings.start_uv[0] = random_between(&more, 0.35, 0.65);
    trial->settings.start_uv[1] = random_between(&more, 0.35, 0.65);
    trial->settings.spacing[1] *= d / trial->settings.spacing[0];
    trial->settings.spacing[0] = d;
    shape_frame(&trial->shape, trial->settings.start_uv, trial->settings.direction_deg,
                trial->settings.pre_shear_deg, &trial->warp, &trial->weft);
    for (int k = 0; k < 12; k++) {
        struct drape_nodes *nodes = plain_of(trial, 1, n);
        bool fits = all_inside(nodes);
        plain_free(nodes);
        if (fits) {
            break;
        }
        trial->settings.spacing[0] *= 0.75;
        trial->settings.spacing[1] *= 0.75;
    }
    for (int k = 0; k < 2; k++) {
        trial->settings.has_extent[k] = true;
        trial->settings.extent[k][0] = -n;
        trial->settings.extent[k][1] = n;
    }
}

/* The largest distance between nodes of two nets with the same indices times `ratio`. */
static double largest_gap(const struct drape_nodes *coarse, const struct drape_nodes *fine,
                          int ratio) {
    struct grid grid;
    double worst = 0;
    grid_make(&grid, fine);
    for (size_t k = 0; k < coarse->count; k++) {
        int at = grid_find(&grid, coarse->i[k] * ratio, coarse->j[k] * ratio);
        check_at_least(at, 0);
        double gap = vec3_distance(node_point(coarse, (int)k), node_point(fine, at));
        worst = fmax(worst, isnan(gap) ? HUGE_VAL : gap);
    }
    grid_free(&grid);
    return worst;
}

/* A trial without rough edges, of which the plain march knows nothing: the curvature does not jump
 * at knots, and changes little from node to node. */
static void trial_make_smooth(struct trial *trial, uint64_t seed, int n) {
    for (uint64_t more = 0; more < 32; more++) {
        trial_make_inside(trial, seed + 1000 * more, n);
        if (trial->shape.degree[0] > 2 && trial->shape.degree[1] > 2) {
            break;
        }
    }
    trial->settings.spacing[0] *= 0.1;
    trial->settings.spacing[1] *= 0.1;
}

/* Node by node what the plain march finds. */
static void test_exact_random_solves_its_equations(void **state) {
    static struct trial trial;
    enum { N = 10 };
    (void)state;
    for (int round = 0; round < rounds_of(ROUNDS); round++) {
        struct drape_run run;
        trial_make_smooth(&trial, first_seed() + 1000 + (uint64_t)round, N);
        const double *spacing = trial.settings.spacing;
        struct drape_nodes *plain = plain_of(&trial, 1, N);
        drape_begin(&run, &trial.shape, &trial.settings);
        const struct drape_nodes *nodes = &run.result.nodes;
        CHECK(&trial, nodes->count == plain->count);
        CHECK(&trial, largest_gap(nodes, plain, 1) < SAME_NODES * spacing[0]);
        CHECK(&trial, measure_edges(&trial.shape, nodes, &run.grid, trial.settings.method,
                                    spacing) < 1e-11);
        plain_free(plain);
        drape_end(&run);
    }
}

/* The integral of K dA over the far quadrant by one point a cell, and the turn of the yarn angle
 * that Hazzidakis' formula says it is. */
static double hazzidakis_miss(const struct trial *trial, const struct drape_run *run, int n) {
    const struct drape_nodes *nodes = &run->result.nodes;
    double sum = 0;
    for (int k = 0; k < n * n; k++) {
        int i = k % n, j = k / n, at[4];
        struct surface_jet jet;
        double uv[2] = {0, 0};
        for (int c = 0; c < 4; c++) {
            at[c] = grid_find(&run->grid, i + c % 2, j + c / 2);
            uv[0] += nodes->u[at[c]] / 4;
            uv[1] += nodes->v[at[c]] / 4;
        }
        shape_evaluate(&trial->shape, uv[0], uv[1], &jet);
        struct vec3 a = vec3_sub(node_point(nodes, at[3]), node_point(nodes, at[0]));
        struct vec3 b = vec3_sub(node_point(nodes, at[2]), node_point(nodes, at[1]));
        sum += jet_gauss(&jet) * vec3_norm(vec3_cross(a, b)) / 2;
    }
    double turned = nodes->shear_deg[grid_find(&run->grid, n, n)] -
                    nodes->shear_deg[grid_find(&run->grid, n, 0)] -
                    nodes->shear_deg[grid_find(&run->grid, 0, n)] +
                    nodes->shear_deg[grid_find(&run->grid, 0, 0)];
    return fabs(sum - turned * M_PI / 180);
}

static void drape_level(const struct trial *trial, int n, int ratio, struct drape_run *run) {
    static struct shape shape;
    struct drape_settings settings = trial->settings;
    shape = trial->shape;
    for (int k = 0; k < 2; k++) {
        settings.spacing[k] /= ratio;
        settings.extent[k][0] = -n * ratio;
        settings.extent[k][1] = n * ratio;
    }
    drape_begin(run, &shape, &settings);
}

/* The common nodes of the finest net, extrapolated by Richardson: r + (r - coarser r) / 3. */
static struct drape_nodes *extrapolated(const struct trial *trial, int n) {
    struct drape_nodes *half = plain_of(trial, 0.5, 2 * n), *limit = plain_of(trial, 0.25, 4 * n);
    struct grid grid;
    grid_make(&grid, limit);
    for (size_t k = 0; k < half->count; k++) {
        int at = grid_find(&grid, 2 * half->i[k], 2 * half->j[k]);
        limit->x[at] += (limit->x[at] - half->x[k]) / 3;
        limit->y[at] += (limit->y[at] - half->y[k]) / 3;
        limit->z[at] += (limit->z[at] - half->z[k]) / 3;
    }
    grid_free(&grid);
    plain_free(half);
    return limit;
}

/* The largest error against the net of `goursat.h`. */
static double collocation_error(const struct trial *trial, const struct drape_nodes *nodes, int n) {
    const struct drape_settings *settings = &trial->settings;
    struct exact_net_setup setup = {
        .shape = &trial->shape,
        .uv = {settings->start_uv[0], settings->start_uv[1]},
        .warp = trial->warp,
        .weft = trial->weft,
        .length = {settings->spacing[0] * n, settings->spacing[1] * n},
        .blocks = 6,
        .order = 8,
    };
    struct reference *exact = reference_net(&setup);
    int all[2] = {n, n};
    double worst = measure_error(nodes, exact, settings->spacing, all).position;
    reference_free(exact);
    return worst;
}

/* Against the exact net, by Richardson extrapolation of the plain march and by collocation, and
 * Hazzidakis' formula, at d, d/2 and d/4. */
static void check_deep(const struct trial *trial, int n) {
    struct drape_run run[3];
    double error[2], miss[3];
    struct drape_nodes *limit = extrapolated(trial, n);
    for (int level = 0; level < 3; level++) {
        drape_level(trial, n, 1 << level, &run[level]);
        miss[level] = hazzidakis_miss(trial, &run[level], n << level);
    }
    error[0] = largest_gap(&run[0].result.nodes, limit, 4);
    error[1] = largest_gap(&run[1].result.nodes, limit, 2);
    double collocated = collocation_error(trial, &run[0].result.nodes, n);
    /* at knots of degrees 2 and 3 curvature or its slope jumps: collocation and one point a cell
     * lose their order there, and extrapolation its sense */
    bool smooth = trial->shape.degree[0] > 3 && trial->shape.degree[1] > 3;
    double order = order_of(error[0], error[1]);
    CHECK(trial, smooth ? order > 1.5 && order < 3.6 : error[1] < 1e-3);
    CHECK(trial, !smooth || fabs(collocated - error[0]) < 0.25 * error[0] + 1e-7);
    CHECK(trial, miss[2] < (smooth ? fmax(miss[0], miss[1]) / 2 + 5e-6 : 2e-3));
    for (int level = 0; level < 3; level++) {
        drape_end(&run[level]);
    }
    plain_free(limit);
}

static void test_exact_random_converges(void **state) {
    static struct trial trial;
    (void)state;
    for (int round = 0; round < rounds_of(DEEP_ROUNDS); round++) {
        trial_make_inside(&trial, first_seed() + 2000 + (uint64_t)round, 8);
        check_deep(&trial, 8);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_exact_random_covers),
        cmocka_unit_test(test_exact_random_solves_its_equations),
        cmocka_unit_test(test_exact_random_converges),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
