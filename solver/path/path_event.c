/* SPDX-License-Identifier: MIT */
#include "path_event.h"

#include <stdint.h>
#include <string.h>

/* A surface that folds by more than 178 degrees, the cosine of which this is, lies on itself: cloth
 * does not turn back there. */
static const double turned_back = -0.9994;

/* How far `x` lies beyond the knot line that leads to another span, and that line; 0 when the
 * span's own polynomials hold there (inside it, or past an open boundary). */
static double beyond_span(const struct path *g, int k, double x, double *knot) {
    const struct surface_axis *axis = &g->surface->axis[k];
    int s = g->span[k];
    double low = axis->breaks[s] + g->turn[k], high = axis->breaks[s + 1] + g->turn[k];
    double slack = 1e-13 * (high - low);
    bool open_low = s == 0 && !axis->closed;
    bool open_high = s == axis->span_count - 1 && !axis->closed;
    *knot = x < low ? low : high;
    if (x < low - slack && !open_low)
        return low - x;
    return x > high + slack && !open_high ? x - high : 0;
}

/* Moves into the next span of direction k. The tangent keeps its components along the common knot
 * line and across it: the two tangent planes are unfolded about the line. Beyond an open boundary
 * the next span may lie inside out: the creases on both its sides have met on the way, and nothing
 * is to be carried over it. */
static bool cross_knot(struct path *g, int k, double knot) {
    const struct surface_axis *axis = &g->surface->axis[k];
    struct surface_jet from, to, inner;
    double inside[2];
    g->uv[k] = knot;
    g->has_jet = false;
    path_jet(g, g->uv, &from);
    bool up = knot > (axis->breaks[g->span[k]] + axis->breaks[g->span[k] + 1]) / 2 + g->turn[k];
    double period = surface_axis_upper(axis) - surface_axis_lower(axis);
    g->span[k] += up ? 1 : -1;
    if (g->span[k] == axis->span_count) {
        g->span[k] = 0;
        g->turn[k] += period;
    } else if (g->span[k] < 0) {
        g->span[k] = axis->span_count - 1;
        g->turn[k] -= period;
    }
    path_jet(g, g->uv, &to);
    if (g->surface->has_folds && path_clamp(g, inside)) {
        path_jet(g, inside, &inner);
        g->ended = vec3_dot(vec3_cross(to.u, to.v), vec3_cross(inner.u, inner.v)) < 0;
        if (g->ended)
            return false;
    }
    if (g->kind != PATH_GEODESIC) {
        path_given_velocity(g, g->uv, &to, g->velocity);
        return isfinite(g->velocity[0]) && isfinite(g->velocity[1]);
    }
    struct vec3 along = vec3_unit(k == 0 ? from.v : from.u);
    struct vec3 side_from = k == 0 ? from.u : from.v, side_to = k == 0 ? to.u : to.v;
    side_from = vec3_unit(vec3_axpy(-vec3_dot(side_from, along), along, side_from));
    side_to = vec3_unit(vec3_axpy(-vec3_dot(side_to, along), along, side_to));
    if (vec3_dot(side_from, side_to) < turned_back) {
        g->ended = true;
        return false;
    }
    struct vec3 t = vec3_axpy(g->velocity[1], from.v, vec3_scale(g->velocity[0], from.u));
    struct vec3 turned =
        vec3_axpy(vec3_dot(t, side_from), side_to, vec3_scale(vec3_dot(t, along), along));
    g->jet = to;
    g->has_jet = true;
    return path_head_for(&to, turned, g->velocity);
}

/* Heads for the next point of the polyline that is not the one reached; past its end straight on.
 */
static bool turn_corner(struct path *g) {
    const double *here = g->curve[g->next];
    struct surface_jet jet;
    path_jet(g, g->uv, &jet);
    for (int64_t next = (int64_t)g->next + g->sense; next >= 0 && next < (int64_t)g->curve_count;
         next += g->sense) {
        g->next = (size_t)next;
        g->line[0] = g->curve[next][0] - here[0];
        g->line[1] = g->curve[next][1] - here[1];
        double velocity[2];
        path_given_velocity(g, g->uv, &jet, velocity);
        if (isfinite(velocity[0]) && isfinite(velocity[1])) {
            memcpy(g->velocity, velocity, sizeof velocity);
            return true;
        }
    }
    g->kind = PATH_GEODESIC;
    return true;
}

/* A step towards the event, as long as it can be followed, below h; not past it. */
static bool advance_towards(struct path *g, const struct path_event *event, double h,
                            double *length) {
    vec4 y;
    struct path_footing at = path_footing_of(g);
    for (int round = 0; round < PATH_ROUNDS; round++, h /= 4)
        if (path_followed(path_try_step(g, &at, h, &y)) &&
            event->sign * (event->at - y[event->k]) > 0) {
            path_accept(g, &y);
            *length = h;
            return true;
        }
    return false;
}

/* The share of a step of h, to the state `end`, at which the cubic through (u, p) at both its ends
 * reaches the event, which lies between. */
static double hermite_share(const struct path *g, const struct path_event *event, double h,
                            const vec4 *end) {
    int k = event->k;
    double a = g->uv[k], b = (*end)[k], low = 0, high = 1, t = (event->at - a) / (b - a);
    double pa = h * g->velocity[k], pb = h * (*end)[2 + k];
    for (int round = 0; round < PATH_ROUNDS; round++) {
        double c2 = 3 * (b - a) - 2 * pa - pb, c3 = pa + pb - 2 * (b - a);
        double value = a + t * (pa + t * (c2 + t * c3)) - event->at;
        double rate = pa + t * (2 * c2 + 3 * t * c3);
        *((value > 0) == (b > a) ? &high : &low) = t;
        double next = t - value / rate;
        if (!(next > low && next < high))
            next = (low + high) / 2;
        if (fabs(next - t) < 1e-9)
            return next;
        t = next;
    }
    return t;
}

