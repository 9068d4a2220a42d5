/* SPDX-License-Identifier: MIT */
/*
 * Arrays of numbers, taken out of a JSON text before it is parsed. A tree takes up to 79 bytes for
 * a byte of text, nearly all of it for numbers, of which a surface may have a million; here a
 * number takes the 8 bytes of a double. In the text that is left, a mark stands for each array.
 */
#ifndef API_JSON_NUMBERS_H
#define API_JSON_NUMBERS_H

#include "solver/arena.h"
#include <stdbool.h>
#include <stddef.h>

/* An array of `rows` numbers (`width` 0), or of `rows` arrays of `width` numbers each. */
struct numbers_array {
    const double *values; /* row by row */
    size_t rows, width;
    size_t from, to; /* where it stands in the caller's text */
    size_t at;       /* and its mark in the text that is left */
};

struct numbers {
    const char *text; /* what is left, not terminated; the caller's own when there is no array */
    size_t length;
    const struct numbers_array *array; /* in the order of the text */
    size_t count;
};

/* Once in each process: what makes marks different from all that a caller could write. */
bool numbers_prepare(void);

/* Takes out every array of NUMBERS_LEAST or more numbers that are JSON and doubles; what is
 * malformed or out of range is left for the parser to complain about; all is without an arena.
 * Linear in the length. False without memory. */
enum { NUMBERS_LEAST = 16 };
bool numbers_take_out(const char *bytes, size_t length, struct arena *arena,
                      struct numbers *numbers);

/* The array that a string of the tree is the mark of, or NULL. */
const struct numbers_array *numbers_find(const struct numbers *numbers, const char *string);

/* Where in the caller's text a position of the text that is left is. The end
 * of a mark is the end of its array, which `*ended` then is; else NULL. */
size_t numbers_origin(const struct numbers *numbers, size_t position,
                      const struct numbers_array **ended);

#endif
