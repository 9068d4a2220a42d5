/* SPDX-License-Identifier: MIT */
/*
 * Nets of gib, basic and geodesic on triangle meshes, against those on the surface that the
 * vertices lie on: they tend to them with more than the second order of the triangles' size, where
 * mosaic's walks tend with the first. Folds of the mesh stay folds.
 */
#include "measure.h"
#include "solver/mesh/fit.h"
#include "tests/check.h"
#include <stdio.h>
#include <stdlib.h>

enum { CELLS_MAX = 64, SIDE = CELLS_MAX + 1, SIZES = 4 };

static double uniform(uint64_t *state) {
    *state = *state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (double)(*state >> 11) * 0x1p-53;
}

/* n x n quadrilaterals over [-1, 1]^2, their diagonals by turns; inner vertices moved by up to
 * `shift` of a quadrilateral. A closed one goes round from 1 to -1 both ways. */
static struct mesh *make_mesh(struct vec3 (*map)(double x, double y), bool closed, int n,
                              double shift, struct arena *arena) {
    static struct vec3 vertices[SIDE * SIDE];
    static int32_t triangles[2 * CELLS_MAX * CELLS_MAX][3];
    uint64_t state = 7;
    int side = closed ? n : n + 1;
    for (int i = 0; i < side; i++)
        for (int j = 0; j < side; j++) {
            bool inner = closed || (i > 0 && j > 0 && i < n && j < n);
            double dx = shift * (2 * uniform(&state) - 1), dy = shift * (2 * uniform(&state) - 1);
            double x = i + (inner ? dx : 0), y = j + (inner ? dy : 0);
            vertices[i * side + j] = map(2 * x / n - 1, 2 * y / n - 1);
        }
    for (int k = 0; k < n * n; k++) {
        int32_t row = k / n * side, up = (k / n + 1) % side * side, right = (k % n + 1) % side;
        int32_t a = row + k % n, b = up + k % n, c = up + right, d = row + right;
        bool turned = (k / n * 7 + k % n * 3) % 2;
        const int32_t two[2][3] = {{a, b, turned ? c : d}, {turned ? a : b, c, d}};
        for (int x = 0; x < 6; x++)
            triangles[2 * k + x / 3][x % 3] = two[x / 3][x % 3];
    }
    struct mesh_source source = {.vertices = vertices,
                                 .vertex_count = (size_t)(side * side),
                                 .triangles = (const int32_t(*)[3])triangles,
                                 .triangle_count = (size_t)(2 * n * n)};
    struct mesh *mesh;
    struct mesh_fault fault;
    assert_int_equal(mesh_make(&source, arena, &mesh, &fault), STATUS_OK);
    return mesh;
}

static struct drape_settings settings_at(enum drape_method method, double d, double angle_deg) {
    double angle = M_PI / 180 * angle_deg;
    return (struct drape_settings){.method = method,
                                   .spacing = {d, 0.8 * d},
                                   .start_kind = DRAPE_START_POINT,
                                   .direction_kind = DRAPE_DIRECTION_VECTOR,
                                   .direction_vector = {cos(angle), sin(angle), 0},
                                   .max_nodes = 100000};
}

/* ---- order ---- */

static const double SQUARE[2] = {-1, 1}, CAP[2] = {-0.4, 0.4};

static struct vec3 saddle(double x, double y) {
    return vec3_make(x, y, (x * x - y * y) / 2);
}

/* The stereographic patch over CAP, moved so that the start is the origin. */
static struct vec3 sphere(double x, double y) {
    double u = CAP[1] * x, v = CAP[1] * y, s = 1 + u * u + v * v;
    return vec3_make(2 * u / s, 2 * v / s, (1 - u * u - v * v) / s);
}

