/* SPDX-License-Identifier: MIT */
#include "studied.h"

#include "api/format/format.h"
#include "api/study/score.h"
#include "api/study/task.h"
#include "tests/check.h"
#include <jansson.h>
#include <math.h>
#include <string.h>

/* z = x y / 2 over [-1, 1] x [0, 1] in two faces, the second with its normal turned, by mosaic. */
static const char twisted[] =
    "{\"method\":\"mosaic\",\"surface\":{\"faces\":["
    "{\"degree_u\":1,\"degree_v\":1,\"knotvector_u\":[0,0,1,1],\"knotvector_v\":[0,0,1,1],"
    "\"size_u\":2,\"size_v\":2,\"control_points\":[[-1,0,0],[-1,1,-0.5],[0,0,0],[0,1,0]]},"
    "{\"degree_u\":1,\"degree_v\":1,\"knotvector_u\":[0,0,1,1],\"knotvector_v\":[0,0,1,1],"
    "\"size_u\":2,\"size_v\":2,\"control_points\":[[1,0,0],[1,1,0.5],[0,0,0],[0,1,0]]}]},"
    "\"fabric\":{\"spacing\":0.2}}";

static void test_study_variants_have_the_numbers_of_their_drapes(void **state) {
    static const char rest[] = "\"vary\":{\"start\":{\"grid\":7},\"angle_deg\":[0,31,77]},"
                               "\"objectives\":[\"max_shear_deg\",\"p95_shear_deg\"]";
    struct bytes parts[] = {
        studied_saddle(),
        studied_mesh(),
        {0},
        {0},
        text_replace(studied_bowl, "{\"spacing\":0.1}", "{\"spacing\":0.2},\"method\":\"mosaic\"")};
    (void)state;
    bytes_format(&parts[2], "%s", studied_roof);
    bytes_format(&parts[3], "%s", twisted);
    for (size_t k = 0; k < sizeof parts / sizeof *parts; k++) {
        struct studied f = studied_make(parts[k].data, rest);
        assert_int_equal(f.rows, 21);
        for (size_t row = 0; row < f.rows; row++)
            studied_check_bits(&f, row);
        studied_free(&f);
        bytes_free(&parts[k]);
    }
}

/* What is not varied stays: a start that the solver chooses, a direction that is a vector. */
static void test_study_keeps_what_it_does_not_vary(void **state) {
    struct bytes part = text_replace(studied_roof, "\"fabric\"",
                                     "\"start\":{\"face\":1,\"uv\":[0.3,0.4]},\"fabric\"");
    struct studied f =
        studied_make(part.data, "\"vary\":{\"pre_shear_deg\":{\"from\":-20,\"to\":20,\"step\":20}},"
                                "\"objectives\":[\"max_shear_deg\",\"p95_shear_deg\"]");
    (void)state;
    assert_int_equal(f.rows, 3);
    for (size_t row = 0; row < f.rows; row++) {
        studied_check_bits(&f, row);
        assert_true(studied_value(&f, "face", row) == 1 &&
                    studied_value(&f, "start_u", row) == 0.3);
        check_at_most(fabs(studied_value(&f, "max_shear_deg", row) - (row == 1 ? 0 : 20)), 0.02);
    }
    assert_int_equal(f.columns.study.best[QUANTITY_MAX_SHEAR], 1);
    studied_free(&f);
    bytes_free(&part);
}

static void test_study_has_the_same_bits_on_any_threads(void **state) {
    static const char *const searches[] = {"grid", "optimise"};
    struct bytes part = studied_saddle();
    (void)state;
    for (int k = 0; k < 2; k++) {
        struct bytes rest = {0};
        bytes_format(&rest,
                     "\"vary\":{\"start\":{\"grid\":40},\"angle_deg\":[0,20,40,60]},"
                     "\"search\":\"%s\",\"budget\":160,"
                     "\"objectives\":[\"max_shear_deg\",\"waste_area\"]",
                     searches[k]);
        studied_check_threads(part.data, rest.data);
        bytes_free(&rest);
    }
    bytes_free(&part);
}

