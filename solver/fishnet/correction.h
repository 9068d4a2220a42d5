/* SPDX-License-Identifier: MIT */
/*
 * Deferred correction: fourth order from a second march. The yarns of a sheared net curve sideways
 * as well as with the surface; the second difference D2 = r[k+1] - 2 r[k] + r[k-1] along a yarn of
 * a net drape before is their whole curvature vector times d^2. With q the square of the mean of D2
 * at the two ends of an edge over d^2, its chord is
 *
 *     d sqrt(1 - q / 12 - p (23 / 720 + 0.001786 q)),
 *
 * where p is the square of the part across that mean of D2's change over the edge, over d^2: what
 * curvature and torsion turn it. That is right to d^4 relative to its length; on a helix to d^6, on
 * a circle to d^8. What is left is that curvature changes unevenly.
 *
 * Across a rough edge (`rough.h`) no difference is taken, and at a node where the curvature jumps
 * none holds along the normal: it then is not what the surface's curvature says. Near such nodes,
 * and where yarns along free edges carry the net on, only the sideways component is used, to
 * shorten the arc of the surface's curvature.
 */
#ifndef SOLVER_FISHNET_CORRECTION_H
#define SOLVER_FISHNET_CORRECTION_H

#include "solver/net/net.h"
#include "solver/shell/surface_point.h"

struct correction {
    struct vec3 bend[2]; /* D2 at the ends; zero where only rough edges lie round it */
    struct vec3 along;   /* the edge's chord in the net before, towards its far end */
    double d;            /* its length along the yarn */
    bool whole;          /* D2 holds at both ends, along the normal too, as far as the net shows */
};

/* D2 at both ends of the edge from (i, j) to (i + di, j + dj), one of di, dj being 0 and the other
 * 1 or -1, by the positions in `before`, which must have been moved to one of its ends or next to
 * it. False where the edge itself is rough, or that yarn has fewer than four nodes round it. */
bool correction_find(const struct net_view *before, int32_t i, int32_t j, int di, int dj, double d,
                     struct correction *correction);

/* D2 at q between p and r, the same from either side. */
static inline struct vec3 correction_bend(struct vec3 p, struct vec3 q, struct vec3 r) {
    return vec3_add(vec3_sub(p, q), vec3_sub(r, q));
}

/* The square of the chord above over that of d: below the shortest it is no yarn of this spacing
 * but a crease. */
#define CORRECTION_STRAIGHT 1e-300
#define CORRECTION_SHORTEST 0.5

/* The chord by a correction that is whole. False where that is no yarn of this length. */
bool correction_chord(const struct correction *correction, double *chord);

/* A chord in the normal plane less what the yarn curves sideways, seen from its ends. */
double correction_sideways(const struct correction *correction, const struct surface_point *from,
                           const struct surface_point *to, double arc_chord);

/* D2 may miss the curvature by this share of it, and of d; and by no more than makes the chord
 * wrong by so much of d, and of |K| d^3: it is by |k| d / 24 of what both ends miss in the mean.
 * Beside a joint D2 takes in what lies beyond it. */
#define CORRECTION_SHARE 0.1
#define CORRECTION_LEAST 2e-3
#define CORRECTION_PRODUCT 24.0
#define CORRECTION_APART 1e-6
#define CORRECTION_APART_SHARE (1.0 / 24)

#include "correction_formulas.h"

/* Whether D2 at the near end (0) or the far one agrees with the normal curvature there, where there
 * is one: not at a pole. */
static inline bool correction_agrees(const struct correction *correction, int end,
                                     const struct surface_point *point, double curvature) {
    return correction_bend_agrees(correction->bend[end], correction->d, point, curvature) ||
           surface_point_at_pole(point->surface, point);
}

#endif
