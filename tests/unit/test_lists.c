/* SPDX-License-Identifier: MIT */
/* The lists of columns, members of the summary and formats, and that docs/fields.md and
 * docs/formats.md show what they say. Where they do not, DRAPE_GOLDEN=write puts the tables there.
 */
#include "api/format/format.h"
#include "api/json/text.h"
#include "api/result/column_list.h"
#include "api/result/result_header.h"

#include "support.h"
#include "tests/check.h"
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static void add(struct bytes *text, const char *string) {
    bytes_add(text, string, strlen(string));
}

static void add_cell(struct bytes *table, const char *string) {
    add(table, *string ? " " : "");
    add(table, string);
    add(table, " |");
}

/* `i`, or `warp_x`, `warp_y`, `warp_z`. */
static void add_names(struct bytes *table, const struct column_spec *spec) {
    add(table, "|");
    for (int k = 0; k < spec->parts; k++) {
        add(table, k ? ", `" : " `");
        add(table, spec->part[k]);
        add(table, "`");
    }
    add(table, " |");
}

static struct bytes columns_table(enum api_table of) {
    struct bytes table = {0};
    add(&table, "| column | kind | unit | meaning | needs |\n|---|---|---|---|---|\n");
    for (int id = 0; id < COLUMN_COUNT; id++) {
        const struct column_spec *spec = &column_specs[id];
        if (spec->table != of)
            continue;
        add_names(&table, spec);
        add_cell(&table, column_kind_names[spec->kind]);
        add_cell(&table, spec->unit);
        add_cell(&table, spec->meaning);
        add_cell(&table, column_need_names[spec->need]);
        add(&table, "\n");
    }
    return table;
}

static struct bytes summary_table(void) {
    struct bytes table = {0};
    add(&table, "| member | meaning |\n|---|---|\n");
    for (size_t k = 0; k < summary_member_count; k++) {
        add(&table, "| `");
        add(&table, summary_members[k].key);
        add(&table, "` |");
        add_cell(&table, summary_members[k].meaning);
        add(&table, "\n");
    }
    return table;
}

static struct bytes formats_table(void) {
    static const struct {
        enum format_use use;
        const char *name;
    } uses[] = {{FORMAT_RESULT, "result"},
                {FORMAT_MAP, "map"},
                {FORMAT_PATTERN, "pattern"},
                {FORMAT_REPORT, "report"},
                {FORMAT_LASER, "laser lines"},
                {FORMAT_BUNDLE, "bundle"},
                {FORMAT_BOOK, "report of a laminate"}};
    const struct format *format;
    struct bytes table = {0};
    add(&table, "| of | format | media type | what it is | exact |\n|---|---|---|---|---|\n");
    for (size_t u = 0; u < sizeof uses / sizeof *uses; u++)
        for (size_t k = 0; (format = format_at(uses[u].use, k)); k++) {
            add(&table, "| ");
            add(&table, uses[u].name);
            add(&table, " | `");
            add(&table, format->name);
            add(&table, "` | `");
            add(&table, format->media_type);
            add(&table, "` |");
            add_cell(&table, format->about);
            add_cell(&table, format->exact);
            add(&table, "\n");
        }
    return table;
}

/* Compares what a page has between the marks of a table, or replaces it. */
static void check_documented(const char *path, const char *name, struct bytes *table) {
    static const char end_mark[] = "<!-- end -->";
    char mark[64];
    const char *mode = getenv("DRAPE_GOLDEN");
    struct bytes page = file_read(path);
    bytes_add(&page, "", 1);
    int length = snprintf(mark, sizeof mark, "<!-- table: %s -->\n", name);
    char *begin = strstr(page.data, mark);
    assert_non_null(begin);
    begin += length;
    char *end = strstr(begin, end_mark);
    assert_non_null(end);
    if (mode && strcmp(mode, "write") == 0) {
        FILE *file = fopen(path, "wb");
        assert_non_null(file);
        fprintf(file, "%.*s%.*s%s", (int)(begin - page.data), page.data, (int)table->length,
                table->data, end);
        fclose(file);
    } else if ((size_t)(end - begin) != table->length ||
               memcmp(begin, table->data, table->length) != 0) {
        fail_msg("%s differs from the list of %s: DRAPE_GOLDEN=write updates it", path, name);
    }
    bytes_free(&page);
    bytes_free(table);
}

