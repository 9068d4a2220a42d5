/* SPDX-License-Identifier: MIT */
#include "api/result/columns.h"

#include "api/format/format.h"
#include "support.h"
#include "tests/check.h"
#include <jansson.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { ROWS = 10003 }; /* more than one block of the writer, and no multiple of four */

static bool fill_values(const void *context, size_t first, size_t count, double *values) {
    memcpy(values, (const double *)context + first, count * sizeof *values);
    return true;
}

/* A container with two tables, and what went into it. */
struct sample {
    double node[ROWS], index[ROWS], reason[3];
    struct api_columns header;
    struct bytes container;
    struct api_reader reader;
};

static const size_t source_count = 3;

static void list_sources(const struct sample *sample, struct api_column_source source[3]) {
    source[0] =
        (struct api_column_source){API_TABLE_NODES, "x", false, ROWS, fill_values, sample->node};
    source[1] =
        (struct api_column_source){API_TABLE_NODES, "i", true, ROWS, fill_values, sample->index};
    source[2] =
        (struct api_column_source){API_TABLE_FRONT, "reason", true, 3, fill_values, sample->reason};
}

static enum api_problem_id write_sample(struct sample *sample, size_t budget,
                                        struct api_problem *problem) {
    struct api_column_source source[3];
    struct arena *arena = arena_new(budget);
    struct api_sink sink = sink_into(&sample->container);
    list_sources(sample, source);
    size_t held = arena_held(arena);
    *problem = (struct api_problem){0};
    enum api_problem_id id =
        api_columns_write(&sample->header, source, source_count, &sink, arena, problem);
    assert_int_equal(arena_held(arena), held);
    arena_free(arena);
    return id;
}

static struct sample *sample_new(struct random *random) {
    struct sample *sample = calloc(1, sizeof *sample);
    assert_non_null(sample);
    sample->header = (struct api_columns){
        .summary = {.outcome = DRAPE_PARTIAL,
                    .nodes = ROWS,
                    .coverage = 1.0 / 3,
                    .max_shear_deg = 12.5,
                    .locked_cells = 4,
                    .error_estimate_max = -1,
                    .max_shear_error_deg = -1,
                    .thickness_error_max = -1,
                    .front_reasons = {[DRAPE_REASON_COLLAPSED] = 3},
                    .solve_ms = 0.25,
                    .solver_version = "9.9"},
        .grid = {.warp = {-5, 6}, .weft = {0, 7}, .spacing = {0.1, 0.2}},
        .start = {.uv = {0.25, 0.75}, .point = {1, 2, 3}, .warp = {1, 0, 0}, .weft = {0, 1, 0}}};
    for (int k = 0; k < ROWS; k++) {
        sample->node[k] = random_between(random, -1e3, 1e3);
        sample->index[k] = k - ROWS / 2;
    }
    sample->reason[1] = DRAPE_REASON_COUNT - 1;
    sample->reader = reader_over(&sample->container);
    return sample;
}

static void sample_free(struct sample *sample) {
    bytes_free(&sample->container);
    free(sample);
}

static void test_columns_read_back_what_was_written(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    struct sample *sample = sample_new(&random);
    struct api_problem problem;
    struct api_columns columns;
    assert_int_equal(write_sample(sample, 1 << 20, &problem), API_OK);
    assert_int_equal(api_columns_open(&sample->reader, &columns, &problem), API_OK);
    assert_int_equal(columns.length, sample->container.length);
    assert_int_equal(columns.summary.outcome, DRAPE_PARTIAL);
    assert_int_equal(columns.summary.nodes, ROWS);
    assert_true(columns.summary.coverage == 1.0 / 3);
    check_below(columns.summary.error_estimate_max, 0);
    assert_int_equal(columns.summary.front_reasons[DRAPE_REASON_COLLAPSED], 3);
    assert_string_equal(columns.summary.solver_version, "9.9");
    assert_memory_equal(&columns.grid, &sample->header.grid, sizeof columns.grid);
    assert_memory_equal(&columns.start, &sample->header.start, sizeof columns.start);
    assert_int_equal(api_columns_rows(&columns, API_TABLE_NODES), ROWS);
    assert_int_equal(api_columns_rows(&columns, API_TABLE_CELLS), 0);
    sample_free(sample);
}

