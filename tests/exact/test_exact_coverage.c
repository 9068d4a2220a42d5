/* SPDX-License-Identifier: MIT */
/* Where the net goes and where it ends: boundaries, seams, poles, creases, collapse. */
#include "chebyshev.h"
#include "scenes.h"
#include "tests/check.h"
#include <stdio.h>
#include <stdlib.h>

static const double DEG = M_PI / 180;

static struct drape_settings settings_at(double u, double v, double angle_deg, double d) {
    struct drape_settings settings = {.method = DRAPE_GIB,
                                      .spacing = {d, d},
                                      .start_kind = DRAPE_START_UV,
                                      .start_uv = {u, v},
                                      .direction_deg = angle_deg,
                                      .max_nodes = 200000};
    return settings;
}

/* The sum of cell areas is what coverage says, and no more than the surface. */
static void check_area(const struct shape *shape, const struct drape_run *run) {
    double share = cells_area(run) / shape_area(shape);
    check_below(fabs(share - run->result.summary.coverage), 0.01);
    check_below(share, 1.005);
}

/* What a net that goes to the boundary everywhere leaves uncovered is a strip narrower than the
 * diagonal of a cell. */
static void check_strip(const struct shape *shape, const struct drape_run *run,
                        const struct drape_settings *settings) {
    double strip = hypot(settings->spacing[0], settings->spacing[1]) * shape_perimeter(shape);
    check_below(1 - run->result.summary.coverage, strip / shape_area(shape));
}

/* --- boundaries --- */

/* A patch of a larger surface, started so that the generators leave it early. */
struct cutting {
    enum scene_id id;
    double cut[2][2], start[2], angle_deg, spacing;
};

static const struct cutting cuttings[] = {
    {SCENE_SPHERE, {{-0.25, 0.3}, {-0.12, 0.15}}, {0.02, 0.01}, 40, 1.5},
    {SCENE_SPHERE, {{-0.1, 0.13}, {-0.3, 0.3}}, {0.05, -0.1}, -30, 1.5},
    {SCENE_SADDLE_OBLIQUE, {{-0.6, 0.7}, {-0.3, 0.35}}, {0.05, 0.02}, 30, 0.04},
    {SCENE_SADDLE_OBLIQUE, {{0.2, 1.0}, {-0.9, 0.4}}, {0.5, 0.2}, 50, 0.04},
    {SCENE_PARABOLOID, {{-0.9, 0.4}, {-0.2, 0.3}}, {-0.2, 0.1}, 45, 0.04},
    {SCENE_CONE, {{0.4, 0.6}, {0.2, 0.6}}, {0.5, 0.3}, 40, 0.06},
    {SCENE_CYLINDER, {{0.45, 0.6}, {0.2, 0.8}}, {0.5, 0.5}, 30, 0.05},
    {SCENE_TORUS, {{0.3, 0.5}, {0.1, 0.35}}, {0.4, 0.2}, 35, 0.04},
    {SCENE_TORUS, {{0.2, 0.9}, {0.3, 0.5}}, {0.55, 0.4}, 50, 0.08},
    {SCENE_ELLIPSOID, {{-0.3, 0.2}, {-0.2, 0.15}}, {-0.1, 0}, 45, 0.03},
    {SCENE_BEZIER, {{0.32, 0.48}, {0.5, 0.8}}, {0.4, 0.7}, 35, 0.02},
};