/* The largest distance of nodes at most ten steps from the start. */
static double net_gap(const struct drape_result *result, const struct drape_run *exact) {
    double gap = 0;
    int compared = 0;
    for (size_t k = 0; k < result->nodes.count; k++) {
        int at = grid_find(&exact->grid, result->nodes.i[k], result->nodes.j[k]);
        if (at < 0 || abs(result->nodes.i[k]) > 10 || abs(result->nodes.j[k]) > 10)
            continue;
        gap = fmax(gap, vec3_distance(node_point(&result->nodes, (int)k),
                                      node_point(&exact->result.nodes, at)));
        compared++;
    }
    assert_true(compared > 300);
    return gap;
}

struct subject {
    const char *name;
    struct vec3 (*map)(double x, double y);
    struct vec3 start;
    double spacing, shift;
};

/* Errors for meshes of 8, 16, 32, 64 a side, and their mean order, which is returned. */
static double measure_order(const struct subject *s, struct shape *shape, enum drape_method method,
                            double *finest) {
    struct drape_settings settings = settings_at(method, s->spacing, 30);
    struct drape_run exact;
    double error[SIZES];
    settings.start_point = s->start;
    settings.method = method == DRAPE_MOSAIC ? DRAPE_BASIC : method;
    drape_begin(&exact, shape, &settings);
    settings.method = method;
    printf("  %-7s shift %.2f %-8s", s->name, s->shift,
           method == DRAPE_GIB        ? "gib"
           : method == DRAPE_BASIC    ? "basic"
           : method == DRAPE_GEODESIC ? "geodesic"
                                      : "mosaic");
    for (int k = 0; k < SIZES; k++) {
        struct arena *arena = arena_new((size_t)1 << 28);
        struct drape_result result;
        struct mesh *mesh = make_mesh(s->map, false, 8 << k, s->shift, arena);
        assert_int_equal(
            drape_solve(&(struct drape_part){.mesh = mesh}, &settings, NULL, arena, &result),
            STATUS_OK);
        check_below(result.summary.residual_max, method == DRAPE_GEODESIC ? 1e-4 : 1e-11);
        error[k] = net_gap(&result, &exact);
        printf(" %.1e", error[k]);
        arena_free(arena);
    }
    drape_end(&exact);
    *finest = error[SIZES - 1];
    double order = order_of(error[0], error[SIZES - 1]) / (SIZES - 1);
    printf(" (%.2f)\n", order);
    return order;
}

static void test_exact_mesh_tends_to_its_surface(void **state) {
    (void)state;
    static struct shape shape;
    static const struct subject subjects[] = {{"saddle", saddle, {0, 0, 0}, 0.08, 0},
                                              {"saddle", saddle, {0, 0, 0}, 0.08, 0.25},
                                              {"sphere", sphere, {0, 0, 1}, 0.06, 0},
                                              {"sphere", sphere, {0, 0, 1}, 0.06, 0.25}};
    enum { METHODS = 3 };
    static const enum drape_method methods[METHODS] = {DRAPE_GIB, DRAPE_BASIC, DRAPE_GEODESIC};
    for (size_t k = 0; k < sizeof subjects / sizeof *subjects; k++) {
        const struct subject *s = &subjects[k];
        double flat, finest;
        if (s->map == saddle)
            shape_quadric(&shape, 1, -1, SQUARE, SQUARE);
        else
            shape_stereographic(&shape, 1, CAP, CAP);
        (void)measure_order(s, &shape, DRAPE_MOSAIC, &flat);
        for (int m = 0; m < METHODS; m++) {
            double order = measure_order(s, &shape, methods[m], &finest);
            assert_true(order > 2);
            assert_true(finest < 1e-6 && finest < flat / 100);
        }
    }
}

/* ---- folds ---- */

static double fold_sine, fold_cosine;

/* Two planes that meet at x = 0, where vertices are. */
static struct vec3 roof(double x, double y) {
    return x <= 0 ? vec3_make(x, y, 0) : vec3_make(fold_cosine * x, y, fold_sine * x);
}

/* How far nodes are from the two planes; and, these unrolled, from the square grid. */
struct gaps {
    double planes, grid;
    int sheared; /* nodes and cells of more than 0.01 degrees */
};