/* Developable: no shear anywhere, and the flat pattern is the part. */
static void test_study_objectives_of_a_roof_are_exact(void **state) {
    struct bytes part = text_replace(studied_roof, "\"spacing\":0.2",
                                     "\"spacing\":0.2,\"locking_angle_deg\":5,\"thickness\":1,"
                                     "\"fiber_volume_fraction\":0.5");
    struct bytes rigid = text_replace(part.data, "{\"surface\"",
                                      "{\"cavity\":{\"height\":1},"
                                      "\"surface\"");
    const double width = 2 * sqrt(2.0), length = 2, area = width * length;
    struct studied f = studied_make(
        rigid.data,
        "\"vary\":{\"start\":{\"points\":[[-0.5,1,0.5],{\"point\":[0.25,0.5,0.75]}]},"
        "\"angle_deg\":[0,30]},\"wanted_direction\":[0,3,0],\"objectives\":[\"max_shear_deg\","
        "\"locked_area\",\"uncovered_area\",\"waste_area\",\"angle_deviation_deg\","
        "\"fiber_volume_fraction_range\"]");
    (void)state;
    for (size_t row = 0; row < f.rows; row++) {
        bool turned = row % 2 == 1;
        double c = cos(acos(-1) / 6), s = 0.5;
        double box = (width * c + length * s) * (width * s + length * c);
        /* yarns over the ridge are measured to 3e-8 of their length, their directions to 7e-8 */
        check_at_most(fabs(studied_value(&f, "max_shear_deg", row)), 1e-5);
        check_at_most(studied_value(&f, "locked_area", row), 0);
        check_at_most(studied_value(&f, "uncovered_area", row), 1e-12);
        check_at_most(fabs(studied_value(&f, "waste_area", row) - (turned ? box - area : 0)),
                      1e-3 * area);
        /* u runs up both faces, across the wanted direction; in cells over the ridge it is bent */
        check_at_most(fabs(studied_value(&f, "angle_deviation_deg", row) - (turned ? 60 : 90)),
                      0.1);
        check_at_most(studied_value(&f, "fiber_volume_fraction_range", row), 1e-3);
    }
    studied_free(&f);
    bytes_free(&rigid);
    bytes_free(&part);
}

/* On the saddle draped from its apex |sin gamma| = |x y| / sqrt((1 + x^2)(1 + y^2)); area and
 * shares of it by sums over (x, y). */
static void test_study_objectives_of_a_saddle_are_those_of_the_exact_net(void **state) {
    enum { N = 1500 };
    struct bytes coarse = studied_saddle(), part = text_replace(coarse.data, "0.25", "0.05");
    struct studied f =
        studied_make(part.data, "\"vary\":{\"start\":{\"points\":[[0,0,0]]},\"angle_deg\":[0]},"
                                "\"wanted_direction\":[1,0,0],"
                                "\"objectives\":[\"locked_area\",\"angle_deviation_deg\","
                                "\"fiber_volume_fraction_range\",\"p95_shear_deg\"],"
                                "\"limits\":{\"mean_shear_deg\":{\"max\":90}}");
    double locked = 0, all = 0, turned = 0, sheared = 0, degree = acos(-1) / 180;
    (void)state;
    for (int k = 0; k < N * N; k++) {
        double x = 2 * (k % N + 0.5) / N, y = 2 * (k / N + 0.5) / N;
        double own = sqrt(1 + x * x + y * y), sine = x * y / sqrt((1 + x * x) * (1 + y * y));
        locked += asin(sine) > 20 * degree ? own : 0;
        sheared += own * asin(sine) / degree;
        all += own;
        turned += own * acos(own / sqrt((1 + x * x) * (1 + y * y))) / degree;
    }
    double cell = 4.0 * 4.0 / (N * (double)N);
    check_at_most(fabs(studied_value(&f, "mean_shear_deg", 0) - sheared / all), 0.01);
    check_at_most(fabs(studied_value(&f, "locked_area", 0) - locked * cell), 1e-3 * all * cell);
    check_at_most(fabs(studied_value(&f, "angle_deviation_deg", 0) - turned / all), 0.01);
    double most = 0.5 * 0.01 / 0.012 / cos(asin(0.8)), least = 0.5 * 0.01 / 0.012;
    check_at_most(fabs(studied_value(&f, "fiber_volume_fraction_range", 0) - (most - least)), 2e-3);
    studied_free(&f);
    bytes_free(&part);
    bytes_free(&coarse);
}

