/* SPDX-License-Identifier: MIT */
#include "api/study/study.h"

#include "api/format/format.h"
#include "api/map/map.h"
#include "support.h"
#include "tests/check.h"
#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- studies as text ---- */

/* A study of a drape, with `rest` behind it. */
static struct bytes study_of(const char *drape, const char *rest) {
    struct bytes text = {0};
    bytes_format(&text, "{\"drape\":");
    bytes_add(&text, drape, strlen(drape));
    bytes_format(&text, ",%s}", rest);
    return text;
}

static struct api_input input_of(const struct bytes *text) {
    return (struct api_input){.request = text->data, .request_length = text->length};
}

static enum api_problem_id run_study(const struct bytes *text, int threads, struct bytes *container,
                                     struct api_problem *problem) {
    const struct api_input input = input_of(text);
    const struct api_sink sink = sink_into(container);
    struct api_limits limits = api_limits_default;
    prepare();
    *problem = (struct api_problem){0};
    limits.threads = threads;
    return api_study_run(&input, &limits, NULL, &sink, problem);
}

/* A finished study, read back. */
struct finished {
    struct bytes text, container;
    struct api_columns columns;
    size_t rows;
};

static struct finished finish_study(const char *drape, const char *rest) {
    struct finished f = {.text = study_of(drape, rest)};
    struct api_problem problem;
    if (run_study(&f.text, 2, &f.container, &problem) != API_OK)
        fail_msg("%s: %s", problem.place[0].pointer, problem.place[0].detail);
    struct api_reader reader = reader_over(&f.container);
    assert_int_equal(api_columns_open(&reader, &f.columns, &problem), API_OK);
    assert_int_equal(f.columns.document, API_DOCUMENT_STUDY);
    f.rows = api_columns_rows(&f.columns, API_TABLE_VARIANTS);
    assert_int_equal(f.rows, f.columns.study.variants);
    return f;
}

static void free_finished(struct finished *f) {
    bytes_free(&f->text);
    bytes_free(&f->container);
}

static double value_at(struct finished *f, const char *name, size_t row) {
    struct api_reader reader = reader_over(&f->container);
    const struct api_column *column = api_columns_find(&f->columns, API_TABLE_VARIANTS, name);
    double value;
    if (!column)
        fail_msg("no column %s", name);
    assert_true(api_columns_read(&reader, column, row, 1, &value));
    return value;
}

/* The drape request of a variant. */
static struct bytes request_of(struct finished *f, size_t row) {
    struct bytes request = {0};
    struct api_problem problem = {0};
    const struct api_input input = input_of(&f->text);
    const struct api_sink sink = sink_into(&request);
    struct api_reader reader = reader_over(&f->container);
    struct api_study *study = api_study_open(&input, &api_limits_default, &problem);
    struct arena *arena = arena_new((size_t)1 << 30);
    assert_non_null(study);
    assert_int_equal(api_study_variant_request(study, &reader, row, arena, &sink, &problem),
                     API_OK);
    bytes_add(&request, "", 1);
    arena_free(arena);
    api_study_close(study);
    return request;
}

static struct api_summary summary_of(const char *request) {
    struct bytes container = {0};
    struct api_problem problem;
    struct api_columns columns;
    assert_int_equal(run_text(request, &container, &problem), API_OK);
    struct api_reader reader = reader_over(&container);
    assert_int_equal(api_columns_open(&reader, &columns, &problem), API_OK);
    bytes_free(&container);
    return columns.summary;
}

/* ---- parts ---- */

static const char saddle_with[] =
    "\"fabric\":{\"spacing\":0.25,\"thickness\":0.01,\"fiber_volume_fraction\":0.5,"
    "\"locking_angle_deg\":20},\"cavity\":{\"height\":0.012},"
    "\"permeability\":{\"model\":\"gebart\",\"fiber_radius\":1e-5,\"packing\":\"hexagonal\"}";

/* z = (x^2 - y^2) / 2 over [-2, 2]^2. */
static struct bytes saddle(void) {
    struct bytes text = {0};
    bytes_format(&text, "{\"surface\":%s,%s}", request_text("saddle_surface"), saddle_with);
    return text;
}

/* A roof of two plane faces that meet along x = 0, the second with its normal turned. */
static const char roof[] =
    "{\"surface\":{\"faces\":["
    "{\"degree_u\":1,\"degree_v\":1,\"knotvector_u\":[0,0,1,1],\"knotvector_v\":[0,0,1,1],"
    "\"size_u\":2,\"size_v\":2,\"control_points\":[[-1,0,0],[-1,2,0],[0,0,1],[0,2,1]]},"
    "{\"degree_u\":1,\"degree_v\":1,\"knotvector_u\":[0,0,1,1],\"knotvector_v\":[0,0,1,1],"
    "\"size_u\":2,\"size_v\":2,\"control_points\":[[1,0,0],[1,2,0],[0,0,1],[0,2,1]]}]},"
    "\"fabric\":{\"spacing\":0.2}}";

/* z = x y / 2 over [-1, 1] x [0, 1] in two faces, the second with its normal turned, by mosaic. */
static const char twisted[] =
    "{\"method\":\"mosaic\",\"surface\":{\"faces\":["
    "{\"degree_u\":1,\"degree_v\":1,\"knotvector_u\":[0,0,1,1],\"knotvector_v\":[0,0,1,1],"
    "\"size_u\":2,\"size_v\":2,\"control_points\":[[-1,0,0],[-1,1,-0.5],[0,0,0],[0,1,0]]},"
    "{\"degree_u\":1,\"degree_v\":1,\"knotvector_u\":[0,0,1,1],\"knotvector_v\":[0,0,1,1],"
    "\"size_u\":2,\"size_v\":2,\"control_points\":[[1,0,0],[1,1,0.5],[0,0,0],[0,1,0]]}]},"
    "\"fabric\":{\"spacing\":0.2}}";

