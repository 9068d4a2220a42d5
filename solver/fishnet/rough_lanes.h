/* SPDX-License-Identifier: MIT */
/*
 * `rough_edge` for as many edges as there are lanes, with the same bits, for files that say LANES
 * (solver/lanes.h): which of them are arcs, and which are bent, with their chords. Of the others
 * nothing is said but that they are neither.
 */
#ifndef SOLVER_FISHNET_ROUGH_LANES_H
#define SOLVER_FISHNET_ROUGH_LANES_H

#include "rough.h"
#include "solver/lanes.h"

/* An end of an edge: of a point what edges ask for. */
struct lanes_end {
    struct lanes3 r, u, v, normal;
    lanes first[3], second[3];
};

INLINE lanes lanes_larger(lanes a, lanes b) {
    return lanes_select(a > b, a, b);
}

/* The misfit times d, and whether it and the turn alone tell of an arc. */
INLINE lanes lanes_misfit(const struct lanes_end *p, const struct lanes_end *q, lanes curvature,
                          double d) {
    struct lanes3 along = lanes3_sub(q->r, p->r);
    lanes rise = curvature * d * d / 2;
    return (lanes_abs(lanes3_dot(along, p->normal) - rise) +
            lanes_abs(lanes3_dot(along, q->normal) + rise)) /
           d;
}

INLINE lanes_mask lanes_folded_back(const struct lanes_end *p, const struct lanes_end *q) {
    return lanes3_dot(p->normal, q->normal) < 0;
}

INLINE lanes_mask lanes_is_arc(const struct lanes_end *p, const struct lanes_end *q,
                               lanes curvature, double d) {
    return (lanes_misfit(p, q, curvature, d) < ROUGH_MISFIT_SMOOTH) &
           (lanes_abs(curvature) * d < ROUGH_TURN_SMOOTH) & ~lanes_folded_back(p, q);
}

INLINE lanes lanes_determinant(const lanes form[3]) {
    return form[0] * form[2] - form[1] * form[1];
}

/* |K| d^2, the larger of both ends. */
INLINE lanes lanes_turn_of_net(const struct lanes_end *p, const struct lanes_end *q, double d) {
    lanes at_p = lanes_determinant(p->second) / lanes_determinant(p->first);
    lanes at_q = lanes_determinant(q->second) / lanes_determinant(q->first);
    return lanes_larger(lanes_abs(at_p) * d * d, lanes_abs(at_q) * d * d);
}

INLINE lanes_mask lanes_rises_as_arc(const struct lanes_end *p, const struct lanes_end *q,
                                     lanes curvature, double d, lanes net) {
    struct lanes3 along = lanes3_sub(q->r, p->r);
    lanes rise = curvature * lanes3_norm2(along) / 2, k = lanes_abs(curvature) * d;
    lanes at_p = (lanes3_dot(along, p->normal) - rise) / d;
    lanes at_q = (-lanes3_dot(along, q->normal) - rise) / d;
    lanes change = 2 * (lanes_abs(at_p) + lanes_abs(at_q)), uneven = at_q - 2 * at_p;
    return (2 * (k + change) < ROUGH_ARC_TURN) &
           (uneven * uneven < ROUGH_EVEN + ROUGH_OWN_SHARE * net) &
           (change * (k + change / 4) < 12 * (ROUGH_ARC_ERROR + ROUGH_ARC_SHARE * net));
}

/* How an edge sets off from an end: the chord, squared, its rise, and how the surface bends. */
struct lanes_departure {
    lanes c2, rise, curvature, torsion;
};

INLINE struct lanes_departure lanes_depart(const struct lanes_end *p, struct lanes3 chord,
                                           double side) {
    const lanes *i = p->first, *ii = p->second;
    lanes rise = lanes3_dot(chord, p->normal), determinant = lanes_determinant(i);
    struct lanes3 flat = lanes3_axpy(-rise, p->normal, chord);
    struct lanes3 along = lanes3_scale(1 / lanes_sqrt(lanes3_norm2(flat)), flat);
    lanes s = lanes3_dot(along, p->u), t = lanes3_dot(along, p->v), inverse = 1 / determinant;
    lanes a = (i[2] * s - i[1] * t) * inverse, b = (i[0] * t - i[1] * s) * inverse;
    lanes scale = side / lanes_sqrt(determinant);
    lanes na = -(a * i[1] + b * i[2]) * scale, nb = (a * i[0] + b * i[1]) * scale;
    return (struct lanes_departure){.c2 = lanes3_norm2(chord),
                                    .rise = rise,
                                    .curvature = a * a * ii[0] + 2 * a * b * ii[1] + b * b * ii[2],
                                    .torsion = a * na * ii[0] + (a * nb + b * na) * ii[1] +
                                               b * nb * ii[2]};
}

