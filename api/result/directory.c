/* SPDX-License-Identifier: MIT */
#include "directory.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

static const char *const table_names[API_TABLE_COUNT] = {"nodes", "cells", "front"};
static const char *const outcome_names[] = {
    [DRAPE_COMPLETE] = "complete", [DRAPE_PARTIAL] = "partial"};

const char *api_table_name(enum api_table table) {
    return table_names[table];
}

static void write_reasons(struct api_text *text, const size_t *counts) {
    api_text_key(text, "front_reasons");
    api_text_raw(text, "{");
    for (int i = 0; i < DRAPE_REASON_COUNT; i++)
        api_text_key_integer(text, drape_reason_name((enum drape_reason)i), (int64_t)counts[i]);
    api_text_raw(text, "}");
}

void directory_write_summary(struct api_text *text, const struct api_summary *s, double queue_ms) {
    api_text_raw(text, "{");
    api_text_key_string(text, "outcome", outcome_names[s->outcome]);
    api_text_key_integer(text, "nodes", (int64_t)s->nodes);
    api_text_key_integer(text, "cells", (int64_t)s->cells);
    api_text_key_number(text, "coverage", s->coverage);
    api_text_key_number(text, "max_shear_deg", s->max_shear_deg);
    api_text_key_number(text, "mean_shear_deg", s->mean_shear_deg);
    api_text_key_integer(text, "locked_cells", (int64_t)s->locked_cells);
    api_text_key_integer(text, "packing_exceeded_cells", (int64_t)s->packing_exceeded_cells);
    api_text_key_number(text, "residual_max", s->residual_max);
    api_text_key_number(text, "newton_iterations_mean", s->newton_iterations_mean);
    api_text_key_number(text, "error_estimate_max",
                        s->error_estimate_max < 0 ? (double)NAN : s->error_estimate_max);
    write_reasons(text, s->front_reasons);
    api_text_key(text, "timing_ms");
    api_text_raw(text, "{");
    if (queue_ms >= 0)
        api_text_key_number(text, "queue", queue_ms);
    api_text_key_number(text, "solve", s->solve_ms);
    api_text_raw(text, "}");
    api_text_key_string(text, "solver_version", s->solver_version);
    api_text_raw(text, "}");
}

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
    directory_write_summary(text, &header->summary, -1);
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
        api_text_key_string(text, "table", table_names[column->table]);
        api_text_key_string(text, "name", column->name);
        api_text_key_integer(text, "rows", (int64_t)column->rows);
        api_text_key(text, "integer");
        api_text_raw(text, column->integer ? "true}" : "false}");
    }
    api_text_raw(text, "]}");
}

char *api_summary_json(const struct api_summary *summary, double queue_ms) {
    char *buffer = malloc(API_HEADER_MAX);
    if (!buffer)
        return NULL;
    struct api_text text = api_text_over(buffer, API_HEADER_MAX);
    directory_write_summary(&text, summary, queue_ms > 0 ? queue_ms : 0);
    if (api_text_finish(&text))
        return buffer;
    free(buffer);
    return NULL;
}

static const struct tree_range any = {-1e300, 1e300, false};
static const struct tree_range counts = {0, 0x1p53, false};

static double read_number(const struct tree_place *object, const char *key,
                          struct tree_range range) {
    struct tree_place place = tree_member(object, key);
    double value = 0;
    tree_number(&place, range, &value);
    return value;
}

static size_t read_count(const struct tree_place *object, const char *key) {
    return (size_t)read_number(object, key, counts);
}

static void read_summary(const struct tree_place *place, struct api_summary *s) {
    struct tree_place outcome = tree_member(place, "outcome");
    struct tree_place estimate = tree_member(place, "error_estimate_max");
    struct tree_place reasons = tree_member(place, "front_reasons");
    struct tree_place timing = tree_member(place, "timing_ms");
    struct tree_place version = tree_member(place, "solver_version");
    int index = DRAPE_COMPLETE;
    const char *text = "";
    tree_choice(&outcome, outcome_names, 2, &index);
    s->outcome = (enum drape_outcome)index;
    s->nodes = read_count(place, "nodes");
    s->cells = read_count(place, "cells");
    s->coverage = read_number(place, "coverage", any);
    s->max_shear_deg = read_number(place, "max_shear_deg", any);
    s->mean_shear_deg = read_number(place, "mean_shear_deg", any);
    s->locked_cells = read_count(place, "locked_cells");
    s->packing_exceeded_cells = read_count(place, "packing_exceeded_cells");
    s->residual_max = read_number(place, "residual_max", any);
    s->newton_iterations_mean = read_number(place, "newton_iterations_mean", any);
    s->error_estimate_max = -1;
    if (tree_type(&estimate) == TREE_NUMBER)
        tree_number(&estimate, any, &s->error_estimate_max);
    for (int i = 0; i < DRAPE_REASON_COUNT; i++)
        s->front_reasons[i] = read_count(&reasons, drape_reason_name((enum drape_reason)i));
    s->solve_ms = read_number(&timing, "solve", any);
    if (tree_string(&version, &text))
        strncpy(s->solver_version, text, API_VERSION_SIZE - 1);
}

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
    struct tree_place integer = tree_member(place, "integer");
    int index = 0;
    const char *text = "";
    tree_choice(&table, table_names, API_TABLE_COUNT, &index);
    column->table = (enum api_table)index;
    if (tree_string(&name, &text)) {
        if (!is_name(text))
            tree_fault(&name, "must be a column's name");
        strncpy(column->name, text, API_COLUMN_NAME_SIZE - 1);
    }
    tree_boolean(&integer, &column->integer);
    column->rows = read_count(place, "rows");
}

void directory_read(const struct tree *tree, struct api_columns *columns) {
    struct tree_place root = tree_root(tree);
    struct tree_place summary = tree_member(&root, "summary"), grid = tree_member(&root, "grid");
    struct tree_place start = tree_member(&root, "start"), list = tree_member(&root, "columns");
    struct tree_place spacing = tree_member(&grid, "spacing"), uv = tree_member(&start, "uv");
    struct tree_place unit = tree_member(&root, "length_unit");
    columns->unit = read_unit(&unit);
    read_summary(&summary, &columns->summary);
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
