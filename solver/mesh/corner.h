/* SPDX-License-Identifier: MIT */
/*
 * The basic step over flat triangles: the fourth corner D of a cell A, B, C on a mesh.
 *
 *       B ---- D        |D - B| = bd and |D - C| = cd, D on the side of BC away from A
 *       |      |        (see `fishnet.h`).
 *       A ---- C
 *
 * The spheres round B and C meet in a circle, and in the plane of a triangle D is one of the two
 * points where that circle passes through it, in closed form. From C a way heads for the D of the
 * triangle it is in, and so from triangle to triangle until D lies in its own; else one from B.
 * When both fail, all triangles on the circle are tried.
 */
#ifndef SOLVER_MESH_CORNER_H
#define SOLVER_MESH_CORNER_H

#include "mesh.h"

struct mesh_cell {
    struct mesh_point a, b, c;
    double bd, cd;     /* chord lengths wanted, > 0 */
    struct vec3 guess; /* where D is expected: of several it is the nearest to it */
    int orientation;   /* 1 when A, C, D, B turn counter-clockwise about the normals, -1 when not */
};

enum mesh_corner_end {
    MESH_CORNER_FOUND,
    MESH_CORNER_COLLAPSED,     /* the spheres no longer meet on the mesh */
    MESH_CORNER_BOUNDARY,      /* D would lie past the edge of the mesh */
    MESH_CORNER_NO_CONVERGENCE /* D is there, but not to be reached from B or C */
};

struct mesh_corner {
    struct mesh_point at; /* D */
    int steps;            /* triangles in which D was looked for */
    double residual;      /* the larger of | |D - B| / bd - 1 |, | |D - C| / cd - 1 | */
};

/* Solves a cell. D is never on the side of A, nor on a sheet that has turned by more than a right
 * angle (95 degrees, so that square edges pass) from those of B and C, nor on one that hangs
 * together with theirs only further away. The point is set only when it was found. */
enum mesh_corner_end mesh_corner_solve(const struct mesh *mesh, const struct mesh_cell *cell,
                                       struct mesh_corner *corner);

/* ---- what a D must be, on flat triangles and on the smooth surface ---- */

/* Whether A lies on its side of BC, as seen along the sum of the normals at A, B and C. */
bool mesh_cell_is_upright(const struct mesh_cell *cell, struct vec3 na, struct vec3 nb,
                          struct vec3 nc);

/* Whether D, with the normal nd, is the root away from A, on the sheet of B and C. Normals are
 * added up, for on an edge of the mesh any may be at right angles to the cell. */
bool mesh_cell_has_corner(const struct mesh_cell *cell, struct vec3 nb, struct vec3 nc,
                          struct vec3 d, struct vec3 nd);

/* The residual of D (`struct mesh_corner`). */
double mesh_cell_residual(const struct mesh_cell *cell, struct vec3 d);

/* Whether a cell without a D has none because it collapsed: two yarns all but parallel at A, or B
 * and C as far apart as the chords reach. */
bool mesh_cell_has_collapsed(const struct mesh *mesh, const struct mesh_cell *cell);

#endif
