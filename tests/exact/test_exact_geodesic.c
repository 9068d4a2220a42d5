/* SPDX-License-Identifier: MIT */
/* The method geodesic: edges are geodesics of the spacing's length, by an independent shooter; so
 * it is exact on developables, creased ones too, and on the sphere equals the recursion. */
#include "scenes.h"
#include "tests/check.h"
#include <stdio.h>
#include <stdlib.h>

/* Geodesic distances, in spacings (docs/mathematics.md, geodesic edges). */
static const double EDGE_TOLERANCE = 1e-10;

static bool is_closed(enum scene_id id) {
    return id == SCENE_SPHERE_FULL || id == SCENE_CYLINDER_FULL || id == SCENE_CONE_FULL ||
           id == SCENE_TORUS_FULL;
}

/* The largest |length / spacing - 1| of all edges between nodes inside; not for closed surfaces,
 * where the shooter would have to know the seam. */
static double geodesic_edges(const struct shape *shape, const struct drape_run *run,
                             const double spacing[2]) {
    const struct drape_nodes *nodes = &run->result.nodes;
    double worst = 0;
    for (size_t k = 0; k < 2 * nodes->count; k++) {
        size_t at = k / 2;
        int along = (int)(k % 2);
        int next = grid_find(&run->grid, nodes->i[at] + !along, nodes->j[at] + along);
        if (next >= 0) {
            double from[2] = {nodes->u[at], nodes->v[at]}, to[2] = {nodes->u[next], nodes->v[next]};
            double length = exact_geodesic_distance(shape, from, to, NULL, NULL);
            if (isinf(length)) { /* missed: the way back may be easier */
                length = exact_geodesic_distance(shape, to, from, NULL, NULL);
            }
            worst = fmax(worst, fabs(length / spacing[along] - 1));
        }
    }
    return worst;
}

static void test_exact_geodesic_edges(void **state) {
    static struct scene scene;
    (void)state;
    for (int id = 0; id < SCENE_COUNT; id++) {
        if (is_closed((enum scene_id)id)) {
            continue;
        }
        scene_make(&scene, (enum scene_id)id);
        struct drape_settings settings = scene_settings(&scene, DRAPE_GEODESIC, check_sized(5, 2));
        struct drape_run run;
        settings.has_extent[0] = settings.has_extent[1] = id == SCENE_TORUS;
        drape_begin(&run, &scene.shape, &settings);
        double worst = geodesic_edges(&scene.shape, &run, settings.spacing);
        printf("  %-23s %zu nodes, edges %.1e\n", scene.name, run.result.nodes.count, worst);
        check_below(worst, EDGE_TOLERANCE);
        drape_end(&run);
        scene_free(&scene);
    }
}

static void test_exact_geodesic_is_great_circle_recursion(void **state) {
    static struct scene scene;
    (void)state;
    for (int id = SCENE_SPHERE; id <= SCENE_SPHERE_SHEARED; id++) {
        scene_make(&scene, (enum scene_id)id);
        struct drape_settings settings = scene_settings(&scene, DRAPE_GEODESIC, 30);
        struct drape_run run;
        drape_begin(&run, &scene.shape, &settings);
        double gap = sphere_gap(&run, scene.motion.shift, &scene.start, settings.spacing, 30);
        check_below(gap, 1e-10 * 50);
        drape_end(&run);
        scene_free(&scene);
    }
}

/* Yarns of a developable's net are geodesics: no error at any spacing. Elsewhere order 2. */
static void test_exact_geodesic_errors(void **state) {
    static struct scene scene;
    (void)state;
    for (int id = 0; id < SCENE_COUNT; id++) {
        double last = 0;
        bool exact = id >= SCENE_PLANE && id <= SCENE_CONE_FULL;
        scene_make(&scene, (enum scene_id)id);
        printf("  %-23s", scene.name);
        for (int n = 8; n <= check_sized(32, 16); n *= 2) {
            struct drape_settings settings = scene_settings(&scene, DRAPE_GEODESIC, n);
            struct drape_run run;
            drape_begin(&run, &scene.shape, &settings);
            size_t row = (size_t)(scene.one_quadrant ? n + 1 : 2 * n + 1);
            assert_int_equal(run.result.nodes.count, row * row);
            struct net_error error = measure_error(&run.result.nodes, scene_reference(&scene),
                                                   settings.spacing, (int[2]){n, n});
            printf("  %.1e %.1e deg", error.position / scene.side, error.shear_deg);
            if (exact) {
                check_below(error.position, 1e-11 * scene.side);
            } else if (last > 0) {
                double order = order_of(last, error.position);
                check_above(order, 1.9);
                check_below(order, 2.1);
            }
            last = error.position;
            drape_end(&run);
        }
        printf("\n");
        scene_free(&scene);
    }
}

