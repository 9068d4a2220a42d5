/* SPDX-License-Identifier: MIT */
/*
 * The triangles round a vertex of a mesh, counter-clockwise, and directions among them by their
 * angle in degrees from the ring's first edge. Round a vertex inside the mesh they close and begin
 * anywhere; at its edge they begin and end at edges of the mesh. Where several rings touch in one
 * vertex each is its own.
 */
#ifndef SOLVER_MESH_RING_H
#define SOLVER_MESH_RING_H

#include "mesh.h"

struct mesh_ring {
    const struct mesh *mesh;
    int32_t first; /* half-edge: the ring's first edge, leaving the vertex, in its first triangle */
    bool closed;
    double total;  /* angle of all triangles, degrees */
    double before; /* of those before the triangle it was asked for */
};

/* The angle of a triangle at the start of one of its half-edges, degrees. */
double mesh_corner_angle(const struct mesh *mesh, int32_t half);

/* The half-edge that leaves the same vertex in the next triangle counter-clockwise, or clockwise;
 * MESH_NONE beyond the mesh's edge. */
int32_t mesh_ring_next(const struct mesh *mesh, int32_t leaving);
int32_t mesh_ring_previous(const struct mesh *mesh, int32_t leaving);

/* The ring round a corner of a triangle. */
struct mesh_ring mesh_ring_make(const struct mesh *mesh, int32_t triangle, int corner);

/* The angle in its triangle, which has the vertex as `corner`, of a direction in its plane:
 * -180..180 degrees counter-clockwise from the triangle's edge `corner`. */
double mesh_ring_angle(const struct mesh *mesh, int32_t triangle, int corner,
                       struct vec3 direction);

/* The direction at an angle of 0..total: its triangle, corner there, and unit vector. */
void mesh_ring_direction(const struct mesh_ring *ring, double angle, int32_t *triangle, int *corner,
                         struct vec3 *direction);

#endif