/* The front by definition, and the best. */
static void test_study_front_is_what_nothing_dominates(void **state) {
    struct bytes part = studied_saddle();
    struct studied f =
        studied_make(part.data, "\"vary\":{\"start\":{\"grid\":30},\"angle_deg\":[0,15,30,45,60]},"
                                "\"limits\":{\"mean_shear_deg\":{\"max\":20}},"
                                "\"wanted_direction\":[1,2,0],"
                                "\"objectives\":[\"p95_shear_deg\",\"angle_deviation_deg\"]");
    static const char *const names[] = {"p95_shear_deg", "angle_deviation_deg"};
    size_t front = 0, feasible = 0;
    (void)state;
    for (size_t a = 0; a < f.rows; a++) {
        bool keeps = studied_value(&f, "mean_shear_deg", a) <= 20, beaten = false;
        for (size_t b = 0; b < f.rows && keeps; b++) {
            double d[2];
            for (int k = 0; k < 2; k++)
                d[k] = studied_value(&f, names[k], b) - studied_value(&f, names[k], a);
            bool other = studied_value(&f, "mean_shear_deg", b) <= 20;
            beaten = beaten || (other && d[0] <= 0 && d[1] <= 0 && (d[0] < 0 || d[1] < 0));
        }
        assert_int_equal(studied_value(&f, "feasible", a), keeps);
        assert_int_equal(studied_value(&f, "pareto", a), keeps && !beaten);
        front += keeps && !beaten;
        feasible += keeps;
    }
    check_above(front, 1);
    check_below(feasible, f.rows);
    assert_int_equal(f.columns.study.pareto, front);
    assert_int_equal(f.columns.study.feasible, feasible);
    assert_int_equal(f.columns.study.hardest, -1);
    studied_free(&f);
    bytes_free(&part);
}

/* On a plane every variant is as good as the others: none beats another. */
static void test_study_front_keeps_all_that_are_equal(void **state) {
    static const char plane[] =
        "{\"surface\":{\"degree_u\":1,\"degree_v\":1,\"knotvector_u\":[0,0,1,1],"
        "\"knotvector_v\":[0,0,1,1],\"size_u\":2,\"size_v\":2,"
        "\"control_points\":[[0,0,0],[0,1,0],[1,0,0],[1,1,0]]},\"fabric\":{\"spacing\":0.1}}";
    struct studied f = studied_make(plane, "\"vary\":{\"start\":{\"grid\":4}},"
                                           "\"objectives\":[\"max_shear_deg\"]");
    (void)state;
    check_above(f.rows, 1);
    for (size_t row = 0; row < f.rows; row++)
        assert_true(studied_value(&f, "max_shear_deg", row) == 0 &&
                    studied_value(&f, "pareto", row) == 1);
    assert_int_equal(f.columns.study.pareto, f.rows);
    studied_free(&f);
}

/* Of two that none keeps that which is missed by more, whichever comes first. */
static void test_study_says_which_of_two_limits_is_harder(void **state) {
    static const struct {
        const char *limits;
        enum quantity_id hardest;
    } cases[] = {
        {"\"max_shear_deg\":{\"max\":0.1},\"p95_shear_deg\":{\"max\":20}", QUANTITY_MAX_SHEAR},
        {"\"max_shear_deg\":{\"max\":30},\"p95_shear_deg\":{\"max\":0.1}", QUANTITY_P95_SHEAR},
    };
    struct bytes part = studied_saddle();
    (void)state;
    for (int k = 0; k < 2; k++) {
        char rest[200];
        snprintf(rest, sizeof rest,
                 "\"vary\":{\"angle_deg\":[0,20]},\"objectives\":[\"waste_area\"],\"limits\":{%s}",
                 cases[k].limits);
        struct studied f = studied_make(part.data, rest);
        for (size_t row = 0; row < f.rows; row++) {
            check_above(studied_value(&f, "max_shear_deg", row), 30);
            check_above(studied_value(&f, "p95_shear_deg", row), 20);
        }
        assert_int_equal(f.columns.study.hardest, cases[k].hardest);
        studied_free(&f);
    }
    bytes_free(&part);
}

