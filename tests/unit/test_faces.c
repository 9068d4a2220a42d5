/* SPDX-License-Identifier: MIT */
/* Several faces as one surface, from the document to the result: checks, descriptions, selections.
 */
#include "api/check.h"
#include "support.h"
#include "tests/check.h"
#include <jansson.h>
#include <math.h>
#include <stdio.h>
#include <string.h>

#define NET "\"degree_u\":1,\"degree_v\":1,\"size_u\":2,\"size_v\":2,"
#define KNOTS "\"knotvector_u\":[0,0,1,1],\"knotvector_v\":[0,0,1,1],"
#define FACE(more, points) "{" more NET KNOTS "\"control_points\":[" points "]}"
/* Squares of side 1 from x = 0: flat, flat beside it, folded up by 45 degrees, a fin on the first
 * joint, a flap that lies on the first one. */
#define FLAT FACE("\"name\":\"left\",", "[0,0,0],[0,1,0],[1,0,0],[1,1,0]")
#define BESIDE FACE("", "[1,0,0],[1,1,0],[2,0,0],[2,1,0]")
#define FOLDED FACE("\"kind\":\"plane\",", "[2,0,0],[2,1,0],[3,0,1],[3,1,1]")
#define FIN FACE("\"name\":\"fin\",", "[1,0,0],[1,1,0],[1,0,1],[1,1,1]")
#define FLAP FACE("", "[1,0,0],[1,1,0],[0.4,0,0],[0.4,1,0]")
#define FABRIC "\"fabric\":{\"spacing\":0.1}"
#define ID "0123456789abcdef0123456789abcdef"

static enum api_problem_id check_with(const char *request, const char *stored,
                                      struct api_problem *problem) {
    const struct api_input input = {.request = request,
                                    .request_length = strlen(request),
                                    .surface = stored,
                                    .surface_length = stored ? strlen(stored) : 0};
    struct api_check check;
    prepare();
    *problem = (struct api_problem){0};
    return api_check_drape(&input, &api_limits_default, NULL, &check, problem);
}

static void assert_refused(const char *request, const char *stored, enum api_problem_id id,
                           const char *pointer, const char *words) {
    struct api_problem problem;
    assert_int_equal(check_with(request, stored, &problem), id);
    assert_string_equal(problem.error[0].pointer, pointer);
    if (!strstr(problem.error[0].detail, words))
        fail_msg("\"%s\" is not in \"%s\"", words, problem.error[0].detail);
}

static json_t *describe(const char *surface, struct api_problem *problem) {
    const struct api_input input = {.request = surface, .request_length = strlen(surface)};
    struct api_check check;
    struct bytes bytes = {0};
    const struct api_sink sink = sink_into(&bytes);
    json_t *document = NULL;
    prepare();
    *problem = (struct api_problem){0};
    if (api_check_surface(&input, &api_limits_default, &sink, NULL, &check, problem) == API_OK)
        document = json_loads(bytes.data + check.definition_length, 0, NULL);
    bytes_free(&bytes);
    return document;
}

static double number_at(const json_t *object, const char *key) {
    return json_number_value(json_object_get(object, key));
}

static void test_faces_that_cannot_be_one_surface_are_named(void **state) {
    (void)state;
    assert_refused("{\"surface\":{\"faces\":[" FLAT "," BESIDE "," FIN "]}," FABRIC "}", NULL,
                   API_INVALID_REQUEST, "/surface/faces", "2 (\"fin\")");
    assert_refused("{\"surface\":{\"faces\":[" FLAT "," BESIDE "],\"tolerance\":50}," FABRIC "}",
                   NULL, API_INVALID_REQUEST, "/surface/tolerance", "as large as the part");
    assert_refused("{\"surface\":{\"faces\":[" FLAT
                   "," FACE("", "[1,0,0],[1,1,0],[1,0,0],[1,1,0]") "]}," FABRIC "}",
                   NULL, API_DEGENERATE_SURFACE, "/surface/faces/1", "face 1 has no area");
}

