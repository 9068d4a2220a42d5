/* SPDX-License-Identifier: MIT */
/* Generators that are no geodesics, yarn paths by relaxation, trimmed regions, several threads. */
#include "scenes.h"
#include "tests/check.h"
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static const double WIDE[2] = {-1.5, 1.5};
static const enum drape_method methods[] = {DRAPE_BASIC, DRAPE_GIB, DRAPE_GIB4, DRAPE_GEODESIC};

static struct drape_settings settings_at(enum drape_method method, double u, double v, double d) {
    struct drape_settings settings = {.method = method,
                                      .spacing = {d, d},
                                      .start_kind = DRAPE_START_UV,
                                      .start_uv = {u, v},
                                      .max_nodes = 200000};
    return settings;
}

static void limit(struct drape_settings *settings, int n) {
    for (int k = 0; k < 2; k++) {
        settings->has_extent[k] = true;
        settings->extent[k][0] = -n;
        settings->extent[k][1] = n;
    }
}

/* --- generators --- */

/* Where the parabola z = x^2 / 2 is at arc length s from x0: Newton. */
static double parabola_at(double x0, double s) {
    double goal = (x0 * sqrt(1 + x0 * x0) + asinh(x0)) / 2 + s, x = x0 + s;
    for (int k = 0; k < 50; k++) {
        x -= ((x * sqrt(1 + x * x) + asinh(x)) / 2 - goal) / sqrt(1 + x * x);
    }
    return x;
}

/* Errors against r = a(s) + b(t), the net on a translation surface between its own sections. */
static double translation_error(const struct drape_run *run, const double start[2], double d,
                                double *on_generators) {
    const struct drape_nodes *nodes = &run->result.nodes;
    double worst = 0;
    *on_generators = 0;
    for (size_t k = 0; k < nodes->count; k++) {
        double x = parabola_at(start[0], nodes->i[k] * d);
        double y = parabola_at(start[1], nodes->j[k] * d);
        struct vec3 exact = {x, y, (x * x - y * y) / 2};
        double gap = vec3_distance(exact, node_point(nodes, (int)k));
        worst = fmax(worst, gap);
        if (nodes->i[k] == 0 || nodes->j[k] == 0) {
            *on_generators = fmax(*on_generators, gap);
        }
    }
    return worst;
}

static const double SADDLE_START[2] = {0.3, -0.2};
static const double ALONG_X[][2] = {{-1.4, -0.2}, {-0.1, -0.2}, {1.4, -0.2}};
static const double ALONG_Y[][2] = {{0.3, -1.4}, {0.3, 1.4}};

static void by_planes(struct drape_settings *settings) {
    settings->generator[0].kind = DRAPE_GENERATOR_PLANE;
    settings->generator[0].plane_normal = vec3_make(0, 2, 0);
    settings->generator[1].kind = DRAPE_GENERATOR_PLANE;
    settings->generator[1].plane_normal = vec3_make(-1, 0, 0);
}

static void by_curves(struct drape_settings *settings) {
    settings->generator[0].kind = DRAPE_GENERATOR_CURVE;
    settings->generator[0].curve = ALONG_X;
    settings->generator[0].curve_count = 3;
    settings->generator[1].kind = DRAPE_GENERATOR_CURVE;
    settings->generator[1].curve = ALONG_Y;
    settings->generator[1].curve_count = 2;
}

/* Nets of 16 .. `finest` cells a side and the order at least to be seen between them. The patches
 * of the mosaic lie anyhow about the nodes, and are many. */
static const struct study {
    enum drape_method method;
    int finest;
    double order;
} studies[] = {{DRAPE_BASIC, 64, 1.9},
               {DRAPE_GIB, 64, 1.9},
               {DRAPE_GIB4, 64, 3.4},
               {DRAPE_GEODESIC, 64, 1.9},
               {DRAPE_MOSAIC, 32, 1.7}};

/* The error of the net of n cells a side, and of its generators, on the saddle. */
static double section_error(enum drape_method method, int n,
                            void (*choose)(struct drape_settings *settings),
                            double *on_generators) {
    static struct shape shape;
    struct drape_settings settings = settings_at(method, SADDLE_START[0], SADDLE_START[1], 0.8 / n);
    struct drape_run run;
    shape_quadric(&shape, 1, -1, WIDE, WIDE);
    choose(&settings);
    limit(&settings, n);
    assert_int_equal(drape_try(&run, &shape, &settings), STATUS_OK);
    if (method != DRAPE_MOSAIC) /* whose nodes lie on its patches */
        check_result(&shape, &settings, &run);
    assert_int_equal(run.result.nodes.count, (2 * n + 1) * (2 * n + 1));
    double error = translation_error(&run, SADDLE_START, settings.spacing[0], on_generators);
    drape_end(&run);
    return error;
}

