/* SPDX-License-Identifier: MIT */
/*
 * The contract's result document, tables of columns; and the map document, whose tables are `cells`
 * and on a mesh `plies`. What is true or false by the contract (`extrapolated`) is written so, and
 * the reasons of the front and the cuts by their names. A study has the table
 * `variants`, and what it was asked for besides.
 */
#include "encoder.h"
#include <string.h>

struct state {
    enum api_table table; /* the one that is open */
};

/* Closes the open table, and those after it that have no columns and belong to a drape's result,
 * until `table` is open. */
static void enter_table(struct encoder *encoder, enum api_table table) {
    struct state *state = encoder->state;
    bool each = encoder->reader && encoder->columns.document == API_DOCUMENT_DRAPE;
    while (state->table < table) {
        state->table = each ? state->table + 1 : table;
        api_text_format(&encoder->piece, "},\"%s\":{", api_table_name(state->table));
    }
}

/* What comes before the tables: of a result its summary, of a map its warnings. */
static void write_preamble(struct encoder *encoder) {
    struct api_text *piece = &encoder->piece;
    struct state *state = encoder->state;
    const struct api_columns *columns = &encoder->columns;
    api_text_raw(piece, "{");
    api_text_key_string(piece, "id", encoder->id);
    if (!encoder->reader) {
        if (encoder->fields.revision)
            api_text_key_string(piece, "revision", encoder->fields.revision);
        api_text_key(piece, "warnings");
        api_text_raw(piece, "[");
        for (size_t k = 0; k < encoder->fields.warning_count; k++) {
            api_text_raw(piece, k > 0 ? "," : "");
            api_text_string(piece, encoder->fields.warnings[k]);
        }
        api_text_raw(piece, "]");
        state->table = API_TABLE_CELLS;
    } else {
        api_text_key_string(piece, "status", "succeeded");
        api_text_key(piece, "summary");
        if (columns->document == API_DOCUMENT_STUDY) {
            study_summary_write(piece, &columns->study, encoder->queue_ms);
            api_text_key(piece, "best");
            study_summary_write_best(piece, &columns->study);
            state->table = API_TABLE_VARIANTS;
        } else {
            summary_write(piece, &columns->summary, encoder->queue_ms);
            api_text_key(piece, "grid");
            result_header_write_grid(piece, &columns->grid);
            state->table = API_TABLE_NODES;
        }
    }
    api_text_format(piece, ",\"%s\":{", api_table_name(state->table));
}

/* Straight into the piece, whose room was made for as many values: this is where the time of a
 * large result goes. */
static void write_json_numbers(struct encoder *encoder, const struct api_column_source *column,
                               size_t count) {
    char *at = encoder->piece.bytes + encoder->piece.length;
    int digits = column->integer ? API_PRECISION_WHOLE : encoder->options.precision;
    if (encoder->row > 0)
        *at++ = ',';
    at += api_number_list(at, encoder->values, count, digits);
    encoder->piece.length = (size_t)(at - encoder->piece.bytes);
}

/* What comes before the tables, then the next rows of the column that the encoder has reached, then
 * what closes the document. */
static void next_json(struct encoder *encoder) {
    if (!encoder->begun) {
        encoder->begun = true;
        write_preamble(encoder);
        return;
    }
    if (encoder->column == encoder->count) {
        if (encoder->reader && encoder->columns.document == API_DOCUMENT_DRAPE)
            enter_table(encoder, API_TABLE_RIM);
        api_text_raw(&encoder->piece, "}}\n");
        encoder->ended = true;
        return;
    }
    const struct api_column_source *column = &encoder->selected[encoder->column];
    size_t count = encoder_left(encoder, column->rows, ENCODER_VALUES);
    if (encoder->row == 0) {
        enter_table(encoder, column->table);
        bool first = encoder->column == 0 || column[-1].table != column->table;
        api_text_format(&encoder->piece, "%s\"%s\":[", first ? "" : ",", column->name);
    }
    if (!encoder_fill(encoder, column, encoder->row, count, encoder->values))
        return;
    const struct column_spec *spec = column_spec_find(column->table, column->name);
    bool truths = spec && spec->kind == COLUMN_TRUTH, words = encoder_has_words(column);
    if (!truths && !words)
        write_json_numbers(encoder, column, count);
    for (size_t i = 0; (truths || words) && i < count; i++) {
        double value = encoder->values[i];
        const char *word = words ? encoder_word(encoder, column, value) : NULL;
        api_text_raw(&encoder->piece, encoder->row + i > 0 ? "," : "");
        if (truths)
            api_text_raw(&encoder->piece, value > 0 ? "true" : "false");
        else if (word)
            api_text_string(&encoder->piece, word);
        else
            encoder->failed = true;
    }
    if (encoder_advance(encoder, column->rows, count))
        api_text_raw(&encoder->piece, "]");
}

const struct format format_json = {.name = "json",
                                   .media_type = "application/json",
                                   .about = "the document of the API: tables of columns",
                                   .exact = "every bit; `precision` rounds",
                                   .uses = FORMAT_RESULT | FORMAT_MAP,
                                   .flow = true,
                                   .tables = true,
                                   .state_size = sizeof(struct state),
                                   .next = next_json};