static void test_faces_selected_by_number(void **state) {
    (void)state;
    const char *stored = "{\"faces\":[" FLAT "," BESIDE "," FOLDED "," FIN "]}";
    struct api_problem problem;
    assert_int_equal(check_with("{\"surface\":{\"id\":\"" ID "\",\"faces\":[0,1,2]}," FABRIC
                                ",\"start\":{\"face\":2,\"uv\":[0.5,0.5]}}",
                                stored, &problem),
                     API_OK);
    assert_refused("{\"surface\":{\"id\":\"" ID "\",\"faces\":[0,2]}," FABRIC
                   ",\"start\":{\"face\":3,\"uv\":[0.5,0.5]}}",
                   stored, API_INVALID_REQUEST, "/start/face", "face 3 (\"fin\") is not among");
    assert_refused("{\"surface\":{\"id\":\"" ID "\",\"faces\":[0,4]}," FABRIC "}", stored,
                   API_INVALID_REQUEST, "/surface/faces/1", "less than 4");
    assert_refused("{\"surface\":{\"id\":\"" ID "\"}," FABRIC "}", stored, API_INVALID_REQUEST,
                   "/surface/faces", "meet at one edge");
}

/* How many faces the nodes of a drape lie on. */
static int faces_under(const char *request, const char *stored) {
    const struct api_input input = {.request = request,
                                    .request_length = strlen(request),
                                    .surface = stored,
                                    .surface_length = strlen(stored)};
    struct bytes container = {0};
    const struct api_sink sink = sink_into(&container);
    struct api_problem problem = {0};
    struct api_columns columns;
    int seen = 0;
    prepare();
    assert_int_equal(api_run(&input, &api_limits_default, NULL, &sink, &problem), API_OK);
    const struct api_reader reader = reader_over(&container);
    assert_int_equal(api_columns_open(&reader, &columns, &problem), API_OK);
    size_t rows = api_columns_rows(&columns, API_TABLE_NODES);
    for (size_t k = 0; k < columns.count; k++) {
        const struct api_column *column = &columns.column[k];
        for (size_t i = 0;
             column->table == API_TABLE_NODES && !strcmp(column->name, "face") && i < rows; i++) {
            double face;
            assert_true(api_columns_read(&reader, column, i, 1, &face));
            seen |= 1 << (int)face;
        }
    }
    bytes_free(&container);
    return seen;
}

static void test_faces_grown_from_one(void **state) {
    (void)state;
    const char *stored = "{\"faces\":[" FOLDED "," FLAT "," BESIDE "]}";
    assert_int_equal(
        faces_under("{\"surface\":{\"id\":\"" ID "\",\"grow_from\":1}," FABRIC "}", stored),
        1 << 1 | 1 << 2);
    assert_int_equal(faces_under("{\"surface\":{\"id\":\"" ID
                                 "\",\"grow_from\":1,\"up_to_deg\":46}," FABRIC "}",
                                 stored),
                     1 << 0 | 1 << 1 | 1 << 2);
    assert_refused("{\"surface\":{\"id\":\"" ID "\",\"grow_from\":3}," FABRIC "}", stored,
                   API_INVALID_REQUEST, "/surface/grow_from", "less than 3");
}

