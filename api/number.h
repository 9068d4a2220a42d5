/* SPDX-License-Identifier: MIT */
/*
 * Decimal text of numbers, by C++17's std::to_chars: no locale, no allocation, the shortest decimal
 * that reads back to the same double. The text is valid JSON and is not zero-terminated.
 */
#ifndef API_NUMBER_H
#define API_NUMBER_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

enum {
    API_NUMBER_SIZE = 32,     /* room that every text fits in */
    API_PRECISION_EXACT = 17, /* significant digits beyond which none says more */
};

/* Write `value`, which must be finite, to `text` (API_NUMBER_SIZE bytes) and return the length:
 * the shortest text that reads back to it, or rounded to `digits` significant digits (1..17). */
size_t api_number_shortest(char *text, double value);
size_t api_number_rounded(char *text, double value, int digits);

size_t api_number_integer(char *text, int64_t value);

#ifdef __cplusplus
}
#endif

#endif