static void test_columns_give_any_run_of_rows(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    struct sample *sample = sample_new(&random);
    struct api_problem problem;
    struct api_columns columns;
    assert_int_equal(write_sample(sample, 1 << 20, &problem), API_OK);
    assert_int_equal(api_columns_open(&sample->reader, &columns, &problem), API_OK);
    const struct api_column *x = api_columns_find(&columns, API_TABLE_NODES, "x");
    const struct api_column *i = api_columns_find(&columns, API_TABLE_NODES, "i");
    assert_non_null(x);
    assert_true(i && i->integer && !x->integer);
    assert_null(api_columns_find(&columns, API_TABLE_CELLS, "x"));
    assert_int_equal(x->offset % 8, 0);
    for (int round = 0; round < 200; round++) {
        double values[ROWS];
        size_t first = (size_t)random_index(&random, ROWS);
        size_t count = (size_t)random_index(&random, (int)(ROWS - first) + 1);
        assert_true(api_columns_read(&sample->reader, x, first, count, values));
        assert_memory_equal(values, sample->node + first, count * sizeof *values);
        assert_true(api_columns_read(&sample->reader, i, first, count, values));
        assert_memory_equal(values, sample->index + first, count * sizeof *values);
    }
    sample_free(sample);
}

static void test_columns_are_little_endian_doubles_behind_the_directory(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    struct sample *sample = sample_new(&random);
    struct api_problem problem;
    sample->node[0] = -2.5;
    assert_int_equal(write_sample(sample, 1 << 20, &problem), API_OK);
    const unsigned char *bytes = (const unsigned char *)sample->container.data;
    size_t length = bytes[12] + 256u * bytes[13];
    static const unsigned char value[8] = {0, 0, 0, 0, 0, 0, 0x04, 0xc0};
    assert_memory_equal(bytes, "DRAPECOL\2\0\0\0", 12);
    assert_memory_equal(bytes + 16 + length, value, 8);
    json_t *directory = json_loadb(sample->container.data + 16, length, 0, NULL);
    assert_non_null(directory);
    assert_int_equal(json_array_size(json_object_get(directory, "columns")), source_count);
    json_decref(directory);
    sample_free(sample);
}

/* A column of the table nodes that is written, read in two runs and compared bit by bit. */
static void check_form(const double *values, size_t rows, bool integer, enum api_form form,
                       size_t bytes) {
    static double back[ROWS];
    const struct api_column_source source = {API_TABLE_NODES, "x",   integer, rows,
                                             fill_values,     values};
    struct api_columns header = {.summary.solver_version = "1"}, columns;
    struct bytes container = {0};
    struct api_reader reader = reader_over(&container);
    struct api_sink sink = sink_into(&container);
    struct api_problem problem = {0};
    struct arena *arena = arena_new(1 << 20);
    assert_int_equal(api_columns_write(&header, &source, 1, &sink, arena, &problem), API_OK);
    assert_int_equal(api_columns_open(&reader, &columns, &problem), API_OK);
    const struct api_column *column = &columns.column[0];
    assert_int_equal(column->form, form);
    assert_int_equal(columns.length - column->offset, bytes);
    assert_int_equal(columns.length, container.length);
    assert_true(api_columns_whole(&reader, &columns));
    assert_true(api_columns_read(&reader, column, 0, rows / 3, back));
    assert_true(api_columns_read(&reader, column, rows / 3, rows - rows / 3, back + rows / 3));
    assert_memory_equal(back, values, rows * sizeof *back);
    container.length--;
    assert_true(rows == 0 || !api_columns_whole(&reader, &columns));
    arena_free(arena);
    bytes_free(&container);
}

