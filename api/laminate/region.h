/* SPDX-License-Identifier: MIT */
/*
 * The boundary of a ply on its cloth: loops in the net's own coordinates (p, q), i and j as real
 * numbers, in which the cloth is flat; so it is the line to cut along as well. A loop is a line in
 * space; it is followed in steps of half a spacing, each going to the nearest place of the cloth.
 */
#ifndef API_LAMINATE_REGION_H
#define API_LAMINATE_REGION_H

#include "api/result/polygons.h"
#include "laminate.h"
#include "solver/mesh/facets.h"

struct region {
    const double (*points)[2]; /* of all loops, one after the other */
    const size_t *first;       /* of each loop, and one more */
    size_t loop_count;
    double away; /* of those over the cloth, how far the farthest is from it */
    /* for region_contains: edges by strips of q */
    double low[2], high[2], height;
    size_t strip_count;
    const size_t *strip_first;
    const uint32_t *strip_edges; /* by the number of the edge's first point */
    const uint32_t *next;        /* of each point: where its edge ends */
};

/* The boundary of ply k (from 0), which has one, on its cloth with these spacings. Problems:
 * API_OUT_OF_MEMORY; API_INVALID_REQUEST where neighbouring points of a loop go to places that are
 * not neighbours on the cloth: it ends between them, or the loop is too far away. */
enum api_problem_id region_make(const struct laminate *laminate, size_t k,
                                const struct facets *facets, const double spacing[2],
                                struct arena *arena, struct region *region,
                                struct api_problem *problem) STATUS_MUST_USE;

/* What polygons enclose whose x and y are p and q times these spacings. False without memory. */
bool region_of_polygons(const struct polygons *polygons, const double spacing[2],
                        struct arena *arena, struct region *region);

/* Whether (p, q) is inside an odd number of the loops. */
bool region_contains(const struct region *region, const double pq[2]);

#endif
