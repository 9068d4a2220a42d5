/* SPDX-License-Identifier: MIT */
/* Against shooting: a geodesic is sent off from A and ends at B; relaxation from A to B has to find
 * the direction and the length it was given. */
#include "solver/path/relaxation.h"

#include "patch.h"
#include "solver/angle.h"
#include "solver/path/path.h"
#include "solver/surface/spans.h"
#include "support.h"
#include "tests/check.h"
#include <stdio.h>

/* ---- surfaces ---- */

enum { POINTS_MAX = 81 };

/* A surface with its arrays; not to be moved once made. */
struct subject {
    const char *name;
    double knots[2][16], weights[POINTS_MAX];
    struct vec3 points[POINTS_MAX];
    struct patch patch;
    struct arena *arena;
    struct surface *surface;
    struct surface_cursor cursor;
};

static void subject_make(struct subject *s, const char *name, const struct nurbs *nurbs) {
    s->name = name;
    s->cursor = (struct surface_cursor){0};
    s->arena = arena_new((size_t)1 << 24);
    assert_int_equal(nurbs_validate(nurbs, NULL), STATUS_OK);
    assert_int_equal(surface_make(nurbs, s->arena, &s->surface), STATUS_OK);
}

/* One biquadratic span over [0, 1]^2. */
static void make_biquadratic(struct subject *s, const char *name) {
    static const double knots[] = {0, 0, 0, 1, 1, 1};
    struct nurbs nurbs = {{2, 3, knots, 6}, {2, 3, knots, 6}, s->points, 9, s->weights, 9};
    subject_make(s, name, &nurbs);
}

/* z = (x^2 - y^2) / 2 over [-1, 1]^2. */
static void make_saddle(struct subject *s) {
    for (int k = 0; k < 9; k++) {
        int i = k / 3 - 1, j = k % 3 - 1;
        s->points[k] = vec3_make(i, j, (i ? 0.5 : -0.5) - (j ? 0.5 : -0.5));
        s->weights[k] = 1;
    }
    make_biquadratic(s, "saddle");
}

/* The unit sphere, r = (2a, 2b, 1 - a^2 - b^2) / (1 + a^2 + b^2) for a, b in [-1/2, 1/2]: the
 * homogeneous polynomials at their blossoms. */
static void make_sphere(struct subject *s) {
    for (int k = 0; k < 9; k++) {
        int i = k / 3 - 1, j = k % 3 - 1;
        double square = (i ? 0.25 : -0.25) + (j ? 0.25 : -0.25);
        s->weights[k] = 1 + square;
        s->points[k] = vec3_scale(1 / s->weights[k], vec3_make(i, j, 1 - square));
    }
    make_biquadratic(s, "sphere");
}

/* A full turn about the z axis of a profile of quarter circles: `count` points (rho, z), the odd
 * ones the corners between arcs. Both directions have a knot at every quarter. */
static void make_turned(struct subject *s, const char *name, const double (*profile)[2],
                        int count) {
    static const double circle[9][2] = {{1, 0},   {1, 1},  {0, 1},  {-1, 1}, {-1, 0},
                                        {-1, -1}, {0, -1}, {1, -1}, {1, 0}};
    static const double knots[] = {0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4};
    for (int k = 0; k < count + 3; k++)
        s->knots[1][k] = k >= count ? (count - 1) / 2 : knots[k];
    for (int i = 0; i < 9; i++)
        for (int j = 0; j < count; j++) {
            int k = i * count + j;
            s->weights[k] = (i % 2 ? sqrt(0.5) : 1) * (j % 2 ? sqrt(0.5) : 1);
            s->points[k] = vec3_make(profile[j][0] * circle[i][0], profile[j][0] * circle[i][1],
                                     profile[j][1]);
        }
    size_t points = (size_t)(9 * count);
    struct nurbs nurbs = {{2, 9, knots, 12}, {2, count, s->knots[1], (size_t)count + 3},
                          s->points,         points,
                          s->weights,        points};
    subject_make(s, name, &nurbs);
}

