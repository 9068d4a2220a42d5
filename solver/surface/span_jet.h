/* SPDX-License-Identifier: MIT */
/*
 * Evaluation of rational spans, for numbers and for lanes (`numbers.h`). With b_k the Bernstein
 * polynomials of the local parameter, or its powers, and P_kl the homogeneous control points of the
 * span, or coefficients,
 *
 *   A(u, v) = sum_k sum_l b_k(u) b_l(v) P_kl = w (r, 1),
 *
 * and r and its derivatives follow from those of A by the quotient rule.
 *
 * At one point the four coordinates of A are the lanes of one vector. At several points each
 * coordinate has a vector of its own, and a control point is one number for all lanes.
 */
#include "solver/numbers.h"
#include "spans.h"

/* A is held in PARTS parts, r in SPACE of them; control points are read in as many. */
#undef PART
#undef COEFFICIENT
#undef WEIGHT
#undef OWN_FUNCTION
#ifdef FORMULAS_OF_LANES
#define PART lanes
#define COEFFICIENT double
#define WEIGHT(a) (a)[3]
#define OWN_FUNCTION static
enum { PARTS = 4, SPACE = 3 };
#else
#define PART vec4
#define COEFFICIENT vec4
#define WEIGHT(a) (a)[0][3]
#define OWN_FUNCTION INLINE /* to be as wide as what calls it */
enum { PARTS = 1, SPACE = 1 };
#endif

/* Unrolls where the degree is a constant. */
#define UNROLL _Pragma("GCC unroll 10")

enum { ORDER_MAX = NURBS_DEGREE_MAX + 1, POWERS_ORDER = SURFACE_POWERS_DEGREE + 1 };

INLINE VECTOR NAME(in_space)(const PART r[SPACE]) {
#ifdef FORMULAS_OF_LANES
    return (VECTOR){r[0], r[1], r[2]};
#else
    return (VECTOR){r[0][0], r[0][1], r[0][2]};
#endif
}

/* A and its derivatives. */
struct NAME(homogeneous) {
    PART a[PARTS], u[PARTS], v[PARTS], uu[PARTS], uv[PARTS], vv[PARTS];
};

/* r and its first derivatives, and 1 / w. */
struct NAME(divided) {
    NUMBER g;
    PART r[SPACE], u[SPACE], v[SPACE];
};

INLINE struct NAME(divided) NAME(divide_first)(const struct NAME(homogeneous) * a) {
    struct NAME(divided) d;
    d.g = 1 / WEIGHT(a->a);
    UNROLL for (int n = 0; n < SPACE; n++) {
        d.r[n] = d.g * a->a[n];
        d.u[n] = d.g * (a->u[n] - WEIGHT(a->u) * d.r[n]);
        d.v[n] = d.g * (a->v[n] - WEIGHT(a->v) * d.r[n]);
    }
    return d;
}

INLINE void NAME(divide)(const struct NAME(homogeneous) * a, JET *jet) {
    struct NAME(divided) d = NAME(divide_first)(a);
    NUMBER g = d.g, wu = WEIGHT(a->u), wv = WEIGHT(a->v);
    PART uu[SPACE], uv[SPACE], vv[SPACE];
    UNROLL for (int n = 0; n < SPACE; n++) {
        uu[n] = g * (a->uu[n] - 2 * wu * d.u[n] - WEIGHT(a->uu) * d.r[n]);
        uv[n] = g * (a->uv[n] - wu * d.v[n] - wv * d.u[n] - WEIGHT(a->uv) * d.r[n]);
        vv[n] = g * (a->vv[n] - 2 * wv * d.v[n] - WEIGHT(a->vv) * d.r[n]);
    }
    jet->r = NAME(in_space)(d.r);
    jet->u = NAME(in_space)(d.u);
    jet->v = NAME(in_space)(d.v);
    jet->uu = NAME(in_space)(uu);
    jet->uv = NAME(in_space)(uv);
    jet->vv = NAME(in_space)(vv);
}

