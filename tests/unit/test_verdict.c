/* SPDX-License-Identifier: MIT */
/* The verdict of drapes and studies, on nets that are known. */
#include "studied.h"

#include "api/result/verdict.h"
#include "tests/check.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* z = 5 (1 - x^2) (1 - y^2) over [-1, 1]^2, so steep that no cloth covers it. */
static const char hill[] =
    "{\"surface\":{\"degree_u\":2,\"degree_v\":2,\"size_u\":3,\"size_v\":3,\"knotvector_u\":"
    "[0,0,0,1,1,1],\"knotvector_v\":[0,0,0,1,1,1],\"control_points\":[[-1,-1,0],[-1,0,0],[-1,1,0],"
    "[0,-1,0],[0,0,20],[0,1,0],[1,-1,0],[1,0,0],[1,1,0]]},\"fabric\":{\"spacing\":0.1}}";

/* The saddle z = (x^2 - y^2) / 2 over [-2, 2]^2 from its middle, with `more` in its request. */
static struct bytes saddle_with(const char *more) {
    struct bytes text = {0};
    bytes_format(&text, "{\"surface\":%s,%s}", request_text("saddle_surface"), more);
    return text;
}

/* The verdict of a drape, as its stored result has it. */
static struct api_verdict drape_verdict(const char *drape) {
    struct bytes container = {0};
    struct api_problem problem = {0};
    struct api_columns columns;
    prepare();
    assert_int_equal(run_text(drape, &container, &problem), API_OK);
    const struct api_reader reader = reader_over(&container);
    assert_int_equal(api_columns_open(&reader, &columns, &problem), API_OK);
    bytes_free(&container);
    return columns.summary.verdict;
}

/* Its largest shear, 53.13 degrees, is in the corners; without a locking angle the limit is 60. */
static void test_verdict_of_a_drape_is_by_its_locking_angle(void **state) {
    static const char *const fabrics[] = {
        "\"fabric\":{\"spacing\":0.25,\"locking_angle_deg\":53}",
        "\"fabric\":{\"spacing\":0.25,\"locking_angle_deg\":53.2}",
        "\"fabric\":{\"spacing\":0.25}",
    };
    (void)state;
    for (int k = 0; k < 3; k++) {
        struct bytes saddle = saddle_with(fabrics[k]);
        struct api_verdict v = drape_verdict(saddle.data);
        assert_int_equal(v.obstacle, k == 0 ? VERDICT_SHEAR : VERDICT_DRAPABLE);
        assert_true(v.placed == (k == 0));
        if (k == 0) {
            check_at_most(fabs(fabs(v.at.x) - 2) + fabs(fabs(v.at.y) - 2) + fabs(v.at.z), 1e-9);
            assert_non_null(strstr(v.detail, "not within 53 degrees in one piece"));
        }
        bytes_free(&saddle);
    }
}

/* A coordinate that is rounding beside the others is said to be 0. */
static void test_verdict_says_places_without_rounding(void **state) {
    static const struct {
        struct vec3 at;
        const char *where;
    } rows[] = {{{-1e-12, 2, 3}, " at (0, 2, 3);"},
                {{1, -1e-12, 3}, " at (1, 0, 3);"},
                {{1, 2, -1e-12}, " at (1, 2, 0);"},
                {{1e-8, 2e-8, 3}, " at (1e-08, 2e-08, 3);"},
                {{-1e-12, -2e-12, 3e-12}, " at (-1e-12, -2e-12, 3e-12);"}};
    (void)state;
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        struct api_verdict v;
        verdict_judge(&(struct verdict_case){.coverage = 1,
                                             .shear_deg = 61,
                                             .limit_deg = 60,
                                             .placed = true,
                                             .at = rows[k].at,
                                             .remedy = "cut it"},
                      &v);
        assert_non_null(strstr(v.detail, rows[k].where));
    }
}

