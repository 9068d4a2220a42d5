/* SPDX-License-Identifier: MIT */
#include "solver/shell/shell.h"
#include "solver/shell/surface_point.h"
#include "solver/surface/surface.h"
#include "solver/surface/trim.h"

#include "patch.h"
#include "support.h"
#include "tests/check.h"
#include <float.h>
#include <math.h>

enum { SURFACES = 60, POINTS = 20, GRID = 120 };

/* A surface and what is asked of it. */
struct question {
    const struct surface *surface;
    struct surface_cursor cursor;
    struct vec3 point;
    double lower[2], upper[2]; /* the domain */
};

static struct question question_make(const struct surface *surface, struct vec3 point) {
    struct question q = {.surface = surface, .point = point};
    surface_domain(surface, q.lower, q.upper);
    return q;
}

static double distance_at(struct question *q, double u, double v) {
    struct surface_jet jet;
    surface_evaluate(q->surface, &q->cursor, u, v, &jet);
    return vec3_distance(jet.r, q->point);
}

static double within(const struct question *q, int k, double x) {
    return fmin(fmax(x, q->lower[k]), q->upper[k]);
}

/* Walks downhill in eight directions by steps that are halved when none helps: needs no
 * derivatives, so creases and edges are nothing special to it. */
static double walk_downhill(struct question *q, double u, double v, double step) {
    double least = distance_at(q, u, v);
    for (int halvings = 0; halvings < 28;) {
        double best[2] = {u, v}, before = least;
        for (int k = 0; k < 9; k++) {
            double x = within(q, 0, u + (k / 3 - 1) * step * (q->upper[0] - q->lower[0]));
            double y = within(q, 1, v + (k % 3 - 1) * step * (q->upper[1] - q->lower[1]));
            double distance = distance_at(q, x, y);
            if (distance < least) {
                least = distance;
                best[0] = x;
                best[1] = y;
            }
        }
        u = best[0];
        v = best[1];
        if (least < before)
            continue;
        step /= 2;
        halvings++;
    }
    return least;
}

/* The least distance found from the samples of a grid that are nearer than those beside them: no
 * less than the true one, and nearly always that. */
static double search(const struct surface *surface, struct vec3 point) {
    static double grid[GRID + 1][GRID + 1];
    struct question q = question_make(surface, point);
    double least = DBL_MAX, place[2][GRID + 1];
    for (int k = 0; k < 2; k++)
        for (int i = 0; i <= GRID; i++)
            place[k][i] = q.lower[k] + (q.upper[k] - q.lower[k]) * i / GRID;
    for (int i = 0; i <= GRID; i++)
        for (int j = 0; j <= GRID; j++)
            grid[i][j] = distance_at(&q, place[0][i], place[1][j]);
    for (int i = 0; i <= GRID; i++)
        for (int j = 0; j <= GRID; j++) {
            double d = grid[i][j];
            if ((i > 0 && grid[i - 1][j] < d) || (i < GRID && grid[i + 1][j] < d) ||
                (j > 0 && grid[i][j - 1] < d) || (j < GRID && grid[i][j + 1] < d))
                continue;
            least = fmin(least, walk_downhill(&q, place[0][i], place[1][j], 1.0 / GRID));
        }
    return least;
}

/* Moving a parameter from uv to a side does not bring the point nearer. The side's tangent is taken
 * just off uv, where a crease at uv is out of the way. */
static void assert_no_descent(struct question *q, const double uv[2], double distance, int k,
                              double side) {
    const double offset = 1e-10 * (q->upper[k] - q->lower[k]);
    double at[2] = {uv[0], uv[1]};
    struct surface_jet jet;
    at[k] = within(q, k, uv[k] + side * offset);
    if (fabs(at[k] - uv[k]) < offset / 2)
        return;
    surface_evaluate(q->surface, &q->cursor, at[0], at[1], &jet);
    struct vec3 tangent = k == 0 ? jet.u : jet.v;
    double slope = side * vec3_dot(vec3_sub(jet.r, q->point), tangent) / vec3_norm(tangent);
    if (!(slope > -1e-7 * (1 + distance)))
        fail_msg("slope %g in direction %d, side %g, at distance %g", slope, k, side, distance);
}

