/* SPDX-License-Identifier: MIT */
/* What searches do with a smaller and a larger budget, and with nets that take long. */
#include "studied.h"

#include "tests/check.h"
#include <stdio.h>

/* Of a net of many nodes a part of what the search looks at is on a coarser one, and the best was
 * draped as asked, be the budget as small as can be. */
static void test_optimise_of_a_fine_net_ends_on_it(void **state) {
    struct bytes coarse = studied_saddle(), part = text_replace(coarse.data, "0.25", "0.025");
    size_t coarse_rows = 0;
    char rest[200];
    (void)state;
    for (int budget = 20; budget <= 66; budget += 46) {
        snprintf(rest, sizeof rest,
                 "\"vary\":{\"start\":{\"grid\":9}},\"search\":\"optimise\",\"budget\":%d,"
                 "\"objectives\":[\"max_shear_deg\"]",
                 budget);
        struct studied f = studied_make(part.data, rest);
        size_t best = (size_t)f.columns.study.best[QUANTITY_MAX_SHEAR], proposed = 0;
        check_above(f.columns.study.coarse, 10);
        check_above(f.columns.study.coarse, coarse_rows);
        assert_true(studied_value(&f, "coarseness", 0) == 1);
        assert_true(studied_value(&f, "coarseness", best) == 1);
        for (size_t k = 50; k < f.rows; k++) /* of those proposed more than half are as asked */
            proposed += studied_value(&f, "coarseness", k) == 1;
        check_at_least(2 * proposed, f.rows > 50 ? f.rows - 50 : 0);
        studied_check_bits(&f, best);
        studied_check_bits(&f, 19);
        check_above(studied_value(&f, "coarseness", 19), 3);
        coarse_rows = f.columns.study.coarse;
        studied_free(&f);
    }
    bytes_free(&part);
    bytes_free(&coarse);
}

/* A net from a start near a corner shears more than coarse ones from elsewhere, and yet it alone
 * may be the best and on the front. */
static void test_optimise_puts_no_coarse_net_on_the_front(void **state) {
    struct bytes part = text_replace(studied_bowl, "\"spacing\":0.1}",
                                     "\"spacing\":0.0125},\"start\":{\"uv\":[0.97,0.2]}");
    struct studied f = studied_make(
        part.data, "\"vary\":{\"start\":{\"grid\":9}},\"search\":\"optimise\",\"budget\":20,"
                   "\"objectives\":[\"max_shear_deg\",\"waste_area\"]");
    size_t less = 0;
    (void)state;
    for (size_t k = 0; k < f.rows; k++) {
        less += studied_value(&f, "max_shear_deg", k) < studied_best(&f, QUANTITY_MAX_SHEAR);
        assert_true(!(studied_value(&f, "pareto", k) > 0) ||
                    studied_value(&f, "coarseness", k) == 1);
    }
    check_above(less, 0);
    studied_free(&f);
    bytes_free(&part);
}

/* A search with the larger budget begins as that with the smaller, to the last bit, and so its best
 * is never worse, wherever in an epoch the smaller ends. */
static void test_optimise_is_never_worse_with_more(void **state) {
    static const int budgets[] = {20, 37, 101, 240, 620};
    enum { BUDGETS = sizeof budgets / sizeof *budgets };
    const int count = check_sized(BUDGETS, BUDGETS - 1);
    struct bytes part = studied_mesh();
    struct studied f[BUDGETS];
    char rest[300];
    (void)state;
    for (int b = 0; b < count; b++) {
        snprintf(
            rest, sizeof rest,
            "\"vary\":{\"start\":{\"grid\":9},\"angle_deg\":{\"from\":0,\"to\":85,\"step\":5}},"
            "\"search\":\"optimise\",\"budget\":%d,\"objectives\":[\"max_shear_deg\"]",
            budgets[b]);
        f[b] = studied_make(part.data, rest);
        assert_int_equal(f[b].rows, budgets[b]);
    }
    for (int b = 1; b < count; b++) {
        for (size_t k = 0; k < f[b - 1].rows; k++) {
            assert_true(studied_value(&f[b], "x", k) == studied_value(&f[b - 1], "x", k));
            assert_true(studied_value(&f[b], "angle_deg", k) ==
                        studied_value(&f[b - 1], "angle_deg", k));
        }
        check_at_most(studied_best(&f[b], QUANTITY_MAX_SHEAR),
                      studied_best(&f[b - 1], QUANTITY_MAX_SHEAR));
    }
    for (int b = 0; b < count; b++)
        studied_free(&f[b]);
    bytes_free(&part);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_optimise_of_a_fine_net_ends_on_it),
        cmocka_unit_test(test_optimise_puts_no_coarse_net_on_the_front),
        cmocka_unit_test(test_optimise_is_never_worse_with_more),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