/* The sections x = x0 and y = y0 of the saddle are no geodesics, and not at right angles; the net
 * between them is known all the same. */
static void check_sections(void (*choose)(struct drape_settings *settings)) {
    for (size_t k = 0; k < sizeof studies / sizeof *studies; k++) {
        const struct study *study = &studies[k];
        double last = 0;
        printf("  method %d:", (int)study->method);
        for (int n = 16; n <= study->finest; n *= 2) {
            double on_generators, error = section_error(study->method, n, choose, &on_generators);
            printf("  %.1e", error / 0.8);
            if (study->method == DRAPE_GIB || study->method == DRAPE_GEODESIC)
                check_below(on_generators, 1e-11);
            double order = order_of(last, error);
            assert_true(last == 0 || (order > study->order && order < study->order + 1.2));
            last = error;
        }
        printf("\n");
    }
}

static void test_exact_yarns_plane_sections(void **state) {
    (void)state;
    check_sections(by_planes);
}

static void test_exact_yarns_curves(void **state) {
    (void)state;
    check_sections(by_curves);
}

/* Planes through the centre of a sphere cut great circles. */
static void test_exact_yarns_planes_through_centre(void **state) {
    static struct scene scene;
    (void)state;
    for (int id = SCENE_SPHERE; id <= SCENE_SPHERE_FULL; id++) {
        scene_make(&scene, (enum scene_id)id);
        struct drape_settings settings = scene_settings(&scene, DRAPE_GIB, 24);
        struct vec3 out = vec3_unit(vec3_sub(scene.start.r, scene.motion.shift));
        struct drape_run run;
        for (int k = 0; k < 2; k++) {
            settings.generator[k].kind = DRAPE_GENERATOR_PLANE;
            settings.generator[k].plane_normal =
                vec3_scale(k ? 3 : -2, vec3_cross(out, k ? scene.start.weft : scene.start.warp));
        }
        drape_begin(&run, &scene.shape, &settings);
        double gap = sphere_gap(&run, scene.motion.shift, &scene.start, settings.spacing, 24);
        check_below(gap, 1e-10 * 50);
        drape_end(&run);
        scene_free(&scene);
    }
}

/* A plane off the centre cuts a small circle. */
static void test_exact_yarns_small_circle(void **state) {
    static struct shape shape;
    static const double cap[2] = {-0.6, 0.6};
    const double radius = 50, d = 1.1, start_uv[2] = {0.1, 0.2};
    struct vec3 normal = {0, 1, 0};
    (void)state;
    shape_stereographic(&shape, radius, cap, cap);
    struct drape_settings settings = settings_at(DRAPE_GIB, start_uv[0], start_uv[1], d);
    struct drape_run run;
    settings.generator[0].kind = DRAPE_GENERATOR_PLANE;
    settings.generator[0].plane_normal = normal;
    drape_begin(&run, &shape, &settings);
    struct vec3 r = shape_point(&shape, start_uv), centre = {0, r.y, 0};
    struct vec3 out = vec3_sub(r, centre), along = vec3_cross(normal, out);
    double rho = vec3_norm(out);
    int seen = 0;
    for (int i = -30; i <= 30; i++) {
        int at = grid_find(&run.grid, i, 0);
        if (at >= 0) {
            double angle = i * d / rho;
            struct vec3 exact = vec3_axpy(cos(angle), out, vec3_axpy(sin(angle), along, centre));
            check_below(vec3_distance(exact, node_point(&run.result.nodes, at)), 1e-11 * radius);
            seen++;
        }
    }
    check_above(seen, 30);
    drape_end(&run);
}

