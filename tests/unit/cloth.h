/* SPDX-License-Identifier: MIT */
/* Nets with fields of the test's choosing, as the solver gives them and as stored results. */
#ifndef UNIT_CLOTH_H
#define UNIT_CLOTH_H

#include "solver/mesh/facets.h"
#include "support.h"

/* The fields of a cell; all columns of its container, in this order. */
enum cloth_field {
    CLOTH_I,
    CLOTH_J,
    CLOTH_SHEAR,
    CLOTH_THICKNESS,
    CLOTH_WARP,
    CLOTH_WEFT = CLOTH_WARP + 3,
    CLOTH_K1 = CLOTH_WEFT + 3,
    CLOTH_K2,
    CLOTH_K3,
    CLOTH_K1_DIRECTION,
    CLOTH_LOCKED = CLOTH_K1_DIRECTION + 3,
    CLOTH_FIELDS
};

struct cloth {
    size_t node_count, cell_count;
    struct vec3 *nodes;
    int (*node_places)[2];
    int32_t (*corners)[4];
    int32_t (*places)[2];
    double (*fields)[CLOTH_FIELDS]; /* zero but for i, j, warp and weft */
};

/* Cells (i, j) of 0 <= i < n, 0 <= j < m for which `keep` (NULL: all) is true, node (i, j) at
 * at(i, j). `cloth_free` gives it back. */
struct cloth cloth_make(int n, int m, struct vec3 (*at)(double i, double j),
                        bool (*keep)(int i, int j));
void cloth_free(struct cloth *cloth);

struct facets_source cloth_source(const struct cloth *cloth);

/* The mean of a cell's corners. */
struct vec3 cloth_middle(const struct cloth *cloth, size_t cell);

/* The container of a result with the spacing 1. */
struct bytes cloth_result(const struct cloth *cloth);

#endif