static void test_faces_are_described(void **state) {
    (void)state;
    struct api_problem problem;
    json_t *shell =
        describe("{\"faces\":[" FLAT "," BESIDE "," FOLDED "],\"length_unit\":\"mm\"}", &problem);
    assert_non_null(shell);
    const json_t *faces = json_object_get(shell, "faces"), *last = json_array_get(faces, 2);
    const json_t *edges = json_object_get(shell, "edges");
    assert_int_equal(json_array_size(faces), 3);
    check_below(fabs(number_at(shell, "area") - 2 - sqrt(2)), 1e-13);
    check_below(fabs(number_at(last, "area") - sqrt(2)), 1e-13);
    check_below(
        fabs(json_number_value(json_array_get(json_object_get(last, "normal"), 2)) - sqrt(0.5)),
        1e-13);
    check_below(fabs(json_number_value(json_array_get(json_object_get(last, "centre"), 0)) - 2.5),
                1e-13);
    assert_string_equal(json_string_value(json_object_get(last, "kind")), "plane");
    assert_string_equal(json_string_value(json_object_get(json_array_get(faces, 0), "name")),
                        "left");
    assert_string_equal(json_string_value(json_object_get(shell, "length_unit")), "mm");
    assert_true(number_at(edges, "shared") == 2 && number_at(edges, "faulty") == 0);
    static const double joints[2][3] = {{0, 1, 0}, {1, 2, 45}}; /* face, face, fold */
    const json_t *rows = json_object_get(shell, "joints");
    assert_int_equal(json_array_size(rows), 2);
    for (size_t k = 0; k < 6; k++)
        check_below(fabs(json_number_value(json_array_get(json_array_get(rows, k / 3), k % 3)) -
                         joints[k / 3][k % 3]),
                    1e-9);
    json_decref(shell);
}

/* Cloth does not turn back upon itself: neither at the flap's edge nor where sides lie on sides. */
static void test_faces_that_lie_on_each_other_are_not_joined(void **state) {
    (void)state;
    struct api_problem problem;
    json_t *shell = describe("{\"faces\":[" FLAT "," FLAP "]}", &problem);
    assert_non_null(shell);
    assert_true(number_at(json_object_get(shell, "edges"), "shared") == 0);
    assert_true(number_at(shell, "components") == 2);
    json_decref(shell);
}

/* What an importer noted is kept, and a file's fault is one more note: some faces can be chosen. */
static void test_faces_of_a_file_are_stored_with_their_fault(void **state) {
    (void)state;
    struct api_problem problem;
    assert_null(describe("{\"faces\":[" FLAT "," BESIDE "," FIN "]}", &problem));
    assert_int_equal(problem.id, API_INVALID_REQUEST);
    json_t *shell =
        describe("{\"faces\":[" FLAT "," BESIDE "," FIN "],\"notes\":[\"sewn\"]}", &problem);
    assert_non_null(shell);
    const json_t *notes = json_object_get(shell, "notes");
    assert_int_equal(json_array_size(notes), 2);
    assert_string_equal(json_string_value(json_array_get(notes, 0)), "sewn");
    assert_non_null(strstr(json_string_value(json_array_get(notes, 1)), "meet at one edge"));
    assert_true(number_at(json_object_get(shell, "edges"), "faulty") == 1);
    json_decref(shell);
}

/* Of three faces at an edge none is joined there; all else is, and can be chosen by growing. */
static void test_faces_with_a_fault_are_joined_elsewhere(void **state) {
    (void)state;
    const char *stored = "{\"faces\":[" FLAT "," BESIDE "," FIN "," FOLDED "],\"notes\":[]}";
    struct api_problem problem;
    json_t *shell = describe(stored, &problem);
    assert_non_null(shell);
    const json_t *edges = json_object_get(shell, "edges");
    assert_true(number_at(edges, "faulty") == 1 && number_at(edges, "shared") == 1);
    assert_true(number_at(shell, "components") == 3);
    json_decref(shell);
    assert_int_equal(faces_under("{\"surface\":{\"id\":\"" ID
                                 "\",\"grow_from\":1,\"up_to_deg\":46}," FABRIC "}",
                                 stored),
                     1 << 1 | 1 << 3);
}

#define TRIMMED(trims)                                                                             \
    FACE("\"name\":\"rib\",\"trims\":[" trims "],", "[1,0,0],[1,1,0],[2,0,0],[2,1,0]")
#define HOLE "{\"points\":[[0.1,0.1],[0.3,0.1],[0.3,0.3],[0.1,0.3]]}"

/* A spline of degree 1 through four corners, and back to the first or not. */
#define SPLINE(knots, more)                                                                        \
    "{\"degree\":1,\"knotvector\":[0,0,1,2,3" knots "],\"control_points\":{\"points\":"            \
    "[[0.5,0.5],[0.9,0.5],[0.9,0.9],[0.5,0.9]" more "]}}"

