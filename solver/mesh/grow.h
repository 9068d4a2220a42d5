/* SPDX-License-Identifier: MIT */
/* The faces of a mesh: triangles that hang together over edges that fold little; and its open
 * edges. */
#ifndef SOLVER_MESH_GROW_H
#define SOLVER_MESH_GROW_H

#include "mesh.h"

/* The angle in degrees between the normals on both sides of a half-edge, 0..180; 180 where there is
 * no triangle beyond. */
double mesh_edge_fold_deg(const struct mesh *mesh, int32_t half);

/* Marks all triangles that are reached from the marked ones (`reached` 1, else 0) across edges that
 * fold by no more than `up_to_deg`. O(n); STATUS_OUT_OF_MEMORY. */
enum status mesh_grow(const struct mesh *mesh, double up_to_deg, struct arena *arena,
                      int32_t *reached) STATUS_MUST_USE;

/* The face of each triangle: one face is all that is reached from its first triangle across edges
 * that fold by no more than MESH_FOLD_DEG; numbered by their first triangles. `face` has the mesh's
 * triangle_count entries. Returns how many faces there are; 0 without memory. */
size_t mesh_faces(const struct mesh *mesh, struct arena *arena, int32_t *face);

/* The triangles that are marked, as a mesh of their own in `arena`; one at least must be.
 * STATUS_OUT_OF_MEMORY. */
enum status mesh_part(const struct mesh *mesh, const int32_t *marked, struct arena *arena,
                      struct mesh **part) STATUS_MUST_USE;

/* A loop of open edges: the outer border of an open mesh, or a hole. */
struct mesh_opening {
    size_t edges;
    double length;
    struct vec3 centre; /* of its edges, by length */
};

/* The loops of open edges, the longest first; `count` of them in `arena`. STATUS_OUT_OF_MEMORY. */
enum status mesh_openings(const struct mesh *mesh, struct arena *arena,
                          struct mesh_opening **openings, size_t *count) STATUS_MUST_USE;

#endif
