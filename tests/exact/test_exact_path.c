/* SPDX-License-Identifier: MIT */
/* Paths past the corners of spans: on a sphere, split as one likes, geodesics are great circles. */
#include "shapes.h"
#include "solver/surface/path.h"
#include "tests/check.h"
#include <stdio.h>

enum { DIRECTIONS = 24 };
static const double split[2] = {0.1, -0.13}; /* the knots inserted in u and v */
static const double half = 0.4;              /* length before and after the corner, radius 1 */

static void chart(struct vec3 r, double uv[2]) {
    uv[0] = r.x / (1 + r.z);
    uv[1] = r.y / (1 + r.z);
}

/* The great circle from the unit vector r along the unit tangent t. */
static struct vec3 circle(struct vec3 r, struct vec3 t, double length) {
    return vec3_axpy(sin(length), t, vec3_scale(cos(length), r));
}

static struct surface *split_sphere(struct shape *shape, struct arena *arena) {
    const double range[2] = {-0.5, 0.5};
    struct surface *surface;
    shape_stereographic(shape, 1, range, range);
    for (int k = 0; k < 2; k++)
        shape_insert_knot(shape, k, split[k]);
    struct nurbs nurbs = shape_nurbs(shape);
    assert_int_equal(surface_make(&nurbs, arena, &surface), STATUS_OK);
    return surface;
}

/* How far a geodesic ends from the great circle that passes the corner by about `miss`, under the
 * given angle. */
static double error_past_corner(const struct surface *surface, struct vec3 corner, double angle,
                                double miss) {
    struct vec3 east = vec3_unit(vec3_cross((struct vec3){0, 1, 0}, corner));
    struct vec3 t = vec3_axpy(sin(angle), vec3_cross(corner, east), vec3_scale(cos(angle), east));
    struct vec3 r = circle(corner, t, -half), end;
    struct vec3 ahead = vec3_axpy(sin(half), corner, vec3_scale(cos(half), t));
    struct vec3 turned = circle(ahead, vec3_cross(r, ahead), miss / sin(half));
    struct surface_cursor cursor = {0, 0};
    struct station from, to;
    struct path path;
    double uv[2];
    chart(r, uv);
    assert_true(station_at(surface, &cursor, uv, &from));
    assert_true(path_geodesic(&path, surface, &from, turned));
    assert_true(path_advance(&path, 2 * half));
    assert_true(path_station(&path, &cursor, &to, NULL));
    end = circle(r, turned, 2 * half);
    return vec3_distance(end, to.jet.r);
}

/* A path that meets one edge within a hair's breadth of another must not take them in the wrong
 * order: it would go on from beyond the edge it missed, and never meet it. */
static void test_exact_path_passes_corners_of_spans(void **state) {
    static const double misses[] = {0, 1e-3, 1e-5, 1e-7, 1e-8, 1e-9, 1e-11, 1e-13};
    static struct shape shape;
    struct arena *arena = arena_new((size_t)1 << 24);
    struct surface *surface = split_sphere(&shape, arena);
    struct vec3 corner = shape_point(&shape, split);
    double worst = 0;
    (void)state;
    for (int k = 0; k < DIRECTIONS; k++)
        for (size_t m = 0; m < sizeof misses / sizeof *misses; m++)
            for (int side = -1; side <= 1; side += 2)
                worst =
                    fmax(worst, error_past_corner(surface, corner, 0.1 + 2 * M_PI * k / DIRECTIONS,
                                                  side * misses[m]));
    printf("  largest error %.1e\n", worst);
    check_below(worst, 1e-12);
    arena_free(arena);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_exact_path_passes_corners_of_spans),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
