/* SPDX-License-Identifier: MIT */
/*
 * The tree of boxes over the triangles of a mesh. It is balanced and has no pointers: a node over m
 * leaves is followed by its left child over m / 2 of them, and 2 (m / 2) places on by its right
 * child over the rest. Triangles are divided at the median along the longest side of the box
 * round their centres, so that a lone triangle far off cannot spoil it.
 */
#ifndef SOLVER_MESH_TREE_H
#define SOLVER_MESH_TREE_H

#include "mesh.h"

/* Builds it: a step of `mesh_make`. Errors: STATUS_OUT_OF_MEMORY. */
enum status mesh_tree_build(struct mesh *mesh, struct arena *arena) STATUS_MUST_USE;

/* The circle in which the spheres |x - b| = bd and |x - c| = cd meet. */
struct mesh_circle {
    struct vec3 b, c;
    double bd, cd;
};

/* Calls `visit` for every triangle that the circle may pass through, and others near it. */
void mesh_tree_visit(const struct mesh *mesh, const struct mesh_circle *circle,
                     void (*visit)(void *context, int32_t triangle), void *context);

#endif
