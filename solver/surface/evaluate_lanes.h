/* SPDX-License-Identifier: MIT */
/*
 * surface_jet_at of LANES places at once, the same bits (evaluate.c has the mathematics). Those
 * in one span take it together, a control point or coefficient being one number for all. Only for
 * files that say LANES (solver/lanes.h).
 */
#ifndef SOLVER_SURFACE_EVALUATE_LANES_H
#define SOLVER_SURFACE_EVALUATE_LANES_H

#include "solver/lanes.h"
#include "spans.h"

struct lanes_jet {
    struct lanes3 r, u, v, uu, uv, vv;
};

/* Coordinates w x, w y, w z, w. */
struct lanes4 {
    lanes of[4];
};

INLINE struct lanes3 lanes4_place(const struct lanes4 *a) {
    return (struct lanes3){a->of[0], a->of[1], a->of[2]};
}

INLINE void lanes_divide(const struct lanes4 *a, const struct lanes4 *au, const struct lanes4 *av,
                         const struct lanes4 *auu, const struct lanes4 *auv,
                         const struct lanes4 *avv, struct lanes_jet *jet) {
    lanes g = 1 / a->of[3], wu = au->of[3], wv = av->of[3];
    struct lanes3 r = lanes3_scale(g, lanes4_place(a));
    struct lanes3 ru = lanes3_scale(g, lanes3_sub(lanes4_place(au), lanes3_scale(wu, r)));
    struct lanes3 rv = lanes3_scale(g, lanes3_sub(lanes4_place(av), lanes3_scale(wv, r)));
    struct lanes3 uu = lanes3_sub(lanes4_place(auu), lanes3_scale(2 * wu, ru));
    struct lanes3 uv = lanes3_sub(lanes4_place(auv), lanes3_scale(wu, rv));
    struct lanes3 vv = lanes3_sub(lanes4_place(avv), lanes3_scale(2 * wv, rv));
    uv = lanes3_sub(uv, lanes3_scale(wv, ru));
    jet->r = r;
    jet->u = ru;
    jet->v = rv;
    jet->uu = lanes3_scale(g, lanes3_sub(uu, lanes3_scale(auu->of[3], r)));
    jet->uv = lanes3_scale(g, lanes3_sub(uv, lanes3_scale(auv->of[3], r)));
    jet->vv = lanes3_scale(g, lanes3_sub(vv, lanes3_scale(avv->of[3], r)));
}

struct lanes_horner {
    lanes value, first, half_second;
};

/* Horner's scheme for the polynomial with the coefficients c[0], c[stride], .. */
#define LANES_HORNER(NAME, TYPE)                                                                   \
    INLINE struct lanes_horner NAME(int p, const TYPE *c, int stride, lanes x, int order) {        \
        struct lanes_horner h = {c[p * stride] - (lanes){0}, {0}, {0}};                            \
        _Pragma("GCC unroll 4") for (int k = p - 1; k >= 0; k--) {                                 \
            if (order >= 2 && k <= p - 2)                                                          \
                h.half_second = k == p - 2 ? h.first : h.half_second * x + h.first;                \
            if (order >= 1)                                                                        \
                h.first = k == p - 1 ? h.value : h.first * x + h.value;                            \
            h.value = h.value * x + c[k * stride];                                                 \
        }                                                                                          \
        return h;                                                                                  \
    }
LANES_HORNER(lanes_horner_numbers, double)
LANES_HORNER(lanes_horner_lanes, lanes)

INLINE void lanes_powers(int p, int q, const vec4 *powers, lanes x, lanes y,
                         struct lanes_jet *jet) {
    struct lanes4 a, au, av, auu, auv, avv;
    _Pragma("GCC unroll 4") for (int n = 0; n < 4; n++) {
        lanes value[SURFACE_POWERS_DEGREE + 1], first[SURFACE_POWERS_DEGREE + 1],
            second[SURFACE_POWERS_DEGREE + 1];
        _Pragma("GCC unroll 4") for (int k = 0; k <= p; k++) {
            const double *row = (const double *)(powers + k * (q + 1)) + n;
            struct lanes_horner h = lanes_horner_numbers(q, row, 4, y, 2);
            value[k] = h.value;
            first[k] = h.first;
            second[k] = 2 * h.half_second;
        }
        struct lanes_horner ha = lanes_horner_lanes(p, value, 1, x, 2);
        struct lanes_horner hv = lanes_horner_lanes(p, first, 1, x, 1);
        a.of[n] = ha.value;
        au.of[n] = ha.first;
        auu.of[n] = 2 * ha.half_second;
        av.of[n] = hv.value;
        auv.of[n] = hv.first;
        avv.of[n] = lanes_horner_lanes(p, second, 1, x, 0).value;
    }
    lanes_divide(&a, &au, &av, &auu, &auv, &avv, jet);
}

