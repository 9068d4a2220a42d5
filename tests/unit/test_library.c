/* SPDX-License-Identifier: MIT */
#include "library/drape.h"

#include "api/format/format.h"
#include "api/map/map.h"
#include "support.h"
#include "tests/check.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* The interface as it was released: a change of a type does not compile. What is added later comes
 * in lines of its own. */
const char *drape_version(void);
struct drape *drape_run(const char *, size_t, const char *, int (*)(void *, double), void *);
void drape_free(struct drape *);
const char *drape_problem(const struct drape *);
const char *drape_summary(struct drape *);
const double *drape_column(struct drape *, const char *, size_t *);
char *drape_document(struct drape *, const char *, const char *, size_t *);
char *drape_map(struct drape *, const char *, size_t, const char *, const char *, const char *,
                size_t *);
void drape_free_document(char *);

static struct drape *run_saddle(const char *options) {
    const char *request = request_text("saddle");
    struct drape *drape = drape_run(request, strlen(request), options, NULL, NULL);
    assert_non_null(drape);
    return drape;
}

static void assert_says(const struct drape *drape, const char *part) {
    const char *problem = drape_problem(drape);
    assert_non_null(problem);
    if (!strstr(problem, part))
        fail_msg("%s is not in %s", part, problem);
}

/* Columns and documents have the bits of what the service stores and sends. */
static void test_library_has_the_bits_of_the_service(void **state) {
    (void)state;
    struct bytes container = {0};
    struct api_problem problem;
    static struct api_columns columns;
    struct drape *drape = run_saddle("threads=2");
    assert_int_equal(run_text(request_text("saddle"), &container, &problem), API_OK);
    struct api_reader reader = reader_over(&container);
    assert_int_equal(api_columns_open(&reader, &columns, &problem), API_OK);
    check_above(columns.count, 30);
    for (size_t k = 0; k < columns.count; k++) {
        const struct api_column *column = &columns.column[k];
        char name[2 * API_COLUMN_NAME_SIZE];
        size_t count = 1;
        double *wanted = calloc(column->rows + 1, sizeof *wanted);
        snprintf(name, sizeof name, "%s.%s", api_table_name(column->table), column->name);
        const double *values = drape_column(drape, name, &count);
        assert_non_null(values);
        assert_int_equal(count, column->rows);
        assert_true(api_columns_read(&reader, column, 0, count, wanted));
        assert_memory_equal(values, wanted, count * sizeof *wanted);
        assert_ptr_equal(drape_column(drape, name, NULL), values);
        free(wanted);
    }
    const struct format_options options = {.precision = 6};
    const struct format_source source = {.id = "", .reader = &reader};
    static char text[1 << 16];
    struct encoder *encoder =
        encoder_new(format_named(FORMAT_RESULT, "csv"), &source, &options, &problem);
    size_t length;
    char *document = drape_document(drape, "csv", "precision=6", &length);
    assert_non_null(document);
    assert_int_equal(strlen(document), length);
    size_t at = 0;
    for (ssize_t piece; (piece = encoder_read(encoder, text, sizeof text)) > 0; at += (size_t)piece)
        assert_memory_equal(document + at, text, (size_t)piece);
    assert_int_equal(at, length);
    encoder_free(encoder);
    drape_free_document(document);
    assert_non_null(strstr(drape_summary(drape), "\"solver_version\":\"" DRAPE_VERSION "\""));
    assert_string_equal(drape_version(), DRAPE_VERSION);
    assert_null(drape_problem(drape));
    drape_free(drape);
    bytes_free(&container);
}

static void test_library_tells_where_a_request_is_wrong(void **state) {
    (void)state;
    struct bytes text =
        text_replace(request_text("saddle"), "{\"surface\"", "{\"methode\":\"gib\",\"surface\"");
    struct drape *drape = drape_run(text.data, text.length, NULL, NULL, NULL);
    size_t count = 7;
    assert_says(drape, "/problems/invalid-request");
    assert_says(drape, "\"/methode\"");
    /* All that is asked of it has that answer. */
    assert_null(drape_column(drape, "nodes.x", &count));
    assert_int_equal(count, 0);
    assert_null(drape_summary(drape));
    assert_null(drape_document(drape, "json", NULL, NULL));
    assert_null(drape_map(drape, "", 0, "json", "json", NULL, NULL));
    assert_says(drape, "\"/methode\"");
    drape_free(drape);
    drape_free(NULL);
    drape = drape_run(NULL, 0, NULL, NULL, NULL);
    assert_says(drape, "/problems/malformed-json");
    drape_free(drape);
    bytes_free(&text);
}

