/* SPDX-License-Identifier: MIT */
/*
 * The formulas of a cell's fourth corner, for numbers and for lanes (`solver/numbers.h`): Newton's
 * method for F(u, v) = (|r - B|^2 - bd^2, |r - C|^2 - cd^2) / 2, and which root of it is D.
 */
#include "fishnet_limits.h"
#include "slide_formulas.h"
#include "solver/numbers.h"

/* A cell, and D on the way to its corner; where that is, and the surface there, is kept apart: by
 * the points of the net, without a copy. */
struct NAME(corner) {
    VECTOR a, b, c;
    NUMBER bd, cd, bd2, cd2, inverse[2]; /* chords, their squares, and one by these */
    VECTOR wb, wc;                       /* D - B, D - C */
    VECTOR gradient;    /* of F's second part: D - C, or less what cd^2 / 2 changes with D */
    NUMBER f[2], error; /* F, and the larger relative error of the lengths */
    NUMBER iterations;
};

INLINE void NAME(square_chords)(struct NAME(corner) * d) {
    d->bd2 = d->bd * d->bd;
    d->cd2 = d->cd * d->cd;
    d->inverse[0] = 1 / d->bd2;
    d->inverse[1] = 1 / d->cd2;
}

INLINE void NAME(find_error)(struct NAME(corner) * d) {
    d->f[0] = (V(norm2)(d->wb) - d->bd2) / 2;
    d->f[1] = (V(norm2)(d->wc) - d->cd2) / 2;
    NUMBER b = N(abs)(d->f[0]) * d->inverse[0], c = N(abs)(d->f[1]) * d->inverse[1];
    d->error = N(select)(b > c, b, c);
}

/* Of cells whose weft slides: the chord of those `wanted` for the D at hand. */
INLINE void NAME(slide_chord)(struct NAME(corner) * d, struct NAME(slide) * slide, MASK wanted) {
    d->gradient = V(select)(wanted, NAME(slide_take)(slide, d->wc, wanted), d->gradient);
    d->cd = slide->chord;
    d->cd2 = d->cd * d->cd;
    d->inverse[1] = 1 / d->cd2;
}

/* The error of the lengths that is enough, `least` being the shorter chord. */
INLINE NUMBER NAME(enough_error)(const struct surface *surface, NUMBER least) {
    return FISHNET_TOLERANCE + FISHNET_ROUNDING * surface->magnitude / least;
}

/* Whether Newton's method ends here: the error is within the limit, or rounding that steps do not
 * reduce; or `settle` leaves no more than rounding where a step of this size (squared, by that of
 * the edge; 0: unknown) led to it. With T the third derivatives, the error is T s^3 / 6, and by T
 * times the last step the second derivatives are wrong, from which the next chords come. */
INLINE MASK NAME(has_converged)(NUMBER error, NUMBER limit, NUMBER share2, NUMBER previous) {
    NUMBER wrong = 6 * error * error;
    return (error <= limit) |
           (wrong * wrong < FISHNET_NEGLIGIBLE * FISHNET_NEGLIGIBLE * share2 * share2 * share2) |
           ((error >= previous) & (error <= FISHNET_STAGNATION));
}

/* Solves J step = f with the rows of J being w . (r_u, r_v). */
struct NAME(linear) {
    NUMBER a, b, c, d, inverse;
};

INLINE struct NAME(linear) NAME(linear_make)(VECTOR u, VECTOR v, VECTOR wb, VECTOR wc) {
    struct NAME(linear) m = {V(dot)(wb, u), V(dot)(wb, v), V(dot)(wc, u), V(dot)(wc, v), N(of)(0)};
    m.inverse = 1 / (m.a * m.d - m.b * m.c);
    return m;
}

INLINE void NAME(linear_solve)(const struct NAME(linear) * m, NUMBER f1, NUMBER f2,
                               NUMBER step[2]) {
    step[0] = (m->d * f1 - m->b * f2) * m->inverse;
    step[1] = (m->a * f2 - m->c * f1) * m->inverse;
}

/* e, the way from D by a step on the surface taken as a paraboloid, and r_u, r_v there. */
INLINE VECTOR NAME(model_step)(const JET *jet, const NUMBER s[2], VECTOR *there_u,
                               VECTOR *there_v) {
    VECTOR u = V(axpy)(s[1], jet->uv, V(scale)(s[0], jet->uu));
    VECTOR v = V(axpy)(s[1], jet->vv, V(scale)(s[0], jet->uv));
    *there_u = V(add)(jet->u, u);
    *there_v = V(add)(jet->v, v);
    u = V(axpy)(N(of)(0.5), u, jet->u);
    v = V(axpy)(N(of)(0.5), v, jet->v);
    return V(axpy)(s[1], v, V(scale)(s[0], u));
}

/* Newton's step, and more of them for the paraboloid that has the derivatives at hand,
 * F + w . e + |e|^2 / 2 = 0: those cost a fraction of an evaluation, and leave the third
 * derivatives' share of the error alone. Which of those `wanted` have a step. `slide`: of a cell
 * whose weft slides, or NULL. */