/* Two planes: geodesics unfold them, so the net is the square grid on the unfolded plane. */
static void test_exact_geodesic_unfolds_crease(void **state) {
    static struct shape shape;
    static const double rise = 40 * M_PI / 180;
    (void)state;
    shape_crease(&shape, 1, rise);
    for (int angle = 0; angle < 90; angle += 15) {
        struct drape_settings settings = {.method = DRAPE_GEODESIC,
                                          .spacing = {0.06, 0.05},
                                          .start_kind = DRAPE_START_UV,
                                          .start_uv = {0.27, 0.52},
                                          .direction_deg = angle,
                                          .max_nodes = 100000};
        struct drape_run run;
        double c = cos(angle * M_PI / 180), s = sin(angle * M_PI / 180), worst = 0;
        drape_begin(&run, &shape, &settings);
        const struct drape_nodes *nodes = &run.result.nodes;
        struct vec3 start = shape_point(&shape, settings.start_uv);
        for (size_t k = 0; k < nodes->count; k++) {
            double a = nodes->i[k] * settings.spacing[0], b = nodes->j[k] * settings.spacing[1];
            double x = start.x + a * c - b * s, y = start.y + a * s + b * c;
            struct vec3 exact = {x > 0 ? x * cos(rise) : x, y, x > 0 ? x * sin(rise) : 0};
            worst = fmax(worst, vec3_distance(exact, node_point(nodes, (int)k)));
        }
        printf("  at %2d deg: %.1e from the grid, coverage %.3f\n", angle, worst,
               run.result.summary.coverage);
        check_below(worst, 1e-9);
        assert_int_equal(run.result.summary.outcome, DRAPE_COMPLETE);
        drape_end(&run);
    }
}

/* A patch drapes like the whole it was cut from. */
static void test_exact_geodesic_patch_drapes_like_whole(void **state) {
    static struct scene scene;
    static struct shape part;
    static const double u[2] = {-0.6, 0.7}, v[2] = {-0.3, 0.35};
    struct drape_run whole, cut;
    (void)state;
    scene_make(&scene, SCENE_SADDLE_OBLIQUE);
    part = scene.shape;
    shape_cut(&part, u, v);
    struct drape_settings settings = {.method = DRAPE_GEODESIC,
                                      .spacing = {0.05, 0.05},
                                      .start_kind = DRAPE_START_UV,
                                      .start_uv = {0.05, 0.02},
                                      .direction_deg = 30,
                                      .max_nodes = 100000};
    drape_begin(&whole, &scene.shape, &settings);
    drape_begin(&cut, &part, &settings);
    for (size_t k = 0; k < cut.result.nodes.count; k++) {
        int at = grid_find(&whole.grid, cut.result.nodes.i[k], cut.result.nodes.j[k]);
        check_at_least(at, 0);
        double gap = vec3_distance(node_point(&cut.result.nodes, (int)k),
                                   node_point(&whole.result.nodes, at));
        check_below(gap, 1e-9 * 0.05);
    }
    check_above(cut.result.nodes.count, 300);
    drape_end(&whole);
    drape_end(&cut);
    scene_free(&scene);
}

/* Closed surfaces, poles and all: the result holds together, and covers what gib covers. */
static void test_exact_geodesic_covers_like_gib(void **state) {
    static struct scene scene;
    (void)state;
    for (int id = 0; id < SCENE_COUNT; id++) {
        scene_make(&scene, (enum scene_id)id);
        struct drape_settings settings = scene_settings(&scene, DRAPE_GEODESIC, 10);
        struct drape_run geodesic, gib;
        settings.has_extent[0] = settings.has_extent[1] = false;
        drape_begin(&geodesic, &scene.shape, &settings);
        settings.method = DRAPE_GIB;
        drape_begin(&gib, &scene.shape, &settings);
        double difference = geodesic.result.summary.coverage - gib.result.summary.coverage;
        if (!(fabs(difference) < 0.03)) {
            fail_msg("%s: coverage differs by %g", scene.name, difference);
        }
        drape_end(&geodesic);
        drape_end(&gib);
        scene_free(&scene);
    }
}

/* Random rational surfaces: all edges, whoever pinned them. DRAPED_SEED sets the seed. */
static void test_exact_geodesic_random_edges(void **state) {
    static struct shape shape;
    uint64_t first = check_seed(20240310);
    (void)state;
    for (uint64_t round = 0; round < (uint64_t)check_sized(8, 2); round++) {
        uint64_t seed = first + round;
        shape_random(&shape, &seed);
        struct drape_settings settings = {
            .method = DRAPE_GEODESIC,
            .spacing = {0.14, 0.14 * random_between(&seed, 0.7, 1.4)},
            .start_kind = DRAPE_START_UV,
            .start_uv = {random_between(&seed, 0.2, 0.8), random_between(&seed, 0.2, 0.8)},
            .direction_deg = random_between(&seed, -180, 180),
            .pre_shear_deg = random_between(&seed, -25, 25),
            .max_nodes = 20000,
        };
        struct drape_run run;
        drape_begin(&run, &shape, &settings);
        double worst = geodesic_edges(&shape, &run, settings.spacing);
        if (!(worst < EDGE_TOLERANCE)) {
            fail_msg("seed %llu: edges %.1e", (unsigned long long)(first + round), worst);
        }
        drape_end(&run);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_exact_geodesic_edges),
        cmocka_unit_test(test_exact_geodesic_is_great_circle_recursion),
        cmocka_unit_test(test_exact_geodesic_errors),
        cmocka_unit_test(test_exact_geodesic_unfolds_crease),
        cmocka_unit_test(test_exact_geodesic_patch_drapes_like_whole),
        cmocka_unit_test(test_exact_geodesic_covers_like_gib),
        cmocka_unit_test(test_exact_geodesic_random_edges),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