/* ---- in powers ---- */

/* One polynomial sum_k c_k x^k and half its second derivative: Horner's scheme run on its own
 * intermediate results. `p` >= 1. */
struct NAME(horner) {
    PART value, first, half_second;
};

INLINE struct NAME(horner) NAME(horner)(int p, const PART *c, NUMBER x, int order) {
    struct NAME(horner) h = {c[p], {0}, {0}};
    UNROLL for (int k = p - 1; k >= 0; k--) {
        if (order >= 2 && k <= p - 2)
            h.half_second = k == p - 2 ? h.first : h.half_second * x + h.first;
        if (order >= 1)
            h.first = k == p - 1 ? h.value : h.first * x + h.value;
        h.value = h.value * x + c[k];
    }
    return h;
}

/* In powers of the distance from the span's middle: a third of the work, but their coefficients
 * cancel more the higher the degree, to 7 units of rounding for cubics. */
INLINE void NAME(by_powers)(int p, int q, const vec4 *powers, NUMBER x, NUMBER y, JET *jet) {
    struct NAME(homogeneous) a;
    UNROLL for (int n = 0; n < PARTS; n++) {
        PART value[POWERS_ORDER], first[POWERS_ORDER], second[POWERS_ORDER], row[POWERS_ORDER];
        UNROLL for (int k = 0; k <= p; k++) {
            const COEFFICIENT *c = (const COEFFICIENT *)(powers + k * (q + 1)) + n;
            UNROLL for (int l = 0; l <= q; l++) row[l] = c[PARTS * l] - (PART){0};
            struct NAME(horner) h = NAME(horner)(q, row, y, 2);
            value[k] = h.value;
            first[k] = h.first;
            second[k] = 2 * h.half_second;
        }
        struct NAME(horner) h = NAME(horner)(p, value, x, 2), hv = NAME(horner)(p, first, x, 1);
        a.a[n] = h.value;
        a.u[n] = h.first;
        a.uu[n] = 2 * h.half_second;
        a.v[n] = hv.value;
        a.uv[n] = hv.first;
        a.vv[n] = NAME(horner)(p, second, x, 0).value;
    }
    NAME(divide)(&a, jet);
}

/* ---- in Bernstein's polynomials ---- */

/* Those of one degree and their derivatives in the surface's own parameter. */
struct NAME(basis) {
    NUMBER value[ORDER_MAX], first[ORDER_MAX], second[ORDER_MAX];
};

/* b^m from b^(m-1): b_k^m = (1 - t) b_k^(m-1) + t b_(k-1)^(m-1), in place. */
INLINE void NAME(raise_degree)(NUMBER *b, int m, NUMBER t) {
    NUMBER s = 1 - t;
    b[m] = t * b[m - 1];
    UNROLL for (int k = m - 1; k > 0; k--) b[k] = s * b[k] + t * b[k - 1];
    b[0] = s * b[0];
}

/* Derivatives are differences of the bases of lower degree:
 * b_k' = p (b_(k-1)^(p-1) - b_k^(p-1)),  b_k'' = p (p-1) (b_(k-2) - 2 b_(k-1) + b_k)^(p-2). */
INLINE void NAME(bernstein)(int p, NUMBER t, double rate, struct NAME(basis) * basis) {
    NUMBER *b = basis->value, none = {0};
    b[0] = N(of)(1);
    UNROLL for (int m = 1; m <= p - 2; m++) NAME(raise_degree)(b, m, t);
    double scale = rate * rate * p * (p - 1);
    UNROLL for (int k = 0; k <= p; k++) {
        NUMBER left = k >= 2 ? b[k - 2] : none;
        NUMBER middle = k >= 1 && k <= p - 1 ? b[k - 1] : none;
        NUMBER right = k <= p - 2 ? b[k] : none;
        basis->second[k] = p < 2 ? none : scale * (left - 2 * middle + right);
    }
    if (p >= 2)
        NAME(raise_degree)(b, p - 1, t);
    UNROLL for (int k = 0; k <= p; k++) basis->first[k] =
        rate * p * ((k >= 1 ? b[k - 1] : none) - (k <= p - 1 ? b[k] : none));
    NAME(raise_degree)(b, p, t);
}

