/* SPDX-License-Identifier: MIT */
#include "shortest.h"

#include <endian.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "powers.h"

enum { FRACTION_BITS = 52, EXPONENT_MASK = 0x7ff, BIAS = 1075, DIGITS_MAX = 17 };

__extension__ typedef unsigned __int128 wide;

/* digits * 10^exponent */
struct decimal {
    uint64_t digits;
    int exponent;
};

/* ---- from binary to decimal ---- */

/* floor(log10 2^e), or with `three_quarters` floor(log10 (3/4) 2^e); floor(log2 10^e). */
static int floor_log10(int e, bool three_quarters) {
    return (e * 1262611 - (three_quarters ? 524031 : 0)) >> 22;
}

static int floor_log2_power(int e) {
    return (e * 1741647) >> 19;
}

/* The high 64 bits of g times c, the last one set when anything below is (but for g's own error).
 */
static inline uint64_t round_to_odd(const uint64_t g[2], uint64_t c) {
    wide low = (wide)g[1] * c;
    wide high = (wide)g[0] * c + (uint64_t)(low >> 64);
    return (uint64_t)(high >> 64) | ((uint64_t)high > 1);
}

/* The shortest decimal that lies in the interval of numbers which round to c 2^q, and of those the
 * closest. `narrow`: the interval reaches only half as far down, at a power of two. All bounds are
 * kept times four. */
static struct decimal shortest_decimal(uint64_t c, int q, bool narrow) {
    uint64_t odd = c & 1;
    int k = floor_log10(q, narrow), shift = q + floor_log2_power(-k) + 1;
    const uint64_t *g = powers[-k - POWERS_FIRST];
    uint64_t low = round_to_odd(g, (4 * c - 2 + narrow) << shift) + odd;
    uint64_t value = round_to_odd(g, (4 * c) << shift);
    uint64_t high = round_to_odd(g, (4 * c + 2) << shift) - odd;
    uint64_t s = value / 4, tens = s / 10;
    if (s >= 10) {
        bool below = low <= 40 * tens, above = 40 * tens + 40 <= high;
        if (below != above)
            return (struct decimal){tens + above, k + 1};
    }
    bool below = low <= 4 * s, above = 4 * s + 4 <= high;
    if (below != above)
        return (struct decimal){s + above, k};
    uint64_t middle = 4 * s + 2;
    return (struct decimal){s + (value > middle || (value == middle && (s & 1))), k};
}

/* The same without the exact bounds: 60 bits of the fraction tell on which side of a bound a number
 * is, but for about one of 2^57. With half of the interval h, 0.5 <= h < 5, the nearest whole
 * number s is always in the interval, and at most one multiple of ten. False where it takes all
 * bits. */
static inline bool shorten_soon(uint64_t c, int q, struct decimal *decimal) {
    const uint64_t one = (uint64_t)1 << 60, unsure = 4;
    int k = floor_log10(q, false), shift = q + floor_log2_power(-k) + 1;
    const uint64_t *g = powers[-k - POWERS_FIRST];
    uint64_t h = g[0] >> (5 - shift), factor = 4 * c << shift;
    wide value = (wide)g[0] * factor + (uint64_t)((wide)g[1] * factor >> 64);
    uint64_t s = (uint64_t)(value >> 66), fraction = (uint64_t)(value >> 6) & (one - 1);
    uint64_t tens = s / 10 * 10, above = (s - tens) * one + fraction, below = 10 * one - above;
    uint64_t digits = s + (fraction > one / 2);
    digits = below <= h ? tens + 10 : digits;
    digits = above <= h ? tens : digits;
    *decimal = (struct decimal){digits, k};
    return !((above - h + unsure <= 2 * unsure) | (below - h + unsure <= 2 * unsure) |
             (fraction - one / 2 + unsure <= 2 * unsure));
}

/* ---- digits ---- */

/* A number's digits as text, the last ones zero: one, eight and eight. */
struct digits {
    char first;
    uint64_t next, last; /* in the order of memory */
    int count;           /* without zeros at the end; at least 1 */
    int point;           /* how many stand before the point; where negative, zeros that follow it */
};

static const uint64_t zeros = 0x3030303030303030; /* "00000000" */

/* The digits of eight as text, the first in the lowest byte: quotients by 100 and 10 are taken of
 * all lanes of a word at once. A lane of x has its quotient p by n and its remainder in place after
 * p + (x - n p) 2^bits = x 2^bits + p (1 - n 2^bits). */
