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

#ifdef FORMULAS_OF_LANES
INLINE lanes slide_stretch_lanes(double c, lanes sine) {
    lanes stretch = lanes_sqrt(1 - sine * sine);
    for (int k = 0; k < LANES && c != 1; k++)
        stretch[k] = 1 / slide_stretch(c, sine[k]);
    return 1 / stretch;
}
#endif

/* CD of a cell. */
struct NAME(slide) {
    double c, spacing[2];
    VECTOR along, across;       /* by which chords have the components that the yarn has at C */
    double mean, rate, foot;    /* t0, t1 and f0, in spacings of warp */
    double curvature, excess;   /* of CD; by which its chord is longer than the law has it */
    NUMBER sine, length, chord; /* as they are for the last D */
};

/* s by a step of Newton's from the sine at hand; m = x + t y, and g' there. */
INLINE void NAME(slide_step)(struct NAME(slide) * s, NUMBER x, NUMBER y, NUMBER *t, NUMBER *rate) {
    NUMBER sine = s->sine, sine2 = sine * sine, cosine2 = 1 - sine2;
    NUMBER all = cosine2 + s->c * sine2, ratio = N(of)(s->spacing[1] / s->spacing[0]);
    NUMBER each = ratio * s->c * NAME(slide_stretch)(s->c, sine) / all; /* l b / a by the sine */
    *t = s->mean + s->rate * (each * sine - s->foot);
    NUMBER root = N(sqrt)(1 + *t * *t);
    NUMBER foot_rate = each * (1 + sine2 * (s->c / cosine2 + 2 * (1 - s->c) / all));
    *rate = root + s->rate * foot_rate * (sine * *t / root - y);
    sine -= (sine * root - x - *t * y) / *rate;
    sine = N(select)(sine > SLIDE_STEEPEST, N(of)(SLIDE_STEEPEST), sine);
    s->sine = N(select)(sine < -SLIDE_STEEPEST, N(of)(-SLIDE_STEEPEST), sine);
}

/* Takes in w: the chord that CD is to have, and w less half the gradient of its square. */
INLINE VECTOR NAME(slide_take)(struct NAME(slide) * s, VECTOR w) {
    NUMBER x = V(dot)(w, s->along), y = V(dot)(w, s->across), t, rate;
    NUMBER inverse = 1 / N(sqrt)(x * x + y * y);
    x *= inverse;
    y *= inverse;
    NAME(slide_step)(s, x, y, &t, &rate);
    NUMBER sine = s->sine, mean = x + t * y;
    s->length = s->spacing[1] * NAME(slide_stretch)(s->c, sine);
    s->chord = NAME(fishnet_arc_chord)(s->length, N(of)(s->curvature)) + s->excess;
    NUMBER turn = s->curvature * s->chord / 2;
    NUMBER tilt = N(sqrt)(1 - turn * turn); /* the chord by the length */
    NUMBER by_sine = s->chord * tilt * s->length * s->c * sine / (1 - sine * sine);
    NUMBER share = by_sine * inverse / rate;
    return V(axpy)(-share * (1 - mean * x), s->along,
                   V(axpy)(-share * (t - mean * y), s->across, w));
}
