/* SPDX-License-Identifier: MIT */
#include "api/run.h"

#include "api/request/decode.h"
#include "api/request/prepared_part.h"
#include "support.h"
#include "tests/check.h"
#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

static enum api_problem_id run_replaced(const char *what, const char *with,
                                        struct api_problem *problem) {
    struct bytes text = text_replace(request_text("saddle"), what, with), container = {0};
    enum api_problem_id id = run_text(text.data, &container, problem);
    bytes_free(&text);
    bytes_free(&container);
    return id;
}

static void assert_problem(const struct api_problem *problem, enum api_problem_id id,
                           const char *pointer) {
    assert_string_equal(api_problem_slug(problem->id), api_problem_slug(id));
    assert_string_equal(problem->error[0].pointer, pointer);
}

static void test_run_gives_a_container(void **state) {
    (void)state;
    struct bytes container = {0};
    struct api_problem problem;
    struct api_columns columns;
    assert_int_equal(run_text(request_text("saddle"), &container, &problem), API_OK);
    struct api_reader reader = reader_over(&container);
    assert_int_equal(api_columns_open(&reader, &columns, &problem), API_OK);
    assert_int_equal(columns.length, container.length);
    assert_string_equal(columns.summary.solver_version, DRAPE_VERSION);
    assert_int_equal(columns.summary.nodes, api_columns_rows(&columns, API_TABLE_NODES));
    assert_true(columns.grid.spacing[0] == 0.5 && columns.grid.warp[0] < 0);
    check_above(columns.summary.coverage, 0.5);
    check_at_most(columns.summary.coverage, 1);
    bytes_free(&container);
}

/* A sheet less a column at each end, where the extent ends, and one of two that a neck joins: both
 * are partial, though little is missing of the one, and nothing but boundaries stopped the other.
 */
static void test_run_of_a_part_is_partial(void **state) {
    (void)state;
    static const struct {
        const char *request;
        size_t extent_ends;
    } cases[] = {{"sheet_in_extent", 34}, {"sheets_with_a_neck", 0}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        struct bytes container = {0};
        struct api_problem problem;
        struct api_columns columns;
        assert_int_equal(run_text(request_text(cases[k].request), &container, &problem), API_OK);
        struct api_reader reader = reader_over(&container);
        assert_int_equal(api_columns_open(&reader, &columns, &problem), API_OK);
        assert_int_equal(columns.summary.outcome, DRAPE_PARTIAL);
        assert_int_equal(columns.summary.front_reasons[DRAPE_REASON_EXTENT], cases[k].extent_ends);
        assert_int_equal(columns.summary.front_reasons[DRAPE_REASON_COLLAPSED], 0);
        bytes_free(&container);
    }
}

/* All but the time it took. */
static void test_run_gives_the_same_bytes_again(void **state) {
    (void)state;
    struct bytes container[2] = {{0}, {0}};
    size_t start[2];
    for (int k = 0; k < 2; k++) {
        struct api_problem problem;
        struct api_columns columns;
        assert_int_equal(run_text(request_text("saddle"), &container[k], &problem), API_OK);
        struct api_reader reader = reader_over(&container[k]);
        assert_int_equal(api_columns_open(&reader, &columns, &problem), API_OK);
        start[k] = (size_t)columns.column[0].offset;
    }
    assert_int_equal(container[0].length - start[0], container[1].length - start[1]);
    assert_memory_equal(container[0].data + start[0], container[1].data + start[1],
                        container[0].length - start[0]);
    bytes_free(&container[0]);
    bytes_free(&container[1]);
}

static void test_run_refuses_a_surface_that_is_not_there(void **state) {
    (void)state;
    struct api_problem problem;
    struct bytes container = {0};
    run_text(
        "{\"surface\":{\"id\":\"0123456789abcdef0123456789abcdef\"},\"fabric\":{\"spacing\":1}}",
        &container, &problem);
    assert_problem(&problem, API_INVALID_REQUEST, "/surface/id");
    bytes_free(&container);
}

static void test_run_refuses_a_start_off_the_surface(void **state) {
    (void)state;
    struct api_problem problem;
    run_replaced("{\"surface\"", "{\"start\":{\"point\":[0,0,9]},\"surface\"", &problem);
    assert_problem(&problem, API_START_OFF_SURFACE, "/start");
    assert_non_null(strstr(problem.error[0].detail, " m away from (")); /* and the nearest point */
    run_replaced("{\"surface\"", "{\"start\":{\"point\":[0,0,0.4]},\"surface\"", &problem);
    assert_int_equal(problem.id, API_OK);
}

