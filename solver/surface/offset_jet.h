/* SPDX-License-Identifier: MIT */
/*
 * The jet of a surface that is moved by h along its unit normal, r_h = r + h n, from the third
 * derivatives of the surface; for numbers and for lanes (`numbers.h`).
 *
 * With A = sum_k sum_l b_k(u) b_l(v) P_kl = w (r, 1) the derivatives of r follow from those of A by
 * the quotient rule; with m = r_u x r_v, J = |m| and n = m / J,
 *
 *   n_u  = (m_u - J_u n) / J,                       J_u  = n . m_u
 *   n_uv = (m_uv - J_uv n - J_u n_v - J_v n_u) / J,  J_uv = n . m_uv + J n_u . n_v
 *
 * and alike in the other directions; m_uv takes r_uuv and r_uvv.
 */
#include "solver/numbers.h"
#include "spans.h"

#define JETS NAME(jets)
#define THIRD NAME(third)
#define BASIS NAME(offset_basis)

#ifndef SOLVER_SURFACE_OFFSET_JET_H
#define SOLVER_SURFACE_OFFSET_JET_H

/* The derivatives up to the third, in their order. */
enum offset_part { OF, OF_U, OF_V, OF_UU, OF_UV, OF_VV, OF_UUU, OF_UUV, OF_UVV, OF_VVV, OF_PARTS };
enum { OFFSET_ORDER = NURBS_DEGREE_MAX + 1, OFFSET_DERIVATIVES = 4 };

#endif

/* Of one homogeneous coordinate. */
struct JETS {
    NUMBER of[OF_PARTS];
};

/* Of the surface itself. */
struct THIRD {
    VECTOR of[OF_PARTS];
};

/* Horner's scheme run on its own intermediate results: the value and the derivatives up to
 * `order`, each divided by its factorial. */
INLINE void NAME(offset_horner)(int p, const NUMBER *c, NUMBER x, int order,
                                NUMBER d[OFFSET_DERIVATIVES]) {
    d[0] = c[p];
    _Pragma("GCC unroll 4") for (int n = 1; n <= order; n++) d[n] = d[0] - d[0];
    _Pragma("GCC unroll 4") for (int k = p - 1; k >= 0; k--) {
        _Pragma("GCC unroll 4") for (int n = order; n > 0; n--) if (p - k >= n) d[n] =
            d[n] * x + d[n - 1];
        d[0] = d[0] * x + c[k];
    }
}

/* Coordinate `lane` from the powers of a span, about its middle. */
INLINE void NAME(offset_powers)(int p, int q, const vec4 *powers, int lane, NUMBER x, NUMBER y,
                                struct JETS *jets) {
    NUMBER by_y[OFFSET_DERIVATIVES][SURFACE_POWERS_DEGREE + 1];
    NUMBER none = x - x, d[OFFSET_DERIVATIVES];
    _Pragma("GCC unroll 4") for (int k = 0; k <= p; k++) {
        NUMBER row[SURFACE_POWERS_DEGREE + 1];
        _Pragma("GCC unroll 4") for (int l = 0; l <= q; l++) row[l] =
            none + powers[k * (q + 1) + l][lane];
        NAME(offset_horner)(q, row, y, 3, d);
        _Pragma("GCC unroll 4") for (int n = 0; n < OFFSET_DERIVATIVES; n++) by_y[n][k] = d[n];
    }
    NAME(offset_horner)(p, by_y[0], x, 3, d);
    jets->of[OF] = d[0];
    jets->of[OF_U] = d[1];
    jets->of[OF_UU] = 2 * d[2];
    jets->of[OF_UUU] = 6 * d[3];
    NAME(offset_horner)(p, by_y[1], x, 2, d);
    jets->of[OF_V] = d[0];
    jets->of[OF_UV] = d[1];
    jets->of[OF_UUV] = 2 * d[2];
    NAME(offset_horner)(p, by_y[2], x, 1, d);
    jets->of[OF_VV] = 2 * d[0];
    jets->of[OF_UVV] = 2 * d[1];
    NAME(offset_horner)(p, by_y[3], x, 0, d);
    jets->of[OF_VVV] = 6 * d[0];
}

