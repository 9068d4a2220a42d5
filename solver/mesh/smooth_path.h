/* SPDX-License-Identifier: MIT */
/*
 * Paths on the smooth surface of a mesh (`smooth.h`): geodesics, x'' = k n with k the normal
 * curvature along x' and n the normal, and sections by a plane, x' along plane x n. Runge and
 * Kutta's method of fourth order, in steps of less than a triangle. At a fold a geodesic keeps what
 * its direction has along the fold and turns the rest into the other side's tangent plane.
 */
#ifndef SOLVER_MESH_SMOOTH_PATH_H
#define SOLVER_MESH_SMOOTH_PATH_H

#include "path.h"
#include "smooth.h"

struct mesh_smooth_path {
    const struct mesh_smooth *smooth;
    struct mesh_point at;
    struct vec3 direction; /* unit tangent */
    struct vec3 plane;     /* a section's unit normal, signed as it goes; zero: a geodesic */
};

/* Sets off from a point on the surface along the projection of `direction`; with `plane` not zero
 * along the section with that normal to the side of `direction`. False where there is none. */
bool mesh_smooth_path(struct mesh_smooth_path *path, const struct mesh_smooth *smooth,
                      const struct mesh_point *from, struct vec3 direction, struct vec3 plane);

/* Moves on by `length` > 0, or to the first point at the distance `chord` > 0 in space. */
enum mesh_path_end mesh_smooth_length(struct mesh_smooth_path *path, double length);
enum mesh_path_end mesh_smooth_chord(struct mesh_smooth_path *path, double chord);

#endif
