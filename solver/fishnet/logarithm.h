/* SPDX-License-Identifier: MIT */
/*
 * The logarithm of a point of the surface at a near one: length and direction of the geodesic
 * between them, without following it. Between p and q as many points are put as it takes for
 * each piece to be known by its ends (`rough_estimate`). The pieces make a geodesic when none of
 * them meets the next at an angle: with a_k the angles, by which the path turns to the left, and
 * h_k the lengths of the pieces, the points move to the left by x_k,
 *
 *     (x_k - x_(k-1)) / h_k - (x_(k+1) - x_k) / h_(k+1) = a_k
 *
 * and the length becomes less by the sum of a_k x_k / 2, which is of second order: the last of
 * these moves needs no evaluation.
 */
#ifndef SOLVER_FISHNET_LOGARITHM_H
#define SOLVER_FISHNET_LOGARITHM_H

#include "rough.h"
#include "solver/shell/surface_point.h"
#include "way.h"

struct logarithm {
    double length;
    struct vec3 leave, arrive; /* unit tangents at p and, onward, at q */
};

/* The way from p to q, and what is known of its pieces by their ends. */
struct logarithm_chain {
    struct surface_cursor *cursor;
    double accuracy, whole;
    struct way way; /* of no pieces: not laid yet */
    struct rough_geodesic piece[WAY_PIECES];
    bool sound[WAY_PIECES];
};

/* Finds the logarithm of q at p to `accuracy`, as a share of the length, its directions to about
 * the square root of that. On a shell it goes from face to face. False where the surface folds or
 * bends too unevenly between them for a few pieces, at poles, and where the way passes the end of a
 * joint within the boundary; at one on the boundary it goes over the line in which the joint goes
 * on.
 */
bool logarithm_find(struct surface_cursor *cursor, const struct surface_point *p,
                    const struct surface_point *q, double accuracy, struct logarithm *logarithm);

/* The same once more, from the chain of the last time, which was to a q near this one and need not
 * have been as accurate; a chain of no pieces is laid anew. Whether its way holds (`way_holds`) is
 * left to be seen when q is where it is to be. */
bool logarithm_go_on(struct surface_cursor *cursor, struct logarithm_chain *chain,
                     const struct surface_point *p, const struct surface_point *q, double accuracy,
                     struct logarithm *logarithm);

/* The unit tangent at p of the geodesic to an end, as `rough_leave`; where that is not
 * sure, by its logarithm. */
struct vec3 logarithm_leave(struct surface_cursor *cursor, const struct surface_point *p,
                            const struct rough_end *end);

#endif