static void test_study_says_which_limit_is_hardest(void **state) {
    struct bytes part = studied_saddle();
    struct studied f = studied_make(
        part.data, "\"vary\":{\"start\":{\"grid\":9}},\"objectives\":[\"waste_area\"],"
                   "\"limits\":{\"cloth_coverage\":{\"min\":0.5},\"max_shear_deg\":{\"max\":1},"
                   "\"p95_shear_deg\":{\"max\":80}}");
    (void)state;
    assert_int_equal(f.columns.study.feasible, 0);
    assert_int_equal(f.columns.study.pareto, 0);
    assert_int_equal(f.columns.study.hardest, QUANTITY_MAX_SHEAR);
    assert_string_equal(f.columns.study.warnings.list[0].code, "infeasible");
    assert_string_equal(f.columns.study.warnings.list[0].pointer, "/limits/max_shear_deg");
    size_t best = (size_t)f.columns.study.best[QUANTITY_WASTE_AREA];
    for (size_t row = 0; row < f.rows; row++)
        check_at_least(studied_value(&f, "max_shear_deg", row),
                       studied_value(&f, "max_shear_deg", best));
    studied_free(&f);
    bytes_free(&part);
}

/* The best of nets that are held to a corner of the part, unless the study has a limit for that. */
static void test_study_warns_of_what_is_bare(void **state) {
    static const char *const limits[] = {"", ",\"limits\":{\"cloth_coverage\":{\"min\":0}}"};
    struct bytes whole = studied_saddle();
    struct bytes part = text_replace(whole.data, "\"fabric\"",
                                     "\"extent\":{\"warp\":[0,4],\"weft\":[0,4]},\"fabric\"");
    (void)state;
    for (size_t k = 0; k < 2; k++) {
        char rest[200];
        snprintf(rest, sizeof rest,
                 "\"vary\":{\"angle_deg\":[0,45]},\"objectives\":[\"max_shear_deg\"]%s", limits[k]);
        struct studied f = studied_make(part.data, rest);
        const struct api_warnings *warnings = &f.columns.study.warnings;
        size_t best = (size_t)f.columns.study.best[QUANTITY_MAX_SHEAR];
        check_below(studied_value(&f, "cloth_coverage", best), 0.5);
        assert_int_equal(warnings->count, k == 0);
        if (k == 0)
            assert_string_equal(warnings->list[0].code, "uncovered");
        studied_free(&f);
    }
    bytes_free(&part);
    bytes_free(&whole);
}

/* Of two directions that which keeps a limit is the best, though the other has less shear. */
static void test_study_best_keeps_the_limits(void **state) {
    struct bytes part = studied_saddle();
    static const char vary[] = "\"vary\":{\"angle_deg\":[0,45]},\"objectives\":[\"max_shear_deg\"]";
    struct studied f = studied_make(part.data, vary);
    size_t least = (size_t)f.columns.study.best[QUANTITY_MAX_SHEAR];
    char rest[300];
    (void)state;
    check_above(studied_value(&f, "max_shear_deg", 1 - least),
                studied_value(&f, "max_shear_deg", least) + 0.1);
    for (int lower = 0; lower < 2; lower++) {
        if (lower)
            snprintf(rest, sizeof rest, "%s,\"limits\":{\"max_shear_deg\":{\"min\":%.17g}}", vary,
                     studied_value(&f, "max_shear_deg", least) + 0.1);
        else
            snprintf(rest, sizeof rest,
                     "%s,\"wanted_direction\":[1,%d,0],"
                     "\"limits\":{\"angle_deviation_deg\":{\"max\":30}}",
                     vary, least == 0);
        struct studied held = studied_make(part.data, rest);
        assert_int_equal(held.columns.study.best[QUANTITY_MAX_SHEAR], 1 - least);
        assert_int_equal(held.columns.study.feasible, 1);
        assert_true(studied_value(&held, "feasible", least) == 0);
        studied_free(&held);
    }
    studied_free(&f);
    bytes_free(&part);
}

