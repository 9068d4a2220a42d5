/* SPDX-License-Identifier: MIT */
/* Random NURBS surfaces for the tests, and their values by de Boor's algorithm in long double: an
 * implementation that shares nothing with the solver's. */
#ifndef UNIT_PATCH_H
#define UNIT_PATCH_H

#include "solver/surface/nurbs.h"
#include "solver/vec.h"
#include "support.h"
#include <stdbool.h>

enum { PATCH_SIZE_MAX = 16, PATCH_KNOTS_MAX = PATCH_SIZE_MAX + NURBS_DEGREE_MAX + 1 };

/* A definition together with its arrays; not to be moved once made. */
struct patch {
    double knots[2][PATCH_KNOTS_MAX];
    double weights[PATCH_SIZE_MAX * PATCH_SIZE_MAX];
    struct vec3 points[PATCH_SIZE_MAX * PATCH_SIZE_MAX];
    struct nurbs nurbs;
};

struct patch_kind {
    int p, q;
    bool clamped, rational;
};

/* Degrees p, q and a few spans of uneven knots, now and then repeated; a regular grid of points
 * with a random part of less than half a cell, so that the surface does not fold. */
void patch_make(struct patch *patch, const struct patch_kind *kind, struct random *random);

/* A random parameter strictly inside a random span of a direction, and that span's first knot. */
double patch_parameter(const struct nurbs_axis *axis, struct random *random, int *span);

struct patch_point {
    long double x, y, z;
};

/* r(u, v) by the polynomials of the spans that begin at knots lu and lv, anywhere. */
struct patch_point patch_evaluate(const struct nurbs *nurbs, int lu, int lv, long double u,
                                  long double v);

#endif
