/* SPDX-License-Identifier: MIT */
/*
 * Nastran bulk data, card by card: small, large (NAME*) and free fields, in any case, with tabs,
 * comments ($) and continuations; with or without what stands before BEGIN BULK. The first thing
 * wrong is reported with its line.
 */
#ifndef API_MAP_BULK_DATA_H
#define API_MAP_BULK_DATA_H

#include "api/problem.h"
#include "solver/status.h"
#include "solver/vec.h"
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

enum {
    BULK_COLUMNS = 256,   /* room of a line; bulk data uses 80 columns */
    BULK_FIELD_SIZE = 32, /* of a free field; fixed ones have 8 or 16 columns */
    BULK_FIELDS = 16,     /* of a card that are looked at, the name not counted */
    BULK_NAME_SIZE = 16,
    BULK_HEAD = 3
};

/* A card with its continuations. `given` counts the fields that its lines reach. */
struct bulk_card {
    size_t line;
    char name[BULK_NAME_SIZE]; /* upper case, without the * of large fields */
    int given;
    char field[BULK_FIELDS][BULK_FIELD_SIZE]; /* without the blanks around them */
};

/* The fields belong to the reader. */
struct bulk_reader {
    const char *at, *end; /* behind the current line */
    size_t number;        /* of the current line */
    char line[BULK_COLUMNS];
    bool cut;  /* the current line is longer than that */
    bool held; /* the current line has not been used yet */
    bool bulk, ended;
    struct api_problem *problem;
};

/* At the first card of `length` bytes, which outlive the reader. */
struct bulk_reader bulk_begin(const char *bytes, size_t length, struct api_problem *problem);

/* The first letters of what stands in the line at `*at`, in upper case, and `*at` behind the line;
 * of a card those of its name. False at the end. */
bool bulk_head(const char **at, const char *end, char head[BULK_HEAD]);

/* The next card. False at the end, or with the problem set: also when a file with BEGIN BULK ends
 * without ENDDATA. */
bool bulk_next(struct bulk_reader *reader, struct bulk_card *card) STATUS_MUST_USE;

/* A field as an id, 1..99999999; `what` names it in the problem. */
bool bulk_id(const struct bulk_card *card, int field, const char *what, int32_t *id,
             struct api_problem *problem) STATUS_MUST_USE;

/* Three fields from `first` on as the coordinates x, y and z: Nastran reals within
 * +-MAP_COORDINATE_MAX, 0 when blank. A card that ends before them is not whole. */
bool bulk_point(const struct bulk_card *card, int first, struct vec3 *point,
                struct api_problem *problem) STATUS_MUST_USE;

#endif
