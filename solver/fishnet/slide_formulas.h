/* SPDX-License-Identifier: MIT */
/*
 * The edge CD of a cell whose weft slides, for numbers and for lanes (`solver/numbers.h`): how long
 * it is, w being D - C, and how that changes with D. `slide.h` has the law.
 *
 * With (x, y) the components of w along the fibre at C and across it, to the side that the weft is
 * on, and t the slope of the straight line from C to the foot of D's characteristic, the tangent q
 * of the shear has
 *
 *     g(q) = q (y - t x) - (x + t y) = 0,     t = t0 + t1 (f(q) - f0),
 *
 * f = l b / a being where the foot is. Newton's method for g takes a step whenever D does. `arc.h`
 * comes before it.
 */
#include "slide.h"
#include "solver/numbers.h"
#include "solver/power_formulas.h"

/* p = (cos g)^-c by 1 + tan^2 g. */
INLINE NUMBER NAME(slide_stretch_by_secant)(double c, NUMBER secant2) {
    return c == 1 ? N(sqrt)(secant2)
                  : NAME(power_exp_normal)(c / 2 * NAME(power_log_normal)(secant2));
}

/* The same by the sine of g. */
INLINE NUMBER NAME(slide_stretch)(double c, NUMBER sine) {
    return NAME(slide_stretch_by_secant)(c, 1 / (1 - sine * sine));
}

/* CD of a cell. */
struct NAME(slide) {
    double c, spacing[2];
    VECTOR along, across;     /* by which chords have the components that the yarn has at C */
    NUMBER mean, rate, foot;  /* t0, t1 and f0, in spacings of warp */
    NUMBER curvature, excess; /* of CD; by which its chord is longer than the law has it */
    NUMBER tangent, stretch, length, chord; /* as they are for the last D */
};

/* Takes in another q. */
INLINE void NAME(slide_set)(struct NAME(slide) * s, NUMBER tangent) {
    s->tangent = tangent;
    s->stretch = NAME(slide_stretch_by_secant)(s->c, 1 + tangent * tangent);
    s->length = s->spacing[1] * s->stretch;
}

/* f by q, and its derivative: b / a times q for parallel fibres. */
INLINE NUMBER NAME(slide_foot)(const struct NAME(slide) * s, NUMBER *rate) {
    double by = s->spacing[1] / s->spacing[0] * s->c;
    *rate = N(of)(by);
    if (s->c == 1)
        return by * s->tangent;
    NUMBER square = s->tangent * s->tangent, secant2 = 1 + square, all = 1 + s->c * square;
    NUMBER inverse = 1 / (secant2 * all);
    NUMBER each = by * s->stretch * N(sqrt)(secant2) * secant2 * inverse;
    *rate = each * (1 + (1 - s->c) * square * (1 - s->c * square) * inverse);
    return each * s->tangent;
}

/* q by a step of Newton's from that at hand, in those `wanted`; t there, and 1 / g'. */
INLINE void NAME(slide_step)(struct NAME(slide) * s, NUMBER x, NUMBER y, MASK wanted, NUMBER *t,
                             NUMBER *inverse) {
    NUMBER q = s->tangent, rate, foot = NAME(slide_foot)(s, &rate);
    *t = s->mean + s->rate * (foot - s->foot);
    rate *= s->rate;
    NUMBER across = y - *t * x;
    *inverse = 1 / (across - rate * (q * x + y));
    NUMBER next = q - (q * across - (x + *t * y)) * *inverse;
    next = N(select)(next > SLIDE_STEEPEST_TANGENT, N(of)(SLIDE_STEEPEST_TANGENT), next);
    next = N(select)(next < -SLIDE_STEEPEST_TANGENT, N(of)(-SLIDE_STEEPEST_TANGENT), next);
    next = N(select)(wanted, next, q);
    *t += rate * (next - q);
    NAME(slide_set)(s, next);
}

/* Takes in w of those `wanted`: the chord that CD is to have, and w less half the gradient of its
 * square. */
INLINE VECTOR NAME(slide_take)(struct NAME(slide) * s, VECTOR w, MASK wanted) {
    NUMBER t, inverse;
    NAME(slide_step)(s, V(dot)(w, s->along), V(dot)(w, s->across), wanted, &t, &inverse);
    NUMBER q = s->tangent, secant2 = 1 + q * q;
    s->chord = NAME(fishnet_arc_chord)(s->length, s->curvature) + s->excess;
    NUMBER turn2 = s->curvature * s->chord / 2;
    turn2 *= turn2;
    NUMBER tilt = 1 - turn2 * (0.5 + turn2 * 0.125); /* the chord by the length */
    NUMBER share = s->chord * tilt * s->length * s->c * q * inverse / secant2;
    return V(axpy)(-share * (1 + t * q), s->along, V(axpy)(share * (q - t), s->across, w));
}

/* q where the weft goes along w, with the length that follows; from that at hand. */
INLINE void NAME(slide_settle)(struct NAME(slide) * s, VECTOR w) {
    NUMBER x = V(dot)(w, s->along), y = V(dot)(w, s->across), t, inverse;
    MASK going = s->tangent == s->tangent;
    for (int round = 0; round < SLIDE_ROUNDS && N(any)(going); round++) {
        NUMBER before = s->tangent;
        NAME(slide_step)(s, x, y, going, &t, &inverse);
        going &= N(not )(N(abs)(s->tangent - before) < SLIDE_SETTLED);
    }
}

/* About the same, w being where D is expected: a step of Newton's from no shear. */
INLINE void NAME(slide_expect)(struct NAME(slide) * s, VECTOR w) {
    NUMBER x = V(dot)(w, s->along), y = V(dot)(w, s->across), t, inverse;
    s->tangent = N(of)(0);
    s->stretch = N(of)(1);
    NAME(slide_step)(s, x, y, x == x, &t, &inverse);
}

/* By how much a fibre turns to the left where it leaves a node along `back` and along `ahead`, unit
 * tangents: twice the angle with this half tangent, to third order. */
INLINE NUMBER NAME(slide_turn)(VECTOR back, VECTOR ahead, VECTOR normal) {
    NUMBER half = -V(dot)(V(cross)(back, ahead), normal) / (1 - V(dot)(back, ahead));
    return 2 * half * (1 - half * half / 3);
}
