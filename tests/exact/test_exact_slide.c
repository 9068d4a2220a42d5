/* SPDX-License-Identifier: MIT */
/*
 * Fabrics whose weft slides along warp, against closed forms and an independent code for geodesics.
 *
 * Parallel fibres of a parallel of a surface of revolution are its other parallels. With t the arc
 * length along the profile and rho(t) the distance from the axis, node (i, j) has t = t0 + j b and
 * the longitude i a / rho(t), and the shear there is tan g = -(i a) rho'(t) / rho(t).
 */
#include "geodesic.h"
#include "tests/check.h"
#include "whole.h"
#include <stdio.h>
#include <string.h>

static const double HALF_PI = 1.57079632679489662;

enum { N_FIRST = 16, LEVELS = 3 };

/* ---- surfaces of revolution ---- */

/* A sphere (major 0) or a torus about the z axis whose tube has the angle `start` at t = 0. */
struct round {
    struct shape shape;
    double major, minor, start;
};

static void round_make(struct round *round, double major, double minor, double start) {
    const double turn[2] = {-2.6, 2.6}, tube[2] = {-1.35, 1.35};
    *round = (struct round){.major = major, .minor = minor, .start = start};
    if (major > 0)
        shape_torus(&round->shape, major, minor, turn, tube, HALF_PI);
    else
        shape_sphere(&round->shape, minor, turn, tube, HALF_PI);
}

static struct vec3 round_point(const struct round *round, double longitude, double tube) {
    double rho = round->major + round->minor * cos(tube);
    return vec3_make(rho * cos(longitude), rho * sin(longitude), round->minor * sin(tube));
}

/* A net that reaches `side` minor radii and n cells to all sides, its warp along a parallel. */
static struct drape_settings round_settings(const struct round *round, enum drape_method method,
                                            double side, int n) {
    double d = side * round->minor / n;
    struct drape_settings settings = {.method = method,
                                      .spacing = {d, d},
                                      .start_kind = DRAPE_START_POINT,
                                      .start_point = round_point(round, 0, round->start),
                                      .direction_kind = DRAPE_DIRECTION_VECTOR,
                                      .direction_vector = {0, 1, 0},
                                      .has_extent = {true, true},
                                      .extent = {{-n, n}, {-n, n}},
                                      .max_nodes = 1000000,
                                      .slide = 1};
    settings.generator[0].kind = DRAPE_GENERATOR_PLANE;
    settings.generator[0].plane_normal = vec3_make(0, 0, 1);
    return settings;
}

struct round_error {
    double position, shear_deg; /* the first by the minor radius */
    double rests;          /* that of the nodes that rest on the cloth alone, which lies between the
                              meridians          through the ends of the first fibre, but for a margin;
                              others rest on          fibres that          have been extrapolated beyond the
                              extent */
    size_t bounded, count; /* nodes whose error the estimate is no less than */
};
static const double MARGIN = 0.15; /* of the side */

static struct round_error round_measure(const struct round *round, const struct drape_nodes *nodes,
                                        const double spacing[2], int n) {
    struct round_error error = {0, 0, 0, 0, nodes->count};
    double first = round->major + round->minor * cos(round->start);
    for (size_t k = 0; k < nodes->count; k++) {
        double tube = round->start + nodes->j[k] * spacing[1] / round->minor;
        double rho = round->major + round->minor * cos(tube), along = nodes->i[k] * spacing[0];
        double shear = atan(along * sin(tube) / rho) * 90 / HALF_PI;
        double gap =
            vec3_distance(round_point(round, along / rho, tube), node_point(nodes, (int)k));
        error.position = fmax(error.position, gap / round->minor);
        if (abs(nodes->i[k]) < n * (fmin(rho / first, 1) - MARGIN))
            error.rests = fmax(error.rests, gap / round->minor);
        error.shear_deg = fmax(error.shear_deg, fabs(nodes->shear_deg[k] - shear));
        error.bounded +=
            nodes->error_estimate && gap <= nodes->error_estimate[k] + 1e-12 * round->minor;
    }
    return error;
}

/* What is asked of a method: its order, and the errors with 32 cells a side. */
struct asked {
    enum drape_method method;
    double order, position, shear_deg;
};

static void check_round(struct round *round, double side, const struct asked *asked) {
    struct round_error last = {0, 0, 0, 0, 0};
    for (int level = 0, n = N_FIRST; level < LEVELS; level++, n *= 2) {
        struct drape_settings settings = round_settings(round, asked->method, side, n);
        struct drape_run run;
        drape_begin(&run, &round->shape, &settings);
        struct round_error error = round_measure(round, &run.result.nodes, settings.spacing, n);
        double order = order_of(last.rests, error.rests);
        printf("# %-8s n %d: position %.2e, %.2e of those that rest on cloth, shear %.2e deg, "
               "order %.2f\n",
               drape_method_names[asked->method], n, error.position, error.rests, error.shear_deg,
               order);
        assert_int_equal(error.count, (2 * n + 1) * (2 * n + 1));
        if (level > 0)
            check_at_least(order, asked->order);
        if (n == 32) {
            check_at_most(error.position, asked->position);
            check_at_most(error.shear_deg, asked->shear_deg);
        }
        if (asked->method == DRAPE_GIB4)
            check_at_least((double)error.bounded, 0.99 * (double)error.count);
        last = error;
        drape_end(&run);
    }
}

