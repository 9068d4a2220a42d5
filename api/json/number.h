/* SPDX-License-Identifier: MIT */
/*
 * Decimal text of numbers, by `shortest.h` and C++17's std::to_chars: no locale, no allocation, the
 * shortest decimal that reads back to the same double. The text is valid JSON and is not
 * zero-terminated.
 */
#ifndef API_JSON_NUMBER_H
#define API_JSON_NUMBER_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum {
    API_NUMBER_SIZE = 32,     /* room that every text fits in */
    API_PRECISION_EXACT = 17, /* significant digits; more would add nothing */
    API_PRECISION_WHOLE = -1, /* of a list of whole numbers */
};

/* Write `value`, which must be finite, to `text` (API_NUMBER_SIZE bytes) and return the length:
 * the shortest text that reads back to it, or rounded to `digits` significant digits (1..17). */
size_t api_number_shortest(char *text, double value);
size_t api_number_rounded(char *text, double value, int digits);

/* The text of api_number_shortest, always by the standard library: what the tests compare with. */
size_t api_number_by_library(char *text, double value);

/* With commas between them the texts of api_number_shortest (`digits` 0), of api_number_rounded, or
 * of api_number_integer (API_PRECISION_WHOLE), and "null" for what is NaN; `text` has
 * API_NUMBER_SIZE bytes for each. What has the bits of the number before it is not found anew:
 * columns of one value (a fibre volume fraction, say) are common. */
size_t api_number_list(char *text, const double *values, size_t count, int digits);

size_t api_number_integer(char *text, int64_t value);

/* Behind the number that JSON has at `text`, before `end`: -? (0 | [1-9][0-9]*) (. [0-9]+)?
 * ([eE] [+-]? [0-9]+)?; NULL when there is none. */
const char *api_number_end(const char *text, const char *end);

/* Reads the decimal at the start of the `length` characters at `text`, as JSON has it but also with
 * nothing before or behind its point; exactly rounded, too small a number is 0. Returns how many
 * characters it takes, 0 when there is none or it is beyond the doubles. */
size_t api_number_read(const char *text, size_t length, double *value);

#ifdef __cplusplus
}
#endif

#endif
