/* SPDX-License-Identifier: MIT */
/* The n-th allocation fails, for every n: each time the answer is a clean out-of-memory, and under
 * a sanitizer nothing is lost. */
#include "cloth.h"
#include "support.h"
#include "tests/check.h"

#include "api/json/value.h"
#include "api/map/cavity.h"
#include "api/map/map.h"
#include "api/request/decode.h"
#include "api/request/digest.h"
#include "api/request/normalise.h"
#include "api/request/prepared_part.h"
#include <stdio.h>
#include <string.h>

/* Decodes with the n-th allocation of the parser, or of the arena, failing. */
static enum api_problem_id decode_failing(const char *text, size_t parser_n, size_t arena_n) {
    struct api_request request;
    struct api_problem problem;
    struct arena *arena = arena_new((size_t)1 << 24);
    arena_fail_at(arena, arena_n);
    json_tree_fail_at(parser_n);
    enum api_problem_id id = decode_text(text, arena, &request, &problem);
    json_tree_fail_at(0);
    assert_int_equal(id, problem.id);
    assert_int_equal(problem.count, id == API_OK ? 0 : problem.count);
    arena_free(arena);
    return id;
}

static void test_allocation_failures_of_the_parser(void **state) {
    (void)state;
    const char *const texts[] = {request_text("saddle"),  request_text("every_member"),
                                 request_text("trimmed"), request_text("tent"),
                                 "\"\\u00e9 string\"",    "[[1]]"};
    for (size_t k = 0; k < sizeof texts / sizeof *texts; k++) {
        enum api_problem_id sound = decode_failing(texts[k], 0, 0);
        size_t n = 1;
        while (decode_failing(texts[k], n, 0) == API_OUT_OF_MEMORY)
            n++;
        assert_int_equal(decode_failing(texts[k], n, 0), sound);
        check_above(n, 3);
        printf("%zu allocations of the parser\n", n - 1);
    }
}

static void test_allocation_failures_of_the_decoder(void **state) {
    (void)state;
    static const char *const names[] = {"saddle", "every_member", "fibres", "trimmed", "tent"};
    for (size_t k = 0; k < sizeof names / sizeof *names; k++) {
        const char *text = request_text(names[k]);
        enum api_problem_id sound = decode_failing(text, 0, 0);
        size_t n = 1;
        while (decode_failing(text, 0, n) == API_OUT_OF_MEMORY)
            n++;
        assert_int_equal(decode_failing(text, 0, n), sound);
        check_above(n, 3);
        printf("%zu allocations of the decoder\n", n - 1);
    }
}

/* What a request costs from its bytes to the result's. */
static enum api_problem_id run_failing(const char *text, int threads, size_t n, size_t budget,
                                       struct api_problem *problem) {
    struct arena *arena = arena_new(budget);
    struct bytes container = {0};
    struct api_sink sink = sink_into(&container);
    const struct api_input input = {.request = text, .request_length = strlen(text)};
    struct api_limits limits = api_limits_default;
    limits.threads = threads;
    *problem = (struct api_problem){0};
    arena_fail_at(arena, n);
    enum api_problem_id id = api_run_in(arena, &input, &limits, NULL, &sink, problem);
    assert_int_equal(id, problem->id);
    arena_free(arena);
    bytes_free(&container);
    return id;
}

/* ---- runs ---- */

/* Every way through the solver that has memory of its own: added to which request, with how many
 * threads. */
static const struct {
    const char *members, *request;
    int threads;
} runs[] = {
    {"\"method\":\"basic\"", "saddle", 1},
    {"\"method\":\"gib\"", "saddle", 1},
    {"\"method\":\"gib\"", "saddle", 4},
    {"\"method\":\"gib\",\"yarn_path\":\"relaxation\"", "saddle", 1},
    {"\"method\":\"gib4\"", "saddle", 1},
    {"\"method\":\"gib4\"", "saddle", 4},
    {"\"method\":\"geodesic\"", "saddle", 1},
    {"\"method\":\"mosaic\"", "saddle", 1},
    {"\"start\":{\"uv\":[0.5,0.5]},\"generators\":{\"warp\":{\"uv\":[[0,0.5],[1,0.5]]}}", "saddle",
     1},
    {"\"start\":{\"uv\":[0.5,0.5]},\"generators\":{\"weft\":{\"plane\":[1,0,0]}}", "saddle", 1},
    {"\"extent\":{\"warp\":[-2,2],\"weft\":[-1,2]}", "saddle", 1},
    {"\"permeability\":{\"model\":\"gebart\",\"fiber_radius\":5e-6,\"packing\":\"hexagonal\"}",
     "fibres", 1},
    {"\"permeability\":{\"model\":\"table\",\"shear_deg\":[0,40],\"k1\":[1e-10,2e-10],"
     "\"k2\":[1e-10,1e-10],\"k3\":[1e-11,1e-11]}",
     "fibres", 1},
    {"\"method\":\"gib\"", "trimmed", 1},
    {"\"method\":\"mosaic\"", "tent", 1},
    {"\"method\":\"mosaic\"", "tent", 4},
    {"\"method\":\"gib\"", "tent", 1},
};

static void test_allocation_failures_of_a_whole_run(void **state) {
    (void)state;
    for (size_t k = 0; k < sizeof runs / sizeof *runs; k++) {
        struct api_problem problem;
        struct bytes text = {0};
        size_t n = 1;
        bytes_format(&text, "{%s,%s", runs[k].members, request_text(runs[k].request) + 1);
        while (run_failing(text.data, runs[k].threads, n, (size_t)1 << 30, &problem) ==
               API_OUT_OF_MEMORY)
            n++;
        if (problem.id != API_OK)
            fail_msg("%s: allocation %zu: %s", text.data, n, problem.error[0].detail);
        check_above(n, 10);
        printf("%zu allocations of a run with %s\n", n - 1, runs[k].members);
        bytes_free(&text);
    }
}

