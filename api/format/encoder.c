/* SPDX-License-Identifier: MIT */
#include "encoder.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

/* ---- columns ---- */

static bool fill_stored(const void *context, size_t first, size_t count, double *values) {
    const struct encoder_stored *stored = context;
    return api_columns_read(stored->reader, stored->column, first, count, values);
}

struct api_column_source encoder_source(struct encoder *encoder, const struct api_column *column) {
    struct encoder_stored *stored = &encoder->stored[column - encoder->columns.column];
    *stored = (struct encoder_stored){encoder->reader, column};
    return (struct api_column_source){.table = column->table,
                                      .name = column->name,
                                      .integer = column->integer,
                                      .rows = column->rows,
                                      .fill = fill_stored,
                                      .context = stored};
}

const struct api_column_source *encoder_find(const struct api_column_source *columns, size_t count,
                                             enum api_table table, const char *name) {
    for (size_t k = 0; k < count; k++)
        if (columns[k].table == table && strcmp(columns[k].name, name) == 0)
            return &columns[k];
    return NULL;
}

bool encoder_fill(struct encoder *encoder, const struct api_column_source *column, size_t first,
                  size_t count, double *values) {
    if (!column->fill(column->context, first, count, values))
        encoder->failed = true;
    if (encoder->columns.document == API_DOCUMENT_STUDY && !encoder->failed) {
        /* what a variant has no number for is stored as one below 0 */
        const struct column_spec *spec = column_spec_find(column->table, column->name);
        for (size_t k = 0; spec && spec->kind == COLUMN_POSITIVE && k < count; k++)
            if (values[k] < 0)
                values[k] = (double)NAN;
    }
    return !encoder->failed;
}

size_t encoder_value(const struct encoder *encoder, const struct api_column_source *column,
                     double value, char *text) {
    if (isnan(value))
        return 0;
    if (column->integer)
        return api_number_integer(text, (int64_t)value);
    if (encoder->options.precision)
        return api_number_rounded(text, value, encoder->options.precision);
    return api_number_shortest(text, value);
}

static enum column_kind kind_of(const struct api_column_source *column) {
    const struct column_spec *spec = column_spec_find(column->table, column->name);
    return spec ? spec->kind : COLUMN_SCALAR;
}

bool encoder_has_words(const struct api_column_source *column) {
    enum column_kind kind = kind_of(column);
    return kind == COLUMN_REASON || kind == COLUMN_FAILURE || kind == COLUMN_NAME;
}

const char *encoder_word(const struct encoder *encoder, const struct api_column_source *column,
                         double value) {
    enum column_kind kind = kind_of(column);
    size_t words = kind == COLUMN_REASON    ? DRAPE_REASON_COUNT
                   : kind == COLUMN_FAILURE ? FAILURE_COUNT
                                            : encoder->columns.cut_count;
    if (!(value >= 0 && value < (double)words))
        return NULL;
    return kind == COLUMN_REASON    ? drape_reason_name((enum drape_reason)(int)value)
           : kind == COLUMN_FAILURE ? failure_names[(int)value]
                                    : encoder->columns.cut_names[(int)value];
}

void encoder_origin(const struct encoder *encoder, char origin[ENCODER_NOTE_SIZE]) {
    const char *revision = encoder->fields.revision, *id = encoder->id;
    if (revision)
        (void)snprintf(origin, ENCODER_NOTE_SIZE, "laminate%s%s, revision %s", *id ? " " : "", id,
                       revision);
    else
        (void)snprintf(origin, ENCODER_NOTE_SIZE, "drape %s", id);
}

bool encoder_damaged(struct api_problem *problem) {
    return !api_problem_set(problem, API_INTERNAL, "the stored result is damaged");
}

/* ---- selection ---- */

/* Fills `selected` from all columns there are, by table: of those that the list names by
 * table.column, in a map those of the cells by the column alone as well. */