/* A polyline with a bend on a plane: nodes at their arc lengths along it. */
static void test_exact_yarns_bent_curve(void **state) {
    static struct shape shape;
    static const double square[2] = {-1, 1};
    static const double bend[][2] = {{-0.9, -0.3}, {-0.2, -0.3}, {0.4, 0.5}, {0.9, 0.5}};
    const double d = 0.07;
    (void)state;
    shape_plane(&shape, square, square);
    struct drape_settings settings = settings_at(DRAPE_GIB, -0.5, -0.3, d);
    struct drape_run run;
    settings.generator[0].kind = DRAPE_GENERATOR_CURVE;
    settings.generator[0].curve = bend;
    settings.generator[0].curve_count = 4;
    drape_begin(&run, &shape, &settings);
    for (int i = -5; i <= 20; i++) {
        double left = i * d + 0.4; /* from the first point */
        int at = grid_find(&run.grid, i, 0), k = 0;
        double length = 0.7;
        while (k < 2 && left > length) {
            left -= length;
            k++;
            length = hypot(bend[k + 1][0] - bend[k][0], bend[k + 1][1] - bend[k][1]);
        }
        double share = left / length;
        struct vec3 exact = {bend[k][0] + share * (bend[k + 1][0] - bend[k][0]),
                             bend[k][1] + share * (bend[k + 1][1] - bend[k][1]), 0};
        check_at_least(at, 0);
        check_below(vec3_distance(exact, node_point(&run.result.nodes, at)), 1e-12);
    }
    drape_end(&run);
}

static void test_exact_yarns_impossible_generators(void **state) {
    static struct shape shape;
    struct drape_run run;
    (void)state;
    shape_quadric(&shape, 1, -1, WIDE, WIDE);
    struct drape_settings settings = settings_at(DRAPE_GIB, 0.3, 0.2, 0.1);
    by_curves(&settings); /* through (0.3, -0.2) */
    assert_int_equal(drape_try(&run, &shape, &settings), STATUS_GENERATOR_OFF_START);
    drape_end(&run);
    settings = settings_at(DRAPE_GIB, 0.3, 0.2, 0.1);
    by_planes(&settings);
    settings.generator[1].plane_normal = vec3_make(0, -1, 0);
    assert_int_equal(drape_try(&run, &shape, &settings), STATUS_GENERATOR_PARALLEL);
    drape_end(&run);
}

/* --- the yarn path by relaxation --- */

static double curvature_along(const struct shape *shape, const double uv[2],
                              struct vec3 direction) {
    struct surface_jet jet;
    shape_evaluate(shape, uv[0], uv[1], &jet);
    struct vec3 normal = jet_normal(&jet);
    struct vec3 t = vec3_unit(vec3_axpy(-vec3_dot(direction, normal), normal, direction));
    return jet_second_form(&jet, t, t);
}

/* The largest |edge / promised - 1| of gib's nodes when the tangents at A are those of the
 * geodesics to B and C, by shooting. */
static double relaxed_edges(const struct shape *shape, const struct drape_run *run, double d) {
    const struct drape_nodes *nodes = &run->result.nodes;
    double worst = 0;
    for (size_t k = 0; k < nodes->count; k++) {
        int i = nodes->i[k], j = nodes->j[k], si = i < 0 ? -1 : 1, sj = j < 0 ? -1 : 1;
        int a = grid_find(&run->grid, i - si, j - sj);
        int next[2] = {grid_find(&run->grid, i - si, j), grid_find(&run->grid, i, j - sj)};
        for (int l = 0; l < 2 && i != 0 && j != 0; l++) {
            int far = next[1 - l];
            double from[2] = {nodes->u[a], nodes->v[a]}, to[2] = {nodes->u[far], nodes->v[far]};
            double uv[2] = {nodes->u[next[l]], nodes->v[next[l]]};
            struct vec3 tangent;
            (void)exact_geodesic_distance(shape, from, to, &tangent, NULL);
            double chord = arc_chord(d, curvature_along(shape, uv, tangent));
            double edge = vec3_distance(node_point(nodes, next[l]), node_point(nodes, (int)k));
            worst = fmax(worst, fabs(edge / chord - 1));
        }
    }
    return worst;
}

/* Across parameters whose second derivatives jump (arcs of several spans) the relaxation is of low
 * order; elsewhere it is exact. */
static void test_exact_yarns_relaxation(void **state) {
    static const struct {
        enum scene_id id;
        double tolerance;
    } rows[] = {{SCENE_SPHERE, 1e-10}, {SCENE_SADDLE_OBLIQUE, 1e-10}, {SCENE_ELLIPSOID, 1e-10},
                {SCENE_BEZIER, 1e-10}, {SCENE_FREEFORM, 1e-7},        {SCENE_TORUS, 1e-5},
                {SCENE_CONE, 1e-5}};
    static struct scene scene;
    (void)state;
    for (size_t k = 0; k < sizeof rows / sizeof rows[0]; k++) {
        scene_make(&scene, rows[k].id);
        struct drape_settings settings = scene_settings(&scene, DRAPE_GIB, 8);
        struct drape_run run;
        settings.yarn_path = DRAPE_PATH_RELAXATION;
        drape_begin(&run, &scene.shape, &settings);
        double worst = relaxed_edges(&scene.shape, &run, settings.spacing[0]);
        printf("  %-23s edges %.1e\n", scene.name, worst);
        check_below(worst, rows[k].tolerance);
        drape_end(&run);
        scene_free(&scene);
    }
}