static void make_torus(struct subject *s) {
    static const double profile[9][2] = {{4, 0},  {4, 1},  {3, 1},  {2, 1}, {2, 0},
                                         {2, -1}, {3, -1}, {4, -1}, {4, 0}};
    make_turned(s, "torus", profile, 9);
}

/* The unit sphere with its poles at the ends of v. */
static void make_globe(struct subject *s) {
    static const double profile[5][2] = {{0, -1}, {1, -1}, {1, 0}, {1, 1}, {0, 1}};
    make_turned(s, "globe", profile, 5);
}

static void make_random(struct subject *s, int degree, struct random *random) {
    struct patch_kind kind = {degree, degree, true, true};
    patch_make(&s->patch, &kind, random);
    subject_make(s, "random", &s->patch.nurbs);
}

/* ---- geodesics with known ends ---- */

struct shot {
    struct surface_point a, b;
    struct vec3 tangent;
    double length;
};

/* Sends a geodesic off at `angle` degrees against r_u. False when it cannot be followed. */
static bool shoot(struct subject *s, const double uv[2], double angle, double length,
                  struct shot *shot) {
    struct path path;
    double sine, cosine, inner[2];
    surface_inner(s->surface, uv, inner);
    if (!surface_point_at(s->surface, &s->cursor, inner, &shot->a))
        return false;
    angle_sincos_deg(angle, &sine, &cosine);
    struct vec3 along = vec3_unit(shot->a.jet.u), across = vec3_cross(shot->a.normal, along);
    shot->tangent = vec3_axpy(sine, across, vec3_scale(cosine, along));
    shot->length = length;
    return path_geodesic(&path, s->surface, &shot->a, shot->tangent) &&
           path_advance(&path, length) && path_surface_point(&path, &s->cursor, &shot->b, NULL);
}

static void must_shoot(struct subject *s, double u, double v, double angle, double length,
                       struct shot *shot) {
    const double uv[2] = {u, v};
    assert_true(shoot(s, uv, angle, length, shot));
}

/* ---- one mesh ---- */

/* How far the velocity at A on a mesh of m points is from the tangent times the length, relative
 * to the length. */
static double mesh_error(struct subject *s, const struct shot *shot, int points) {
    struct relaxation path;
    if (!relaxation_solve(s->surface, &shot->a, &shot->b, points, &path))
        fail_msg("%s: no path on %d points", s->name, points);
    const double *y = path.y[0], *end = path.y[points - 1];
    struct vec3 velocity = vec3_axpy(y[3], shot->a.jet.v, vec3_scale(y[2], shot->a.jet.u));
    for (int n = 0; n < 2; n++) {
        check_below(fabs(y[n]), 1e-14);
        check_below(fabs(end[n] - (shot->b.uv[n] - shot->a.uv[n])), 1e-14);
    }
    return vec3_distance(velocity, vec3_scale(shot->length, shot->tangent)) / shot->length;
}

static void check_order(struct subject *s, const struct shot *shot) {
    double error[4];
    printf("[     note ] %s, d = %g, m = 5, 9, 17, 33:", s->name, shot->length);
    for (int k = 0; k < 4; k++) {
        error[k] = mesh_error(s, shot, (4 << k) + 1);
        printf(" %.1e", error[k]);
    }
    double order = log2(error[2] / error[3]);
    printf(", order %.3f\n", order);
    if (!(fabs(order - 2) < 0.05) && !(error[3] < 1e-12))
        fail_msg("%s: order %g", s->name, order);
}

static void test_relaxation_is_of_second_order_in_the_mesh(void **state) {
    (void)state;
    struct subject s;
    struct shot shot;
    make_sphere(&s);
    must_shoot(&s, 0.2, 0.3, 25, 0.5, &shot);
    check_order(&s, &shot);
    arena_free(s.arena);
    make_saddle(&s);
    must_shoot(&s, 0.3, 0.4, 35, 0.5, &shot);
    check_order(&s, &shot);
    arena_free(s.arena);
    make_torus(&s);
    must_shoot(&s, 0.2, 2.2, 50, 0.6, &shot);
    check_order(&s, &shot);
    arena_free(s.arena);
}

