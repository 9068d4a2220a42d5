/* SPDX-License-Identifier: MIT */
/*
 * The kernel of `digits.h` for registers of LANES doubles: included by a file that says LANES and
 * DIGITS_KERNEL, and has a target with fused multiplication.
 */
#include "digits.h"

#include "solver/lanes.h"

typedef uint64_t words __attribute__((vector_size(8 * LANES)));
typedef uint32_t halves __attribute__((vector_size(8 * LANES)));
typedef uint16_t quarters __attribute__((vector_size(8 * LANES)));

/* a b + c, rounded once. */
INLINE lanes lanes_fused(lanes a, lanes b, lanes c) {
#if LANES == 8
    return (lanes)_mm512_fmadd_pd((__m512d)a, (__m512d)b, (__m512d)c);
#else
    return (lanes)_mm256_fmadd_pd((__m256d)a, (__m256d)b, (__m256d)c);
#endif
}

/* The nearest whole number; and of whole numbers from 0 to 2^32 the words, below that of 2^52. */
INLINE lanes nearest_whole(lanes x) {
    return (x + 0x1.8p52) - 0x1.8p52;
}

INLINE words whole_words(lanes x) {
    return (words)(x + 0x1p52);
}

/* The whole part of (x + 1/2) / n, n >= 10: that is 1/2n at least from where it changes. */
INLINE lanes whole_quotient(lanes x, lanes reciprocal) {
    return nearest_whole(lanes_fused(x, reciprocal, 0.5 * reciprocal - 0.5));
}

/* The eight digits of a whole number as text, as `eight_digits` of one has them: the division by
 * 10^4 in doubles, those by 100 and 10 in halves and quarters of a word. */
INLINE words eight_digits_lanes(lanes x) {
    lanes upper = whole_quotient(x, lanes_of(1e-4)), lower = x - upper * 1e4;
    words four = (whole_words(lower) << 32) | (whole_words(upper) & 0xffffffff);
    halves p = (halves)four * 10486 >> 20;
    quarters two = (quarters)(((halves)four << 16) + p * (1 - (UINT32_C(100) << 16)));
    quarters q = two * 103 >> 10;
    return (words)((two << 8) + q * (uint16_t)(1 - (10 << 8))) + DIGITS_ZEROS;
}

INLINE void digits_scales_of(const double *values, lanes *high, lanes *low, lanes_mask *point) {
    for (int k = 0; k < LANES; k++) {
        uint64_t bits;
        memcpy(&bits, &values[k], sizeof bits);
        uint64_t row = (bits << 1 >> 53) - DIGITS_SCALES_FIRST;
        const struct digits_scale *scale =
            &digits_scales[row < DIGITS_SCALES ? row : DIGITS_SCALES];
        (*high)[k] = scale->high;
        (*low)[k] = scale->low;
        (*point)[k] = scale->point;
    }
}

/* v 10^-k = whole + small is taken apart as upper D + lower + rest, D = 10^8 or, so that `upper`
 * has nine digits, 10^7; |rest| <= 1/2. Half of the interval of the numbers that round to v is 0.5
 * <= h < 5: the shortest decimal is the multiple of ten in it, at most one, or else upper D +
 * lower. */
INLINE void spell_lanes(const double *values, struct digits_lanes *to, size_t lane) {
    const double unsure = 0x1p-40;
    lanes v = lanes_abs(lanes_load(values)), high = {0}, low = {0};
    lanes_mask point = {0}, bits = (lanes_mask)v, exponent = bits & (INT64_C(0x7ff) << 52);
    digits_scales_of(values, &high, &low, &point);
    lanes half = high * (lanes)(exponent - (INT64_C(53) << 52));
    lanes whole = v * high, small = lanes_fused(v, low, lanes_fused(v, high, -whole));

    lanes_mask sixteen = whole < 1e16;
    lanes divisor = lanes_select(sixteen, lanes_of(1e7), lanes_of(1e8));
    lanes upper = whole_quotient(whole, lanes_select(sixteen, lanes_of(1e-7), lanes_of(1e-8)));
    lanes near = nearest_whole(small), rest = small - near;
    lanes lower = lanes_fused(-upper, divisor, whole) + near;

    lanes tens = whole_quotient(lower, lanes_of(0.1)) * 10, above = lower - tens + rest,
          below = 10 - above;
    lanes_mask take_low = lanes_abs(above) <= half, take_high = below <= half;
    lower = lanes_select(take_low, tens, lanes_select(take_high, tens + 10, lower));
    lanes_mask less = lower < 0, more = lower >= divisor;
    upper +=
        lanes_select(more, lanes_of(1), lanes_of(0)) - lanes_select(less, lanes_of(1), lanes_of(0));
    lower += lanes_select(less, divisor, lanes_of(0)) - lanes_select(more, divisor, lanes_of(0));
    lower *= lanes_select(sixteen, lanes_of(10), lanes_of(1));

    lanes_mask sure = (upper >= 1e8) & (upper < 1e9) & ((bits << 12) != 0) &
                      (lanes_abs(lanes_abs(above) - half) > unsure) &
                      (lanes_abs(below - half) > unsure) & (lanes_abs(rest) < 0.5 - unsure);
    lanes first = whole_quotient(upper, lanes_of(1e-8));
    words text[3] = {whole_words(first + '0'), eight_digits_lanes(upper - first * 1e8),
                     eight_digits_lanes(lower)};
    point += sixteen;
    memcpy(&to->first[lane], &text[0], sizeof text[0]);
    memcpy(&to->next[lane], &text[1], sizeof text[1]);
    memcpy(&to->last[lane], &text[2], sizeof text[2]);
    memcpy(&to->point[lane], &point, sizeof point);
    memcpy(&to->sure[lane], &sure, sizeof sure);
}

void DIGITS_KERNEL(const double *values, size_t count, struct digits_lanes *to) {
    size_t lane = 0;
    for (; lane + LANES <= count; lane += LANES)
        spell_lanes(values + lane, to, lane);
    memset(&to->sure[lane], 0, (DIGITS_TOGETHER - lane) * sizeof *to->sure);
}