/* z = (x^2 + y^2) / 2 over [-1, 1]^2. */
static const char bowl[] =
    "{\"surface\":{\"degree_u\":2,\"degree_v\":2,\"knotvector_u\":[0,0,0,1,1,1],"
    "\"knotvector_v\":[0,0,0,1,1,1],\"size_u\":3,\"size_v\":3,\"control_points\":["
    "[-1,-1,1],[-1,0,0],[-1,1,1],[0,-1,0],[0,0,-1],[0,1,0],[1,-1,1],[1,0,0],[1,1,1]]},"
    "\"fabric\":{\"spacing\":0.1}}";

/* z = x y over [0, 1]^2 as triangles. */
static struct bytes mesh_part(void) {
    enum { N = 12 };
    struct bytes text = {0};
    bytes_format(&text, "{\"surface\":{\"vertices\":[");
    for (int k = 0; k < (N + 1) * (N + 1); k++) {
        double x = (double)(k % (N + 1)) / N, y = k / (N + 1) / (double)N;
        bytes_format(&text, "%s[%.17g,%.17g,%.17g]", k ? "," : "", x, y, x * y);
    }
    bytes_format(&text, "],\"triangles\":[");
    for (int k = 0; k < N * N; k++) {
        int a = k / N * (N + 1) + k % N;
        bytes_format(&text, "%s[%d,%d,%d],[%d,%d,%d]", k ? "," : "", a, a + 1, a + N + 2, a,
                     a + N + 2, a + N + 1);
    }
    bytes_format(&text, "]},\"fabric\":{\"spacing\":0.1}}");
    return text;
}

/* ---- tests ---- */

static void check_bits(struct finished *f, size_t row) {
    struct bytes request = request_of(f, row);
    struct api_summary s = summary_of(request.data);
    assert_true(value_at(f, "failure", row) == 0);
    assert_true(value_at(f, "max_shear_deg", row) == s.max_shear_deg);
    if (f->columns.study.objective[QUANTITY_P95_SHEAR])
        assert_true(value_at(f, "p95_shear_deg", row) == s.p95_shear_deg);
    assert_true(value_at(f, "cloth_coverage", row) == s.cloth_coverage);
    bytes_free(&request);
}

static void test_study_variants_have_the_numbers_of_their_drapes(void **state) {
    static const char rest[] = "\"vary\":{\"start\":{\"grid\":7},\"angle_deg\":[0,31,77]},"
                               "\"objectives\":[\"max_shear_deg\",\"p95_shear_deg\"]";
    struct bytes parts[] = {
        saddle(),
        mesh_part(),
        {0},
        {0},
        text_replace(bowl, "{\"spacing\":0.1}", "{\"spacing\":0.2},\"method\":\"mosaic\"")};
    (void)state;
    bytes_format(&parts[2], "%s", roof);
    bytes_format(&parts[3], "%s", twisted);
    for (size_t k = 0; k < sizeof parts / sizeof *parts; k++) {
        struct finished f = finish_study(parts[k].data, rest);
        assert_int_equal(f.rows, 21);
        for (size_t row = 0; row < f.rows; row++)
            check_bits(&f, row);
        free_finished(&f);
        bytes_free(&parts[k]);
    }
}

/* What is not varied stays: a start that the solver chooses, a direction that is a vector. */
static void test_study_keeps_what_it_does_not_vary(void **state) {
    struct bytes part =
        text_replace(roof, "\"fabric\"", "\"start\":{\"face\":1,\"uv\":[0.3,0.4]},\"fabric\"");
    struct finished f =
        finish_study(part.data, "\"vary\":{\"pre_shear_deg\":{\"from\":-20,\"to\":20,\"step\":20}},"
                                "\"objectives\":[\"max_shear_deg\",\"p95_shear_deg\"]");
    (void)state;
    assert_int_equal(f.rows, 3);
    for (size_t row = 0; row < f.rows; row++) {
        check_bits(&f, row);
        assert_true(value_at(&f, "face", row) == 1 && value_at(&f, "start_u", row) == 0.3);
        check_at_most(fabs(value_at(&f, "max_shear_deg", row) - (row == 1 ? 0 : 20)), 0.02);
    }
    assert_int_equal(f.columns.study.best[QUANTITY_MAX_SHEAR], 1);
    free_finished(&f);
    bytes_free(&part);
}

static void check_same_bits(const char *drape, const char *search) {
    struct bytes container[2] = {{0}, {0}}, text = {0};
    size_t first[2];
    bytes_format(&text,
                 "\"vary\":{\"start\":{\"grid\":40},\"angle_deg\":[0,20,40,60]},"
                 "\"search\":\"%s\",\"budget\":160,"
                 "\"objectives\":[\"max_shear_deg\",\"waste_area\"]",
                 search);
    struct bytes study = study_of(drape, text.data);
    for (int k = 0; k < 2; k++) {
        struct api_problem problem;
        struct api_columns columns;
        assert_int_equal(run_study(&study, k ? 5 : 1, &container[k], &problem), API_OK);
        struct api_reader reader = reader_over(&container[k]);
        assert_int_equal(api_columns_open(&reader, &columns, &problem), API_OK);
        first[k] = (size_t)columns.column[0].offset;
    }
    assert_int_equal(container[0].length - first[0], container[1].length - first[1]);
    assert_memory_equal(container[0].data + first[0], container[1].data + first[1],
                        container[0].length - first[0]);
    bytes_free(&container[0]);
    bytes_free(&container[1]);
    bytes_free(&study);
    bytes_free(&text);
}

static void test_study_has_the_same_bits_on_any_threads(void **state) {
    struct bytes part = saddle();
    (void)state;
    check_same_bits(part.data, "grid");
    check_same_bits(part.data, "optimise");
    bytes_free(&part);
}