/* Bernstein polynomials of one degree and their derivatives. */
struct BASIS {
    NUMBER of[OFFSET_DERIVATIVES][OFFSET_ORDER];
};

/* b^m from b^(m-1): b_k^m = (1 - t) b_k^(m-1) + t b_(k-1)^(m-1), in place; and on the way the
 * derivatives as differences of the bases of lower degree. */
static void NAME(offset_bernstein)(int p, NUMBER t, double rate, struct BASIS *basis) {
    static const double binomial[OFFSET_DERIVATIVES][OFFSET_DERIVATIVES] = {
        {1}, {-1, 1}, {1, -2, 1}, {-1, 3, -3, 1}};
    NUMBER b[OFFSET_ORDER], none = t - t;
    b[0] = none + 1;
    for (int m = 0; m <= p; m++) {
        for (int k = m; m > 0 && k >= 0; k--)
            b[k] = (k < m ? (1 - t) * b[k] : none) + (k > 0 ? t * b[k - 1] : none);
        int n = p - m;
        if (n >= OFFSET_DERIVATIVES)
            continue;
        double scale = 1;
        for (int r = 0; r < n; r++)
            scale *= rate * (p - r);
        for (int k = 0; k <= p; k++) {
            basis->of[n][k] = none;
            for (int r = 0; r <= n; r++)
                if (k - r >= 0 && k - r <= m)
                    basis->of[n][k] += scale * binomial[n][r] * b[k - r];
        }
    }
    for (int n = p + 1; n < OFFSET_DERIVATIVES; n++)
        for (int k = 0; k <= p; k++)
            basis->of[n][k] = none;
}

static void NAME(offset_points)(int p, int q, const vec4 *points, int lane, const struct BASIS *u,
                                const struct BASIS *v, struct JETS *jets) {
    static const int part[OFFSET_DERIVATIVES][OFFSET_DERIVATIVES] = {
        {OF, OF_V, OF_VV, OF_VVV}, {OF_U, OF_UV, OF_UVV}, {OF_UU, OF_UUV}, {OF_UUU}};
    for (int n = 0; n < OF_PARTS; n++)
        jets->of[n] = u->of[0][0] - u->of[0][0];
    for (int k = 0; k <= p; k++)
        for (int n = 0; n < OFFSET_DERIVATIVES; n++) {
            NUMBER sum = u->of[0][0] - u->of[0][0];
            for (int l = 0; l <= q; l++)
                sum += v->of[n][l] * points[k * (q + 1) + l][lane];
            for (int m = 0; m + n < OFFSET_DERIVATIVES; m++)
                jets->of[part[m][n]] += u->of[m][k] * sum;
        }
}

