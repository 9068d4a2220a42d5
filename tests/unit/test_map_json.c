/* SPDX-License-Identifier: MIT */
#include "mesh_text.h"
#include "own_arena.h"
#include "support.h"
#include "tests/check.h"
#include <stdlib.h>
#include <string.h>

static enum api_problem_id read_bytes(const char *text, size_t length, struct map_target *mesh,
                                      struct api_problem *problem) {
    return mesh_text_read(map_target_json, text, length, arena, mesh, problem);
}

static struct map_target read_good(const char *text) {
    return mesh_text_good(map_target_json, text, arena);
}

static void test_map_json_reads_points(void **state) {
    (void)state;
    struct map_target mesh =
        read_good(" {\"points\" : [[1, -2.5e1, 0], [0.125,1E-2,-0]\n, [1e12,-1e12,3]]} \r\n");
    assert_int_equal(mesh.element_count, 3);
    assert_int_equal(mesh.vertex_count, 3);
    assert_null(mesh.elements);
    assert_null(mesh.ids);
    assert_null(mesh.roles);
    assert_true(mesh.vertices[0].x == 1 && mesh.vertices[0].y == -25 && mesh.vertices[0].z == 0);
    assert_true(mesh.vertices[1].x == 0.125 && mesh.vertices[1].y == 0.01);
    assert_true(mesh.vertices[2].x == 1e12 && mesh.vertices[2].y == -1e12);
}

#define SQUARE "\"vertices\":[[0,0,0],[1,0,0],[1,1,0],[0,1,0]]"
#define HALVES "\"triangles\":[[0,1,2],[0,2,3]]"

static void test_map_json_reads_a_mesh_in_any_order(void **state) {
    (void)state;
    static const char *const texts[] = {"{\"mesh\":{" SQUARE "," HALVES "},\"inlet_elements\":[1]}",
                                        "{\"inlet_elements\":[1,1],\"mesh\":{" HALVES "," SQUARE
                                        "}}"};
    for (int k = 0; k < 2; k++) {
        struct map_target mesh = read_good(texts[k]);
        static const int32_t expected[2][4] = {{0, 1, 2, -1}, {0, 2, 3, -1}};
        assert_int_equal(mesh.vertex_count, 4);
        assert_int_equal(mesh.element_count, 2);
        assert_memory_equal(mesh.elements, expected, sizeof expected);
        assert_true(mesh.roles[0] == 0 && mesh.roles[1] == 1);
    }
    assert_null(read_good("{\"mesh\":{" SQUARE "," HALVES "}}").roles);
    assert_non_null(read_good("{\"mesh\":{" SQUARE "," HALVES "},\"inlet_elements\":[]}").roles);
}

/* Triangles come first, whatever the order of the keys; numbers are of all elements. */
static void test_map_json_reads_quadrilaterals_and_numbers(void **state) {
    (void)state;
    struct map_target mesh = read_good("{\"mesh\":{\"ids\":[5,9,7],\"quads\":[[0,1,2,3]]," HALVES
                                       ",\"vertex_ids\":[40,30,20,10]," SQUARE "}}");
    static const int32_t expected[3][4] = {{0, 1, 2, -1}, {0, 2, 3, -1}, {0, 1, 2, 3}};
    static const int32_t ids[] = {5, 9, 7}, vertex_ids[] = {40, 30, 20, 10};
    assert_int_equal(mesh.element_count, 3);
    assert_memory_equal(mesh.elements, expected, sizeof expected);
    assert_memory_equal(mesh.ids, ids, sizeof ids);
    assert_memory_equal(mesh.vertex_ids, vertex_ids, sizeof vertex_ids);
    mesh = read_good("{\"mesh\":{" SQUARE ",\"quads\":[[0,1,2,3]]}}");
    assert_int_equal(mesh.element_count, 1);
    assert_memory_equal(mesh.elements, expected[2], sizeof expected[2]);
    assert_null(mesh.ids);
}

struct wrong {
    const char *text;
    enum api_problem_id id;
    const char *pointer; /* NULL: none */
    const char *detail;  /* a part of it */
};

#define MALFORMED API_MALFORMED_JSON, NULL
#define INVALID API_INVALID_REQUEST
#define MESH(...) "{\"mesh\":{" __VA_ARGS__ "}}"

