/* SPDX-License-Identifier: MIT */
/*
 * The edge CD of a cell whose weft slides, for numbers and for lanes (`solver/numbers.h`): how long
 * it is, w being D - C, and how that changes with D. `slide.h` has the law.
 *
 * With (x, y) the components of the weft along the fibre at C and to the left of it, and t the
 * slope of the straight line from C to the foot of D's characteristic, the sine s of the shear has
 *
 *     g(s) = s sqrt(1 + t^2) - x - t y = 0,     t = t0 + t1 (l(s) b / a - f0).
 *
 * Newton's method for g takes a step whenever D does. `arc.h` comes before it.
 */
#include "slide.h"
#include "solver/numbers.h"
#include "solver/power_formulas.h"

/* p = (cos g)^-c by the sine of g. */
INLINE NUMBER NAME(slide_stretch)(double c, NUMBER sine) {
    NUMBER cosine2 = 1 - sine * sine;
    return c == 1 ? 1 / N(sqrt)(cosine2)
                  : NAME(power_exp_normal)(-c / 2 * NAME(power_log_normal)(cosine2));
}

/* CD of a cell. */
struct NAME(slide) {
    double c, spacing[2];
    VECTOR along, across;     /* by which chords have the components that the yarn has at C */
    NUMBER mean, rate, foot;  /* t0, t1 and f0, in spacings of warp */
    NUMBER curvature, excess; /* of CD; by which its chord is longer than the law has it */
    NUMBER sine, stretch, length, chord; /* as they are for the last D */
};

/* Takes in another sine. */
INLINE void NAME(slide_set)(struct NAME(slide) * s, NUMBER sine) {
    s->sine = sine;
    s->stretch = NAME(slide_stretch)(s->c, sine);
    s->length = s->spacing[1] * s->stretch;
}

/* s by a step of Newton's from the sine at hand, in those `wanted`; t there, and g'. */
INLINE void NAME(slide_step)(struct NAME(slide) * s, NUMBER x, NUMBER y, MASK wanted, NUMBER *t,
                             NUMBER *rate) {
    NUMBER sine = s->sine, sine2 = sine * sine, cosine2 = 1 - sine2;
    NUMBER all = cosine2 + s->c * sine2, inverse = 1 / (all * cosine2);
    NUMBER each = s->spacing[1] / s->spacing[0] * s->c * s->stretch * cosine2 * inverse;
    *t = s->mean + s->rate * (each * sine - s->foot); /* each: l b / a by the sine */
    NUMBER root = N(sqrt)(1 + *t * *t);
    NUMBER foot_rate = each * (1 + sine2 * inverse * (s->c * all + 2 * (1 - s->c) * cosine2));
    *rate = root + s->rate * foot_rate * (sine * *t / root - y);
    NUMBER next = sine - (sine * root - x - *t * y) / *rate;
    next = N(select)(next > SLIDE_STEEPEST, N(of)(SLIDE_STEEPEST), next);
    next = N(select)(next < -SLIDE_STEEPEST, N(of)(-SLIDE_STEEPEST), next);
    NAME(slide_set)(s, N(select)(wanted, next, sine));
}

/* How much of w goes along the fibre at C, and to the left of it; and one by its size. */
INLINE NUMBER NAME(slide_parts)(const struct NAME(slide) * s, VECTOR w, NUMBER *x, NUMBER *y) {
    *x = V(dot)(w, s->along);
    *y = V(dot)(w, s->across);
    NUMBER inverse = 1 / N(sqrt)(*x * *x + *y * *y);
    *x *= inverse;
    *y *= inverse;
    return inverse;
}

/* Takes in w of those `wanted`: the chord that CD is to have, and w less half the gradient of its
 * square. */
INLINE VECTOR NAME(slide_take)(struct NAME(slide) * s, VECTOR w, MASK wanted) {
    NUMBER x, y, t, rate, inverse = NAME(slide_parts)(s, w, &x, &y);
    NAME(slide_step)(s, x, y, wanted, &t, &rate);
    NUMBER sine = s->sine, mean = x + t * y;
    s->chord = NAME(fishnet_arc_chord)(s->length, s->curvature) + s->excess;
    NUMBER turn = s->curvature * s->chord / 2;
    NUMBER tilt = N(sqrt)(1 - turn * turn); /* the chord by the length */
    NUMBER by_sine = s->chord * tilt * s->length * s->c * sine / (1 - sine * sine);
    NUMBER share = by_sine * inverse / rate;
    return V(axpy)(-share * (1 - mean * x), s->along,
                   V(axpy)(-share * (t - mean * y), s->across, w));
}

/* The sine where the weft goes along w, with the length that follows; from the sine at hand. */
INLINE void NAME(slide_settle)(struct NAME(slide) * s, VECTOR w) {
    NUMBER x, y, t, rate;
    (void)NAME(slide_parts)(s, w, &x, &y);
    MASK going = s->sine == s->sine;
    for (int round = 0; round < SLIDE_ROUNDS && N(any)(going); round++) {
        NUMBER before = s->sine;
        NAME(slide_step)(s, x, y, going, &t, &rate);
        going &= N(not )(N(abs)(s->sine - before) < SLIDE_SETTLED);
    }
}

/* Where the foot of D's characteristic is about, in spacings of warp ahead of C. */
INLINE NUMBER NAME(slide_foot)(const struct NAME(slide) * s) {
    NUMBER sine2 = s->sine * s->sine;
    return s->c * s->stretch * s->sine / (1 - sine2 + s->c * sine2) *
           (s->spacing[1] / s->spacing[0]);
}

/* By how much a fibre turns to the left where it leaves a node along `back` and along `ahead`, unit
 * tangents: twice the angle with this half tangent, to third order. */
INLINE NUMBER NAME(slide_turn)(VECTOR back, VECTOR ahead, VECTOR normal) {
    NUMBER half = -V(dot)(V(cross)(back, ahead), normal) / (1 - V(dot)(back, ahead));
    return 2 * half * (1 - half * half / 3);
}