static void test_exact_slide_parallel_fibers_of_sphere(void **state) {
    (void)state;
    static const struct asked asked[] = {{DRAPE_BASIC, 1.9, 1e-5, 9e-4},
                                         {DRAPE_GIB, 1.9, 1.4e-6, 4e-4},
                                         {DRAPE_GEODESIC, 1.9, 1.4e-6, 4e-4},
                                         {DRAPE_GIB4, 3.2, 5e-9, 3e-6}};
    struct round sphere;
    round_make(&sphere, 0, 50, 0);
    for (size_t m = 0; m < sizeof asked / sizeof *asked; m++)
        check_round(&sphere, 0.45, &asked[m]);
}

/* Weft ten times as far apart as warp: a node rests on cloth that is more than a cell ahead. */
static void test_exact_slide_rests_on_cloth_cells_ahead(void **state) {
    (void)state;
    const int n = 16, many = 10 * n;
    const enum drape_method methods[] = {DRAPE_GIB, DRAPE_GIB4};
    const double most[] = {1.5e-4, 1e-5};
    struct round sphere;
    round_make(&sphere, 0, 50, 0);
    for (size_t m = 0; m < 2; m++) {
        struct drape_settings settings = round_settings(&sphere, methods[m], 0.8, n);
        struct drape_run run;
        settings.spacing[0] /= 10;
        settings.extent[0][0] = -many;
        settings.extent[0][1] = many;
        drape_begin(&run, &sphere.shape, &settings);
        struct round_error error =
            round_measure(&sphere, &run.result.nodes, settings.spacing, many);
        printf("# %-8s position %.2e, %.2e of those that rest on cloth, shear %.2e deg\n",
               drape_method_names[methods[m]], error.position, error.rests, error.shear_deg);
        assert_int_equal(error.count, (2 * many + 1) * (2 * n + 1));
        check_at_most(error.position, most[m]);
        drape_end(&run);
    }
}

static void test_exact_slide_parallel_fibers_of_torus(void **state) {
    (void)state;
    static const struct asked asked[] = {{DRAPE_BASIC, 1.9, 1.4e-5, 4e-4},
                                         {DRAPE_GIB, 1.9, 1.9e-6, 5e-4},
                                         {DRAPE_GEODESIC, 1.9, 1.9e-6, 5e-4},
                                         {DRAPE_GIB4, 2.2, 8e-9, 1e-5}};
    struct round torus;
    round_make(&torus, 1.5, 1, 0.3);
    for (size_t m = 0; m < sizeof asked / sizeof *asked; m++)
        check_round(&torus, 0.6, &asked[m]);
}

/* ---- any slide on surfaces of revolution, by lines ---- */

/* The fibre as values at Chebyshev points of -reach <= s <= reach, which moves over the surface
 * along weft: with e = r_s and its curvature k = r_ss . (n x e) the shear is what
 * g_s = k / (1 + c tan^2 g) gives from g = 0 at s = 0, and r_t = (cos g)^-c (sin g e + cos g n x
 * e).
 */
enum { LINE_POINTS = 25, LINE_MIDDLE = LINE_POINTS / 2, LINE_STEPS = 8 };

struct line {
    const struct round *round;
    double c, reach, s[LINE_POINTS], weight[LINE_POINTS], derive[LINE_POINTS][LINE_POINTS];
    double integrate[LINE_POINTS][LINE_POINTS]; /* from 0 to each point, by Gauss */
    struct vec3 r[LINE_POINTS];
};

/* Lagrange's polynomials at s, by barycentric weights. */
static void line_basis(const struct line *line, double s, double basis[LINE_POINTS]) {
    double sum = 0;
    for (int k = 0; k < LINE_POINTS; k++) {
        bool there = fabs(s - line->s[k]) < 1e-14;
        for (int n = 0; n < LINE_POINTS && there; n++)
            basis[n] = n == k;
        if (there)
            return;
        basis[k] = line->weight[k] / (s - line->s[k]);
        sum += basis[k];
    }
    for (int k = 0; k < LINE_POINTS; k++)
        basis[k] /= sum;
}

static void line_make(struct line *line) {
    static const double at[] = {-0.7745966692414834, 0, 0.7745966692414834};
    static const double share[] = {5.0 / 18, 8.0 / 18, 5.0 / 18};
    enum { PARTS = 40 };
    for (int k = 0; k < LINE_POINTS; k++) {
        line->s[k] = -line->reach * cos(2 * HALF_PI * k / (LINE_POINTS - 1));
        line->weight[k] = (k % 2 ? -1 : 1) * (k == 0 || k == LINE_POINTS - 1 ? 0.5 : 1);
    }
    line->s[LINE_MIDDLE] = 0;
    for (int k = 0; k < LINE_POINTS; k++) {
        line->derive[k][k] = 0;
        for (int n = 0; n < LINE_POINTS; n++)
            if (n != k) {
                line->derive[k][n] = line->weight[n] / line->weight[k] / (line->s[k] - line->s[n]);
                line->derive[k][k] -= line->derive[k][n];
            }
        memset(line->integrate[k], 0, sizeof line->integrate[k]);
        for (int part = 0; part < PARTS * 3; part++) {
            double basis[LINE_POINTS], width = line->s[k] / PARTS;
            line_basis(line, width * (part / 3 + 0.5 + at[part % 3] / 2), basis);
            for (int n = 0; n < LINE_POINTS; n++)
                line->integrate[k][n] += width * share[part % 3] * basis[n];
        }
    }
}

