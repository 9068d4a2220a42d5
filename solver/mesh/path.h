/* SPDX-License-Identifier: MIT */
/*
 * Paths on a mesh: what the generators of a mosaic net run along.
 *
 * - Straight: in a triangle along a straight line, across an edge by unfolding the two triangles
 *   about it. Through a vertex, where triangles cannot be unfolded, it goes on so as to have equal
 *   angles on either side (a straightest geodesic); at a vertex of the mesh's edge so as to have
 *   180 degrees on that side where there are as many.
 * - Section by a plane: in every triangle along the line in which the plane cuts it.
 *
 * A straight path that runs along the edge of the mesh stays on it where it bends away by less than
 * 0.6 degrees, 1.2 degrees in one move: so bends the edge of a mesh that follows a curved surface.
 */
#ifndef SOLVER_MESH_PATH_H
#define SOLVER_MESH_PATH_H

#include "mesh.h"

struct mesh_path {
    const struct mesh *mesh;
    struct mesh_point at;  /* where it is */
    struct vec3 direction; /* the way it is going there: unit, in the triangle's plane */
    struct vec3 plane;     /* a section's unit normal, signed as it goes; zero: straight */
    int entry;             /* edge of the triangle by which it has just come in, or MESH_NONE */
    int corner;            /* corner of the triangle that it sets off from, or MESH_NONE */
    double bent;           /* degrees turned in this move to stay on the mesh along its edge */
    double sharpest;       /* the least cosine between the normals of triangles next to each other
                              that this move has passed; 1: it has passed into none */
};

enum mesh_path_end {
    MESH_PATH_DONE,
    MESH_PATH_BOUNDARY, /* the mesh ends before: `point` is where it does */
    MESH_PATH_LOST      /* there is no chord that long on this way */
};

/* Sets off from `from` along the projection of `direction` on its triangle; from a vertex inside
 * the mesh at the same share of its total angle as the direction has of a full turn, so that right
 * angles become quarters of it. False when there is no such direction: it is normal to the
 * triangle, or at a vertex leads off the mesh. */
bool mesh_path_straight(struct mesh_path *path, const struct mesh *mesh,
                        const struct mesh_point *from, struct vec3 direction);

/* Sets off along the section by the plane through `from` with the normal `plane`, to that side to
 * which `direction` points. False when the plane is that of the triangle, or at a vertex when the
 * section leads off the mesh. */
bool mesh_path_section(struct mesh_path *path, const struct mesh *mesh,
                       const struct mesh_point *from, struct vec3 plane, struct vec3 direction);

/* Sets off along the section by the plane through `from` and the point `target` that is upright on
 * the triangle of `from`, towards `target`, which need not be on the mesh. False when `target` is
 * straight above `from`, or the way to it leads off the mesh from a vertex. */
bool mesh_path_towards(struct mesh_path *path, const struct mesh *mesh,
                       const struct mesh_point *from, struct vec3 target);

/* Moves on by `length` >= 0. */
enum mesh_path_end mesh_path_length(struct mesh_path *path, double length);

/* Moves on to the first point at the distance `chord` > 0 in space from where it is now. Lost when
 * there is none within a length of eight chords. */
enum mesh_path_end mesh_path_chord(struct mesh_path *path, double chord);

/* Whether the section by the plane through two points, upright on the mesh at the first, leads from
 * it straight to the second within the length `reach`. */
bool mesh_path_connects(const struct mesh *mesh, const struct mesh_point *from,
                        const struct mesh_point *to, double reach);

#endif