INLINE void NAME(find_basis)(int p, NUMBER t, double rate, struct NAME(basis) * basis) {
#define CASE(P)                                                                                    \
    case P:                                                                                        \
        NAME(bernstein)(P, t, rate, basis);                                                        \
        break;
    switch (p) {
        SURFACE_DEGREES(CASE)
    default:
        break;
    }
#undef CASE
}

INLINE void NAME(sum_up)(int p, int q, const vec4 *points, const struct NAME(basis) * u,
                         const struct NAME(basis) * v, JET *jet) {
    struct NAME(homogeneous) sum;
    for (int n = 0; n < PARTS; n++) {
        PART a = {0}, au = {0}, av = {0}, auu = {0}, auv = {0}, avv = {0};
        for (int k = 0; k <= p; k++) {
            const COEFFICIENT *row = (const COEFFICIENT *)(points + k * (q + 1)) + n;
            PART c = {0}, cv = {0}, cvv = {0};
            UNROLL for (int l = 0; l <= q; l++) {
                c += v->value[l] * row[PARTS * l];
                cv += v->first[l] * row[PARTS * l];
                cvv += v->second[l] * row[PARTS * l];
            }
            a += u->value[k] * c;
            au += u->first[k] * c;
            auu += u->second[k] * c;
            av += u->value[k] * cv;
            auv += u->first[k] * cv;
            avv += u->value[k] * cvv;
        }
        sum.a[n] = a;
        sum.u[n] = au;
        sum.v[n] = av;
        sum.uu[n] = auu;
        sum.uv[n] = auv;
        sum.vv[n] = avv;
    }
    NAME(divide)(&sum, jet);
}

OWN_FUNCTION void NAME(by_points)(int p, int q, const vec4 *points, const NUMBER t[2],
                                  const double rate[2], JET *jet) {
    struct NAME(basis) u, v;
    NAME(find_basis)(p, t[0], rate[0], &u);
    NAME(find_basis)(q, t[1], rate[1], &v);
#define CASE(Q)                                                                                    \
    case Q:                                                                                        \
        NAME(sum_up)(p, Q, points, &u, &v, jet);                                                   \
        break;
    switch (q) {
        SURFACE_DEGREES(CASE)
    default:
        break;
    }
#undef CASE
}

/* ---- of a span ---- */

/* By the polynomials of the span. Each pair of degrees that powers are used for is a case of its
 * own, so that its loops unroll. */
INLINE void NAME(span_jet)(const struct surface *surface, int span_u, int span_v, NUMBER u,
                           NUMBER v, JET *jet) {
    const struct surface_axis *au = &surface->axis[0], *av = &surface->axis[1];
    size_t span = (size_t)span_u * (size_t)av->span_count + (size_t)span_v;
    size_t first = span * surface->points_per_span;
    int p = au->degree, q = av->degree;
    if (surface->height != 0) {
        NAME(surface_evaluate_moved)(surface, span_u, span_v, u, v, jet);
    } else if (surface->powers && surface->in_powers[span]) {
        NUMBER x = u - au->middles[span_u], y = v - av->middles[span_v];
#define CASE(P, Q)                                                                                 \
    case (P)*POWERS_ORDER + (Q):                                                                   \
        NAME(by_powers)(P, Q, surface->powers + first, x, y, jet);                                 \
        break;
        switch (p * POWERS_ORDER + q) {
            SURFACE_LOW_DEGREES(CASE)
        default:
            break;
        }
#undef CASE
    } else {
        const double rate[2] = {au->rates[span_u], av->rates[span_v]};
        const NUMBER t[2] = {(u - au->breaks[span_u]) * rate[0],
                             (v - av->breaks[span_v]) * rate[1]};
        NAME(by_points)(p, q, surface->points + first, t, rate, jet);
    }
}