/* A line from a random place; false when it leaves its span, where the surface is not smooth. */
static bool random_shot(struct subject *s, double length, struct random *random,
                        struct shot *shot) {
    const struct nurbs *nurbs = &s->patch.nurbs;
    double uv[2];
    int span;
    uv[0] = patch_parameter(&nurbs->u, random, &span);
    uv[1] = patch_parameter(&nurbs->v, random, &span);
    if (!shoot(s, uv, random_between(random, 0, 360), length, shot))
        return false;
    struct surface_cursor from = {0}, to = {0};
    struct surface_jet jet;
    surface_jet_at(s->surface, &from, shot->a.uv[0], shot->a.uv[1], &jet);
    surface_jet_at(s->surface, &to, shot->b.uv[0], shot->b.uv[1], &jet);
    return from.span_u == to.span_u && from.span_v == to.span_v;
}

static void test_relaxation_is_of_second_order_on_random_surfaces(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    double least = HUGE_VAL, most = 0;
    int tried = 0;
    while (tried < 200) {
        struct subject s;
        struct shot shot;
        make_random(&s, 2 + random_index(&random, 4), &random);
        if (random_shot(&s, 0.1, &random, &shot)) {
            double order = log2(mesh_error(&s, &shot, 17) / mesh_error(&s, &shot, 33));
            least = fmin(least, order);
            most = fmax(most, order);
            tried++;
        }
        arena_free(s.arena);
    }
    printf("[     note ] %d geodesics: order %.3f to %.3f\n", tried, least, most);
    check_above(least, 1.8);
    check_below(most, 2.2);
}

/* ---- the tangent ---- */

struct errors {
    double angle, length; /* of the tangent in radians; of the length, relative */
    double chord;         /* of the chord projected on the tangent plane, in radians */
    int iterations;
};

static bool measure(struct subject *s, const struct shot *shot, struct errors *e) {
    struct vec3 tangent, chord;
    double length;
    if (!relaxation_tangents(s->surface, &s->cursor, &shot->a, &shot->b, &tangent, &length,
                             &e->iterations))
        return false;
    chord = surface_point_tangent(&shot->a, vec3_sub(shot->b.jet.r, shot->a.jet.r));
    e->angle = vec3_angle(tangent, shot->tangent);
    e->chord = vec3_angle(chord, shot->tangent);
    e->length = fabs(length / shot->length - 1);
    check_below(fabs(vec3_norm(tangent) - 1), 1e-14);
    check_below(fabs(vec3_dot(tangent, shot->a.normal)), 1e-14);
    return true;
}

/* Geodesics of lengths d, d/2, .. in all directions from a place. */
static void check_tangents(struct subject *s, double u, double v, double length, double allowed) {
    for (int k = 0; k < 4; k++, length /= 2, allowed /= 16) {
        struct errors worst = {0};
        for (int angle = 0; angle < 360; angle += 15) {
            struct shot shot;
            struct errors e;
            must_shoot(s, u, v, angle, length, &shot);
            assert_true(measure(s, &shot, &e));
            worst.angle = fmax(worst.angle, e.angle);
            worst.length = fmax(worst.length, e.length);
            worst.chord = fmax(worst.chord, e.chord);
            worst.iterations += e.iterations;
        }
        printf("[     note ] %s, d = %g: tangent %.1e, length %.1e, projected chord %.1e; "
               "%.1f iterations\n",
               s->name, length, worst.angle, worst.length, worst.chord, worst.iterations / 24.0);
        double rounding = 1e-13 / length;
        if (!(worst.angle < allowed + rounding) || !(worst.length < allowed + rounding))
            fail_msg("%s: beyond %g", s->name, allowed);
    }
}

static void test_relaxation_tangents_agree_with_shooting(void **state) {
    (void)state;
    struct subject s;
    make_sphere(&s);
    check_tangents(&s, 0.45, 0.55, 0.4, 2e-6);
    arena_free(s.arena);
    make_saddle(&s);
    check_tangents(&s, 0.6, 0.3, 0.4, 2e-6);
    arena_free(s.arena);
    make_torus(&s);
    check_tangents(&s, 0.4, 1.55, 0.4, 2e-6);
    arena_free(s.arena);
}