static const struct wrong wrongs[] = {
    {"", MALFORMED, "empty"},
    {" ", MALFORMED, "line 1, column 2"},
    {"nonsense", MALFORMED, "line 1, column 1: a value is missing"},
    {"null", INVALID, "", "must be an object"},
    {"[]", INVALID, "", "must be an object"},
    {"{}", INVALID, "", "either \"points\" or \"mesh\""},
    {"{\"points\":[[1,2,3]]} x", MALFORMED, "line 1, column 22: there is text after the end"},
    {"{\"points\":[[1,2,3]],}", MALFORMED, "a key in quotes"},
    {"{\"points\" [[1,2,3]]}", MALFORMED, "colon"},
    {"{\"points\":[[1,2,3]]", MALFORMED, "ends early"},
    {"{\"points\":[[1,2,3]", MALFORMED, "ends early"},
    {"{\"points\":[[1,2", MALFORMED, "ends early"},
    {"{\"points\":[[1,2,3],\n[1,2,]]}", MALFORMED, "line 2, column 6: a value is missing"},
    {"{\"points\":[[1,2,3] [1,2,3]]}", MALFORMED, "comma"},
    {"{\"points\":[[1,2,NaN]]}", MALFORMED, "line 1, column 17: a value is missing"},
    {"{\"points\":[[1,2,-Infinity]]}", MALFORMED, "this is not a JSON number"},
    {"{\"points\":[[1,2,+3]]}", MALFORMED, "a value is missing"},
    {"{\"points\":[[1,2,03]]}", MALFORMED, "this is not a JSON number"},
    {"{\"points\":[[1,2,3.]]}", MALFORMED, "this is not a JSON number"},
    {"{\"points\":[[1,2,.3]]}", MALFORMED, "a value is missing"},
    {"{\"points\":[[1,2,-.3]]}", MALFORMED, "this is not a JSON number"},
    {"{\"points\":[[1,2,3e]]}", MALFORMED, "comma"},
    {"{\"points\":[[1,2,0x3]]}", MALFORMED, "comma"},
    {"{\"points\":[[1,2,1e999]]}", INVALID, "/points/0/2", "too large"},
    {"{\"points\":[[1,2,2e12]]}", INVALID, "/points/0/2", "between -1e12 and 1e12"},
    {"{\"points\":[[1,2,null]]}", INVALID, "/points/0/2", "must be a number"},
    {"{\"points\":[[1,2,nan]]}", MALFORMED, "a value is missing"},
    {"{\"points\":[[1,2,\"3\"]]}", INVALID, "/points/0/2", "must be a number"},
    {"{\"points\":[[1,2,3],[1,2]]}", INVALID, "/points/1", "three numbers"},
    {"{\"points\":[[1,2,3,4]]}", INVALID, "/points/0", "three numbers"},
    {"{\"points\":[[]]}", INVALID, "/points/0", "three numbers"},
    {"{\"points\":[1,2,3]}", INVALID, "/points/0", "three numbers"},
    {"{\"points\":[]}", INVALID, "/points", "empty"},
    {"{\"points\":{}}", INVALID, "/points", "array"},
    {"{\"points\":7}", INVALID, "/points", "must be an array of arrays of numbers"},
    {"{\"cavity_heights\":7}", INVALID, "/cavity_heights", "must be an array of numbers"},
    {"{\"inlet_elements\":7}", INVALID, "/inlet_elements", "must be an array of whole numbers"},
    {"{\"point\":[[1,2,3]]}", INVALID, "/point", "not known"},
    {"{\"points\":[[1,2,3]],\"points\":[[1,2,3]]}", INVALID, "/points", "only one"},
    {"{\"points\":[[1,2,3]],\"mesh\":{}}", INVALID, "/mesh", "only one"},
    {"{\"points\":[[1,2,3]],\"inlet_elements\":[0]}", INVALID, "/inlet_elements", "needs a mesh"},
    {"{\"mesh\":[]}", INVALID, "/mesh", "must be an object"},
    {MESH(""), INVALID, "/mesh/vertices", "required"},
    {MESH(SQUARE), INVALID, "/mesh/triangles", "required"},
    {MESH(HALVES), INVALID, "/mesh/vertices", "required"},
    {MESH(SQUARE ",\"triangles\":[]"), INVALID, "/mesh/triangles", "empty"},
    {MESH(SQUARE ",\"triangles\":[[0,1,4]]"), INVALID, "/mesh/triangles/0/2", "less than 4"},
    {MESH(SQUARE ",\"triangles\":[[0,1,-1]]"), INVALID, "/mesh/triangles/0/2", "index"},
    {MESH(SQUARE ",\"triangles\":[[0,1,1.5]]"), INVALID, "/mesh/triangles/0/2", "index"},
    {MESH(SQUARE ",\"triangles\":[[0,1,2,3]]"), INVALID, "/mesh/triangles/0", "three"},
    {MESH(SQUARE ",\"quads\":[[0,1,2]]"), INVALID, "/mesh/quads/0", "four"},
    {MESH(SQUARE ",\"quads\":[[0,1,2,4]]"), INVALID, "/mesh/quads/0/3", "less than 4"},
    {MESH(SQUARE ",\"quads\":[[0,1,2,3]],\"quads\":[]"), MALFORMED, "twice"},
    {MESH(SQUARE ",\"hexas\":[[0,1,2,3]]"), INVALID, "/mesh/hexas", "not known"},
    {MESH(SQUARE "," HALVES ",\"ids\":[7]"), INVALID, "/mesh/ids", "2 numbers, not 1"},
    {MESH(SQUARE "," HALVES ",\"ids\":[7,0]"), INVALID, "/mesh/ids/1", "from 1"},
    {MESH(SQUARE "," HALVES ",\"ids\":[7,7]"), INVALID, "/mesh/ids/1", "given twice: 7"},
    {MESH(SQUARE "," HALVES ",\"ids\":[7,8],\"ids\":[7,8]"), MALFORMED, "twice"},
    {MESH(SQUARE "," HALVES ",\"vertex_ids\":[4,3,2,4]"), INVALID, "/mesh/vertex_ids/3", "twice"},
    {MESH(SQUARE "," SQUARE), MALFORMED, "twice"},
    {"{\"mesh\":{" SQUARE "," HALVES "},\"inlet_elements\":[2]}", INVALID, "/inlet_elements/0",
     "less than 2"},
    {"{\"mesh\":{" SQUARE "," HALVES "},\"inlet_elements\":[\"a\"]}", INVALID, "/inlet_elements/0",
     "must be a number"},
    {"{\"inlet_elements\":[0],\"inlet_elements\":[0]}", MALFORMED, "twice"},
    {"{\"po\\u0069nts\":[[1,2,3]]}", MALFORMED, "a backslash or a control character"},
    {"\xef\xbb\xbf{\"points\":[[1,2,3]]}", MALFORMED, "a value is missing"},
};