/* The shear from the curvature: g by fixed points of its integral, which contract. */
static void line_shear(const struct line *line, const double *curvature, double *shear) {
    double slope[LINE_POINTS];
    memset(shear, 0, LINE_POINTS * sizeof *shear);
    for (int round = 0; round < 30; round++) {
        for (int k = 0; k < LINE_POINTS; k++)
            slope[k] = curvature[k] / (1 + line->c * pow(tan(shear[k]), 2));
        for (int k = 0; k < LINE_POINTS; k++) {
            shear[k] = 0;
            for (int n = 0; n < LINE_POINTS; n++)
                shear[k] += line->integrate[k][n] * slope[n];
        }
    }
}

static void line_move(const struct line *line, const struct vec3 *r, struct vec3 *moved) {
    struct vec3 e[LINE_POINTS], left[LINE_POINTS];
    double curvature[LINE_POINTS], shear[LINE_POINTS];
    for (int k = 0; k < LINE_POINTS; k++) {
        e[k] = vec3_make(0, 0, 0);
        for (int n = 0; n < LINE_POINTS; n++)
            e[k] = vec3_axpy(line->derive[k][n], r[n], e[k]);
        double across = hypot(r[k].x, r[k].y), ring = 1 - line->round->major / across;
        left[k] = vec3_unit(vec3_cross(vec3_make(r[k].x * ring, r[k].y * ring, r[k].z), e[k]));
    }
    for (int k = 0; k < LINE_POINTS; k++) {
        struct vec3 turn = {0, 0, 0};
        for (int n = 0; n < LINE_POINTS; n++)
            turn = vec3_axpy(line->derive[k][n], e[n], turn);
        curvature[k] = vec3_dot(turn, left[k]);
    }
    line_shear(line, curvature, shear);
    for (int k = 0; k < LINE_POINTS; k++)
        moved[k] = vec3_scale(pow(cos(shear[k]), -line->c),
                              vec3_axpy(sin(shear[k]), e[k], vec3_scale(cos(shear[k]), left[k])));
}

/* To the next fibre, d further along weft, by Runge and Kutta's steps. */
static void line_advance(struct line *line, double d) {
    static const double ahead[] = {0, 0.5, 0.5, 1}, share[] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6};
    double h = d / LINE_STEPS;
    for (int step = 0; step < LINE_STEPS; step++) {
        struct vec3 rate[LINE_POINTS], at[LINE_POINTS], next[LINE_POINTS];
        memcpy(next, line->r, sizeof next);
        memset(rate, 0, sizeof rate);
        for (int stage = 0; stage < 4; stage++) {
            for (int k = 0; k < LINE_POINTS; k++)
                at[k] = vec3_axpy(h * ahead[stage], rate[k], line->r[k]);
            line_move(line, at, rate);
            for (int k = 0; k < LINE_POINTS; k++)
                next[k] = vec3_axpy(h * share[stage], rate[k], next[k]);
        }
        memcpy(line->r, next, sizeof next);
    }
}

/* The largest distance of nodes that rest on cloth alone from those fibres, by the minor radius. */
static double off_lines(const struct round *round, const struct drape_run *run, double c, double d,
                        int n, bool meridian) {
    struct line line = {.round = round, .c = c, .reach = 1.1 * n * d};
    double most = 0, rho = round->major + round->minor * cos(round->start);
    line_make(&line);
    for (int side = -1; side <= 1; side += 2) {
        for (int k = 0; k < LINE_POINTS; k++)
            line.r[k] = meridian ? round_point(round, 0, round->start + line.s[k] / round->minor)
                                 : round_point(round, line.s[k] / rho, round->start);
        for (int j = 1; j <= n; j++) {
            line_advance(&line, side * d);
            for (int i = -n / 2; i <= n / 2; i++) {
                double basis[LINE_POINTS];
                struct vec3 exact = {0, 0, 0};
                line_basis(&line, i * d, basis);
                for (int k = 0; k < LINE_POINTS; k++)
                    exact = vec3_axpy(basis[k], line.r[k], exact);
                int at = grid_find(&run->grid, i, side * j);
                assert_true(at >= 0);
                most = fmax(most, vec3_distance(exact, node_point(&run->result.nodes, at)));
            }
        }
    }
    return most / round->minor;
}

