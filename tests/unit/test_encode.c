/* SPDX-License-Identifier: MIT */
#include "api/format/format.h"

#include "support.h"
#include "tests/check.h"
#include <jansson.h>
#include <stdlib.h>
#include <string.h>

/* A fabric with everything, so that there is every column. */
static const char full_fabric[] =
    "\"fabric\":{\"spacing\":0.1,\"thickness\":0.002,\"fiber_volume_fraction\":0.5,"
    "\"locking_angle_deg\":20,\"plies\":2}";

/* The saddle, draped: one container for all tests. */
static struct bytes container;

static int drape_saddle(void **state) {
    (void)state;
    struct api_problem problem;
    struct bytes request =
        text_replace(request_text("saddle"), "\"fabric\":{\"spacing\":0.5}", full_fabric);
    if (run_text(request.data, &container, &problem) != API_OK)
        fail_msg("%s", problem.error[0].detail);
    bytes_free(&request);
    return 0;
}

static int forget_saddle(void **state) {
    (void)state;
    bytes_free(&container);
    return 0;
}

/* The whole document, asked for in pieces of `piece` bytes. */
static struct bytes encode_pieces(const char *format, const struct format_options *options,
                                  size_t piece) {
    struct api_reader reader = reader_over(&container);
    struct api_problem problem = {0};
    struct bytes text = {0};
    char *buffer = malloc(piece);
    ssize_t length;
    const struct format_source source = {.id = "abc", .reader = &reader, .queue_ms = 4};
    struct encoder *encoder =
        encoder_new(format_named(FORMAT_RESULT, format), &source, options, &problem);
    if (!encoder)
        fail_msg("%s", problem.error[0].detail);
    bytes_add(&text, "", 0);
    while ((length = encoder_read(encoder, buffer, piece)) > 0)
        bytes_add(&text, buffer, (size_t)length);
    assert_int_equal(length, 0);
    assert_int_equal(encoder_read(encoder, buffer, piece), 0);
    encoder_free(encoder);
    free(buffer);
    return text;
}

static struct bytes encode(const char *format, struct format_options options) {
    return encode_pieces(format, &options, 1 << 16);
}

static json_t *encode_json_tree(struct format_options options) {
    struct bytes text = encode("json", options);
    json_t *json = json_loadb(text.data, text.length, JSON_REJECT_DUPLICATES, NULL);
    assert_non_null(json);
    bytes_free(&text);
    return json;
}

static void open_container(struct api_columns *columns) {
    struct api_reader reader = reader_over(&container);
    struct api_problem problem = {0};
    assert_int_equal(api_columns_open(&reader, columns, &problem), API_OK);
}

static double *read_column(const struct api_column *column) {
    struct api_reader reader = reader_over(&container);
    double *values = calloc(column->rows + 1, sizeof *values);
    assert_true(api_columns_read(&reader, column, 0, column->rows, values));
    return values;
}

static void test_encode_json_is_the_contracts_document(void **state) {
    (void)state;
    json_t *json = encode_json_tree((struct format_options){0});
    static const char *const cells[] = {
        "i",        "j",      "shear_deg", "thickness", "fiber_volume_fraction",
        "porosity", "warp_x", "warp_y",    "warp_z",    "weft_x",
        "weft_y",   "weft_z", "locked"};
    static const char *const nodes[] = {"i", "j", "u", "v", "x", "y", "z", "shear_deg"};
    static const char *const front[] = {"i", "j", "reason"};
    double queue, spacing;
    json_t *grid, *tables[3];
    assert_int_equal(json_unpack(json, "{s:{s:{s:F}},s:o,s:o,s:o,s:o}", "summary", "timing_ms",
                                 "queue", &queue, "grid", &grid, "nodes", &tables[0], "cells",
                                 &tables[1], "front", &tables[2]),
                     0);
    assert_string_equal(json_string_value(json_object_get(json, "id")), "abc");
    assert_string_equal(json_string_value(json_object_get(json, "status")), "succeeded");
    assert_true(queue == 4);
    for (size_t i = 0; i < sizeof nodes / sizeof *nodes; i++)
        assert_true(json_is_array(json_object_get(tables[0], nodes[i])));
    for (size_t i = 0; i < sizeof cells / sizeof *cells; i++)
        assert_true(json_is_array(json_object_get(tables[1], cells[i])));
    for (size_t i = 0; i < sizeof front / sizeof *front; i++)
        assert_true(json_is_array(json_object_get(tables[2], front[i])));
    assert_int_equal(json_unpack(grid, "{s:[i,i],s:[i,i],s:[F,F]}", "warp", &(int){0}, &(int){0},
                                 "weft", &(int){0}, &(int){0}, "spacing", &spacing, &(double){0}),
                     0);
    assert_true(spacing == 0.1);
    json_decref(json);
}

