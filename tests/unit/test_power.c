/* SPDX-License-Identifier: MIT */
/* Logarithms and exponentials against the C library's. */
#include "solver/power.h"

#include "support.h"
#include "tests/check.h"
#include <math.h>

static void test_power_log_and_exp_are_those_of_the_library(void **state) {
    (void)state;
    struct random random = random_begin("power");
    for (int k = 0; k < 3000; k++) {
        double x = random_between(&random, -690, 690), y = exp(x);
        check_at_most(fabs(power_exp(x) / y - 1), 1e-15);
        check_at_most(fabs(power_log(y) - log(y)), 2e-16 * (1 + fabs(log(y))));
        double near = random_between(&random, 0.5, 2);
        check_at_most(fabs(power_log(near) - log(near)), 1e-15 * fabs(log(near)));
    }
    assert_true(power_log(1) == 0);
    assert_true(power_exp(0) == 1);
}

static void test_power_mean_is_geometric(void **state) {
    (void)state;
    check_at_most(fabs(power_mean(2, 8, 0.5) - 4), 1e-15);
    check_at_most(fabs(power_mean(1e-10, 1e-13, 1.0 / 3) / 1e-11 - 1), 1e-14);
    assert_true(power_mean(3, 5, 0) == 3 && power_mean(3, 5, 1) == 5);
    assert_true(power_mean(0, 5, 0.5) == 0 && power_mean(0, 5, 1) == 5);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_power_log_and_exp_are_those_of_the_library),
        cmocka_unit_test(test_power_mean_is_geometric),
    };
    return cmocka_run_group_tests_name("power", tests, NULL, NULL);
}
