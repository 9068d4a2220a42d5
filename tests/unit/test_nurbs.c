/* SPDX-License-Identifier: MIT */
#include "solver/surface/nurbs.h"

#include "support.h"
#include "tests/check.h"
#include <math.h>

enum { SIZE = 14, KNOTS = SIZE + NURBS_DEGREE_MAX + 1 };

/* A sound definition of degrees p and q, with its arrays: knots 0, 1, 2, ... (unclamped) or with
 * p + 1 equal ones at the ends. */
struct definition {
    double knots[2][KNOTS], weights[SIZE * SIZE];
    struct vec3 points[SIZE * SIZE];
    struct nurbs nurbs;
};

static void make_axis(struct nurbs_axis *axis, double *knots, int degree, bool clamped) {
    *axis = (struct nurbs_axis){degree, SIZE, knots, (size_t)(SIZE + degree + 1)};
    for (int i = 0; i < SIZE + degree + 1; i++)
        knots[i] = clamped ? fmin(fmax(i, degree), SIZE) : i;
}

static void definition_make(struct definition *d, int p, int q, bool clamped) {
    for (int i = 0; i < SIZE * SIZE; i++) {
        d->points[i] = vec3_make(i / SIZE, i % SIZE, i % 3);
        d->weights[i] = 1 + i % 2;
    }
    d->nurbs = (struct nurbs){.points = d->points,
                              .point_count = SIZE * SIZE,
                              .weights = d->weights,
                              .weight_count = SIZE * SIZE};
    make_axis(&d->nurbs.u, d->knots[0], p, clamped);
    make_axis(&d->nurbs.v, d->knots[1], q, clamped);
}

static void assert_fault(const struct definition *d, enum nurbs_member member, int has_index,
                         size_t index) {
    struct nurbs_fault fault = {0};
    assert_int_equal(nurbs_validate(&d->nurbs, &fault), STATUS_INVALID);
    assert_int_equal(nurbs_validate(&d->nurbs, NULL), STATUS_INVALID);
    assert_int_equal(fault.member, member);
    assert_int_equal(fault.has_index, has_index);
    if (has_index)
        assert_int_equal(fault.index, index);
    assert_true(fault.reason && fault.reason[0]);
}

/* Calls `check` for every pair of degrees, clamped and unclamped. */
static void for_all_degrees(void (*check)(struct definition *d, int p, int q)) {
    for (int p = 1; p <= NURBS_DEGREE_MAX; p++)
        for (int q = 1; q <= NURBS_DEGREE_MAX; q++)
            for (int clamped = 0; clamped < 2; clamped++) {
                struct definition d;
                definition_make(&d, p, q, clamped);
                check(&d, p, q);
            }
}

static void check_sound(struct definition *d, int p, int q) {
    (void)p;
    (void)q;
    assert_int_equal(nurbs_validate(&d->nurbs, NULL), STATUS_OK);
    d->nurbs.weights = NULL;
    d->nurbs.weight_count = 0;
    assert_int_equal(nurbs_validate(&d->nurbs, NULL), STATUS_OK);
}

static void test_nurbs_every_degree_is_accepted(void **state) {
    (void)state;
    for_all_degrees(check_sound);
}

static void check_knot_count(struct definition *d, int p, int q) {
    (void)p;
    (void)q;
    d->nurbs.v.knot_count--;
    assert_fault(d, NURBS_KNOTS_V, 0, 0);
    d->nurbs.u.knot_count--;
    assert_fault(d, NURBS_KNOTS_U, 0, 0);
}

static void test_nurbs_knot_count_must_fit(void **state) {
    (void)state;
    for_all_degrees(check_knot_count);
}

static void check_decrease(struct definition *d, int p, int q) {
    double kept = d->knots[0][p + 3];
    d->knots[0][p + 3] = d->knots[0][p + 2] - 0.5;
    assert_fault(d, NURBS_KNOTS_U, 1, (size_t)p + 3);
    d->knots[0][p + 3] = kept;
    d->knots[1][q + 2] = NAN;
    assert_fault(d, NURBS_KNOTS_V, 1, (size_t)q + 2);
    d->knots[1][q + 2] = INFINITY;
    assert_fault(d, NURBS_KNOTS_V, 1, (size_t)q + 2);
}

