/* SPDX-License-Identifier: MIT */
/*
 * What a result format is made of, for those who write one. `encode.c` holds the table of formats,
 * selects the columns and hands out the bytes; a format writes the document piece by piece.
 */
#ifndef API_FORMAT_FORMAT_H
#define API_FORMAT_FORMAT_H

#include "api/json/number.h"
#include "api/json/text.h"
#include "api/result/columns.h"
#include "encode.h"

enum {
    ENCODE_VALUES = 4096, /* values of one piece */
    ENCODE_VALUE_ROOM = API_NUMBER_SIZE,
    ENCODE_PIECE = ENCODE_VALUES * ENCODE_VALUE_ROOM + API_HEADER_MAX /* bytes of one piece */
};

struct api_encoder {
    const struct api_format *format;
    const struct api_reader *reader;
    struct api_encode_options options; /* fields is not kept */
    char id[API_ID_SIZE];
    struct api_columns columns;
    const struct api_column *selected[API_COLUMNS_MAX]; /* those to send, by table */
    size_t count;
    /* Where the format is; zero at the start. */
    bool begun;
    size_t column;        /* of `selected` */
    size_t row;           /* in it */
    enum api_table table; /* the one that is open */
    /* The piece being sent. */
    struct api_text piece;
    size_t sent;
    bool ended, failed;
    uint64_t length; /* of the whole document, set by `begin`; 0: not known beforehand */
    void *state;     /* the format's own, `state_size` bytes */
    double values[ENCODE_VALUES];
    char buffer[ENCODE_PIECE];
};

struct api_format {
    const char *name, *media_type;
    bool one_table; /* holds the table of the options alone */
    size_t state_size;
    /* Prepares the state, which is zero, once the columns are selected; NULL when there is nothing
     * to prepare. False with the problem set. */
    bool (*begin)(struct api_encoder *encoder, struct api_problem *problem);
    /* Appends the next piece to `encoder->piece`, which is empty and has ENCODE_PIECE bytes of
     * room; sets `ended` with the last one, or `failed` when the container cannot be read. */
    void (*next)(struct api_encoder *encoder);
    /* Frees what the state holds; NULL when it holds nothing. Also called when `begin` failed. */
    void (*end)(struct api_encoder *encoder);
};

extern const struct api_format encode_json, encode_csv, encode_vtp, encode_glb, encode_npz;

/* Writes one value of a column as the options want it to `text` (ENCODE_VALUE_ROOM bytes); returns
 * its length. */
size_t encode_value(const struct api_encoder *encoder, const struct api_column *column,
                    double value, char *text);

/* The selected column of that table and name, or NULL. */
const struct api_column *encode_selected(const struct api_encoder *encoder, enum api_table table,
                                         const char *name);

/* Sets the problem of a container that lacks what the format needs, or cannot be read; false. */
bool encode_damaged(struct api_problem *problem);

#endif
