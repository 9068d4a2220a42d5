/* SPDX-License-Identifier: MIT */
/* Logarithm and exponential away from the ends of their ranges, for numbers and for lanes
 * (`numbers.h`); `power.h` has all of them. */
#include "numbers.h"

#ifndef SOLVER_POWER_FORMULAS_H
#define SOLVER_POWER_FORMULAS_H

/* ln 2 in two parts, the first of few bits: a multiple of it by a whole number is exact. */
#define POWER_LN2_HIGH 0x1.62e42fefap-1
#define POWER_LN2_LOW 0x1.cf79abc9e3b3ap-40

/* Added and taken away again it leaves whole numbers below 2^51. */
#define POWER_WHOLE 0x1.8p52

enum { POWER_ORDER = 15 };
static const double power_inverse[POWER_ORDER + 1] = {
    0,       1,       1.0 / 2, 1.0 / 3,  1.0 / 4,  1.0 / 5,  1.0 / 6,  1.0 / 7,
    1.0 / 8, 1.0 / 9, 0.1,     1.0 / 11, 1.0 / 12, 1.0 / 13, 1.0 / 14, 1.0 / 15};

#endif

/* ln x for x > 0, normal and finite: x = m 2^e with m next to 1, ln m = 2 artanh t,
 * t = (m - 1) / (m + 1), |t| <= 0.172. */
INLINE NUMBER NAME(power_log_normal)(NUMBER x) {
    NUMBER exponent, m = N(split)(x, &exponent);
    MASK small = m < 0.70710678118654752;
    m = N(select)(small, 2 * m, m);
    exponent = N(select)(small, exponent - 1, exponent);
    NUMBER t = (m - 1) / (m + 1), square = t * t, sum = N(of)(0);
    _Pragma("GCC unroll 11") for (int k = 23; k >= 3; k -= 2) sum = (sum + 1.0 / k) * square;
    return exponent * POWER_LN2_HIGH + (2 * t * (1 + sum) + exponent * POWER_LN2_LOW);
}

/* e^x = 2^k e^r, in lanes for |x| <= 700, |r| <= ln 2 / 2, by Taylor's series. */
INLINE NUMBER NAME(power_exp_normal)(NUMBER x) {
    NUMBER k = (x / (POWER_LN2_HIGH + POWER_LN2_LOW) + POWER_WHOLE) - POWER_WHOLE;
    NUMBER r = (x - k * POWER_LN2_HIGH) - k * POWER_LN2_LOW, sum = N(of)(1);
    _Pragma("GCC unroll 15") for (int n = POWER_ORDER; n >= 1; n--) sum =
        1 + r * power_inverse[n] * sum;
    return N(scale2)(sum, k);
}
