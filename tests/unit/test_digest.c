/* SPDX-License-Identifier: MIT */
#include "api/request/digest.h"

#include "api/request/normalise.h"
#include "support.h"
#include "tests/check.h"
#include <stdlib.h>
#include <string.h>

/* The id of a request given as text, which must decode; the caller frees nothing. */
static const char *digest(const char *text) {
    static char ids[8][API_ID_SIZE];
    static int next;
    char *id = ids[next = (next + 1) % 8];
    struct api_request request;
    struct api_problem problem;
    struct arena *arena = arena_new((size_t)1 << 24);
    if (decode_text(text, arena, &request, &problem) != API_OK)
        fail_msg("%s: %s", problem.error[0].pointer, problem.error[0].detail);
    size_t held = arena_held(arena);
    assert_true(api_digest_request(&request, arena, id));
    assert_int_equal(arena_held(arena), held);
    arena_free(arena);
    return id;
}

static const char *digest_replaced(const char *what, const char *with) {
    struct bytes text = text_replace(request_text("saddle"), what, with);
    const char *id = digest(text.data);
    bytes_free(&text);
    return id;
}

static void test_digest_is_lower_case_hex_of_the_documented_length(void **state) {
    (void)state;
    const char *id = digest(request_text("saddle"));
    assert_int_equal(strlen(id), API_ID_LENGTH);
    assert_int_equal(strspn(id, "0123456789abcdef"), API_ID_LENGTH);
}

static void test_digest_is_the_same_for_every_spelling(void **state) {
    (void)state;
    static const char *const spellings[][2] = {
        {"\"fabric\":{", "\n\t \"fabric\" : { "},
        {"\"degree_u\":2,\"degree_v\":2", "\"degree_v\":2,\"degree_u\":2.0"},
        {"[2,2,0]", "[2.0,2e0,0.0]"},
        {"[2,2,0]", "[2,20E-1,-0.0]"},
        {"\"size_u\":3", "\"size_u\":3,\"name\":\"saddle\",\"delta\":[0.1,0.1],\"rational\":false"},
        {"[2,2,0]]", "[2,2,0]],\"weights\":[1,1,1,1,1,1,1,1,1]"},
        {"\"spacing\":0.5", "\"spacing\":[0.5,5e-1]"},
        {"\"spacing\":0.5", "\"spacing\":0.5,\"plies\":1,\"pre_shear_deg\":0"},
        {"{\"surface\"", "{\"method\":\"gib\",\"length_unit\":\"m\",\"cavity\":\"flexible\","
                         "\"yarn_path\":\"chord\",\"direction\":{\"angle_deg\":0},\"extent\":{},"
                         "\"generators\":{\"weft\":\"geodesic\"},\"surface\""},
    };
    const char *id = digest(request_text("saddle"));
    for (size_t i = 0; i < sizeof spellings / sizeof *spellings; i++)
        assert_string_equal(digest_replaced(spellings[i][0], spellings[i][1]), id);
    struct bytes moved = {0};
    bytes_format(&moved, "{\"fabri\\u0063\":{\"spacing\":0.5},\"surface\":%s}",
                 request_text("saddle_surface"));
    assert_string_equal(digest(moved.data), id);
    bytes_free(&moved);
}

static void test_digest_of_a_whole_export_file_is_that_of_its_surface(void **state) {
    (void)state;
    struct bytes text = {0};
    bytes_format(&text,
                 "{\"surface\":{\"shape\":{\"type\":\"surface\",\"count\":1,\"data\":[%s]}},"
                 "\"fabric\":{\"spacing\":0.5}}",
                 request_text("saddle_surface"));
    assert_string_equal(digest(text.data), digest(request_text("saddle")));
    bytes_free(&text);
}