static void test_exact_slide_on_surfaces_of_revolution_by_lines(void **state) {
    (void)state;
    static const struct {
        double major, start, c;
        bool meridian;
    } rows[] = {{0, 0, 1, false},       {0, 0, 0, false},       {0, 0, 0.3, false},
                {0, 0, 0.7, false},     {1.5, 0.3, 0.5, false}, {1.5, 0.3, 0.5, true},
                {1.5, 0.3, 0.25, true}, {1.5, 0.3, 1, true}};
    static const struct {
        enum drape_method method;
        double order, most;
    } asked[] = {{DRAPE_GIB, 1.9, 5e-7}, {DRAPE_GIB4, 3.2, 1e-9}};
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++)
        for (size_t m = 0; m < sizeof asked / sizeof *asked; m++) {
            struct round round;
            double last = 0;
            round_make(&round, rows[k].major, 1, rows[k].start);
            for (int n = N_FIRST; n <= 2 * N_FIRST; n *= 2) {
                struct drape_settings settings = round_settings(&round, asked[m].method, 0.45, n);
                struct drape_run run;
                settings.slide = rows[k].c;
                if (rows[k].meridian) {
                    settings.generator[0].kind = DRAPE_GENERATOR_GEODESIC;
                    settings.direction_vector =
                        vec3_make(-sin(rows[k].start), 0, cos(rows[k].start));
                }
                drape_begin(&run, &round.shape, &settings);
                double most =
                    off_lines(&round, &run, rows[k].c, settings.spacing[0], n, rows[k].meridian);
                printf("# %s, along a %s, slide %.2f, %s n %d: %.2e, order %.2f; shear %.1f deg\n",
                       rows[k].major > 0 ? "torus" : "sphere",
                       rows[k].meridian ? "meridian" : "parallel", rows[k].c,
                       drape_method_names[asked[m].method], n, most, order_of(last, most),
                       run.result.summary.max_shear_deg);
                if (n > N_FIRST) {
                    check_at_least(order_of(last, most), asked[m].order);
                    check_at_most(most, asked[m].most);
                }
                last = most;
                drape_end(&run);
            }
        }
}

/* ---- developables, and no slide ---- */

static const enum drape_method METHODS[] = {DRAPE_BASIC, DRAPE_GIB, DRAPE_GEODESIC, DRAPE_GIB4};
enum { METHOD_COUNT = sizeof METHODS / sizeof *METHODS };

/* Flat cloth is not sheared, whatever slides: the net is as right as that of a weave, but for what
 * the correction of gib4 leaves, by the side. */
static const double OF_CORRECTION = 3e-8;

static void test_exact_slide_leaves_developables_flat(void **state) {
    (void)state;
    static const enum scene_id ids[] = {SCENE_PLANE, SCENE_CYLINDER, SCENE_CYLINDER_FULL,
                                        SCENE_CONE};
    static const double slides[] = {0.4, 1};
    for (size_t s = 0; s < sizeof ids / sizeof *ids; s++)
        for (int m = 0; m < METHOD_COUNT; m++) {
            struct scene scene;
            const int n[2] = {32, 32};
            double weave = 0;
            scene_make(&scene, ids[s]);
            for (int c = -1; c < 2; c++) {
                struct drape_settings settings = scene_settings(&scene, METHODS[m], n[0]);
                struct drape_run run;
                settings.slide = c < 0 ? 0 : slides[c];
                drape_begin(&run, &scene.shape, &settings);
                struct net_error error =
                    measure_error(&run.result.nodes, scene_reference(&scene), settings.spacing, n);
                printf("# %-22s %-8s slide %.1f: %.2e of the side, %.2e deg, %d nodes\n",
                       scene.name, drape_method_names[METHODS[m]], settings.slide,
                       error.position / scene.side, error.shear_deg, error.count);
                weave = c < 0 ? error.position : weave;
                check_at_most(error.position, 1.1 * weave + OF_CORRECTION * scene.side);
                drape_end(&run);
            }
            scene_free(&scene);
        }
}

/* A slide that is next to nothing leads by the way of sliding to the net of a weave. */
static void test_exact_slide_of_nothing_is_a_weave(void **state) {
    (void)state;
    static const enum scene_id ids[] = {SCENE_SPHERE, SCENE_SADDLE_OBLIQUE, SCENE_FREEFORM,
                                        SCENE_TORUS_FULL};
    for (size_t s = 0; s < sizeof ids / sizeof *ids; s++)
        for (int m = 0; m < METHOD_COUNT; m++) {
            struct scene scene;
            struct drape_run weave, sliding;
            scene_make(&scene, ids[s]);
            struct drape_settings settings = scene_settings(&scene, METHODS[m], 16);
            drape_begin(&weave, &scene.shape, &settings);
            settings.slide = 1e-13;
            drape_begin(&sliding, &scene.shape, &settings);
            const struct drape_nodes *nodes = &weave.result.nodes;
            double gap = 0;
            assert_int_equal(nodes->count, sliding.result.nodes.count);
            for (size_t k = 0; k < nodes->count; k++)
                gap = fmax(gap, vec3_distance(node_point(nodes, (int)k),
                                              node_point(&sliding.result.nodes, (int)k)));
            printf("# %-22s %-8s %.1e spacings, %zu nodes\n", scene.name,
                   drape_method_names[METHODS[m]], gap / settings.spacing[0], nodes->count);
            if (METHODS[m] != DRAPE_GIB4)
                check_at_most(gap, 1e-9 * settings.spacing[0]);
            drape_end(&weave);
            drape_end(&sliding);
            scene_free(&scene);
        }
}

/* ---- any surface ---- */

/* How far node (i, j) is from the end of some geodesic of the length j b that leaves the base, a
 * geodesic, at a right angle; beginning at arc length s of it. */