/* --- trims --- */

enum { CORNERS = 5 };

/* A keeping pentagon, and a triangle cut out of it on the way of both generators; in (u, v) of
 * [0, 1]^2. */
static const double outer[CORNERS][2] = {
    {0.1, 0.15}, {0.85, 0.05}, {0.95, 0.7}, {0.5, 0.97}, {0.05, 0.6}};
static const double hole[3][2] = {{0.55, 0.42}, {0.8, 0.62}, {0.48, 0.7}};

static bool in_polygon(const double (*corner)[2], int count, const double uv[2]) {
    bool inside = false;
    for (int a = 0, b = count - 1; a < count; b = a++) {
        const double *p = corner[a], *q = corner[b];
        bool crosses = (p[1] > uv[1]) != (q[1] > uv[1]);
        double at = p[0] + (uv[1] - p[1]) / (q[1] - p[1]) * (q[0] - p[0]);
        inside = crosses && uv[0] < at ? !inside : inside;
    }
    return inside;
}

/* How near uv is to an edge of a polygon, in parameters. */
static double edge_distance(const double (*corner)[2], int count, const double uv[2]) {
    double least = HUGE_VAL;
    for (int a = 0, b = count - 1; a < count; b = a++) {
        double ex = corner[b][0] - corner[a][0], ey = corner[b][1] - corner[a][1];
        double px = uv[0] - corner[a][0], py = uv[1] - corner[a][1];
        double share = fmin(fmax((px * ex + py * ey) / (ex * ex + ey * ey), 0), 1);
        least = fmin(least, hypot(px - share * ex, py - share * ey));
    }
    return least;
}

static struct trim *trim_of(struct shape *shape, struct arena *arena) {
    struct trim_curve curve[2] = {{.degree = 1, .points = outer, .count = CORNERS},
                                  {.degree = 1, .points = hole, .count = 3}};
    struct trim_loop loops[2] = {{.reversed = true, .curves = &curve[0], .count = 1},
                                 {.reversed = false, .curves = &curve[1], .count = 1}};
    struct nurbs nurbs = shape_nurbs(shape);
    struct surface *surface;
    struct trim *trim;
    assert_int_equal(surface_make(&nurbs, arena, &surface), STATUS_OK);
    assert_int_equal(trim_make(surface, loops, 2, arena, &trim), STATUS_OK);
    return trim;
}

/* The trimmed net is the whole one where the region is, on both sides of the hole. */
static void check_trimmed(enum scene_id id, enum drape_method method) {
    static struct scene scene;
    struct arena *arena = arena_new((size_t)64 << 20);
    scene_make(&scene, id);
    struct drape_settings settings = settings_at(method, 0.4, 0.5, scene.side / 20);
    struct drape_run whole, trimmed;
    settings.direction_deg = 25;
    drape_begin(&whole, &scene.shape, &settings);
    const struct trim *trim = trim_of(&scene.shape, arena);
    drape_begin_trimmed(&trimmed, &scene.shape, trim, &settings);
    const struct drape_nodes *all = &whole.result.nodes, *some = &trimmed.result.nodes;
    size_t there = 0;
    struct vec3 centroid;
    double share = cells_area(&trimmed) / trim_area(trim, &centroid);
    for (size_t k = 0; k < all->count; k++) {
        double uv[2] = {all->u[k], all->v[k]};
        bool inside = in_polygon(outer, CORNERS, uv) && !in_polygon(hole, 3, uv);
        bool sure = fmin(edge_distance(outer, CORNERS, uv), edge_distance(hole, 3, uv)) > 1e-9;
        int at = grid_find(&trimmed.grid, all->i[k], all->j[k]);
        there += at >= 0;
        assert_true(!sure || inside == (at >= 0));
        assert_true(at < 0 || vec3_distance(node_point(all, (int)k), node_point(some, at)) <
                                  1e-9 * settings.spacing[0]);
        assert_true(at < 0 || fabs(all->shear_deg[k] - some->shear_deg[at]) < 1e-7);
    }
    printf("  %-20s method %d: %zu of %zu nodes, coverage %.3f\n", scene.name, (int)method, there,
           all->count, trimmed.result.summary.coverage);
    assert_int_equal(there, some->count);
    check_below(fabs(share - trimmed.result.summary.coverage), 0.01);
    assert_int_equal(trimmed.result.summary.front_reasons[DRAPE_REASON_BOUNDARY],
                     trimmed.result.front.count);
    drape_end(&whole);
    drape_end(&trimmed);
    arena_free(arena);
    scene_free(&scene);
}

