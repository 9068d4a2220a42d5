/* SPDX-License-Identifier: MIT */
/* Arcs of constant curvature, and whether an edge is one, for numbers and for lanes
 * (`solver/numbers.h`). */
#include "rough_limits.h"
#include "solver/numbers.h"

/* The chord of an arc of the given length and curvature: 2 sin(length curvature / 2) / curvature;
 * 0 for arcs of a full turn and more. */
INLINE NUMBER NAME(fishnet_arc_chord)(NUMBER length, NUMBER curvature) {
    NUMBER half = length * curvature / 2;
    MASK part = N(abs)(half) < ANGLE_PI;
    return N(select)(part, length * NAME(angle_sinc)(half), N(of)(0));
}

/* The misfit, as a share of d, of the edge from p to q with this normal curvature at p. */
INLINE NUMBER NAME(rough_misfit)(const POINT *p, const POINT *q, NUMBER curvature, NUMBER d) {
    VECTOR along = V(sub)(q->jet.r, p->jet.r);
    NUMBER rise = curvature * d * d / 2;
    return (N(abs)(V(dot)(along, p->normal) - rise) + N(abs)(V(dot)(along, q->normal) + rise)) / d;
}

/* Whether the surface faces away from one end at the other: it is folded back between them, so that
 * its two sides are nearly parallel and nothing rises above either. */
INLINE MASK NAME(rough_is_folded_back)(const POINT *p, const POINT *q) {
    return V(dot)(p->normal, q->normal) < 0;
}

/* Whether an edge is an arc by its misfit and turn alone. */
INLINE MASK NAME(rough_is_arc)(const POINT *p, const POINT *q, NUMBER curvature, NUMBER d) {
    return (NAME(rough_misfit)(p, q, curvature, d) < ROUGH_MISFIT_SMOOTH) &
           (N(abs)(curvature) * d < ROUGH_TURN_SMOOTH) & N(not )(NAME(rough_is_folded_back)(p, q));
}
