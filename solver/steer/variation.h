/* SPDX-License-Identifier: MIT */
/*
 * How the nodes of a net move with the curvature values of its generators: the march,
 * differentiated.
 *
 * A node D lies at the distances b from B and c from C, w_B = D - B, w_C = D - C. So
 *
 *     w_B . dD = w_B . dB + b db,    w_C . dD = w_C . dC + c dc,    N . dD = 0,
 *
 * a system of 2 x 2 whose right-hand sides are linear in the derivatives of A, B and C: chords of
 * geodesics change with the normal curvature at B and C and with the tangents at A, whose gradients
 * are differences over next to nothing. The matrices are found once a cell and applied to all
 * parameters, eight at a time. Along a generator, which is turned to the left by t and has moved by
 * x along itself and y to its left, where its curvature k rises by dk and the surface has the
 * Gaussian curvature K,
 *
 *     x' = k y,    y' = t - k x,    t' = dk - K y,
 *
 * Jacobi's equation y'' + K y = dk where k = 0.
 */
#ifndef SOLVER_STEER_VARIATION_H
#define SOLVER_STEER_VARIATION_H

#include "solver/march/march.h"
#include "solver/wide.h"
#include <string.h>

enum { STEER_LANES = 8, STEER_PARAMETERS = 2 * DRAPE_CURVATURE_VALUES };

/* The places of a net by their position, i from low[0] and j from low[1] on. */
struct steer_variation {
    int parameters; /* values of warp, then of weft, of those generators that are varied */
    int row;        /* that rounded up to whole lanes */
    int32_t low[2], size[2];
    const struct net_node **node; /* NULL: no place there */
    struct surface_point *point;  /* of each place */
    int32_t *slot;                /* of its derivatives; -1: not known */
    int32_t places, known;
    double *derivative; /* [known][3][row] */
};

/* Of a net by chords or arcs that is done, on a surface or a shell, by the values of the steered
 * generators that are `varied`; in the march's arena. Nodes that rest on yarns that go straight on
 * from a free edge have none. Errors: STATUS_OUT_OF_MEMORY. */
enum status steer_variation_make(struct march *march, const bool varied[2],
                                 struct steer_variation *variation) STATUS_MUST_USE;

/* The index of (i, j) in the tables; -1 outside them. */
static inline int32_t steer_index(const struct steer_variation *v, int32_t i, int32_t j) {
    i -= v->low[0];
    j -= v->low[1];
    return i >= 0 && i < v->size[0] && j >= 0 && j < v->size[1] ? j * v->size[0] + i : -1;
}

/* The derivatives of node (i, j): [x, y, z][row]; NULL where they are not known. */
static inline const double *steer_derivative(const struct steer_variation *v, int32_t i,
                                             int32_t j) {
    int32_t index = steer_index(v, i, j);
    return index >= 0 && v->slot[index] >= 0
               ? v->derivative + (size_t)v->slot[index] * 3 * (size_t)v->row
               : NULL;
}

/* ---- rows of derivatives, so many parameters at a time ---- */

typedef double steer_lanes __attribute__((vector_size(8 * STEER_LANES)));

INLINE steer_lanes steer_load(const double *from) {
    steer_lanes a;
    memcpy(&a, from, sizeof a);
    return a;
}

INLINE void steer_store(double *to, steer_lanes a) {
    memcpy(to, &a, sizeof a);
}

INLINE steer_lanes steer_dot(struct vec3 a, const double *d, int row) {
    return a.x * steer_load(d) + a.y * steer_load(d + row) + a.z * steer_load(d + 2 * row);
}

#endif