/* The quotient rule for one coordinate, A = w r, by its derivatives `a` and those of w. */
INLINE void NAME(offset_divide)(const struct JETS *a, const struct JETS *weight,
                                NUMBER r[OF_PARTS]) {
    const NUMBER *c = a->of, *w = weight->of;
    NUMBER g = 1 / w[OF];
    r[OF] = g * c[OF];
    r[OF_U] = g * (c[OF_U] - w[OF_U] * r[OF]);
    r[OF_V] = g * (c[OF_V] - w[OF_V] * r[OF]);
    r[OF_UU] = g * (c[OF_UU] - 2 * w[OF_U] * r[OF_U] - w[OF_UU] * r[OF]);
    r[OF_UV] = g * (c[OF_UV] - w[OF_U] * r[OF_V] - w[OF_V] * r[OF_U] - w[OF_UV] * r[OF]);
    r[OF_VV] = g * (c[OF_VV] - 2 * w[OF_V] * r[OF_V] - w[OF_VV] * r[OF]);
    r[OF_UUU] =
        g * (c[OF_UUU] - 3 * w[OF_U] * r[OF_UU] - 3 * w[OF_UU] * r[OF_U] - w[OF_UUU] * r[OF]);
    r[OF_UUV] = g * (c[OF_UUV] - 2 * w[OF_U] * r[OF_UV] - w[OF_V] * r[OF_UU] - w[OF_UU] * r[OF_V] -
                     2 * w[OF_UV] * r[OF_U] - w[OF_UUV] * r[OF]);
    r[OF_UVV] = g * (c[OF_UVV] - 2 * w[OF_V] * r[OF_UV] - w[OF_U] * r[OF_VV] - w[OF_VV] * r[OF_U] -
                     2 * w[OF_UV] * r[OF_V] - w[OF_UVV] * r[OF]);
    r[OF_VVV] =
        g * (c[OF_VVV] - 3 * w[OF_V] * r[OF_VV] - 3 * w[OF_VV] * r[OF_V] - w[OF_VVV] * r[OF]);
}

INLINE void NAME(offset_third)(const struct JETS a[4], struct THIRD *third) {
    NUMBER x[OF_PARTS], y[OF_PARTS], z[OF_PARTS];
    NAME(offset_divide)(&a[0], &a[3], x);
    NAME(offset_divide)(&a[1], &a[3], y);
    NAME(offset_divide)(&a[2], &a[3], z);
    _Pragma("GCC unroll 10") for (int n = 0; n < OF_PARTS; n++) third->of[n] =
        (VECTOR){x[n], y[n], z[n]};
}

INLINE void NAME(offset_by_powers)(int p, int q, const vec4 *powers, NUMBER x, NUMBER y,
                                   struct THIRD *third) {
    struct JETS a[4];
    _Pragma("GCC unroll 4") for (int lane = 0; lane < 4; lane++)
        NAME(offset_powers)(p, q, powers, lane, x, y, &a[lane]);
    NAME(offset_third)(a, third);
}

/* Point and derivatives of the surface before it is moved. */
INLINE void NAME(offset_base)(const struct surface *surface, int span_u, int span_v, NUMBER u,
                              NUMBER v, struct THIRD *third) {
    const struct surface_axis *au = &surface->axis[0], *av = &surface->axis[1];
    size_t span = (size_t)span_u * (size_t)av->span_count + (size_t)span_v;
    size_t first = span * surface->points_per_span;
    int p = au->degree, q = av->degree;
    if (surface->powers && surface->in_powers[span]) {
        NUMBER x = u - au->middles[span_u], y = v - av->middles[span_v];
#define CASE(P, Q)                                                                                 \
    case (P) * (SURFACE_POWERS_DEGREE + 1) + (Q):                                                  \
        NAME(offset_by_powers)(P, Q, surface->powers + first, x, y, third);                        \
        break;
        switch (p * (SURFACE_POWERS_DEGREE + 1) + q) {
            SURFACE_LOW_DEGREES(CASE)
        default:
            *third = (struct THIRD){0};
            break;
        }
#undef CASE
        return;
    }
    struct BASIS bu, bv;
    struct JETS a[4];
    NAME(offset_bernstein)
    (p, (u - au->breaks[span_u]) * au->rates[span_u], au->rates[span_u], &bu);
    NAME(offset_bernstein)
    (q, (v - av->breaks[span_v]) * av->rates[span_v], av->rates[span_v], &bv);
    for (int lane = 0; lane < 4; lane++)
        NAME(offset_points)(p, q, surface->points + first, lane, &bu, &bv, &a[lane]);
    NAME(offset_third)(a, third);
}

/* ---- the normal ---- */

