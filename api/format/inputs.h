/* SPDX-License-Identifier: MIT */
/*
 * A request as `api_normalise` writes it, as rows of a table: each value with the keys that lead to
 * it. Arrays that are long or hold more than numbers are counted, not shown, so that the surface of
 * any part takes a few rows.
 */
#ifndef API_FORMAT_INPUTS_H
#define API_FORMAT_INPUTS_H

#include <stdbool.h>
#include <stddef.h>

enum { INPUTS_NAME_SIZE = 128, INPUTS_DEPTH = 8 };

struct inputs {
    const char *at;              /* what comes next of the text, zero-terminated */
    char name[INPUTS_NAME_SIZE]; /* the keys of the objects that are open, with dots */
    size_t length[INPUTS_DEPTH]; /* of `name` outside of each of these */
    int depth;
};

struct inputs_row {
    const char *name;  /* of the `inputs` until the next row */
    const char *value; /* JSON within the text */
    size_t length;
    size_t count; /* elements of an array that is not to be shown; 0: show the value */
};

/* Starts with a JSON object without spaces between its values. */
struct inputs inputs_of(const char *text);

/* The next row; false at the end, which is also where the text is not as it should be. */
bool inputs_next(struct inputs *inputs, struct inputs_row *row);

#endif