static void test_study_goes_on_after_a_variant_that_cannot_be_draped(void **state) {
    struct bytes part = studied_saddle(), document = {0};
    struct studied f =
        studied_make(part.data, "\"vary\":{\"start\":{\"points\":[[0,0,0],[9,9,9],[1,1,0]]}},"
                                "\"objectives\":[\"max_shear_deg\"]");
    struct api_problem problem = {0};
    struct api_reader reader = reader_over(&f.container);
    char buffer[4096];
    ssize_t length;
    (void)state;
    assert_int_equal(f.columns.study.failed, 1);
    assert_int_equal(studied_value(&f, "failure", 1), FAILURE_START_OFF_SURFACE);
    assert_non_null(
        strstr(f.columns.study.warnings.list[0].detail, " because of start-off-surface"));
    assert_int_equal(studied_value(&f, "feasible", 1), 0);
    struct encoder *encoder =
        encoder_new(format_named(FORMAT_RESULT, "json"), &(struct format_source){.reader = &reader},
                    &(struct format_options){0}, &problem);
    assert_non_null(encoder);
    while ((length = encoder_read(encoder, buffer, sizeof buffer)) > 0)
        bytes_add(&document, buffer, (size_t)length);
    encoder_free(encoder);
    json_t *root = json_loadb(document.data, document.length, 0, NULL);
    json_t *variants = json_object_get(root, "variants");
    assert_non_null(variants);
    assert_true(json_is_null(json_array_get(json_object_get(variants, "max_shear_deg"), 1)));
    assert_string_equal(json_string_value(json_array_get(json_object_get(variants, "failure"), 1)),
                        "start-off-surface");
    json_decref(root);
    bytes_free(&document);
    studied_free(&f);
    bytes_free(&part);
}

/* On a part of 4 m^2 a limit is missed by a share of what the quantity ranges over there; a ratio
 * of no end, by a share of the limit. */
static void test_study_violations_are_shares_of_ranges(void **state) {
    static const struct {
        enum quantity_id id;
        double min, max, value, share; /* min or max HUGE_VAL: there is none */
    } cases[] = {{QUANTITY_MAX_SHEAR, HUGE_VAL, 30, 39, 0.1},
                 {QUANTITY_MEAN_SHEAR, HUGE_VAL, 30, 29, 0},
                 {QUANTITY_ANGLE_DEVIATION, HUGE_VAL, 0, 45, 0.5},
                 {QUANTITY_CLOTH_COVERAGE, 0.9, HUGE_VAL, 0.4, 0.5},
                 {QUANTITY_CLOTH_COVERAGE, 0.2, 0.5, 0.3, 0},
                 {QUANTITY_CLOTH_COVERAGE, 0.2, 0.5, 0.75, 0.25},
                 {QUANTITY_WASTE_AREA, HUGE_VAL, 1, 3, 0.5},
                 {QUANTITY_UNCOVERED_AREA, 2, HUGE_VAL, 1, 0.25},
                 {QUANTITY_LOCKED_AREA, HUGE_VAL, 0, 4, 1},
                 {QUANTITY_SEVERITY_AREA, HUGE_VAL, 0, 1, 0.25},
                 {QUANTITY_CUT_LENGTH, HUGE_VAL, 1, 2, 0.5},
                 {QUANTITY_K1_RATIO, HUGE_VAL, 5, 10, 1},
                 {QUANTITY_FRACTION_RANGE, HUGE_VAL, 0.25, 0.75, 0.5}};
    static struct api_study study;
    static struct study_row row;
    (void)state;
    study.part.area = 4;
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        struct study_limit *limit = &study.request.limit[cases[k].id];
        *limit = (struct study_limit){.has_min = cases[k].min < HUGE_VAL,
                                      .min = cases[k].min,
                                      .has_max = cases[k].max < HUGE_VAL,
                                      .max = cases[k].max};
        row.quantity[cases[k].id] = cases[k].value;
        check_at_most(fabs(study_violation(&study, &row) - cases[k].share), 1e-15);
        *limit = (struct study_limit){.has_min = false};
    }
    row.failure = FAILURE_CRASHED;
    assert_true(study_violation(&study, &row) == HUGE_VAL);
}

/* A net that is twice as coarse has a quarter of the nodes. */
static void test_study_counts_the_nodes_of_coarse_nets(void **state) {
    static struct api_study study;
    (void)state;
    study.part.area = 6;
    study.request.drape.settings.spacing[0] = 0.1;
    study.request.drape.settings.spacing[1] = 0.2;
    check_at_most(fabs(study_nodes(&study, 1) - 301), 1e-9);
    check_at_most(fabs(study_nodes(&study, 2) - 76), 1e-9);
    check_at_most(fabs(study_cost(&study, 2) - drape_method_traits[0].cost * 76), 1e-9);
}

/* While it goes on the least so far is told, of each objective and of no more; of what failed, or
 * misses a limit by more, nothing. */