static struct gaps measure_gaps(const struct drape_result *result, const double d[2]) {
    struct gaps gaps = {0, 0, 0};
    for (size_t k = 0; k < result->nodes.count; k++) {
        struct vec3 r = node_point(&result->nodes, (int)k), start = result->start_point;
        double beyond = fold_cosine * r.x + fold_sine * r.z, left = fabs(r.z);
        double right = fabs(fold_cosine * r.z - fold_sine * r.x);
        struct vec3 flat = {left < right && r.x < 0 ? r.x : beyond, r.y, 0};
        struct vec3 warp = vec3_scale(d[0] * result->nodes.i[k], result->start_warp);
        struct vec3 weft = vec3_scale(d[1] * result->nodes.j[k], result->start_weft);
        gaps.planes = fmax(gaps.planes, fmin(left, right));
        gaps.grid = fmax(gaps.grid, vec3_distance(flat, vec3_add(start, vec3_add(warp, weft))));
        gaps.sheared += fabs(result->nodes.shear_deg[k]) > 0.01;
    }
    for (size_t k = 0; k < result->cells.count; k++)
        gaps.sheared += fabs(result->cells.shear_deg[k]) > 0.01;
    return gaps;
}

static struct gaps drape_roof(double degrees, double angle_deg, double *coverage) {
    struct arena *arena = arena_new((size_t)1 << 28);
    struct drape_settings settings = settings_at(DRAPE_GIB, 0.05, angle_deg);
    struct drape_result result;
    fold_sine = sin(M_PI / 180 * degrees);
    fold_cosine = cos(M_PI / 180 * degrees);
    settings.start_point = vec3_make(-0.31, 0.02, 0);
    struct mesh *mesh = make_mesh(roof, false, 16, 0, arena);
    assert_int_equal(
        drape_solve(&(struct drape_part){.mesh = mesh}, &settings, NULL, arena, &result),
        STATUS_OK);
    struct gaps gaps = measure_gaps(&result, settings.spacing);
    *coverage = result.summary.coverage;
    arena_free(arena);
    return gaps;
}

/* Sheets folded by 40 to 150 degrees are flat cloth: their nodes are the square grid, however the
 * net lies, and none is sheared but one or two at the rim, between which an edge of the net was not
 * laid over the fold. An edge of 20 degrees is taken for a bend of the surface. */
static void test_exact_mesh_folds_stay_folds(void **state) {
    (void)state;
    static const double folds[] = {20, 40, 60, 90, 120, 150}, angles[] = {0, 20, 45, 70};
    for (int k = 0; k < 24; k++) {
        double degrees = folds[k / 4], coverage;
        struct gaps gaps = drape_roof(degrees, angles[k % 4], &coverage);
        printf(
            "  fold of %3.0f, net at %2.0f: %.1e from the planes, %.1e d from the grid, coverage "
            "%.3f\n",
            degrees, angles[k % 4], gaps.planes, gaps.grid / 0.05, coverage);
        assert_true(coverage > 0.9);
        if (degrees > MESH_FOLD_DEG)
            assert_true(gaps.planes < 1e-9 && gaps.grid < 1e-8 * 0.05 && gaps.sheared <= 4);
        else
            assert_true(gaps.planes > 1e-3 && gaps.grid < 0.2 * 0.05);
    }
}

/* ---- a blade ---- */

static double nose_radius;

/* Two parallel planes a little apart, joined at one edge by half a cylinder: a third of the way
 * each. The flat sheet has s = x on the upper plane, which is x <= 0. */
static struct vec3 blade(double x, double y) {
    double r = nose_radius, angle = M_PI / 2 * (3 * x + 1);
    if (3 * x <= -1)
        return vec3_make((3 * x + 1) / 2, y, r);
    if (3 * x >= 1)
        return vec3_make((1 - 3 * x) / 2, y, -r);
    return vec3_make(r * sin(angle), y, r * cos(angle));
}

static double blade_unrolled(struct vec3 r) {
    double round = nose_radius * atan2(fmax(r.x, 0), r.z);
    return r.x > 0 ? round : r.z > 0 ? r.x : M_PI * nose_radius - r.x;
}

