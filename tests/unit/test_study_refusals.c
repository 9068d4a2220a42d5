/* SPDX-License-Identifier: MIT */
#include "studied.h"

#include "api/json/value.h"
#include "tests/check.h"
#include <stdio.h>
#include <string.h>

/* That there is a problem at the pointer, whose words end with `end`. */
static void check_refused_by(const char *rest, const char *pointer, const char *end) {
    struct bytes part = studied_saddle(), text = studied_text(part.data, rest);
    const struct api_input input = studied_input(&text);
    struct api_problem problem = {0};
    struct api_check check;
    prepare();
    assert_int_equal(api_check_study(&input, &api_limits_default, NULL, &check, &problem),
                     API_INVALID_REQUEST);
    for (size_t k = 0; k < problem.count; k++)
        if (strcmp(problem.error[k].pointer, pointer) == 0) {
            const char *detail = problem.error[k].detail;
            check_at_least((double)strlen(detail), (double)strlen(end));
            assert_string_equal(detail + strlen(detail) - strlen(end), end);
            bytes_free(&text);
            bytes_free(&part);
            return;
        }
    fail_msg("%s: the problem is at %s: %s", rest, problem.error[0].pointer,
             problem.error[0].detail);
}

static void check_refused(const char *rest, const char *pointer) {
    check_refused_by(rest, pointer, "");
}

#define MAX "\"objectives\":[\"max_shear_deg\"]"

static void test_study_refuses_by_pointer(void **state) {
    static const char *const cases[][2] = {
        {"\"vary\":{}," MAX, "/vary"},
        {MAX, "/vary"},
        {"\"vary\":{\"start\":{\"grid\":10000000}}," MAX, "/vary"},
        {"\"vary\":{\"start\":{\"grid\":0}}," MAX, "/vary/start/grid"},
        {"\"vary\":{\"start\":{\"grid\":3,\"points\":[[0,0,0]]}}," MAX, "/vary/start"},
        {"\"vary\":{\"start\":{\"points\":[{\"uv\":[2,0]}]}}," MAX, "/vary/start/points/0/uv"},
        {"\"vary\":{\"angle_deg\":{\"from\":9,\"to\":0,\"step\":1}}," MAX, "/vary/angle_deg/to"},
        {"\"vary\":{\"angle_deg\":{\"from\":0,\"to\":9,\"step\":0}}," MAX, "/vary/angle_deg/step"},
        {"\"vary\":{\"angle_deg\":{\"from\":0,\"to\":180,\"step\":1e-6}}," MAX, "/vary"},
        {"\"vary\":{\"angle_deg\":[]}," MAX, "/vary/angle_deg"},
        {"\"vary\":{\"angle_deg\":30}," MAX, "/vary/angle_deg"},
        {"\"vary\":{\"pre_shear_deg\":[85]}," MAX, "/vary/pre_shear_deg/0"},
        {"\"vary\":{\"steering\":[]}," MAX, "/vary/steering"},
        {"\"vary\":{\"steering\":{\"points\":0}}," MAX, "/vary/steering/points"},
        {"\"vary\":{\"steering\":{\"points\":17}}," MAX, "/vary/steering/points"},
        {"\"vary\":{\"steering\":{\"values\":[0,0]}}," MAX, "/vary/steering/values"},
        {"\"vary\":{\"angle_deg\":[0]},\"objectives\":[]", "/objectives"},
        {"\"vary\":{\"angle_deg\":[0]},\"objectives\":[\"beauty\"]", "/objectives/0"},
        {"\"vary\":{\"angle_deg\":[0]},\"objectives\":[\"waste_area\",\"waste_area\"]",
         "/objectives/1"},
        {"\"vary\":{\"angle_deg\":[0]},\"objectives\":[\"angle_deviation_deg\"]",
         "/wanted_direction"},
        {"\"vary\":{\"angle_deg\":[0]}," MAX
         ",\"limits\":{\"max_shear_deg\":{\"min\":9,\"max\":3}}",
         "/limits/max_shear_deg/min"},
        {"\"vary\":{\"angle_deg\":[0]}," MAX ",\"limits\":{\"cloth_coverage\":{\"min\":1.5}}",
         "/limits/cloth_coverage/min"},
        {"\"vary\":{\"angle_deg\":[0]}," MAX ",\"limits\":{\"beauty\":{\"min\":1}}",
         "/limits/beauty"},
        {"\"vary\":{\"angle_deg\":[0]}," MAX ",\"search\":\"guess\"", "/search"},
        {"\"vary\":{\"start\":{\"grid\":21}}," MAX ",\"budget\":20", "/budget"},
        {"\"vary\":{\"start\":{\"radius\":1}}," MAX ",\"sample\":21,\"budget\":20", "/budget"},
        {"\"vary\":{\"start\":{\"radius\":1}}," MAX, "/sample"},
        {"\"vary\":{\"angle_deg\":[0]}," MAX ",\"sample\":9", "/vary"},
        {"\"vary\":{\"angle_deg\":[0]}," MAX ",\"colour\":9", "/colour"},
        {"\"vary\":{\"splits\":\"drawn\"}", "/vary/splits"},
        {"\"vary\":{\"splits\":{\"proposed\":9}}", "/vary/splits/proposed"},
        {"\"vary\":{\"splits\":{\"proposed\":0}}", "/vary/splits/proposed"},
        {"\"vary\":{\"splits\":{}}", "/vary/splits/proposed"},
        {"\"vary\":{\"splits\":\"proposed\",\"angle_deg\":[0]}", "/vary/splits"},
        {"\"vary\":{\"splits\":\"proposed\"},\"search\":\"optimise\"", "/search"},
        {"\"vary\":{\"splits\":\"proposed\"},\"budget\":5", "/budget"},
    };
    (void)state;
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++)
        check_refused(cases[k][0], cases[k][1]);
    check_refused_by("\"vary\":{\"angle_deg\":[0]},\"objectives\":[\"beauty\"]", "/objectives/0",
                     " \"cut_length\", \"angle_deviation_max_deg\" or \"gap_width\"");
}