/* Every node of the whole that lies in the patch is a node of the patch, and the reverse. */
static void check_cutting(const struct cutting *c, enum drape_method method) {
    static struct scene scene;
    static struct shape part;
    struct drape_run whole, cut;
    scene_make(&scene, c->id);
    part = scene.shape;
    shape_cut(&part, c->cut[0], c->cut[1]);
    struct drape_settings settings =
        settings_at(c->start[0], c->start[1], c->angle_deg, c->spacing);
    settings.method = method;
    drape_begin(&whole, &scene.shape, &settings);
    drape_begin(&cut, &part, &settings);
    const struct drape_nodes *all = &whole.result.nodes, *some = &cut.result.nodes;
    int missing = 0, there = 0;
    double gap = 0;
    for (size_t k = 0; k < all->count; k++) {
        double uv[2] = {all->u[k], all->v[k]}, margin = 1;
        for (int l = 0; l < 2; l++) {
            margin = fmin(margin, fmin(uv[l] - c->cut[l][0], c->cut[l][1] - uv[l]));
        }
        int at = grid_find(&cut.grid, all->i[k], all->j[k]);
        if (margin > 1e-9) {
            missing += at < 0;
            there += at >= 0;
        }
        if (at >= 0) {
            gap = fmax(gap, vec3_distance(node_point(all, (int)k), node_point(some, at)));
        }
    }
    printf("  %-23s %4d nodes, %d missing, gap %.1e d\n", scene.name, there, missing,
           gap / c->spacing);
    assert_int_equal(missing, 0);
    check_above(there, 150);
    check_at_most((size_t)there, some->count);
    check_at_most(some->count, (size_t)there + 4);
    check_below(gap, 1e-9 * c->spacing);
    check_area(&part, &cut);
    check_strip(&part, &cut, &settings);
    assert_int_equal(cut.result.summary.outcome, DRAPE_COMPLETE);
    drape_end(&whole);
    drape_end(&cut);
    scene_free(&scene);
}

static void test_exact_coverage_patch_drapes_like_whole(void **state) {
    (void)state;
    for (size_t k = 0; k < sizeof cuttings / sizeof cuttings[0]; k++) {
        check_cutting(&cuttings[k], k % 3 == 2 ? DRAPE_BASIC : DRAPE_GIB);
    }
}

/* The surfaces that a net covers as far as it can be seen: all of them but those that close on
 * themselves, and the torus, round which it collapses. */
static bool has_complete_net(enum scene_id id) {
    return id != SCENE_SPHERE_FULL && id != SCENE_TORUS && id != SCENE_TORUS_FULL &&
           id != SCENE_CYLINDER_FULL && id != SCENE_CONE_FULL;
}

static void test_exact_coverage_is_complete(void **state) {
    static struct scene scene;
    (void)state;
    for (int id = 0; id < SCENE_COUNT; id++) {
        if (!has_complete_net((enum scene_id)id)) {
            continue;
        }
        scene_make(&scene, (enum scene_id)id);
        double last = 0;
        for (int n = 12; n <= 48; n *= 4) {
            struct drape_settings settings = scene_settings(&scene, DRAPE_GIB, n);
            struct drape_run run;
            settings.has_extent[0] = settings.has_extent[1] = false;
            drape_begin(&run, &scene.shape, &settings);
            const struct drape_summary *summary = &run.result.summary;
            assert_int_equal(summary->outcome, DRAPE_COMPLETE);
            assert_int_equal(summary->front_reasons[DRAPE_REASON_BOUNDARY], run.result.front.count);
            assert_true(summary->coverage > last && (n < 48 || summary->coverage > 0.95));
            check_area(&scene.shape, &run);
            check_strip(&scene.shape, &run, &settings);
            last = summary->coverage;
            drape_end(&run);
        }
        scene_free(&scene);
    }
}

/* A strip so long that ghosts cannot carry the net to its ends: yarns go straight on, and all of
 * the strip is covered. */
static void test_exact_coverage_long_strip(void **state) {
    static struct scene scene;
    static struct shape strip;
    static const double u[2] = {-1.45, 1.45}, v[2] = {-0.1, 0.1};
    (void)state;
    scene_make(&scene, SCENE_SADDLE_OBLIQUE);
    for (int angle = -60; angle <= 60; angle += 30) {
        struct drape_settings settings = settings_at(0.1, 0.02, angle, 0.02);
        struct drape_run run;
        strip = scene.shape;
        shape_cut(&strip, u, v);
        drape_begin(&run, &strip, &settings);
        printf("  strip at %3d deg: coverage %.3f\n", angle, run.result.summary.coverage);
        check_area(&strip, &run);
        check_strip(&strip, &run, &settings);
        drape_end(&run);
    }
    scene_free(&scene);
}