/* Cloth goes round the nose, which is sharper than the spacing, and neither side is taken for the
 * other: a flat sheet that covers all. */
static void test_exact_mesh_of_a_blade(void **state) {
    (void)state;
    static const double radii[] = {0.01, 0.02, 0.03};
    for (int k = 0; k < 9; k++) {
        struct arena *arena = arena_new((size_t)1 << 28);
        struct drape_settings settings = settings_at(DRAPE_GIB, 0.05, 25.0 * (k % 3));
        struct drape_result result;
        nose_radius = radii[k / 3];
        settings.start_point = vec3_make(-0.31, 0.02, nose_radius);
        struct mesh *mesh = make_mesh(blade, false, 48, 0, arena);
        assert_int_equal(
            drape_solve(&(struct drape_part){.mesh = mesh}, &settings, NULL, arena, &result),
            STATUS_OK);
        double gap = 0;
        for (size_t n = 0; n < result.nodes.count; n++) {
            struct vec3 r = node_point(&result.nodes, (int)n);
            struct vec3 flat = {blade_unrolled(r), r.y, nose_radius};
            struct vec3 warp = vec3_scale(0.05 * result.nodes.i[n], result.start_warp);
            struct vec3 weft = vec3_scale(0.04 * result.nodes.j[n], result.start_weft);
            struct vec3 right = vec3_add(result.start_point, vec3_add(warp, weft));
            gap = fmax(gap, vec3_distance(flat, right));
        }
        printf("  nose of %.2f d, net at %2.0f: %.1e d from the grid, coverage %.3f, %.3f\n",
               nose_radius / 0.05, 25.0 * (k % 3), gap / 0.05, result.summary.coverage,
               result.summary.cloth_coverage);
        for (int reason = 0; reason < DRAPE_REASON_COUNT; reason++)
            if (reason != DRAPE_REASON_BOUNDARY)
                assert_int_equal(result.summary.front_reasons[reason], 0);
        check_at_least(result.summary.cloth_coverage, 0.995);
        check_below(gap, 0.25 * 0.05);
        arena_free(arena);
    }
}

/* ---- a torus ---- */

static struct vec3 torus(double x, double y) {
    double rho = 2 + 0.7 * cos(M_PI * y);
    return vec3_make(rho * cos(M_PI * x), rho * sin(M_PI * x), 0.7 * sin(M_PI * y));
}

/* On a mesh that closes both ways the smooth surface of gib carries the net as far as the flat
 * triangles of mosaic do. */
static void test_exact_mesh_of_a_torus_is_covered_as_by_mosaic(void **state) {
    (void)state;
    static const double angles[] = {0, 25, 50, 90};
    for (int k = 0; k < 4; k++) {
        double coverage[2];
        for (int flat = 0; flat < 2; flat++) {
            struct arena *arena = arena_new((size_t)1 << 28);
            struct drape_settings settings =
                settings_at(flat ? DRAPE_MOSAIC : DRAPE_GIB, 0.1, angles[k]);
            struct drape_result result;
            double angle = M_PI / 180 * angles[k];
            settings.start_point = vec3_make(2.7, 0, 0);
            settings.direction_vector = vec3_make(0, cos(angle), sin(angle));
            struct mesh *mesh = make_mesh(torus, true, 48, 0, arena);
            assert_int_equal(
                drape_solve(&(struct drape_part){.mesh = mesh}, &settings, NULL, arena, &result),
                STATUS_OK);
            coverage[flat] = result.summary.cloth_coverage;
            arena_free(arena);
        }
        printf("  net at %2.0f: coverage %.4f, by mosaic %.4f\n", angles[k], coverage[0],
               coverage[1]);
        check_at_least(coverage[0], coverage[1]);
        check_above(coverage[0], 0.9);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_exact_mesh_tends_to_its_surface),
        cmocka_unit_test(test_exact_mesh_folds_stay_folds),
        cmocka_unit_test(test_exact_mesh_of_a_blade),
        cmocka_unit_test(test_exact_mesh_of_a_torus_is_covered_as_by_mosaic),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