static void check_drape_refused(const char *drape, const char *rest, const char *pointer) {
    struct bytes text = studied_text(drape, rest);
    const struct api_input input = studied_input(&text);
    struct api_problem problem = {0};
    struct api_check check;
    prepare();
    assert_int_not_equal(api_check_study(&input, &api_limits_default, NULL, &check, &problem),
                         API_OK);
    assert_string_equal(problem.error[0].pointer, pointer);
    bytes_free(&text);
}

static void test_study_refuses_what_its_drape_lacks(void **state) {
    static const char vary[] = "\"vary\":{\"angle_deg\":[0]},\"objectives\":[\"";
    static const char *const cases[][2] = {
        {"locked_area", "/drape/fabric/locking_angle_deg"},
        {"severity_area", "/drape/fabric/limit_curve"},
        {"k1_ratio_p95", "/drape/permeability"},
        {"fiber_volume_fraction_range", "/drape/fabric/fiber_volume_fraction"}};
    (void)state;
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        char rest[200];
        snprintf(rest, sizeof rest, "%s%s\"]", vary, cases[k][0]);
        check_drape_refused(studied_roof, rest, cases[k][1]);
    }
    struct bytes fine = text_replace(studied_roof, "0.2", "1e-7");
    check_drape_refused(fine.data, "\"vary\":{\"angle_deg\":[0]}," MAX, "/drape/fabric/spacing");
    bytes_free(&fine);
    struct bytes plane = text_replace(studied_roof, "\"fabric\"",
                                      "\"generators\":{\"warp\":{\"plane\":[1,0,0]}},\"fabric\"");
    check_drape_refused(plane.data, "\"vary\":{\"angle_deg\":[0]}," MAX, "/drape/generators/warp");
    bytes_free(&plane);
    struct bytes sliding =
        text_replace(studied_roof, "\"spacing\"", "\"kinematics\":{\"slide\":1},\"spacing\"");
    check_drape_refused(sliding.data, "\"vary\":{\"pre_shear_deg\":[0,5]}," MAX,
                        "/vary/pre_shear_deg");
    bytes_free(&sliding);
}

/* What the last step could not hold is refused by the first. */
static void test_samples_beyond_memory_are_refused(void **state) {
    struct bytes part = studied_saddle();
    struct bytes text =
        studied_text(part.data, "\"vary\":{\"angle_deg\":{\"normal\":1}},\"sample\":5000");
    const struct api_input input = studied_input(&text);
    struct api_limits limits = api_limits_default;
    struct api_problem problem = {0};
    (void)state;
    prepare();
    limits.max_memory = (size_t)64 << 20;
    assert_null(api_study_open(&input, &limits, &problem));
    assert_int_equal(problem.id, API_TOO_LARGE);
    assert_string_equal(problem.error[0].pointer, "/sample");
    problem = (struct api_problem){0};
    struct api_study *study = api_study_open(&input, &api_limits_default, &problem);
    assert_non_null(study);
    api_study_close(study);
    bytes_free(&text);
    bytes_free(&part);
}