static double off_parallel(const struct shape *shape, const struct exact_geodesic *base, double s,
                           double length, struct vec3 node) {
    double gap = HUGE_VAL, last_s = 0, last_along = 0;
    for (int round = 0; round < 20; round++) {
        struct surface_jet jet;
        double uv[2], duv[2];
        exact_geodesic_at(base, s, uv, duv);
        shape_evaluate(shape, uv[0], uv[1], &jet);
        struct vec3 tangent = vec3_unit(vec3_axpy(duv[1], jet.v, vec3_scale(duv[0], jet.u)));
        struct exact_geodesic_setup setup = {
            shape, {uv[0], uv[1]}, vec3_cross(jet_normal(&jet), tangent), length, 2, 20};
        struct exact_geodesic *across = exact_geodesic_make(&setup);
        exact_geodesic_at(across, length, uv, duv);
        exact_geodesic_free(across);
        shape_evaluate(shape, uv[0], uv[1], &jet);
        struct vec3 left = vec3_sub(node, jet.r);
        double along = vec3_dot(left, tangent);
        double rate = round ? (along - last_along) / (s - last_s) : -1;
        gap = vec3_norm(left);
        if (fabs(along) < 1e-12 || (round && s == last_s))
            break;
        last_s = s;
        last_along = along;
        s -= along / rate;
    }
    return gap;
}

/* Parallel fibres are as far from the first as they are by their number, everywhere. */
static void test_exact_slide_fibers_keep_their_distance(void **state) {
    (void)state;
    static const enum scene_id ids[] = {SCENE_ELLIPSOID, SCENE_BEZIER, SCENE_SADDLE_OBLIQUE};
    static const struct {
        enum drape_method method;
        double order, most; /* by the side, with 32 cells */
    } asked[] = {{DRAPE_GIB, 1.8, 8e-7}, {DRAPE_GIB4, 3.4, 2e-8}};
    for (size_t s = 0; s < sizeof ids / sizeof *ids; s++)
        for (size_t m = 0; m < sizeof asked / sizeof *asked; m++) {
            struct scene scene;
            scene_make(&scene, ids[s]);
            double last = 0;
            struct exact_geodesic_setup setup = {&scene.smooth,
                                                 {scene.smooth_uv[0], scene.smooth_uv[1]},
                                                 scene.start.warp,
                                                 1.3 * scene.side,
                                                 8,
                                                 24};
            struct exact_geodesic *base = exact_geodesic_make(&setup);
            for (int n = N_FIRST; n <= 2 * N_FIRST; n *= 2) {
                struct drape_settings settings = scene_settings(&scene, asked[m].method, n);
                struct drape_run run;
                double most = 0;
                settings.slide = 1;
                drape_begin(&run, &scene.shape, &settings);
                for (int j = n / 4; j <= n / 2; j += n / 4)
                    for (int i = n / 4; i <= n / 2; i += n / 4) {
                        int at = grid_find(&run.grid, i, j);
                        assert_true(at >= 0);
                        double off = off_parallel(&scene.smooth, base, i * settings.spacing[0],
                                                  j * settings.spacing[1],
                                                  node_point(&run.result.nodes, at));
                        most = fmax(most, off / scene.side);
                    }
                printf("# %-22s %-4s n %d: %.2e of the side, order %.2f; shear %.1f deg\n",
                       scene.name, drape_method_names[asked[m].method], n, most,
                       order_of(last, most), run.result.summary.max_shear_deg);
                check_at_most(most, n == 2 * N_FIRST ? asked[m].most : HUGE_VAL);
                if (n > N_FIRST)
                    check_at_least(order_of(last, most), asked[m].order);
                last = most;
                drape_end(&run);
            }
            exact_geodesic_free(base);
            scene_free(&scene);
        }
}

/* The derivative of the net at node (i, j) along warp (family 0) or weft, to fourth order. */
static bool derive(const struct drape_run *run, int i, int j, int family, struct vec3 *derivative) {
    static const double weight[] = {1.0 / 12, -8.0 / 12, 0, 8.0 / 12, -1.0 / 12};
    *derivative = vec3_make(0, 0, 0);
    for (int k = -2; k <= 2; k++) {
        int at = grid_find(&run->grid, family ? i : i + k, family ? j + k : j);
        if (at < 0)
            return false;
        *derivative = vec3_axpy(weight[k + 2], node_point(&run->result.nodes, at), *derivative);
    }
    return true;
}

