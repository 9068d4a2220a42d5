/* SPDX-License-Identifier: MIT */
#include "result_header.h"

#include "api/json/text.h"
#include "api/json/value.h"
#include "api/request/members.h"
#include <limits.h>
#include <stdlib.h>
#include <string.h>

enum { SUMMARY_TEXT_MAX = 8192 };

static const char *const form_names[] = {
#define X(id, name) name,
    API_FORM_LIST(X)
#undef X
};

void result_header_write_grid(struct api_text *text, const struct api_grid *grid) {
    api_text_raw(text, "{");
    api_text_key_integers(text, "warp", grid->warp, 2);
    api_text_key_integers(text, "weft", grid->weft, 2);
    api_text_key_numbers(text, "spacing", grid->spacing, 2);
    api_text_raw(text, "}");
}

void result_header_write(struct api_text *text, const struct api_columns *header) {
    if (header->document == API_DOCUMENT_STUDY) {
        api_text_raw(text, "{\"study\":{\"summary\":");
        study_summary_write(text, &header->study, -1);
        api_text_key(text, "best");
        study_summary_write_best(text, &header->study);
        api_text_raw(text, "}");
    } else {
        api_text_raw(text, "{\"summary\":");
        summary_write(text, &header->summary, -1);
        api_text_key(text, "grid");
        result_header_write_grid(text, &header->grid);
        const struct api_start *start = &header->start;
        api_text_key_object(text, "start");
        api_text_key_integer(text, "face", start->face);
        api_text_key_numbers(text, "uv", start->uv, 2);
        api_text_key_numbers(text, "point", &start->point.x, 3);
        api_text_key_numbers(text, "warp", &start->warp.x, 3);
        api_text_key_numbers(text, "weft", &start->weft.x, 3);
        if (vec3_norm2(start->rosette.x) > 0) {
            api_text_key_numbers(text, "zero", &start->zero.x, 3);
            api_text_key_numbers(text, "rosette_origin", &start->rosette.origin.x, 3);
            api_text_key_numbers(text, "rosette_x", &start->rosette.x.x, 3);
            api_text_key_numbers(text, "rosette_z", &start->rosette.z.x, 3);
        }
        api_text_raw(text, "}");
        if (header->cut_count)
            api_text_key(text, "cut_names");
        for (size_t k = 0; k < header->cut_count; k++) {
            api_text_raw(text, k ? "," : "[");
            api_text_string(text, header->cut_names[k]);
        }
        api_text_raw(text, header->cut_count ? "]" : "");
    }
    api_text_key_string(text, "length_unit", header->unit ? header->unit->name : api_units[0].name);
    api_text_key(text, "columns");
    api_text_raw(text, "[");
    for (size_t i = 0; i < header->count; i++) {
        const struct api_column *column = &header->column[i];
        api_text_raw(text, i ? ",{" : "{");
        api_text_key_string(text, "table", column_tables[column->table]);
        api_text_key_string(text, "name", column->name);
        api_text_key_integer(text, "rows", (int64_t)column->rows);
        api_text_key_boolean(text, "integer", column->integer);
        if (column->form != API_FORM_FLOAT64)
            api_text_key_string(text, "form", form_names[column->form]);
        api_text_raw(text, "}");
    }
    api_text_raw(text, "]}");
}

static const struct value_range any = {-1e300, 1e300, false};

static void read_pair(const struct json_value *object, const char *key, int *pair) {
    struct json_value json = value_member(object, key);
    double values[2];
    if (value_vector(&json, (struct value_range){INT32_MIN, INT32_MAX, false}, 2, values))
        for (int k = 0; k < 2; k++)
            pair[k] = (int)values[k];
}

static void read_cut_names(const struct json_value *root, struct api_columns *columns) {
    struct json_value names = value_member(root, "cut_names");
    size_t count = value_given(&names) && value_array(&names, 1) ? value_length(&names) : 0;
    if (count > API_CUTS_MAX)
        value_fault(&names, "must have at most %d names", API_CUTS_MAX);
    for (size_t k = 0; k < count && k < API_CUTS_MAX; k++) {
        struct json_value name = value_element(&names, k);
        columns->cut_count += decode_name(&name, API_CUT_NAME_MAX, columns->cut_names[k]);
    }
}

static struct vec3 read_header_point(const struct json_value *object, const char *key) {
    struct json_value json = value_member(object, key);
    double v[3] = {0, 0, 0};
    value_vector(&json, any, 3, v);
    return vec3_make(v[0], v[1], v[2]);
}