static void test_columns_take_the_bytes_that_their_values_need(void **state) {
    (void)state;
    static const struct {
        double value, last; /* of all rows but the last, and of that one */
        bool integer;
        enum api_form form;
        size_t bytes; /* of 9999 rows */
    } cases[] = {
        {0.5, 0.5, false, API_FORM_REPEATED, 8},
        {0.0, -0.0, false, API_FORM_FLOAT64, 8 * 9999},
        {0.5, 0.25, false, API_FORM_FLOAT64, 8 * 9999},
        {7, 7, true, API_FORM_REPEATED, 8},
        {0, 1, false, API_FORM_FLOAT64, 8 * 9999},
        {-128, 127, true, API_FORM_INT8, 10000},
        {0, 128, true, API_FORM_INT16, 20000},
        {-129, 0, true, API_FORM_INT16, 20000},
        {-32768, 32767, true, API_FORM_INT16, 20000},
        {0, 32768, true, API_FORM_INT32, 40000},
        {-INT32_MAX, INT32_MAX, true, API_FORM_INT32, 40000},
        {0, 0x1p31, true, API_FORM_FLOAT64, 8 * 9999},
        {0.0, -0.0, true, API_FORM_FLOAT64, 8 * 9999},
    };
    static double values[9999];
    for (size_t k = 0; k < sizeof cases / sizeof *cases; k++) {
        for (size_t i = 0; i < 9999; i++)
            values[i] = i < 9998 ? cases[k].value : cases[k].last;
        check_form(values, 9999, cases[k].integer, cases[k].form, cases[k].bytes);
    }
    check_form(values, 0, true, API_FORM_FLOAT64, 0);
    check_form(values, 1, true, API_FORM_FLOAT64, 8);
}

/* A column of whole numbers in which something else is found is damaged. */
static void test_columns_of_whole_numbers_hold_nothing_else(void **state) {
    static const double stored[] = {0, 0x1p31}, damaged[] = {0.5, -0x1p53 - 2, NAN};
    const struct api_column_source source = {API_TABLE_NODES, "x", true, 2, fill_values, stored};
    struct api_columns header = {.summary.solver_version = "1"}, columns;
    struct bytes container = {0};
    struct api_reader reader = reader_over(&container);
    struct api_sink sink = sink_into(&container);
    struct api_problem problem = {0};
    struct arena *arena = arena_new(1 << 20);
    double back[2];
    (void)state;
    assert_int_equal(api_columns_write(&header, &source, 1, &sink, arena, &problem), API_OK);
    assert_int_equal(api_columns_open(&reader, &columns, &problem), API_OK);
    assert_true(api_columns_read(&reader, &columns.column[0], 0, 2, back));
    for (size_t k = 0; k < sizeof damaged / sizeof *damaged; k++) {
        memcpy(container.data + columns.column[0].offset, &damaged[k], sizeof damaged[k]);
        assert_false(api_columns_read(&reader, &columns.column[0], 0, 2, back));
    }
    arena_free(arena);
    bytes_free(&container);
}

/* As it was before columns had forms: all that differs is the version. */
static void test_columns_of_version_1_are_read(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    struct sample *sample = sample_new(&random);
    struct api_problem problem;
    struct api_columns columns;
    double values[ROWS];
    for (int k = 0; k < ROWS; k++)
        sample->index[k] = k * 0x1p36;
    sample->reason[0] = 0x1p36;
    assert_int_equal(write_sample(sample, 1 << 20, &problem), API_OK);
    assert_null(memmem(sample->container.data, sample->container.length, "form", 4));
    sample->container.data[8] = 1;
    assert_int_equal(api_columns_open(&sample->reader, &columns, &problem), API_OK);
    assert_true(api_columns_read(&sample->reader, &columns.column[1], 0, ROWS, values));
    assert_memory_equal(values, sample->index, sizeof values);
    sample->container.data[8] = 3;
    assert_int_equal(api_columns_open(&sample->reader, &columns, &problem), API_INTERNAL);
    sample_free(sample);
}