/* A second derivative of n by a and b, from that of m over J; ja and jb are J_a / J and J_b / J. */
INLINE VECTOR NAME(offset_bend)(VECTOR m, VECTOR n, VECTOR na, VECTOR nb, NUMBER ja, NUMBER jb) {
    NUMBER along = V(dot)(n, m) + V(dot)(na, nb);
    VECTOR bend = V(axpy)(-along, n, m);
    bend = V(axpy)(-ja, nb, bend);
    return V(axpy)(-jb, na, bend);
}

/* Two vectors a and b of a tangent plane, by themselves and their derivatives u, v, uu, uv, vv. */
struct NAME(offset_sides) {
    VECTOR a[6], b[6];
};

/* The unit vector n along m = a x b and its derivatives up to the second; `area2` gets J^2. */
INLINE void NAME(offset_normal_of)(const struct NAME(offset_sides) * sides, JET *n, NUMBER *area2) {
    const VECTOR *a = sides->a, *b = sides->b;
    VECTOR m = V(cross)(a[0], b[0]);
    VECTOR mu = V(add)(V(cross)(a[1], b[0]), V(cross)(a[0], b[1]));
    VECTOR mv = V(add)(V(cross)(a[2], b[0]), V(cross)(a[0], b[2]));
    VECTOR mixed = V(cross)(a[1], b[1]);
    VECTOR muu = V(add)(V(add)(V(cross)(a[3], b[0]), V(add)(mixed, mixed)), V(cross)(a[0], b[3]));
    mixed = V(add)(V(cross)(a[1], b[2]), V(cross)(a[2], b[1]));
    VECTOR muv = V(add)(V(add)(V(cross)(a[4], b[0]), mixed), V(cross)(a[0], b[4]));
    mixed = V(cross)(a[2], b[2]);
    VECTOR mvv = V(add)(V(add)(V(cross)(a[5], b[0]), V(add)(mixed, mixed)), V(cross)(a[0], b[5]));
    *area2 = V(norm2)(m);
    NUMBER g = 1 / N(sqrt)(*area2);
    n->r = V(scale)(g, m);
    mu = V(scale)(g, mu);
    mv = V(scale)(g, mv);
    NUMBER ju = V(dot)(n->r, mu), jv = V(dot)(n->r, mv);
    n->u = V(axpy)(-ju, n->r, mu);
    n->v = V(axpy)(-jv, n->r, mv);
    n->uu = NAME(offset_bend)(V(scale)(g, muu), n->r, n->u, n->u, ju, ju);
    n->uv = NAME(offset_bend)(V(scale)(g, muv), n->r, n->u, n->v, ju, jv);
    n->vv = NAME(offset_bend)(V(scale)(g, mvv), n->r, n->v, n->v, jv, jv);
}

/* That of r_u and r_v. */
INLINE void NAME(offset_normal)(const struct THIRD *third, JET *n, NUMBER *area2) {
    const VECTOR *r = third->of;
    const struct NAME(offset_sides)
        sides = {{r[OF_U], r[OF_UU], r[OF_UV], r[OF_UUU], r[OF_UUV], r[OF_UVV]},
                 {r[OF_V], r[OF_UV], r[OF_VV], r[OF_UUV], r[OF_UVV], r[OF_VVV]}};
    NAME(offset_normal_of)(&sides, n, area2);
}

/* r_h = r + h n */
INLINE void NAME(offset_add)(const struct THIRD *third, NUMBER h, const JET *n, JET *jet) {
    const VECTOR *r = third->of;
    jet->r = V(axpy)(h, n->r, r[OF]);
    jet->u = V(axpy)(h, n->u, r[OF_U]);
    jet->v = V(axpy)(h, n->v, r[OF_V]);
    jet->uu = V(axpy)(h, n->uu, r[OF_UU]);
    jet->uv = V(axpy)(h, n->uv, r[OF_UV]);
    jet->vv = V(axpy)(h, n->vv, r[OF_VV]);
}

#undef JETS
#undef THIRD
#undef BASIS