static bool select_columns(struct encoder *encoder, const struct api_column_source *columns,
                           size_t count, const char *fields, struct api_problem *problem) {
    bool all = !fields || !*fields, wanted[API_COLUMNS_MAX] = {false}, map = !encoder->reader;
    for (const char *field = all ? NULL : fields; field;) {
        size_t length = strcspn(field, ","), i = 0;
        const char *next = field[length] ? field + length + 1 : NULL;
        if (map && strncmp(field, "cells.", 6) == 0) {
            field += 6;
            length -= 6;
        }
        for (; i < count; i++) {
            char name[16 + API_COLUMN_NAME_SIZE];
            bool alone = map && columns[i].table == API_TABLE_CELLS;
            snprintf(name, sizeof name, "%s%s%s", alone ? "" : api_table_name(columns[i].table),
                     alone ? "" : ".", columns[i].name);
            if (strlen(name) == length && memcmp(name, field, length) == 0)
                break;
        }
        if (i == count)
            return !api_problem_set(problem, API_INVALID_REQUEST,
                                    "fields: \"%.*s\" is not in this %s",
                                    length > 60 ? 60 : (int)length, field, map ? "map" : "result");
        wanted[i] = true;
        field = next;
    }
    for (int table = 0; table < API_TABLE_COUNT; table++) {
        if (encoder->format->one_table && table != (int)encoder->options.table)
            continue;
        for (size_t i = 0; i < count; i++)
            if ((int)columns[i].table == table && (all || wanted[i]))
                encoder->selected[encoder->count++] = columns[i];
    }
    if (encoder->count == 0)
        api_problem_set(problem, API_INVALID_REQUEST,
                        "fields: the table %s has none of these columns",
                        api_table_name(encoder->options.table));
    return encoder->count > 0;
}

/* ---- the encoder ---- */

/* The stored result with all its columns but those of cut cells. Its table is, of a drape, the
 * nodes, the cells or the cuts, of a study the variants, the
 * bands or the proposed cuts. */
static bool open_result(struct encoder *encoder, const char *fields, struct api_problem *problem) {
    struct api_column_source columns[API_COLUMNS_MAX];
    enum api_table *table = &encoder->options.table;
    size_t count = 0;
    if (api_columns_open(encoder->reader, &encoder->columns, problem) != API_OK)
        return false;
    if (!api_columns_whole(encoder->reader, &encoder->columns))
        return encoder_damaged(problem);
    for (size_t k = 0; k < encoder->columns.count; k++)
        if (encoder->columns.column[k].table != API_TABLE_CUT)
            columns[count++] = encoder_source(encoder, &encoder->columns.column[k]);
    bool study = encoder->columns.document == API_DOCUMENT_STUDY;
    if (study && !encoder->format->tables)
        return !api_problem_set(problem, API_NOT_ACCEPTABLE,
                                "a study has no %s; drape one of its variants",
                                encoder->format->name);
    enum api_table first = study ? API_TABLE_VARIANTS : API_TABLE_NODES;
    if (!encoder->options.table_given)
        *table = first;
    bool cuts = (*table == API_TABLE_CUTS && encoder->columns.cut_count > 0) ||
                ((*table == API_TABLE_PROPOSED || *table == API_TABLE_COURSES) && study);
    if (*table == first || *table == (study ? API_TABLE_BANDS : API_TABLE_CELLS) || cuts)
        return select_columns(encoder, columns, count, fields, problem);
    return !api_problem_set(
        problem, API_INVALID_REQUEST,
        study ? "table: a study has the tables variants and bands, and proposed where it proposes "
                "cuts; "
                "those of one of its drapes come with the parameter sample"
              : "table: a drape has the tables nodes and cells, and with cuts the table cuts");
}

