/* SPDX-License-Identifier: MIT */
/*
 * What lies within a distance of edges of polygons on cloth that is sheared, the distance taken on
 * the part. A way (x, y) along warp and weft, whose angle has the sine s, is on the part
 *
 *     (X, Y) = (x + s y, c y),    c = sqrt(1 - s^2),
 *
 * so that a band is as wide there as it should be, and on the cloth wider than that, or slanted.
 */
#ifndef API_LAMINATE_BAND_H
#define API_LAMINATE_BAND_H

#include "api/result/polygons.h"

/* The cloth beside the edge that begins at a point of polygons. */
struct band_edge {
    double reach; /* 0: there is no band */
    double sine;  /* of the shear, -1..1; NaN is taken for 0 */
};

/* A rectangle of the part along each edge, and a sector of a disc about each corner and end, each
 * as a polygon of its own that overlaps others: turning left, round within 5e-4 of the reach.
 * `shapes` is zero-initialised, and freed by the caller. False without memory. */
bool band_make(const struct polygons *polygons, const struct band_edge *edges,
               struct polygons *shapes);

#endif