static void test_faces_with_a_bad_loop_are_named(void **state) {
    (void)state;
    static const struct {
        const char *face, *words; /* NULL: the loops are sound */
    } cases[] = {
        {TRIMMED(HOLE "," SPLINE(",4,4", ",[0.5,0.5]")), NULL},
        {TRIMMED(HOLE "," SPLINE(",3", "")), "trim 1 of face 1 (\"rib\") is open: a curve ends at "
                                             "u = 0.5, v = 0.9 and the next begins at u = 0.5, "
                                             "v = 0.5"},
        {TRIMMED(HOLE ",{\"points\":[[0.5,0.5],[0.9,0.9],[0.9,0.5],[0.5,0.9]]}"),
         "trim 1 of face 1 (\"rib\") crosses itself"},
        /* two strips of a 250th of the domain, above each other's ends */
        {TRIMMED(HOLE ",{\"points\":[[0.5,0.5],[0.9,0.504],[0.9,0.5],[0.5,0.504]]}"),
         "crosses itself"},
        {TRIMMED(HOLE ",{\"points\":[[0.5,0.5],[0.9,0.5],[0.9,0.9],[0.5,0.9],"
                      "[0.5,0.5],[0.9,0.5],[0.9,0.9],[0.5,0.9]]}"),
         "goes round more than once"},
        /* a square with a strip beside it, a 1000th high, whose sides cross */
        {TRIMMED(HOLE
                 ",{\"points\":[[0.5,0.5],[0.9,0.5],[0.9,0.701],[1,0.702],[1,0.701],[0.9,0.702],"
                 "[0.9,0.9],[0.5,0.9]]}"),
         "crosses itself"},
        /* a slit goes there and back and encloses nothing */
        {TRIMMED(HOLE ",{\"points\":[[0.5,0.5],[0.9,0.5],[0.9,0.9],[0.7,0.9],[0.7,0.6],[0.7,0.9],"
                      "[0.5,0.9]]}"),
         NULL},
    };
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        char request[2048], alone[2048];
        struct api_problem problem;
        (void)snprintf(request, sizeof request, "{\"surface\":{\"faces\":[%s,%s]},%s}", FLAT,
                       cases[k].face, FABRIC);
        (void)snprintf(alone, sizeof alone, "{\"surface\":%s,%s}", cases[k].face, FABRIC);
        if (!cases[k].words) {
            assert_int_equal(check_with(request, NULL, &problem), API_OK);
            assert_int_equal(check_with(alone, NULL, &problem), API_OK);
            continue;
        }
        assert_refused(request, NULL, API_INVALID_REQUEST, "/surface/faces/1/trims/1",
                       cases[k].words);
        assert_refused(alone, NULL, API_INVALID_REQUEST, "/surface/trims/1", "of the surface");
    }
}

static void test_faces_of_geomdl_are_one_surface(void **state) {
    (void)state;
    struct bytes container = {0};
    struct api_problem problem;
    assert_int_equal(
        run_text("{\"surface\":{\"shape\":{\"type\":\"surface\",\"count\":2,\"data\":[" FLAT
                 "," BESIDE "]}}," FABRIC "}",
                 &container, &problem),
        API_OK);
    bytes_free(&container);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_faces_that_cannot_be_one_surface_are_named),
        cmocka_unit_test(test_faces_selected_by_number),
        cmocka_unit_test(test_faces_grown_from_one),
        cmocka_unit_test(test_faces_are_described),
        cmocka_unit_test(test_faces_that_lie_on_each_other_are_not_joined),
        cmocka_unit_test(test_faces_of_a_file_are_stored_with_their_fault),
        cmocka_unit_test(test_faces_with_a_fault_are_joined_elsewhere),
        cmocka_unit_test(test_faces_with_a_bad_loop_are_named),
        cmocka_unit_test(test_faces_of_geomdl_are_one_surface),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
