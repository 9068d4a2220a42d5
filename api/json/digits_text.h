/* SPDX-License-Identifier: MIT */
/* From the digits of a number to its text, for `shortest.c` and `number_list.c`. */
#ifndef API_JSON_DIGITS_TEXT_H
#define API_JSON_DIGITS_TEXT_H

#include "digits.h"
#include <endian.h>
#include <stdbool.h>
#include <stddef.h>
#include <string.h>

/* A number's digits as text, the last ones zero: one, eight and eight. */
struct digits {
    char first;
    uint64_t next, last; /* the first digit in the lowest byte */
    int count;           /* without zeros at the end; at least 1 */
    int point;           /* how many stand before the point; where negative, zeros that follow it */
};

/* Zeros at the end of eight digits that are not all zero. */
static inline int digits_end_zeros(uint64_t digits) {
    return __builtin_clzll(digits ^ DIGITS_ZEROS) / 8;
}

static inline struct digits digits_of(char first, uint64_t next, uint64_t last, int point) {
    struct digits digits = {.first = first, .next = next, .last = last, .count = 1, .point = point};
    if (last != DIGITS_ZEROS)
        digits.count = DIGITS_MAX - digits_end_zeros(last);
    else if (next != DIGITS_ZEROS)
        digits.count = DIGITS_MAX - 8 - digits_end_zeros(next);
    return digits;
}

static inline void digits_put(char *text, uint64_t eight) {
    eight = htole64(eight);
    memcpy(text, &eight, sizeof eight);
}

static inline void digits_put_rest(char *text, struct digits digits) {
    digits_put(text, digits.next);
    digits_put(text + 8, digits.last);
}

/* d.ddde-XX */
static inline size_t digits_write_scientific(char *text, struct digits digits) {
    size_t length = digits.count > 1 ? (size_t)digits.count + 1 : 1;
    int exponent = 1 - digits.point;
    text[0] = digits.first;
    text[1] = '.';
    digits_put_rest(text + 2, digits);
    text[length++] = 'e';
    text[length++] = '-';
    text[length++] = (char)('0' + exponent / 10);
    text[length++] = (char)('0' + exponent % 10);
    return length;
}

/* Where digits stand before the point, those of the eight that it is among are written twice: as if
 * there were none, and again, without those before it, behind it. */
static inline size_t digits_write_fixed(char *text, struct digits digits) {
    int count = digits.count, point = digits.point;
    if (point <= 0) {
        memcpy(text, "0.000", 5);
        text[2 - point] = digits.first;
        digits_put_rest(text + 3 - point, digits);
        return (size_t)(2 - point + count);
    }
    text[0] = digits.first;
    digits_put(text + 1, digits.next);
    if (point <= 8) {
        digits_put(text + point + 1, digits.next >> 8 * (point - 1));
        digits_put(text + 10, digits.last);
    } else {
        digits_put(text + 9, digits.last);
        if (point < count)
            digits_put(text + point + 1, digits.last >> 8 * (point - 9));
    }
    if (point == count)
        return (size_t)count;
    text[point] = '.';
    return (size_t)count + 1;
}

/* The text, fixed where that is not longer. 0 of a whole number that ends in zeros, where which
 * form is shorter is for others to say, and of very small ones. */
static inline size_t digits_write(char *text, size_t sign, struct digits digits) {
    *text = '-';
    if (digits.point > digits.count || digits.point < -98)
        return 0;
    bool fixed = digits.point > -3 || (digits.point == -3 && digits.count > 1);
    return sign + (fixed ? digits_write_fixed(text + sign, digits)
                         : digits_write_scientific(text + sign, digits));
}

#endif
