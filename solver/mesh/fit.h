/* SPDX-License-Identifier: MIT */
/*
 * The smooth surface that a mesh of triangles stands for, seen from each of its vertices: a height
 * z = P(x, y) over the tangent plane there, P a cubic polynomial through the vertex, by least
 * squares from the vertices around. On a mesh of size h with vertices on a smooth surface its error
 * is O(h^4), that of its slopes O(h^3), that of its curvatures O(h^2).
 *
 * Edges across which the mesh turns by more than MESH_FOLD_DEG are folds: no fit reaches across,
 * and a vertex on one has a fit for each of the sides that folds divide its triangles into.
 */
#ifndef SOLVER_MESH_FIT_H
#define SOLVER_MESH_FIT_H

#include "mesh.h"

/* The sharpest edge that still stands for a smooth surface, by the angle between the normals of its
 * triangles. A cylinder of twelve faces turns by 30 degrees at each edge; coarser ones are boxes.
 */
#define MESH_FOLD_DEG 30
#define MESH_FOLD_COSINE 0.8660254037844387

enum { FIT_TERMS = 9 };

struct mesh_fit {
    struct vec3 origin, x, y, normal; /* the vertex and its axes */
    double slope[2];                  /* of P: x, y */
    double second[3];                 /* x^2, x y, y^2 */
    double third[4];                  /* x^3, x^2 y, x y^2, y^3 */
};

struct mesh_fits {
    int32_t (*of)[3]; /* of each corner of each triangle: its fit */
    struct mesh_fit *fit;
    size_t count;
};

/* Whether half-edge `edge`, which is not one of the mesh's rim, is a fold. */
bool mesh_is_fold(const struct mesh *mesh, int32_t edge);

/* The fits of a mesh, in `arena`; where there are too few vertices around for a cubic polynomial,
 * or they lie so that it is not determined, quadratic ones or planes. O(n). Errors:
 * STATUS_OUT_OF_MEMORY. */
enum status mesh_fits_make(const struct mesh *mesh, struct arena *arena,
                           struct mesh_fits *fits) STATUS_MUST_USE;

#endif
