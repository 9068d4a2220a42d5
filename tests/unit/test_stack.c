/* SPDX-License-Identifier: MIT */
#include "solver/stack.h"

#include "solver/power.h"
#include "support.h"
#include "tests/check.h"
#include <math.h>
#include <string.h>

static void test_power_agrees_with_libm(void **state) {
    struct random random = random_begin("power");
    (void)state;
    for (int k = 0; k < 200000; k++) {
        double x = random_between(&random, -700, 700), y = exp(random_between(&random, -700, 700));
        check_at_most(fabs(power_exp(x) / exp(x) - 1), 6e-16);
        check_at_most(fabs(power_log(y) - log(y)), 4e-16 * fmax(fabs(log(y)), 1));
    }
    assert_true(power_exp(0) == 1 && power_log(1) == 0);
    assert_true(power_exp(-1e9) == 0 && isinf(power_exp(1e9)) && isnan(power_exp(NAN)));
}

/* Plies with random laws, some without, some with the exponent of the one before. */
static size_t random_plies(struct random *random, struct stack_ply *plies, double *volume) {
    size_t count = 1 + (size_t)random_between(random, 0, 12);
    for (size_t k = 0; k < count; k++) {
        bool law = random_between(random, 0, 1) < 0.7;
        plies[k] = (struct stack_ply){.thickness = random_between(random, 1e-4, 2e-3),
                                      .fraction = random_between(random, 0.3, 0.6),
                                      .a = law ? random_between(random, 0.1, 0.4) : 0,
                                      .b = law ? random_between(random, 0.02, 0.2) : 0};
        if (law && k > 0 && plies[k - 1].b > 0 && random_index(random, 2))
            plies[k].b = plies[k - 1].b;
        volume[k] = plies[k].thickness * plies[k].fraction;
    }
    return count;
}

/* What was said of `stack_press`, for heights from a third to twice the stack's own. */
static void test_stack_fills_a_height_under_one_pressure(void **state) {
    struct random random = random_begin("stack");
    (void)state;
    for (int round = 0; round < 20000; round++) {
        struct stack_ply plies[16], own[16];
        double volume[16], whole = 0, pressed = 0;
        size_t count = random_plies(&random, plies, volume);
        memcpy(own, plies, sizeof own);
        for (size_t k = 0; k < count; k++)
            whole += own[k].thickness;
        double height = whole * random_between(&random, 0.33, 2);
        double pressure = stack_press(
            &(struct stack_cavity){.kind = STACK_HEIGHT, .height = height}, count, plies);
        for (size_t k = 0; k < count; k++) {
            pressed += plies[k].thickness;
            double vf = plies[k].fraction;
            check_at_most(fabs(plies[k].thickness * vf / volume[k] - 1), 1e-14);
            double wanted = own[k].a > 0 ? own[k].a * pow(pressure, own[k].b)
                                         : own[k].fraction * whole / height;
            check_at_most(fabs(vf / wanted - 1), 1e-12);
        }
        check_at_most(fabs(pressed / height - 1), 1e-13);
    }
}

static void test_stack_pressing_leaves_every_volume_of_fibres(void **state) {
    static const enum stack_kind kinds[] = {STACK_FLEXIBLE, STACK_PRESSURE, STACK_HEIGHT};
    struct random random = random_begin("volume");
    (void)state;
    for (int round = 0; round < 3000; round++) {
        struct stack_ply plies[16];
        double volume[16];
        size_t count = random_plies(&random, plies, volume);
        const struct stack_cavity cavity = {.kind = kinds[round % 3],
                                            .pressure = random_between(&random, 1, 1e7),
                                            .height = random_between(&random, 1e-4, 1e-2)};
        (void)stack_press(&cavity, count, plies);
        for (size_t k = 0; k < count; k++)
            check_at_most(fabs(plies[k].thickness * plies[k].fraction / volume[k] - 1), 1e-14);
    }
}

static void test_stack_leaves_plies_without_a_law_under_a_pressure(void **state) {
    struct stack_ply plies[2] = {{1e-3, 0.5, 0.2, 0.1}, {1e-3, 0.5, 0, 0}};
    const struct stack_cavity cavity = {.kind = STACK_PRESSURE, .pressure = 1e5};
    (void)state;
    check_at_most(fabs(stack_press(&cavity, 2, plies) / 1e5 - 1), 1e-14);
    check_at_most(fabs(plies[0].fraction - 0.2 * pow(1e5, 0.1)), 1e-14);
    assert_true(plies[1].fraction == 0.5 && plies[1].thickness == 1e-3);
    const struct stack_cavity flexible = {.kind = STACK_FLEXIBLE};
    struct stack_ply same = {1e-3, 0.5, 0.2, 0.1};
    assert_true(stack_press(&flexible, 1, &same) == 0 && same.thickness == 1e-3);
}

