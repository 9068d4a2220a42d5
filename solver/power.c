/* SPDX-License-Identifier: MIT */
#include "power.h"

#include <math.h>

/* ln 2 in two parts, the first of few bits: a multiple of it by a whole number is exact. */
static const double ln2_high = 0x1.62e42fefap-1, ln2_low = 0x1.cf79abc9e3b3ap-40;

/* x = m 2^e with m next to 1: ln m = 2 artanh t, t = (m - 1) / (m + 1), |t| <= 0.172. */
double power_log(double x) {
    int exponent;
    double m = frexp(x, &exponent);
    if (m < 0.70710678118654752) {
        m *= 2;
        exponent--;
    }
    double t = (m - 1) / (m + 1), square = t * t, sum = 0;
    for (int k = 23; k >= 3; k -= 2)
        sum = (sum + 1.0 / k) * square;
    return exponent * ln2_high + (2 * t * (1 + sum) + exponent * ln2_low);
}

/* e^x = 2^k e^r, |r| <= ln 2 / 2, by Taylor's series. */
double power_exp(double x) {
    if (!(x > -746))
        return x < 0 ? 0 : x;
    if (x > 710)
        return HUGE_VAL;
    double k = nearbyint(x / (ln2_high + ln2_low));
    double r = (x - k * ln2_high) - k * ln2_low, sum = 1;
    for (int n = 15; n >= 1; n--)
        sum = 1 + r / n * sum;
    return ldexp(sum, (int)k);
}

double power_mean(double a, double b, double t) {
    if (!(t > 0))
        return a;
    if (!(t < 1))
        return b;
    return a > 0 && b > 0 ? power_exp((1 - t) * power_log(a) + t * power_log(b)) : 0;
}