static void test_exact_yarns_trimmed_is_part_of_whole(void **state) {
    static const enum scene_id ids[] = {SCENE_BEZIER, SCENE_FREEFORM, SCENE_SPHERE_PATCH};
    (void)state;
    for (int k = 0; k < 3; k++) {
        check_trimmed(ids[k], DRAPE_BASIC);
        check_trimmed(ids[k], DRAPE_GIB);
        check_trimmed(ids[k], DRAPE_GEODESIC);
    }
}

/* --- threads --- */

static void run_backwards(void *context, int count, void (*task)(void *data, int k), void *data) {
    (void)context;
    for (int k = count - 1; k >= 0; k--) {
        task(data, k);
    }
}

struct errand {
    void (*task)(void *data, int k);
    void *data;
    int k;
};

static void *run_errand(void *argument) {
    struct errand *errand = argument;
    errand->task(errand->data, errand->k);
    return NULL;
}

static void run_at_once(void *context, int count, void (*task)(void *data, int k), void *data) {
    enum { MOST = 256 };
    pthread_t thread[MOST];
    struct errand errand[MOST];
    (void)context;
    check_at_most(count, MOST);
    for (int k = 0; k < count; k++) {
        errand[k] = (struct errand){task, data, k};
        assert_int_equal(pthread_create(&thread[k], NULL, run_errand, &errand[k]), 0);
    }
    for (int k = 0; k < count; k++) {
        pthread_join(thread[k], NULL);
    }
}

static void check_same_bits(const struct drape_run *a, const struct drape_run *b) {
    const struct drape_nodes *p = &a->result.nodes, *q = &b->result.nodes;
    size_t count = p->count;
    assert_int_equal(count, q->count);
    assert_memory_equal(p->i, q->i, count * sizeof *p->i);
    assert_memory_equal(p->j, q->j, count * sizeof *p->j);
    const double *columns[][2] = {{p->u, q->u}, {p->v, q->v}, {p->x, q->x},
                                  {p->y, q->y}, {p->z, q->z}, {p->shear_deg, q->shear_deg}};
    for (int k = 0; k < 6; k++) {
        assert_memory_equal(columns[k][0], columns[k][1], count * sizeof(double));
    }
    assert_int_equal(a->result.front.count, b->result.front.count);
    assert_memory_equal(a->result.front.reason, b->result.front.reason, a->result.front.count);
    assert_memory_equal(&a->result.summary, &b->result.summary, sizeof a->result.summary);
}

static void test_exact_yarns_threads_give_same_bits(void **state) {
    static const enum scene_id ids[] = {SCENE_SPHERE_FULL, SCENE_TORUS_FULL, SCENE_FREEFORM,
                                        SCENE_CONE};
    static struct scene scene;
    const struct drape_team teams[2] = {{run_backwards, NULL}, {run_at_once, NULL}};
    (void)state;
    for (int k = 0; k < 16; k++) {
        scene_make(&scene, ids[k / 4]);
        struct drape_settings settings = scene_settings(&scene, methods[k % 4], 14);
        struct drape_run alone, together;
        settings.has_extent[0] = settings.has_extent[1] = false;
        drape_begin(&alone, &scene.shape, &settings);
        for (int t = 0; t < 2; t++) {
            settings.team = &teams[t];
            drape_begin(&together, &scene.shape, &settings);
            check_same_bits(&alone, &together);
            drape_end(&together);
        }
        drape_end(&alone);
        scene_free(&scene);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_exact_yarns_plane_sections),
        cmocka_unit_test(test_exact_yarns_curves),
        cmocka_unit_test(test_exact_yarns_planes_through_centre),
        cmocka_unit_test(test_exact_yarns_small_circle),
        cmocka_unit_test(test_exact_yarns_bent_curve),
        cmocka_unit_test(test_exact_yarns_impossible_generators),
        cmocka_unit_test(test_exact_yarns_relaxation),
        cmocka_unit_test(test_exact_yarns_trimmed_is_part_of_whole),
        cmocka_unit_test(test_exact_yarns_threads_give_same_bits),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
