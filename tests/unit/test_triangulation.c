/* SPDX-License-Identifier: MIT */
/* Triangulations of points in the plane that have given edges: they cover the hull once, have all
 * the edges, and are Delaunay's elsewhere. */
#include "solver/mesh/triangulation.h"

#include "own_arena.h"
#include "support.h"
#include "tests/check.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { POINTS = 600, SPOKES = 24 };

static struct vec3 corner(const struct triangulation *t, size_t triangle, int k) {
    return t->points[t->corners[triangle][k]];
}

static double area(const struct triangulation *t, size_t triangle) {
    struct vec3 a = corner(t, triangle, 0);
    return vec3_cross(vec3_sub(corner(t, triangle, 1), a), vec3_sub(corner(t, triangle, 2), a)).z /
           2;
}

/* The region of a place, by the triangle that it is in; -1 where there is none. */
static int32_t region_at(const struct triangulation *t, double x, double y) {
    struct vec3 r = vec3_make(x, y, 0);
    for (size_t n = 0; n < t->count; n++) {
        bool inside = true;
        for (int k = 0; k < 3; k++) {
            struct vec3 a = corner(t, n, k), b = corner(t, n, (k + 1) % 3);
            inside = inside && vec3_cross(vec3_sub(b, a), vec3_sub(r, a)).z >= 0;
        }
        if (inside)
            return t->region[n];
    }
    return -1;
}

/* Neighbours know each other, no triangle is turned over, and Euler's formula holds. */
static void check_whole(const struct triangulation *t, size_t distinct) {
    assert_int_equal(t->count, 2 * (distinct + 3) - 5);
    double sum = 0;
    for (size_t n = 0; n < t->count; n++) {
        check_above(area(t, n), -1e-15);
        sum += area(t, n);
        for (int k = 0; k < 3; k++) {
            int32_t other = t->beyond[n][k];
            if (other < 0)
                continue;
            int back = 0;
            while (t->beyond[other][back] != (int32_t)n)
                back++;
            assert_int_equal(t->corners[other][back], t->corners[n][(k + 1) % 3]);
            assert_int_equal(t->corners[other][(back + 1) % 3], t->corners[n][k]);
            assert_int_equal(t->fixed[other][back], t->fixed[n][k]);
        }
    }
    check_below(fabs(sum - 1800), 1e-9); /* of the triangle round all */
}

/* A star with hidden corners: its inside is one region, found by area and by place. */
static void test_triangulation_has_given_edges(void **state) {
    static double points[POINTS][2];
    static int32_t edges[SPOKES][2];
    (void)state;
    struct random random = random_begin("triangulation");
    double star = 0;
    for (int k = 0; k < SPOKES; k++) {
        double angle = 2 * M_PI * k / SPOKES, radius = k % 2 ? 0.12 : 0.45;
        points[k][0] = 0.5 + radius * cos(angle);
        points[k][1] = 0.5 + radius * sin(angle);
        edges[k][0] = k;
        edges[k][1] = (k + 1) % SPOKES;
        star += 0.5 * 0.12 * 0.45 * sin(2 * M_PI / SPOKES);
    }
    for (int k = SPOKES; k < POINTS; k++)
        for (int x = 0; x < 2; x++)
            points[k][x] = k % 3 ? random_between(&random, 0.05, 0.95)
                                 : floor(random_between(&random, 0, 21)) / 20; /* on a grid */
    struct triangulation *t;
    assert_int_equal(triangulate((const double(*)[2])points, POINTS, (const int32_t(*)[2])edges,
                                 SPOKES, arena, &t),
                     STATUS_OK);
    size_t distinct = 0;
    for (int k = 0; k < POINTS; k++)
        distinct += t->same[k] == k;
    assert_int_equal(t->missed, 0);
    check_whole(t, distinct);
    assert_int_equal(t->region_count, 2);
    int32_t inside = region_at(t, 0.5, 0.5), outside = region_at(t, 0.01, 0.99);
    assert_true(inside >= 0 && outside >= 0 && inside != outside);
    double found = 0;
    for (size_t n = 0; n < t->count; n++)
        found += t->region[n] == inside ? area(t, n) : 0;
    check_below(fabs(found - star), 1e-12);
}

/* No corner of a neighbour lies in the circle round a triangle, but for rounding. */
static void test_triangulation_is_delaunays(void **state) {
    static double points[POINTS][2];
    (void)state;
    struct random random = random_begin("triangulation");
    struct triangulation *t;
    for (int k = 0; k < POINTS; k++)
        for (int x = 0; x < 2; x++)
            points[k][x] = random_between(&random, 0, 1);
    assert_int_equal(triangulate((const double(*)[2])points, POINTS, NULL, 0, arena, &t),
                     STATUS_OK);
    check_whole(t, POINTS);
    for (size_t n = 0; n < t->count; n++)
        for (int k = 0; k < 3; k++) {
            int32_t other = t->beyond[n][k];
            for (int far = 0; other >= 0 && far < 3; far++) {
                struct vec3 d = corner(t, (size_t)other, far), e[3];
                double determinant = 0, scale = 0;
                for (int c = 0; c < 3; c++) {
                    e[c] = vec3_sub(corner(t, n, c), d);
                    scale = fmax(scale, vec3_norm(e[c]));
                }
                for (int c = 0; c < 3; c++)
                    determinant += vec3_norm2(e[c]) * vec3_cross(e[(c + 1) % 3], e[(c + 2) % 3]).z;
                check_below(determinant, 1e-9 * scale * scale * scale * scale);
            }
        }
}

/* An edge across another one is counted, and the first stays. */
static void test_triangulation_counts_edges_that_cross(void **state) {
    static const double points[4][2] = {{0.1, 0.1}, {0.9, 0.9}, {0.1, 0.9}, {0.9, 0.1}};
    static const int32_t edges[2][2] = {{0, 1}, {2, 3}};
    (void)state;
    struct triangulation *t;
    assert_int_equal(triangulate(points, 4, edges, 2, arena, &t), STATUS_OK);
    assert_int_equal(t->missed, 1);
    check_whole(t, 4);
    static const double bad[1][2] = {{NAN, 0}};
    assert_int_equal(triangulate(bad, 1, NULL, 0, arena, &t), STATUS_INVALID);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_triangulation_has_given_edges, set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_triangulation_is_delaunays, set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_triangulation_counts_edges_that_cross, set_up,
                                        tear_down),
    };
    return cmocka_run_group_tests_name("triangulation", tests, NULL, NULL);
}