/* The shear has the other sign in the corners where x and y have the same one. */
static void test_verdict_of_a_drape_is_by_the_sign_that_locks(void **state) {
    static const struct {
        const char *fabric, *detail;
        double sign; /* of x y there; 0: drapable */
    } rows[] = {
        {"\"fabric\":{\"spacing\":0.25,\"locking_angle_deg\":{\"positive\":50,\"negative\":53}}",
         "not within 50 degrees", -1},
        {"\"fabric\":{\"spacing\":0.25,\"locking_angle_deg\":{\"positive\":60,\"negative\":53}}",
         "not within 53 degrees", 1},
        {"\"fabric\":{\"spacing\":0.25,\"locking_angle_deg\":{\"positive\":60,\"negative\":54}}",
         "within 54 degrees", 0}};
    (void)state;
    for (size_t k = 0; k < sizeof rows / sizeof *rows; k++) {
        struct bytes saddle = saddle_with(rows[k].fabric);
        struct api_verdict v = drape_verdict(saddle.data);
        assert_int_equal(v.obstacle, rows[k].sign == 0 ? VERDICT_DRAPABLE : VERDICT_SHEAR);
        assert_non_null(strstr(v.detail, rows[k].detail));
        assert_true(rows[k].sign == 0 || rows[k].sign * v.at.x * v.at.y > 3.9);
        bytes_free(&saddle);
    }
}

/* Where the cloth ends lies on the part, and not at its edge; where it was asked to end there is no
 * obstacle. */
static void test_verdict_says_where_the_cloth_ends(void **state) {
    struct api_verdict v = drape_verdict(hill);
    struct bytes narrow =
        saddle_with("\"extent\":{\"warp\":[-2,2],\"weft\":[-2,2]},\"fabric\":{\"spacing\":0.25}");
    (void)state;
    assert_int_equal(v.obstacle, VERDICT_UNCOVERED);
    assert_true(v.placed);
    check_below(fmax(fabs(v.at.x), fabs(v.at.y)), 1 - 1e-9);
    check_at_most(fabs(v.at.z - 5 * (1 - v.at.x * v.at.x) * (1 - v.at.y * v.at.y)), 1e-6);
    assert_non_null(strstr(v.detail, "not in one piece"));
    v = drape_verdict(narrow.data);
    assert_int_equal(v.obstacle, VERDICT_DRAPABLE);
    bytes_free(&narrow);
}

/* A bowl from its apex has 30 degrees in its corners, and from other starts more. A study is judged
 * by its best variant, samples by their worst. */
static void test_verdict_of_a_study_is_by_its_best(void **state) {
    static const struct {
        const char *rest;
        enum verdict_obstacle obstacle;
        bool worst;
    } cases[] = {
        {"\"vary\":{\"start\":{\"points\":[[0.5,0.3,0.17],[0,0,0]]}},"
         "\"limits\":{\"max_shear_deg\":{\"max\":30.5}},\"objectives\":[\"waste_area\"]",
         VERDICT_DRAPABLE, false},
        {"\"vary\":{\"start\":{\"points\":[[0.5,0.3,0.17],[0,0,0]]}},"
         "\"limits\":{\"max_shear_deg\":{\"max\":29.5}},\"objectives\":[\"waste_area\"]",
         VERDICT_SHEAR, false},
        {"\"vary\":{\"start\":{\"points\":[[0.5,0.3,0.17],[0,0,0]]}},"
         "\"limits\":{\"mean_shear_deg\":{\"max\":1}},\"objectives\":[\"max_shear_deg\"]",
         VERDICT_LIMIT, false},
        {"\"vary\":{\"start\":{\"points\":[[9,9,9]]}},\"objectives\":[\"max_shear_deg\"]",
         VERDICT_FAILED, false},
        {"\"vary\":{\"start\":{\"radius\":0.3}},\"sample\":20,\"seed\":1", VERDICT_DRAPABLE, true},
    };
    (void)state;
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        struct studied f = studied_make(studied_bowl, cases[k].rest);
        const struct api_verdict *v = &f.columns.study.verdict;
        assert_int_equal(v->obstacle, cases[k].obstacle);
        assert_true((v->variant < 0) == (v->obstacle == VERDICT_FAILED));
        if (v->obstacle == VERDICT_SHEAR)
            check_at_most(fabs(fabs(v->at.x) - 1) + fabs(fabs(v->at.y) - 1), 1e-5);
        if (v->variant >= 0 && !cases[k].worst)
            check_at_most(studied_value(&f, "x", (size_t)v->variant), 1e-6);
        for (size_t row = 0; cases[k].worst && row < f.rows; row++)
            check_at_most(studied_value(&f, "max_shear_deg", row),
                          studied_value(&f, "max_shear_deg", (size_t)v->variant));
        studied_free(&f);
    }
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_verdict_says_places_without_rounding),
        cmocka_unit_test(test_verdict_of_a_drape_is_by_the_sign_that_locks),
        cmocka_unit_test(test_verdict_of_a_drape_is_by_its_locking_angle),
        cmocka_unit_test(test_verdict_says_where_the_cloth_ends),
        cmocka_unit_test(test_verdict_of_a_study_is_by_its_best),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