static void test_run_refuses_a_direction_across_the_surface(void **state) {
    (void)state;
    struct api_problem problem;
    run_replaced("{\"surface\"",
                 "{\"start\":{\"uv\":[0.5,0.5]},\"direction\":{\"vector\":[0,0,1]},\"surface\"",
                 &problem);
    assert_problem(&problem, API_INVALID_REQUEST, "/direction/vector");
}

static void test_run_refuses_generators_that_make_no_net(void **state) {
    (void)state;
    static const struct {
        const char *generators, *pointer;
    } cases[] = {
        {"\"warp\":{\"uv\":[[0,0.2],[1,0.2]]}", "/generators/warp"},
        {"\"weft\":{\"uv\":[[0.5,0.6],[0.5,1]]}", "/generators/weft"},
        {"\"warp\":{\"plane\":[0,0,1]}", "/generators/warp"},
        {"\"warp\":{\"plane\":[0,1,0]},\"weft\":{\"plane\":[0,-2,0]}", "/generators/weft"}};
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        struct api_problem problem;
        struct bytes with = {0};
        bytes_format(&with, "{\"start\":{\"uv\":[0.5,0.5]},\"generators\":{%s},\"surface\"",
                     cases[k].generators);
        run_replaced("{\"surface\"", with.data, &problem);
        assert_problem(&problem, API_INVALID_REQUEST, cases[k].pointer);
        bytes_free(&with);
    }
}

static void test_run_refuses_a_surface_without_area(void **state) {
    (void)state;
    struct api_problem problem;
    run_replaced(
        "[[-2,-2,0],[-2,0,4],[-2,2,0],[0,-2,-4],[0,0,0],[0,2,-4],[2,-2,0],[2,0,4],[2,2,0]]",
        "[[0,0,0],[1,0,0],[2,0,0],[0,0,0],[1,0,0],[2,0,0],[0,0,0],[1,0,0],[2,0,0]]", &problem);
    assert_problem(&problem, API_DEGENERATE_SURFACE, "/surface");
}

static void test_run_refuses_more_nodes_than_allowed(void **state) {
    (void)state;
    struct api_problem problem;
    run_replaced("0.5", "1e-4", &problem);
    assert_problem(&problem, API_INVALID_REQUEST, "/fabric/spacing");
    run_replaced("0.5}", "1e-4},\"extent\":{\"warp\":[0,1],\"weft\":[0,1]}", &problem);
    assert_int_equal(problem.id, API_OK);
}

/* An extent in one direction makes a strip, of fewer nodes than the area would take. */
static void test_run_allows_a_fine_strip(void **state) {
    (void)state;
    struct api_problem problem;
    run_replaced("0.5}", "1e-3},\"extent\":{\"weft\":[0,1]}", &problem);
    assert_int_equal(problem.id, API_OK);
}

static void test_run_stops_when_the_net_outgrows_the_limit(void **state) {
    (void)state;
    struct api_limits limits = api_limits_default;
    const struct api_input input = {.request = request_text("saddle"),
                                    .request_length = strlen(request_text("saddle"))};
    struct api_problem problem = {0};
    struct bytes container = {0};
    struct api_sink sink = sink_into(&container);
    limits.max_nodes = 120; /* the area divided by that of a cell is 119.1, the net has 121 */
    assert_int_equal(api_run(&input, &limits, NULL, &sink, &problem), API_INVALID_REQUEST);
    assert_problem(&problem, API_INVALID_REQUEST, "/fabric/spacing");
    bytes_free(&container);
}

struct watch {
    int calls, stop_at;
    double last;
    bool in_order;
};

static bool watch_progress(void *context, double fraction) {
    struct watch *watch = context;
    watch->in_order = watch->in_order && fraction >= watch->last && fraction >= 0 && fraction <= 1;
    watch->last = fraction;
    return ++watch->calls != watch->stop_at;
}

static enum api_problem_id run_watched(struct watch *watch) {
    struct bytes text = text_replace(request_text("saddle"), "0.5}", "0.02}"), container = {0};
    const struct api_input input = {.request = text.data, .request_length = text.length};
    struct api_problem problem = {0};
    struct api_sink sink = sink_into(&container);
    const struct drape_monitor monitor = {watch_progress, watch};
    watch->in_order = true;
    enum api_problem_id id = api_run(&input, &api_limits_default, &monitor, &sink, &problem);
    bytes_free(&text);
    bytes_free(&container);
    return id;
}

