/* SPDX-License-Identifier: MIT */
/*
 * The draped cloth as a surface of its own, to find the point of it that is nearest to a point:
 * each cell is four flat triangles between its middle, the mean of its corners, and its edges. They
 * join without gaps; and what is known at the middles of the cells can be interpolated on them,
 * with the mean of the surrounding middles at a corner, so that it is continuous over the whole
 * net.
 *
 * A tree of balls over the cells makes the search fast: neighbours in the net are neighbours in
 * space, because the yarns do not stretch, so its nodes are squares and rectangles of places (i,
 * j). Each has up to eight children, whose balls are compared at once. A search first hops in the
 * net to a cell close by, so that the tree has only to show that no other is nearer.
 *
 * Immutable once made; may be read by many threads at once.
 */
#ifndef SOLVER_MESH_FACETS_H
#define SOLVER_MESH_FACETS_H

#include "solver/arena.h"
#include "solver/status.h"
#include "solver/vec.h"
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

/* A net as it was solved: a view of the caller's arrays, which must outlive the facets. */
struct facets_source {
    const struct vec3 *nodes;    /* finite */
    size_t node_count;           /* at most INT32_MAX */
    const int32_t (*corners)[4]; /* nodes (i,j), (i+1,j), (i+1,j+1), (i,j+1) of each cell */
    const int32_t (*places)[2];  /* (i, j) of each cell, each once */
    size_t cell_count;           /* 1 .. INT32_MAX */
};

enum { FACETS_NONE = -1, FACETS_CHILDREN = 8, FACETS_LEVELS = 22 };

/* The balls of the children of a node, in which all of their cells lie. */
struct facets_node {
    double middle[3][FACETS_CHILDREN], radius[FACETS_CHILDREN];
    size_t first; /* its children are those of the level below from here on, or of `order` */
    int count;
    uint64_t key; /* its number among those of its level */
};

struct facets {
    struct facets_source source;
    int32_t (*around)[4]; /* of each node: the cells about it, FACETS_NONE where there is none */
    /* The tree: the cells in the order of Morton's curve through their places; nodes over 4 x 2
     * places, over 8 x 8, ...; the last level is the root alone. */
    struct facets_node *level[FACETS_LEVELS];
    int levels;
    int32_t *order;
    int32_t low[2]; /* the least i and j */
    double size;    /* of a cell: the mean radius of the balls round them */
};

struct facets_point {
    int32_t cell;
    int side;         /* of the cell: from corner `side` to the next one */
    double weight[3]; /* of its middle and of these two corners; they add up to 1, none < 0 */
    struct vec3 r;
    double distance;
    bool outside; /* nearest is the rim of the net, and the point lies beyond it */
};

/* O(n log n). Errors: STATUS_OUT_OF_MEMORY; STATUS_INVALID without cells. */
enum status facets_make(const struct facets_source *source, struct arena *arena,
                        struct facets **facets) STATUS_MUST_USE;

enum { FACETS_GROUPS = 8, FACETS_NEAR = FACETS_GROUPS * FACETS_CHILDREN };

/* One search after the other: what was found for a point makes the next one fast when it lies close
 * by. */
struct facets_search {
    const struct facets *facets;
    int32_t cell;      /* that of the last point found */
    struct vec3 point; /* the last one */
    /* All nodes of level 0 that come within `reach` of the middle, with their balls. */
    struct vec3 middle;
    double reach; /* < 0: not known */
    struct facets_node near[FACETS_GROUPS];
    size_t node[FACETS_NEAR];
    int count;
};

struct facets_search facets_search_begin(const struct facets *facets);

/* The point of the cloth nearest to `point`, which must be finite; of several as near as each other
 * that of the first cell. It does not depend on what was searched for before. */
void facets_nearest(struct facets_search *search, struct vec3 point, struct facets_point *at);

#endif
