/* SPDX-License-Identifier: MIT */
/* The references themselves, against closed forms and against each other. */
#include "march.h"
#include "scenes.h"
#include "tests/check.h"
#include <stdio.h>

static const double DEG = M_PI / 180;

/* --- the evaluator --- */

/* The largest deviation of `jet` from central differences of shape_evaluate, relative. */
static double jet_mismatch(const struct shape *shape, double u, double v) {
    const double h = 1e-4;
    struct surface_jet at, up, down;
    double worst = 0;
    shape_evaluate(shape, u, v, &at);
    for (int k = 0; k < 2; k++) {
        double du = k ? 0 : h, dv = k ? h : 0;
        shape_evaluate(shape, u + du, v + dv, &up);
        shape_evaluate(shape, u - du, v - dv, &down);
        struct vec3 first = vec3_scale(0.5 / h, vec3_sub(up.r, down.r));
        struct vec3 second =
            vec3_scale(0.5 / h, k ? vec3_sub(up.v, down.v) : vec3_sub(up.u, down.u));
        struct vec3 mixed =
            vec3_scale(0.5 / h, k ? vec3_sub(up.u, down.u) : vec3_sub(up.v, down.v));
        double size = 1 + vec3_norm(at.uu) + vec3_norm(at.vv) + vec3_norm(at.u) + vec3_norm(at.v);
        worst = fmax(worst, vec3_distance(first, k ? at.v : at.u) / size);
        worst = fmax(worst, vec3_distance(second, k ? at.vv : at.uu) / size);
        worst = fmax(worst, vec3_distance(mixed, at.uv) / size);
    }
    return worst;
}

static void test_exact_reference_derivatives(void **state) {
    static struct shape shape;
    uint64_t seed = 7;
    (void)state;
    for (int round = 0; round < 40; round++) {
        shape_random(&shape, &seed);
        double u = random_between(&seed, 0.01, 0.99), v = random_between(&seed, 0.01, 0.99);
        bool knot_near = false; /* second derivatives may jump there */
        for (int k = 0; k < 2; k++) {
            for (int i = 0; i < shape.size[k]; i++) {
                knot_near = knot_near || fabs(shape.knots[k][i] - (k ? v : u)) < 2e-4;
            }
        }
        assert_true(knot_near || jet_mismatch(&shape, u, v) < 1e-5);
    }
}

/* The solver's evaluator against this one, second derivatives included, beyond the domain too. */
static void test_exact_reference_agrees_with_solver_evaluation(void **state) {
    static struct shape shape;
    uint64_t seed = 11;
    (void)state;
    for (int round = 0; round < 60; round++) {
        shape_random(&shape, &seed);
        struct nurbs nurbs = shape_nurbs(&shape);
        struct arena *arena = arena_new((size_t)64 << 20);
        struct surface *surface;
        struct surface_cursor cursor = {0, 0};
        assert_int_equal(nurbs_validate(&nurbs, NULL), STATUS_OK);
        assert_int_equal(surface_make(&nurbs, arena, &surface), STATUS_OK);
        for (int i = 0; i < 50; i++) {
            double u = random_between(&seed, -0.02, 1.02), v = random_between(&seed, -0.02, 1.02);
            struct surface_jet a, b;
            shape_evaluate(&shape, u, v, &a);
            surface_evaluate(surface, &cursor, u, v, &b);
            double second = vec3_norm(a.uu) + vec3_norm(a.uv) + vec3_norm(a.vv);
            check_below(vec3_distance(a.r, b.r), 1e-12);
            check_below(vec3_distance(a.u, b.u) + vec3_distance(a.v, b.v), 1e-10);
            check_below(vec3_distance(a.uu, b.uu) + vec3_distance(a.uv, b.uv) +
                            vec3_distance(a.vv, b.vv),
                        1e-9 * (1 + second));
        }
        arena_free(arena);
    }
}

static void test_exact_reference_knot_insertion_keeps_shape(void **state) {
    static struct shape shape, split, turned;
    uint64_t seed = 5;
    (void)state;
    for (int round = 0; round < 20; round++) {
        shape_random(&shape, &seed);
        split = shape;
        for (int i = 0; i < 6; i++) {
            shape_insert_knot(&split, i % 2, random_between(&seed, 0.05, 0.95));
        }
        turned = split;
        shape_transpose(&turned);
        for (int i = 0; i < 20; i++) {
            double uv[2] = {random_unit(&seed), random_unit(&seed)}, vu[2] = {uv[1], uv[0]};
            struct vec3 r = shape_point(&shape, uv);
            check_below(vec3_distance(r, shape_point(&split, uv)), 1e-13);
            check_below(vec3_distance(r, shape_point(&turned, vu)), 1e-13);
        }
    }
}