static void test_digest_differs_when_anything_does(void **state) {
    (void)state;
#define TRIMS(reversed)                                                                            \
    "[2,2,0]]},\"trims\":[{\"points\":[[0.2,0.2],[0.8,0.2],[0.5,0.8],[0.2,0.2]],"                  \
    "\"reversed\":" reversed "}]}"
    static const char *const changes[][2] = {
        {"[2,2,0]]}}", TRIMS("0")},
        {"[2,2,0]]}}", TRIMS("1")},
        {"[2,2,0]", "[2,2,1e-15]"},
        {"[0,0,0,1,1,1]", "[0,0,0,2,2,2]"},
        {"[2,2,0]]", "[2,2,0]],\"weights\":[1,1,1,1,2,1,1,1,1]"},
        {"\"spacing\":0.5", "\"spacing\":0.5000000000000001"},
        {"\"spacing\":0.5", "\"spacing\":[0.5,0.25]"},
        {"\"spacing\":0.5", "\"spacing\":0.5,\"thickness\":1"},
        {"\"spacing\":0.5", "\"spacing\":0.5,\"fiber_volume_fraction\":0.5"},
        {"\"spacing\":0.5", "\"spacing\":0.5,\"locking_angle_deg\":0"},
        {"\"spacing\":0.5", "\"spacing\":0.5,\"locking_angle_deg\":40"},
        {"\"spacing\":0.5",
         "\"spacing\":0.5,\"locking_angle_deg\":{\"positive\":40,\"negative\":30}"},
        {"\"spacing\":0.5",
         "\"spacing\":0.5,\"locking_angle_deg\":{\"positive\":30,\"negative\":40}"},
        {"\"spacing\":0.5",
         "\"spacing\":0.5,\"limit_curve\":{\"shear_deg\":[0,40],\"severity\":[0,1]}"},
        {"\"spacing\":0.5",
         "\"spacing\":0.5,\"limit_curve\":{\"shear_deg\":[0,40],\"severity\":[0,0.9]}"},
        {"\"spacing\":0.5", "\"spacing\":0.5,\"kinematics\":\"parallel_fibers\""},
        {"\"spacing\":0.5", "\"spacing\":0.5,\"kinematics\":{\"slide\":0.5}"},
        {"\"spacing\":0.5", "\"spacing\":0.5,\"plies\":2"},
        {"\"spacing\":0.5", "\"spacing\":0.5,\"pre_shear_deg\":1"},
        {"\"spacing\":0.5", "\"spacing\":0.5,\"pre_shear_deg\":-1"},
        {"{\"surface\"", "{\"length_unit\":\"mm\",\"surface\""},
        {"{\"surface\"", "{\"method\":\"basic\",\"surface\""},
        {"{\"surface\"", "{\"start\":{\"uv\":[0.5,0.5]},\"surface\""},
        {"{\"surface\"", "{\"start\":{\"point\":[0,0,0]},\"surface\""},
        {"{\"surface\"", "{\"direction\":{\"angle_deg\":1},\"surface\""},
        {"{\"surface\"", "{\"direction\":{\"vector\":[1,0,0]},\"surface\""},
        {"{\"surface\"", "{\"extent\":{\"warp\":[-1,1]},\"surface\""},
        {"{\"surface\"", "{\"extent\":{\"weft\":[-1,1]},\"surface\""},
        {"{\"surface\"", "{\"cavity\":{\"height\":1},\"surface\""},
    };
    enum { COUNT = sizeof changes / sizeof *changes };
    char ids[COUNT + 1][API_ID_SIZE];
    strcpy(ids[COUNT], digest(request_text("saddle")));
    for (size_t i = 0; i < COUNT; i++)
        strcpy(ids[i], digest_replaced(changes[i][0], changes[i][1]));
    for (size_t i = 0; i <= COUNT; i++)
        for (size_t k = 0; k < i; k++)
            assert_string_not_equal(ids[i], ids[k]);
}

/* A stored surface and the same surface sent along make the same request. */
static void test_digest_of_a_named_surface_is_that_of_its_definition(void **state) {
    (void)state;
    struct arena *arena = arena_new((size_t)1 << 24);
    struct api_request request;
    struct api_problem problem;
    struct bytes text = {0};
    char id[API_ID_SIZE];
    assert_int_equal(decode_text(request_text("saddle"), arena, &request, &problem), API_OK);
    assert_true(api_digest_surface(&request.surface, arena, id));
    bytes_format(&text, "{\"surface\":{\"id\":\"%s\"},\"fabric\":{\"spacing\":0.5}}", id);
    assert_string_equal(digest(text.data), digest(request_text("saddle")));
    bytes_free(&text);
    arena_free(arena);
}

/* Ids outlive the process: they must not change by accident. A change of the canonical text, and
 * thereby of these, is a change of every stored id. */
static void test_digest_of_the_saddle_stays_what_it_was(void **state) {
    (void)state;
    struct arena *arena = arena_new((size_t)1 << 24);
    struct api_request request;
    struct api_problem problem;
    char id[API_ID_SIZE];
    assert_int_equal(decode_text(request_text("saddle"), arena, &request, &problem), API_OK);
    assert_true(api_digest_surface(&request.surface, arena, id));
    assert_string_equal(api_normalise_surface(&request.surface, arena),
                        request_text("saddle_surface"));
    assert_string_equal(id, "03d4a63eecf9b89ee7421a3945f2bf22");
    arena_free(arena);
}

/* Another version of the solver may give another result: the id is of it as well. */
static void test_digest_of_a_request_has_the_solvers_version(void **state) {
    (void)state;
    struct arena *arena = arena_new((size_t)1 << 24);
    struct api_request request;
    struct api_problem problem;
    struct bytes all = {0};
    char id[API_ID_SIZE];
    assert_int_equal(decode_text(request_text("saddle"), arena, &request, &problem), API_OK);
    assert_true(api_digest_surface(&request.surface, arena, request.surface.id));
    const char *text = api_normalise(&request, NULL, arena);
    bytes_add(&all, text, strlen(text) + 1);
    bytes_add(&all, DRAPE_VERSION, strlen(DRAPE_VERSION));
    api_digest_bytes(all.data, all.length, id);
    assert_string_equal(digest(request_text("saddle")), id);
    bytes_free(&all);
    arena_free(arena);
}

static void test_digest_of_bytes_is_blake2b(void **state) {
    (void)state;
    char id[API_ID_SIZE];
    api_digest_bytes("abc", 3, id);
    assert_string_equal(id, "cf4ab791c62b8d2b2109c90275287816"); /* b2sum -l 128 */
    api_digest_bytes("", 0, id);
    assert_string_equal(id, "cae66941d9efbd404e4d88758ea67670");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_digest_is_lower_case_hex_of_the_documented_length),
        cmocka_unit_test(test_digest_is_the_same_for_every_spelling),
        cmocka_unit_test(test_digest_of_a_whole_export_file_is_that_of_its_surface),
        cmocka_unit_test(test_digest_differs_when_anything_does),
        cmocka_unit_test(test_digest_of_a_named_surface_is_that_of_its_definition),
        cmocka_unit_test(test_digest_of_the_saddle_stays_what_it_was),
        cmocka_unit_test(test_digest_of_a_request_has_the_solvers_version),
        cmocka_unit_test(test_digest_of_bytes_is_blake2b),
    };
    prepare();
    return cmocka_run_group_tests_name("digest", tests, NULL, NULL);
}