static inline uint64_t eight_digits(uint64_t x) {
    uint64_t p = x * 3518437209 >> 45;
    x = (x << 32) + p * (1 - (UINT64_C(10000) << 32));
    p = (x * 10486 >> 20) & 0x0000007f0000007f;
    x = (x << 16) + p * (1 - (UINT64_C(100) << 16));
    p = (x * 103 >> 10) & 0x000f000f000f000f;
    return (x << 8) + p * (1 - (UINT64_C(10) << 8)) + zeros;
}

/* Zeros at the end of eight digits that are not all zero. */
static inline int end_zeros(uint64_t digits) {
    return __builtin_clzll(digits ^ zeros) / 8;
}

static inline struct digits spell(struct decimal decimal) {
    const uint64_t seventeen = 10000000000000000, eight = 100000000;
    while (decimal.digits < seventeen) { /* of most numbers once or not at all */
        decimal.digits *= 10;
        decimal.exponent--;
    }
    uint64_t first = decimal.digits / seventeen, rest = decimal.digits - first * seventeen;
    uint64_t next = rest / eight;
    struct digits digits = {.first = (char)('0' + first),
                            .next = eight_digits(next),
                            .last = eight_digits(rest - next * eight),
                            .count = 1,
                            .point = DIGITS_MAX + decimal.exponent};
    if (digits.last != zeros)
        digits.count = DIGITS_MAX - end_zeros(digits.last);
    else if (digits.next != zeros)
        digits.count = DIGITS_MAX - 8 - end_zeros(digits.next);
    digits.next = htole64(digits.next);
    digits.last = htole64(digits.last);
    return digits;
}

/* ---- text ---- */

static inline void put_rest(char *text, const struct digits *digits) {
    memcpy(text, &digits->next, sizeof digits->next);
    memcpy(text + sizeof digits->next, &digits->last, sizeof digits->last);
}

/* d.ddde-XX */
static size_t write_scientific(char *text, const struct digits *digits) {
    size_t length = digits->count > 1 ? (size_t)digits->count + 1 : 1;
    int exponent = 1 - digits->point;
    text[0] = digits->first;
    text[1] = '.';
    put_rest(text + 2, digits);
    text[length++] = 'e';
    text[length++] = '-';
    text[length++] = (char)('0' + exponent / 10);
    text[length++] = (char)('0' + exponent % 10);
    return length;
}

static inline size_t write_fixed(char *text, const struct digits *digits) {
    int count = digits->count, point = digits->point;
    if (point == 1) {
        text[0] = digits->first;
        text[1] = '.';
        put_rest(text + 2, digits);
        return count > 1 ? (size_t)count + 1 : 1;
    }
    if (point <= 0) {
        memcpy(text, "0.000", 5);
        text[2 - point] = digits->first;
        put_rest(text + 3 - point, digits);
        return (size_t)(2 - point + count);
    }
    text[0] = digits->first;
    put_rest(text + 1, digits);
    if (point == count)
        return (size_t)count;
    memmove(text + point + 1, text + point, (size_t)(count - point));
    text[point] = '.';
    return (size_t)count + 1;
}

size_t shortest_write(char *text, double value) {
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    uint64_t fraction = bits & (((uint64_t)1 << FRACTION_BITS) - 1);
    int exponent = (int)(bits >> FRACTION_BITS & EXPONENT_MASK);
    size_t sign = bits >> 63;
    if (exponent == 0 || exponent == EXPONENT_MASK)
        return 0;
    uint64_t c = fraction | (uint64_t)1 << FRACTION_BITS;
    struct decimal decimal;
    if (fraction == 0 || !shorten_soon(c, exponent - BIAS, &decimal))
        decimal = shortest_decimal(c, exponent - BIAS, fraction == 0 && exponent > 1);
    struct digits digits = spell(decimal);
    *text = '-';
    /* Fixed where that is not longer. Of a whole number that ends in zeros, which form is shorter
     * is for others to say. */
    if (digits.point > digits.count || digits.point < -98)
        return 0;
    bool fixed = digits.point > -3 || (digits.point == -3 && digits.count > 1);
    return sign +
           (fixed ? write_fixed(text + sign, &digits) : write_scientific(text + sign, &digits));
}