static void test_map_json_says_what_is_wrong_and_where(void **state) {
    (void)state;
    for (size_t k = 0; k < sizeof wrongs / sizeof *wrongs; k++) {
        const struct wrong *wrong = &wrongs[k];
        struct map_target mesh;
        struct api_problem problem;
        enum api_problem_id id = read_bytes(wrong->text, strlen(wrong->text), &mesh, &problem);
        if (id != wrong->id || !strstr(problem.error[0].detail, wrong->detail) ||
            problem.has_pointer != (wrong->pointer != NULL) ||
            (wrong->pointer && strcmp(problem.error[0].pointer, wrong->pointer) != 0))
            fail_msg("%s: %s at '%s': %s", wrong->text, api_problem_slug(id),
                     problem.error[0].pointer, problem.error[0].detail);
    }
}

/* Cut anywhere, or with any byte replaced, it is read or refused, and never read beyond its end. */
static void test_map_json_takes_any_bytes(void **state) {
    (void)state;
    static const char text[] =
        "{\"mesh\":{\"vertices\":[[0,0,0],[1,-1.5e-3,0],[1,1,0.25]],\"triangles\":[[0,1,2]]},"
        "\"inlet_elements\":[0]}";
    struct random random = random_begin("bytes");
    struct map_target mesh;
    struct api_problem problem;
    for (size_t length = 0; length < sizeof text - 1; length++)
        assert_int_equal(read_bytes(text, length, &mesh, &problem), API_MALFORMED_JSON);
    for (int trial = 0; trial < 20000; trial++) {
        static const char some[] = "{}[]\",:0123456789.-+eE \n\\tn\xff";
        char changed[sizeof text];
        memcpy(changed, text, sizeof text);
        for (int k = random_index(&random, 3); k >= 0; k--)
            changed[random_index(&random, sizeof text - 1)] =
                some[random_index(&random, sizeof some)];
        struct arena_mark mark = arena_mark(arena);
        enum api_problem_id id = read_bytes(changed, sizeof text - 1, &mesh, &problem);
        assert_true(id == problem.id);
        assert_true(id == API_OK || id == API_MALFORMED_JSON || id == API_INVALID_REQUEST);
        arena_rewind(arena, mark);
    }
}

static void test_map_json_without_memory_is_a_problem(void **state) {
    (void)state;
    static const char text[] = "{\"mesh\":{" SQUARE "," HALVES "},\"inlet_elements\":[1]}";
    struct map_target mesh;
    struct api_problem problem;
    for (size_t n = 1; n <= 4; n++) {
        arena_fail_at(arena, n);
        assert_int_equal(read_bytes(text, sizeof text - 1, &mesh, &problem), API_OUT_OF_MEMORY);
    }
    arena_fail_at(arena, 5);
    assert_int_equal(read_bytes(text, sizeof text - 1, &mesh, &problem), API_OK);
    arena_fail_at(arena, 0);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_map_json_reads_points),
        cmocka_unit_test(test_map_json_reads_a_mesh_in_any_order),
        cmocka_unit_test(test_map_json_reads_quadrilaterals_and_numbers),
        cmocka_unit_test(test_map_json_says_what_is_wrong_and_where),
        cmocka_unit_test(test_map_json_takes_any_bytes),
        cmocka_unit_test(test_map_json_without_memory_is_a_problem),
    };
    return cmocka_run_group_tests_name("map_json", tests, set_up, tear_down);
}
