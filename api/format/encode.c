/* SPDX-License-Identifier: MIT */
#include "encode.h"

#include "format.h"
#include <stdlib.h>
#include <string.h>
#include <strings.h>

static const struct api_format *const formats[] = {&encode_json, &encode_csv, &encode_vtp,
                                                   &encode_glb, &encode_npz};

enum { FORMATS = sizeof formats / sizeof *formats };

const struct api_format *api_format_at(size_t index) {
    return index < FORMATS ? formats[index] : NULL;
}

const struct api_format *api_format_named(const char *name) {
    for (size_t i = 0; i < FORMATS; i++)
        if (strcmp(name, formats[i]->name) == 0)
            return formats[i];
    return NULL;
}

const struct api_format *api_format_for_media_type(const char *media_type) {
    for (size_t i = 0; i < FORMATS; i++)
        if (strcasecmp(media_type, formats[i]->media_type) == 0)
            return formats[i];
    return NULL;
}

const char *api_format_name(const struct api_format *format) {
    return format->name;
}

const char *api_format_media_type(const struct api_format *format) {
    return format->media_type;
}

/* ---- options ---- */

static bool set_precision(struct api_encode_options *options, const char *value,
                          struct api_problem *problem) {
    char *end;
    long digits = strtol(value, &end, 10);
    if (*value >= '0' && *value <= '9' && *end == '\0' && digits >= 1 &&
        digits <= API_PRECISION_EXACT) {
        options->precision = (int)digits;
        return true;
    }
    api_problem_set(problem, API_INVALID_REQUEST, "precision must be a whole number from 1 to %d",
                    API_PRECISION_EXACT);
    return false;
}

static bool set_table(struct api_encode_options *options, const char *value,
                      struct api_problem *problem) {
    for (int table = API_TABLE_NODES; table <= API_TABLE_CELLS; table++) {
        if (strcmp(value, api_table_name((enum api_table)table)) == 0) {
            options->table = (enum api_table)table;
            return true;
        }
    }
    api_problem_set(problem, API_INVALID_REQUEST, "table must be nodes or cells");
    return false;
}

bool api_encode_option(struct api_encode_options *options, const char *name, const char *value,
                       struct api_problem *problem) {
    if (strcmp(name, "precision") == 0)
        return set_precision(options, value, problem);
    if (strcmp(name, "table") == 0)
        return set_table(options, value, problem);
    if (strcmp(name, "fields") != 0)
        return false;
    options->fields = value;
    return true;
}

/* ---- selection ---- */

/* Whether `column` is the field that the `length` characters at `field` name: table.column. */
static bool is_field(const struct api_column *column, const char *field, size_t length) {
    const char *table = api_table_name(column->table);
    size_t table_length = strlen(table);
    return length == table_length + 1 + strlen(column->name) &&
           memcmp(field, table, table_length) == 0 && field[table_length] == '.' &&
           memcmp(field + table_length + 1, column->name, length - table_length - 1) == 0;
}

/* Marks the columns that the list names. */
static bool mark_fields(const struct api_columns *columns, const char *list,
                        bool wanted[API_COLUMNS_MAX], struct api_problem *problem) {
    for (const char *field = list; field;) {
        size_t length = strcspn(field, ","), i = 0;
        while (i < columns->count && !is_field(&columns->column[i], field, length))
            i++;
        if (i == columns->count) {
            api_problem_set(problem, API_INVALID_REQUEST, "fields: \"%.*s\" is not in this result",
                            length > 60 ? 60 : (int)length, field);
            return false;
        }
        wanted[i] = true;
        field = field[length] ? field + length + 1 : NULL;
    }
    return true;
}