static void test_relaxation_tangents_on_random_surfaces(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    struct errors worst = {0};
    int tried = 0, failed = 0, poor = 0, iterations = 0;
    while (tried < 300) {
        struct subject s;
        struct shot shot;
        struct errors e;
        make_random(&s, 2 + random_index(&random, 4), &random);
        if (random_shot(&s, 0.1, &random, &shot)) {
            tried++;
            if (measure(&s, &shot, &e)) {
                worst.angle = fmax(worst.angle, e.angle);
                worst.length = fmax(worst.length, e.length);
                worst.chord = fmax(worst.chord, e.chord);
                poor += e.angle > 1e-5 || e.length > 1e-5;
                iterations += e.iterations;
            } else {
                failed++;
            }
        }
        arena_free(s.arena);
    }
    printf(
        "[     note ] %d geodesics, %d refused: tangent %.1e, length %.1e, projected chord %.1e; "
        "%.1f iterations\n",
        tried, failed, worst.angle, worst.length, worst.chord,
        (double)iterations / (tried - failed));
    check_at_most(failed, tried / 100);
    check_at_most(poor, tried / 50);
    check_below(worst.angle, 1e-2);
    check_below(worst.length, 1e-2);
}

/* ---- places that need care ---- */

/* Over the seams of both directions, and over knots where r_uu jumps. */
static void test_relaxation_crosses_seams_and_knots(void **state) {
    (void)state;
    static const double places[][2] = {{3.99, 3.98}, {0.01, 0.03}, {0.98, 1.99}, {-4.02, 8.01}};
    struct subject s;
    double worst = 0;
    make_torus(&s);
    for (int k = 0; k < 4; k++)
        for (int angle = 0; angle < 360; angle += 15) {
            struct shot shot;
            struct errors e;
            must_shoot(&s, places[k][0], places[k][1], angle, 0.1, &shot);
            assert_true(measure(&s, &shot, &e));
            worst = fmax(worst, fmax(e.angle, e.length));
        }
    printf("[     note ] off by %.1e at the most\n", worst);
    check_below(worst, 1e-8);
    arena_free(s.arena);
}

/* Near a pole it refuses; further away it is right, or refuses as well. */
static void test_relaxation_refuses_near_poles(void **state) {
    (void)state;
    struct subject s;
    double worst = 0;
    int refused = 0, tried = 0;
    make_globe(&s);
    for (int k = 0; k <= 40; k++)
        for (int angle = 0; angle < 360; angle += 15) {
            struct shot shot;
            struct errors e;
            const double uv[2] = {0.3, 2 - 0.01 * k};
            if (!shoot(&s, uv, angle, 0.05, &shot))
                continue;
            bool found = measure(&s, &shot, &e);
            if (surface_point_pole_distance(s.surface, shot.a.jet.r, &(struct vec3){0}) < 0.2)
                assert_false(found);
            tried++;
            refused += !found;
            if (found)
                worst = fmax(worst, fmax(e.angle, e.length));
        }
    printf("[     note ] refused %d of %d; else off by %.1e at the most\n", refused, tried, worst);
    check_below(refused, tried);
    check_below(worst, 2e-6);
    arena_free(s.arena);
}

/* There and back is the same line. */
static void test_relaxation_is_the_same_from_both_ends(void **state) {
    (void)state;
    struct subject s;
    struct shot shot;
    struct relaxation there, back;
    make_saddle(&s);
    must_shoot(&s, 0.3, 0.4, 70, 0.4, &shot);
    assert_true(relaxation_solve(s.surface, &shot.a, &shot.b, 9, &there));
    assert_true(relaxation_solve(s.surface, &shot.b, &shot.a, 9, &back));
    for (int k = 0; k < 9; k++)
        for (int n = 0; n < 2; n++) {
            double shift = shot.b.uv[n] - shot.a.uv[n];
            check_below(fabs(there.y[k][n] - shift - back.y[8 - k][n]), 1e-13);
            check_below(fabs(there.y[k][2 + n] + back.y[8 - k][2 + n]), 1e-12);
        }
    arena_free(s.arena);
}

