/* SPDX-License-Identifier: MIT */
/*
 * What follows from the ends of an edge, for numbers and for lanes (`solver/numbers.h`): how it
 * sets off from them, how it turns between them, and what kind of edge it is. `rough.h` has the
 * idea.
 */
#include "solver/numbers.h"

/* An edge as it sets off from an end: its chord in the tangent plane, as a unit vector t; the
 * square of the chord and how far that rises above the plane; and how the surface bends along t and
 * across it: II(t, t), II(t, n x t) and II(n x t, n x t), the normal curvatures and the geodesic
 * torsion. */
struct NAME(departure) {
    VECTOR along;
    NUMBER c2, rise, curvature, torsion, across;
};

/* With t = a r_u + b r_v and D = sqrt(E G - F^2), n x t has the components -(a F + b G) / D and
 * (a E + b F) / D, where n is along r_u x r_v; `side` is that of p's surface. */
INLINE struct NAME(departure) NAME(depart)(const POINT *p, VECTOR chord, NUMBER side) {
    struct NAME(departure) d = {.c2 = V(norm2)(chord), .rise = V(dot)(chord, p->normal)};
    const NUMBER *i = p->first, *ii = p->second, zero = {0};
    NUMBER ab[2] = {zero, zero};
    d.along = V(unit)(V(axpy)(-d.rise, p->normal, chord));
    MASK regular = NAME(surface_point_components)(p, d.along, ab);
    NUMBER scale = side / N(sqrt)(NAME(surface_point_determinant)(p));
    const NUMBER n[2] = {-(ab[0] * i[1] + ab[1] * i[2]) * scale,
                         (ab[0] * i[0] + ab[1] * i[1]) * scale};
    NUMBER torsion =
        ab[0] * n[0] * ii[0] + (ab[0] * n[1] + ab[1] * n[0]) * ii[1] + ab[1] * n[1] * ii[2];
    d.curvature = N(select)(regular, NAME(surface_point_form)(ii, ab), zero);
    d.torsion = N(select)(regular, torsion, zero);
    d.across = N(select)(regular, NAME(surface_point_form)(ii, n), zero);
    return d;
}

/* The angle between the projected chord of a geodesic and the geodesic itself, taken as a helix, to
 * fourth order; the bend along the helix differs by that angle from the one along the chord. */
INLINE NUMBER NAME(helix_angle)(const struct NAME(departure) * d) {
    NUMBER curvature = d->curvature, torsion = d->torsion, c2 = d->c2;
    NUMBER angle = curvature * torsion * c2 / 6;
    NUMBER k2 = curvature * curvature, t2 = torsion * torsion;
    NUMBER k = curvature + 2 * torsion * angle, t = torsion + (d->across - curvature) * angle;
    NUMBER d2 = c2 * (1 + k2 * c2 / 12);
    return k * t * d2 / 6 * (1 + d2 * (k2 / 6 - (k2 + t2) / 20));
}

/* Whether an edge lies on the other side of a joint at the end it departs from: it rises otherwise
 * than an arc of the curvature there. */
INLINE MASK NAME(is_over_joint)(const struct NAME(departure) * d) {
    NUMBER arc = d->curvature * d->c2 / 2;
    return N(abs)(d->rise - arc) >
           ROUGH_OTHER_SIDE * N(abs)(arc) + ROUGH_LEAST_RISE * N(sqrt)(d->c2);
}

/* `helix_angle` over a joint between p and q, both bends constant: where the edge rises by a share
 * of what it does with the far one more than with the near one, sqrt(share) of it lies beyond the
 * joint. */
INLINE NUMBER NAME(joint_angle)(const struct NAME(departure) * near,
                                const struct NAME(departure) * far) {
    NUMBER c2 = near->c2, arc = near->curvature * c2 / 2;
    NUMBER share = (near->rise - arc) / ((far->curvature - near->curvature) * c2 / 2);
    NUMBER beyond = N(sqrt)(N(select)(share < 1, share, N(of)(1)));
    beyond = N(select)(share > 0, beyond, N(of)(0));
    NUMBER s = 1 - beyond;
    return c2 *
           (near->curvature * near->torsion * s * s * (0.5 - s / 3) +
            far->curvature * beyond * beyond * (near->torsion * s / 2 + far->torsion * beyond / 6));
}