/* Developable: no shear anywhere, and the flat pattern is the part. */
static void test_study_objectives_of_a_roof_are_exact(void **state) {
    struct bytes part = text_replace(roof, "\"spacing\":0.2",
                                     "\"spacing\":0.2,\"locking_angle_deg\":5,\"thickness\":1,"
                                     "\"fiber_volume_fraction\":0.5");
    struct bytes rigid = text_replace(part.data, "{\"surface\"",
                                      "{\"cavity\":{\"height\":1},"
                                      "\"surface\"");
    const double width = 2 * sqrt(2.0), length = 2, area = width * length;
    struct finished f = finish_study(
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
        check_at_most(fabs(value_at(&f, "max_shear_deg", row)), 1e-9);
        check_at_most(value_at(&f, "locked_area", row), 0);
        check_at_most(value_at(&f, "uncovered_area", row), 1e-12);
        check_at_most(fabs(value_at(&f, "waste_area", row) - (turned ? box - area : 0)),
                      1e-3 * area);
        /* u runs up both faces, across the wanted direction; in cells over the ridge it is bent */
        check_at_most(fabs(value_at(&f, "angle_deviation_deg", row) - (turned ? 60 : 90)), 0.1);
        check_at_most(value_at(&f, "fiber_volume_fraction_range", row), 1e-3);
    }
    free_finished(&f);
    bytes_free(&rigid);
    bytes_free(&part);
}

/* On the saddle draped from its apex |sin gamma| = |x y| / sqrt((1 + x^2)(1 + y^2)); area and
 * shares of it by sums over (x, y). */
static void test_study_objectives_of_a_saddle_are_those_of_the_exact_net(void **state) {
    enum { N = 1500 };
    struct bytes coarse = saddle(), part = text_replace(coarse.data, "0.25", "0.05");
    struct finished f =
        finish_study(part.data, "\"vary\":{\"start\":{\"points\":[[0,0,0]]},\"angle_deg\":[0]},"
                                "\"wanted_direction\":[1,0,0],"
                                "\"objectives\":[\"locked_area\",\"angle_deviation_deg\","
                                "\"fiber_volume_fraction_range\",\"p95_shear_deg\"]");
    double locked = 0, all = 0, turned = 0, degree = acos(-1) / 180;
    (void)state;
    for (int k = 0; k < N * N; k++) {
        double x = 2 * (k % N + 0.5) / N, y = 2 * (k / N + 0.5) / N;
        double own = sqrt(1 + x * x + y * y), sine = x * y / sqrt((1 + x * x) * (1 + y * y));
        locked += asin(sine) > 20 * degree ? own : 0;
        all += own;
        turned += own * acos(own / sqrt((1 + x * x) * (1 + y * y))) / degree;
    }
    double cell = 4.0 * 4.0 / (N * (double)N);
    check_at_most(fabs(value_at(&f, "locked_area", 0) - locked * cell), 1e-3 * all * cell);
    check_at_most(fabs(value_at(&f, "angle_deviation_deg", 0) - turned / all), 0.01);
    double most = 0.5 * 0.01 / 0.012 / cos(asin(0.8)), least = 0.5 * 0.01 / 0.012;
    check_at_most(fabs(value_at(&f, "fiber_volume_fraction_range", 0) - (most - least)), 2e-3);
    free_finished(&f);
    bytes_free(&part);
    bytes_free(&coarse);
}

/* The front by definition, and the best. */
static void test_study_front_is_what_nothing_dominates(void **state) {
    struct bytes part = saddle();
    struct finished f =
        finish_study(part.data, "\"vary\":{\"start\":{\"grid\":30},\"angle_deg\":[0,15,30,45,60]},"
                                "\"limits\":{\"mean_shear_deg\":{\"max\":20}},"
                                "\"wanted_direction\":[1,2,0],"
                                "\"objectives\":[\"p95_shear_deg\",\"angle_deviation_deg\"]");
    static const char *const names[] = {"p95_shear_deg", "angle_deviation_deg"};
    size_t front = 0, feasible = 0;
    (void)state;
    for (size_t a = 0; a < f.rows; a++) {
        bool keeps = value_at(&f, "mean_shear_deg", a) <= 20, beaten = false;
        for (size_t b = 0; b < f.rows && keeps; b++) {
            double d[2];
            for (int k = 0; k < 2; k++)
                d[k] = value_at(&f, names[k], b) - value_at(&f, names[k], a);
            bool other = value_at(&f, "mean_shear_deg", b) <= 20;
            beaten = beaten || (other && d[0] <= 0 && d[1] <= 0 && (d[0] < 0 || d[1] < 0));
        }
        assert_int_equal(value_at(&f, "feasible", a), keeps);
        assert_int_equal(value_at(&f, "pareto", a), keeps && !beaten);
        front += keeps && !beaten;
        feasible += keeps;
    }
    check_above(front, 1);
    check_below(feasible, f.rows);
    assert_int_equal(f.columns.study.pareto, front);
    assert_int_equal(f.columns.study.feasible, feasible);
    assert_int_equal(f.columns.study.hardest, -1);
    free_finished(&f);
    bytes_free(&part);
}