/* The list of columns is read as it is written, or not at all. */
static void test_columns_of_a_damaged_list_are_refused(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    struct sample *sample = sample_new(&random);
    struct api_problem problem;
    struct api_columns columns;
    assert_int_equal(write_sample(sample, 1 << 20, &problem), API_OK);
    char *bytes = sample->container.data;
    char *list = memmem(bytes, sample->container.length, ",\"columns\":[", 12);
    char *end = bytes + sample->header.column[0].offset;
    assert_non_null(list);
    for (char *at = list; at < end; at++) {
        char whole = *at;
        *at = '?';
        assert_int_equal(api_columns_open(&sample->reader, &columns, &problem), API_INTERNAL);
        *at = whole;
    }
    assert_int_equal(api_columns_open(&sample->reader, &columns, &problem), API_OK);
    char *rows = memmem(list, (size_t)(end - list), "\"rows\":", 7);
    rows[7] ^= 1; /* not as many as the next column of the table has */
    assert_int_equal(api_columns_open(&sample->reader, &columns, &problem), API_INTERNAL);
    sample_free(sample);
}

/* A repeated value needs no bytes a row, but the rows must be there all the same. */
static void test_columns_that_are_not_whole_are_not_encoded(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    struct sample *sample = sample_new(&random);
    struct api_problem problem;
    for (int k = 0; k < ROWS; k++)
        sample->index[k] = 5;
    assert_int_equal(write_sample(sample, 1 << 20, &problem), API_OK);
    const struct format_source source = {.id = "0", .reader = &sample->reader};
    const struct format_options options = {.fields = "nodes.i"};
    struct encoder *encoder =
        encoder_new(format_named(FORMAT_RESULT, "json"), &source, &options, &problem);
    assert_non_null(encoder);
    encoder_free(encoder);
    sample->container.length = (size_t)sample->header.column[2].offset;
    assert_null(encoder_new(format_named(FORMAT_RESULT, "json"), &source, &options, &problem));
    assert_int_equal(problem.id, API_INTERNAL);
    sample_free(sample);
}

static void test_columns_refuse_values_that_are_no_numbers(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    struct sample *sample = sample_new(&random);
    struct api_problem problem;
    sample->node[ROWS - 1] = NAN;
    assert_int_equal(write_sample(sample, 1 << 20, &problem), API_INTERNAL);
    assert_non_null(strstr(problem.error[0].detail, "nodes.x"));
    sample->node[ROWS - 1] = 0;
    sample->header.summary.coverage = INFINITY;
    assert_int_equal(write_sample(sample, 1 << 20, &problem), API_INTERNAL);
    sample_free(sample);
}

static bool refuse(void *context, const void *bytes, size_t length) {
    (void)bytes;
    size_t *left = context;
    bool taken = length <= *left;
    *left -= taken ? length : 0;
    return taken;
}

static void test_columns_stop_when_the_sink_refuses(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    struct sample *sample = sample_new(&random);
    struct api_column_source source[3];
    list_sources(sample, source);
    for (size_t room = 0; room < 100000; room += 10000) {
        size_t left = room;
        struct api_problem problem = {0};
        struct arena *arena = arena_new(1 << 20);
        struct api_sink sink = {.write = refuse, .context = &left};
        assert_int_equal(
            api_columns_write(&sample->header, source, source_count, &sink, arena, &problem),
            API_CANCELLED);
        arena_free(arena);
    }
    sample_free(sample);
}

static bool keep_text(void *context, const char *json) {
    *(char **)context = strdup(json);
    return true;
}

static bool write_nothing(void *context, const void *bytes, size_t length) {
    (void)context, (void)bytes, (void)length;
    return true;
}

static bool refuse_text(void *context, const char *json) {
    (void)context, (void)json;
    return false;
}

/* What the sink is told is what a reader finds. */
static void test_columns_tell_their_summary(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    struct sample *sample = sample_new(&random);
    struct api_column_source source[3];
    struct api_problem problem;
    struct api_columns found;
    char *told = NULL;
    list_sources(sample, source);
    assert_int_equal(write_sample(sample, 1 << 20, &problem), API_OK);
    assert_int_equal(api_columns_open(&sample->reader, &found, &problem), API_OK);
    char *wanted = api_columns_summary_json(&found);
    struct arena *arena = arena_new(1 << 20);
    struct api_sink sink = {.write = write_nothing, .context = &told, .summary = keep_text};
    assert_int_equal(
        api_columns_write(&sample->header, source, source_count, &sink, arena, &problem), API_OK);
    assert_string_equal(told, wanted);
    sink.summary = refuse_text;
    assert_int_equal(
        api_columns_write(&sample->header, source, source_count, &sink, arena, &problem),
        API_CANCELLED);
    arena_free(arena);
    free(told);
    free(wanted);
    sample_free(sample);
}