/* Whether there is a crease between p and q, whose normals differ by `turned`. */
INLINE MASK NAME(is_creased)(const struct NAME(departure) * p, const struct NAME(departure) * q,
                             VECTOR turned) {
    NUMBER a = p->curvature * p->curvature + p->torsion * p->torsion;
    NUMBER b = q->curvature * q->curvature + q->torsion * q->torsion;
    NUMBER bends2 = N(select)(a > b, a, b) * p->c2;
    return N(sqrt)(V(norm2)(turned)) > 2 * N(sqrt)(bends2) + ROUGH_LEAST_FOLD;
}

/* The unit vector t in the tangent plane, turned to the left by a small angle. */
INLINE VECTOR NAME(lead_aside)(VECTOR t, NUMBER angle, VECTOR normal) {
    return V(unit)(V(axpy)(angle, V(cross)(normal, t), t));
}

/* The angle, in radians, with the sine x, |x| <= 1: of less than a tenth by the series, of more as
 * the scalar functions have it. */
INLINE NUMBER NAME(arcsine)(NUMBER x) {
    NUMBER x2 = x * x;
    NUMBER angle = x * (1 + x2 * (1.0 / 6 + x2 * (3.0 / 40 + x2 * (5.0 / 112))));
#ifdef FORMULAS_OF_LANES
    for (unsigned steep = ~lanes_bits(x2 < 0.01) & LANES_ALL; steep; steep &= steep - 1) {
        int lane = __builtin_ctz(steep);
        angle[lane] = rough_steep_arcsine(x[lane]);
    }
    return angle;
#else
    return x2 < 0.01 ? angle : rough_steep_arcsine(x);
#endif
}

/* The turn of an edge in its normal plane, as it goes from one end to the other, in Legendre's
 * polynomials; the largest of the first order is half an arc's turn. */
struct NAME(turn) {
    NUMBER of[4];    /* of order 1 to 4 */
    NUMBER sideways; /* by torsion: of order 2, to the side */
    NUMBER wound;    /* what torsion may leave wrong of the length, as a share of it */
    NUMBER unsure;   /* and of the angle at which it leaves */
};

/* The angle of the chord above the tangent plane at p, and its mean with that at q. */
INLINE void NAME(chord_angles)(const struct NAME(departure) * p, const struct NAME(departure) * q,
                               NUMBER *at_p, NUMBER *mean) {
    NUMBER chord = N(sqrt)(p->c2);
    *at_p = NAME(arcsine)(p->rise / chord);
    *mean = (*at_p + NAME(arcsine)(q->rise / chord)) / 2;
}

/* The turn that has the curvatures at both ends, the angle between the normals there and, as its
 * mean, the direction of the chord: what follows from p and q for the edge between them, d long,
 * which has these angles there, to fourth order. What is left out of a helix, of the length and of
 * its angle, follows from curvatures and torsions times the length: where they change, and where
 * there is much of them. */
INLINE struct NAME(turn)
    NAME(turn_between)(const struct NAME(departure) * p, const struct NAME(departure) * q,
                       NUMBER at_p, NUMBER mean, NUMBER d) {
    NUMBER c2 = p->c2, t0 = p->torsion, t1 = q->torsion;
    /* the geodesic leaves beside the chord, by rough_leave's angle */
    NUMBER a = p->curvature * (1 + t0 * t0 * c2 / 3) * d;
    NUMBER b = q->curvature * (1 + t1 * t1 * c2 / 3) * d;
    NUMBER third = ((a + b) / 4 - mean) / 5, fourth = ((b - a) / 4 - 3 * (mean - at_p)) / 7;
    struct NAME(turn) turn = {.of = {mean - third, mean - at_p - fourth, third, fourth},
                              .sideways = N(abs)((a + b) * (t0 + t1)) * d / 48};
    t0 *= d;
    t1 *= d;
    NUMBER bend = (a * a + b * b + t0 * t0 + t1 * t1) / 2;
    turn.wound = turn.sideways * turn.sideways * bend / 4;
    turn.unsure = N(abs)(b * t1 - a * t0) / 12 + N(abs)(b * t1 + a * t0) * bend * bend / 64;
    return turn;
}

/* The chord by its length: the mean cosine of the turn. */
INLINE NUMBER NAME(chord_share)(const struct NAME(turn) * turn) {
    const NUMBER *c = turn->of;
    return NAME(angle_sinc)(c[0]) - (c[1] * c[1] / 5 + c[2] * c[2] / 7 + c[3] * c[3] / 9) / 2 -
           turn->sideways * turn->sideways;
}