/* --- closed surfaces --- */

/* Where node (i, j) of the square grid lies on the unrolled surface about the start, in the scene's
 * unit: along u and along v there. */
static void unrolled(const struct scene *scene, double d, int i, int j, double flat[2]) {
    double c = cos(scene->angle_deg * DEG), s = sin(scene->angle_deg * DEG);
    flat[0] = d * (i * c - j * s);
    flat[1] = d * (i * s + j * c);
}

/* How far before the end of the half period, and how far inside the rims, a place is, in the
 * scene's unit; negative outside. */
struct depth {
    double seam, rim;
};

/* Closed cylinder of radius 2 and length 4, started at half its length. */
static struct depth inside_cylinder(const double flat[2]) {
    return (struct depth){2 * M_PI - fabs(flat[0]), 2 - fabs(flat[1])};
}

/* Closed cone, rho = 0.6 z, z = 2 to 7, started half way: a sector about the apex. */
static struct depth inside_cone(const double flat[2]) {
    double slant = hypot(1, 0.6), sine = 0.6 / slant, along = 4.5 * slant + flat[1];
    double l = hypot(flat[0], along), angle = atan2(flat[0], along);
    return (struct depth){l * (M_PI * sine - fabs(angle)), fmin(l - 2 * slant, 7 * slant - l)};
}

/* On a closed developable the net is known: the square grid within half a turn of the start. */
static void check_closed_developable(enum scene_id id,
                                     struct depth (*inside)(const double flat[2])) {
    static struct scene scene;
    enum { FAR = 300 };
    scene_make(&scene, id);
    struct drape_settings settings = scene_settings(&scene, DRAPE_GIB, 24);
    struct drape_run run;
    double d = settings.spacing[0], unsure = 0.02 * d;
    int missing = 0, excess = 0;
    settings.has_extent[0] = settings.has_extent[1] = false;
    drape_begin(&run, &scene.shape, &settings);
    for (int k = 0; k < (2 * FAR + 1) * (2 * FAR + 1); k++) {
        int i = k % (2 * FAR + 1) - FAR, j = k / (2 * FAR + 1) - FAR;
        double flat[2];
        unrolled(&scene, d, i, j, flat);
        struct depth depth = inside(flat);
        bool there = grid_find(&run.grid, i, j) >= 0;
        missing += !there && fmin(depth.rim, depth.seam) > unsure;
        excess += there && fmin(depth.rim, depth.seam) < -unsure;
    }
    struct net_error error = measure_error(&run.result.nodes, scene_reference(&scene),
                                           settings.spacing, (int[2]){FAR, FAR});
    printf("  %-23s %zu nodes, %d missing, %d in excess, error %.1e d\n", scene.name,
           run.result.nodes.count, missing, excess, error.position / d);
    assert_int_equal(missing, 0);
    assert_int_equal(excess, 0);
    check_below(error.position, unsure / 2);
    check_above(run.result.summary.front_reasons[DRAPE_REASON_FOLD], 0);
    check_above(run.result.summary.front_reasons[DRAPE_REASON_BOUNDARY], 0);
    check_area(&scene.shape, &run);
    drape_end(&run);
    scene_free(&scene);
}

static void test_exact_coverage_closed_cylinder(void **state) {
    (void)state;
    check_closed_developable(SCENE_CYLINDER_FULL, inside_cylinder);
}

static void test_exact_coverage_closed_cone(void **state) {
    (void)state;
    check_closed_developable(SCENE_CONE_FULL, inside_cone);
}