static void test_study_says_which_limit_is_hardest(void **state) {
    struct bytes part = saddle();
    struct finished f = finish_study(
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
        check_at_least(value_at(&f, "max_shear_deg", row), value_at(&f, "max_shear_deg", best));
    free_finished(&f);
    bytes_free(&part);
}

/* The best of nets that are held to a corner of the part, unless the study has a limit for that. */
static void test_study_warns_of_what_is_bare(void **state) {
    static const char *const limits[] = {"", ",\"limits\":{\"cloth_coverage\":{\"min\":0}}"};
    struct bytes whole = saddle();
    struct bytes part = text_replace(whole.data, "\"fabric\"",
                                     "\"extent\":{\"warp\":[0,4],\"weft\":[0,4]},\"fabric\"");
    (void)state;
    for (size_t k = 0; k < 2; k++) {
        char rest[200];
        snprintf(rest, sizeof rest,
                 "\"vary\":{\"angle_deg\":[0,45]},\"objectives\":[\"max_shear_deg\"]%s", limits[k]);
        struct finished f = finish_study(part.data, rest);
        const struct api_warnings *warnings = &f.columns.study.warnings;
        size_t best = (size_t)f.columns.study.best[QUANTITY_MAX_SHEAR];
        check_below(value_at(&f, "cloth_coverage", best), 0.5);
        assert_int_equal(warnings->count, k == 0);
        if (k == 0)
            assert_string_equal(warnings->list[0].code, "uncovered");
        free_finished(&f);
    }
    bytes_free(&part);
    bytes_free(&whole);
}

/* Of two directions that which keeps a limit is the best, though the other has less shear. */
static void test_study_best_keeps_the_limits(void **state) {
    struct bytes part = saddle();
    static const char vary[] = "\"vary\":{\"angle_deg\":[0,45]},\"objectives\":[\"max_shear_deg\"]";
    struct finished f = finish_study(part.data, vary);
    size_t least = (size_t)f.columns.study.best[QUANTITY_MAX_SHEAR];
    char rest[300];
    (void)state;
    check_above(value_at(&f, "max_shear_deg", 1 - least),
                value_at(&f, "max_shear_deg", least) + 0.1);
    for (int lower = 0; lower < 2; lower++) {
        if (lower)
            snprintf(rest, sizeof rest, "%s,\"limits\":{\"max_shear_deg\":{\"min\":%.17g}}", vary,
                     value_at(&f, "max_shear_deg", least) + 0.1);
        else
            snprintf(rest, sizeof rest,
                     "%s,\"wanted_direction\":[1,%d,0],"
                     "\"limits\":{\"angle_deviation_deg\":{\"max\":30}}",
                     vary, least == 0);
        struct finished held = finish_study(part.data, rest);
        assert_int_equal(held.columns.study.best[QUANTITY_MAX_SHEAR], 1 - least);
        assert_int_equal(held.columns.study.feasible, 1);
        assert_true(value_at(&held, "feasible", least) == 0);
        free_finished(&held);
    }
    free_finished(&f);
    bytes_free(&part);
}

static void test_study_goes_on_after_a_variant_that_cannot_be_draped(void **state) {
    struct bytes part = saddle(), document = {0};
    struct finished f =
        finish_study(part.data, "\"vary\":{\"start\":{\"points\":[[0,0,0],[9,9,9],[1,1,0]]}},"
                                "\"objectives\":[\"max_shear_deg\"]");
    struct api_problem problem = {0};
    struct api_reader reader = reader_over(&f.container);
    char buffer[4096];
    ssize_t length;
    (void)state;
    assert_int_equal(f.columns.study.failed, 1);
    assert_int_equal(value_at(&f, "failure", 1), FAILURE_START_OFF_SURFACE);
    assert_non_null(
        strstr(f.columns.study.warnings.list[0].detail, " because of start-off-surface"));
    assert_int_equal(value_at(&f, "feasible", 1), 0);
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
    free_finished(&f);
    bytes_free(&part);
}

/* How many variants the first task of a study of 300 starts has. */
static size_t first_task(const char *drape) {
    struct bytes text =
        study_of(drape, "\"vary\":{\"start\":{\"grid\":300}},\"objectives\":[\"max_shear_deg\"]");
    const struct api_input input = input_of(&text);
    const struct api_study_numbers none = {NULL, 0};
    struct api_problem problem = {0};
    struct api_study_plan plan = {0};
    struct arena *arena = arena_new((size_t)1 << 28);
    prepare();
    struct api_study *study = api_study_open(&input, &api_limits_default, &problem);
    assert_non_null(study);
    assert_int_equal(api_study_plan(study, &none, arena, &plan, &problem), API_OK);
    size_t variants = api_study_task_variants(&plan.tasks[0]);
    api_study_close(study);
    arena_free(arena);
    bytes_free(&text);
    return variants;
}

/* What waits for a task waits about as long whatever its method: the slower ones have fewer
 * variants. */
static void test_study_gives_slow_methods_short_tasks(void **state) {
    struct bytes part = text_replace(bowl, "0.1}", "0.1},\"method\":\"gib\"");
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
    enum { VARIANTS = 300, ROW = 11 + QUANTITY_COUNT };
    static double numbers[VARIANTS * ROW]; /* rows of zeros are sound */
    struct bytes coarse = saddle(), part = text_replace(coarse.data, "0.25", "0.005");
    struct bytes text = study_of(
        part.data, "\"vary\":{\"start\":{\"grid\":300}},\"objectives\":[\"max_shear_deg\"]");
    const struct api_input input = input_of(&text);
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
            done += api_study_task_variants(&plan.tasks[k]);
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
    struct bytes part = saddle(), given[2] = {{0}, {0}};
    struct bytes text = study_of(part.data, "\"vary\":{\"angle_deg\":[0,10,20,30]},"
                                            "\"objectives\":[\"max_shear_deg\"]");
    const struct api_input input = input_of(&text);
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
    assert_int_equal(api_study_task_variants(&plan.tasks[0]), 4);
    for (int k = 0; k < 2; k++) {
        struct api_study_task task = plan.tasks[0];
        const struct api_sink sink = sink_into(&given[k]);
        if (k)
            api_study_task_blame(&task, 2);
        assert_int_equal(api_study_chunk(study, &task, NULL, arena, &sink, &problem), API_OK);
    }
    size_t row = given[0].length / 4;
    assert_int_equal(given[1].length, given[0].length);
    for (size_t k = 0; k < 4; k++)
        assert_int_equal(memcmp(given[0].data + k * row, given[1].data + k * row, row) != 0,
                         k == 2);
    const struct api_study_numbers numbers = {(const double *)(const void *)given[1].data,
                                              given[1].length / sizeof(double)};
    struct finished f = {.rows = 4};
    const struct api_sink sink = sink_into(&f.container);
    assert_int_equal(api_study_finish(study, &numbers, 0, arena, &sink, &problem), API_OK);
    struct api_reader reader = reader_over(&f.container);
    assert_int_equal(api_columns_open(&reader, &f.columns, &problem), API_OK);
    assert_int_equal(value_at(&f, "failure", 2), FAILURE_CRASHED);
    assert_int_equal(f.columns.study.failed, 1);
    arena_free(arena);
    api_study_close(study);
    free_finished(&f);
    bytes_free(&given[0]);
    bytes_free(&given[1]);
    bytes_free(&text);
    bytes_free(&part);
}

/* ---- optimise ---- */

static double best_value(struct finished *f, enum quantity_id id) {
    assert_true(f->columns.study.best[id] >= 0);
    return value_at(f, quantities[id].name, (size_t)f->columns.study.best[id]);
}

/* With a part of the drapes it finds what a grid finds, or better, and keeps its budget. */
static void test_optimise_beats_a_grid(void **state) {
    static const char vary[] = "\"vary\":{\"start\":{\"grid\":60},\"angle_deg\":{\"from\":0,"
                               "\"to\":75,\"step\":15}},\"objectives\":[\"max_shear_deg\"]";
    char rest[300];
    struct bytes parts[] = {text_replace(bowl, "0.1", "0.08"), mesh_part()};
    (void)state;
    for (int k = 0; k < 2; k += check_stride(2)) {
        struct finished grid = finish_study(parts[k].data, vary);
        snprintf(rest, sizeof rest, "%s,\"search\":\"optimise\",\"budget\":180", vary);
        struct finished best = finish_study(parts[k].data, rest);
        check_at_most(best.rows, 180);
        check_at_most(best_value(&best, QUANTITY_MAX_SHEAR),
                      best_value(&grid, QUANTITY_MAX_SHEAR) + 1e-9);
        check_bits(&best, (size_t)best.columns.study.best[QUANTITY_MAX_SHEAR]);
        free_finished(&grid);
        free_finished(&best);
    }
    bytes_free(&parts[0]);
    bytes_free(&parts[1]);
}

/* On z = (x^2 + y^2) / 2 over a square it finds its apex, from where the net is that of a
 * translation surface: sin gamma = x y / sqrt((1 + x^2)(1 + y^2)), 30 degrees in the corners (1,
 * 1). */
static void test_optimise_finds_the_apex_of_a_bowl(void **state) {
    struct finished f =
        finish_study(bowl, "\"vary\":{\"start\":{\"grid\":9}},\"search\":\"optimise\","
                           "\"budget\":150,\"objectives\":[\"max_shear_deg\"]");
    (void)state;
    size_t best = (size_t)f.columns.study.best[QUANTITY_MAX_SHEAR];
    check_at_most(fabs(value_at(&f, "x", best)), 0.01);
    check_at_most(fabs(value_at(&f, "y", best)), 0.01);
    check_at_most(fabs(value_at(&f, "max_shear_deg", best) - 30), 0.3);
    free_finished(&f);
}

/* On a roof, whose faces have their normals to different sides, the net is that of a plane: the cut
 * is a rectangle, without waste, where the yarns run along the edges, wherever it starts. */
static void test_optimise_goes_over_the_faces_of_a_shell(void **state) {
    struct finished f = finish_study(
        roof, "\"vary\":{\"start\":{\"grid\":9},\"angle_deg\":{\"from\":0,\"to\":80,\"step\":10}},"
              "\"search\":\"optimise\",\"budget\":120,\"objectives\":[\"waste_area\"]");
    (void)state;
    check_at_most(best_value(&f, QUANTITY_WASTE_AREA), 0.005);
    free_finished(&f);
}

/* Half a sphere whose parameters end in its pole, from where the net is the most even: the search
 * ends there, and goes on where there is no tangent plane to look about in. */
#define W "0.70710678118654752"
static void test_optimise_ends_in_a_pole(void **state) {
    static const char half[] =
        "{\"surface\":{\"degree_u\":2,\"degree_v\":2,\"size_u\":9,\"size_v\":3,"
        "\"knotvector_u\":[0,0,0,1,1,2,2,3,3,4,4,4],\"knotvector_v\":[0,0,0,1,1,1],"
        "\"control_points\":{\"points\":[[1,0,0],[1,0,1],[0,0,1],[1,1,0],[1,1,1],[0,0,1],[0,1,0],"
        "[0,1,1],[0,0,1],[-1,1,0],[-1,1,1],[0,0,1],[-1,0,0],[-1,0,1],[0,0,1],[-1,-1,0],[-1,-1,1],"
        "[0,0,1],[0,-1,0],[0,-1,1],[0,0,1],[1,-1,0],[1,-1,1],[0,0,1],[1,0,0],[1,0,1],[0,0,1]],"
        "\"weights\":[1," W ",1," W ",0.5," W ",1," W ",1," W ",0.5," W ",1," W ",1," W ",0.5," W
        ",1," W ",1," W ",0.5," W ",1," W ",1]}},"
        "\"fabric\":{\"spacing\":0.12}}";
    struct finished f = finish_study(
        half, "\"vary\":{\"start\":{\"grid\":9},\"angle_deg\":{\"from\":0,\"to\":80,\"step\":10}},"
              "\"search\":\"optimise\",\"budget\":120,\"objectives\":[\"max_shear_deg\"]");
    size_t best = (size_t)f.columns.study.best[QUANTITY_MAX_SHEAR];
    (void)state;
    check_at_least(f.rows, 110);
    check_at_least(value_at(&f, "z", best), 0.99);
    free_finished(&f);
}

/* A limit that the best without it breaks holds at what comes out, and is all but reached; once the
 * search knows the part most of what it looks at keeps it. */
static void test_optimise_keeps_limits(void **state) {
    char rest[500];
    struct bytes part = mesh_part();
    double limit = 90, deviation = 0;
    (void)state;
    for (int k = 0; k < 2; k++) {
        snprintf(
            rest, sizeof rest,
            "\"vary\":{\"start\":{\"grid\":9},\"angle_deg\":{\"from\":0,\"to\":170,\"step\":10}},"
            "\"wanted_direction\":[3,1,0],\"search\":\"optimise\",\"budget\":240,"
            "\"objectives\":[\"max_shear_deg\"],"
            "\"limits\":{\"angle_deviation_deg\":{\"max\":%.17g}}",
            limit);
        struct finished f = finish_study(part.data, rest);
        size_t best = (size_t)f.columns.study.best[QUANTITY_MAX_SHEAR];
        deviation = value_at(&f, "angle_deviation_deg", best);
        assert_true(value_at(&f, "feasible", best) == 1);
        check_at_most(deviation, limit);
        size_t kept = 0;
        for (size_t row = f.rows / 2; row < f.rows; row++)
            kept += value_at(&f, "feasible", row) > 0;
        check_at_least((double)kept, 0.7 * (double)(f.rows - f.rows / 2));
        if (k == 1)
            check_at_least(deviation, 0.7 * limit);
        limit = 0.5 * deviation;
        free_finished(&f);
    }
    bytes_free(&part);
}

/* Two objectives: the ends of the front are as good as each search alone, and there is more between
 * them than the first round found. */
static void test_optimise_spreads_a_front(void **state) {
    struct bytes part = mesh_part();
    struct finished f = finish_study(
        part.data,
        "\"vary\":{\"start\":{\"grid\":9},\"angle_deg\":{\"from\":0,\"to\":170,\"step\":10}},"
        "\"wanted_direction\":[1,1,0],\"search\":\"optimise\",\"budget\":300,"
        "\"objectives\":[\"p95_shear_deg\",\"angle_deviation_deg\"]");
    size_t refined = 0;
    (void)state;
    for (size_t k = 150; k < f.rows; k++)
        refined += value_at(&f, "pareto", k) > 0;
    check_at_least(f.columns.study.pareto, 8);
    check_at_least((double)refined, 0.4 * (double)f.columns.study.pareto);
    free_finished(&f);
    bytes_free(&part);
}

/* A net of many nodes is searched on a coarser one, and what is best was draped as asked. */
static void test_optimise_of_a_fine_net_ends_on_it(void **state) {
    struct bytes coarse = saddle(), part = text_replace(coarse.data, "0.25", "0.06");
    struct finished f = finish_study(
        part.data, "\"vary\":{\"start\":{\"grid\":9}},\"search\":\"optimise\",\"budget\":40,"
                   "\"objectives\":[\"max_shear_deg\"]");
    size_t best = (size_t)f.columns.study.best[QUANTITY_MAX_SHEAR];
    (void)state;
    check_above(f.columns.study.coarse, 10);
    check_below(f.columns.study.coarse, f.rows);
    assert_true(value_at(&f, "coarseness", best) == 1);
    check_above(value_at(&f, "coarseness", 0), 1.3);
    check_bits(&f, best);
    check_bits(&f, 0);
    free_finished(&f);
    bytes_free(&part);
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
    struct bytes part = text_replace(bowl, "0.1}", "0.1,\"locking_angle_deg\":15}");
    (void)state;
    bytes_format(&rest, "\"objectives\":[\"max_shear_deg\",\"p95_shear_deg\",\"locked_area\","
                        "\"uncovered_area\",\"waste_area\",\"angle_deviation_deg\"],"
                        "\"wanted_direction\":[1,0.3,0],\"vary\":{\"angle_deg\":[17],"
                        "\"start\":{\"points\":[");
    for (int k = 0; k <= STEPS; k++)
        bytes_format(&rest, "%s{\"uv\":[%.17g,0.55]}", k ? "," : "", 0.55 + 0.0005 * k);
    bytes_format(&rest, "]}}");
    struct finished f = finish_study(part.data, rest.data);
    for (size_t q = 0; q < sizeof names / sizeof *names; q++) {
        double sum = 0, low = HUGE_VAL, high = -HUGE_VAL;
        for (size_t k = 0; k < f.rows; k++) {
            double value = value_at(&f, names[q], k);
            double step = k ? fabs(value - value_at(&f, names[q], k - 1)) : 0;
            if (step > most[q])
                fail_msg("%s steps by %g at %zu", names[q], step, k);
            sum += step;
            low = fmin(low, value);
            high = fmax(high, value);
        }
        if (sum > 3 * (high - low) + 10 * most[q])
            fail_msg("%s goes %g to and fro within %g", names[q], sum, high - low);
    }
    free_finished(&f);
    bytes_free(&rest);
    bytes_free(&part);
}

/* ---- samples ---- */

#define TOLERANCES                                                                                 \
    "\"vary\":{\"start\":{\"radius\":0.2},\"angle_deg\":{\"normal\":3}},\"sample\":%d,\"seed\":%d"

static struct finished draw_samples(const char *drape, int count, int seed) {
    char rest[200];
    snprintf(rest, sizeof rest, TOLERANCES, count, seed);
    return finish_study(drape, rest);
}

static double band_at(struct finished *f, const char *name, size_t row) {
    struct api_reader reader = reader_over(&f->container);
    const struct api_column *column = api_columns_find(&f->columns, API_TABLE_BANDS, name);
    double value;
    if (!column)
        fail_msg("no column %s", name);
    assert_true(api_columns_read(&reader, column, row, 1, &value));
    return value;
}

static const char plate[] =
    "{\"surface\":{\"degree_u\":1,\"degree_v\":1,\"knotvector_u\":[0,0,1,1],"
    "\"knotvector_v\":[0,0,1,1],\"size_u\":2,\"size_v\":2,"
    "\"control_points\":[[-1,-1,0],[-1,1,0],[1,-1,0],[1,1,0]]},\"fabric\":{\"spacing\":0.5},"
    "\"direction\":{\"angle_deg\":40}}";

/* Starts within the radius, evenly: half of them within r / sqrt 2; angles normal, 68.3 % of them
 * within one deviation. */
static void test_samples_are_drawn_as_asked(void **state) {
    enum { COUNT = 800 };
    struct finished f = draw_samples(plate, COUNT, 5);
    int near = 0, within = 0, right = 0;
    double sum = 0;
    (void)state;
    assert_int_equal(f.rows, COUNT);
    for (size_t k = 0; k < f.rows; k++) {
        double x = value_at(&f, "x", k), y = value_at(&f, "y", k);
        double turn = value_at(&f, "angle_deg", k) - 40;
        check_at_most(hypot(x, y), 0.2 + 1e-12);
        near += hypot(x, y) < 0.2 / sqrt(2);
        right += x > 0;
        within += fabs(turn) < 3;
        sum += turn;
    }
    check_at_most(fabs(near / (double)COUNT - 0.5), 0.06);
    check_at_most(fabs(right / (double)COUNT - 0.5), 0.06);
    check_at_most(fabs(within / (double)COUNT - 0.683), 0.06);
    check_at_most(fabs(sum / COUNT), 3 * 3 / sqrt(COUNT));
    for (size_t cell = 0; cell < api_columns_rows(&f.columns, API_TABLE_BANDS); cell++) {
        check_at_most(fabs(band_at(&f, "shear_deg_p95", cell)), 1e-9);
        check_at_most(band_at(&f, "warp_x_p05", cell), band_at(&f, "warp_x_mean", cell));
        check_at_most(fabs(band_at(&f, "warp_x_mean", cell) - cos(40 * acos(-1) / 180)), 0.01);
    }
    free_finished(&f);
}

/* Of a plate the turn of the warp is that of its sample, a normal deviate of 3 degrees: how much of
 * its distribution lies within the band is exact, and nine tenths on the mean however few there
 * are. */
static void test_bands_of_few_samples_are_wide_enough(void **state) {
    enum { COUNT = 30 };
    const int seeds = check_sized(60, 30);
    double sum = 0;
    (void)state;
    for (int seed = 1; seed <= seeds; seed++) {
        struct finished f = draw_samples(plate, COUNT, seed);
        for (int side = 0; side < 2; side++) {
            double sine = band_at(&f, side ? "warp_y_p95" : "warp_y_p05", 0);
            double turn = asin(sine) * 180 / acos(-1) - 40;
            sum += (side ? 0.5 : -0.5) * erf(turn / (3 * sqrt(2)));
        }
        free_finished(&f);
    }
    check_at_most(fabs(sum / seeds - 0.9), 0.02);
}

/* Bands of some samples hold nine in ten of others, over all cells. */
static void test_bands_hold_nine_tenths_of_fresh_samples(void **state) {
    enum { COUNT = 250 };
    const int others = check_sized(100, 40);
    struct bytes part = saddle();
    struct finished bands = draw_samples(part.data, COUNT, 1);
    struct finished fresh = draw_samples(part.data, others, 2);
    size_t cells = api_columns_rows(&bands.columns, API_TABLE_BANDS), inside = 0, all = 0;
    (void)state;
    check_above(cells, 100);
    for (size_t k = 0; k < (size_t)others; k++) {
        struct bytes request = request_of(&fresh, k), container = {0};
        struct api_problem problem = {0};
        struct arena *arena = arena_new((size_t)1 << 30);
        struct vec3 *points = arena_alloc(arena, cells, sizeof *points);
        struct api_map *map = arena_alloc(arena, 1, sizeof *map);
        for (size_t c = 0; c < cells; c++)
            points[c] = vec3_make(band_at(&bands, "x", c), band_at(&bands, "y", c),
                                  band_at(&bands, "z", c));
        const struct map_target target = {
            .vertices = points, .vertex_count = cells, .element_count = cells};
        assert_int_equal(run_text(request.data, &container, &problem), API_OK);
        struct api_reader reader = reader_over(&container);
        assert_int_equal(api_map_make(&reader, &target, NULL, arena, map, &problem), API_OK);
        for (size_t m = 0; m < map->fields.column_count; m++) {
            double value;
            if (strcmp(map->columns[m].name, "shear_deg") != 0)
                continue;
            for (size_t c = 0; c < cells; c++, all++) {
                map->columns[m].fill(map->columns[m].context, c, 1, &value);
                inside += value >= band_at(&bands, "shear_deg_p05", c) &&
                          value <= band_at(&bands, "shear_deg_p95", c);
            }
        }
        bytes_free(&request);
        bytes_free(&container);
        arena_free(arena);
    }
    printf("  bands hold %.2f %% of fresh samples\n", 100 * (double)inside / (double)all);
    check_at_most(fabs((double)inside / (double)all - 0.9), 0.02);
    free_finished(&bands);
    free_finished(&fresh);
    bytes_free(&part);
}

static void test_samples_have_the_same_bits_from_any_tasks(void **state) {
    struct bytes part = saddle(), container[2] = {{0}, {0}};
    char rest[200];
    size_t first[2];
    (void)state;
    snprintf(rest, sizeof rest, TOLERANCES, 40, 3);
    struct bytes text = study_of(part.data, rest);
    for (int k = 0; k < 2; k++) {
        struct api_problem problem;
        struct api_columns columns;
        assert_int_equal(run_study(&text, k ? 3 : 1, &container[k], &problem), API_OK);
        struct api_reader reader = reader_over(&container[k]);
        assert_int_equal(api_columns_open(&reader, &columns, &problem), API_OK);
        first[k] = (size_t)columns.column[0].offset;
    }
    assert_int_equal(container[0].length - first[0], container[1].length - first[1]);
    assert_memory_equal(container[0].data + first[0], container[1].data + first[1],
                        container[0].length - first[0]);
    bytes_free(&container[0]);
    bytes_free(&container[1]);
    bytes_free(&text);
    bytes_free(&part);
}

/* ---- what is refused ---- */

/* That there is a problem at the pointer, whose words end with `end`. */
static void check_refused_by(const char *rest, const char *pointer, const char *end) {
    struct bytes part = saddle(), text = study_of(part.data, rest);
    const struct api_input input = input_of(&text);
    struct api_problem problem = {0};
    struct api_check check;
    prepare();
    assert_int_equal(api_check_study(&input, &api_limits_default, &check, &problem),
                     API_INVALID_REQUEST);
    for (size_t k = 0; k < problem.count; k++)
        if (strcmp(problem.place[k].pointer, pointer) == 0) {
            const char *detail = problem.place[k].detail;
            check_at_least((double)strlen(detail), (double)strlen(end));
            assert_string_equal(detail + strlen(detail) - strlen(end), end);
            bytes_free(&text);
            bytes_free(&part);
            return;
        }
    fail_msg("%s: the problem is at %s: %s", rest, problem.place[0].pointer,
             problem.place[0].detail);
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
    };
    (void)state;
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++)
        check_refused(cases[k][0], cases[k][1]);
    check_refused_by("\"vary\":{\"angle_deg\":[0]},\"objectives\":[\"beauty\"]", "/objectives/0",
                     " or \"k1_ratio_p95\"");
}