static void test_encode_json_has_columns_of_equal_length(void **state) {
    (void)state;
    static const char *const tables[] = {"nodes", "cells", "front"};
    static const char *const counts[] = {"nodes", "cells"};
    json_t *json = encode_json_tree((struct format_options){0});
    json_t *summary = json_object_get(json, "summary");
    for (size_t t = 0; t < 3; t++) {
        json_t *table = json_object_get(json, tables[t]), *column;
        const char *name;
        size_t rows = json_array_size(json_object_get(table, "i"));
        check_above(rows, 0);
        json_object_foreach(table, name, column) {
            assert_int_equal(json_array_size(column), rows);
            for (size_t k = 0; k < rows; k++)
                assert_true(json_is_number(json_array_get(column, k)) ||
                            strcmp(name, "reason") == 0);
        }
        if (t < 2)
            assert_int_equal(json_integer_value(json_object_get(summary, counts[t])), rows);
    }
    json_decref(json);
}

static void test_encode_json_gives_back_every_bit(void **state) {
    (void)state;
    struct api_columns columns;
    open_container(&columns);
    json_t *json = encode_json_tree((struct format_options){0});
    for (size_t c = 0; c < columns.count; c++) {
        const struct api_column *column = &columns.column[c];
        if (column->table == API_TABLE_CUT) /* is not shown */
            continue;
        json_t *array =
            json_object_get(json_object_get(json, api_table_name(column->table)), column->name);
        double *values = read_column(column);
        for (size_t k = 0; k < column->rows; k++) {
            json_t *value = json_array_get(array, k);
            if (json_is_string(value))
                assert_string_equal(json_string_value(value),
                                    drape_reason_name((enum drape_reason)(int)values[k]));
            else
                assert_true(json_number_value(value) == values[k]);
            assert_true(!column->integer || !json_is_real(value));
        }
        free(values);
    }
    json_decref(json);
}

static void test_encode_documents_do_not_depend_on_the_size_of_the_reads(void **state) {
    (void)state;
    static const size_t pieces[] = {1, 7, 4096, 10000000};
    for (size_t f = 0; format_at(FORMAT_RESULT, f); f++) {
        const char *format = format_at(FORMAT_RESULT, f)->name;
        const struct format_options options = {0};
        struct bytes whole = encode(format, options);
        for (size_t k = 0; k < sizeof pieces / sizeof *pieces; k++) {
            struct bytes text = encode_pieces(format, &options, pieces[k]);
            assert_int_equal(text.length, whole.length);
            assert_memory_equal(text.data, whole.data, whole.length);
            bytes_free(&text);
        }
        bytes_free(&whole);
    }
}

static void test_encode_fields_sends_only_those(void **state) {
    (void)state;
    json_t *json =
        encode_json_tree((struct format_options){.fields = "cells.thickness,nodes.y,nodes.x"});
    json_t *nodes = json_object_get(json, "nodes");
    assert_int_equal(json_object_size(nodes), 2);
    check_above(json_array_size(json_object_get(nodes, "x")), 0);
    assert_int_equal(json_object_size(json_object_get(json, "cells")), 1);
    assert_int_equal(json_object_size(json_object_get(json, "front")), 0);
    assert_non_null(json_object_get(json, "summary"));
    json_decref(json);
}

