/* SPDX-License-Identifier: MIT */
/*
 * Where a mesh that is a tube is to be cut open, so that it becomes a sheet: along the points that
 * are as far from a start one way round as the other, opposite it.
 *
 * A tube is a component without handles of whose borders two are ends. A border that turns by more
 * than three quarters of a turn against the mesh, as seen along it, is a hole, for which nothing
 * has to be cut; one that turns as far with it is the outer border of a plate, and then the mesh is
 * no tube. But two borders alone are the ends, as of barrels, hourglasses and flanges, unless one
 * is a plate's or a small hole.
 */
#ifndef SOLVER_MESH_TUBE_CUT_H
#define SOLVER_MESH_TUBE_CUT_H

#include "mesh.h"

/* The way of the cut over a triangle: where it comes in and where it goes out, each on one of the
 * triangle's half-edges, at a share of it from its beginning. */
struct mesh_slit {
    int32_t half[2];
    double share[2];
};

/* Lines of slits, each from a border to a border: from[k] .. from[k + 1]. The first begins at one
 * end of the tube, the last ends at the other, and between two of them there is a hole. */
struct mesh_tube_cuts {
    struct mesh_slit *slits;
    size_t *from;
    size_t count; /* of lines; 0: the mesh is not to be cut */
};

/*
 * The cuts opposite `start` of the component that it is in. With d_l(x) the length of the
 * shortest way to x among those that pass a fence from one end of the tube to the other l times
 * more to one side than to the other, they consist of the points whose two shortest of these are
 * equal. Ways are found as straight lines over unfolded triangles, from each triangle's edge on as
 * if they came from one point, which on developable meshes is exact.
 *
 * Errors: STATUS_OUT_OF_MEMORY.
 */
enum status mesh_find_tube_cuts(const struct mesh *mesh, const struct mesh_point *start,
                                struct arena *arena, struct mesh_tube_cuts *cuts) STATUS_MUST_USE;

#endif