static void test_nurbs_knots_must_not_decrease(void **state) {
    (void)state;
    for_all_degrees(check_decrease);
}

/* Multiplicity p inside is a crease, p + 1 a tear. */
static void check_multiplicity(struct definition *d, int p, int q) {
    (void)q;
    double *t = d->knots[0];
    for (int i = 0; i < p; i++)
        t[p + 1 + i] = t[p + 1];
    for (int i = p + 1; i < (int)d->nurbs.u.knot_count; i++)
        t[i] = fmax(t[i], t[i - 1]);
    bool open = t[p + 1] < t[SIZE];
    if (!open)
        return;
    assert_int_equal(nurbs_validate(&d->nurbs, NULL), STATUS_OK);
    if (!(2 * p + 1 < SIZE && t[SIZE] > t[2 * p + 1]))
        return;
    t[2 * p + 1] = t[p + 1];
    assert_fault(d, NURBS_KNOTS_U, 1, (size_t)(2 * p + 1));
}

static void test_nurbs_interior_multiplicity_is_at_most_the_degree(void **state) {
    (void)state;
    for_all_degrees(check_multiplicity);
}

/* One fault, as a change of a sound definition, and where it is found. */
static void test_nurbs_every_other_fault_is_found(void **state) {
    (void)state;
    struct definition d;
#define FAULT(change, part, has_index, index)                                                      \
    do {                                                                                           \
        definition_make(&d, 3, 2, true);                                                           \
        change;                                                                                    \
        assert_fault(&d, part, has_index, index);                                                  \
    } while (0)
    FAULT(d.nurbs.u.degree = 0, NURBS_DEGREE_U, 0, 0);
    FAULT(d.nurbs.v.degree = -1, NURBS_DEGREE_V, 0, 0);
    FAULT(d.nurbs.v.degree = 10, NURBS_DEGREE_V, 0, 0);
    FAULT(d.nurbs.u.size = 3, NURBS_SIZE_U, 0, 0);
    FAULT(d.nurbs.v.size = NURBS_SIZE_MAX + 1, NURBS_SIZE_V, 0, 0);
    FAULT(d.nurbs.point_count--, NURBS_POINTS, 0, 0);
    FAULT(d.nurbs.point_count = 0, NURBS_POINTS, 0, 0);
    FAULT(d.points[17].y = NAN, NURBS_POINTS, 1, 17);
    FAULT(d.points[0].z = -INFINITY, NURBS_POINTS, 1, 0);
    FAULT(d.nurbs.weight_count = 1, NURBS_WEIGHTS, 0, 0);
    FAULT(d.weights[5] = 0, NURBS_WEIGHTS, 1, 5);
    FAULT(d.weights[SIZE * SIZE - 1] = -1, NURBS_WEIGHTS, 1, SIZE * SIZE - 1);
    FAULT(d.weights[2] = NAN, NURBS_WEIGHTS, 1, 2);
    FAULT(d.weights[2] = INFINITY, NURBS_WEIGHTS, 1, 2);
#undef FAULT
}

static void test_nurbs_domain_must_not_be_empty(void **state) {
    (void)state;
    struct definition d;
    definition_make(&d, 3, 3, false);
    for (size_t i = 0; i < d.nurbs.u.knot_count; i++)
        d.knots[0][i] = i < 2 ? 0 : i > SIZE + 1 ? 2 : 1;
    assert_fault(&d, NURBS_KNOTS_U, 0, 0);
    definition_make(&d, 3, 3, true);
    for (size_t i = 0; i < d.nurbs.v.knot_count; i++)
        d.knots[1][i] = i < SIZE ? -1.7e308 : 1.7e308;
    assert_fault(&d, NURBS_KNOTS_V, 0, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_nurbs_every_degree_is_accepted),
        cmocka_unit_test(test_nurbs_knot_count_must_fit),
        cmocka_unit_test(test_nurbs_knots_must_not_decrease),
        cmocka_unit_test(test_nurbs_interior_multiplicity_is_at_most_the_degree),
        cmocka_unit_test(test_nurbs_every_other_fault_is_found),
        cmocka_unit_test(test_nurbs_domain_must_not_be_empty),
    };
    return cmocka_run_group_tests_name("nurbs", tests, NULL, NULL);
}