static void test_study_tells_the_best_so_far(void **state) {
    enum { ROWS = 5, ROW = STUDY_ROW_NUMBERS, FAILED = 10, SHEAR = ROW - QUANTITY_COUNT };
    static double numbers[ROWS * ROW];
    static const double shears[ROWS] = {5, 1, 3, 4, 2}, covers[ROWS] = {1, 1, 1, 1, 0.4};
    struct bytes text = studied_text(studied_roof, "\"vary\":{\"start\":{\"grid\":300}},"
                                                   "\"objectives\":[\"max_shear_deg\"],"
                                                   "\"limits\":{\"cloth_coverage\":{\"min\":0.5}}");
    const struct api_input input = studied_input(&text);
    struct api_problem problem = {0};
    struct api_study_plan plan = {0};
    struct arena *arena = arena_new((size_t)1 << 28);
    (void)state;
    prepare();
    struct api_study *study = api_study_open(&input, &api_limits_default, &problem);
    assert_non_null(study);
    for (size_t k = 0; k < ROWS; k++) {
        numbers[k * ROW + SHEAR + QUANTITY_MAX_SHEAR] = shears[k];
        numbers[k * ROW + SHEAR + QUANTITY_CLOTH_COVERAGE] = covers[k];
    }
    numbers[ROW + FAILED] = FAILURE_CRASHED;
    const struct api_study_numbers so_far = {numbers, ROWS * ROW};
    assert_int_equal(api_study_plan(study, &so_far, arena, &plan, &problem), API_OK);
    for (int id = 0; id < QUANTITY_COUNT; id++)
        assert_true(id == QUANTITY_MAX_SHEAR ? plan.best[id] == 3 : isnan(plan.best[id]));
    api_study_close(study);
    arena_free(arena);
    bytes_free(&text);
}

/* How many variants the first task of a study of 300 starts has. */
static size_t first_task(const char *drape) {
    struct bytes text = studied_text(
        drape, "\"vary\":{\"start\":{\"grid\":300}},\"objectives\":[\"max_shear_deg\"]");
    const struct api_input input = studied_input(&text);
    const struct api_study_numbers none = {NULL, 0};
    struct api_problem problem = {0};
    struct api_study_plan plan = {0};
    struct arena *arena = arena_new((size_t)1 << 28);
    prepare();
    struct api_study *study = api_study_open(&input, &api_limits_default, &problem);
    assert_non_null(study);
    assert_int_equal(api_study_plan(study, &none, arena, &plan, &problem), API_OK);
    size_t variants = (size_t)plan.tasks[0].variants;
    api_study_close(study);
    arena_free(arena);
    bytes_free(&text);
    return variants;
}

/* What waits for a task waits about as long whatever its method: the slower ones have fewer
 * variants. */
static void test_study_gives_slow_methods_short_tasks(void **state) {
    struct bytes part = text_replace(studied_bowl, "0.1}", "0.1},\"method\":\"gib\"");
    struct bytes slow = text_replace(part.data, "\"gib\"", "\"geodesic\"");
    struct bytes slower = text_replace(part.data, "\"gib\"", "\"mosaic\"");
    size_t variants[] = {first_task(part.data), first_task(slow.data), first_task(slower.data)};
    (void)state;
    check_at_least((double)variants[0], 3.5 * (double)variants[1]);
    check_at_least((double)variants[0], 3.5 * (double)variants[2]);
    check_at_least((double)variants[1], 1);
    check_at_least((double)variants[2], 1);
    bytes_free(&part);
    bytes_free(&slow);
    bytes_free(&slower);
}

/* A large grid has rounds, each as large as all before; together they have each variant once. */
static void test_study_does_large_grids_in_rounds(void **state) {
    enum { VARIANTS = 300, ROW = 18 + QUANTITY_COUNT };
    static double numbers[VARIANTS * ROW]; /* rows of zeros are sound */
    struct bytes coarse = studied_saddle(), part = text_replace(coarse.data, "0.25", "0.005");
    struct bytes text = studied_text(
        part.data, "\"vary\":{\"start\":{\"grid\":300}},\"objectives\":[\"max_shear_deg\"]");
    const struct api_input input = studied_input(&text);
    struct api_problem problem = {0};
    struct arena *arena = arena_new((size_t)1 << 28);
    prepare();
    struct api_study *study = api_study_open(&input, &api_limits_default, &problem);
    struct api_study_plan plan = {0};
    size_t done = 0, rounds = 0, before = 0;
    (void)state;
    assert_non_null(study);
    for (;; rounds++) {
        const struct api_study_numbers so_far = {numbers, done * ROW};
        assert_int_equal(api_study_plan(study, &so_far, arena, &plan, &problem), API_OK);
        assert_int_equal(plan.done, done);
        assert_int_equal(plan.variants, VARIANTS);
        before = done;
        for (size_t k = 0; k < plan.count; k++)
            done += (size_t)plan.tasks[k].variants;
        if (plan.count == 0)
            break;
        check_at_most(done - before, before > 100 ? before : 100);
        assert_in_range(done, 1, VARIANTS);
    }
    assert_int_equal(done, VARIANTS);
    assert_int_equal(rounds, 4);
    api_study_close(study);
    arena_free(arena);
    bytes_free(&text);
    bytes_free(&part);
    bytes_free(&coarse);
}

