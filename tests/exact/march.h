/* SPDX-License-Identifier: MIT */
/*
 * A second, plain implementation of the march and of its deferred correction (docs/mathematics.md),
 * on the evaluator of `shapes.h`: it shows what errors the methods themselves have on a surface,
 * whatever program computes them. No ghosts, no free edges, no safeguards: the surface must be
 * large enough.
 */
#ifndef DRAPE_TESTS_MARCH_H
#define DRAPE_TESTS_MARCH_H

#include "shapes.h"
#include "solver/drape.h"

struct plain_setup {
    const struct shape *shape;
    double uv[2];
    struct vec3 warp, weft;   /* unit tangents at the start */
    enum drape_method method; /* DRAPE_BASIC, DRAPE_GIB or DRAPE_GIB4 */
    double spacing[2];
    int n[2]; /* nodes to -n..n in each direction */
};

/* The net; the caller gives it back with `plain_free`. */
struct drape_nodes *plain_make(const struct plain_setup *setup);
void plain_free(struct drape_nodes *nodes);

#endif