/* Round a torus the net meets itself and may collapse; it must end, and not lie on itself. */
static void test_exact_coverage_closed_torus(void **state) {
    static struct scene scene;
    (void)state;
    scene_make(&scene, SCENE_TORUS_FULL);
    for (int k = 0; k < 8; k++) {
        double d = k < 4 ? 0.15 : 0.075;
        struct drape_settings settings =
            settings_at(0.02 + 0.3 * (k % 4), 0.97 - 0.2 * (k % 4), -50 + 50 * (k % 4), d);
        struct drape_run run;
        settings.max_nodes = (size_t)(2 * shape_area(&scene.shape) / (d * d));
        drape_begin(&run, &scene.shape, &settings);
        printf("  torus: coverage %.3f\n", run.result.summary.coverage);
        check_area(&scene.shape, &run);
        check_above(run.result.summary.coverage, 0.3);
        assert_int_equal(run.result.summary.front_reasons[DRAPE_REASON_BOUNDARY], 0);
        drape_end(&run);
    }
    scene_free(&scene);
}

/* --- poles --- */

static const double RADIUS = 50;
/* Distance from the exact discrete net. Next to a pole r_u is short, and its direction no better
 * than rounding over its length. */
static const double ANYWHERE = 1e-10, NEAR_POLE = 2e-8;

static void make_full_sphere(struct shape *shape) {
    static const double full[2] = {0, 360 * M_PI / 180}, poles[2] = {-M_PI / 2, M_PI / 2};
    shape_sphere(shape, RADIUS, full, poles, M_PI / 2);
}

/* The start's frame from longitude and latitude, also at the poles, where for r_u the tangent r_v
 * stands in: it points away from the longitude at the north pole, along it at the south. */
static struct frame sphere_frame(double turn, double latitude, double angle_deg) {
    struct vec3 out = {cos(turn), sin(turn), 0}, round = {-sin(turn), cos(turn), 0};
    struct vec3 normal = vec3_axpy(cos(latitude), out, vec3_make(0, 0, sin(latitude)));
    struct vec3 up = vec3_axpy(-sin(latitude), out, vec3_make(0, 0, cos(latitude)));
    struct vec3 first = fabs(latitude) > M_PI / 2 - 1e-12 ? up : round;
    struct vec3 across = vec3_cross(normal, first);
    double a = angle_deg * DEG;
    struct frame frame = {vec3_scale(RADIUS, normal),
                          vec3_axpy(sin(a), across, vec3_scale(cos(a), first)),
                          vec3_axpy(cos(a), across, vec3_scale(-sin(a), first))};
    return frame;
}

/* On the full sphere from (u, v), L = 0.6 R to all sides: the same net wherever the poles are. */
static void check_pole(double u, double v, double angle_deg) {
    static struct shape shape;
    enum { N = 20 };
    double uv[2] = {u, v}, equator[2] = {u, 0.5}, d = 0.6 * RADIUS / N;
    double near = fmin(v, 1 - v), allowed = near > 0 && near < 1e-4 ? NEAR_POLE : ANYWHERE;
    make_full_sphere(&shape);
    struct vec3 r = shape_point(&shape, uv), side = shape_point(&shape, equator);
    struct drape_settings settings = settings_at(u, v, angle_deg, d);
    struct drape_run run;
    for (int k = 0; k < 2; k++) {
        settings.has_extent[k] = true;
        settings.extent[k][0] = -N;
        settings.extent[k][1] = N;
    }
    double latitude = v == 1 ? M_PI / 2 : v == 0 ? -M_PI / 2 : atan2(r.z, hypot(r.x, r.y));
    struct frame start = sphere_frame(atan2(side.y, side.x), latitude, angle_deg);
    drape_begin(&run, &shape, &settings);
    double gap = sphere_gap(&run, vec3_make(0, 0, 0), &start, settings.spacing, N);
    if (run.result.nodes.count != (2 * N + 1) * (2 * N + 1) || gap > allowed * RADIUS) {
        fail_msg("start (%g, %g), angle %g: %zu nodes, %.1e R", u, v, angle_deg,
                 run.result.nodes.count, gap / RADIUS);
    }
    drape_end(&run);
}