/* --- geodesics --- */

static struct exact_geodesic *line_on(const struct shape *shape, const double uv[2], double angle,
                                      double length) {
    struct exact_geodesic_setup setup = {
        .shape = shape, .uv = {uv[0], uv[1]}, .length = length, .blocks = 8, .order = 16};
    struct vec3 weft;
    shape_frame(shape, uv, angle, 0, &setup.direction, &weft);
    return exact_geodesic_make(&setup);
}

/* Over four quadratic spans, whose parameters are smooth in their first derivatives only. */
static void test_exact_reference_geodesic_is_great_circle(void **state) {
    static struct shape shape;
    const double turn[2] = {0, 350 * DEG}, latitude[2] = {-70 * DEG, 70 * DEG}, uv[2] = {0.1, 0.4};
    struct vec3 warp, weft;
    (void)state;
    shape_sphere(&shape, 50, turn, latitude, M_PI / 2);
    struct vec3 r = shape_point(&shape, uv);
    shape_frame(&shape, uv, 25, 0, &warp, &weft);
    struct exact_geodesic *line = line_on(&shape, uv, 25, 120);
    for (double s = 0; s <= 120; s += 3.7) {
        double at[2];
        exact_geodesic_at(line, s, at, NULL);
        struct vec3 exact = vec3_axpy(50 * sin(s / 50), warp, vec3_scale(cos(s / 50), r));
        check_below(vec3_distance(shape_point(&shape, at), exact), 1e-11 * 50);
    }
    exact_geodesic_free(line);
}

/* Clairaut: rho times the cosine of the angle with the parallel is constant. */
static void test_exact_reference_geodesic_obeys_clairaut(void **state) {
    static struct shape shape;
    const double quarter[2] = {0, 300 * DEG}, full[2] = {0, 360 * DEG}, uv[2] = {0.1, 0.1};
    double first = 0;
    (void)state;
    shape_torus(&shape, 3, 1, quarter, full, M_PI / 2);
    struct exact_geodesic *line = line_on(&shape, uv, 40, 6);
    for (double s = 0; s <= 6; s += 0.1) {
        double at[2], duv[2];
        struct surface_jet jet;
        exact_geodesic_at(line, s, at, duv);
        shape_evaluate(&shape, at[0], at[1], &jet);
        struct vec3 t = vec3_axpy(duv[0], jet.u, vec3_scale(duv[1], jet.v));
        double momentum = jet.r.x * t.y - jet.r.y * t.x;
        first = s == 0 ? momentum : first;
        check_below(fabs(momentum - first), 1e-11);
        check_below(fabs(vec3_norm(t) - 1), 1e-11);
    }
    exact_geodesic_free(line);
}

/* Unfolded, the line over a crease is straight. */
static void test_exact_reference_geodesic_unfolds_crease(void **state) {
    static struct shape shape;
    const double uv[2] = {0.4, 0.45}, rise = 50 * DEG;
    (void)state;
    shape_crease(&shape, 1, rise);
    struct exact_geodesic *line = line_on(&shape, uv, 30, 0.9);
    struct vec3 r = shape_point(&shape, uv);
    for (double s = 0; s <= 0.9; s += 0.05) {
        double at[2], x = r.x + s * cos(30 * DEG), y = r.y + s * sin(30 * DEG);
        struct vec3 exact = {x > 0 ? x * cos(rise) : x, y, x > 0 ? x * sin(rise) : 0};
        exact_geodesic_at(line, s, at, NULL);
        check_below(vec3_distance(shape_point(&shape, at), exact), 1e-13);
    }
    exact_geodesic_free(line);
}