/* As `rough_arcsine`: of less than a tenth by the series, the others one by one. */
INLINE lanes lanes_arcsine(lanes x) {
    lanes x2 = x * x;
    lanes angle = x * (1 + x2 * (1.0 / 6 + x2 * (3.0 / 40 + x2 * (5.0 / 112))));
    for (unsigned steep = ~lanes_bits(x2 < 0.01) & LANES_ALL; steep; steep &= steep - 1) {
        int lane = __builtin_ctz(steep);
        angle[lane] = rough_arcsine(x[lane]);
    }
    return angle;
}

/* As angle_sinc, for less than a quarter. */
INLINE lanes lanes_sinc(lanes x) {
    lanes square = x * x, sum = 1.0 / 362880 - square * (1.0 / 39916800);
    sum = 1.0 / 5040 - square * sum;
    sum = 1.0 / 120 - square * sum;
    sum = 1.0 / 6 - square * sum;
    return 1 - square * sum;
}

struct lanes_turn {
    lanes of[4], sideways;
};

INLINE struct lanes_turn lanes_turn_between(const struct lanes_departure *p,
                                            const struct lanes_departure *q, double d) {
    lanes c2 = p->c2, chord = lanes_sqrt(c2);
    lanes mean = lanes_arcsine(p->rise / chord);
    lanes half = (mean + lanes_arcsine(q->rise / chord)) / 2;
    lanes a = p->curvature * (1 + p->torsion * p->torsion * c2 / 3) * d;
    lanes b = q->curvature * (1 + q->torsion * q->torsion * c2 / 3) * d;
    lanes third = ((a + b) / 4 - half) / 5, fourth = ((b - a) / 4 - 3 * (half - mean)) / 7;
    return (struct lanes_turn){.of = {half - third, half - mean - fourth, third, fourth},
                               .sideways = lanes_abs((a + b) * (p->torsion + q->torsion)) * d / 48};
}

INLINE lanes lanes_chord_share(const struct lanes_turn *turn) {
    const lanes *c = turn->of;
    return lanes_sinc(c[0]) - (c[1] * c[1] / 5 + c[2] * c[2] / 7 + c[3] * c[3] / 9) / 2 -
           turn->sideways * turn->sideways;
}

/* What an edge is: ROUGH_NOT, or ROUGH_BENT with this chord. */
struct lanes_edge {
    lanes_mask smooth, bent;
    lanes chord;
};

/* Edges from p to q, d long, with this curvature at p and the chords of arcs, at no pole. `side` is
 * that of the surface. */
INLINE struct lanes_edge lanes_rough_edge(const struct lanes_end *p, const struct lanes_end *q,
                                          lanes curvature, double d, lanes chord, double side) {
    lanes net = lanes_turn_of_net(p, q, d);
    lanes_mask apart = lanes_folded_back(p, q);
    struct lanes_edge edge = {lanes_rises_as_arc(p, q, curvature, d, net) & ~apart, {0}, chord};
    if (lanes_bits(edge.smooth) == LANES_ALL)
        return edge;
    struct lanes3 way = lanes3_sub(q->r, p->r), back = lanes3_sub(p->r, q->r);
    struct lanes_departure from_p = lanes_depart(p, way, side),
                           from_q = lanes_depart(q, back, side);
    struct lanes_turn turn = lanes_turn_between(&from_p, &from_q, d);
    lanes misfit = lanes_misfit(p, q, curvature, d);
    lanes error = ROUGH_MISSED * (turn.of[2] * turn.of[2] + turn.of[3] * turn.of[3]);
    lanes own = ROUGH_OWN_SHARE * net, right = d * lanes_chord_share(&turn);
    lanes_mask gentle = 2 * lanes_abs(turn.of[0]) < ROUGH_ARC_TURN;
    lanes_mask even = (misfit < ROUGH_ARC_MISFIT) & (error < ROUGH_EVEN + own) &
                      (lanes_abs(right - chord) < (ROUGH_ARC_ERROR + ROUGH_ARC_SHARE * net) * d);
    lanes_mask told =
        (error < ROUGH_BENT_ERROR + own) & ~(turn.sideways > ROUGH_WINDING + net) &
        (misfit * misfit < ROUGH_ARC_MISFIT * ROUGH_ARC_MISFIT + ROUGH_SHEAR_SHARE * net);
    edge.smooth |= gentle & even & ~apart;
    edge.bent = gentle & told & ~edge.smooth & ~apart;
    edge.chord = lanes_select(edge.bent, right, chord);
    return edge;
}

#endif
