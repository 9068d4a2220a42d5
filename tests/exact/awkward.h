/* SPDX-License-Identifier: MIT */
/*
 * Surfaces that are no pleasure to drape: sharp bends, joints where the curvature jumps, creases,
 * ruled and twisted ones, starts at their edges. Those without a closed form are splines with
 * control points on the surface that they are called after, at the Greville abscissae: smooth, and
 * near it.
 */
#ifndef DRAPE_TESTS_AWKWARD_H
#define DRAPE_TESTS_AWKWARD_H

#include "shapes.h"

struct awkward {
    const char *name;
    void (*make)(struct shape *shape);
    double start[2]; /* shares of the domain */
    double angle_deg, d;
    int cells; /* of a net of spacing d, to each side of the start */
};

enum { AWKWARD = 16 };
extern const struct awkward awkward[AWKWARD];

/* Random ones of a kind, of a size of about 2. */
struct awkward_family {
    const char *name;
    void (*make)(struct shape *shape, uint64_t *seed);
};

enum { AWKWARD_FAMILIES = 7 };
extern const struct awkward_family awkward_families[AWKWARD_FAMILIES];

/* The start's parameters. */
void awkward_start(const struct awkward *which, const struct shape *shape, double uv[2]);

#endif
