/* SPDX-License-Identifier: MIT */
/*
 * The draped cloth as a surface of its own, to find the place of it that is nearest to a point:
 * each cell is four flat triangles between its middle, the mean of its corners, and its edges. They
 * join without gaps; and what is known at the middles of the cells can be interpolated on them,
 * with the mean of the surrounding middles at a corner, so that it is continuous over the whole
 * net.
 *
 * A tree of boxes over the cells, in the order of Morton's curve through their places (i, j), makes
 * the search fast: neighbours in the net are neighbours in space, because the yarns do not stretch.
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

struct facets_box {
    double lower[3], upper[3];
};

struct facets {
    struct facets_source source;
    int32_t (*around)[4]; /* of each node: the cells about it, FACETS_NONE where there is none */
    /* The tree: leaf l has the cells order[FACETS_LEAF l ..]; a node over m leaves is followed by
     * its left child over m / 2 of them, and 2 (m / 2) places on by its right child. */
    struct facets_box *boxes;
    int32_t *order;
    size_t leaf_count;
};

enum { FACETS_NONE = -1, FACETS_LEAF = 4 };

struct facets_place {
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

/* The place nearest to `point`, which must be finite; of several as near as each other that of the
 * first cell. `hint` is a cell that may be near, such as that of the point before; any will do. */
void facets_nearest(const struct facets *facets, struct vec3 point, int32_t hint,
                    struct facets_place *place);

#endif