static bool open_map(struct encoder *encoder, const struct map_fields *source, const char *fields,
                     struct api_problem *problem) {
    encoder->fields = *source;
    if (encoder->options.table != API_TABLE_NODES && !source->plies)
        return !api_problem_set(problem, API_INVALID_REQUEST,
                                "table: a map onto points has one table");
    if (encoder->options.table != API_TABLE_PLIES)
        encoder->options.table = API_TABLE_CELLS;
    if (encoder->options.plies_as && !encoder->format->yarns)
        return !api_problem_set(problem, API_INVALID_REQUEST,
                                "plies_as: %s shows every ply as it is, with its shear; it is for "
                                "decks, such as calculix or nastran, and for abd",
                                encoder->format->name);
    if (source->roles && !encoder->format->flow)
        return !api_problem_set(
            problem, API_INVALID_REQUEST,
            "%s has no place for an inlet, an outlet or an edge channel: leave "
            "these out, or choose json, csv, vtu, gmsh, unv, lcmsim, lcmsim-h5 or lims",
            encoder->format->name);
    if (source->column_count == 0 || source->column_count > API_COLUMNS_MAX)
        return !api_problem_set(problem, API_INTERNAL, "the fields have no columns, or too many");
    if (!select_columns(encoder, source->columns, source->column_count, fields, problem))
        return false;
    encoder->fields.columns = encoder->selected;
    encoder->fields.column_count = encoder->count;
    return true;
}

struct encoder *encoder_new(const struct format *format, const struct format_source *source,
                            const struct format_options *options, struct api_problem *problem) {
    struct encoder *encoder = malloc(sizeof *encoder);
    void *state = calloc(1, format->state_size ? format->state_size : 1);
    if (!encoder || !state) {
        api_problem_set(problem, API_OUT_OF_MEMORY, "no memory to encode the %s",
                        source->fields ? "mesh" : "result");
        free(state);
        free(encoder);
        return NULL;
    }
    memset(encoder, 0, offsetof(struct encoder, values));
    encoder->state = state;
    encoder->format = format;
    encoder->reader = source->reader;
    encoder->queue_ms = source->queue_ms;
    encoder->record = source->record;
    encoder->options = *options;
    encoder->options.fields = NULL;
    strncpy(encoder->id, source->id ? source->id : "", sizeof encoder->id - 1);
    if ((source->fields ? open_map(encoder, source->fields, options->fields, problem)
                        : open_result(encoder, options->fields, problem)) &&
        (!format->begin || format->begin(encoder, problem)))
        return encoder;
    encoder_free(encoder);
    return NULL;
}

/* The next piece, in ENCODER_PIECE bytes there. */
static void make_piece(struct encoder *encoder, char *bytes) {
    encoder->piece = api_text_over(bytes, ENCODER_PIECE);
    encoder->sent = 0;
    encoder->format->next(encoder);
    encoder->failed = encoder->failed || encoder->piece.failed;
    if (encoder->failed)
        encoder->piece.length = 0;
}

/* A piece is made when the last one has been sent: in the buffer itself if that has room for any.
 */
ssize_t encoder_read(struct encoder *encoder, char *buffer, size_t size) {
    size_t length = 0;
    while (length < size) {
        size_t left = encoder->piece.length - encoder->sent, room = size - length;
        size_t part = left < room ? left : room;
        if (left > 0) {
            memcpy(buffer + length, encoder->buffer + encoder->sent, part);
            encoder->sent += part;
        } else if (encoder->ended || encoder->failed) {
            break;
        } else if (room >= ENCODER_PIECE) {
            make_piece(encoder, buffer + length);
            part = encoder->sent = encoder->piece.length;
        } else {
            make_piece(encoder, encoder->buffer);
        }
        length += part;
    }
    return length == 0 && encoder->failed ? -1 : (ssize_t)length;
}

uint64_t encoder_length(const struct encoder *encoder) {
    return encoder->length;
}

const char *encoder_binning(const struct encoder *encoder) {
    return encoder->binning;
}

void encoder_free(struct encoder *encoder) {
    if (encoder && encoder->format->end)
        encoder->format->end(encoder);
    if (encoder)
        free(encoder->state);
    free(encoder);
}
