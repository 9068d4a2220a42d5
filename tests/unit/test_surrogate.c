/* SPDX-License-Identifier: MIT */
#include "api/study/surrogate.h"

#include "tests/check.h"
#include <math.h>
#include <string.h>

enum { SIDE_MOST = 17, POINTS_MOST = SIDE_MOST * SIDE_MOST };

/* Two functions at once: one that is linear, and sin 2x cos 2y. */
static void functions(const struct surrogate_point *p, double value[2]) {
    value[0] = 3 - 2 * p->x[0] + 0.5 * p->x[1];
    value[1] = sin(2 * p->x[0]) * cos(2 * p->x[1]);
}

static struct surrogate_point at(double x, double y) {
    return (struct surrogate_point){{x, y}};
}

/* Of a square of side x side points from (0, 0) to (1, 1), all other coordinates 0. */
static struct surrogate of_square(int side, struct arena *arena) {
    static struct surrogate_point points[POINTS_MOST];
    double value[2 * POINTS_MOST];
    struct surrogate surrogate;
    for (int k = 0; k < side * side; k++) {
        points[k] = at(k % side / (side - 1.0), k / side / (side - 1.0));
        functions(&points[k], value + 2 * k);
    }
    assert_int_equal(surrogate_make(points, value, (size_t)(side * side), 2, arena, &surrogate),
                     STATUS_OK);
    return surrogate;
}

/* Its greatest errors between the points, away from their border. */
static void errors_of(int side, double error[2]) {
    struct arena *arena = arena_new((size_t)1 << 28);
    struct surrogate surrogate = of_square(side, arena);
    error[0] = error[1] = 0;
    for (int k = 0; k < 400; k++) {
        struct surrogate_point p = at(0.3 + 0.4 * (k % 20) / 19, 0.3 + 0.4 * (k / 20) / 19);
        double own[SURROGATE_VALUES_MOST], exact[2], nearest;
        surrogate_at(&surrogate, &p, own, &nearest);
        functions(&p, exact);
        check_at_most(nearest, 0.5 / ((side - 1.0) * (side - 1.0)) + 1e-12);
        for (int f = 0; f < 2; f++)
            error[f] = fmax(error[f], fabs(own[f] - exact[f]));
    }
    arena_free(arena);
}

/* It has linear functions as they are, and others with an error of the order h^3 within. */
static void test_surrogate_is_exact_for_linear_and_of_third_order(void **state) {
    double coarse[2], fine[2];
    (void)state;
    errors_of(9, coarse);
    errors_of(SIDE_MOST, fine);
    check_at_most(coarse[0], 1e-6);
    check_at_most(fine[0], 1e-6);
    check_at_most(coarse[1], 2e-3);
    check_at_most(fine[1], coarse[1] / 6);
}

static void test_surrogate_has_the_values_of_its_points(void **state) {
    struct arena *arena = arena_new((size_t)1 << 28);
    struct surrogate surrogate = of_square(9, arena);
    (void)state;
    for (size_t k = 0; k < surrogate.count; k++) {
        double own[SURROGATE_VALUES_MOST], exact[2], nearest;
        surrogate_at(&surrogate, &surrogate.points[k], own, &nearest);
        functions(&surrogate.points[k], exact);
        check_at_most(nearest, 0);
        check_at_most(fabs(own[0] - exact[0]), 1e-6);
        check_at_most(fabs(own[1] - exact[1]), 1e-5);
    }
    arena_free(arena);
}

/* What the same place has twice is about the mean; one point alone is a constant. */
static void test_surrogate_of_equal_points(void **state) {
    struct arena *arena = arena_new((size_t)1 << 20);
    struct surrogate_point points[] = {at(0, 0), at(1, 0), at(0, 1), at(1, 1), at(1, 1)};
    const double value[] = {0, 1, 2, 3, 5};
    struct surrogate surrogate;
    double own[SURROGATE_VALUES_MOST], nearest;
    (void)state;
    assert_int_equal(surrogate_make(points, value, 5, 1, arena, &surrogate), STATUS_OK);
    surrogate_at(&surrogate, &points[4], own, &nearest);
    check_at_most(fabs(own[0] - 4), 1e-3);
    assert_int_equal(surrogate_make(points, value + 4, 1, 1, arena, &surrogate), STATUS_OK);
    surrogate_at(&surrogate, &points[3], own, &nearest);
    check_at_most(fabs(own[0] - 5), 1e-3);
    check_at_most(fabs(nearest - 2), 1e-12);
    arena_free(arena);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_surrogate_is_exact_for_linear_and_of_third_order),
        cmocka_unit_test(test_surrogate_has_the_values_of_its_points),
        cmocka_unit_test(test_surrogate_of_equal_points),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