/* Inside the domain, at the distance it says, and a place where no step to a side helps. */
static void assert_minimum(const struct surface *surface, struct vec3 point, const double uv[2],
                           double distance) {
    struct question q = question_make(surface, point);
    check_at_least(uv[0], q.lower[0]);
    check_at_most(uv[0], q.upper[0]);
    check_at_least(uv[1], q.lower[1]);
    check_at_most(uv[1], q.upper[1]);
    check_at_most(fabs(distance_at(&q, uv[0], uv[1]) - distance), 1e-12 * (1 + distance));
    for (int k = 0; k < 2; k++) {
        assert_no_descent(&q, uv, distance, k, -1);
        assert_no_descent(&q, uv, distance, k, 1);
    }
}

static void for_random_surfaces(void (*check)(const struct surface *surface, struct random *random),
                                const char *name) {
    struct random random = random_begin(name);
    for (int k = 0; k < SURFACES; k++) {
        struct patch patch;
        struct surface *surface;
        /* Every other one of degree 1 to 3, with creases where knots are repeated. */
        int degrees = k % 8 < 4 ? 3 : NURBS_DEGREE_MAX;
        struct patch_kind kind = {1 + random_index(&random, degrees),
                                  1 + random_index(&random, degrees), k % 2 == 0, k % 4 < 2};
        struct arena *arena = arena_new((size_t)1 << 26);
        patch_make(&patch, &kind, &random);
        assert_int_equal(surface_make(&patch.nurbs, arena, &surface), STATUS_OK);
        check(surface, &random);
        arena_free(arena);
    }
}

static void check_on_surface(const struct surface *surface, struct random *random) {
    struct surface_cursor cursor = {0};
    double lower[2], upper[2];
    surface_domain(surface, lower, upper);
    for (int k = 0; k < POINTS; k++) {
        struct surface_jet jet;
        double uv[2], distance;
        surface_evaluate(surface, &cursor, random_between(random, lower[0], upper[0]),
                         random_between(random, lower[1], upper[1]), &jet);
        surface_nearest(surface, jet.r, uv, &distance);
        if (!(distance < 1e-9))
            fail_msg("%g %g %g: distance %g of a point of the surface", jet.r.x, jet.r.y, jet.r.z,
                     distance);
    }
}

static void test_nearest_point_of_the_surface_is_itself(void **state) {
    (void)state;
    for_random_surfaces(check_on_surface, __func__);
}

/* A little off the surface, along its normal. */
static void check_near(const struct surface *surface, struct random *random) {
    struct surface_cursor cursor = {0};
    double lower[2], upper[2];
    surface_domain(surface, lower, upper);
    for (int k = 0; k < POINTS; k++) {
        struct surface_jet jet;
        double uv[2], distance, off = random_between(random, -0.02, 0.02);
        surface_evaluate(surface, &cursor, random_between(random, lower[0], upper[0]),
                         random_between(random, lower[1], upper[1]), &jet);
        struct vec3 point = vec3_axpy(off, vec3_unit(vec3_cross(jet.u, jet.v)), jet.r);
        surface_nearest(surface, point, uv, &distance);
        assert_minimum(surface, point, uv, distance);
        check_at_most(distance, fabs(off) + 1e-12);
    }
}

static void test_nearest_of_a_point_near_the_surface(void **state) {
    (void)state;
    for_random_surfaces(check_near, __func__);
}

static void check_anywhere(const struct surface *surface, struct random *random) {
    struct vec3 low, high;
    surface_bounds(surface, &low, &high);
    for (int k = 0; k < POINTS; k++) {
        struct vec3 point = {random_between(random, low.x - 2, high.x + 2),
                             random_between(random, low.y - 2, high.y + 2),
                             random_between(random, low.z - 2, high.z + 2)};
        double uv[2], distance, found = search(surface, point);
        surface_nearest(surface, point, uv, &distance);
        assert_minimum(surface, point, uv, distance);
        if (!(distance <= found + 1e-9 * (1 + found)))
            fail_msg("%g %g %g: distance %.12g, another place is at %.12g", point.x, point.y,
                     point.z, distance, found);
    }
}

