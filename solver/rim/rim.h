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
    struct vec3 r, beside; /* and a place inside, on the same side of all cuts */
    int32_t sight;         /* as `rim_vertex` */
    double p, q;
};

struct rim {
    struct rim_point *points; /* loop by loop, the last of each joined to its first */
    size_t count, room;
    size_t loop_count;
    bool covered; /* all points are, and there are some */
    struct rim_cloth cloth;
    const int32_t *lip_of; /* as `rim_edges` */
};

/* A straight piece of the rim within one cell, that on its left where it runs along a side. */
struct rim_piece {
    int32_t i, j;
    double from[2], to[2];
    struct vec3 r[2]; /* at its ends, as straight lines in space have it */
    size_t point;     /* of the rim, at which its line begins */
    bool loose;       /* the cloth does not reach the part's edge there: .. */
    bool at_extent;   /* .. it is its own edge, on a side of cells where its extent ends it */
};

/* Where one is on the way round the rim; begins as {.rim = rim}. */
struct rim_walk {
    const struct rim *rim;
    size_t point, first; /* the next line begins there; and the loop */
    double at;           /* so much of it is behind, 0..1 */
};

/* The next piece; false when there is none. */
bool rim_walk_next(struct rim_walk *walk, struct rim_piece *piece);

/* Follows the rim of a net that is complete, in the march's arena. Errors: STATUS_OUT_OF_MEMORY. */
enum status rim_make(struct march *march, struct rim *rim) STATUS_MUST_USE;

#endif