/* What the chord may be wrong by, by its length. */
INLINE NUMBER NAME(chord_error)(const struct NAME(turn) * turn) {
    return ROUGH_MISSED * (turn->of[2] * turn->of[2] + turn->of[3] * turn->of[3]);
}

/* |K| d^2, the larger of both ends. */
INLINE NUMBER NAME(turn_of_net)(const POINT *p, const POINT *q, NUMBER d) {
    const POINT *end[2] = {p, q};
    NUMBER most = {0};
    for (int k = 0; k < 2; k++) {
        NUMBER turn = N(abs)(NAME(surface_point_gauss_curvature)(end[k])) * d * d;
        most = N(select)(turn > most, turn, most);
    }
    return most;
}

/* Whether an edge is an arc beyond doubt, without a look at how the surface bends at its far end.
 * Curvature that changes evenly, by c / d over the edge, has it rise by c d / 6 more than an arc at
 * p and by twice that at q, and its chord is wrong by c (k + c / 4) / 24; what else q rises by is
 * five times the third term of the turn. */
INLINE MASK NAME(rises_as_arc)(const POINT *p, const POINT *q, NUMBER curvature, NUMBER d,
                               NUMBER net) {
    VECTOR along = V(sub)(q->jet.r, p->jet.r);
    NUMBER rise = curvature * V(norm2)(along) / 2, k = N(abs)(curvature) * d;
    NUMBER at_p = (V(dot)(along, p->normal) - rise) / d;
    NUMBER at_q = (-V(dot)(along, q->normal) - rise) / d;
    NUMBER change = 2 * (N(abs)(at_p) + N(abs)(at_q)), uneven = at_q - 2 * at_p;
    return (2 * (k + change) < ROUGH_ARC_TURN) &
           (uneven * uneven < ROUGH_EVEN + ROUGH_OWN_SHARE * net) &
           (change * (k + change / 4) < 12 * (ROUGH_ARC_ERROR + ROUGH_ARC_SHARE * net));
}

/* What an edge is: an arc; or a curve that follows from its ends, with this chord, perhaps even
 * enough for differences of positions in space. */
struct NAME(edge_kind) {
    MASK arc, known, even;
    NUMBER chord;
};

/* Of the edge from p to q, away from poles, with this curvature at p and the chord of an arc;
 * `side` has those of their surfaces. */
INLINE struct NAME(edge_kind) NAME(find_edge_kind)(const POINT *p, const POINT *q, NUMBER curvature,
                                                   NUMBER d, NUMBER chord, const NUMBER side[2]) {
    NUMBER net = NAME(turn_of_net)(p, q, d), at_p, mean;
    MASK unfolded = N(not )(NAME(rough_is_folded_back)(p, q));
    struct NAME(edge_kind) kind = {.arc = NAME(rises_as_arc)(p, q, curvature, d, net) & unfolded};
    if (N(all)(kind.arc))
        return kind;
    struct NAME(departure) from_p = NAME(depart)(p, V(sub)(q->jet.r, p->jet.r), side[0]);
    struct NAME(departure) from_q = NAME(depart)(q, V(sub)(p->jet.r, q->jet.r), side[1]);
    NAME(chord_angles)(&from_p, &from_q, &at_p, &mean);
    struct NAME(turn) turn = NAME(turn_between)(&from_p, &from_q, at_p, mean, d);
    const NUMBER *c = turn.of;
    NUMBER misfit = NAME(rough_misfit)(p, q, curvature, d), error = NAME(chord_error)(&turn);
    NUMBER own = ROUGH_OWN_SHARE * net, most = ROUGH_ARC_ERROR + own;
    MASK gentle = 2 * N(abs)(c[0]) < ROUGH_ARC_TURN;
    MASK winds = (turn.sideways > ROUGH_WINDING + net) |
                 (N(not )(gentle) & (turn.sideways * turn.sideways + c[1] * c[1] > most));
    kind.chord = d * NAME(chord_share)(&turn);
    kind.arc |= unfolded & gentle & (misfit < ROUGH_ARC_MISFIT) & (error < ROUGH_EVEN + own) &
                (N(abs)(kind.chord - chord) < (ROUGH_ARC_ERROR + ROUGH_ARC_SHARE * net) * d);
    kind.known = unfolded & (error < ROUGH_BENT_ERROR + own) & (N(abs)(c[0]) < ROUGH_TURN_MOST) &
                 N(not )(winds);
    kind.even =
        gentle & (misfit * misfit < ROUGH_ARC_MISFIT * ROUGH_ARC_MISFIT + ROUGH_SHEAR_SHARE * net);
    return kind;
}
