/* SPDX-License-Identifier: MIT */
/* How the triangles of a mesh hang together: a step of `mesh_make`. */
#ifndef SOLVER_MESH_TOPOLOGY_H
#define SOLVER_MESH_TOPOLOGY_H

#include "mesh.h"

/* Sets mesh->twins, ->component and ->component_count and winds the triangles consistently, from
 * the vertices and the corners; normals and corners of those turned over are changed. Scratch comes
 * from `arena` and is given back. Errors: STATUS_OUT_OF_MEMORY; STATUS_INVALID with the kind, the
 * index of `fault`. */
enum status mesh_topology_find(struct mesh *mesh, struct arena *arena,
                               struct mesh_fault *fault) STATUS_MUST_USE;

#endif