/* ---- permeability ---- */

static void turned(double degrees, double along[2], double across[2]) {
    along[0] = cos(degrees * M_PI / 180);
    along[1] = sin(degrees * M_PI / 180);
    across[0] = -along[1];
    across[1] = along[0];
}

static struct permeability of_plies(const struct permeability *k, const double *degrees,
                                    const double *thickness, size_t count) {
    struct stack_sum sum = {.thickness = 0};
    for (size_t n = 0; n < count; n++) {
        double along[2], across[2];
        turned(degrees[n], along, across);
        stack_add(&sum, thickness[n], &k[n], along, across);
    }
    return stack_permeability(&sum);
}

static void test_stack_of_equal_plies_is_one(void **state) {
    const double measured[3] = {3e-10, 1e-10, 2e-11};
    struct permeability k = permeability_kozeny_carman(measured, 0.5, 0.55, 20, 0);
    const struct permeability all[3] = {k, k, k};
    const double degrees[3] = {0, 0, 0}, thickness[3] = {1e-3, 2e-4, 7e-4};
    (void)state;
    struct permeability stack = of_plies(all, degrees, thickness, 3);
    check_at_most(fabs(stack.k1 / k.k1 - 1), 1e-14);
    check_at_most(fabs(stack.k2 / k.k2 - 1), 1e-14);
    check_at_most(fabs(stack.k3 / k.k3 - 1), 1e-14);
    check_at_most(fabs(stack.along - k.along) + fabs(stack.across - k.across), 1e-13);
}

static void test_stack_of_crossed_plies_is_isotropic(void **state) {
    const double measured[3] = {3e-10, 1e-10, 2e-11};
    struct permeability k = permeability_kozeny_carman(measured, 0.5, 0.5, 0, 0);
    const struct permeability all[2] = {k, k};
    (void)state;
    for (int angle = -90; angle < 90; angle += 7) {
        const double degrees[2] = {angle, angle + 90.0}, thickness[2] = {1e-3, 1e-3};
        struct permeability stack = of_plies(all, degrees, thickness, 2);
        check_at_most(fabs(stack.k1 / 2e-10 - 1), 1e-7); /* the root of a difference of rounding */
        check_at_most(fabs(stack.k2 / 2e-10 - 1), 1e-7);
        check_at_most(fabs((stack.k1 + stack.k2) / 4e-10 - 1), 1e-14);
    }
}

/* And a ply that lets nothing through closes the stack. */
static void test_stack_does_not_depend_on_the_order(void **state) {
    struct random random = random_begin("order");
    (void)state;
    for (int round = 0; round < 1000; round++) {
        struct permeability k[5];
        double degrees[5], thickness[5];
        for (int n = 0; n < 5; n++) {
            double k1 = random_between(&random, 1e-11, 1e-9),
                   k2 = k1 * random_between(&random, 0, 1);
            k[n] = permeability_principal(k1, 0, k2, random_between(&random, 1e-12, 1e-10));
            degrees[n] = random_between(&random, -180, 180);
            thickness[n] = random_between(&random, 1e-4, 1e-3);
        }
        struct permeability a = of_plies(k, degrees, thickness, 5);
        for (int n = 0; n < 2; n++) {
            struct permeability swap = k[n];
            double angle = degrees[n], own = thickness[n];
            k[n] = k[4 - n];
            degrees[n] = degrees[4 - n];
            thickness[n] = thickness[4 - n];
            k[4 - n] = swap;
            degrees[4 - n] = angle;
            thickness[4 - n] = own;
        }
        struct permeability b = of_plies(k, degrees, thickness, 5);
        check_at_most(fabs(a.k1 - b.k1) + fabs(a.k2 - b.k2) + fabs(a.k3 - b.k3), 1e-13 * a.k1);
        k[2].k3 = 0;
        assert_true(of_plies(k, degrees, thickness, 5).k3 == 0);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_power_agrees_with_libm),
        cmocka_unit_test(test_stack_fills_a_height_under_one_pressure),
        cmocka_unit_test(test_stack_pressing_leaves_every_volume_of_fibres),
        cmocka_unit_test(test_stack_leaves_plies_without_a_law_under_a_pressure),
        cmocka_unit_test(test_stack_of_equal_plies_is_one),
        cmocka_unit_test(test_stack_of_crossed_plies_is_isotropic),
        cmocka_unit_test(test_stack_does_not_depend_on_the_order),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