static void test_exact_coverage_start_on_pole(void **state) {
    (void)state;
    for (int angle = -90; angle <= 180; angle += 18) {
        check_pole(0, 1, angle);
        check_pole(0.3, 1, angle);
        check_pole(0.62, 0, angle);
        check_pole(1, 0, angle);
    }
}

static void test_exact_coverage_start_near_pole(void **state) {
    (void)state;
    for (int k = 1; k <= 9; k++) {
        double near = pow(10, -k);
        for (int angle = -45; angle <= 90; angle += 27) {
            check_pole(0.37, 1 - near, angle);
            check_pole(0.81, near, angle);
        }
    }
}

/* A pole anywhere in the net: on a generator, on a node, inside a cell. */
static void test_exact_coverage_passes_poles(void **state) {
    uint64_t seed = 17;
    (void)state;
    check_pole(0.2, 0.9, 90); /* warp goes over the north pole */
    check_pole(0.2, 0.1, 0);  /* weft over the south */
    check_pole(0.5, 0.8, 45);
    for (int k = 0; k < 30; k++) {
        double u = random_unit(&seed), angle = random_between(&seed, -180, 180);
        double from_pole = random_between(&seed, 0, 0.2); /* of v: up to 0.6 R away */
        check_pole(u, random_unit(&seed) < 0.5 ? from_pole : 1 - from_pole, angle);
    }
}

/* --- creases --- */

/* An extrusion along y of a profile in the (x, z) plane: u runs along the profile. Degree 2 with
 * control points (x_i, z_i). */
static void make_extrusion(struct shape *shape, int size, const double *knots,
                           const double (*xz)[2]) {
    static const double kv[] = {0, 0, 1, 1};
    shape->degree[0] = 2;
    shape->degree[1] = 1;
    shape->size[0] = size;
    shape->size[1] = 2;
    for (int i = 0; i < size + 3; i++) {
        shape->knots[0][i] = knots[i];
    }
    for (int i = 0; i < 4; i++) {
        shape->knots[1][i] = kv[i];
    }
    for (int i = 0; i < 2 * size; i++) {
        double h[4] = {xz[i / 2][0], i % 2 ? 1 : -1, xz[i / 2][1], 1};
        for (int c = 0; c < 4; c++) {
            shape->h[i][c] = h[c];
        }
    }
}

/* Length of the profile from its start to u: Clenshaw-Curtis sums between the knots. */
static double profile_length(const struct shape *shape, double u) {
    struct chebyshev rule;
    double sum = 0;
    chebyshev_make(&rule, 16);
    for (int i = 2; i < shape->size[0]; i++) {
        double low = shape->knots[0][i], high = fmin(u, shape->knots[0][i + 1]);
        for (int k = 0; k < rule.n && high > low; k++) {
            struct surface_jet jet;
            shape_evaluate(shape, low + rule.x[k] * (high - low), 0.5, &jet);
            sum += (high - low) * rule.integral[rule.n - 1][k] * vec3_norm(jet.u);
        }
    }
    return sum;
}

/* The largest distance of a node from the unrolled square grid, in spacings. */
static double unrolled_error(const struct shape *shape, const struct drape_run *run,
                             const struct drape_settings *settings) {
    double c = cos(settings->direction_deg * DEG), s = sin(settings->direction_deg * DEG);
    double d = settings->spacing[0], x0 = profile_length(shape, settings->start_uv[0]), worst = 0;
    const struct drape_nodes *nodes = &run->result.nodes;
    for (size_t k = 0; k < nodes->count; k++) {
        double x = profile_length(shape, nodes->u[k]) - x0, y = 2 * nodes->v[k] - 1;
        double ex = d * (nodes->i[k] * c - nodes->j[k] * s);
        double ey = 2 * settings->start_uv[1] - 1 + d * (nodes->i[k] * s + nodes->j[k] * c);
        worst = fmax(worst, hypot(x - ex, y - ey) / d);
    }
    return worst;
}

