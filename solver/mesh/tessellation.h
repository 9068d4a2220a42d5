/* SPDX-License-Identifier: MIT */
/*
 * The tessellation of a surface: rows of points along its parameter lines, a strip of triangles
 * between each two. Rows are about `size` apart where they are furthest, and each has as many
 * points as make its pieces about `size` long, by arc length, so that triangles keep their shape
 * towards a pole, where the row is one point. Spans are cut separately: knot lines, and so creases,
 * are edges of the mesh. Closed directions are closed: the points on both sides of a seam are the
 * same, with parameters of their own on each side.
 *
 * The triangles' corners lie on the surface, their normals along r_u x r_v.
 */
#ifndef SOLVER_MESH_TESSELLATION_H
#define SOLVER_MESH_TESSELLATION_H

#include "mesh.h"
#include "solver/shell/shell.h"

/*
 * Tessellates the domain of `surface` into triangles with sides of about `size` > 0, with the
 * vertices' parameters. `most` is the largest number of triangles allowed, at most INT32_MAX / 6.
 * Errors: STATUS_OUT_OF_MEMORY; STATUS_TOO_MANY_NODES (more than `most` triangles);
 * STATUS_DEGENERATE_SURFACE (triangles without area away from poles).
 */
enum status mesh_from_surface(const struct surface *surface, double size, size_t most,
                              struct arena *arena, struct mesh **mesh) STATUS_MUST_USE;

/* The points of such a tessellation alone: in space and in inner parameters. */
struct tessellation_points {
    struct vec3 *r;
    double (*uv)[2];
    size_t count;
};
enum status tessellation_points(const struct surface *surface, double size, size_t most,
                                struct arena *arena,
                                struct tessellation_points *points) STATUS_MUST_USE;

/*
 * Tessellates the faces of a shell that are reached from `face` (`shell_tessellation.c`): on each
 * its lines (`shell_lines`), which neighbours share, and between them the points of its
 * tessellation that lie in its region, triangulated so that angles in space are as even as they can
 * be. Normals are those that the faces have. Triangles know their face. Errors as above.
 */
enum status mesh_from_shell(const struct shell *shell, int32_t face, double size, size_t most,
                            struct arena *arena, struct mesh **mesh) STATUS_MUST_USE;

#endif