static void test_exact_reference_shooter_measures_distance(void **state) {
    static struct scene scene;
    uint64_t seed = 3;
    (void)state;
    scene_make(&scene, SCENE_SPHERE);
    for (int round = 0; round < 30; round++) {
        double a[2] = {random_between(&seed, -0.3, 0.3), random_between(&seed, -0.3, 0.3)};
        double b[2] = {a[0] + random_between(&seed, 0.01, 0.06), a[1] + 0.03};
        struct vec3 p = shape_point(&scene.shape, a), q = shape_point(&scene.shape, b), first, last;
        double angle = vec3_angle(p, q);
        double distance = exact_geodesic_distance(&scene.shape, a, b, &first, &last);
        check_below(fabs(distance / 50 - angle), 1e-13);
        struct vec3 across = vec3_unit(vec3_cross(p, q));
        check_below(vec3_distance(first, vec3_unit(vec3_cross(across, p))), 1e-11);
        check_below(vec3_distance(last, vec3_unit(vec3_cross(across, q))), 1e-11);
    }
    scene_free(&scene);
}

/* --- the sphere --- */

static void test_exact_reference_sphere_gamma_of_z(void **state) {
    static const double table[][2] = {{0.1, 5.72640},   {0.25, 14.27443}, {0.5, 28.25682},
                                      {0.75, 41.67945}, {1.0, 54.31828},  {1.25, 66.00429},
                                      {1.5, 76.62625}};
    double w, dw;
    (void)state;
    for (size_t k = 0; k < sizeof table / sizeof table[0]; k++) {
        sphere_angle(M_PI / 2, table[k][0], &w, &dw);
        check_below(fabs(90 - w / DEG - table[k][1]), 6e-6);
        sphere_angle(M_PI / 2, -table[k][0], &w, &dw);
        check_below(fabs(90 - w / DEG + table[k][1]), 6e-6);
    }
    check_below(fabs(sphere_collapse(M_PI / 2) - 1.86159), 6e-6);
    /* z w'' + w' = -sin w, w'' by a difference of w' */
    for (double z = 0.05; z < 1.8; z += 0.1) {
        double up, down, at, h = 1e-4;
        sphere_angle(1.3, z + h, &w, &up);
        sphere_angle(1.3, z - h, &w, &down);
        sphere_angle(1.3, z, &w, &at);
        check_below(fabs(z * (up - down) / (2 * h) + at + sin(w)), 1e-7);
    }
}

/* Shear where the diagonal is at a polar angle (degrees) from the start: the paper's figure 8. */
static void test_exact_reference_sphere_gamma_of_polar_angle(void **state) {
    static const double table[][2] = {{10, 0.868},  {30, 7.520},  {45, 16.113},
                                      {60, 26.946}, {75, 39.270}, {90, 52.425}};
    const struct frame start = {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}};
    const double length[2] = {1.2, 1.2};
    (void)state;
    struct reference *reference = reference_sphere(vec3_make(0, 0, 0), 1, &start, length);
    for (size_t k = 0; k < sizeof table / sizeof table[0]; k++) {
        double low = 0, high = 1.2;
        struct exact_net_point at;
        for (int round = 0; round < 50; round++) {
            double s = (low + high) / 2;
            reference_at(reference, s, s, &at);
            *(vec3_angle(at.r, start.r) < table[k][0] * DEG ? &low : &high) = s;
        }
        check_below(fabs(at.shear_deg - table[k][1]), 6e-4);
    }
    reference_free(reference);
}

/* Unit tangents, yarn angle as told, and a point on the sphere. */
static void test_exact_reference_sphere_is_chebyshev(void **state) {
    static struct scene scene;
    (void)state;
    for (int id = SCENE_SPHERE; id <= SCENE_SPHERE_SHEARED; id++) {
        scene_make(&scene, (enum scene_id)id);
        for (double s = -1; s <= 1; s += 0.125) {
            for (double t = -1; t <= 1; t += 0.125) {
                struct exact_net_point at;
                reference_at(scene_reference(&scene), s * scene.length[0], t * scene.length[1],
                             &at);
                double radius = vec3_distance(at.r, scene.motion.shift);
                double shear = 90 - vec3_angle(at.warp, at.weft) / DEG;
                check_below(fabs(radius / 50 - 1), 1e-13);
                check_below(fabs(vec3_norm(at.warp) - 1) + fabs(vec3_norm(at.weft) - 1), 1e-12);
                check_below(fabs(shear - at.shear_deg), 1e-10);
            }
        }
        scene_free(&scene);
    }
}

/* Edges of the discrete net are great circles of the length asked for, and it converges to the
 * smooth one with order 2. */