/* |r_s| = 1 and |r_t| = (cos g)^-c as the nodes themselves have it. */
static void test_exact_slide_keeps_the_law(void **state) {
    (void)state;
    static const enum scene_id ids[] = {SCENE_ELLIPSOID, SCENE_SADDLE_OBLIQUE, SCENE_BEZIER};
    static const double slides[] = {0.25, 0.5, 1};
    for (size_t s = 0; s < sizeof ids / sizeof *ids; s++)
        for (size_t c = 0; c < sizeof slides / sizeof *slides; c++) {
            struct scene scene;
            scene_make(&scene, ids[s]);
            double last = 0;
            for (int n = N_FIRST; n <= 2 * N_FIRST; n *= 2) {
                struct drape_settings settings = scene_settings(&scene, DRAPE_GIB4, n);
                struct drape_run run;
                double most = 0, unsheared = 0;
                settings.slide = slides[c];
                drape_begin(&run, &scene.shape, &settings);
                for (int i = 3; i <= n / 2; i++)
                    for (int j = 3; j <= n / 2; j++) {
                        struct vec3 r[2] = {{0, 0, 0}, {0, 0, 0}};
                        assert_true(derive(&run, i, j, 0, &r[0]) && derive(&run, i, j, 1, &r[1]));
                        double a = vec3_norm(r[0]), b = vec3_norm(r[1]);
                        double sine = vec3_dot(r[0], r[1]) / (a * b);
                        double law = settings.spacing[1] * pow(1 - sine * sine, -slides[c] / 2);
                        most = fmax(most, fabs(b / law - 1) + fabs(a / settings.spacing[0] - 1));
                        unsheared = fmax(unsheared, law / settings.spacing[1] - 1);
                    }
                printf("# %-22s slide %.2f n %d: %.2e, where weft is longer by %.2e\n", scene.name,
                       slides[c], n, most, unsheared);
                if (n > N_FIRST) {
                    check_at_least(order_of(last, most), 2.5);
                    check_at_most(most, 1e-7);
                }
                last = most;
                drape_end(&run);
            }
            scene_free(&scene);
        }
}

/* ---- other parts ---- */

/* Where all is covered the cloth has the area of the part, that of its pattern less what shear
 * takes: nothing of parallel fibres. */
static void test_exact_slide_cloth_has_the_area_of_the_part(void **state) {
    (void)state;
    static const double slides[] = {0, 0.5, 1};
    static const struct vec3 points[] = {{-1, -1, 0}, {-1, 0, 1}, {-1, 1, 0},
                                         {0, -1, -1}, {0, 0, 0},  {0, 1, -1},
                                         {1, -1, 0},  {1, 0, 1},  {1, 1, 0}};
    static const double knots[] = {0, 0, 0, 1, 1, 1};
    const struct nurbs_axis axis = {2, 3, knots, 6};
    const struct nurbs nurbs = {axis, axis, points, 9, NULL, 0};
    for (size_t k = 0; k < sizeof slides / sizeof *slides; k++) {
        struct arena *arena = arena_new((size_t)1 << 28);
        struct surface *saddle;
        struct drape_result result;
        const struct drape_settings settings = {.method = DRAPE_GIB,
                                                .spacing = {0.02, 0.02},
                                                .start_kind = DRAPE_START_UV,
                                                .start_uv = {0.5, 0.5},
                                                .direction_deg = 45,
                                                .max_nodes = 1000000,
                                                .slide = slides[k]};
        assert_int_equal(surface_make(&nurbs, arena, &saddle), STATUS_OK);
        assert_int_equal(
            drape_solve(&(struct drape_part){.surface = saddle}, &settings, NULL, arena, &result),
            STATUS_OK);
        const struct drape_summary *s = &result.summary;
        double off = fabs(s->cloth_area / s->part_area - 1), kept = s->cloth_area / s->flat_area;
        printf("# slide %.1f: area off by %.1e, %.4f of the pattern's, shear up to %.1f deg\n",
               slides[k], off, kept, s->max_shear_deg);
        assert_int_equal(s->outcome, DRAPE_COMPLETE);
        check_at_most(off, 2e-3);
        if (slides[k] == 1)
            check_at_most(fabs(kept - 1), 1e-9);
        else
            check_at_most(kept, 0.999);
        arena_free(arena);
    }
}

/* The unit sphere about its equator as a mesh of n x n quadrilaterals of two triangles. */
static struct mesh *zone_mesh(int n, struct arena *arena) {
    struct round unit = {.minor = 1};
    struct vec3 *vertices = arena_alloc(arena, (size_t)((n + 1) * (n + 1)), sizeof *vertices);
    int32_t(*triangles)[3] = arena_alloc(arena, (size_t)(2 * n * n), sizeof *triangles);
    for (int k = 0; k < (n + 1) * (n + 1); k++)
        vertices[k] =
            round_point(&unit, 1.8 * (k % (n + 1)) / n - 0.9, 1.4 * (k / (n + 1)) / n - 0.7);
    for (int k = 0; k < n * n; k++) {
        int32_t a = k / n * (n + 1) + k % n, c = a + n + 1;
        const int32_t two[2][3] = {{a, a + 1, c + 1}, {a, c + 1, c}};
        memcpy(triangles[2 * k], two, sizeof two);
    }
    const struct mesh_source source = {.vertices = vertices,
                                       .vertex_count = (size_t)((n + 1) * (n + 1)),
                                       .triangles = (const int32_t(*)[3])triangles,
                                       .triangle_count = (size_t)(2 * n * n)};
    struct mesh_fault fault;
    struct mesh *mesh;
    assert_int_equal(mesh_make(&source, arena, &mesh, &fault), STATUS_OK);
    return mesh;
}

