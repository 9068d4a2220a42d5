/* SPDX-License-Identifier: MIT */
/* sin(x) / x for |x| < 1/4, from x^2, for numbers and for lanes (`numbers.h`): six terms of
 * sum_k (-1)^k x^(2k) / (2k+1)! leave less than 1e-16. */
#include "numbers.h"

INLINE NUMBER NAME(angle_small_sinc)(NUMBER square) {
    NUMBER sum = 1.0 / 362880 - square * (1.0 / 39916800);
    sum = 1.0 / 5040 - square * sum;
    sum = 1.0 / 120 - square * sum;
    sum = 1.0 / 6 - square * sum;
    return 1 - square * sum;
}

#ifdef FORMULAS_OF_LANES
/* angle_sinc: lanes of 1/4 and more one by one. */
INLINE lanes angle_sinc_lanes(lanes x) {
    lanes square = x * x, sinc = angle_small_sinc_lanes(square);
    for (unsigned large = ~lanes_bits(square < 0.0625) & LANES_ALL; large; large &= large - 1) {
        int lane = __builtin_ctz(large);
        sinc[lane] = angle_sinc(x[lane]);
    }
    return sinc;
}
#endif
