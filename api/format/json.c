/* SPDX-License-Identifier: MIT */
/* The contract's result document: tables of columns. */
#include "api/result/directory.h"
#include "format.h"
#include <string.h>

static void open_table(struct api_text *piece, enum api_table table) {
    api_text_raw(piece, ",\"");
    api_text_raw(piece, api_table_name(table));
    api_text_raw(piece, "\":{");
}

/* Closes the open table and those after it that have no columns, until `table` is open. */
static void enter_table(struct api_encoder *encoder, enum api_table table) {
    while (encoder->table < table) {
        encoder->table++;
        api_text_raw(&encoder->piece, "}");
        open_table(&encoder->piece, encoder->table);
    }
}

static void write_preamble(struct api_encoder *encoder) {
    struct api_text *piece = &encoder->piece;
    api_text_raw(piece, "{");
    api_text_key_string(piece, "id", encoder->id);
    api_text_key_string(piece, "status", "succeeded");
    api_text_key(piece, "summary");
    directory_write_summary(piece, &encoder->columns.summary, encoder->options.queue_ms);
    api_text_key(piece, "grid");
    directory_write_grid(piece, &encoder->columns.grid);
    open_table(piece, encoder->table);
}

static bool names_reasons(const struct api_column *column) {
    return column->table == API_TABLE_FRONT && strcmp(column->name, "reason") == 0;
}

static void write_reasons(struct api_encoder *encoder, size_t count) {
    for (size_t i = 0; i < count; i++) {
        double reason = encoder->values[i];
        if (encoder->row + i > 0)
            api_text_raw(&encoder->piece, ",");
        if (reason >= 0 && reason < DRAPE_REASON_COUNT)
            api_text_string(&encoder->piece, drape_reason_name((enum drape_reason)(int)reason));
        else
            encoder->failed = true;
    }
}

/* Straight into the piece, whose room was made for as many values: this loop is where the time of
 * a large result goes. Columns of one value (a fibre volume fraction, say) are common, so a value
 * that repeats the one before is copied. */
static void write_numbers(struct api_encoder *encoder, const struct api_column *column,
                          size_t count) {
    struct api_text *piece = &encoder->piece;
    const double *values = encoder->values;
    char *at = piece->bytes + piece->length, last[ENCODE_VALUE_ROOM];
    size_t length = 0;
    for (size_t i = 0; i < count; i++) {
        if (encoder->row + i > 0)
            *at++ = ',';
        if (i == 0 || memcmp(&values[i], &values[i - 1], sizeof *values) != 0) {
            length = encode_value(encoder, column, values[i], at);
            if (i + 1 < count && memcmp(&values[i], &values[i + 1], sizeof *values) == 0)
                memcpy(last, at, length);
        } else {
            memcpy(at, last, ENCODE_VALUE_ROOM);
        }
        at += length;
    }
    piece->length = (size_t)(at - piece->bytes);
}

static void begin_column(struct api_encoder *encoder, const struct api_column *column) {
    enter_table(encoder, column->table);
    bool first =
        encoder->column == 0 || encoder->selected[encoder->column - 1]->table != column->table;
    api_text_raw(&encoder->piece, first ? "\"" : ",\"");
    api_text_raw(&encoder->piece, column->name);
    api_text_raw(&encoder->piece, "\":[");
}

/* The next rows of the column that the encoder has reached. */
static void write_rows(struct api_encoder *encoder) {
    const struct api_column *column = encoder->selected[encoder->column];
    size_t left = column->rows - encoder->row;
    size_t count = left < ENCODE_VALUES ? left : ENCODE_VALUES;
    if (encoder->row == 0)
        begin_column(encoder, column);
    if (!api_columns_read(encoder->reader, column, encoder->row, count, encoder->values)) {
        encoder->failed = true;
        return;
    }
    if (names_reasons(column))
        write_reasons(encoder, count);
    else
        write_numbers(encoder, column, count);
    encoder->row += count;
    if (encoder->row == column->rows) {
        api_text_raw(&encoder->piece, "]");
        encoder->row = 0;
        encoder->column++;
    }
}

static void next(struct api_encoder *encoder) {
    if (!encoder->begun) {
        encoder->begun = true;
        write_preamble(encoder);
    } else if (encoder->column < encoder->count) {
        write_rows(encoder);
    } else {
        enter_table(encoder, API_TABLE_FRONT);
        api_text_raw(&encoder->piece, "}}\n");
        encoder->ended = true;
    }
}

const struct api_format encode_json = {
    .name = "json", .media_type = "application/json", .next = next};