/* A task whose variant crashed its process: it is marked, and the others are as they were. */
static void test_study_marks_variants_that_crash(void **state) {
    struct bytes part = studied_saddle(), given[2] = {{0}, {0}};
    struct bytes text = studied_text(part.data, "\"vary\":{\"angle_deg\":[0,10,20,30]},"
                                                "\"objectives\":[\"max_shear_deg\"]");
    const struct api_input input = studied_input(&text);
    struct api_problem problem = {0};
    struct api_study_plan plan;
    (void)state;
    prepare();
    struct api_study *study = api_study_open(&input, &api_limits_default, &problem);
    struct arena *arena = arena_new((size_t)1 << 30);
    assert_non_null(study);
    assert_int_equal(api_study_plan(study, &(struct api_study_numbers){0}, arena, &plan, &problem),
                     API_OK);
    assert_int_equal(plan.count, 1);
    assert_int_equal((size_t)plan.tasks[0].variants, 4);
    for (int k = 0; k < 2; k++) {
        struct api_study_task task = plan.tasks[0];
        const struct api_sink sink = sink_into(&given[k]);
        if (k)
            api_study_task_crashed(&task, 2);
        assert_int_equal(api_study_run_task(study, &task, NULL, arena, &sink, &problem), API_OK);
    }
    size_t row = given[0].length / 4;
    assert_int_equal(given[1].length, given[0].length);
    for (size_t k = 0; k < 4; k++)
        assert_int_equal(memcmp(given[0].data + k * row, given[1].data + k * row, row) != 0,
                         k == 2);
    const struct api_study_numbers numbers = {(const double *)(const void *)given[1].data,
                                              given[1].length / sizeof(double)};
    struct studied f = {.rows = 4};
    const struct api_sink sink = sink_into(&f.container);
    assert_int_equal(api_study_finish(study, &numbers, 0, arena, &sink, &problem), API_OK);
    struct api_reader reader = reader_over(&f.container);
    assert_int_equal(api_columns_open(&reader, &f.columns, &problem), API_OK);
    assert_int_equal(studied_value(&f, "failure", 2), FAILURE_CRASHED);
    assert_int_equal(f.columns.study.failed, 1);
    arena_free(arena);
    api_study_close(study);
    studied_free(&f);
    bytes_free(&given[0]);
    bytes_free(&given[1]);
    bytes_free(&text);
    bytes_free(&part);
}

/* There the shear of each sign has half of every area: one locks at 20 degrees, the other at 35,
 * and its severity rises from 0 to 1 over 40 degrees and over 50. */
static void test_study_judges_each_sign_of_the_shear(void **state) {
    enum { N = 1500 };
    struct bytes coarse = studied_saddle(), fine = text_replace(coarse.data, "0.25", "0.05");
    struct bytes part =
        text_replace(fine.data, "\"locking_angle_deg\":20",
                     "\"locking_angle_deg\":{\"positive\":35,\"negative\":20},"
                     "\"limit_curve\":{\"shear_deg\":[-50,0,40],\"severity\":[1,0,1]}");
    struct studied f =
        studied_make(part.data, "\"vary\":{\"start\":{\"points\":[[0,0,0]]},\"angle_deg\":[0]},"
                                "\"objectives\":[\"locked_area\",\"severity_area\"]");
    double locked = 0, severe = 0, all = 0, degree = acos(-1) / 180;
    (void)state;
    for (int k = 0; k < N * N; k++) {
        double x = 2 * (k % N + 0.5) / N, y = 2 * (k / N + 0.5) / N;
        double own = sqrt(1 + x * x + y * y), sine = x * y / sqrt((1 + x * x) * (1 + y * y));
        double shear_deg = asin(sine) / degree;
        locked += ((shear_deg > 35) + (shear_deg > 20)) * own / 2;
        severe += (fmin(shear_deg / 40, 1) + fmin(shear_deg / 50, 1)) * own / 2;
        all += own;
    }
    double cell = 4.0 * 4.0 / (N * (double)N);
    check_at_most(fabs(studied_value(&f, "locked_area", 0) - locked * cell), 1e-3 * all * cell);
    check_at_most(fabs(studied_value(&f, "severity_area", 0) - severe * cell), 1e-3 * all * cell);
    studied_free(&f);
    bytes_free(&part);
    bytes_free(&fine);
    bytes_free(&coarse);
}