static void test_exact_reference_sphere_recursion(void **state) {
    static struct vec3 out[65 * 65];
    const struct frame start = {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}};
    const double length[2] = {0.6, 0.5};
    double last = 0;
    (void)state;
    struct reference *reference = reference_sphere(vec3_make(0, 0, 0), 1, &start, length);
    for (int n = 16; n <= 64; n *= 2) {
        double arc[2] = {length[0] / n, length[1] / n}, error = 0;
        sphere_recursion(1, &start, arc, (int[2]){n, n}, out);
        for (int k = 0; k < (n + 1) * (n + 1); k++) {
            int i = k % (n + 1), j = k / (n + 1);
            struct exact_net_point at;
            reference_at(reference, i * arc[0], j * arc[1], &at);
            error = fmax(error, vec3_distance(at.r, out[k]));
            double warp = i ? vec3_distance(out[k], out[k - 1]) : 2 * sin(arc[0] / 2);
            double weft = j ? vec3_distance(out[k], out[k - n - 1]) : 2 * sin(arc[1] / 2);
            check_below(fabs(warp / (2 * sin(arc[0] / 2)) - 1), 1e-11);
            check_below(fabs(weft / (2 * sin(arc[1] / 2)) - 1), 1e-11);
        }
        assert_true(n == 16 || fabs(order_of(last, error) - 2) < 0.05);
        last = error;
    }
    reference_free(reference);
}

/* --- translation surfaces --- */

static void test_exact_reference_saddle_gamma(void **state) {
    static const double table[][2] = {{0.5, 11.53696}, {1, 30}, {1.5, 43.81306}, {2, 53.13010}};
    struct motion none = motion_identity();
    (void)state;
    for (int up = 0; up < 2; up++) {
        struct reference *reference = reference_translation(&none, 1, up ? 1 : -1);
        for (int k = 0; k < 4; k++) {
            double x = table[k][0], s = (x * sqrt(1 + x * x) + asinh(x)) / 2;
            double sine = x * x / (1 + x * x) * (up ? 1 : -1);
            struct exact_net_point at;
            reference_at(reference, s, s, &at);
            check_below(fabs(at.r.x - x) + fabs(at.r.y - x), 1e-13);
            check_below(fabs(fabs(at.shear_deg) - table[k][1]), 6e-6);
            check_below(fabs(at.shear_deg - asin(sine) / DEG), 1e-11);
        }
        reference_free(reference);
    }
}

/* --- the integrator of the general net --- */

static struct exact_net *net_of(const struct scene *scene) {
    struct exact_net_setup setup = {.shape = &scene->smooth,
                                    .uv = {scene->smooth_uv[0], scene->smooth_uv[1]},
                                    .warp = scene->start.warp,
                                    .weft = scene->start.weft,
                                    .length = {scene->length[0], scene->length[1]},
                                    .blocks = 3,
                                    .order = 18};
    return exact_net_make(&setup);
}

/* All closed forms against the general integrator. */
static void test_exact_reference_integrator_meets_closed_forms(void **state) {
    static struct scene scene;
    (void)state;
    for (int id = 0; id <= SCENE_CONE_FULL; id++) {
        if (id == SCENE_SPHERE_EDGE || id == SCENE_SADDLE_SPLIT || id == SCENE_SPHERE_FULL) {
            continue; /* the same surface again; knots cost the integrator its accuracy */
        }
        scene_make(&scene, (enum scene_id)id);
        struct exact_net *net = net_of(&scene);
        double position = 0, shear = 0;
        for (double s = -1; s <= 1; s += 0.125) {
            for (double t = -1; t <= 1; t += 0.125) {
                struct exact_net_point a, b;
                reference_at(scene_reference(&scene), s * scene.length[0], t * scene.length[1], &a);
                exact_net_at(net, s * scene.length[0], t * scene.length[1], &b);
                position = fmax(position, vec3_distance(a.r, b.r) / scene.side);
                shear = fmax(shear, fabs(a.shear_deg - b.shear_deg));
            }
        }
        printf("  %-24s integrator %.1e, %.1e deg\n", scene.name, position, shear);
        check_below(position, 1e-11);
        check_below(shear, 1e-9);
        exact_net_free(net);
        scene_free(&scene);
    }
}

