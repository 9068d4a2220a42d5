/* SPDX-License-Identifier: MIT */
/* Polygons made wider, against areas and distances that are known. */
#include "api/result/polygons.h"
#include "support.h"
#include "tests/check.h"
#include <math.h>

static void add(struct polygons *polygons, const double (*points)[2], size_t count) {
    for (size_t k = 0; k < count; k++)
        assert_true(polygons_add(polygons, points[k][0], points[k][1]));
    polygons_close(polygons);
}

static void add_circle(struct polygons *polygons, double x, double y, double radius, bool hole) {
    enum { SIDES = 720 };
    for (int k = 0; k < SIDES; k++) {
        double angle = (hole ? -1 : 1) * 2 * M_PI * k / SIDES;
        assert_true(polygons_add(polygons, x + radius * cos(angle), y + radius * sin(angle)));
    }
    polygons_close(polygons);
}

static size_t next_of(const struct polygons *p, size_t k, size_t *first) {
    size_t next = p->points[k].last ? *first : k + 1;
    *first = p->points[k].last ? k + 1 : *first;
    return next;
}

static double area_of(const struct polygons *p) {
    double area = 0;
    for (size_t k = 0, first = 0; k < p->count; k++) {
        const struct polygons_point *a = &p->points[k], *b = &p->points[next_of(p, k, &first)];
        area += (a->x * b->y - b->x * a->y) / 2;
    }
    return area;
}

static size_t loops_of(const struct polygons *p) {
    size_t loops = 0;
    for (size_t k = 0; k < p->count; k++)
        loops += p->points[k].last;
    return loops;
}

static double distance_from(const struct polygons *p, double x, double y) {
    double least = HUGE_VAL;
    for (size_t k = 0, first = 0; k < p->count; k++) {
        const struct polygons_point *a = &p->points[k], *b = &p->points[next_of(p, k, &first)];
        double dx = b->x - a->x, dy = b->y - a->y, l = dx * dx + dy * dy;
        double t = l > 0 ? fmin(fmax(((x - a->x) * dx + (y - a->y) * dy) / l, 0), 1) : 0;
        least = fmin(least, hypot(x - a->x - t * dx, y - a->y - t * dy));
    }
    return least;
}

static void test_polygons_widened_have_the_area_that_they_should(void **state) {
    static const double square[4][2] = {{0, 0}, {10, 0}, {10, 10}, {0, 10}};
    static const double corner[6][2] = {{0, 0}, {10, 0}, {10, 4}, {4, 4}, {4, 10}, {0, 10}};
    struct polygons polygons = {0}, wider = {0};
    (void)state;
    add(&polygons, square, 4);
    assert_true(polygons_widen(&polygons, (const double[]){1.5}, &wider));
    check_below(fabs(area_of(&wider) - (100 + 60 + M_PI * 2.25)), 0.02);
    assert_int_equal(loops_of(&wider), 1);
    polygons_free(&polygons);
    polygons_free(&wider);
    /* 36 of length, five corners that open and one that closes */
    add(&polygons, corner, 6);
    assert_true(polygons_widen(&polygons, (const double[]){1}, &wider));
    check_below(fabs(area_of(&wider) - (64 + 40 + 5 * M_PI / 4 - 1)), 0.02);
    polygons_free(&polygons);
    polygons_free(&wider);
}

/* A hole becomes smaller, and closes when it is too small; two parts grow together. */
static void test_polygons_widened_close_their_holes_and_gaps(void **state) {
    static const double left[4][2] = {{0, 0}, {4, 0}, {4, 4}, {0, 4}};
    static const double right[4][2] = {{5, 0}, {9, 0}, {9, 4}, {5, 4}};
    struct polygons polygons = {0}, wider = {0};
    (void)state;
    add_circle(&polygons, 0, 0, 10, false);
    add_circle(&polygons, 3, 0, 2, true);
    add_circle(&polygons, -3, 0, 0.7, true);
    assert_true(polygons_widen(&polygons, (const double[]){1}, &wider));
    assert_int_equal(loops_of(&wider), 2);
    check_below(fabs(area_of(&wider) - M_PI * (121 - 1)), 0.05);
    polygons_free(&polygons);
    polygons_free(&wider);
    add(&polygons, left, 4);
    add(&polygons, right, 4);
    assert_true(polygons_widen(&polygons, (const double[]){0.4}, &wider));
    assert_int_equal(loops_of(&wider), 2);
    polygons_free(&wider);
    assert_true(polygons_widen(&polygons, (const double[]){0.75}, &wider));
    assert_int_equal(loops_of(&wider), 1);
    polygons_free(&polygons);
    polygons_free(&wider);
}