/* Errors at d and d/4 of both methods; the net goes everywhere. */
static void check_extrusion(const char *name, struct shape *shape, double angle_deg,
                            double errors[2]) {
    for (int level = 0; level < 2; level++) {
        struct drape_settings settings = settings_at(0.27, 0.52, angle_deg, level ? 0.0125 : 0.05);
        struct drape_run run;
        drape_begin(&run, shape, &settings);
        errors[level] = unrolled_error(shape, &run, &settings) * settings.spacing[0];
        printf("  %-8s at %3g deg: coverage %.3f, %.1e from the grid\n", name, angle_deg,
               run.result.summary.coverage, errors[level]);
        assert_int_equal(run.result.summary.outcome, DRAPE_COMPLETE);
        check_area(shape, &run);
        check_strip(shape, &run, &settings);
        drape_end(&run);
    }
}

/* Over an edge of 40 degrees yarns are laid unfolded: no error but rounding. */
static void test_exact_coverage_crosses_crease(void **state) {
    static struct shape shape;
    (void)state;
    for (int angle = 0; angle <= 80; angle += 20) {
        double errors[2];
        shape_crease(&shape, 1, 40 * DEG);
        check_extrusion("crease", &shape, angle, errors);
        check_below(errors[0], 1e-12);
        check_below(errors[1], 1e-12);
    }
}

/* A plane that goes over into an arc: a jump of curvature at a simple knot. */
static void test_exact_coverage_crosses_curvature_jump(void **state) {
    static struct shape shape;
    static const double knots[] = {0, 0, 0, 0.5, 1, 1, 1};
    static const double xz[][2] = {{-1, 0}, {-0.5, 0}, {0.5, 0}, {1, 0.8}};
    (void)state;
    for (int angle = 0; angle <= 80; angle += 20) {
        double errors[2];
        make_extrusion(&shape, 4, knots, xz);
        check_extrusion("jump", &shape, angle, errors);
        check_below(errors[0], 0.002);
        check_below(errors[1], errors[0] / 8);
    }
}

/* --- collapse --- */

/* z = s t / R^2 up to 2.4 in all quadrants: the net collapses at 1.86159 and is whole before. */
static void test_exact_coverage_collapse(void **state) {
    static struct shape shape;
    enum { N = 62 };
    double d = RADIUS * 1.55 / N, unit = d * d / (RADIUS * RADIUS), collapse;
    (void)state;
    collapse = sphere_collapse(M_PI / 2);
    make_full_sphere(&shape);
    for (int angle = 0; angle <= 30; angle += 30) {
        struct drape_settings settings = settings_at(0.1, 0.5, angle, d);
        struct drape_run run;
        double reached = 0, least = HUGE_VAL;
        for (int k = 0; k < 2; k++) {
            settings.has_extent[k] = true;
            settings.extent[k][0] = -N;
            settings.extent[k][1] = N;
        }
        drape_begin(&run, &shape, &settings);
        for (int i = -N; i <= N; i++) {
            for (int j = -N; j <= N; j++) {
                bool there = grid_find(&run.grid, i, j) >= 0;
                double z = abs(i * j) * unit;
                assert_true(there || z > 0.93 * collapse);
                reached = fmax(reached, there ? z : 0);
            }
        }
        for (size_t k = 0; k < run.result.front.count; k++) {
            if (run.result.front.reason[k] == DRAPE_REASON_COLLAPSED) {
                least = fmin(least, abs(run.result.front.i[k] * run.result.front.j[k]) * unit);
            }
        }
        printf("  collapse: nodes to z = %.3f, front from %.3f, exact %.5f\n", reached, least,
               collapse);
        check_above(reached, 0.97 * collapse);
        check_below(reached, 1.03 * collapse);
        check_above(least, 0.93 * collapse);
        check_below(least, 1.03 * collapse);
        check_above(run.result.summary.max_shear_deg, 85);
        assert_int_equal(run.result.summary.outcome, DRAPE_PARTIAL);
        drape_end(&run);
    }
}