INLINE void lanes_low_degrees(int p, int q, const vec4 *powers, lanes x, lanes y,
                              struct lanes_jet *jet) {
#define CASE(P, Q)                                                                                 \
    case (P) * (SURFACE_POWERS_DEGREE + 1) + (Q):                                                  \
        lanes_powers(P, Q, powers, x, y, jet);                                                     \
        break;
    switch (p * (SURFACE_POWERS_DEGREE + 1) + q) {
        SURFACE_LOW_DEGREES(CASE)
    default:
        break;
    }
#undef CASE
}

#define OFFSET_NUMBER lanes
#define OFFSET_VECTOR struct lanes3
#define OFFSET_JET struct lanes_jet
#define OFFSET_NAME(f) f##_lanes
#define OFFSET_OF(f) lanes3_##f
#define OFFSET_SQRT(x) lanes_sqrt(x)
#include "offset_jet.h"

/* As surface_evaluate_moved; NaN where that has ways of its own. */
static __attribute__((noinline)) void lanes_moved(const struct surface *surface,
                                                  const struct surface_cursor *at,
                                                  const lanes uv[2], struct lanes_jet *jet) {
    const int span[2] = {at->span_u, at->span_v};
    struct third_lanes third;
    struct lanes_jet n;
    lanes area2;
    offset_base_lanes(surface, span[0], span[1], uv[0], uv[1], &third);
    offset_normal_lanes(&third, &n, &area2);
    offset_add_lanes(&third, lanes_of(surface->height), &n, jet);
    lanes_mask own = ~(area2 > 0);
    for (int k = 0; k < 2; k++)
        for (int end = 0; end < 2; end++) {
            const struct surface_axis *axis = &surface->axis[k];
            if (!axis->pinched[end] || span[k] != (end ? axis->span_count - 1 : 0))
                continue;
            lanes x = end ? surface_axis_upper(axis) - uv[k] : uv[k] - surface_axis_lower(axis);
            own |= x * axis->rates[span[k]] <= SURFACE_PINCH;
        }
    jet->r.x = lanes_select(own, lanes_of(NAN), jet->r.x);
}

enum { LANES_ORDER = NURBS_DEGREE_MAX + 1 };

struct lanes_basis {
    lanes value[LANES_ORDER], first[LANES_ORDER], second[LANES_ORDER];
};

INLINE void lanes_raise_degree(lanes *b, int m, lanes t) {
    lanes s = 1 - t;
    b[m] = t * b[m - 1];
    _Pragma("GCC unroll 10") for (int k = m - 1; k > 0; k--) b[k] = s * b[k] + t * b[k - 1];
    b[0] = s * b[0];
}

INLINE void lanes_bernstein(int p, lanes t, double rate, struct lanes_basis *basis) {
    lanes *b = basis->value, none = {0};
    b[0] = lanes_of(1);
    _Pragma("GCC unroll 10") for (int m = 1; m <= p - 2; m++) lanes_raise_degree(b, m, t);
    double scale = rate * rate * p * (p - 1);
    _Pragma("GCC unroll 10") for (int k = 0; k <= p; k++) {
        lanes left = k >= 2 ? b[k - 2] : none;
        lanes middle = k >= 1 && k <= p - 1 ? b[k - 1] : none;
        lanes right = k <= p - 2 ? b[k] : none;
        basis->second[k] = p < 2 ? none : scale * (left - 2 * middle + right);
    }
    if (p >= 2)
        lanes_raise_degree(b, p - 1, t);
    _Pragma("GCC unroll 10") for (int k = 0; k <= p; k++) basis->first[k] =
        rate * p * ((k >= 1 ? b[k - 1] : none) - (k <= p - 1 ? b[k] : none));
    lanes_raise_degree(b, p, t);
}

/* The sums of degree q in v, for each as a case of its own, so that they unroll. */
INLINE void lanes_sum_up(int p, int q, const vec4 *points, const struct lanes_basis *u,
                         const struct lanes_basis *v, struct lanes_jet *jet) {
    struct lanes4 a, au, av, auu, auv, avv;
    for (int n = 0; n < 4; n++) {
        lanes none = {0}, w = none, wu = none, wv = none, wuu = none, wuv = none, wvv = none;
        for (int k = 0; k <= p; k++) {
            const double *row = (const double *)(points + k * (q + 1)) + n;
            lanes c = none, cv = none, cvv = none;
            _Pragma("GCC unroll 10") for (int l = 0; l <= q; l++) {
                c += v->value[l] * row[4 * l];
                cv += v->first[l] * row[4 * l];
                cvv += v->second[l] * row[4 * l];
            }
            w += u->value[k] * c;
            wu += u->first[k] * c;
            wuu += u->second[k] * c;
            wv += u->value[k] * cv;
            wuv += u->first[k] * cv;
            wvv += u->value[k] * cvv;
        }
        a.of[n] = w;
        au.of[n] = wu;
        av.of[n] = wv;
        auu.of[n] = wuu;
        auv.of[n] = wuv;
        avv.of[n] = wvv;
    }
    lanes_divide(&a, &au, &av, &auu, &auv, &avv, jet);
}