static void test_library_refuses_options_it_does_not_know(void **state) {
    (void)state;
    static const char *const wrong[][2] = {{"thread=2", "thread is no option here"},
                                           {"threads", "threads must be followed by ="},
                                           {"threads=0", "threads must be a whole number"},
                                           {"max_nodes=+9", "max_nodes must be a whole number"},
                                           {"max_memory=-1", "max_memory must be a whole number"}};
    for (size_t k = 0; k < sizeof wrong / sizeof *wrong; k++) {
        struct drape *drape = run_saddle(wrong[k][0]);
        assert_says(drape, wrong[k][1]);
        drape_free(drape);
    }
    struct drape *drape = run_saddle("max_nodes=10&threads=1");
    assert_says(drape, "119 nodes, and 10 are allowed");
    drape_free(drape);
    char longest[5000];
    memset(longest, '&', sizeof longest - 1);
    longest[sizeof longest - 1] = '\0';
    drape = run_saddle(longest);
    assert_says(drape, "less than 4096");
    drape_free(drape);
    longest[4095] = '\0'; /* empty ones between are nothing */
    drape = run_saddle(longest);
    assert_null(drape_problem(drape));
    /* After a call that failed the next one may be right. */
    assert_null(drape_document(drape, "cvs", NULL, NULL));
    assert_says(drape, "no format cvs; there are json csv vtp glb npz svg dxf");
    assert_null(drape_document(drape, "csv", "precision=18", NULL));
    assert_says(drape, "precision must be a whole number from 1 to 17");
    assert_null(drape_document(drape, "csv", "inlet=1", NULL));
    assert_says(drape, "inlet is no option here");
    assert_null(drape_column(drape, "nodes.shear", NULL));
    assert_says(drape, "no column nodes.shear; there are nodes.i nodes.j");
    assert_null(drape_column(drape, "", NULL));
    assert_says(drape, "there are nodes cells front rim");
    assert_non_null(drape_column(drape, "rim.p", NULL));
    assert_null(drape_problem(drape));
    drape_free(drape);
}

/* ---- progress ---- */

static int stop_at_a_half(void *seen, double fraction) {
    *(double *)seen = fraction;
    return fraction >= 0.5;
}

static void test_library_stops_when_the_caller_wants(void **state) {
    (void)state;
    struct bytes text = text_replace(request_text("saddle"), "\"spacing\":0.5", "\"spacing\":0.02");
    double seen = -1;
    struct drape *drape = drape_run(text.data, text.length, NULL, stop_at_a_half, &seen);
    assert_says(drape, "/problems/cancelled");
    check_above(seen, 0.499);
    check_below(seen, 1);
    drape_free(drape);
    bytes_free(&text);
}

/* ---- maps ---- */

static void test_library_maps_onto_meshes(void **state) {
    (void)state;
    static const char points[] = "{\"points\": [[0, 0, 0], [0.3, -0.2, 0.02]]}",
                      bulk[] = "GRID,7,,0.0,0.0,0.0\nGRID,8,,0.1,0.0,0.0\nGRID,9,,0.0,0.1,0.0\n"
                               "CTRIA3,41,3,7,8,9\n";
    struct drape *drape = run_saddle(NULL);
    size_t length;
    char *document =
        drape_map(drape, points, strlen(points), "json", "csv", "fields=k1,shear_deg", &length);
    assert_null(document); /* the request has no permeability */
    assert_says(drape, "k1");
    document = drape_map(drape, points, strlen(points), "json", "csv", "fields=shear_deg", &length);
    assert_non_null(document);
    assert_int_equal(strlen(document), length);
    double shear[2];
    assert_int_equal(sscanf(document, "shear_deg %lf %lf", &shear[0], &shear[1]), 2);
    check_below(fabs(shear[0]), 0.5); /* by symmetry none */
    drape_free_document(document);
    document = drape_map(drape, bulk, strlen(bulk), "nastran", "json", "reference=1,0,0", &length);
    assert_non_null(document);
    assert_non_null(strstr(document, "\"id\":[41]"));
    drape_free_document(document);
    assert_null(drape_map(drape, points, strlen(points), "json", "vtu", NULL, NULL));
    assert_says(drape, "vtu needs elements");
    assert_null(drape_map(drape, bulk, strlen(bulk), "step", "vtu", NULL, NULL));
    assert_says(drape, "/problems/unsupported-media-type");
    assert_null(drape_map(drape, bulk, 30, "nastran", "vtu", NULL, NULL));
    assert_says(drape, "line 2: GRID ends");
    drape_free(drape);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_library_has_the_bits_of_the_service),
        cmocka_unit_test(test_library_tells_where_a_request_is_wrong),
        cmocka_unit_test(test_library_refuses_options_it_does_not_know),
        cmocka_unit_test(test_library_stops_when_the_caller_wants),
        cmocka_unit_test(test_library_maps_onto_meshes),
    };
    return cmocka_run_group_tests(tests, NULL, NULL);
}