static void check_drape_refused(const char *drape, const char *rest, const char *pointer) {
    struct bytes text = study_of(drape, rest);
    const struct api_input input = input_of(&text);
    struct api_problem problem = {0};
    struct api_check check;
    prepare();
    assert_int_not_equal(api_check_study(&input, &api_limits_default, &check, &problem), API_OK);
    assert_string_equal(problem.place[0].pointer, pointer);
    bytes_free(&text);
}

static void test_study_refuses_what_its_drape_lacks(void **state) {
    static const char vary[] = "\"vary\":{\"angle_deg\":[0]},\"objectives\":[\"";
    static const char *const cases[][2] = {
        {"locked_area", "/drape/fabric/locking_angle_deg"},
        {"k1_ratio_p95", "/drape/permeability"},
        {"fiber_volume_fraction_range", "/drape/fabric/fiber_volume_fraction"}};
    (void)state;
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        char rest[200];
        snprintf(rest, sizeof rest, "%s%s\"]", vary, cases[k][0]);
        check_drape_refused(roof, rest, cases[k][1]);
    }
    struct bytes fine = text_replace(roof, "0.2", "1e-7");
    check_drape_refused(fine.data, "\"vary\":{\"angle_deg\":[0]}," MAX, "/drape/fabric/spacing");
    bytes_free(&fine);
    struct bytes plane = text_replace(roof, "\"fabric\"",
                                      "\"generators\":{\"warp\":{\"plane\":[1,0,0]}},\"fabric\"");
    check_drape_refused(plane.data, "\"vary\":{\"angle_deg\":[0]}," MAX, "/drape/generators/warp");
    bytes_free(&plane);
}

