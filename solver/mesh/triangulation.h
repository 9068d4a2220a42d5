/* SPDX-License-Identifier: MIT */
/*
 * A triangulation of points in the plane that has given edges: Delaunay's, one point after another
 * (Lawson), then each edge that is missing by exchanging the diagonals that cross it (Sloan, A fast
 * algorithm for generating constrained Delaunay triangulations, Computers & Structures 47, 1993).
 *
 * It covers the points' convex hull and, by three corners of its own far outside, more: edges cut
 * it into regions, of which the caller chooses.
 */
#ifndef SOLVER_MESH_TRIANGULATION_H
#define SOLVER_MESH_TRIANGULATION_H

#include "solver/arena.h"
#include "solver/status.h"
#include "solver/vec.h"
#include <stdbool.h>
#include <stdint.h>

/* Edge k of a triangle runs from its corner k to corner k + 1 (mod 3), counter-clockwise. */
struct triangulation {
    struct vec3 *points; /* z = 0, scaled into the unit square; the last three are its own */
    int32_t *same;       /* of each point: the first at its place, which has the triangles */
    size_t point_count;  /* the caller's */
    int32_t (*corners)[3];
    int32_t (*beyond)[3]; /* the triangle across edge k, or -1 */
    bool (*fixed)[3];     /* edge k is one of those given */
    int32_t *region;      /* of each triangle: what hangs together without crossing given edges */
    size_t count, region_count;
    size_t missed; /* given edges that cross others, and are not there */
};

/* `points` within a square whose lower corner is (0, 0) and whose side is 1; `edges` are pairs of
 * them. O(n log n) for points in an order in which neighbours follow each other. At most
 * INT32_MAX / 4 points. Errors: STATUS_OUT_OF_MEMORY; STATUS_INVALID for points that are not
 * finite. */
enum status triangulate(const double (*points)[2], size_t count, const int32_t (*edges)[2],
                        size_t edge_count, struct arena *arena,
                        struct triangulation **triangulation) STATUS_MUST_USE;

/* Exchanges diagonals of pairs of triangles of chosen regions until the angles opposite to them, as
 * they are in space, add up to half a turn at the most. `at` is where the points are there. Errors:
 * STATUS_OUT_OF_MEMORY. */
enum status triangulation_improve(struct triangulation *triangulation, const struct vec3 *at,
                                  const bool *chosen, struct arena *arena) STATUS_MUST_USE;

#endif