static void test_run_reports_progress(void **state) {
    (void)state;
    struct watch watch = {0};
    assert_int_equal(run_watched(&watch), API_OK);
    assert_true(watch.in_order);
    assert_in_range(watch.calls, 10, 1000);
}

static void test_run_stops_when_the_monitor_says_so(void **state) {
    (void)state;
    struct watch watch = {.stop_at = 5};
    assert_int_equal(run_watched(&watch), API_CANCELLED);
    assert_int_equal(watch.calls, 5);
}

static bool refuse(void *context, const void *bytes, size_t length) {
    (void)context;
    (void)bytes;
    (void)length;
    return false;
}

static void test_run_stops_when_the_sink_refuses(void **state) {
    (void)state;
    const struct api_input input = {.request = request_text("saddle"),
                                    .request_length = strlen(request_text("saddle"))};
    const struct api_sink sink = {.write = refuse, .context = NULL};
    struct api_problem problem = {0};
    assert_int_equal(api_run(&input, &api_limits_default, NULL, &sink, &problem), API_CANCELLED);
}

static void test_run_describes_a_surface(void **state) {
    (void)state;
    struct arena *arena = arena_new((size_t)1 << 24);
    struct api_request request;
    struct api_problem problem;
    double area;
    int degree, size;
    assert_int_equal(decode_text(request_text("saddle"), arena, &request, &problem), API_OK);
    const char *text = describe_text(&request.surface, arena, &problem);
    assert_non_null(text);
    json_t *json = json_loads(text, 0, NULL);
    assert_int_equal(
        json_unpack(json, "{s:F,s:i,s:i}", "area", &area, "degree_u", &degree, "size_v", &size), 0);
    /* int int sqrt(1 + x^2 + y^2) over [-2, 2]^2 */
    assert_true(fabs(area - 29.7850269) < 1e-6 && degree == 2 && size == 3);
    assert_int_equal(json_array_size(json_object_get(json, "bounding_box")), 2);
    assert_int_equal(strlen(json_string_value(json_object_get(json, "id"))), API_ID_LENGTH);
    assert_true(json_is_false(json_object_get(json, "closed_u")));
    json_decref(json);
    arena_free(arena);
}

/* The pointer is one into the document that was posted: the surface alone. */
static void test_run_describes_no_surface_without_area(void **state) {
    (void)state;
    static const char flat[] = "{\"degree_u\":1,\"degree_v\":1,\"size_u\":2,\"size_v\":2,"
                               "\"knotvector_u\":[0,0,1,1],\"knotvector_v\":[0,0,1,1],"
                               "\"control_points\":[[0,0,0],[0,0,0],[1,0,0],[1,0,0]]}";
    struct arena *arena = arena_new((size_t)1 << 24);
    struct api_surface surface;
    struct api_problem problem = {0};
    assert_int_equal(
        api_decode_surface(flat, strlen(flat), &api_limits_default, arena, &surface, &problem),
        API_OK);
    assert_null(describe_text(&surface, arena, &problem));
    assert_problem(&problem, API_DEGENERATE_SURFACE, "");
    arena_free(arena);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_run_gives_a_container),
        cmocka_unit_test(test_run_of_a_part_is_partial),
        cmocka_unit_test(test_run_gives_the_same_bytes_again),
        cmocka_unit_test(test_run_refuses_a_surface_that_is_not_there),
        cmocka_unit_test(test_run_refuses_a_start_off_the_surface),
        cmocka_unit_test(test_run_refuses_a_direction_across_the_surface),
        cmocka_unit_test(test_run_refuses_generators_that_make_no_net),
        cmocka_unit_test(test_run_refuses_a_surface_without_area),
        cmocka_unit_test(test_run_refuses_more_nodes_than_allowed),
        cmocka_unit_test(test_run_allows_a_fine_strip),
        cmocka_unit_test(test_run_stops_when_the_net_outgrows_the_limit),
        cmocka_unit_test(test_run_reports_progress),
        cmocka_unit_test(test_run_stops_when_the_monitor_says_so),
        cmocka_unit_test(test_run_stops_when_the_sink_refuses),
        cmocka_unit_test(test_run_describes_a_surface),
        cmocka_unit_test(test_run_describes_no_surface_without_area),
    };
    prepare();
    return cmocka_run_group_tests_name("run", tests, NULL, NULL);
}
