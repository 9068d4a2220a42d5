/* SPDX-License-Identifier: MIT */
/*
 * A document being sent, for those who write a format. `encoder.c` selects the columns and hands
 * out the bytes; a format writes the document piece by piece.
 */
#ifndef API_FORMAT_ENCODER_H
#define API_FORMAT_ENCODER_H

#include "api/json/number.h"
#include "api/json/text.h"
#include "format.h"

enum {
    ENCODER_VALUES = 4096, /* values of one piece */
    ENCODER_VALUE_ROOM = API_NUMBER_SIZE,
    ENCODER_PIECE = ENCODER_VALUES * ENCODER_VALUE_ROOM + API_HEADER_MAX, /* bytes of one piece */
    ENCODER_NOTE_SIZE = 320
};

/* A column of a stored result, as the context of a source. */
struct encoder_stored {
    const struct api_reader *reader;
    const struct api_column *column;
};

struct encoder {
    const struct format *format;
    const struct api_reader *reader; /* NULL: of a map */
    double queue_ms;
    struct format_record record;
    struct format_options options; /* of a map `table` is cells or plies; fields is not kept */
    char id[FORMAT_ID_SIZE];
    struct api_columns columns; /* the header of a stored result */
    struct encoder_stored stored[API_COLUMNS_MAX];
    struct map_fields fields;                           /* of a map; its columns are `selected` */
    struct api_column_source selected[API_COLUMNS_MAX]; /* the columns to send, by table */
    size_t count;
    /* Where the format is; zero at the start. */
    bool begun;
    size_t column; /* of `selected` */
    size_t row;    /* in it */
    /* The piece being sent. */
    struct api_text piece;
    size_t sent;
    bool ended, failed;
    uint64_t length; /* of the whole document, set by `begin`; 0: not known beforehand */
    char binning[ENCODER_NOTE_SIZE]; /* set by `begin` */
    void *state;                     /* the format's own, `state_size` bytes */
    double values[ENCODER_VALUES];
    char buffer[ENCODER_PIECE];
};

/* `count` rows of a column from `first` on, NaN where there is no number; false, and the encoder
 * has failed, when they cannot be read. */
bool encoder_fill(struct encoder *encoder, const struct api_column_source *column, size_t first,
                  size_t count, double *values);

/* How many of `rows` rows the next piece has, of at most `most`; and having written so many of the
 * encoder's column, whether that was its end: then the next column is begun. */
static inline size_t encoder_left(const struct encoder *encoder, size_t rows, size_t most) {
    return rows - encoder->row < most ? rows - encoder->row : most;
}
static inline bool encoder_advance(struct encoder *encoder, size_t rows, size_t count) {
    encoder->row += count;
    bool end = encoder->row == rows;
    encoder->column += end;
    encoder->row = end ? 0 : encoder->row;
    return end;
}

/* Writes one value of a column as the options want it to `text` (ENCODER_VALUE_ROOM bytes); returns
 * its length, 0 where there is no number. */
size_t encoder_value(const struct encoder *encoder, const struct api_column_source *column,
                     double value, char *text);

/* What a map is of, for its head: "drape ID", or "laminate ID, revision DIGEST". */
void encoder_origin(const struct encoder *encoder, char origin[ENCODER_NOTE_SIZE]);

/* Whether a column's numbers stand for words; and the word of one: a reason, a failure, a cut's
 * name. NULL for a number that stands for none. */
bool encoder_has_words(const struct api_column_source *column);
const char *encoder_word(const struct encoder *encoder, const struct api_column_source *column,
                         double value);

/* A stored column, selected or not, as a source. */
struct api_column_source encoder_source(struct encoder *encoder, const struct api_column *column);

/* Of a list of columns that of a name, or NULL. */
const struct api_column_source *encoder_find(const struct api_column_source *columns, size_t count,
                                             enum api_table table, const char *name);

/* Sets the problem of a stored result that lacks what the format needs, or cannot be read; false.
 */
bool encoder_damaged(struct api_problem *problem);

#endif
