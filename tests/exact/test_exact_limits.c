/* SPDX-License-Identifier: MIT */
/* Inputs at the limits of what is allowed, with nets that are known: degrees 1 and 9, unclamped
 * knots, starts in corners, surfaces far from the origin, extreme spacings. */
#include "scenes.h"
#include "tests/check.h"
#include <stdio.h>
#include <string.h>

static const enum drape_method methods[] = {DRAPE_BASIC, DRAPE_GIB, DRAPE_GIB4, DRAPE_GEODESIC};
static const double SQUARE[2] = {-1, 1};

static struct drape_settings settings_at(enum drape_method method, double u, double v, double d) {
    struct drape_settings settings = {.method = method,
                                      .spacing = {d, d},
                                      .start_kind = DRAPE_START_UV,
                                      .start_uv = {u, v},
                                      .max_nodes = 200000};
    return settings;
}

static void check_same_nodes(struct shape *one, struct shape *two,
                             const struct drape_settings *settings, double scale) {
    struct drape_run a, b;
    drape_begin(&a, one, settings);
    drape_begin(&b, two, settings);
    assert_int_equal(a.result.nodes.count, b.result.nodes.count);
    for (size_t k = 0; k < a.result.nodes.count; k++) {
        assert_int_equal(a.result.nodes.i[k], b.result.nodes.i[k]);
        assert_int_equal(a.result.nodes.j[k], b.result.nodes.j[k]);
        double gap =
            vec3_distance(node_point(&a.result.nodes, (int)k), node_point(&b.result.nodes, (int)k));
        check_below(gap, scale * settings->spacing[0]);
    }
    check_below(fabs(a.result.summary.coverage - b.result.summary.coverage), 1e-6);
    drape_end(&a);
    drape_end(&b);
}

/* One span of degree p in direction 0 becomes degree p + 1:
 * Q_i = i / (p + 1) P_(i-1) + (1 - i / (p + 1)) P_i. */
static void elevate_rows(struct shape *shape) {
    int p = shape->degree[0], row = shape->size[1];
    double first = shape->knots[0][0], last = shape->knots[0][p + 1];
    for (int i = p + 1; i >= 0; i--) {
        double share = (double)i / (p + 1);
        for (int k = 0; k < 4 * row; k++) {
            double before = i > 0 ? shape->h[(i - 1) * row + k / 4][k % 4] : 0;
            double here = i <= p ? shape->h[i * row + k / 4][k % 4] : 0;
            shape->h[i * row + k / 4][k % 4] = share * before + (1 - share) * here;
        }
    }
    shape->degree[0] = p + 1;
    shape->size[0] = p + 2;
    for (int i = 0; i < 2 * (p + 2); i++) {
        shape->knots[0][i] = i < p + 2 ? first : last;
    }
}

static void test_exact_limits_degree_nine(void **state) {
    static struct shape low, high;
    static const double cap[2] = {-0.5, 0.5};
    (void)state;
    for (int m = 0; m < 4; m++) {
        shape_stereographic(&low, 50, cap, cap);
        high = low;
        while (high.degree[0] < NURBS_DEGREE_MAX) {
            elevate_rows(&high);
        }
        shape_transpose(&high);
        while (high.degree[0] < 3 + 2 * m) {
            elevate_rows(&high);
        }
        shape_transpose(&high);
        struct drape_settings settings = settings_at(methods[m], 0.1, -0.2, 3);
        settings.direction_deg = 37;
        check_same_nodes(&low, &high, &settings, 1e-9);
    }
}

/* z = x y is the saddle seen at 45 degrees, and bilinear: of degree 1. */
static void test_exact_limits_degree_one(void **state) {
    static struct shape shape;
    static const double knots[] = {-1, -1, 1, 1};
    (void)state;
    for (int k = 0; k < 2; k++) {
        shape.degree[k] = 1;
        shape.size[k] = 2;
        memcpy(shape.knots[k], knots, sizeof knots);
    }
    for (int i = 0; i < 4; i++) {
        double x = i / 2 ? 1 : -1, y = i % 2 ? 1 : -1, h[4] = {x, y, x * y, 1};
        memcpy(shape.h[i], h, sizeof h);
    }
    struct motion turn = motion_similar(1, vec3_make(0, 0, 1), M_PI / 4, vec3_make(0, 0, 0));
    struct reference *reference = reference_translation(&turn, 1, -1);
    for (int m = 0; m < 4; m++) {
        double last = 0;
        printf("  method %d:", (int)methods[m]);
        for (int n = 16; n <= 64; n *= 2) {
            struct drape_settings settings = settings_at(methods[m], 0, 0, 1.0 / n);
            struct drape_run run;
            settings.direction_deg = 45;
            drape_begin(&run, &shape, &settings);
            double error = measure_error(&run.result.nodes, reference, settings.spacing,
                                         (int[2]){2 * n, 2 * n})
                               .position;
            double order = order_of(last, error);
            printf("  %.1e", error);
            assert_true(last == 0 || order > (methods[m] == DRAPE_GIB4 ? 3.2 : 1.9));
            assert_int_equal(run.result.summary.outcome, DRAPE_COMPLETE);
            last = error;
            drape_end(&run);
        }
        printf("\n");
    }
    reference_free(reference);
}