/* ---- step control ---- */

/* How far from B a geodesic sent off with the velocity that was found arrives, relative to its
 * length. */
static double arrival(struct subject *s, const struct shot *shot, const struct relaxation *path) {
    struct path line;
    struct surface_point end;
    const double *y = path->y[0];
    struct vec3 v = vec3_axpy(y[3], shot->a.jet.v, vec3_scale(y[2], shot->a.jet.u));
    assert_true(path_geodesic(&line, s->surface, &shot->a, v));
    assert_true(path_advance(&line, vec3_norm(v)));
    assert_true(path_surface_point(&line, &s->cursor, &end, NULL));
    return vec3_distance(end.jet.r, shot->b.jet.r) / vec3_norm(v);
}

/* One bicubic span over [0, 1]^2 with steep hills and weights from 0.3 to 3. */
static void make_wild(struct subject *s, struct random *random) {
    static const double knots[] = {0, 0, 0, 0, 1, 1, 1, 1};
    for (int k = 0; k < 16; k++) {
        double x = k / 4, y = k % 4;
        s->points[k] =
            vec3_make(x + random_between(random, -0.3, 0.3), y + random_between(random, -0.3, 0.3),
                      random_between(random, -4, 4));
        s->weights[k] = random_between(random, 0.3, 3);
    }
    struct nurbs nurbs = {{3, 4, knots, 8}, {3, 4, knots, 8}, s->points, 16, s->weights, 16};
    subject_make(s, "wild", &nurbs);
}

static bool inside(const struct surface_point *point) {
    return fabs(point->uv[0] - 0.5) <= 0.5 && fabs(point->uv[1] - 0.5) <= 0.5;
}

/* Lines across steep hills, where the straight line in (u, v) is a poor start and undamped Newton
 * gets lost. What comes out is a geodesic all the same: sent off with its velocity, it arrives, as
 * far as the mesh can tell. Always the same lines, for hard ones are rare. */
static void test_relaxation_halves_steps_that_do_not_help(void **state) {
    (void)state;
    struct random random = {20};
    int tried = 0, found = 0, halved = 0, halvings = 0, iterations = 0;
    double worst = 0;
    while (tried < 400) {
        struct subject s;
        struct shot shot;
        struct relaxation path;
        make_wild(&s, &random);
        const double uv[2] = {random_between(&random, 0, 1), random_between(&random, 0, 1)};
        if (shoot(&s, uv, random_between(&random, 0, 360), 3.5, &shot) && inside(&shot.b)) {
            tried++;
            if (relaxation_solve(s.surface, &shot.a, &shot.b, 33, &path)) {
                found++;
                iterations += path.iterations;
                if (path.halvings > 0) {
                    halved++;
                    halvings += path.halvings;
                    worst = fmax(worst, arrival(&s, &shot, &path));
                }
            }
        }
        arena_free(s.arena);
    }
    printf(
        "[     note ] found %d of %d, %d of them with %d halvings, in %.1f iterations; they miss "
        "by %.1e of their length at the most\n",
        found, tried, halved, halvings, (double)iterations / found, worst);
    check_above(found, 9 * tried / 10);
    check_above(halved, 3);
    check_below(worst, 0.05);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_relaxation_is_of_second_order_in_the_mesh),
        cmocka_unit_test(test_relaxation_is_of_second_order_on_random_surfaces),
        cmocka_unit_test(test_relaxation_tangents_agree_with_shooting),
        cmocka_unit_test(test_relaxation_tangents_on_random_surfaces),
        cmocka_unit_test(test_relaxation_crosses_seams_and_knots),
        cmocka_unit_test(test_relaxation_refuses_near_poles),
        cmocka_unit_test(test_relaxation_is_the_same_from_both_ends),
        cmocka_unit_test(test_relaxation_halves_steps_that_do_not_help),
    };
    return cmocka_run_group_tests_name("relaxation", tests, NULL, NULL);
}