static void refuse_fields(const char *format, const char *fields) {
    struct api_reader reader = reader_over(&container);
    struct api_problem problem = {0};
    const struct format_options options = {.fields = fields};
    const struct format_source source = {.id = "x", .reader = &reader};
    assert_null(encoder_new(format_named(FORMAT_RESULT, format), &source, &options, &problem));
    assert_int_equal(problem.id, API_INVALID_REQUEST);
}

static void test_encode_refuses_fields_that_are_not_there(void **state) {
    (void)state;
    refuse_fields("json", "nodes.w");
    refuse_fields("json", "nodes");
    refuse_fields("json", "nodes.x,");
    refuse_fields("json", ",");
    refuse_fields("json", "cells.k1");
    refuse_fields("json", "xnodes.x");
    refuse_fields("csv", "cells.shear_deg"); /* the table is nodes */
}

static void test_encode_precision_rounds_what_is_no_whole_number(void **state) {
    (void)state;
    struct api_columns columns;
    open_container(&columns);
    json_t *json = encode_json_tree((struct format_options){.precision = 3});
    json_t *x = json_object_get(json_object_get(json, "nodes"), "x");
    double *values = read_column(api_columns_find(&columns, API_TABLE_NODES, "x"));
    for (size_t k = 0; k < json_array_size(x); k++) {
        char rounded[32];
        snprintf(rounded, sizeof rounded, "%.3g", values[k]);
        assert_true(json_number_value(json_array_get(x, k)) == strtod(rounded, NULL));
    }
    free(values);
    json_decref(json);
}

/* The next field of a line, its end replaced by a zero. */
static char *take(char **text, char end) {
    char *field = *text;
    *text = strchr(field, end);
    assert_non_null(*text);
    *(*text)++ = '\0';
    return field;
}

static void check_csv(enum api_table table) {
    struct api_columns columns;
    open_container(&columns);
    struct bytes text = encode("csv", (struct format_options){.table = table, .table_given = true});
    double *values[API_COLUMNS_MAX];
    const struct api_column *of_table[API_COLUMNS_MAX];
    size_t count = 0;
    char *at = text.data;
    for (size_t c = 0; c < columns.count; c++)
        if (columns.column[c].table == table) {
            of_table[count] = &columns.column[c];
            values[count++] = read_column(&columns.column[c]);
        }
    for (size_t c = 0; c < count; c++)
        assert_string_equal(take(&at, c + 1 < count ? ',' : '\n'), of_table[c]->name);
    for (size_t row = 0; row < api_columns_rows(&columns, table); row++)
        for (size_t c = 0; c < count; c++)
            assert_true(strtod(take(&at, c + 1 < count ? ',' : '\n'), NULL) == values[c][row]);
    assert_int_equal(*at, '\0');
    for (size_t c = 0; c < count; c++)
        free(values[c]);
    bytes_free(&text);
}

static void test_encode_csv_is_a_line_of_names_and_a_line_for_each_row(void **state) {
    (void)state;
    check_csv(API_TABLE_NODES);
    check_csv(API_TABLE_CELLS);
}

static void test_encode_csv_fields_keep_the_order_of_the_table(void **state) {
    (void)state;
    struct bytes text = encode("csv", (struct format_options){.fields = "nodes.z,nodes.i,cells.j"});
    assert_memory_equal(text.data, "i,z\n", 4);
    bytes_free(&text);
}

#define NAME_63 "123456789 123456789 123456789 123456789 123456789 123456789 123"

