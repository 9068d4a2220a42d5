/* SPDX-License-Identifier: MIT */
/*
 * surface_jet_at for LANES points at once, with the same bits (`span_jet.h`). Those in one span are
 * evaluated together. Only for files that say LANES (solver/lanes.h).
 */
#ifndef SOLVER_SURFACE_EVALUATE_LANES_H
#define SOLVER_SURFACE_EVALUATE_LANES_H

#include "solver/lanes.h"
#include "spans.h"

#define FORMULAS_OF_LANES
#include "offset_jet.h"

/* As surface_evaluate_moved; NaN where that has ways of its own. */
static __attribute__((noinline)) void surface_evaluate_moved_lanes(const struct surface *surface,
                                                                   int span_u, int span_v, lanes u,
                                                                   lanes v, struct lanes_jet *jet) {
    const int span[2] = {span_u, span_v};
    const lanes uv[2] = {u, v};
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

#include "span_jet.h"
#undef FORMULAS_OF_LANES

/* Not all in one span: for each span that there is, those that are in it. */
static __attribute__((noinline)) void lanes_jets_apart(const struct surface *surface,
                                                       struct surface_cursor *cursor,
                                                       const lanes uv[2], struct lanes_jet *jet) {
    double at[2][LANES];
    int64_t span[2][LANES];
    for (int n = 0; n < 2; n++) {
        const struct surface_axis *axis = &surface->axis[n];
        int hint = n ? cursor->span_v : cursor->span_u, known = hint < axis->span_count ? hint : 0;
        const double *b = axis->breaks + known;
        lanes_mask there = (uv[n] >= b[0]) & (uv[n] < b[1]);
        lanes_store(uv[n], at[n]);
        for (int k = 0; k < LANES; k++)
            span[n][k] = known;
        for (unsigned left = LANES_ALL & ~lanes_bits(there); left; left &= left - 1) {
            int k = __builtin_ctz(left);
            at[n][k] = surface_axis_wrap(axis, at[n][k]);
            span[n][k] = surface_axis_span(axis, known, at[n][k]);
        }
    }
    lanes_mask u, v;
    memcpy(&u, span[0], sizeof u);
    memcpy(&v, span[1], sizeof v);
    for (unsigned left = LANES_ALL; left;) {
        int first = __builtin_ctz(left);
        lanes_mask here = (u == span[0][first]) & (v == span[1][first]);
        struct lanes_jet some;
        cursor->span_u = (int)span[0][first];
        cursor->span_v = (int)span[1][first];
        span_jet_lanes(surface, cursor->span_u, cursor->span_v, lanes_load(at[0]),
                       lanes_load(at[1]), left == LANES_ALL ? jet : &some);
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
    const struct surface_axis *au = &surface->axis[0], *av = &surface->axis[1];
    const double *bu = au->breaks + cursor->span_u, *bv = av->breaks + cursor->span_v;
    const lanes uv[2] = {u, v};
    if (cursor->span_u < au->span_count && cursor->span_v < av->span_count &&
        lanes_all((u >= bu[0]) & (u < bu[1]) & (v >= bv[0]) & (v < bv[1])))
        span_jet_lanes(surface, cursor->span_u, cursor->span_v, u, v, jet);
    else
        lanes_jets_apart(surface, cursor, uv, jet);
}

#endif
