/* SPDX-License-Identifier: MIT */
/*
 * Mapped fields as text: JSON with the columns as in a result's `cells`, and CSV with one row an
 * element. What is true or false by the contract (`extrapolated`) is written so in JSON.
 */
#include "api/json/number.h"
#include "mesh_format.h"
#include <string.h>

enum { ROWS = 2048, TEXT_MAX = API_NUMBER_SIZE + 1 /* a number and what parts it from the next */ };

_Static_assert((int)MESH_PIECE >= ROWS * TEXT_MAX + 1024, "a piece has room for a block of rows");

struct state {
    bool begun;
    size_t column, row;
    double block[ROWS];
    double rows[API_COLUMNS_MAX][ROWS]; /* CSV: a block of every column */
};

static void write_value(struct api_mesh_encoder *encoder, const struct api_column_source *column,
                        double value) {
    char text[API_NUMBER_SIZE];
    size_t length;
    if (column->integer)
        length = api_number_integer(text, (int64_t)value);
    else if (encoder->fields.precision)
        length = api_number_rounded(text, value, encoder->fields.precision);
    else
        length = api_number_shortest(text, value);
    api_text_bytes(&encoder->piece, text, length);
}

/* ---- JSON ---- */

static void json_begin(struct api_mesh_encoder *encoder) {
    struct api_text *piece = &encoder->piece;
    api_text_raw(piece, "{");
    api_text_key_string(piece, "id", encoder->fields.id);
    api_text_key(piece, "warnings");
    api_text_raw(piece, "[");
    if (encoder->fields.warning)
        api_text_string(piece, encoder->fields.warning);
    api_text_raw(piece, "],\"cells\":{");
}

static bool is_truth(const struct api_column_source *column) {
    return strcmp(column->name, "extrapolated") == 0;
}

static void json_rows(struct api_mesh_encoder *encoder, struct state *state) {
    const struct api_column_source *column = &encoder->fields.columns[state->column];
    size_t left = column->rows - state->row, count = left < ROWS ? left : ROWS;
    struct api_text *piece = &encoder->piece;
    if (state->row == 0) {
        api_text_raw(piece, state->column ? ",\"" : "\"");
        api_text_raw(piece, column->name);
        api_text_raw(piece, "\":[");
    }
    column->fill(column->context, state->row, count, state->block);
    for (size_t k = 0; k < count; k++) {
        if (state->row + k > 0)
            api_text_raw(piece, ",");
        if (is_truth(column))
            api_text_raw(piece, state->block[k] > 0 ? "true" : "false");
        else
            write_value(encoder, column, state->block[k]);
    }
    state->row += count;
    if (state->row < column->rows)
        return;
    api_text_raw(piece, "]");
    state->row = 0;
    state->column++;
}

static void json_next(struct api_mesh_encoder *encoder) {
    struct state *state = encoder->state;
    if (!state->begun) {
        json_begin(encoder);
        state->begun = true;
    } else if (state->column < encoder->fields.column_count) {
        json_rows(encoder, state);
    } else {
        api_text_raw(&encoder->piece, "}}\n");
        encoder->ended = true;
    }
}

/* ---- CSV ---- */

static void csv_head(struct api_mesh_encoder *encoder) {
    for (size_t k = 0; k < encoder->fields.column_count; k++) {
        api_text_raw(&encoder->piece, k ? "," : "");
        api_text_raw(&encoder->piece, encoder->fields.columns[k].name);
    }
    api_text_raw(&encoder->piece, "\n");
}

static void csv_rows(struct api_mesh_encoder *encoder, struct state *state) {
    const struct api_mesh_fields *fields = &encoder->fields;
    size_t left = fields->columns[0].rows - state->row;
    size_t room = (size_t)MESH_PIECE / (TEXT_MAX * fields->column_count);
    size_t count = left < room ? left : room;
    for (size_t k = 0; k < fields->column_count; k++)
        fields->columns[k].fill(fields->columns[k].context, state->row, count, state->rows[k]);
    for (size_t row = 0; row < count; row++) {
        for (size_t k = 0; k < fields->column_count; k++) {
            api_text_raw(&encoder->piece, k ? "," : "");
            write_value(encoder, &fields->columns[k], state->rows[k][row]);
        }
        api_text_raw(&encoder->piece, "\n");
    }
    state->row += count;
}

static void csv_next(struct api_mesh_encoder *encoder) {
    struct state *state = encoder->state;
    if (!state->begun)
        csv_head(encoder);
    else if (state->row < encoder->fields.columns[0].rows)
        csv_rows(encoder, state);
    else
        encoder->ended = true;
    state->begun = true;
}

/* ---- formats ---- */

static bool begin(struct api_mesh_encoder *encoder, struct api_problem *problem) {
    if (encoder->fields.column_count > 0 && encoder->fields.column_count <= API_COLUMNS_MAX)
        return true;
    api_problem_set(problem, API_INTERNAL, "the fields have no columns, or too many");
    return false;
}

const struct api_mesh_format mesh_format_json = {.name = "json",
                                                 .media_type = "application/json",
                                                 .no_elements = true,
                                                 .state_size = sizeof(struct state),
                                                 .begin = begin,
                                                 .next = json_next};

const struct api_mesh_format mesh_format_csv = {.name = "csv",
                                                .media_type = "text/csv",
                                                .no_elements = true,
                                                .state_size = sizeof(struct state),
                                                .begin = begin,
                                                .next = csv_next};