/* ---- maps ---- */

static struct vec3 flat(double i, double j) {
    return vec3_make(i, j, 0);
}

typedef enum api_problem_id mesh_reader(const char *bytes, size_t length, struct arena *arena,
                                        struct map_target *mesh, struct api_problem *problem);

static const char pressed_request[] =
    "{\"surface\":{\"id\":\"00000000000000000000000000000000\"},"
    "\"fabric\":{\"spacing\":1,\"thickness\":0.01,\"fiber_volume_fraction\":0.5}}";
static const struct api_input pressed = {.request = pressed_request,
                                         .request_length = sizeof pressed_request - 1};

/* The mesh is read and mapped onto the cloth, which a punch presses if there is one. */
static enum api_problem_id map_failing(mesh_reader *read, const char *text, struct bytes *container,
                                       size_t n) {
    struct api_reader reader = reader_over(container);
    struct arena *arena = arena_new((size_t)1 << 28);
    struct map_target mesh = {0};
    struct api_map map;
    struct api_problem problem = {0};
    arena_fail_at(arena, n);
    enum api_problem_id id = read(text, strlen(text), arena, &mesh, &problem);
    if (id == API_OK && mesh.elements)
        id = map_target_option(&mesh, "inlet", "1", arena, &problem) ? API_OK : problem.id;
    if (id == API_OK &&
        cavity_take_cloth(&mesh, &reader, &pressed, &api_limits_default, arena, &problem))
        id = api_map_make(&reader, &mesh, NULL, arena, &map, &problem);
    id = problem.id;
    arena_free(arena);
    return id;
}

static void test_allocation_failures_of_a_map(void **state) {
    static const struct {
        mesh_reader *read;
        const char *text;
    } maps[] = {
        {map_target_json, "{\"points\":[[1,1,0],[2,2.5,0],[-1,3,2]]}"},
        {map_target_json, "{\"mesh\":{\"triangles\":[[0,1,2],[0,2,3]],"
                          "\"vertices\":[[0,0,0],[1,0,0],[1,1,0],[0,1,0]]}}"},
        {map_target_json, "{\"points\":[[1,1,0],[2,2.5,0]],\"punch\":{\"triangles\":[[0,1,2]],"
                          "\"vertices\":[[0,0,0.1],[9,0,0.1],[0,9,0.1]]}}"},
        {map_target_nastran, "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,1.,1.,0.\n"
                             "GRID,4,,0.,1.,0.\nCQUAD4,1,1,1,2,3,4\nCTRIA3,2,1,1,2,3\n"},
    };
    struct cloth cloth = cloth_make(8, 8, flat, NULL);
    struct bytes container = cloth_result(&cloth);
    (void)state;
    for (size_t k = 0; k < sizeof maps / sizeof *maps; k++) {
        size_t n = 1;
        enum api_problem_id id;
        while ((id = map_failing(maps[k].read, maps[k].text, &container, n)) == API_OUT_OF_MEMORY)
            n++;
        assert_int_equal(id, API_OK);
        check_above(n, 10);
        printf("%zu allocations of a map\n", n - 1);
    }
    bytes_free(&container);
    cloth_free(&cloth);
}

static void test_allocation_budgets_of_a_whole_run(void **state) {
    (void)state;
    struct api_problem problem = {0};
    size_t budget = 0;
    for (; budget < (size_t)1 << 26; budget += budget / 16 + 64)
        if (run_failing(request_text("saddle"), 1, 0, budget, &problem) != API_OUT_OF_MEMORY)
            break;
    if (problem.id != API_OK)
        fail_msg("budget %zu: %s", budget, problem.error[0].detail);
    printf("a run within %zu bytes\n", budget);
}

static void test_allocation_failures_of_the_written_documents(void **state) {
    (void)state;
    struct arena *arena = arena_new((size_t)1 << 24);
    struct api_request request;
    struct api_problem problem;
    char id[API_ID_SIZE];
    assert_int_equal(decode_text(request_text("saddle"), arena, &request, &problem), API_OK);
    size_t n = 1;
    for (bool done = false; !done; n++) {
        struct arena_mark mark = arena_mark(arena);
        arena_fail_at(arena, n);
        problem = (struct api_problem){0};
        bool normalised = api_normalise(&request, NULL, arena) != NULL;
        bool digested = normalised && api_digest_request(&request, arena, id);
        bool described = digested && describe_text(&request.surface, arena, &problem) != NULL;
        assert_int_equal(problem.id, digested && !described ? API_OUT_OF_MEMORY : API_OK);
        done = described;
        arena_fail_at(arena, 0);
        arena_rewind(arena, mark);
    }
    check_above(n, 5);
    arena_free(arena);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_allocation_failures_of_the_parser),
        cmocka_unit_test(test_allocation_failures_of_the_decoder),
        cmocka_unit_test(test_allocation_failures_of_a_whole_run),
        cmocka_unit_test(test_allocation_failures_of_a_map),
        cmocka_unit_test(test_allocation_budgets_of_a_whole_run),
        cmocka_unit_test(test_allocation_failures_of_the_written_documents),
    };
    prepare();
    return cmocka_run_group_tests_name("allocation", tests, NULL, NULL);
}
