/* SPDX-License-Identifier: MIT */
/*
 * Geodesics to rounding: x'' = -Gamma(x', x') by collocation at Chebyshev points on short blocks,
 * each solved by Picard's iteration. A block ends where the line crosses a knot, is integrated with
 * the polynomials of its own span, and hands its direction over by unfolding the two tangent planes
 * about their common edge; so neither knots nor creases cost accuracy. Beyond the domain the end
 * spans go on. A closed direction is not wrapped.
 */
#ifndef DRAPE_TESTS_GEODESIC_H
#define DRAPE_TESTS_GEODESIC_H

#include "shapes.h"

struct exact_geodesic_setup {
    const struct shape *shape; /* must outlive what is made from this */
    double uv[2];
    struct vec3 direction; /* unit tangent */
    double length;
    int blocks, order; /* at least so many blocks, with `order` points each */
};

struct exact_geodesic;

struct exact_geodesic *exact_geodesic_make(const struct exact_geodesic_setup *setup);
void exact_geodesic_free(struct exact_geodesic *geodesic);
/* uv and its derivative (may be NULL) at arc length s in [0, length]. */
void exact_geodesic_at(const struct exact_geodesic *geodesic, double s, double uv[2],
                       double duv[2]);

/* The geodesic from one point to another nearby, by Newton on direction and length (a shooter):
 * its length, and its unit tangents at both ends (may be NULL). Infinite when there is none. */
double exact_geodesic_distance(const struct shape *shape, const double from[2], const double to[2],
                               struct vec3 *first, struct vec3 *last);

/* -Gamma^k_ij a^i b^j: the second derivatives' tangent part, with the sign turned. */
void jet_connection(const struct surface_jet *jet, const double a[2], const double b[2],
                    double out[2]);

#endif
