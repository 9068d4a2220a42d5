/* SPDX-License-Identifier: MIT */
/*
 * The rim: the true edge of what is to be covered, in the coordinates (p, q) of the net. A chain of
 * edges (`rim_edges.h`) is followed in steps of about a spacing; each place is found on the cloth
 * (`rim_cloth.h`), and between two of them p and q are cubics along the edge, by their values and
 * derivatives at both ends, where the place in the middle confirms it. Points are as dense as
 * straight lines between them need to be right.
 *
 * Near rough edges, where a place costs a geodesic, the flat edge may have corners, which no cubic
 * has. There steps may also be parabolas through three places as long as they bend by less than
 * 0.02 spacings, which leaves some 2e-3 where the flat edge is curved.
 */
#ifndef SOLVER_RIM_RIM_H
#define SOLVER_RIM_RIM_H

#include "rim_cloth.h"
#include "rim_edges.h"

/* Straight lines between points are right to this share of a spacing. */
#define RIM_TOLERANCE 1e-3

struct rim_point {
    int32_t loop, face;
    bool covered; /* the cloth reaches it; p and q are those of the last point it reached, if not */
    double uv[2]; /* as `rim_vertex` */
    struct vec3 r;
    double p, q;
};

/* The largest shear along the rim, but for places near rough edges. */
struct rim_shear {
    double half_tangent; /* |tan(gamma / 2)| */
    double p, q;
    struct vec3 r;
};

/* A place near rough edges, whose shear is that between the nodes around it (`node_shear.h`). */
struct rim_rough {
    double p, q;
    struct vec3 r;
};

struct rim {
    struct rim_point *points; /* loop by loop, the last of each joined to its first */
    size_t count, room;
    size_t loop_count;
    bool covered; /* all points are, and there are some */
    struct rim_shear shear;
    struct rim_rough *rough;
    size_t rough_count, rough_room;
    struct rim_cloth cloth;
};

/* Follows the rim of a net that is complete, in the march's arena. Errors: STATUS_OUT_OF_MEMORY. */
enum status rim_make(struct march *march, struct rim *rim) STATUS_MUST_USE;

#endif
