/* SPDX-License-Identifier: MIT */
/*
 * The digits of several numbers at once, for `number_list.c`: the short way of `shortest.c`, one
 * number a lane, in doubles. With 10^-k known to twice the digits of a double (`powers.h`), |v|
 * 10^-k is the sum of a whole double and a small one, exact to 2^-48; all that follows is about
 * numbers with few digits, which doubles have exactly. Where that leaves a doubt, or the number is
 * not of the magnitudes that results have, a lane is not sure and its digits are those of nothing.
 */
#ifndef API_JSON_DIGITS_H
#define API_JSON_DIGITS_H

#include <stddef.h>
#include <stdint.h>

enum {
    DIGITS_MAX = 17,     /* significant digits of a double */
    DIGITS_TOGETHER = 32 /* numbers, so that a kernel's constants are made ready for many */
};
#define DIGITS_ZEROS UINT64_C(0x3030303030303030) /* "00000000" */

/* 10^-k = high + low for the numbers of one binary exponent, of which 10^k is at most the distance
 * between two; `point` is 17 + k. The last row, of zeros, is for all other numbers. */
struct digits_scale {
    double high, low;
    int64_t point;
};
enum {
    DIGITS_SCALES_FIRST = 890, /* 2^-133, biased; up to 2^56 */
    DIGITS_SCALES = 190
};
extern const struct digits_scale digits_scales[DIGITS_SCALES + 1];

/* By lane: the first of 17 digits, in the lowest byte, the eight that follow and the last eight, as
 * text with the first one in the lowest byte; how many stand before the point; and whether that is
 * sure. */
struct digits_lanes {
    uint64_t first[DIGITS_TOGETHER], next[DIGITS_TOGETHER], last[DIGITS_TOGETHER];
    int64_t point[DIGITS_TOGETHER], sure[DIGITS_TOGETHER];
};

/* Of at most DIGITS_TOGETHER numbers, whatever they are; for processors with AVX2 and fused
 * multiplication, and with AVX-512. The lanes of those that
 * fill no register, and of none, are not sure. */
typedef void digits_kernel(const double *values, size_t count, struct digits_lanes *to);
digits_kernel digits_kernel_4, digits_kernel_8;

#endif
