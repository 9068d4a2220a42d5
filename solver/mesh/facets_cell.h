/* SPDX-License-Identifier: MIT */
/* One cell of the facets: four flat triangles between its middle and its edges. */
#ifndef SOLVER_MESH_FACETS_CELL_H
#define SOLVER_MESH_FACETS_CELL_H

#include "solver/vec.h"

enum { FACETS_SIDES = 4 };

struct facets_cell {
    struct vec3 corner[FACETS_SIDES], middle;
};

struct facets_cell_point {
    int side;         /* from this corner to the next one */
    double weight[3]; /* of the middle and of these two corners; they add up to 1, none < 0 */
    struct vec3 r;
    double distance2; /* squared */
};

/* The point of the cell nearest to `point`; of several as near that of the first side. */
void facets_cell_nearest(const struct facets_cell *cell, struct vec3 point,
                         struct facets_cell_point *nearest);

#endif