/* On meshes, and over the triangles of the method mosaic. */
static void test_exact_slide_on_triangles(void **state) {
    (void)state;
    enum { CELLS = 12 };
    static const struct {
        enum drape_method method;
        bool mesh; /* or the surface */
        double most;
    } rows[] = {{DRAPE_BASIC, true, 1e-4},
                {DRAPE_GIB, true, 2e-5},
                {DRAPE_GEODESIC, true, 2e-5},
                {DRAPE_MOSAIC, true, 4e-4},
                {DRAPE_MOSAIC, false, 2e-4}};
    struct round sphere;
    round_make(&sphere, 0, 1, 0);
    struct arena *arena = arena_new((size_t)1 << 30);
    const struct mesh *mesh = zone_mesh(64, arena);
    for (size_t m = 0; m < sizeof rows / sizeof *rows; m++) {
        struct drape_settings settings = round_settings(&sphere, rows[m].method, 0.5, CELLS);
        struct drape_run whole = {.arena = NULL};
        struct drape_result result = {0};
        settings.generator[0].kind = DRAPE_GENERATOR_GEODESIC;
        if (rows[m].mesh)
            assert_int_equal(
                drape_solve(&(struct drape_part){.mesh = mesh}, &settings, NULL, arena, &result),
                STATUS_OK);
        else
            assert_int_equal(drape_try(&whole, &sphere.shape, &settings), STATUS_OK);
        const struct drape_nodes *nodes = rows[m].mesh ? &result.nodes : &whole.result.nodes;
        struct round_error error = round_measure(&sphere, nodes, settings.spacing, CELLS);
        printf("# %-8s on %s: %.2e, %zu nodes\n", drape_method_names[rows[m].method],
               rows[m].mesh ? "a mesh" : "a surface", error.position, nodes->count);
        check_at_least((double)nodes->count, (2 * CELLS + 1) * (2 * CELLS + 1));
        check_at_most(error.position, rows[m].most);
        if (!rows[m].mesh)
            drape_end(&whole);
    }
    arena_free(arena);
}

/* Cut into faces a surface has the net of the whole; mosaic of its faces' triangles is near that of
 * chords. */
static void test_exact_slide_on_shells(void **state) {
    (void)state;
    static const enum scene_id ids[] = {SCENE_SPHERE, SCENE_SADDLE_OBLIQUE, SCENE_BEZIER};
    for (size_t s = 0; s < sizeof ids / sizeof *ids; s++)
        for (int m = 0; m < 2 * METHOD_COUNT + 2; m++) {
            struct scene scene;
            scene_make(&scene, ids[s]);
            struct whole_case c = {.cutting = m % 2 ? CUT_QUADS : CUT_ISOLINES,
                                   .method = m / 2 < METHOD_COUNT ? METHODS[m / 2] : DRAPE_MOSAIC,
                                   .seed = 5 + s,
                                   .slide = (int)s % 2 == m % 2 ? 0.5 : 1};
            assert_true(whole_is_same(&scene, &c));
            scene_free(&scene);
        }
}

/* The zone of the unit sphere is cut along a meridian from below to nearly the equator, which is
 * the first fibre. Cloth that does not rest on the slit is as without it. Behind it weft begins
 * anew at its edge, and goes straight on there, but fibres are parallels as before, on which nodes
 * are a apart. */
struct slit_error {
    double before, latitude,
        step; /* of nodes before it; of those behind it, but for the yarn next to it */
    int behind;
};
static const double SLIT_AT = 0.2003, SLIT_TIP = -0.103;

static struct slit_error measure_slit(const struct drape_run *run, double d) {
    const struct drape_nodes *nodes = &run->result.nodes;
    struct round unit = {.minor = 1};
    struct slit_error error = {0, 0, 0, 0};
    for (size_t k = 0; k < nodes->count; k++) {
        int i = nodes->i[k], j = nodes->j[k], last = grid_find(&run->grid, i - 1, j);
        struct vec3 r = node_point(nodes, (int)k);
        double latitude = j * d, longitude = i * d / cos(latitude), at = atan2(r.y, r.x);
        if (at < SLIT_AT || latitude > SLIT_TIP) {
            double gap = vec3_distance(round_point(&unit, longitude, latitude), r);
            error.before = fmax(error.before, gap);
        } else if (last >= 0 && at > SLIT_AT + 2 * d) {
            struct vec3 other = node_point(nodes, last);
            double step = at - atan2(other.y, other.x);
            error.behind++;
            error.latitude = fmax(error.latitude, fabs(asin(r.z) - latitude));
            error.step = fmax(error.step, fabs(step * cos(latitude) / d - 1));
        }
    }
    return error;
}

static void test_exact_slide_beside_a_slit(void **state) {
    (void)state;
    static const struct {
        double order, before, latitude, step; /* with 32 cells */
    } asked[METHOD_COUNT] = {{1.9, 7e-6, 4e-6, 2e-5},
                             {1.9, 1e-6, 2e-6, 5e-6},
                             {1.9, 1e-6, 2e-6, 5e-6},
                             {1.9, 5e-8, 2e-6, 5e-6}};
    struct round unit;
    round_make(&unit, 0, 1, 0);
    const struct vec3 path[2] = {round_point(&unit, SLIT_AT, -1.35),
                                 round_point(&unit, SLIT_AT, SLIT_TIP)};
    const struct drape_cut_line slit = {path, 2};
    for (int m = 0; m < METHOD_COUNT; m++) {
        struct slit_error last = {0, 0, 0, 0};
        for (int n = N_FIRST; n <= 2 * N_FIRST; n *= 2) {
            struct drape_settings settings = round_settings(&unit, METHODS[m], 0.45, n);
            struct drape_run run;
            settings.cuts = &slit;
            settings.cut_count = 1;
            assert_int_equal(drape_try(&run, &unit.shape, &settings), STATUS_OK);
            struct slit_error error = measure_slit(&run, settings.spacing[0]);
            printf("# %-8s n %d: %.2e before the slit, %d nodes behind it: latitude %.2e, steps "
                   "%.2e\n",
                   drape_method_names[METHODS[m]], n, error.before, error.behind, error.latitude,
                   error.step);
            check_at_least(error.behind, n * n / 4);
            if (n > N_FIRST) {
                check_at_least(order_of(last.before, error.before), asked[m].order);
                check_at_most(error.before, asked[m].before);
                check_at_most(error.latitude, asked[m].latitude);
                check_at_most(error.step, asked[m].step);
            }
            last = error;
            drape_end(&run);
        }
    }
}