static void test_lists_are_what_the_docs_say(void **state) {
    (void)state;
    for (int table = 0; table < API_TABLE_COUNT; table++) {
        if (table == API_TABLE_CUT) /* is not shown */
            continue;
        struct bytes text = columns_table((enum api_table)table);
        check_documented("docs/fields.md", api_table_name((enum api_table)table), &text);
    }
    struct bytes text = summary_table();
    check_documented("docs/fields.md", "summary", &text);
    text = formats_table();
    check_documented("docs/formats.md", "formats", &text);
}

static void test_column_list_names_fit_and_are_found(void **state) {
    (void)state;
    size_t stored = 0;
    for (int id = 0; id < COLUMN_COUNT; id++) {
        const struct column_spec *spec = &column_specs[id];
        for (int k = 0; k < spec->parts; k++, stored++) {
            assert_ptr_equal(column_spec_find(spec->table, spec->part[k]), spec);
            check_below(strlen(spec->part[k]), API_COLUMN_NAME_SIZE);
        }
        assert_true(id == 0 || spec[-1].table <= spec->table);
    }
    check_at_most(stored, API_COLUMNS_MAX);
    assert_null(column_spec_find(API_TABLE_CELLS, "x"));
    assert_null(column_spec_find(API_TABLE_CELLS, "warp"));
}

static void test_formats_are_all_in_the_description_of_the_interface(void **state) {
    static const enum format_use uses[] = {FORMAT_RESULT, FORMAT_MAP,   FORMAT_PATTERN,
                                           FORMAT_REPORT, FORMAT_LASER, FORMAT_BUNDLE,
                                           FORMAT_BOOK};
    struct bytes page = file_read("api/openapi.yaml");
    const struct format *format;
    (void)state;
    bytes_add(&page, "", 1);
    for (size_t u = 0; u < sizeof uses / sizeof *uses; u++)
        for (size_t k = 0; (format = format_at(uses[u], k)); k++)
            if (!strstr(page.data, format->media_type) || !strstr(page.data, format->name))
                fail_msg("api/openapi.yaml does not mention %s", format->name);
    bytes_free(&page);
}

/* What is of elements goes to another program: docs/handover.md says what it holds and loses. */
static void test_formats_of_elements_have_a_section_in_the_handover(void **state) {
    struct bytes page = file_read("docs/handover.md");
    const struct format *format;
    (void)state;
    bytes_add(&page, "", 1);
    for (size_t k = 0; (format = format_at(FORMAT_MAP, k)); k++) {
        char heading[64];
        snprintf(heading, sizeof heading, "\n## `%s`", format->name);
        if (format->elements && !strstr(page.data, heading))
            fail_msg("docs/handover.md has no section \"## `%s`\"", format->name);
    }
    bytes_free(&page);
}

/* The text of a summary as it is stored, with another time in the queue. */
static void check_stored(const char *stored, const char *expected) {
    char buffer[512];
    struct api_text text = api_text_over(buffer, sizeof buffer);
    api_summary_write_stored(&text, stored, 2.5);
    assert_string_equal(api_text_finish(&text), expected);
}

static void test_summary_takes_the_queue_time_of_a_job(void **state) {
    (void)state;
    check_stored("{\"nodes\":3,\"timing_ms\":{\"queue\":0,\"solve\":1},\"later\":[1]}",
                 "{\"nodes\":3,\"timing_ms\":{\"queue\":2.5,\"solve\":1},\"later\":[1]}");
    check_stored("{\"a\":\"\\\"timing_ms\\\":{\\\"queue\\\":7\",\"timing_ms\":{\"queue\":0}}",
                 "{\"a\":\"\\\"timing_ms\\\":{\\\"queue\\\":7\",\"timing_ms\":{\"queue\":2.5}}");
    check_stored("{\"of\":{\"timing_ms\":{\"queue\":0}}}",
                 "{\"of\":{\"timing_ms\":{\"queue\":0}}}");
    check_stored("{\"timing_ms\":{\"solve\":1}}", "{\"timing_ms\":{\"solve\":1}}");
    check_stored("{\"nodes\":7}", "{\"nodes\":7}");
    check_stored("{\"cut", "{\"cut");
    check_stored("", "");
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test(test_lists_are_what_the_docs_say),
        cmocka_unit_test(test_column_list_names_fit_and_are_found),
        cmocka_unit_test(test_formats_of_elements_have_a_section_in_the_handover),
        cmocka_unit_test(test_formats_are_all_in_the_description_of_the_interface),
        cmocka_unit_test(test_summary_takes_the_queue_time_of_a_job),
    };
    return cmocka_run_group_tests_name("lists", tests, NULL, NULL);
}
