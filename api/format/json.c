/* SPDX-License-Identifier: MIT */
/*
 * The contract's result document, tables of columns; and the map document, whose tables are `cells`
 * and on a mesh `plies`. What is true or false by the contract (`extrapolated`) is written so, and
 * the reasons of the front by their names. A study has the one table
 * `variants`.
 */
#include "encoder.h"
#include <string.h>

struct state {
    enum api_table table; /* the one that is open */
};

static void open_table(struct api_text *piece, enum api_table table) {
    api_text_raw(piece, ",\"");
    api_text_raw(piece, api_table_name(table));
    api_text_raw(piece, "\":{");
}

/* Closes the open table, and those after it that have no columns and belong to a result, until
 * `table` is open. */
static void enter_table(struct encoder *encoder, enum api_table table) {
    struct state *state = encoder->state;
    while (state->table < table) {
        api_text_raw(&encoder->piece, "}");
        state->table = encoder->reader ? state->table + 1 : table;
        open_table(&encoder->piece, state->table);
    }
}

static void write_result_preamble(struct encoder *encoder) {
    struct api_text *piece = &encoder->piece;
    api_text_raw(piece, "{");
    api_text_key_string(piece, "id", encoder->id);
    api_text_key_string(piece, "status", "succeeded");
    api_text_key(piece, "summary");
    summary_write(piece, &encoder->columns.summary, encoder->queue_ms);
    api_text_key(piece, "grid");
    directory_write_grid(piece, &encoder->columns.grid);
    open_table(piece, API_TABLE_NODES);
}

static void write_study_preamble(struct encoder *encoder) {
    struct api_text *piece = &encoder->piece;
    struct state *state = encoder->state;
    api_text_raw(piece, "{");
    api_text_key_string(piece, "id", encoder->id);
    api_text_key_string(piece, "status", "succeeded");
    api_text_key(piece, "summary");
    study_summary_write(piece, &encoder->columns.study, encoder->queue_ms);
    api_text_key(piece, "best");
    study_summary_write_best(piece, &encoder->columns.study);
    state->table = API_TABLE_VARIANTS;
    open_table(piece, state->table);
}

static void write_map_preamble(struct encoder *encoder) {
    struct api_text *piece = &encoder->piece;
    struct state *state = encoder->state;
    api_text_raw(piece, "{");
    api_text_key_string(piece, "id", encoder->id);
    api_text_key(piece, "warnings");
    api_text_raw(piece, "[");
    for (size_t k = 0; k < encoder->fields.warning_count; k++) {
        api_text_raw(piece, k > 0 ? "," : "");
        api_text_string(piece, encoder->fields.warnings[k]);
    }
    api_text_raw(piece, "]");
    state->table = API_TABLE_CELLS;
    open_table(piece, state->table);
}

/* Names in place of the numbers that stand for them. */
static void write_names(struct encoder *encoder, enum column_kind kind, size_t count) {
    int names = kind == COLUMN_REASON ? DRAPE_REASON_COUNT : FAILURE_COUNT;
    for (size_t i = 0; i < count; i++) {
        double value = encoder->values[i];
        if (encoder->row + i > 0)
            api_text_raw(&encoder->piece, ",");
        if (!(value >= 0 && value < names))
            encoder->failed = true;
        else if (kind == COLUMN_REASON)
            api_text_string(&encoder->piece, drape_reason_name((enum drape_reason)(int)value));
        else
            api_text_string(&encoder->piece, failure_names[(int)value]);
    }
}

static void write_truths(struct encoder *encoder, size_t count) {
    for (size_t i = 0; i < count; i++) {
        if (encoder->row + i > 0)
            api_text_raw(&encoder->piece, ",");
        api_text_raw(&encoder->piece, encoder->values[i] > 0 ? "true" : "false");
    }
}

/* Straight into the piece, whose room was made for as many values: this loop is where the time of
 * a large result goes. Columns of one value (a fibre volume fraction, say) are common, so a value
 * that repeats the one before is copied. */
static void write_numbers(struct encoder *encoder, const struct api_column_source *column,
                          size_t count) {
    struct api_text *piece = &encoder->piece;
    const double *values = encoder->values;
    char *at = piece->bytes + piece->length, last[ENCODER_VALUE_ROOM];
    size_t length = 0;
    for (size_t i = 0; i < count; i++) {
        if (encoder->row + i > 0)
            *at++ = ',';
        if (i == 0 || memcmp(&values[i], &values[i - 1], sizeof *values) != 0) {
            length = encoder_value(encoder, column, values[i], at);
            if (length == 0)
                length = (size_t)(stpcpy(at, "null") - at);
            if (i + 1 < count && memcmp(&values[i], &values[i + 1], sizeof *values) == 0)
                memcpy(last, at, length);
        } else {
            memcpy(at, last, ENCODER_VALUE_ROOM);
        }
        at += length;
    }
    piece->length = (size_t)(at - piece->bytes);
}

static void open_column(struct encoder *encoder, const struct api_column_source *column) {
    enter_table(encoder, column->table);
    bool first = encoder->column == 0 || column[-1].table != column->table;
    api_text_raw(&encoder->piece, first ? "\"" : ",\"");
    api_text_raw(&encoder->piece, column->name);
    api_text_raw(&encoder->piece, "\":[");
}

/* The next rows of the column that the encoder has reached. */
static void write_rows(struct encoder *encoder) {
    const struct api_column_source *column = &encoder->selected[encoder->column];
    size_t left = column->rows - encoder->row;
    size_t count = left < ENCODER_VALUES ? left : ENCODER_VALUES;
    if (encoder->row == 0)
        open_column(encoder, column);
    if (!encoder_fill(encoder, column, encoder->row, count, encoder->values))
        return;
    const struct column_spec *spec = column_spec_find(column->table, column->name);
    if (spec && (spec->kind == COLUMN_REASON || spec->kind == COLUMN_FAILURE))
        write_names(encoder, spec->kind, count);
    else if (spec && spec->kind == COLUMN_TRUTH)
        write_truths(encoder, count);
    else
        write_numbers(encoder, column, count);
    encoder->row += count;
    if (encoder->row == column->rows) {
        api_text_raw(&encoder->piece, "]");
        encoder->row = 0;
        encoder->column++;
    }
}

static void next(struct encoder *encoder) {
    if (!encoder->begun) {
        encoder->begun = true;
        (!encoder->reader                                  ? write_map_preamble
         : encoder->columns.document == API_DOCUMENT_STUDY ? write_study_preamble
                                                           : write_result_preamble)(encoder);
    } else if (encoder->column < encoder->count) {
        write_rows(encoder);
    } else {
        if (encoder->reader && encoder->columns.document == API_DOCUMENT_DRAPE)
            enter_table(encoder, API_TABLE_RIM);
        api_text_raw(&encoder->piece, "}}\n");
        encoder->ended = true;
    }
}

const struct format format_json = {.name = "json",
                                   .media_type = "application/json",
                                   .about = "the document of the API: tables of columns",
                                   .exact = "every bit; `precision` rounds",
                                   .uses = FORMAT_RESULT | FORMAT_MAP,
                                   .tables = true,
                                   .state_size = sizeof(struct state),
                                   .next = next};