/* Fibres beside a circle of radius 1 in the plane are circles about its centre, where they meet:
 * the cloth ends before, and says why. */
static void test_exact_slide_ends_where_parallels_meet(void **state) {
    (void)state;
    enum { POINTS = 4001 };
    static double circle[POINTS][2];
    static struct shape plane;
    const double x[2] = {-3, 3};
    const int n = 20;
    struct drape_run run;
    size_t collapsed = 0, lost = 0;
    double most = 0, highest = 0;
    shape_plane(&plane, x, x);
    for (int k = 0; k < POINTS; k++) {
        double angle = 2.5 * (2.0 * k / (POINTS - 1) - 1);
        circle[k][0] = sin(angle);
        circle[k][1] = 1 - cos(angle);
    }
    struct drape_settings settings = {.method = DRAPE_GIB,
                                      .spacing = {0.05, 0.05},
                                      .start_kind = DRAPE_START_UV,
                                      .direction_kind = DRAPE_DIRECTION_VECTOR,
                                      .direction_vector = {1, 0, 0},
                                      .has_extent = {true, true},
                                      .extent = {{-n, n}, {-n, n}},
                                      .max_nodes = 100000,
                                      .slide = 1};
    settings.generator[0] = (struct drape_generator){
        .kind = DRAPE_GENERATOR_CURVE, .curve = (const double(*)[2])circle, .curve_count = POINTS};
    drape_begin(&run, &plane, &settings);
    const struct drape_nodes *nodes = &run.result.nodes;
    for (size_t k = 0; k < nodes->count; k++) {
        double radius = 1 - nodes->j[k] * 0.05, angle = nodes->i[k] * 0.05 / radius;
        const struct vec3 exact = {radius * sin(angle), 1 - radius * cos(angle), 0};
        if (abs(nodes->i[k]) <= n / 2 && abs(nodes->j[k]) <= n / 2)
            most = fmax(most, vec3_distance(exact, node_point(nodes, (int)k)));
        highest = fmax(highest, nodes->j[k] * 0.05);
    }
    for (size_t k = 0; k < run.result.front.count; k++) {
        collapsed += run.result.front.reason[k] == DRAPE_REASON_COLLAPSED;
        lost += run.result.front.reason[k] == DRAPE_REASON_NO_CONVERGENCE;
    }
    printf("# %zu nodes, %zu ends collapsed, %.1f deg, off by %.1e, up to %.2f\n", nodes->count,
           collapsed, run.result.summary.max_shear_deg, most, highest);
    check_at_least((double)collapsed, 1);
    assert_int_equal(lost, 0);
    check_at_most(most, 8e-4);
    check_at_most(highest, 1);
    drape_end(&run);
}

static void test_exact_slide_refuses_sheared_generators(void **state) {
    (void)state;
    struct round sphere;
    struct drape_run run;
    round_make(&sphere, 0, 1, 0);
    for (int k = 0; k < 4; k++) {
        struct drape_settings settings = round_settings(&sphere, DRAPE_GIB, 0.5, 4);
        settings.slide = k == 0 ? 1.01 : k == 1 ? -0.01 : 0.5;
        settings.pre_shear_deg = k == 2 ? 1 : 0;
        settings.generator[1] = settings.generator[k == 3 ? 0 : 1];
        assert_int_equal(drape_try(&run, &sphere.shape, &settings), STATUS_INVALID);
        drape_end(&run);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_exact_slide_parallel_fibers_of_sphere),
        cmocka_unit_test(test_exact_slide_rests_on_cloth_cells_ahead),
        cmocka_unit_test(test_exact_slide_parallel_fibers_of_torus),
        cmocka_unit_test(test_exact_slide_on_surfaces_of_revolution_by_lines),
        cmocka_unit_test(test_exact_slide_leaves_developables_flat),
        cmocka_unit_test(test_exact_slide_of_nothing_is_a_weave),
        cmocka_unit_test(test_exact_slide_fibers_keep_their_distance),
        cmocka_unit_test(test_exact_slide_keeps_the_law),
        cmocka_unit_test(test_exact_slide_cloth_has_the_area_of_the_part),
        cmocka_unit_test(test_exact_slide_on_triangles),
        cmocka_unit_test(test_exact_slide_on_shells),
        cmocka_unit_test(test_exact_slide_beside_a_slit),
        cmocka_unit_test(test_exact_slide_ends_where_parallels_meet),
        cmocka_unit_test(test_exact_slide_refuses_sheared_generators),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