/* A whole sphere: four collapsed corners, the rest covered once. */
static void test_exact_coverage_full_sphere(void **state) {
    static struct shape shape;
    (void)state;
    make_full_sphere(&shape);
    for (int k = 0; k < 6; k++) {
        struct drape_settings settings =
            settings_at(0.1 + 0.15 * k, 0.5 + 0.1 * k, 15 * k, RADIUS * 0.08);
        struct drape_run run;
        drape_begin(&run, &shape, &settings);
        printf("  sphere: coverage %.3f\n", run.result.summary.coverage);
        check_above(run.result.summary.coverage, 0.9);
        check_area(&shape, &run);
        drape_end(&run);
    }
}

/* A band of a sphere, on which the yarns collapse before the cut opposite the start: what grows on
 * from there does not lie on cloth. */
static void test_exact_coverage_band(void **state) {
    static const double turn[2] = {0, 2 * M_PI}, band[2] = {-50 * M_PI / 180, 50 * M_PI / 180};
    static struct shape shape;
    (void)state;
    shape_sphere(&shape, 1, turn, band, M_PI / 2);
    for (int k = 0; k < 2; k++) {
        struct drape_settings settings = settings_at(0.3, 0.4, 20 + 30 * k, 0.02);
        struct drape_run run;
        drape_begin(&run, &shape, &settings);
        double layers = cells_area(&run) / (4 * M_PI * sin(50 * DEG));
        printf("  band: cells of %.4f of its area, cloth %.4f\n", layers,
               run.result.summary.cloth_coverage);
        check_above(run.result.summary.cloth_coverage, 0.95);
        check_below(layers, run.result.summary.cloth_coverage + 2e-3);
        drape_end(&run);
    }
}

/* --- degenerate places --- */

/* A biquadratic patch whose corner (0, 0) has parallel edges: no tangent plane there. With `point`
 * both edges vanish. */
static void make_bad_corner(struct shape *shape, bool point) {
    static const double square[2] = {0, 1};
    shape_quadric(shape, 0.3, 0.2, square, square);
    for (int c = 0; c < 3; c++) {
        double from = shape->h[0][c], along = shape->h[1][c] - from;
        shape->h[3][c] = from + (point ? 0 : 0.8 * along);
        shape->h[1][c] = from + (point ? 0 : along);
    }
}

static void test_exact_coverage_degenerate_start(void **state) {
    static struct shape shape;
    (void)state;
    for (int point = 0; point < 2; point++) {
        struct drape_settings settings = settings_at(0, 0, 20, 0.05);
        struct drape_run run;
        make_bad_corner(&shape, point);
        assert_int_equal(drape_try(&run, &shape, &settings), STATUS_DEGENERATE_SURFACE);
        drape_end(&run);
        /* from elsewhere it works, up to that corner */
        settings.start_uv[0] = settings.start_uv[1] = 0.6;
        drape_begin(&run, &shape, &settings);
        printf("  bad corner: coverage %.3f\n", run.result.summary.coverage);
        check_above(run.result.summary.coverage, 0.85);
        check_area(&shape, &run);
        drape_end(&run);
    }
}

/* A cone to its apex: no tangent plane there, and half the angle of a plane round it. */
static void test_exact_coverage_cone_with_apex(void **state) {
    static struct shape shape;
    static const double full[2] = {0, 2 * M_PI}, apex[2] = {0, 0}, rim[2] = {0.6, 1};
    (void)state;
    for (int k = 0; k < 4; k++) {
        struct drape_settings settings = settings_at(0.15 * k, 0.4 + 0.15 * k, 10 + 25 * k, 0.03);
        struct drape_run run;
        shape_frustum(&shape, full, apex, rim, M_PI / 2);
        drape_begin(&run, &shape, &settings);
        printf("  cone to its apex: coverage %.3f\n", run.result.summary.coverage);
        check_above(run.result.summary.coverage, 0.8);
        check_area(&shape, &run);
        drape_end(&run);
    }
}

/* Beyond the corners of a disk made of one patch no parameters lead: that is its boundary. The net
 * is the square grid. */