static void test_encode_options_are_checked(void **state) {
    (void)state;
    static const struct {
        const char *name, *value;
        bool ok;
    } cases[] = {{"precision", "1", true},
                 {"precision", "17", true},
                 {"precision", "0", false},
                 {"precision", "18", false},
                 {"precision", "", false},
                 {"precision", "3x", false},
                 {"precision", " 3", false},
                 {"precision", "-3", false},
                 {"precision", "+3", false},
                 {"precision", "99999999999999999999", false},
                 {"table", "nodes", true},
                 {"table", "cells", true},
                 {"table", "front", false},
                 {"table", "", false},
                 {"fields", "nodes.x", true},
                 {"lcmsim_version", "2", true},
                 {"lcmsim_version", "3", true},
                 {"lcmsim_version", "1", false},
                 {"lcmsim_version", "4", false},
                 {"lcmsim_version", "22", false},
                 {"at_most_fiber_volume_fraction", "1e-300", true},
                 {"at_most_fiber_volume_fraction", "0.9999999999999999", true},
                 {"at_most_fiber_volume_fraction", "0", false},
                 {"at_most_fiber_volume_fraction", "1", false},
                 {"within", "0", true},
                 {"within", "10", true},
                 {"within", "10.000001", false},
                 {"within", "-1e-9", false},
                 {"within", "nan", false},
                 {"plies_as", "warp", true},
                 {"plies_as", "bisector", true},
                 {"plies_as", "weft", false},
                 {"allowance", "0", true},
                 {"allowance", "1e12", true},
                 {"allowance", "1.000001e12", false},
                 {"allowance", "-1", false},
                 {"partial", "0", true},
                 {"partial", "1", true},
                 {"partial", "2", false},
                 {"partial", "01", false},
                 {"partial", "", false},
                 {"part", NAME_63, true},
                 {"part", NAME_63 "x", false},
                 {"part", "a&b", false},
                 {"ply", "~ ok", true},
                 {"ply", "\x7f", false},
                 {"ply", "a\tb", false}};
    for (size_t i = 0; i < sizeof cases / sizeof *cases; i++) {
        struct format_options options = {0};
        struct api_problem problem = {0};
        assert_int_equal(format_option(&options, cases[i].name, cases[i].value, &problem),
                         cases[i].ok);
        assert_int_equal(problem.id, cases[i].ok ? API_OK : API_INVALID_REQUEST);
        if (!cases[i].ok)
            assert_non_null(strstr(problem.error[0].detail, cases[i].name));
    }
    struct format_options options = {0};
    struct api_problem problem = {0};
    assert_false(format_option(&options, "colour", "red", &problem));
    assert_int_equal(problem.id, API_OK);
}

static void test_encode_formats_are_found_by_name_and_media_type(void **state) {
    (void)state;
    assert_string_equal(format_at(FORMAT_RESULT, 0)->name, "json");
    for (size_t k = 0; format_at(FORMAT_RESULT, k); k++) {
        const struct format *format = format_at(FORMAT_RESULT, k);
        assert_ptr_equal(format_named(FORMAT_RESULT, format->name), format);
        assert_ptr_equal(format_for_media_type(FORMAT_RESULT, format->media_type), format);
    }
    assert_ptr_equal(format_for_media_type(FORMAT_RESULT, "TEXT/CSV"),
                     format_named(FORMAT_RESULT, "csv"));
    assert_null(format_named(FORMAT_RESULT, "JSON"));
    assert_null(format_named(FORMAT_RESULT, ""));
    assert_null(format_for_media_type(FORMAT_RESULT, "text/html"));
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_encode_json_is_the_contracts_document),
        cmocka_unit_test(test_encode_json_has_columns_of_equal_length),
        cmocka_unit_test(test_encode_json_gives_back_every_bit),
        cmocka_unit_test(test_encode_documents_do_not_depend_on_the_size_of_the_reads),
        cmocka_unit_test(test_encode_fields_sends_only_those),
        cmocka_unit_test(test_encode_refuses_fields_that_are_not_there),
        cmocka_unit_test(test_encode_precision_rounds_what_is_no_whole_number),
        cmocka_unit_test(test_encode_csv_is_a_line_of_names_and_a_line_for_each_row),
        cmocka_unit_test(test_encode_csv_fields_keep_the_order_of_the_table),
        cmocka_unit_test(test_encode_options_are_checked),
        cmocka_unit_test(test_encode_formats_are_found_by_name_and_media_type),
    };
    prepare();
    return cmocka_run_group_tests_name("encode", tests, drape_saddle, forget_saddle);
}