INLINE MASK NAME(newton_step)(const struct NAME(corner) * d, const JET *jet,
                              struct NAME(slide) * slide, MASK wanted, NUMBER step[2]) {
    struct NAME(linear) linear = NAME(linear_make)(jet->u, jet->v, d->wb, d->gradient);
    NAME(linear_solve)(&linear, -d->f[0], -d->f[1], step);
    NUMBER whole = N(abs)(step[0]) + N(abs)(step[1]);
    MASK going = (d->error > FISHNET_MODEL_LEAST) & wanted;
    wanted &= N(finite)(linear.inverse);
    for (int round = 0; round < FISHNET_MODEL_ROUNDS && N(any)(going); round++) {
        NUMBER more[2];
        VECTOR u, v, e = NAME(model_step)(jet, step, &u, &v);
        NUMBER half = V(norm2)(e) / 2, second = d->f[1] + V(dot)(d->wc, e) + half;
        VECTOR gradient = V(add)(d->wc, e);
        if (slide) {
            gradient = NAME(slide_take)(slide, gradient, going);
            second += (d->cd2 - slide->chord * slide->chord) / 2;
        }
        linear = NAME(linear_make)(u, v, V(add)(d->wb, e), gradient);
        NAME(linear_solve)(&linear, -(d->f[0] + V(dot)(d->wb, e) + half), -second, more);
        NUMBER size = N(abs)(more[0]) + N(abs)(more[1]);
        going &= N(finite)(linear.inverse) & (size < 0.5 * whole);
        for (int k = 0; k < 2; k++)
            step[k] = N(select)(going, step[k] + more[k], step[k]);
        going &= size > FISHNET_MODEL_ENOUGH * whole;
    }
    return wanted & N(finite)(step[0]) & N(finite)(step[1]);
}

/* The square of the size of a step in space, to first order. */
INLINE NUMBER NAME(spatial_size2)(const JET *jet, const NUMBER step[2]) {
    return V(norm2)(V(axpy)(step[1], jet->v, V(scale)(step[0], jet->u)));
}

/* The last step, next to nothing: D moves by it on the paraboloid, and needs no evaluation. */
INLINE void NAME(settle)(struct NAME(corner) * d, struct NAME(slide) * slide, NUMBER uv[2],
                         JET *jet) {
    NUMBER step[2];
    MASK moves = d->error > FISHNET_SETTLED;
    if (!N(any)(moves))
        return;
    struct NAME(linear) linear = NAME(linear_make)(jet->u, jet->v, d->wb, d->gradient);
    moves &= N(finite)(linear.inverse);
    NAME(linear_solve)(&linear, -d->f[0], -d->f[1], step);
    VECTOR u, v, e = NAME(model_step)(jet, step, &u, &v);
    NUMBER error = d->error;
    for (int k = 0; k < 2; k++)
        uv[k] = N(select)(moves, uv[k] + step[k], uv[k]);
    jet->r = V(select)(moves, V(add)(jet->r, e), jet->r);
    jet->u = V(select)(moves, u, jet->u);
    jet->v = V(select)(moves, v, jet->v);
    d->wb = V(add)(d->wb, e);
    d->wc = V(add)(d->wc, e);
    if (slide)
        NAME(slide_chord)(d, slide, moves);
    NAME(find_error)(d);
    d->error = N(select)(moves, d->error, error);
}

/* Twice the area of the triangle p q r as seen along the normal. */
INLINE NUMBER NAME(triangle_turn)(VECTOR p, VECTOR q, VECTOR r, VECTOR normal) {
    return V(dot)(V(cross)(V(sub)(q, p), V(sub)(r, p)), normal);
}

/* Whether D is the root away from A, and the cell A, C, D, B convex: as seen along the normals or,
 * where it is hardly open, from anywhere. `sign` is 1 when A, C, D, B turn counter-clockwise. */
INLINE MASK NAME(is_right_root)(const struct NAME(corner) * cell, VECTOR d, double sign,
                                VECTOR normal_b, VECTOR normal_d) {
    VECTOR a = cell->a, b = cell->b, c = cell->c;
    NUMBER at_d = sign * NAME(triangle_turn)(c, d, b, normal_d);
    MASK away = (at_d > 0) & (sign * NAME(triangle_turn)(c, d, b, normal_b) > 0);
    MASK open = at_d > FISHNET_OPEN_SINE * cell->bd * cell->cd;
    if (N(all)(open))
        return away;
    VECTOR normal = V(cross)(V(sub)(d, a), V(sub)(b, c));
    MASK convex =
        (NAME(triangle_turn)(a, c, d, normal) > 0) & (NAME(triangle_turn)(d, b, a, normal) > 0) &
        (NAME(triangle_turn)(c, d, b, normal) > 0) & (NAME(triangle_turn)(b, a, c, normal) > 0);
    open |= (sign * NAME(triangle_turn)(a, c, d, normal_d) > 0) &
            (sign * NAME(triangle_turn)(d, b, a, normal_d) > 0) & convex;
    return away & open;
}