static bool select_columns(struct api_encoder *encoder, const char *fields,
                           struct api_problem *problem) {
    const struct api_columns *columns = &encoder->columns;
    bool all = !fields || !*fields, wanted[API_COLUMNS_MAX] = {false};
    if (!all && !mark_fields(columns, fields, wanted, problem))
        return false;
    for (int table = 0; table < API_TABLE_COUNT; table++) {
        if (encoder->format->one_table && table != (int)encoder->options.table)
            continue;
        for (size_t i = 0; i < columns->count; i++)
            if ((int)columns->column[i].table == table && (all || wanted[i]))
                encoder->selected[encoder->count++] = &columns->column[i];
    }
    if (encoder->count == 0)
        api_problem_set(problem, API_INVALID_REQUEST, "fields: none of them is in the table %s",
                        api_table_name(encoder->options.table));
    return encoder->count > 0;
}

/* ---- the encoder ---- */

struct api_encoder *api_encoder_new(const struct api_format *format,
                                    const struct api_reader *reader,
                                    const struct api_encode_options *options,
                                    struct api_problem *problem) {
    struct api_encoder *encoder = malloc(sizeof *encoder);
    void *state = calloc(1, format->state_size ? format->state_size : 1);
    if (!encoder || !state) {
        api_problem_set(problem, API_OUT_OF_MEMORY, "no memory to encode the result");
        free(state);
        free(encoder);
        return NULL;
    }
    memset(encoder, 0, offsetof(struct api_encoder, values));
    encoder->state = state;
    encoder->format = format;
    encoder->reader = reader;
    encoder->options = *options;
    strncpy(encoder->id, options->id ? options->id : "", API_ID_SIZE - 1);
    if (api_columns_open(reader, &encoder->columns, problem) != API_OK ||
        !select_columns(encoder, options->fields, problem) ||
        (format->begin && !format->begin(encoder, problem))) {
        api_encoder_free(encoder);
        return NULL;
    }
    encoder->options.id = encoder->id;
    encoder->options.fields = NULL;
    return encoder;
}

/* Makes the next piece if the last one has been sent; false when there is nothing to send. */
static bool refill(struct api_encoder *encoder) {
    while (encoder->sent == encoder->piece.length) {
        if (encoder->ended || encoder->failed)
            return false;
        encoder->piece = api_text_over(encoder->buffer, sizeof encoder->buffer);
        encoder->sent = 0;
        encoder->format->next(encoder);
        encoder->failed = encoder->failed || encoder->piece.failed;
        if (encoder->failed)
            encoder->piece.length = 0;
    }
    return true;
}

ssize_t api_encoder_read(struct api_encoder *encoder, char *buffer, size_t size) {
    size_t length = 0;
    while (length < size && refill(encoder)) {
        size_t left = encoder->piece.length - encoder->sent;
        size_t part = left < size - length ? left : size - length;
        memcpy(buffer + length, encoder->buffer + encoder->sent, part);
        encoder->sent += part;
        length += part;
    }
    return length == 0 && encoder->failed ? -1 : (ssize_t)length;
}

uint64_t api_encoder_length(const struct api_encoder *encoder) {
    return encoder->length;
}

void api_encoder_free(struct api_encoder *encoder) {
    if (encoder && encoder->format->end)
        encoder->format->end(encoder);
    if (encoder)
        free(encoder->state);
    free(encoder);
}

const struct api_column *encode_selected(const struct api_encoder *encoder, enum api_table table,
                                         const char *name) {
    for (size_t i = 0; i < encoder->count; i++)
        if (encoder->selected[i]->table == table && strcmp(encoder->selected[i]->name, name) == 0)
            return encoder->selected[i];
    return NULL;
}

bool encode_damaged(struct api_problem *problem) {
    api_problem_set(problem, API_INTERNAL, "the stored result is damaged");
    return false;
}

size_t encode_value(const struct api_encoder *encoder, const struct api_column *column,
                    double value, char *text) {
    if (column->integer)
        return api_number_integer(text, (int64_t)value);
    if (encoder->options.precision)
        return api_number_rounded(text, value, encoder->options.precision);
    return api_number_shortest(text, value);
}