void result_header_read(const struct json_tree *tree, struct api_columns *columns) {
    struct json_value root = value_root(tree);
    struct json_value unit = value_member(&root, "length_unit");
    struct json_value study = value_member(&root, "study");
    columns->unit = &api_units[0];
    if (value_given(&unit))
        decode_unit_name(&unit, &columns->unit);
    columns->start.unit = (int)(columns->unit - api_units);
    if (value_given(&study)) {
        columns->document = API_DOCUMENT_STUDY;
        study_summary_read(&study, &columns->study);
        return;
    }
    struct json_value summary = value_member(&root, "summary"), grid = value_member(&root, "grid");
    struct json_value start = value_member(&root, "start"), face = value_member(&start, "face");
    struct json_value spacing = value_member(&grid, "spacing"), uv = value_member(&start, "uv");
    summary_read(&summary, &columns->summary);
    read_cut_names(&root, columns);
    read_pair(&grid, "warp", columns->grid.warp);
    read_pair(&grid, "weft", columns->grid.weft);
    value_vector(&spacing, any, 2, columns->grid.spacing);
    columns->start.face = -1;
    if (value_given(&face))
        value_integer(&face, -1, INT_MAX, &columns->start.face);
    value_vector(&uv, any, 2, columns->start.uv);
    columns->start.point = read_header_point(&start, "point");
    columns->start.warp = read_header_point(&start, "warp");
    columns->start.weft = read_header_point(&start, "weft");
    struct json_value zero = value_member(&start, "zero");
    if (!value_given(&zero))
        return;
    columns->start.zero = read_header_point(&start, "zero");
    columns->start.rosette = (struct api_rosette){read_header_point(&start, "rosette_origin"),
                                                  read_header_point(&start, "rosette_x"),
                                                  read_header_point(&start, "rosette_z")};
}

/* ---- the list of columns ---- */

/* Whether that is what comes next, which is then behind. */
static bool take_literal(const char **at, const char *literal) {
    size_t length = strlen(literal);
    bool there = strncmp(*at, literal, length) == 0;
    *at += there ? length : 0;
    return there;
}

/* A name up to its closing quote, of characters that encoders may write without escaping them. */
static bool take_name(const char **at, char name[API_COLUMN_NAME_SIZE]) {
    size_t length = strspn(*at, "abcdefghijklmnopqrstuvwxyz0123456789_");
    if (length == 0 || length >= API_COLUMN_NAME_SIZE)
        return false;
    memcpy(name, *at, length);
    name[length] = '\0';
    *at += length;
    return take_literal(at, "\"");
}

static bool take_choice(const char **at, const char *const names[], int count, int *choice) {
    char name[API_COLUMN_NAME_SIZE];
    if (!take_name(at, name))
        return false;
    for (*choice = 0; *choice < count; ++*choice)
        if (strcmp(names[*choice], name) == 0)
            return true;
    return false;
}

bool result_header_take_columns(char *text, struct api_columns *columns) {
    static const char key[] = ",\"columns\":[";
    char *list = strstr(text, key);
    const char *at = list ? list + strlen(key) : text;
    bool good = list != NULL;
    for (columns->count = 0; good && *at == '{'; take_literal(&at, ",")) {
        struct api_column *column = &columns->column[columns->count];
        int table = 0, form = API_FORM_FLOAT64;
        good = columns->count < API_COLUMNS_MAX && take_literal(&at, "{\"table\":\"") &&
               take_choice(&at, column_tables, API_TABLE_COUNT, &table) &&
               take_literal(&at, ",\"name\":\"") && take_name(&at, column->name) &&
               take_literal(&at, ",\"rows\":");
        if (!good)
            break;
        /* A whole number of up to 15 digits. */
        size_t digits = strspn(at, "0123456789");
        column->rows = digits > 0 && digits <= 15 ? (size_t)strtoull(at, NULL, 10) : 0;
        at += digits;
        good = digits > 0 && digits <= 15 && take_literal(&at, ",\"integer\":");
        column->integer = good && take_literal(&at, "true");
        good = good && (column->integer || take_literal(&at, "false"));
        if (good && take_literal(&at, ",\"form\":\""))
            good = take_choice(&at, form_names, API_FORM_COUNT, &form);
        column->table = (enum api_table)table;
        column->form = (enum api_form)form;
        good = good && take_literal(&at, "}");
        columns->count += good;
        good = good && column->rows == api_columns_rows(columns, column->table);
    }
    good = good && take_literal(&at, "]}") && at[strspn(at, " ")] == '\0';
    if (good)
        memcpy(list, "}", sizeof "}");
    return good;
}

char *api_columns_summary_json(const struct api_columns *columns) {
    char *buffer = malloc(SUMMARY_TEXT_MAX);
    if (!buffer)
        return NULL;
    struct api_text text = api_text_over(buffer, SUMMARY_TEXT_MAX);
    if (columns->document == API_DOCUMENT_STUDY)
        study_summary_write(&text, &columns->study, 0);
    else
        summary_write(&text, &columns->summary, 0);
    if (api_text_finish(&text))
        return buffer;
    free(buffer);
    return NULL;
}

const struct api_column *api_columns_find(const struct api_columns *columns, enum api_table table,
                                          const char *name) {
    for (size_t i = 0; i < columns->count; i++)
        if (columns->column[i].table == table && strcmp(columns->column[i].name, name) == 0)
            return &columns->column[i];
    return NULL;
}

size_t api_columns_rows(const struct api_columns *columns, enum api_table table) {
    for (size_t i = 0; i < columns->count; i++)
        if (columns->column[i].table == table)
            return columns->column[i].rows;
    return 0;
}