/* What the last step could not hold is refused by the first. */
static void test_samples_beyond_memory_are_refused(void **state) {
    struct bytes part = saddle();
    struct bytes text =
        study_of(part.data, "\"vary\":{\"angle_deg\":{\"normal\":1}},\"sample\":5000");
    const struct api_input input = input_of(&text);
    struct api_limits limits = api_limits_default;
    struct api_problem problem = {0};
    (void)state;
    prepare();
    limits.max_memory = (size_t)64 << 20;
    assert_null(api_study_open(&input, &limits, &problem));
    assert_int_equal(problem.id, API_TOO_LARGE);
    assert_string_equal(problem.place[0].pointer, "/sample");
    problem = (struct api_problem){0};
    struct api_study *study = api_study_open(&input, &api_limits_default, &problem);
    assert_non_null(study);
    api_study_close(study);
    bytes_free(&text);
    bytes_free(&part);
}

static void test_study_is_known_by_its_drape(void **state) {
    struct bytes part = saddle(), text = study_of(part.data, MAX);
    (void)state;
    prepare();
    assert_true(api_is_study(text.data, text.length, &api_limits_default));
    assert_false(api_is_study(part.data, part.length, &api_limits_default));
    assert_false(api_is_study("[", 1, &api_limits_default));
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
    struct bytes part = saddle();
    struct api_check check[COUNT];
    (void)state;
    prepare();
    for (int k = 0; k < COUNT; k++) {
        struct bytes text = study_of(part.data, rests[k]);
        const struct api_input input = input_of(&text);
        struct api_problem problem = {0};
        assert_int_equal(api_check_study(&input, &api_limits_default, &check[k], &problem), API_OK);
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
    struct bytes part = saddle();
    (void)state;
    prepare();
    for (size_t k = 0; k < sizeof rests / sizeof *rests; k++) {
        struct bytes text[2] = {study_of(part.data, rests[k]), {0}};
        struct api_check check[2];
        struct api_problem problem = {0};
        struct api_input input = input_of(&text[0]);
        const struct api_sink sink = sink_into(&text[1]);
        assert_int_equal(api_study_normalise(&input, &api_limits_default, &sink, &problem), API_OK);
        for (int i = 0; i < 2; i++) {
            input = input_of(&text[i]);
            assert_int_equal(api_check_study(&input, &api_limits_default, &check[i], &problem),
                             API_OK);
        }
        assert_string_equal(check[0].digest, check[1].digest);
        bytes_free(&text[0]);
        bytes_free(&text[1]);
    }
    bytes_free(&part);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_study_variants_have_the_numbers_of_their_drapes),
        cmocka_unit_test(test_study_keeps_what_it_does_not_vary),
        cmocka_unit_test(test_study_has_the_same_bits_on_any_threads),
        cmocka_unit_test(test_study_objectives_of_a_roof_are_exact),
        cmocka_unit_test(test_study_objectives_of_a_saddle_are_those_of_the_exact_net),
        cmocka_unit_test(test_study_front_is_what_nothing_dominates),
        cmocka_unit_test(test_study_says_which_limit_is_hardest),
        cmocka_unit_test(test_study_warns_of_what_is_bare),
        cmocka_unit_test(test_study_best_keeps_the_limits),
        cmocka_unit_test(test_study_goes_on_after_a_variant_that_cannot_be_draped),
        cmocka_unit_test(test_study_gives_slow_methods_short_tasks),
        cmocka_unit_test(test_study_does_large_grids_in_rounds),
        cmocka_unit_test(test_study_marks_variants_that_crash),
        cmocka_unit_test(test_optimise_beats_a_grid),
        cmocka_unit_test(test_optimise_finds_the_apex_of_a_bowl),
        cmocka_unit_test(test_optimise_goes_over_the_faces_of_a_shell),
        cmocka_unit_test(test_optimise_ends_in_a_pole),
        cmocka_unit_test(test_optimise_keeps_limits),
        cmocka_unit_test(test_optimise_spreads_a_front),
        cmocka_unit_test(test_optimise_of_a_fine_net_ends_on_it),
        cmocka_unit_test(test_study_quantities_do_not_jump),
        cmocka_unit_test(test_samples_are_drawn_as_asked),
        cmocka_unit_test(test_bands_of_few_samples_are_wide_enough),
        cmocka_unit_test(test_bands_hold_nine_tenths_of_fresh_samples),
        cmocka_unit_test(test_samples_have_the_same_bits_from_any_tasks),
        cmocka_unit_test(test_study_refuses_by_pointer),
        cmocka_unit_test(test_study_refuses_what_its_drape_lacks),
        cmocka_unit_test(test_samples_beyond_memory_are_refused),
        cmocka_unit_test(test_study_is_known_by_its_drape),
        cmocka_unit_test(test_study_digest_is_of_the_content),
        cmocka_unit_test(test_study_as_understood_is_the_same_study),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