/* The integral of K dA over a quadrant is -[w(s,t) - w(s,0) - w(0,t) + w(0,0)], signs turned where
 * s t < 0. */
static void test_exact_reference_hazzidakis(void **state) {
    static const int general[] = {SCENE_TORUS,          SCENE_TORUS_FULL, SCENE_ELLIPSOID,
                                  SCENE_SADDLE_OBLIQUE, SCENE_BEZIER,     SCENE_FREEFORM};
    static struct scene scene;
    (void)state;
    for (int g = 0; g < 6; g++) {
        scene_make(&scene, (enum scene_id)general[g]);
        const struct exact_net *net = reference_get_net(scene_reference(&scene));
        for (int q = 0; q < 4; q++) {
            int a = q % 2 ? -1 : 1, b = q / 2 ? -1 : 1;
            struct exact_net_point far, s, t, start;
            exact_net_at(net, a * scene.length[0], b * scene.length[1], &far);
            exact_net_at(net, a * scene.length[0], 0, &s);
            exact_net_at(net, 0, b * scene.length[1], &t);
            exact_net_at(net, 0, 0, &start);
            double turned = far.shear_deg - s.shear_deg - t.shear_deg + start.shear_deg;
            double miss = exact_net_curvature(net, a, b) - a * b * turned * DEG;
            check_below(fabs(miss), (general[g] == SCENE_FREEFORM ? 1e-5 : 1e-11));
        }
        scene_free(&scene);
    }
}

/* --- the second march --- */

static void test_exact_reference_march_orders(void **state) {
    static const struct {
        enum scene_id id;
        double basic, gib, gib4; /* at N = 16 */
    } rows[] = {{SCENE_SPHERE, 1.2e-4, 2.8e-5, 4.6e-8}, {SCENE_SADDLE, 1.2e-4, 8.4e-5, 2.1e-7}};
    static struct scene scene;
    (void)state;
    for (int k = 0; k < 6; k++) {
        enum drape_method method = k % 3 == 0 ? DRAPE_BASIC : k % 3 == 1 ? DRAPE_GIB : DRAPE_GIB4;
        double goal = k % 3 == 0   ? rows[k / 3].basic
                      : k % 3 == 1 ? rows[k / 3].gib
                                   : rows[k / 3].gib4;
        double last = 0;
        scene_make(&scene, rows[k / 3].id);
        for (int n = 16; n <= 32; n *= 2) {
            struct plain_setup setup = {
                .shape = &scene.shape,
                .uv = {scene.start_uv[0], scene.start_uv[1]},
                .warp = scene.start.warp,
                .weft = scene.start.weft,
                .method = method,
                .spacing = {scene.length[0] / n, scene.length[1] / n},
                .n = {n, n},
            };
            struct drape_nodes *nodes = plain_make(&setup);
            double error =
                measure_error(nodes, scene_reference(&scene), setup.spacing, setup.n).position;
            error /= scene.side;
            assert_true(n > 16 || (error < 1.5 * goal && error > goal / 1.5));
            assert_true(n == 16 || order_of(last, error) > (method == DRAPE_GIB4 ? 3.3 : 1.9));
            last = error;
            plain_free(nodes);
        }
        scene_free(&scene);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_exact_reference_derivatives),
        cmocka_unit_test(test_exact_reference_agrees_with_solver_evaluation),
        cmocka_unit_test(test_exact_reference_knot_insertion_keeps_shape),
        cmocka_unit_test(test_exact_reference_geodesic_is_great_circle),
        cmocka_unit_test(test_exact_reference_geodesic_obeys_clairaut),
        cmocka_unit_test(test_exact_reference_geodesic_unfolds_crease),
        cmocka_unit_test(test_exact_reference_shooter_measures_distance),
        cmocka_unit_test(test_exact_reference_sphere_gamma_of_z),
        cmocka_unit_test(test_exact_reference_sphere_gamma_of_polar_angle),
        cmocka_unit_test(test_exact_reference_sphere_is_chebyshev),
        cmocka_unit_test(test_exact_reference_sphere_recursion),
        cmocka_unit_test(test_exact_reference_saddle_gamma),
        cmocka_unit_test(test_exact_reference_integrator_meets_closed_forms),
        cmocka_unit_test(test_exact_reference_hazzidakis),
        cmocka_unit_test(test_exact_reference_march_orders),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