static void test_exact_coverage_disk_with_singular_corners(void **state) {
    static const enum drape_method methods[] = {DRAPE_GIB, DRAPE_BASIC, DRAPE_GIB4, DRAPE_GEODESIC};
    static struct shape shape;
    (void)state;
    shape_disk(&shape, 1);
    for (int k = 0; k < 16; k++) {
        double d = k < 8 ? 0.04 : 0.11, turn = 90.0 / 16 * k;
        struct drape_settings settings = settings_at(0.5, 0.5, turn, d);
        struct drape_run run;
        settings.method = methods[k % 4];
        drape_begin(&run, &shape, &settings);
        const struct drape_nodes *nodes = &run.result.nodes;
        struct vec3 warp = run.result.start_warp, weft = run.result.start_weft;
        assert_int_equal(run.result.summary.outcome, DRAPE_COMPLETE);
        assert_int_equal(run.result.summary.front_reasons[DRAPE_REASON_NO_CONVERGENCE], 0);
        for (size_t n = 0; n < nodes->count; n++) {
            struct vec3 exact = vec3_axpy(d * nodes->j[n], weft, vec3_scale(d * nodes->i[n], warp));
            assert_true(vec3_distance(node_point(nodes, (int)n), exact) < 1e-10);
        }
        for (int i = -30; i <= 30; i++)
            for (int j = -30; j <= 30; j++)
                assert_true(grid_find(&run.grid, i, j) >= 0 || d * hypot(i, j) > 1 - 1e-9);
        drape_end(&run);
    }
}

/* On a torus the net goes on over the cuts opposite its start until it meets itself: oblique nets,
 * which the cuts would end at 0.70 and 0.74 of the area, cover as much as mosaic's, which know
 * none.
 */
static void test_exact_coverage_goes_round_a_torus_both_ways(void **state) {
    static struct shape shape;
    static const double all[2] = {0, 2 * M_PI};
    (void)state;
    shape_torus(&shape, 3, 1, all, all, M_PI / 2);
    for (double angle = 0; angle <= 45; angle += 15) {
        double coverage[2];
        for (int k = 0; k < 2; k++) {
            struct drape_settings settings = settings_at(0.3, 0.25, angle, 0.15);
            struct drape_run run;
            settings.method = k ? DRAPE_MOSAIC : DRAPE_GIB;
            assert_int_equal(drape_try(&run, &shape, &settings), STATUS_OK);
            coverage[k] = run.result.summary.coverage;
            if (k == 0) {
                check_result(&shape, &settings, &run);
                check_area(&shape, &run);
            }
            drape_end(&run);
        }
        printf("  torus at %2.0f: gib %.3f, mosaic %.3f\n", angle, coverage[0], coverage[1]);
        assert_true(coverage[0] > 0.9 && coverage[0] > coverage[1] - 0.05);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_exact_coverage_goes_round_a_torus_both_ways),
        cmocka_unit_test(test_exact_coverage_patch_drapes_like_whole),
        cmocka_unit_test(test_exact_coverage_is_complete),
        cmocka_unit_test(test_exact_coverage_long_strip),
        cmocka_unit_test(test_exact_coverage_closed_cylinder),
        cmocka_unit_test(test_exact_coverage_closed_cone),
        cmocka_unit_test(test_exact_coverage_closed_torus),
        cmocka_unit_test(test_exact_coverage_start_on_pole),
        cmocka_unit_test(test_exact_coverage_start_near_pole),
        cmocka_unit_test(test_exact_coverage_passes_poles),
        cmocka_unit_test(test_exact_coverage_crosses_crease),
        cmocka_unit_test(test_exact_coverage_crosses_curvature_jump),
        cmocka_unit_test(test_exact_coverage_collapse),
        cmocka_unit_test(test_exact_coverage_full_sphere),
        cmocka_unit_test(test_exact_coverage_band),
        cmocka_unit_test(test_exact_coverage_degenerate_start),
        cmocka_unit_test(test_exact_coverage_cone_with_apex),
        cmocka_unit_test(test_exact_coverage_disk_with_singular_corners),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
