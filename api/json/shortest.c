/* SPDX-License-Identifier: MIT */
#include "shortest.h"

#include "digits_text.h"
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

#include "powers.h"

enum { FRACTION_BITS = 52, EXPONENT_MASK = 0x7ff, BIAS = 1075 };

__extension__ typedef unsigned __int128 wide;

const struct digits_scale digits_scales[DIGITS_SCALES + 1] = {POWERS_SCALES};

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

/* The digits of eight as text, the first in the lowest byte: quotients by 100 and 10 are taken of
 * all lanes of a word at once. A lane of x has its quotient p by n and its remainder in place after
 * p + (x - n p) 2^bits = x 2^bits + p (1 - n 2^bits). */
static inline uint64_t eight_digits(uint64_t x) {
    uint64_t p = x * 3518437209 >> 45;
    x = (x << 32) + p * (1 - (UINT64_C(10000) << 32));
    p = (x * 10486 >> 20) & 0x0000007f0000007f;
    x = (x << 16) + p * (1 - (UINT64_C(100) << 16));
    p = (x * 103 >> 10) & 0x000f000f000f000f;
    return (x << 8) + p * (1 - (UINT64_C(10) << 8)) + DIGITS_ZEROS;
}

static inline struct digits spell(struct decimal decimal) {
    const uint64_t seventeen = 10000000000000000, eight = 100000000;
    while (decimal.digits < seventeen) { /* of most numbers once or not at all */
        decimal.digits *= 10;
        decimal.exponent--;
    }
    uint64_t first = decimal.digits / seventeen, rest = decimal.digits - first * seventeen;
    uint64_t next = rest / eight;
    return digits_of((char)('0' + first), eight_digits(next), eight_digits(rest - next * eight),
                     DIGITS_MAX + decimal.exponent);
}

size_t shortest_write(char *text, double value) {
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    uint64_t fraction = bits & (((uint64_t)1 << FRACTION_BITS) - 1);
    int exponent = (int)(bits >> FRACTION_BITS & EXPONENT_MASK);
    if (exponent == 0 || exponent == EXPONENT_MASK)
        return 0;
    uint64_t c = fraction | (uint64_t)1 << FRACTION_BITS;
    struct decimal decimal;
    if (fraction == 0 || !shorten_soon(c, exponent - BIAS, &decimal))
        decimal = shortest_decimal(c, exponent - BIAS, fraction == 0 && exponent > 1);
    return digits_write(text, bits >> 63, spell(decimal));
}
