/* SPDX-License-Identifier: MIT */
#include "directory.h"

#include "api/json/place.h"
#include "api/json/text.h"
#include <string.h>

void directory_write_grid(struct api_text *text, const struct api_grid *grid) {
    api_text_raw(text, "{");
    api_text_key(text, "warp");
    api_text_integers(text, grid->warp, 2);
    api_text_key(text, "weft");
    api_text_integers(text, grid->weft, 2);
    api_text_key(text, "spacing");
    api_text_numbers(text, grid->spacing, 2);
    api_text_raw(text, "}");
}

static void write_point(struct api_text *text, const char *key, struct vec3 v) {
    api_text_key(text, key);
    api_text_numbers(text, (const double[]){v.x, v.y, v.z}, 3);
}

static void write_start(struct api_text *text, const struct api_start *start) {
    api_text_raw(text, "{");
    api_text_key(text, "uv");
    api_text_numbers(text, start->uv, 2);
    write_point(text, "point", start->point);
    write_point(text, "warp", start->warp);
    write_point(text, "weft", start->weft);
    api_text_raw(text, "}");
}

void directory_write(struct api_text *text, const struct api_columns *header) {
    api_text_raw(text, "{\"summary\":");
    summary_write(text, &header->summary, -1);
    api_text_key(text, "grid");
    directory_write_grid(text, &header->grid);
    api_text_key(text, "start");
    write_start(text, &header->start);
    api_text_key_string(text, "length_unit", header->unit ? header->unit->name : api_units[0].name);
    api_text_key(text, "columns");
    api_text_raw(text, "[");
    for (size_t i = 0; i < header->count; i++) {
        const struct api_column *column = &header->column[i];
        api_text_raw(text, i ? ",{" : "{");
        api_text_key_string(text, "table", column_tables[column->table]);
        api_text_key_string(text, "name", column->name);
        api_text_key_integer(text, "rows", (int64_t)column->rows);
        api_text_key(text, "integer");
        api_text_raw(text, column->integer ? "true}" : "false}");
    }
    api_text_raw(text, "]}");
}

static const struct tree_range any = {-1e300, 1e300, false};
static const struct tree_range counts = {0, 0x1p53, false};

static void read_pair(const struct tree_place *object, const char *key, int *pair) {
    struct tree_place place = tree_member(object, key);
    double values[2];
    if (tree_vector(&place, (struct tree_range){INT32_MIN, INT32_MAX, false}, 2, values))
        for (int k = 0; k < 2; k++)
            pair[k] = (int)values[k];
}

static struct vec3 read_point(const struct tree_place *object, const char *key) {
    struct tree_place place = tree_member(object, key);
    double v[3] = {0, 0, 0};
    tree_vector(&place, any, 3, v);
    return vec3_make(v[0], v[1], v[2]);
}

static const struct api_unit *read_unit(const struct tree_place *place) {
    const char *names[API_UNIT_COUNT];
    int index = 0;
    for (int k = 0; k < API_UNIT_COUNT; k++)
        names[k] = api_units[k].name;
    if (tree_given(place))
        tree_choice(place, names, API_UNIT_COUNT, &index);
    return &api_units[index];
}

/* What encoders may write without escaping it. */
static bool is_name(const char *text) {
    size_t length = strspn(text, "abcdefghijklmnopqrstuvwxyz0123456789_");
    return length > 0 && length < API_COLUMN_NAME_SIZE && text[length] == '\0';
}

static void read_column(const struct tree_place *place, struct api_column *column) {
    struct tree_place table = tree_member(place, "table"), name = tree_member(place, "name");
    struct tree_place integer = tree_member(place, "integer"), count = tree_member(place, "rows");
    int index = 0;
    double rows = 0;
    const char *text = "";
    tree_choice(&table, column_tables, API_TABLE_COUNT, &index);
    column->table = (enum api_table)index;
    if (tree_string(&name, &text)) {
        if (!is_name(text))
            tree_fault(&name, "must be a column's name");
        strncpy(column->name, text, API_COLUMN_NAME_SIZE - 1);
    }
    tree_boolean(&integer, &column->integer);
    tree_number(&count, counts, &rows);
    column->rows = (size_t)rows;
}

void directory_read(const struct tree *tree, struct api_columns *columns) {
    struct tree_place root = tree_root(tree);
    struct tree_place summary = tree_member(&root, "summary"), grid = tree_member(&root, "grid");
    struct tree_place start = tree_member(&root, "start"), list = tree_member(&root, "columns");
    struct tree_place spacing = tree_member(&grid, "spacing"), uv = tree_member(&start, "uv");
    struct tree_place unit = tree_member(&root, "length_unit");
    columns->unit = read_unit(&unit);
    summary_read(&summary, &columns->summary);
    read_pair(&grid, "warp", columns->grid.warp);
    read_pair(&grid, "weft", columns->grid.weft);
    tree_vector(&spacing, any, 2, columns->grid.spacing);
    tree_vector(&uv, any, 2, columns->start.uv);
    columns->start.point = read_point(&start, "point");
    columns->start.warp = read_point(&start, "warp");
    columns->start.weft = read_point(&start, "weft");
    columns->count = tree_length(&list);
    if (columns->count > API_COLUMNS_MAX) {
        tree_fault(&list, "must have at most %d elements", API_COLUMNS_MAX);
        return;
    }
    for (size_t i = 0; i < columns->count; i++) {
        struct tree_place column = tree_element(&list, i);
        read_column(&column, &columns->column[i]);
        if (columns->column[i].rows != api_columns_rows(columns, columns->column[i].table))
            tree_fault(&column, "must have as many rows as the others of its table");
    }
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
