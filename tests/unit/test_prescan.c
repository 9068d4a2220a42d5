/* SPDX-License-Identifier: MIT */
#include "api/json/prescan.h"

#include "support.h"
#include "tests/check.h"
#include <string.h>

static const struct api_limits limits = {.max_elements = 10, .max_depth = 4};

static enum api_problem_id scan(const char *text) {
    struct api_problem problem = {0};
    enum api_problem_id id = api_prescan(text, strlen(text), &limits, &problem);
    assert_int_equal(id, problem.id);
    return id;
}

static void test_prescan_accepts_what_is_within_the_limits(void **state) {
    (void)state;
    static const char *const texts[] = {"",
                                        "1",
                                        "[]",
                                        "[1,2,3,4,5,6,7,8,9]",
                                        "[[[[1]]]]",
                                        "[{},{},{}]",
                                        "[[1],[2],[3]]",
                                        "]]]]}}}}",
                                        "\"[[[[[[[[[[,,,,,,,,,,,,\"",
                                        "\"\\\"[[[[[[\"",
                                        "\"open [[[[[[[",
                                        "\"\\",
                                        "[[[[]]],[[[]]]]"};
    for (size_t i = 0; i < sizeof texts / sizeof *texts; i++)
        assert_int_equal(scan(texts[i]), API_OK);
}

static void test_prescan_refuses_deep_nesting(void **state) {
    (void)state;
    assert_int_equal(scan("[[[[[1]]]]]"), API_TOO_LARGE);
    assert_int_equal(scan("[[[[["), API_TOO_LARGE);
    assert_int_equal(scan("[{\"a\":[{\"b\":[]}]}]"), API_TOO_LARGE);
    assert_int_equal(scan("\"]]]]\\\"\"[[[[["), API_TOO_LARGE);
}

static void test_prescan_refuses_many_values(void **state) {
    (void)state;
    assert_int_equal(scan("[1,2,3,4,5,6,7,8,9,10]"), API_TOO_LARGE);
    assert_int_equal(scan("[[],[],[],[],[],[]]"), API_TOO_LARGE);
    assert_int_equal(scan(",,,,,,,,,,,,"), API_TOO_LARGE);
}

/* A member of an object counts as eight. */
static void test_prescan_refuses_many_members(void **state) {
    (void)state;
    assert_int_equal(scan("{\"a:::,,,\":1}"), API_OK);
    assert_int_equal(scan("{\"a\":1,\"b\":2}"), API_TOO_LARGE);
    assert_int_equal(scan("{\"a\":{\"b\":{}}}"), API_TOO_LARGE);
}

static void test_prescan_names_the_limit(void **state) {
    (void)state;
    struct api_problem problem = {0};
    assert_int_equal(api_prescan("[[[[[", 5, &limits, &problem), API_TOO_LARGE);
    assert_non_null(strstr(problem.error[0].detail, "limit of 4 levels"));
    problem = (struct api_problem){0};
    assert_int_equal(api_prescan(",,,,,,,,,,", 10, &limits, &problem), API_TOO_LARGE);
    assert_non_null(strstr(problem.error[0].detail, "limit of 10"));
}

/* A hostile body of any bytes, cut anywhere. */
static void test_prescan_survives_any_bytes(void **state) {
    (void)state;
    static const char alphabet[] = "[]{}\",:\\1 a\0";
    struct random random = random_begin(__func__);
    for (int round = 0; round < 20000; round++) {
        char text[40];
        size_t length = (size_t)random_index(&random, sizeof text);
        for (size_t i = 0; i < length; i++)
            text[i] = alphabet[random_index(&random, sizeof alphabet)];
        struct bytes exact = {0}; /* of its very length, so that reading beyond is noticed */
        bytes_add(&exact, text, length);
        struct api_problem problem = {0};
        enum api_problem_id id = api_prescan(exact.data, length, &limits, &problem);
        assert_true(id == API_OK || id == API_TOO_LARGE);
        bytes_free(&exact);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_prescan_accepts_what_is_within_the_limits),
        cmocka_unit_test(test_prescan_refuses_deep_nesting),
        cmocka_unit_test(test_prescan_refuses_many_values),
        cmocka_unit_test(test_prescan_refuses_many_members),
        cmocka_unit_test(test_prescan_names_the_limit),
        cmocka_unit_test(test_prescan_survives_any_bytes),
    };
    return cmocka_run_group_tests_name("prescan", tests, NULL, NULL);
}
