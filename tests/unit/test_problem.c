/* SPDX-License-Identifier: MIT */
#include "api/problem.h"

#include "support.h"
#include "tests/check.h"
#include <jansson.h>
#include <stdlib.h>
#include <string.h>

/* The document, parsed; the caller gives it back with json_decref. */
static json_t *document(const struct api_problem *problem, const char *request_id) {
    char *text = api_problem_json(problem, request_id);
    assert_non_null(text);
    json_t *json = json_loads(text, 0, NULL);
    assert_non_null(json);
    free(text);
    return json;
}

static const char *text_of(json_t *json, const char *key) {
    return json_string_value(json_object_get(json, key));
}

static void test_problem_json_has_the_members_of_rfc_9457(void **state) {
    (void)state;
    struct api_problem problem = {0};
    api_problem_set(&problem, API_QUEUE_FULL, "%d wait", 7);
    json_t *json = document(&problem, "r-1");
    assert_string_equal(text_of(json, "type"), "/problems/queue-full");
    assert_string_equal(text_of(json, "title"), api_problem_title(API_QUEUE_FULL));
    assert_int_equal(json_integer_value(json_object_get(json, "status")), 429);
    assert_string_equal(text_of(json, "detail"), "7 wait");
    assert_string_equal(text_of(json, "request_id"), "r-1");
    assert_null(json_object_get(json, "pointer"));
    assert_null(json_object_get(json, "errors"));
    json_decref(json);
}

static void test_problem_json_lists_every_place(void **state) {
    (void)state;
    struct api_problem problem = {0};
    api_problem_add(&problem, "/a", "first");
    api_problem_add(&problem, "/b/0", "second");
    json_t *json = document(&problem, NULL);
    json_t *errors = json_object_get(json, "errors");
    assert_string_equal(text_of(json, "pointer"), "/a");
    assert_string_equal(text_of(json, "detail"), "first");
    assert_null(json_object_get(json, "request_id"));
    assert_int_equal(json_array_size(errors), 2);
    assert_string_equal(text_of(json_array_get(errors, 1), "pointer"), "/b/0");
    assert_string_equal(text_of(json_array_get(errors, 1), "detail"), "second");
    json_decref(json);
}

static void test_problem_first_error_wins(void **state) {
    (void)state;
    struct api_problem problem = {0};
    api_problem_set(&problem, API_OUT_OF_MEMORY, "first");
    api_problem_set(&problem, API_INTERNAL, "second");
    api_problem_set_at(&problem, API_INTERNAL, "/x", "third");
    api_problem_add(&problem, "/x", "fourth");
    assert_int_equal(problem.id, API_OUT_OF_MEMORY);
    assert_int_equal(problem.count, 1);
    assert_string_equal(problem.error[0].detail, "first");
    assert_false(problem.has_pointer);
}

static void test_problem_keeps_as_many_places_as_it_says(void **state) {
    (void)state;
    struct api_problem problem = {0};
    for (int i = 0; i < 3 * API_ERRORS_MAX; i++)
        api_problem_add(&problem, "/x", "%d", i);
    assert_int_equal(problem.count, API_ERRORS_MAX);
    assert_string_equal(problem.error[0].detail, "0");
}

/* Control characters, quotes, broken and cut UTF-8: the longest document there can be still is
 * one. */
static void test_problem_json_is_whole_for_any_bytes(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    for (int round = 0; round < 300; round++) {
        struct api_problem problem = {0};
        for (int i = 0; i < API_ERRORS_MAX; i++) {
            char pointer[2 * API_POINTER_MAX], detail[2 * API_DETAIL_MAX];
            for (size_t k = 0; k < sizeof pointer; k++)
                pointer[k] = (char)(round ? 1 + random_index(&random, 255) : 1);
            for (size_t k = 0; k < sizeof detail; k++)
                detail[k] = (char)(round ? 1 + random_index(&random, 255) : 1);
            pointer[sizeof pointer - 1] = detail[sizeof detail - 1] = '\0';
            api_problem_add(&problem, pointer, "%s", detail);
        }
        json_decref(document(&problem, "\"\\\n"));
    }
}

static void test_problem_slugs_lead_back_to_their_ids(void **state) {
    (void)state;
    for (int id = API_OK + 1; id < API_PROBLEM_COUNT; id++) {
        assert_int_equal(api_problem_from_slug(api_problem_slug((enum api_problem_id)id)), id);
        assert_in_range(api_problem_status((enum api_problem_id)id), 400, 599);
    }
    assert_int_equal(api_problem_from_slug("nonsense"), API_INTERNAL);
    assert_int_equal(api_problem_from_slug(""), API_INTERNAL);
}

static void test_problem_statuses_are_those_of_the_contract(void **state) {
    (void)state;
    static const struct {
        const char *slug;
        int status;
    } contract[] = {
        {"malformed-json", 400},    {"unauthorized", 401},       {"forbidden", 403},
        {"not-found", 404},         {"result-not-ready", 404},   {"method-not-allowed", 405},
        {"too-large", 413},         {"invalid-request", 422},    {"queue-full", 429},
        {"start-off-surface", 422}, {"degenerate-surface", 422}, {"solver-crashed", 500},
        {"job-timeout", 500},       {"out-of-memory", 500}};
    for (size_t i = 0; i < sizeof contract / sizeof *contract; i++) {
        enum api_problem_id id = api_problem_from_slug(contract[i].slug);
        assert_string_equal(api_problem_slug(id), contract[i].slug);
        assert_int_equal(api_problem_status(id), contract[i].status);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_problem_json_has_the_members_of_rfc_9457),
        cmocka_unit_test(test_problem_json_lists_every_place),
        cmocka_unit_test(test_problem_first_error_wins),
        cmocka_unit_test(test_problem_keeps_as_many_places_as_it_says),
        cmocka_unit_test(test_problem_json_is_whole_for_any_bytes),
        cmocka_unit_test(test_problem_slugs_lead_back_to_their_ids),
        cmocka_unit_test(test_problem_statuses_are_those_of_the_contract),
    };
    return cmocka_run_group_tests_name("problem", tests, NULL, NULL);
}