static void test_columns_report_missing_memory_and_too_many(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    struct sample *sample = sample_new(&random);
    struct api_problem problem;
    assert_int_equal(write_sample(sample, 100, &problem), API_OUT_OF_MEMORY);
    struct api_column_source many[API_COLUMNS_MAX + 1] = {{0}};
    struct api_sink sink = sink_into(&sample->container);
    struct arena *arena = arena_new(1 << 20);
    problem = (struct api_problem){0};
    assert_int_equal(
        api_columns_write(&sample->header, many, API_COLUMNS_MAX + 1, &sink, arena, &problem),
        API_INTERNAL);
    arena_free(arena);
    sample_free(sample);
}

/* These draw a net, which the samples are not. */
static bool needs_net(const struct format *format) {
    const char *name = format->name;
    return strcmp(name, "vtp") == 0 || strcmp(name, "glb") == 0;
}

/* Reads a container whatever is in it, to the end of every document; true when it was sound. */
static bool read_everything(struct bytes *container) {
    static char buffer[1 << 16];
    struct api_reader reader = reader_over(container);
    bool sound = true;
    for (size_t k = 0; format_at(FORMAT_RESULT, k); k++) {
        struct api_problem problem = {0};
        const struct format_source source = {.id = "0", .reader = &reader};
        struct encoder *encoder = encoder_new(format_at(FORMAT_RESULT, k), &source,
                                              &(struct format_options){0}, &problem);
        ssize_t length = encoder ? 1 : -1;
        for (int pieces = 0; encoder && length > 0 && pieces < 100; pieces++)
            length = encoder_read(encoder, buffer, sizeof buffer);
        sound = sound && (length == 0 || needs_net(format_at(FORMAT_RESULT, k)));
        assert_true(encoder || problem.id != API_OK);
        encoder_free(encoder);
    }
    return sound;
}

static void test_columns_cut_anywhere_are_damaged(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    struct sample *sample = sample_new(&random);
    struct api_problem problem;
    struct api_columns columns;
    assert_int_equal(write_sample(sample, 1 << 20, &problem), API_OK);
    assert_true(read_everything(&sample->container));
    size_t header = (size_t)(sample->header.column[0].offset);
    for (size_t length = 0; length < header; length += 7) {
        sample->container.length = length;
        problem = (struct api_problem){0};
        assert_int_equal(api_columns_open(&sample->reader, &columns, &problem), API_INTERNAL);
    }
    sample->container.length = header + 8;
    assert_false(read_everything(&sample->container));
    sample_free(sample);
}

static void test_columns_survive_a_corrupted_header(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    struct sample *sample = sample_new(&random);
    struct api_problem problem;
    assert_int_equal(write_sample(sample, 1 << 20, &problem), API_OK);
    size_t header = (size_t)(sample->header.column[0].offset);
    for (int round = 0; round < 3000; round++) {
        struct bytes copy = {0};
        bytes_add(&copy, sample->container.data, sample->container.length);
        for (int hits = 1 + random_index(&random, 4); hits > 0; hits--) {
            size_t at = (size_t)random_index(&random, (int)header);
            copy.data[at] = round % 2 ? (char)random_index(&random, 256)
                                      : "0123456789-.eE{}[],:\"\\"[random_index(&random, 22)];
        }
        read_everything(&copy);
        bytes_free(&copy);
    }
    sample_free(sample);
}

