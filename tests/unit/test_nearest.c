/* SPDX-License-Identifier: MIT */
#include "../../solver/surface.h"

#include "check.h"
#include "patch.h"
#include "support.h"
#include <float.h>
#include <math.h>

enum { SURFACES = 60, POINTS = 20, GRID = 120 };

/* The least distance to a fine grid of points of the surface: no less than the true one. */
static double search(const struct surface *surface, struct vec3 point) {
    struct surface_cursor cursor = {0};
    double lower[2], upper[2], least = DBL_MAX;
    surface_domain(surface, lower, upper);
    for (int i = 0; i <= GRID; i++)
        for (int j = 0; j <= GRID; j++) {
            struct surface_jet jet;
            surface_evaluate(surface, &cursor, lower[0] + (upper[0] - lower[0]) * i / GRID,
                             lower[1] + (upper[1] - lower[1]) * j / GRID, &jet);
            least = fmin(least, vec3_distance(jet.r, point));
        }
    return least;
}

/* Inside the domain, at the distance it says, and a place where no step to the side helps. */
static void assert_minimum(const struct surface *surface, struct vec3 point, const double uv[2],
                           double distance) {
    struct surface_cursor cursor = {0};
    struct surface_jet jet;
    double lower[2], upper[2];
    surface_domain(surface, lower, upper);
    assert_true(uv[0] >= lower[0] && uv[0] <= upper[0]);
    assert_true(uv[1] >= lower[1] && uv[1] <= upper[1]);
    surface_evaluate(surface, &cursor, uv[0], uv[1], &jet);
    assert_true(fabs(vec3_distance(jet.r, point) - distance) <= 1e-12 * (1 + distance));
    struct vec3 offset = vec3_sub(jet.r, point), tangent[2] = {jet.u, jet.v};
    for (int k = 0; k < 2; k++) {
        double slope = vec3_dot(offset, tangent[k]) / vec3_norm(tangent[k]);
        bool held = (uv[k] == lower[k] && slope > 0) || (uv[k] == upper[k] && slope < 0);
        assert_true(held || fabs(slope) < 1e-7 * (1 + distance));
    }
}

static void for_random_surfaces(void (*check)(const struct surface *surface, struct random *random),
                                const char *name) {
    struct random random = random_begin(name);
    for (int k = 0; k < SURFACES; k++) {
        struct patch patch;
        struct surface *surface;
        /* Degree 3 and more: a repeated knot leaves no crease, where no slope would vanish. */
        struct patch_kind kind = {3 + random_index(&random, NURBS_DEGREE_MAX - 2),
                                  3 + random_index(&random, NURBS_DEGREE_MAX - 2), k % 2 == 0,
                                  k % 4 < 2};
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
        assert_minimum(surface, jet.r, uv, distance);
        assert_true(distance < 1e-9);
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
        assert_true(distance <= fabs(off) + 1e-12);
    }
}

static void test_nearest_of_a_point_near_the_surface(void **state) {
    (void)state;
    for_random_surfaces(check_near, __func__);
}

/* Far away the nearest point may be one of many that are about as near: it must be one of those. */
static void check_anywhere(const struct surface *surface, struct random *random) {
    struct vec3 low, high;
    surface_bounds(surface, &low, &high);
    for (int k = 0; k < POINTS; k++) {
        struct vec3 point = {random_between(random, low.x - 2, high.x + 2),
                             random_between(random, low.y - 2, high.y + 2),
                             random_between(random, low.z - 2, high.z + 2)};
        double uv[2], distance, found = search(surface, point);
        surface_nearest(surface, point, uv, &distance);
        if (!(distance <= 1.1 * found))
            fail_msg("%g %g %g: distance %g, but a sample is at %g", point.x, point.y, point.z,
                     distance, found);
    }
}

static void test_nearest_is_no_further_than_any_sample(void **state) {
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
    assert_true(fabs(uv[0] - 0.25) < 1e-12 && fabs(uv[1] - 0.75) < 1e-12);
    assert_true(fabs(distance - 2) < 1e-14);
    surface_nearest(surface, vec3_make(4, -4, 0), uv, &distance);
    assert_true(uv[0] == 1 && uv[1] == 0 && fabs(distance - 5) < 1e-14);
    surface_nearest(surface, vec3_make(0.5, 3, 0), uv, &distance);
    assert_true(fabs(uv[0] - 0.5) < 1e-12 && uv[1] == 1 && distance == 2);
    arena_free(arena);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_nearest_point_of_the_surface_is_itself),
        cmocka_unit_test(test_nearest_of_a_point_near_the_surface),
        cmocka_unit_test(test_nearest_is_no_further_than_any_sample),
        cmocka_unit_test(test_nearest_of_a_square_is_known),
    };
    return cmocka_run_group_tests_name("nearest", tests, NULL, NULL);
}