INLINE void lanes_find_basis(int p, lanes t, double rate, struct lanes_basis *basis) {
#define CASE(P)                                                                                    \
    case P:                                                                                        \
        lanes_bernstein(P, t, rate, basis);                                                        \
        break;
    switch (p) {
        SURFACE_DEGREES(CASE)
    default:
        break;
    }
#undef CASE
}

static void lanes_points(int p, int q, const vec4 *points, const lanes t[2], const double rate[2],
                         struct lanes_jet *jet) {
    struct lanes_basis u, v;
    lanes_find_basis(p, t[0], rate[0], &u);
    lanes_find_basis(q, t[1], rate[1], &v);
#define CASE(Q)                                                                                    \
    case Q:                                                                                        \
        lanes_sum_up(p, Q, points, &u, &v, jet);                                                   \
        break;
    switch (q) {
        SURFACE_DEGREES(CASE)
    default:
        break;
    }
#undef CASE
}

INLINE bool lanes_in_span(const struct surface_axis *axis, int span, lanes x) {
    const double *b = axis->breaks + span;
    return span < axis->span_count && lanes_bits((x >= b[0]) & (x < b[1])) == LANES_ALL;
}

/* By the polynomials of the cursor's span. */
INLINE void lanes_jets_together(const struct surface *surface, const struct surface_cursor *at,
                                const lanes uv[2], struct lanes_jet *jet) {
    int span_u = at->span_u, span_v = at->span_v;
    lanes u = uv[0], v = uv[1];
    const struct surface_axis *au = &surface->axis[0], *av = &surface->axis[1];
    size_t span = (size_t)span_u * (size_t)av->span_count + (size_t)span_v;
    size_t first = span * surface->points_per_span;
    if (surface->height != 0) {
        lanes_moved(surface, at, uv, jet);
    } else if (surface->powers && surface->in_powers[span]) {
        lanes x = u - au->middles[span_u], y = v - av->middles[span_v];
        lanes_low_degrees(au->degree, av->degree, surface->powers + first, x, y, jet);
    } else {
        double rate[2] = {au->rates[span_u], av->rates[span_v]};
        lanes t[2] = {(u - au->breaks[span_u]) * rate[0], (v - av->breaks[span_v]) * rate[1]};
        lanes_points(au->degree, av->degree, surface->points + first, t, rate, jet);
    }
}

/* Not all in one span: for each span that there is, those that are in it. */
static __attribute__((noinline)) void lanes_jets_apart(const struct surface *surface,
                                                       struct surface_cursor *cursor,
                                                       const lanes uv[2], struct lanes_jet *jet) {
    double at[2][LANES];
    int64_t span[2][LANES];
    lanes_store(uv[0], at[0]);
    lanes_store(uv[1], at[1]);
    for (int n = 0; n < 2; n++)
        for (int k = 0; k < LANES; k++) {
            const struct surface_axis *axis = &surface->axis[n];
            int hint = n ? cursor->span_v : cursor->span_u;
            at[n][k] = surface_axis_wrap(axis, at[n][k]);
            span[n][k] = surface_axis_span(axis, hint, at[n][k]);
        }
    lanes_mask u, v;
    memcpy(&u, span[0], sizeof u);
    memcpy(&v, span[1], sizeof v);
    for (unsigned left = LANES_ALL; left;) {
        int first = __builtin_ctz(left);
        lanes_mask here = (u == span[0][first]) & (v == span[1][first]);
        const lanes wrapped[2] = {lanes_load(at[0]), lanes_load(at[1])};
        struct lanes_jet some;
        cursor->span_u = (int)span[0][first];
        cursor->span_v = (int)span[1][first];
        lanes_jets_together(surface, cursor, wrapped, left == LANES_ALL ? jet : &some);
        if (left != LANES_ALL)
            *jet = (struct lanes_jet){
                lanes3_select(here, some.r, jet->r),   lanes3_select(here, some.u, jet->u),
                lanes3_select(here, some.v, jet->v),   lanes3_select(here, some.uu, jet->uu),
                lanes3_select(here, some.uv, jet->uv), lanes3_select(here, some.vv, jet->vv)};
        left &= ~lanes_bits(here);
    }
}

INLINE void lanes_jet_at(const struct surface *surface, struct surface_cursor *cursor, lanes u,
                         lanes v, struct lanes_jet *jet) {
    const struct surface_axis *axis = surface->axis;
    const lanes uv[2] = {u, v};
    if (lanes_in_span(&axis[0], cursor->span_u, u) && lanes_in_span(&axis[1], cursor->span_v, v))
        lanes_jets_together(surface, cursor, uv, jet);
    else
        lanes_jets_apart(surface, cursor, uv, jet);
}

#endif