/* Control points are blossoms of the knots: with those of x^2 and y^2 the quadric comes out
 * whatever the knots, clamped or not. */
static void make_unclamped(struct shape *shape, const double knots[2][9]) {
    for (int k = 0; k < 2; k++) {
        shape->degree[k] = 2;
        shape->size[k] = 6;
        memcpy(shape->knots[k], knots[k], 9 * sizeof(double));
    }
    for (int i = 0; i < 36; i++) {
        const double *u = &knots[0][i / 6], *v = &knots[1][i % 6];
        double z = (u[1] * u[2] - v[1] * v[2]) / 2;
        double h[4] = {(u[1] + u[2]) / 2, (v[1] + v[2]) / 2, z, 1};
        memcpy(shape->h[i], h, sizeof h);
    }
}

static void test_exact_limits_unclamped_knots(void **state) {
    static struct shape clamped, unclamped;
    static const double knots[2][9] = {{-1.9, -1.2, -1, -0.6, 0.1, 0.3, 1, 1.4, 1.5},
                                       {-1.1, -1, -1, -0.2, 0.0, 0.8, 1, 2, 4}};
    (void)state;
    for (int m = 0; m < 4; m++) {
        struct drape_settings settings = settings_at(methods[m], 0.2, 0.1, 0.06);
        settings.direction_deg = -20;
        make_unclamped(&unclamped, knots);
        shape_quadric(&clamped, 1, -1, SQUARE, SQUARE);
        check_same_nodes(&clamped, &unclamped, &settings, 1e-9);
    }
}

/* On a square plane the net is every grid point in it, wherever it starts and points. */
static void check_plane(double x, double y, double angle_deg, const double spacing[2],
                        enum drape_method method) {
    static struct shape shape;
    double a = angle_deg * M_PI / 180;
    struct drape_settings settings = settings_at(method, x, y, spacing[0]);
    struct drape_run run;
    int missing = 0, far = (int)(3 / fmin(spacing[0], spacing[1]));
    double worst = 0;
    settings.spacing[1] = spacing[1];
    settings.direction_deg = angle_deg;
    shape_plane(&shape, SQUARE, SQUARE);
    drape_begin(&run, &shape, &settings);
    for (int i = -far; i <= far; i++) {
        for (int j = -far; j <= far; j++) {
            double s = i * spacing[0], t = j * spacing[1];
            struct vec3 exact = {x + s * cos(a) - t * sin(a), y + s * sin(a) + t * cos(a), 0};
            double depth = 1 - fmax(fabs(exact.x), fabs(exact.y));
            int at = grid_find(&run.grid, i, j);
            missing += depth > 1e-8 && at < 0;
            worst =
                fmax(worst, at < 0 ? 0 : vec3_distance(exact, node_point(&run.result.nodes, at)));
        }
    }
    if (missing > 0 || !(worst < 1e-9)) {
        fail_msg("start (%g, %g), angle %g, spacing %g x %g: %d missing, off by %.1e", x, y,
                 angle_deg, spacing[0], spacing[1], missing, worst);
    }
    drape_end(&run);
}

static void test_exact_limits_starts_on_rim(void **state) {
    static const double starts[][2] = {{-1, -1},  {1, -1},   {1, 1}, {-1, 1},
                                       {0.3, -1}, {-1, 0.9}, {1, 0}};
    const double spacing[2] = {0.09, 0.11};
    (void)state;
    for (size_t k = 0; k < sizeof starts / sizeof starts[0]; k++) {
        for (int angle = -180; angle < 180; angle += 35) {
            check_plane(starts[k][0], starts[k][1], angle, spacing, methods[(angle / 35) & 3]);
        }
        for (int angle = 0; angle < 360; angle += 90) { /* along the rim itself */
            check_plane(starts[k][0], starts[k][1], angle, spacing, methods[k % 4]);
        }
    }
}

static void test_exact_limits_long_cells(void **state) {
    static const double wide[2] = {0.5, 0.02}, tall[2] = {0.015, 0.4};
    (void)state;
    for (int angle = 0; angle < 90; angle += 20) {
        check_plane(0.1, 0.2, angle, wide, methods[(angle / 20) % 4]);
        check_plane(-0.3, 0.6, angle, tall, methods[(angle / 20 + 1) % 4]);
    }
}

