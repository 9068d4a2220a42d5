/* SPDX-License-Identifier: MIT */
/* The formulas of `correction.h`, for numbers and for lanes (`solver/numbers.h`). */
#include "solver/numbers.h"

/* The square of a chord over that of d, from q and p. */
INLINE NUMBER NAME(correction_share)(NUMBER q, NUMBER p) {
    return 1 - q * (1.0 / 12) - p * (23.0 / 720 + q * 0.001786);
}

/* p d^2, with M the mean of D2 and D3 its change over the edge, from |M|^2, M . D3 and |D3|^2. */
INLINE NUMBER NAME(correction_across)(NUMBER m2, NUMBER m3, NUMBER third2) {
    return third2 - m3 * m3 / (m2 + CORRECTION_STRAIGHT);
}

/* The chord of an edge that is d long, by D2 at both its ends; `holds` says whether it is that of a
 * yarn. */
INLINE NUMBER NAME(correction_chord_of)(VECTOR near, VECTOR far, double d, MASK *holds) {
    VECTOR mean = V(scale)(N(of)(0.5), V(add)(near, far)), change = V(sub)(far, near);
    NUMBER m2 = V(norm2)(mean);
    NUMBER across = NAME(correction_across)(m2, V(dot)(mean, change), V(norm2)(change));
    NUMBER share = NAME(correction_share)(m2 / (d * d), across / (d * d));
    *holds = share > CORRECTION_SHORTEST;
    return d * N(sqrt)(share);
}

/* Whether D2 agrees with the normal curvature at a point. */
INLINE MASK NAME(correction_bend_agrees)(VECTOR bend, double d, const POINT *point,
                                         NUMBER curvature) {
    NUMBER expected = N(abs)(curvature) * d * d;
    NUMBER net = N(abs)(NAME(surface_point_gauss_curvature)(point)) * d * d;
    NUMBER miss = N(abs)(V(dot)(bend, point->normal) - curvature * d * d);
    NUMBER apart = CORRECTION_APART + CORRECTION_APART_SHARE * net;
    return (miss <= CORRECTION_SHARE * expected + CORRECTION_LEAST * d) &
           (miss * expected <= CORRECTION_PRODUCT * apart * d * d);
}