static void test_study_is_known_by_its_drape(void **state) {
    struct bytes part = studied_saddle(), text = studied_text(part.data, MAX);
    (void)state;
    prepare();
    assert_true(json_document_has(text.data, text.length, &api_limits_default, "drape"));
    assert_false(json_document_has(part.data, part.length, &api_limits_default, "drape"));
    assert_false(json_document_has("[", 1, &api_limits_default, "drape"));
    bytes_free(&text);
    bytes_free(&part);
}

/* Equal studies have equal ids, however they are spelled; others have others. */
static void test_study_digest_is_of_the_content(void **state) {
    static const char *const rests[] = {
        "\"vary\":{\"angle_deg\":[0,10]}," MAX,
        MAX ",\"search\":\"grid\",\"vary\":{\"angle_deg\":[0.0,1e1]}",
        "\"vary\":{\"angle_deg\":[0,11]}," MAX,
        "\"vary\":{\"angle_deg\":[0,10]},\"objectives\":[\"p95_shear_deg\"]",
        "\"vary\":{\"angle_deg\":[0,10]}," MAX ",\"limits\":{\"max_shear_deg\":{\"max\":30}}",
        "\"vary\":{\"angle_deg\":[0,10]}," MAX ",\"search\":\"optimise\""};
    enum { COUNT = sizeof rests / sizeof *rests };
    struct bytes part = studied_saddle();
    struct api_check check[COUNT];
    (void)state;
    prepare();
    for (int k = 0; k < COUNT; k++) {
        struct bytes text = studied_text(part.data, rests[k]);
        const struct api_input input = studied_input(&text);
        struct api_problem problem = {0};
        assert_int_equal(api_check_study(&input, &api_limits_default, NULL, &check[k], &problem),
                         API_OK);
        for (int other = 0; other < k; other++)
            assert_int_equal(strcmp(check[k].digest, check[other].digest) == 0,
                             k == 1 && other == 0);
        bytes_free(&text);
    }
    assert_int_equal(check[0].variants, 2);
    assert_int_equal(check[COUNT - 1].variants, 500);
    bytes_free(&part);
}

/* What was understood is understood as the same. */
static void test_study_as_understood_is_the_same_study(void **state) {
    static const char *const rests[] = {
        "\"vary\":{\"angle_deg\":[0,10],\"start\":{\"grid\":9}}," MAX,
        "\"vary\":{\"start\":{\"points\":[[0,0,0],{\"uv\":[0.5,0.25]}]}}," MAX
        ",\"limits\":{\"waste_area\":{\"min\":0,\"max\":3}}",
        "\"vary\":{\"pre_shear_deg\":{\"from\":-5,\"to\":5,\"step\":0.1}},\"wanted_direction\":[1,"
        "2,3],"
        "\"objectives\":[\"angle_deviation_deg\",\"locked_area\"]"};
    struct bytes part = studied_saddle();
    (void)state;
    prepare();
    for (size_t k = 0; k < sizeof rests / sizeof *rests; k++) {
        struct bytes text[2] = {studied_text(part.data, rests[k]), {0}};
        struct api_check check[2];
        struct api_problem problem = {0};
        struct api_input input = studied_input(&text[0]);
        const struct api_sink sink = sink_into(&text[1]);
        assert_int_equal(api_study_normalise(&input, &api_limits_default, &sink, &problem), API_OK);
        for (int i = 0; i < 2; i++) {
            input = studied_input(&text[i]);
            assert_int_equal(
                api_check_study(&input, &api_limits_default, NULL, &check[i], &problem), API_OK);
        }
        assert_string_equal(check[0].digest, check[1].digest);
        bytes_free(&text[0]);
        bytes_free(&text[1]);
    }
    bytes_free(&part);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_study_refuses_by_pointer),
        cmocka_unit_test(test_study_refuses_what_its_drape_lacks),
        cmocka_unit_test(test_samples_beyond_memory_are_refused),
        cmocka_unit_test(test_study_is_known_by_its_drape),
        cmocka_unit_test(test_study_digest_is_of_the_content),
        cmocka_unit_test(test_study_as_understood_is_the_same_study),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