static void test_nearest_is_no_further_than_any_place(void **state) {
    (void)state;
    for_random_surfaces(check_anywhere, __func__);
}

/* Beyond a corner of a flat square, and above it. */
static void test_nearest_of_a_square_is_known(void **state) {
    (void)state;
    static const double knots[] = {0, 0, 1, 1};
    static const struct vec3 points[] = {{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {1, 1, 0}};
    const struct nurbs_axis axis = {1, 2, knots, 4};
    const struct nurbs nurbs = {.u = axis, .v = axis, .points = points, .point_count = 4};
    struct arena *arena = arena_new(1 << 20);
    struct surface *surface;
    double uv[2], distance;
    assert_int_equal(surface_make(&nurbs, arena, &surface), STATUS_OK);
    surface_nearest(surface, vec3_make(0.25, 0.75, -2), uv, &distance);
    check_below(fabs(uv[0] - 0.25), 1e-12);
    check_below(fabs(uv[1] - 0.75), 1e-12);
    check_below(fabs(distance - 2), 1e-14);
    surface_nearest(surface, vec3_make(4, -4, 0), uv, &distance);
    assert_true(uv[0] == 1 && uv[1] == 0 && fabs(distance - 5) < 1e-14);
    surface_nearest(surface, vec3_make(0.5, 3, 0), uv, &distance);
    assert_true(fabs(uv[0] - 0.5) < 1e-12 && uv[1] == 1 && distance == 2);
    arena_free(arena);
}

/* ---- creases, poles and centres ---- */

/* On coarse surfaces of degree 1 and 2 the way down ends at a crease more often than not. */
static void test_nearest_is_not_held_by_creases(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    for (int k = 0; k < 4 * SURFACES; k++) {
        struct patch patch;
        struct surface *surface;
        struct patch_kind kind = {1 + k % 2, 1 + k / 2 % 2, k % 8 < 4, k % 16 < 8};
        struct arena *arena = arena_new((size_t)1 << 26);
        patch_make(&patch, &kind, &random);
        assert_int_equal(surface_make(&patch.nurbs, arena, &surface), STATUS_OK);
        check_on_surface(surface, &random);
        check_near(surface, &random);
        arena_free(arena);
    }
}

/* The sphere of radius 2 about (5, -3, 2), poles in z. */
static struct surface *make_sphere(struct arena *arena) {
    static const double around[] = {0, 0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 4};
    static const double up[] = {0, 0, 0, 1, 1, 2, 2, 2};
    static const double x[] = {1, 1, 0, -1, -1, -1, 0, 1, 1}, y[] = {0, 1, 1, 1, 0, -1, -1, -1, 0};
    static const double radius[] = {0, 2, 2, 2, 0}, height[] = {-2, -2, 0, 2, 2};
    struct vec3 points[45];
    double weights[45];
    for (int k = 0; k < 45; k++) {
        int i = k / 5, j = k % 5;
        points[k] = vec3_make(5 + radius[j] * x[i], -3 + radius[j] * y[i], 2 + height[j]);
        weights[k] = (i % 2 ? sqrt(0.5) : 1) * (j % 2 ? sqrt(0.5) : 1);
    }
    const struct nurbs nurbs = {.u = {2, 9, around, 12},
                                .v = {2, 5, up, 8},
                                .points = points,
                                .point_count = 45,
                                .weights = weights,
                                .weight_count = 45};
    struct surface *surface;
    assert_int_equal(surface_make(&nurbs, arena, &surface), STATUS_OK);
    return surface;
}

/* On a pole and beside it the sphere bends as elsewhere, along every tangent. */
static void test_nearest_poles_bend_as_the_sphere(void **state) {
    (void)state;
    struct arena *arena = arena_new((size_t)1 << 22);
    struct surface *surface = make_sphere(arena);
    struct surface_cursor cursor = {0, 0};
    for (int k = 0; k < 100; k++) {
        double aside = k % 5 ? pow(10, -4 - 2 * (k % 5)) : 0;
        const double uv[2] = {k / 25.0, k % 2 ? aside : 2 - aside};
        struct surface_point point;
        assert_true(surface_point_at(surface, &cursor, uv, &point));
        struct vec3 a = vec3_unit(surface_point_tangent(&point, vec3_make(1, 0.1, 0)));
        struct vec3 b = vec3_cross(point.normal, a);
        double bend =
            surface_point_curvature(&cursor, &point, vec3_axpy(sin(k), b, vec3_scale(cos(k), a)));
        check_below(fabs(fabs(bend) - 0.5), 5e-6);
    }
    arena_free(arena);
}

/* As close to a pole as a billionth of the radius, on the sphere, inside and outside. */
static void test_nearest_beside_a_pole(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    struct arena *arena = arena_new((size_t)1 << 22);
    struct surface *surface = make_sphere(arena);
    for (int k = 0; k < 3000; k++) {
        double aside = pow(10, random_between(&random, -12, 0));
        double radius = k % 2 ? 2 : random_between(&random, 0.1, 4), uv[2], distance;
        struct vec3 way = {random_between(&random, -aside, aside),
                           random_between(&random, -aside, aside), k % 4 < 2 ? 1 : -1};
        struct vec3 point = vec3_axpy(radius, vec3_unit(way), vec3_make(5, -3, 2));
        surface_nearest(surface, point, uv, &distance);
        if (!(fabs(distance - fabs(radius - 2)) < 1e-9))
            fail_msg("%g beside the pole at radius %g: distance %.12g", aside, radius, distance);
    }
    arena_free(arena);
}

/* From the centre all of the sphere is as near; the search must see that, not wander. */
static void test_nearest_of_the_centre_of_a_sphere(void **state) {
    (void)state;
    struct arena *arena = arena_new((size_t)1 << 22);
    struct surface *surface = make_sphere(arena);
    for (int k = 0; k < 20; k++) {
        double off = k == 0 ? 0 : pow(10, -k), uv[2], distance;
        surface_nearest(surface, vec3_make(5 + 0.6 * off, -3 - 0.8 * off, 2), uv, &distance);
        check_below(fabs(distance - (2 - off)), 1e-9);
    }
    arena_free(arena);
}

/* What cannot be answered still comes back, with parameters of the domain. */
static void test_nearest_of_no_place_ends(void **state) {
    (void)state;
    static const double bad[] = {NAN, INFINITY, 1e200, -1e308};
    struct arena *arena = arena_new((size_t)1 << 22);
    struct surface *surface = make_sphere(arena);
    for (int k = 0; k < 4; k++) {
        double uv[2], distance;
        surface_nearest(surface, vec3_make(bad[k], 0, 1), uv, &distance);
        check_at_least(uv[0], 0);
        check_at_most(uv[0], 4);
        check_at_least(uv[1], 0);
        check_at_most(uv[1], 2);
        assert_true(!(distance < 1e200));
    }
    arena_free(arena);
}

/* ---- trimmed faces ---- */

enum { LOOP_POINTS = 12, LOOP_KNOTS = LOOP_POINTS + 4, LOOP_SAMPLES = 20000, FACES = 20 };

/* A closed cubic that keeps what lies within, round the middle of the domain 0..1; cut at its
 * knots. */
struct curved_loop {
    double points[LOOP_POINTS][2], knots[LOOP_KNOTS];
    struct trim_curve curve;
    struct trim_loop loop;
};

static void curved_loop_make(struct curved_loop *made, struct random *random) {
    for (int k = 0; k < LOOP_POINTS; k++) {
        double angle = 6.283185307179586 * (k % (LOOP_POINTS - 1)) / (LOOP_POINTS - 1);
        double radius = random_between(random, 0.1, 0.45);
        made->points[k][0] = 0.5 + radius * cos(angle);
        made->points[k][1] = 0.5 + radius * sin(angle);
    }
    for (int x = 0; x < 2; x++)
        made->points[LOOP_POINTS - 1][x] = made->points[0][x];
    for (int k = 0; k < LOOP_KNOTS; k++)
        made->knots[k] = fmin(fmax(k - 3, 0), LOOP_POINTS - 3);
    made->curve = (struct trim_curve){.degree = 3,
                                      .points = (const double(*)[2])made->points,
                                      .count = LOOP_POINTS,
                                      .knots = made->knots};
    made->loop = (struct trim_loop){.reversed = true, .curves = &made->curve, .count = 1};
}

/* How far the loop is from a point: no less than in truth, and by next to nothing more. */
static double distance_of_loop(const struct surface *surface, const struct curved_loop *loop,
                               struct vec3 point) {
    struct question q = question_make(surface, point);
    double least = DBL_MAX, nearest = 0, step = (LOOP_POINTS - 3.0) / LOOP_SAMPLES, uv[2];
    for (int k = -LOOP_SAMPLES; k < LOOP_SAMPLES; k++) {
        double t =
            k < 0 ? (k + LOOP_SAMPLES) * step : nearest + (2.0 * k / LOOP_SAMPLES - 1) * step;
        trim_curve_at(&loop->curve, t, uv, NULL);
        double distance = distance_at(&q, uv[0], uv[1]);
        if (distance < least && k < 0)
            nearest = t;
        least = fmin(least, distance);
    }
    return least;
}

/* A face's nearest place is where its surface comes nearest or, where that is cut away, on its
 * boundary: of points beside it and of those that are far from it all. */
static void test_nearest_of_trimmed_faces(void **state) {
    (void)state;
    struct random random = random_begin("nearest_of_trimmed_faces");
    struct arena *arena = arena_new((size_t)1 << 26);
    int cut_away = 0;
    for (int f = 0; f < FACES; f++) {
        static struct patch patch;
        struct curved_loop loop;
        struct surface *surface;
        struct shell *shell;
        double lower[2], upper[2];
        struct arena_mark mark = arena_mark(arena);
        patch_make(&patch, &(struct patch_kind){3, 3, true, f % 2 == 0}, &random);
        assert_int_equal(surface_make(&patch.nurbs, arena, &surface), STATUS_OK);
        curved_loop_make(&loop, &random);
        surface_domain(surface, lower, upper);
        for (int k = 0; k < LOOP_POINTS; k++)
            for (int x = 0; x < 2; x++)
                loop.points[k][x] = lower[x] + loop.points[k][x] * (upper[x] - lower[x]);
        const struct shell_patch face = {.surface = surface, .loops = &loop.loop, .loop_count = 1};
        assert_int_equal(shell_make(&face, 1, 0, arena, &shell, NULL), STATUS_OK);
        for (int k = 0; k < POINTS; k++) {
            struct vec3 low, high;
            struct shell_point place;
            struct surface_jet jet;
            struct surface_cursor cursor = {0};
            double out = k % 2 ? 0.1 : 2, uv[2], whole, distance;
            shell_bounds(shell, &low, &high);
            struct vec3 p = {random_between(&random, low.x, high.x),
                             random_between(&random, low.y, high.y),
                             high.z + out * (high.z - low.z)};
            shell_nearest(shell, p, SHELL_ANY, &place, &distance);
            surface_evaluate(surface, &cursor, place.uv[0], place.uv[1], &jet);
            check_at_most(fabs(vec3_distance(jet.r, p) - distance), 1e-12 * shell_size(shell));
            surface_nearest(surface, p, uv, &whole);
            bool inside = trim_contains(shell_trim(shell, 0), uv);
            double wanted = inside ? whole : distance_of_loop(surface, &loop, p);
            check_at_most(fabs(distance - wanted), 1e-8 * shell_size(shell));
            cut_away += !inside;
        }
        arena_rewind(arena, mark);
    }
    check_at_least(cut_away, FACES * POINTS / 4);
    arena_free(arena);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_nearest_point_of_the_surface_is_itself),
        cmocka_unit_test(test_nearest_of_a_point_near_the_surface),
        cmocka_unit_test(test_nearest_is_no_further_than_any_place),
        cmocka_unit_test(test_nearest_of_a_square_is_known),
        cmocka_unit_test(test_nearest_is_not_held_by_creases),
        cmocka_unit_test(test_nearest_poles_bend_as_the_sphere),
        cmocka_unit_test(test_nearest_beside_a_pole),
        cmocka_unit_test(test_nearest_of_the_centre_of_a_sphere),
        cmocka_unit_test(test_nearest_of_no_place_ends),
        cmocka_unit_test(test_nearest_of_trimmed_faces),
    };
    return cmocka_run_group_tests_name("nearest", tests, NULL, NULL);
}
