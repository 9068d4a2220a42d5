/* SPDX-License-Identifier: MIT */
/*
 * The exact net on any smooth surface (see docs/mathematics.md), by integrating its equation: with
 * p = (u, v)_s along warp and q = (u, v)_t along weft, r_st = II(r_s, r_t) N says
 *
 *     p_t = q_s = F,   F^k = -Gamma^k_ij p^i q^j,
 *
 * a Goursat problem whose data are the two geodesics through the start. It is solved by collocation
 * at Chebyshev points on blocks of the (s, t) plane, each by Picard's iteration, which converges
 * factorially. On an analytic surface the error falls exponentially with the order, 1e-12 of the
 * size is usual; across curvature jumps it is of second order in the distance of the points.
 */
#ifndef DRAPE_TESTS_GOURSAT_H
#define DRAPE_TESTS_GOURSAT_H

#include "geodesic.h"

struct exact_net_point {
    double uv[2];
    struct vec3 r, warp, weft; /* position and unit tangents r_s, r_t */
    double shear_deg;
};

struct exact_net_setup {
    const struct shape *shape; /* must outlive the net */
    double uv[2];
    struct vec3 warp, weft; /* unit tangents at the start */
    double length[2];
    int blocks, order;
    bool one_quadrant; /* that of s, t >= 0 alone: from a corner of the surface */
};

struct exact_net;

/* |s| <= length[0] and |t| <= length[1]. */
struct exact_net *exact_net_make(const struct exact_net_setup *setup);
void exact_net_free(struct exact_net *net);
void exact_net_at(const struct exact_net *net, double s, double t, struct exact_net_point *point);

/* The integral of K dA over the index rectangle between (0,0) and the far corner of the quadrant
 * with the given signs, by Clenshaw-Curtis quadrature. */
double exact_net_curvature(const struct exact_net *net, int sign_s, int sign_t);

#endif