/* ---- continuity ---- */

/* While the start moves over half a spacing in hundredths of one, and turns, every quantity goes
 * its way: the sum of its steps is little more than its range, and no step is much of that of one
 * degree or of the area. */
static void test_study_quantities_do_not_jump(void **state) {
    enum { STEPS = 50 };
    static const char *const names[] = {"max_shear_deg",  "p95_shear_deg", "locked_area",
                                        "uncovered_area", "waste_area",    "angle_deviation_deg"};
    static const double most[] = {0.15, 0.1, 0.03, 1e-3, 0.05, 0.05};
    struct bytes rest = {0};
    struct bytes part = text_replace(studied_bowl, "0.1}", "0.1,\"locking_angle_deg\":15}");
    (void)state;
    bytes_format(&rest, "\"objectives\":[\"max_shear_deg\",\"p95_shear_deg\",\"locked_area\","
                        "\"uncovered_area\",\"waste_area\",\"angle_deviation_deg\"],"
                        "\"wanted_direction\":[1,0.3,0],\"vary\":{\"angle_deg\":[17],"
                        "\"start\":{\"points\":[");
    for (int k = 0; k <= STEPS; k++)
        bytes_format(&rest, "%s{\"uv\":[%.17g,0.55]}", k ? "," : "", 0.55 + 0.0005 * k);
    bytes_format(&rest, "]}}");
    struct studied f = studied_make(part.data, rest.data);
    for (size_t q = 0; q < sizeof names / sizeof *names; q++) {
        double sum = 0, low = HUGE_VAL, high = -HUGE_VAL;
        for (size_t k = 0; k < f.rows; k++) {
            double value = studied_value(&f, names[q], k);
            double step = k ? fabs(value - studied_value(&f, names[q], k - 1)) : 0;
            if (step > most[q])
                fail_msg("%s steps by %g at %zu", names[q], step, k);
            sum += step;
            low = fmin(low, value);
            high = fmax(high, value);
        }
        if (sum > 3 * (high - low) + 10 * most[q])
            fail_msg("%s goes %g to and fro within %g", names[q], sum, high - low);
    }
    studied_free(&f);
    bytes_free(&rest);
    bytes_free(&part);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_study_violations_are_shares_of_ranges),
        cmocka_unit_test(test_study_counts_the_nodes_of_coarse_nets),
        cmocka_unit_test(test_study_tells_the_best_so_far),
        cmocka_unit_test(test_study_variants_have_the_numbers_of_their_drapes),
        cmocka_unit_test(test_study_keeps_what_it_does_not_vary),
        cmocka_unit_test(test_study_has_the_same_bits_on_any_threads),
        cmocka_unit_test(test_study_objectives_of_a_roof_are_exact),
        cmocka_unit_test(test_study_judges_each_sign_of_the_shear),
        cmocka_unit_test(test_study_objectives_of_a_saddle_are_those_of_the_exact_net),
        cmocka_unit_test(test_study_front_is_what_nothing_dominates),
        cmocka_unit_test(test_study_front_keeps_all_that_are_equal),
        cmocka_unit_test(test_study_says_which_limit_is_hardest),
        cmocka_unit_test(test_study_says_which_of_two_limits_is_harder),
        cmocka_unit_test(test_study_warns_of_what_is_bare),
        cmocka_unit_test(test_study_best_keeps_the_limits),
        cmocka_unit_test(test_study_goes_on_after_a_variant_that_cannot_be_draped),
        cmocka_unit_test(test_study_gives_slow_methods_short_tasks),
        cmocka_unit_test(test_study_does_large_grids_in_rounds),
        cmocka_unit_test(test_study_marks_variants_that_crash),
        cmocka_unit_test(test_study_quantities_do_not_jump),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