/* The promise of the writer, that every value is a number, is not taken on trust. */
static void test_columns_refuse_to_read_values_that_are_no_numbers(void **state) {
    (void)state;
    struct random random = random_begin(__func__);
    struct sample *sample = sample_new(&random);
    struct api_problem problem;
    const double bad[] = {NAN, INFINITY, -INFINITY};
    const size_t places[] = {0, 1, 2, 3, ROWS - 3, ROWS - 2, ROWS - 1};
    const char no_reason[] = {-1, DRAPE_REASON_COUNT, 127};
    assert_int_equal(write_sample(sample, 1 << 20, &problem), API_OK);
    assert_true(read_everything(&sample->container));
    char *x = sample->container.data + sample->header.column[0].offset;
    char *reason = sample->container.data + sample->header.column[2].offset;
    assert_int_equal(sample->header.column[2].form, API_FORM_INT8);
    for (size_t k = 0; k < sizeof bad / sizeof *bad; k++) {
        for (size_t n = 0; n < sizeof places / sizeof *places; n++) {
            char *at = x + places[n] * sizeof(double);
            double good;
            memcpy(&good, at, sizeof good);
            memcpy(at, &bad[k], sizeof bad[k]);
            assert_false(read_everything(&sample->container));
            memcpy(at, &good, sizeof good);
        }
        *reason = no_reason[k];
        assert_false(read_everything(&sample->container));
        *reason = 0;
    }
    assert_true(read_everything(&sample->container));
    sample_free(sample);
}

static void test_columns_summary_json_is_the_contracts(void **state) {
    (void)state;
    struct api_columns columns = {.summary = {.outcome = DRAPE_COMPLETE,
                                              .nodes = 12,
                                              .error_estimate_max = 0.5,
                                              .front_reasons = {[DRAPE_REASON_FOLD] = 2},
                                              .solve_ms = 7,
                                              .solver_version = "1"}};
    char *text = api_columns_summary_json(&columns);
    json_t *json = json_loads(text, 0, NULL);
    static const char *const keys[] = {"outcome",
                                       "nodes",
                                       "cells",
                                       "coverage",
                                       "max_shear_deg",
                                       "mean_shear_deg",
                                       "locked_cells",
                                       "packing_exceeded_cells",
                                       "residual_max",
                                       "newton_iterations_mean",
                                       "error_estimate_max",
                                       "front_reasons",
                                       "timing_ms",
                                       "solver_version"};
    double queue, solve;
    int folds, boundaries;
    for (size_t i = 0; i < sizeof keys / sizeof *keys; i++)
        assert_non_null(json_object_get(json, keys[i]));
    assert_int_equal(json_unpack(json, "{s:{s:F,s:F},s:{s:i,s:i}}", "timing_ms", "queue", &queue,
                                 "solve", &solve, "front_reasons", "fold", &folds, "boundary",
                                 &boundaries),
                     0);
    assert_true(queue == 0 && solve == 7 && folds == 2 && boundaries == 0);
    json_decref(json);
    free(text);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_columns_read_back_what_was_written),
        cmocka_unit_test(test_columns_give_any_run_of_rows),
        cmocka_unit_test(test_columns_are_little_endian_doubles_behind_the_directory),
        cmocka_unit_test(test_columns_take_the_bytes_that_their_values_need),
        cmocka_unit_test(test_columns_of_whole_numbers_hold_nothing_else),
        cmocka_unit_test(test_columns_of_version_1_are_read),
        cmocka_unit_test(test_columns_of_a_damaged_list_are_refused),
        cmocka_unit_test(test_columns_that_are_not_whole_are_not_encoded),
        cmocka_unit_test(test_columns_refuse_values_that_are_no_numbers),
        cmocka_unit_test(test_columns_stop_when_the_sink_refuses),
        cmocka_unit_test(test_columns_tell_their_summary),
        cmocka_unit_test(test_columns_report_missing_memory_and_too_many),
        cmocka_unit_test(test_columns_cut_anywhere_are_damaged),
        cmocka_unit_test(test_columns_survive_a_corrupted_header),
        cmocka_unit_test(test_columns_refuse_to_read_values_that_are_no_numbers),
        cmocka_unit_test(test_columns_summary_json_is_the_contracts),
    };
    prepare();
    return cmocka_run_group_tests_name("columns", tests, NULL, NULL);
}
