/* SPDX-License-Identifier: MIT */
/*
 * Deferred correction: fourth order from a second march. The yarns of a sheared net curve sideways
 * as well as with the surface; the second difference D2 = r[k+1] - 2 r[k] + r[k-1] along a yarn of
 * a net drape before is their whole curvature vector times d^2. With m the square of the mean of D2
 * at the two ends of an edge, its chord is
 *
 *     d sqrt(1 - m / (12 d^2)),
 *
 * right to d^4 relative to its length.
 */
#ifndef SOLVER_NET_CORRECTION_H
#define SOLVER_NET_CORRECTION_H

#include "net.h"

/* The chord of the edge from (i, j) to (i + di, j + dj), one of di, dj being 0 and the other 1 or
 * -1, d long along the yarn, by the positions in `before`, which must have been moved to one of its
 * ends or next to it. False where that yarn has fewer than four nodes round the edge. */
bool correction_chord(const struct net_view *before, int32_t i, int32_t j, int di, int dj, double d,
                      double *chord);

#endif
