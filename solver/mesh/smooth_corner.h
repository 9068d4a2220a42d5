/* SPDX-License-Identifier: MIT */
/*
 * The fourth corner D of a cell on the smooth surface of a mesh (`smooth.h`), by Newton's method:
 * at two distances in space, or at the common end of two geodesics of given lengths.
 */
#ifndef SOLVER_MESH_SMOOTH_CORNER_H
#define SOLVER_MESH_SMOOTH_CORNER_H

#include "corner.h"
#include "smooth.h"

/* As mesh_corner_solve, for F(D) = 0, |D - B| = bd, |D - C| = cd; A, B and C lie on the smooth
 * surface, and so does D. It begins where the cell expects D; should that fail, at the corner on
 * the flat triangles (`corner.h`), which looks everywhere. */
enum mesh_corner_end mesh_smooth_corner(const struct mesh_smooth *smooth,
                                        const struct mesh_cell *cell, struct mesh_corner *corner);

/* What a cell lies on: the flat triangles of a mesh, or the smooth surface that they stand for. */
struct mesh_sheet {
    const struct mesh *mesh;
    const struct mesh_smooth *smooth; /* NULL: the triangles */
};

/* The geodesics BD and CD: unit tangents at B and C and, in the tangent plane there, at D; and on
 * flat triangles the cosine of the sharpest edge that those tried have passed. */
struct mesh_yarns {
    struct vec3 start[2], end[2];
    double sharpest;
};

/* Solves a cell whose edges are geodesics (`cell_geodesics.c`), by turning their directions. Across
 * folds they unfold (`smooth_path.h`, `path.h`), so that on a developable mesh, however it is
 * folded, D is that of the plane. `cell->bd` and `cell->cd` are the lengths, and D is expected at
 * `cell->guess`, or where the geodesics lead that set off as `yarns->start`. `back`: the directions
 * in which the yarns through A leave B and C towards it; D is on their other side. The residual is
 * the gap between the two ends, relative to the shorter length. MESH_CORNER_BOUNDARY when a
 * geodesic leaves the mesh. */
enum mesh_corner_end mesh_cell_geodesics(const struct mesh_sheet *sheet,
                                         const struct mesh_cell *cell, const struct vec3 back[2],
                                         struct mesh_corner *corner, struct mesh_yarns *yarns);

#endif