/* A square of 10 with a wedge of 2 by 6 cut out of its lower edge, whose lips have a distance of
 * their own; and a slit without one. At the mouth the wider parts end at right angles to the edge.
 */
static void test_polygons_widened_have_a_distance_for_each_part(void **state) {
    static const double points[7][2] = {{0, 0}, {4, 0}, {5, 6}, {6, 0}, {10, 0}, {10, 10}, {0, 10}};
    const double lip = hypot(1, 6), angle = 2 * atan(1.0 / 6), own = 0.1;
    (void)state;
    for (int slit = 0; slit < 2; slit++)
        for (int beyond = 0; beyond < 2 - slit; beyond++)
            for (int turned = 0; turned < 7; turned++) {
                struct polygons polygons = {0}, wider = {0};
                for (int n = 0; n < 7; n++) {
                    int k = (n + turned) % 7;
                    double x = slit && (k == 1 || k == 3) ? 5 : points[k][0];
                    assert_true(polygons_add(&polygons, x, points[k][1]));
                    polygons.points[n].part = k == 1 || k == 2;
                }
                polygons_close(&polygons);
                const double distance[2] = {1, beyond ? own : 0};
                assert_true(polygons_widen(&polygons, distance, &wider));
                assert_int_equal(loops_of(&wider), 1);
                double mouth = slit ? 0 : 2, whole = 100 - mouth * 3;
                /* a margin, four corners; lips up to where their margins meet, and a little at the
                 * mouth beyond the edge */
                double expected = whole + 40 - mouth + M_PI;
                if (beyond)
                    expected += 2 * lip * own - own * own / tan(angle / 2) - own * own / 6;
                check_below(fabs(area_of(&wider) - expected), 0.02);
                polygons_free(&polygons);
                polygons_free(&wider);
            }
}

/* Stars with deep clefts: no point of the line is nearer than the distance, and none further. */
static void test_polygons_widened_run_at_the_distance(void **state) {
    struct random random = random_begin("widen");
    (void)state;
    for (int round = 0; round < check_sized(60, 10); round++) {
        struct polygons polygons = {0}, wider = {0};
        int points = 5 + random_index(&random, 60);
        double distance = random_between(&random, 0.05, 1.5);
        for (int k = 0; k < points; k++) {
            double angle = 2 * M_PI * k / points, radius = random_between(&random, 2, 10);
            assert_true(polygons_add(&polygons, radius * cos(angle), radius * sin(angle)));
        }
        polygons_close(&polygons);
        assert_true(polygons_widen(&polygons, (const double[]){distance}, &wider));
        check_above(area_of(&wider), area_of(&polygons));
        for (size_t k = 0; k < wider.count; k++) {
            double away = distance_from(&polygons, wider.points[k].x, wider.points[k].y);
            check_below(fabs(away / distance - 1), 0.02);
        }
        polygons_free(&polygons);
        polygons_free(&wider);
    }
}

static void test_polygons_simplified_stay_within_the_tolerance(void **state) {
    struct polygons whole = {0}, fewer = {0};
    (void)state;
    add_circle(&whole, 1, 2, 5, false);
    add_circle(&fewer, 1, 2, 5, false);
    polygons_simplify(&fewer, 1e-2);
    check_below(fewer.count, 120);
    for (size_t k = 0; k < whole.count; k++)
        check_below(distance_from(&fewer, whole.points[k].x, whole.points[k].y), 1.0001e-2);
    polygons_free(&whole);
    polygons_free(&fewer);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_polygons_widened_have_the_area_that_they_should),
        cmocka_unit_test(test_polygons_widened_close_their_holes_and_gaps),
        cmocka_unit_test(test_polygons_widened_have_a_distance_for_each_part),
        cmocka_unit_test(test_polygons_widened_run_at_the_distance),
        cmocka_unit_test(test_polygons_simplified_stay_within_the_tolerance),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