/* The length to the event, at most h: Newton on uv[k](length) = at, kept between 0 and h by
 * bisection, from the length `first`; and the state there. False when the step to there is too long
 * to be followed; `length` then is one that was too long. */
static bool find_event(const struct path *g, const struct path_event *event, double h, double first,
                       vec4 *y, double *length) {
    int k = event->k;
    const struct surface_axis *axis = &g->surface->axis[k];
    struct path_footing at = path_footing_of(g);
    double low = 0, high = h, next = first, last = HUGE_VAL;
    double slack = 1e-14 * (surface_axis_upper(axis) - surface_axis_lower(axis));
    for (int round = 0; round < PATH_ROUNDS; round++) {
        if (fabs(next - last) <= path_nudge_share * h)
            path_short_step(g, last, next - last, y);
        else if (!path_followed(path_try_step(g, &at, next, y))) {
            *length = next;
            return false;
        }
        *length = last = next;
        double miss = event->sign * (event->at - (*y)[k]);
        if (fabs(miss) <= slack)
            break;
        *(miss > 0 ? &low : &high) = last;
        next = last + miss / (event->sign * (*y)[2 + k]);
        if (!(next > low && next < high))
            next = (low + high) / 2;
    }
    return true;
}

/* Whether the state y lies beyond a knot line of the direction other than k, and that line. */
static bool crosses_other(const struct path *g, int k, vec4 y, struct path_event *event) {
    double knot, beyond = beyond_span(g, 1 - k, y[1 - k], &knot);
    *event = (struct path_event){1 - k, knot, y[1 - k] > knot ? 1 : -1, false};
    return beyond > 0;
}

bool path_advance_to(struct path *g, const struct path_event *first, double h, const vec4 *end,
                     double *length) {
    struct path_event event = *first, other;
    vec4 y;
    *length = 0;
    if (event.sign * (event.at - g->uv[event.k]) > 0) {
        double share = hermite_share(g, &event, h, end);
        if (!find_event(g, &event, h, h * share, &y, length))
            return advance_towards(g, &event, *length / 2, length);
        if (crosses_other(g, event.k, y, &other)) {
            event = other;
            share = hermite_share(g, &event, *length, &y);
            if (!find_event(g, &event, *length, *length * share, &y, length))
                return advance_towards(g, &event, *length / 2, length);
        }
        path_accept(g, &y);
    }
    return event.corner ? turn_corner(g) : cross_knot(g, event.k, event.at);
}

bool path_first_event(const struct path *g, const vec4 *y, struct path_event *event) {
    double farthest = 0;
    for (int k = 0; k < 2; k++) {
        double knot, beyond = beyond_span(g, k, (*y)[k], &knot) / fabs((*y)[k] - g->uv[k]);
        if (beyond > farthest) {
            farthest = beyond;
            *event = (struct path_event){k, knot, (*y)[k] > knot ? 1 : -1, false};
        }
    }
    if (g->kind == PATH_CURVE) {
        int k = fabs(g->line[0]) > fabs(g->line[1]) ? 0 : 1;
        double to = surface_axis_inner(&g->surface->axis[k], g->curve[g->next][k]),
               beyond = ((*y)[k] - to) / ((*y)[k] - g->uv[k]);
        if (beyond >= 0 && beyond >= farthest) {
            farthest = 1;
            *event = (struct path_event){k, to, (*y)[k] > g->uv[k] ? 1 : -1, true};
        }
    }
    return farthest > 0;
}

double path_length_to_knot(const struct path *g, const struct path_footing *at,
                           struct path_event *event) {
    double least = HUGE_VAL;
    for (int k = 0; k < 2; k++) {
        const struct surface_axis *axis = &g->surface->axis[k];
        double p = at->state[1][k], bend = at->state[1][2 + k];
        int s = g->span[k], next = p > 0 ? s + 1 : s - 1;
        if (!axis->closed && (next < 0 || next == axis->span_count))
            continue;
        double knot = axis->breaks[p > 0 ? s + 1 : s] + g->turn[k], way = knot - g->uv[k];
        double root = p * p + 2 * bend * way;
        double length = root > 0 ? 2 * way / (p + (p > 0 ? 1 : -1) * sqrt(root)) : HUGE_VAL;
        if (length > 0 && length < least) {
            least = length;
            *event = (struct path_event){k, knot, p > 0 ? 1 : -1, false};
        }
    }
    return least;
}

bool path_touch_knot(struct path *g, const struct path_event *event, const vec4 *end,
                     double *length) {
    struct path_event other;
    vec4 y = *end;
    const struct surface_axis *axis = &g->surface->axis[event->k];
    double slack = 1e-14 * (surface_axis_upper(axis) - surface_axis_lower(axis)), gone = *length;
    for (int round = 0; round < 3; round++) {
        double way = event->at - y[event->k], by = way / y[2 + event->k];
        if (fabs(way) <= slack) {
            if (crosses_other(g, event->k, y, &other))
                return false;
            path_accept(g, &y);
            *length = gone;
            return cross_knot(g, event->k, event->at);
        }
        if (!(fabs(by) <= path_nudge_share * *length))
            return false;
        path_short_step(g, gone, by, &y);
        gone += by;
    }
    return false;
}