/* A spacing longer than the surface: the start alone, and no error. */
static void test_exact_limits_one_node(void **state) {
    static struct shape shape;
    struct drape_run run;
    (void)state;
    for (int m = 0; m < 4; m++) {
        struct drape_settings settings = settings_at(methods[m], 0.1, 0.2, 30);
        shape_quadric(&shape, 0.3, 0.2, SQUARE, SQUARE);
        drape_begin(&run, &shape, &settings);
        assert_int_equal(run.result.nodes.count, 1);
        assert_int_equal(run.result.cells.count, 0);
        assert_true(run.result.summary.coverage == 0);
        drape_end(&run);
    }
}

/* A thousand and a hundred thousand times its size away from the origin: only rounding is lost. */
static void test_exact_limits_far_from_origin(void **state) {
    static struct scene scene;
    static struct shape there;
    (void)state;
    for (int k = 0; k < 8; k++) {
        double away = k / 4 ? 1e5 : 1e3;
        struct motion shift = motion_identity();
        struct drape_run a, b;
        shift.shift = vec3_make(away, -2 * away, 0.7 * away);
        scene_make(&scene, SCENE_BEZIER);
        there = scene.shape;
        shape_move(&there, &shift);
        struct drape_settings settings = scene_settings(&scene, methods[k % 4], 20);
        drape_begin(&a, &scene.shape, &settings);
        drape_begin(&b, &there, &settings);
        assert_int_equal(a.result.nodes.count, b.result.nodes.count);
        double worst = 0;
        for (size_t l = 0; l < a.result.nodes.count; l++) {
            struct vec3 r = vec3_sub(node_point(&b.result.nodes, (int)l), shift.shift);
            worst = fmax(worst, vec3_distance(node_point(&a.result.nodes, (int)l), r));
        }
        printf("  %g away, method %d: %.1e\n", away, (int)methods[k % 4], worst);
        check_below(worst, 1e-12 * away);
        drape_end(&a);
        drape_end(&b);
        scene_free(&scene);
    }
}

/* The start's shear is the pre-shear, up to the widest allowed; the cells collapse or open from
 * there on, and the result holds together. */
static void test_exact_limits_pre_shear(void **state) {
    static struct scene scene;
    (void)state;
    scene_make(&scene, SCENE_BEZIER);
    for (int shear = -80; shear <= 80; shear += 20) {
        struct drape_settings settings = scene_settings(&scene, DRAPE_GIB, 40);
        struct drape_run run;
        settings.has_extent[0] = settings.has_extent[1] = false;
        settings.pre_shear_deg = shear;
        drape_begin(&run, &scene.shape, &settings);
        double start = run.result.nodes.shear_deg[grid_find(&run.grid, 0, 0)];
        check_below(fabs(start - shear), 0.02);
        check_below(cells_area(&run), 1.005 * shape_area(&scene.shape));
        drape_end(&run);
    }
    scene_free(&scene);
}

/* On a cylinder the net is sheared alike everywhere: its cells are as its nodes, although their
 * chords are shorter than their yarns, and by how much depends on the angle between these. */
static void test_exact_limits_pre_shear_of_cells(void **state) {
    static const double turn[2] = {0, 4.5}, low[2] = {1, 0}, high[2] = {1, 4};
    static struct shape cylinder;
    (void)state;
    shape_frustum(&cylinder, turn, low, high, M_PI / 2);
    for (int shear = -60; shear <= 60; shear += 20)
        for (int angle = 0; angle < 180; angle += 25) {
            struct drape_settings settings = settings_at(DRAPE_GEODESIC, 0.5, 0.5, 0.2);
            struct drape_run run;
            double lower[2], upper[2], worst = 0;
            shape_domain(&cylinder, lower, upper);
            for (int k = 0; k < 2; k++)
                settings.start_uv[k] = (lower[k] + upper[k]) / 2;
            settings.direction_deg = angle;
            settings.pre_shear_deg = shear;
            drape_begin(&run, &cylinder, &settings);
            const struct drape_cells *cells = &run.result.cells;
            for (size_t k = 0; k < cells->count; k++)
                worst = fmax(worst, fabs(cells->shear_deg[k] - shear));
            printf("  %d deg at %d: cells off by %.4f deg\n", shear, angle, worst);
            check_above((double)cells->count, 100);
            check_below(worst, 0.01);
            drape_end(&run);
        }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_exact_limits_degree_nine),
        cmocka_unit_test(test_exact_limits_degree_one),
        cmocka_unit_test(test_exact_limits_unclamped_knots),
        cmocka_unit_test(test_exact_limits_starts_on_rim),
        cmocka_unit_test(test_exact_limits_long_cells),
        cmocka_unit_test(test_exact_limits_one_node),
        cmocka_unit_test(test_exact_limits_far_from_origin),
        cmocka_unit_test(test_exact_limits_pre_shear),
        cmocka_unit_test(test_exact_limits_pre_shear_of_cells),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
