/* SPDX-License-Identifier: MIT */
/* Searches for what has to keep a limit, and of two objectives. */
#include "studied.h"

#include "tests/check.h"
#include <stdio.h>

/* A limit that the best without it breaks holds at what comes out, and is all but reached; once the
 * search knows the part most of what it looks at keeps it. */
static void test_optimise_keeps_limits(void **state) {
    char rest[500];
    struct bytes part = studied_mesh();
    double limit = 90, deviation = 0;
    (void)state;
    for (int k = 0; k < 2; k++) {
        snprintf(
            rest, sizeof rest,
            "\"vary\":{\"start\":{\"grid\":9},\"angle_deg\":{\"from\":0,\"to\":170,\"step\":10}},"
            "\"wanted_direction\":[3,1,0],\"search\":\"optimise\",\"budget\":500,"
            "\"objectives\":[\"max_shear_deg\"],"
            "\"limits\":{\"angle_deviation_deg\":{\"max\":%.17g}}",
            limit);
        struct studied f = studied_make(part.data, rest);
        size_t best = (size_t)f.columns.study.best[QUANTITY_MAX_SHEAR];
        deviation = studied_value(&f, "angle_deviation_deg", best);
        assert_true(studied_value(&f, "feasible", best) == 1);
        check_at_most(deviation, limit);
        size_t kept = 0;
        for (size_t row = 400; row < f.rows; row++)
            kept += studied_value(&f, "feasible", row) > 0;
        check_at_least((double)kept, 0.5 * (double)(f.rows - 400));
        if (k == 1)
            check_at_least(deviation, 0.7 * limit);
        limit = 0.5 * deviation;
        studied_free(&f);
    }
    bytes_free(&part);
}

/* Two objectives: the ends of the front are as good as each search alone, and there is more between
 * them than the first round found. */
static void test_optimise_spreads_a_front(void **state) {
    struct bytes part = studied_mesh();
    struct studied f = studied_make(
        part.data,
        "\"vary\":{\"start\":{\"grid\":9},\"angle_deg\":{\"from\":0,\"to\":170,\"step\":10}},"
        "\"wanted_direction\":[1,1,0],\"search\":\"optimise\",\"budget\":500,"
        "\"objectives\":[\"p95_shear_deg\",\"angle_deviation_deg\"]");
    size_t refined = 0;
    (void)state;
    for (size_t k = 250; k < f.rows; k++)
        refined += studied_value(&f, "pareto", k) > 0;
    check_at_least(f.columns.study.pareto, 8);
    check_at_least((double)refined, 0.4 * (double)f.columns.study.pareto);
    studied_free(&f);
    bytes_free(&part);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_optimise_keeps_limits),
        cmocka_unit_test(test_optimise_spreads_a_front),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
