/* SPDX-License-Identifier: MIT */
/*
 * Points spread evenly over the area of a part, whatever its parameters or triangles: the middles
 * of as many cells of about the same size and shape. Candidates are set out by area, about twenty
 * for each point; then each moves to the middle of those that it is the nearest of, again and
 * again (Lloyd), and in the end onto the next of them. The same part and count give the same
 * points.
 */
#ifndef SOLVER_MESH_EVEN_POINTS_H
#define SOLVER_MESH_EVEN_POINTS_H

#include "mesh.h"
#include "solver/part.h"
#include "solver/shell/shell.h"
#include "solver/surface/surface.h"
#include "solver/surface/trim.h"

/* A point of a part. */
struct part_point {
    int32_t face; /* of a shell, else 0; on a mesh the triangle */
    double uv[2]; /* the caller's parameters; on a mesh (triangle, 0) */
    struct vec3 r;
};

/* `count` points, 1 or more, over a part, of a shell or mesh over its component, in `arena`. A part
 * without area gives fewer, `*found` of them. Errors: STATUS_OUT_OF_MEMORY. */
enum status even_points(const struct drape_part *part, int32_t component, size_t count,
                        struct arena *arena, struct part_point **points,
                        size_t *found) STATUS_MUST_USE;

#endif
