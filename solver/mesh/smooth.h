/* SPDX-License-Identifier: MIT */
/*
 * The smooth surface that a mesh of triangles stands for, made of the fits at its vertices
 * (`fit.h`). Over a triangle with the foot of a point r at the barycentric coordinates l_k it is
 *
 *     F(r) = l_0 F_0(r) + l_1 F_1(r) + l_2 F_2(r) = 0,   F_k(r) = z_k - P_k(x_k, y_k),
 *
 * with x_k, y_k, z_k the coordinates of r at corner k. Normal and curvature are those of the same
 * mean. Neighbouring triangles have the same surface on their common edge but for O(h^6), for their
 * feet are taken along their own normals.
 *
 * A point on it is a `struct mesh_point`: a triangle and a point, whose foot on the triangle's
 * plane lies in it. Its rim is that of the triangles.
 */
#ifndef SOLVER_MESH_SMOOTH_H
#define SOLVER_MESH_SMOOTH_H

#include "fit.h"

struct mesh_smooth {
    const struct mesh *mesh;
    struct mesh_fits fits;
    int32_t *patch; /* of each triangle: what hangs together without crossing folds */
};

/* F and its derivatives at a point near the surface. */
struct mesh_jet {
    double height;                 /* F: the distance from the surface, nearly */
    struct vec3 gradient;          /* along the normal; not a unit vector */
    double xx, xy, xz, yy, yz, zz; /* of the second derivatives of the P_k: -F'' */
};

/* Errors: STATUS_OUT_OF_MEMORY. The mesh must outlive it. */
enum status mesh_smooth_make(const struct mesh *mesh, struct arena *arena,
                             struct mesh_smooth **smooth) STATUS_MUST_USE;

void mesh_smooth_jet(const struct mesh_smooth *smooth, const struct mesh_point *at,
                     struct mesh_jet *jet);

/* The unit normal at a point near the surface, as its triangle has it. */
struct vec3 mesh_smooth_normal(const struct mesh_smooth *smooth, const struct mesh_point *at);

/* a^T (-F'') b / |F'|: for unit tangents a = b the normal curvature along them, positive where the
 * surface bends towards the normal. */
double mesh_jet_form(const struct mesh_jet *jet, struct vec3 a, struct vec3 b);

/* Finds the triangle that a point belongs to, from that of `at` on, and sets it. What it cannot
 * cross, the mesh's rim and with `folds` false folds, stops it: then the half-edge beyond which the
 * point lies, else MESH_NONE; a little beyond, as the sagitta of a curved edge is, counts as
 * within. With `slack`, a share of a triangle's height, a point that is less outside stays in its
 * triangle: so an iteration cannot go to and fro over an edge. */
int32_t mesh_smooth_follow(const struct mesh_smooth *smooth, struct mesh_point *at, bool folds,
                           double slack);

/* Whether a point on the surface is as near to its triangle as a surface that bends by less than a
 * fold from edge to edge can be: rough vertices make fits that lead astray. */
bool mesh_smooth_is_sound(const struct mesh_smooth *smooth, const struct mesh_point *at);

/* Moves a point onto the surface, along the normal, within its triangle's fits. */
void mesh_smooth_project(const struct mesh_smooth *smooth, struct mesh_point *at);

#endif
