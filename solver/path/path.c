/* SPDX-License-Identifier: MIT */
#include "path.h"

#include "dormand.h"
#include "solver/shell/crossing.h"
#include "solver/shell/shell.h"
#include <stdint.h>
#include <string.h>

enum {
    EVENT_ROUNDS = 12, /* Newton on the length to a span's edge */
    CHORD_ROUNDS = 8,  /* Newton on the length to a chord */
    SETTLE_ROUNDS = 3, /* to the place beyond a joint that was missed */
    JOINT_ROUNDS = 8,  /* steps, each half of the last, to a joint */
    JOINT_PIECES = 4,  /* straight ones, in which joints are sought along a step */
    FAILURES_MAX = 40, /* steps of one advance in one span that were too long */
    FAILURES_OUTSIDE = 8,
    STEPS_MAX = 200, /* steps of one advance in one span */
};

/* Local error allowed, as a share of the step, unless the owner of the path says more. */
static const double accuracy = 1e-12;

/* Steps of one advance beyond an open boundary, by the accuracy that the path is followed to: those
 * that the same way takes, for steps of order 8 go with the ninth root of it. */
static const struct {
    double accuracy;
    int steps;
} outside_most[] = {{5e-12, 24}, {5e-10, 16}, {5e-9, 12}, {HUGE_VAL, 9}};

/* With k the curvature of the surface and d the spacing, that of a net's own yarns: as a share of
 * (k d)^2 or (k d)^4, which the errors of a method of that order are a multiple of; and its limits.
 */
static const double share_of_order[2] = {1e-6, 1e-7}, finest_of_order[2] = {1e-9, 1e-11};
static const double coarsest = 1e-7;

/* Rounding in the sums of one step, as a share of the surface's coordinates. */
static const double rounding = 4e-15;

/* Steps shorter than this share of the whole are not tried: the line cannot be followed. Beyond an
 * open boundary, where the continuation may be anything, it is given up sooner. */
static const double shortest = 1e-10, shortest_outside = 1e-3;

/* The first step of a path, as a share of the length over which its velocity changes, by the eighth
 * root of its accuracy. */
static const double first_pace = 11;

/* A step that only corrects the end of another is this short against it at the most: then the
 * classical rule of fourth order is as exact. */
static const double nudge_share = 4e-3;

/* Relative accuracy of a chord along a path. */
static const double chord_tolerance = 1e-13, chord_rounding = 2e-15;

/* Steps and crossings of one advance; far more than any line needs. */
static const int rounds_max = 4 * NURBS_SIZE_MAX;

/* Nearer to a pole than this share of the surface's size, the line goes straight through it: the
 * turn it misses is the square of this. */
static const double pole_radius = 1e-7;

/* The velocity whose tangent is the projection of `t`, scaled to unit speed. */
static bool set_velocity(const struct surface_jet *jet, struct vec3 t, double velocity[2]) {
    struct station station = {
        .jet = *jet, .first = {vec3_norm2(jet->u), vec3_dot(jet->u, jet->v), vec3_norm2(jet->v)}};
    if (!station_components(&station, t, velocity))
        return false;
    double speed = vec3_norm(vec3_axpy(velocity[1], jet->v, vec3_scale(velocity[0], jet->u)));
    velocity[0] /= speed;
    velocity[1] /= speed;
    return speed > 0;
}

static void jet_here(const struct path *g, const double uv[2], struct surface_jet *jet) {
    surface_evaluate_span(g->surface, g->span[0], g->span[1], uv[0] - g->turn[0],
                          uv[1] - g->turn[1], jet);
}

/* The velocity of a path that is given by its direction at each place: a line of the chart, or the
 * section by a plane, along which plane . r stays what it is: (plane . r_v, -plane . r_u). */
static void given_velocity(const struct path *g, const double uv[2], const struct surface_jet *jet,
                           double velocity[2]) {
    double a, b;
    if (g->kind == PATH_CURVE) {
        const struct surface_axis *axis = g->surface->axis;
        a = g->line[0] * surface_axis_rate(&axis[0], uv[0] - g->turn[0], NULL);
        b = g->line[1] * surface_axis_rate(&axis[1], uv[1] - g->turn[1], NULL);
    } else {
        a = vec3_dot(g->plane, jet->v);
        b = -vec3_dot(g->plane, jet->u);
    }
    double speed = vec3_norm(vec3_axpy(b, jet->v, vec3_scale(a, jet->u)));
    velocity[0] = a / speed;
    velocity[1] = b / speed;
}

/* The state (u, v, p, q). */
static vec4 state_of(const struct path *g) {
    return (vec4){g->uv[0], g->uv[1], g->velocity[0], g->velocity[1]};
}

/* Its slope where the jet is that of (u, v): the equations at the top of path.h. */
static vec4 slope_of(const struct path *g, const struct surface_jet *jet, vec4 y) {
    double given[2], uv[2] = {y[0], y[1]}, p = y[2], q = y[3];
    if (g->kind != PATH_GEODESIC) {
        given_velocity(g, uv, jet, given);
        return (vec4){given[0], given[1], 0, 0};
    }
    struct vec3 a = vec3_scale(p * p, jet->uu);
    a = vec3_axpy(2 * p * q, jet->uv, a);
    a = vec3_axpy(q * q, jet->vv, a);
    double e = vec3_norm2(jet->u), f = vec3_dot(jet->u, jet->v), h = vec3_norm2(jet->v);
    double au = vec3_dot(a, jet->u), av = vec3_dot(a, jet->v);
    double inverse = 1 / (e * h - f * f);
    return (vec4){p, q, -(h * au - f * av) * inverse, -(e * av - f * au) * inverse};
}

static void slope_at(const void *context, const vec4 *y, vec4 *slope) {
    const struct path *g = context;
    struct surface_jet jet;
    double uv[2] = {(*y)[0], (*y)[1]};
    jet_here(g, uv, &jet);
    *slope = slope_of(g, &jet, *y);
}

/* A path that is given by its direction has no other velocity than that. */
static vec4 with_given_velocity(const struct path *g, vec4 y) {
    vec4 slope;
    if (g->kind == PATH_GEODESIC)
        return y;
    slope_at(g, &y, &slope);
    return (vec4){y[0], y[1], slope[0], slope[1]};
}

/* The distance in space that a difference of states makes over the step h. */
static double spatial_size(const struct surface_jet *jet, vec4 difference, double h) {
    double nu = vec3_norm(jet->u), nv = vec3_norm(jet->v);
    return nu * fabs(difference[0]) + nv * fabs(difference[1]) +
           h * (nu * fabs(difference[2]) + nv * fabs(difference[3]));
}

/* Where a step begins: the jet, the state and its slope. */
struct footing {
    struct surface_jet jet;
    vec4 state[2];
};

static struct footing footing_of(const struct path *g) {
    struct footing at = {.state = {state_of(g)}};
    if (g->has_jet)
        at.jet = g->jet;
    else
        jet_here(g, g->uv, &at.jet);
    at.state[1] = slope_of(g, &at.jet, at.state[0]);
    return at;
}

static double allowed_error(const struct path *g, const struct footing *at, double h) {
    return g->accuracy * h + rounding * (g->surface->size + vec3_norm(at->jet.r));
}

/* The length over which the velocity in parameters turns or changes by much. */
static double length_of_change(const struct footing *at) {
    vec4 slope = at->state[1];
    struct vec3 change = vec3_axpy(slope[3], at->jet.v, vec3_scale(slope[2], at->jet.u));
    return 1 / vec3_norm(change);
}

static double first_pace_of(const struct path *g, const struct footing *at) {
    return first_pace * sqrt(sqrt(sqrt(g->accuracy))) * length_of_change(at);
}

/* The error of a step of h by what is allowed: the step will do when that is less than 1; NaN where
 * there is no telling. */
static double error_of_step(const struct path *g, const struct footing *at, double h,
                            const struct dormand_error *error) {
    double fifth = spatial_size(&at->jet, error->fifth, h);
    double third = spatial_size(&at->jet, error->third, h);
    double size = sqrt(fifth * fifth + 0.01 * third * third);
    return (size > 0 ? fifth * fifth / size : size) / allowed_error(g, at, h);
}

/* One step of h, however long, and its error as above. */
static double try_step(const struct path *g, const struct footing *at, double h, vec4 *out) {
    struct dormand_error error;
    dormand_step(slope_at, g, h, at->state, out, &error);
    *out = with_given_velocity(g, *out);
    return error_of_step(g, at, h, &error);
}

static bool followed(double error) {
    return error < 1;
}

/* What to multiply a step with this error by: the error goes with the eighth power. */
static double rescaling(double error) {
    double factor = error < 1e16 ? 0.92 / sqrt(sqrt(sqrt(fmax(error, 1e-8)))) : 0;
    return fmin(fmax(factor, 0.1), 4);
}

/* A step so short, of either sign, that the classical Runge-Kutta rule will do. */
static vec4 short_step(const struct path *g, vec4 y, double h) {
    vec4 k[4], at;
    slope_at(g, &y, &k[0]);
    at = y + h / 2 * k[0];
    slope_at(g, &at, &k[1]);
    at = y + h / 2 * k[1];
    slope_at(g, &at, &k[2]);
    at = y + h * k[2];
    slope_at(g, &at, &k[3]);
    return with_given_velocity(g, y + h / 6 * (k[0] + 2 * k[1] + 2 * k[2] + k[3]));
}

/* How far `x` lies beyond the span's edge that leads to another span, and that edge; 0 when the
 * span's own polynomials hold there (inside it, or past an open boundary). */
static double beyond_span(const struct path *g, int k, double x, double *edge) {
    const struct surface_axis *axis = &g->surface->axis[k];
    int s = g->span[k];
    double low = axis->breaks[s] + g->turn[k], high = axis->breaks[s + 1] + g->turn[k];
    double slack = 1e-13 * (high - low);
    bool open_low = s == 0 && !axis->closed;
    bool open_high = s == axis->span_count - 1 && !axis->closed;
    *edge = x < low ? low : high;
    if (x < low - slack && !open_low)
        return low - x;
    return x > high + slack && !open_high ? x - high : 0;
}

/* A surface that folds by more than 178 degrees, the cosine of which this is, lies on itself: cloth
 * does not turn back there. */
static const double turned_back = -0.9994;

/* Moves into the next span of direction k. The tangent keeps its components along the common edge
 * and across it: the two tangent planes are unfolded about the edge. */
static bool cross_edge(struct path *g, int k, double edge) {
    const struct surface_axis *axis = &g->surface->axis[k];
    struct surface_jet from, to;
    g->uv[k] = edge;
    g->has_jet = false;
    jet_here(g, g->uv, &from);
    bool up = edge > (axis->breaks[g->span[k]] + axis->breaks[g->span[k] + 1]) / 2 + g->turn[k];
    double period = surface_axis_upper(axis) - surface_axis_lower(axis);
    g->span[k] += up ? 1 : -1;
    if (g->span[k] == axis->span_count) {
        g->span[k] = 0;
        g->turn[k] += period;
    } else if (g->span[k] < 0) {
        g->span[k] = axis->span_count - 1;
        g->turn[k] -= period;
    }
    jet_here(g, g->uv, &to);
    if (g->kind != PATH_GEODESIC) {
        given_velocity(g, g->uv, &to, g->velocity);
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
    return set_velocity(&to, turned, g->velocity);
}

static void accept(struct path *g, vec4 y) {
    g->has_jet = false;
    g->uv[0] = y[0];
    g->uv[1] = y[1];
    g->velocity[0] = y[2];
    g->velocity[1] = y[3];
}

/* What a step may run into: the parameter of direction k reaches `at`, an edge of the span or, with
 * `corner`, the next point of a polyline; from below with sign 1, from above with -1. */
struct event {
    int k;
    double at, sign;
    bool corner;
};

/* Heads for the next point of the polyline that is not the one reached; past its end straight on.
 */
static bool turn_corner(struct path *g) {
    const double *here = g->curve[g->next];
    struct surface_jet jet;
    jet_here(g, g->uv, &jet);
    for (int64_t next = (int64_t)g->next + g->sense; next >= 0 && next < (int64_t)g->curve_count;
         next += g->sense) {
        g->next = (size_t)next;
        g->line[0] = g->curve[next][0] - here[0];
        g->line[1] = g->curve[next][1] - here[1];
        double velocity[2];
        given_velocity(g, g->uv, &jet, velocity);
        if (isfinite(velocity[0]) && isfinite(velocity[1])) {
            memcpy(g->velocity, velocity, sizeof velocity);
            return true;
        }
    }
    g->kind = PATH_GEODESIC;
    return true;
}

static bool pass_event(struct path *g, const struct event *event) {
    return event->corner ? turn_corner(g) : cross_edge(g, event->k, event->at);
}

/* A step towards the event, as long as it can be followed, below h; not past it. */
static bool advance_towards(struct path *g, const struct event *event, double h, double *length) {
    vec4 y;
    struct footing at = footing_of(g);
    for (int round = 0; round < EVENT_ROUNDS; round++, h /= 4)
        if (followed(try_step(g, &at, h, &y)) && event->sign * (event->at - y[event->k]) > 0) {
            accept(g, y);
            *length = h;
            return true;
        }
    return false;
}

/* The share of a step of h at which the cubic through (u, p) at both its ends, `from` and `to`,
 * reaches `at`, which lies between. */
static double hermite_share(const vec4 *from, const vec4 *to, int k, double h, double at) {
    double a = (*from)[k], b = (*to)[k], low = 0, high = 1, t = (at - a) / (b - a);
    double pa = h * (*from)[2 + k], pb = h * (*to)[2 + k];
    for (int round = 0; round < EVENT_ROUNDS; round++) {
        double c2 = 3 * (b - a) - 2 * pa - pb, c3 = pa + pb - 2 * (b - a);
        double value = a + t * (pa + t * (c2 + t * c3)) - at, rate = pa + t * (2 * c2 + 3 * t * c3);
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

/* The length to the event, at most h, where the state is `end`: Newton on uv[k](length) = at, kept
 * between 0 and h by bisection, from where a cubic meets the edge; and the state there. False when
 * the step to there is too long to be followed; `length` then is one that was too long. */
static bool find_event(const struct path *g, const struct event *event, double h, const vec4 *end,
                       vec4 *y, double *length) {
    int k = event->k;
    const struct surface_axis *axis = &g->surface->axis[k];
    struct footing at = footing_of(g);
    double low = 0, high = h, next = h * hermite_share(at.state, end, k, h, event->at),
           last = HUGE_VAL;
    double slack = 1e-14 * (surface_axis_upper(axis) - surface_axis_lower(axis));
    for (int round = 0; round < EVENT_ROUNDS; round++) {
        if (fabs(next - last) <= nudge_share * h)
            *y = short_step(g, *y, next - last);
        else if (!followed(try_step(g, &at, next, y))) {
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

/* Whether the state y lies beyond an edge of the direction other than k, and that edge. */
static bool crosses_other(const struct path *g, int k, vec4 y, struct event *event) {
    double edge, beyond = beyond_span(g, 1 - k, y[1 - k], &edge);
    *event = (struct event){1 - k, edge, y[1 - k] > edge ? 1 : -1, false};
    return beyond > 0;
}

/* Moves to the event before the end of a step of h, and past it; next to a corner of the span to
 * that edge which comes first. Less far when the step to there is too long to be followed. */
static bool advance_to_event(struct path *g, const struct event *first, double h, const vec4 *end,
                             double *length) {
    struct event event = *first, other;
    vec4 y, before;
    *length = 0;
    if (event.sign * (event.at - g->uv[event.k]) <= 0)
        return pass_event(g, &event);
    if (!find_event(g, &event, h, end, &y, length))
        return advance_towards(g, &event, *length / 2, length);
    if (crosses_other(g, event.k, y, &other)) {
        event = other;
        before = y;
        if (!find_event(g, &event, *length, &before, &y, length))
            return advance_towards(g, &event, *length / 2, length);
    }
    accept(g, y);
    return pass_event(g, &event);
}

static struct vec3 point_of(const struct path *g, struct vec3 *tangent) {
    struct surface_jet jet;
    jet_here(g, g->uv, &jet);
    *tangent = vec3_unit(vec3_axpy(g->velocity[1], jet.v, vec3_scale(g->velocity[0], jet.u)));
    return jet.r;
}

/* Whether the place where a path is, is taken by the surface as in the path's own span. */
static bool is_in_own_span(const struct path *g) {
    bool own = true;
    for (int k = 0; k < 2; k++) {
        const struct surface_axis *axis = &g->surface->axis[k];
        double at = surface_axis_wrap(axis, g->uv[k]);
        own = own && at == g->uv[k] - g->turn[k] &&
              surface_axis_span(axis, g->span[k], at) == g->span[k];
    }
    return own;
}

bool path_station(const struct path *path, struct surface_cursor *cursor, struct station *station,
                  struct vec3 *tangent) {
    struct surface_jet jet;
    double uv[2] = {path->uv[0], path->uv[1]};
    if (path->has_jet)
        jet = path->jet;
    else
        jet_here(path, uv, &jet);
    struct vec3 t =
        vec3_unit(vec3_axpy(path->velocity[1], jet.v, vec3_scale(path->velocity[0], jet.u)));
    if (tangent)
        *tangent = t;
    bool regular;
    if (is_in_own_span(path)) {
        *station = (struct station){.uv = {uv[0], uv[1]}, .jet = jet};
        regular = station_complete(path->surface, station);
    } else {
        regular = station_at(path->surface, cursor, uv, station);
    }
    if (!regular || !(path->ahead > 0))
        return regular;
    return station_pull(path->surface, cursor, station, vec3_scale(-path->ahead, t), uv) &&
           station_at(path->surface, cursor, uv, station);
}

/* Puts the path at uv, in the span there, heading along the projection of `direction`. */
static bool place(struct path *g, const double uv[2], struct vec3 direction) {
    for (int k = 0; k < 2; k++) {
        const struct surface_axis *axis = &g->surface->axis[k];
        double wrapped = surface_axis_wrap(axis, uv[k]);
        g->uv[k] = uv[k];
        g->turn[k] = uv[k] - wrapped;
        g->span[k] = surface_axis_span(axis, 0, wrapped);
    }
    jet_here(g, g->uv, &g->jet);
    g->has_jet = true;
    return set_velocity(&g->jet, direction, g->velocity);
}

/* Leaps straight on by `length`, which is next to nothing, through a pole. */
static bool leap(struct path *g, const struct station *from, struct vec3 direction, double length) {
    struct surface_cursor cursor = {0, 0};
    double uv[2];
    g->ahead += length;
    return station_pull(g->surface, &cursor, from, vec3_scale(length, direction), uv) &&
           place(g, uv, direction);
}

bool path_geodesic(struct path *path, const struct surface *surface, const struct station *from,
                   struct vec3 direction) {
    struct vec3 pole, tangent = station_tangent(from, direction);
    *path = (struct path){.surface = surface, .accuracy = accuracy};
    if (!(vec3_norm2(tangent) > 0))
        return false;
    double radius = pole_radius * surface->size;
    if (station_pole_distance(surface, from->jet.r, &pole) < radius)
        return leap(path, from, tangent, radius);
    return place(path, from->uv, tangent);
}

bool path_section(struct path *path, const struct surface *surface, const struct station *from,
                  struct vec3 plane, struct vec3 direction) {
    struct vec3 along = vec3_cross(plane, from->normal);
    if (!path_geodesic(path, surface, from,
                       vec3_dot(along, direction) < 0 ? vec3_scale(-1, along) : along))
        return false;
    path->kind = PATH_SECTION;
    path->plane = vec3_dot(along, direction) < 0 ? vec3_scale(-1, plane) : plane;
    return true;
}

bool path_curve(struct path *path, const struct surface *surface, const struct station *from,
                const double (*curve)[2], size_t count, size_t next, int sense) {
    *path = (struct path){.surface = surface,
                          .accuracy = accuracy,
                          .kind = PATH_CURVE,
                          .curve = curve,
                          .curve_count = count,
                          .next = next,
                          .sense = sense};
    struct vec3 direction;
    double uv[2], ab[2];
    surface_outer(surface, from->uv, uv);
    for (int k = 0; k < 2; k++) {
        path->line[k] = curve[next][k] - uv[k];
        ab[k] = path->line[k] * surface_axis_rate(&surface->axis[k], from->uv[k], NULL);
    }
    direction = vec3_axpy(ab[1], from->jet.v, vec3_scale(ab[0], from->jet.u));
    return place(path, from->uv, direction);
}

/* Goes through a pole when the point is within its radius and heading for it: straight on to the
 * mirrored place on the other side. */
static bool pass_pole(struct path *g, struct vec3 pole) {
    struct surface_cursor cursor = {0, 0};
    struct station here;
    struct vec3 t, r = point_of(g, &t);
    double before = vec3_dot(vec3_sub(pole, r), t);
    if (before <= 0)
        return true;
    if (g->kind == PATH_CURVE)
        return false;
    return station_at(g->surface, &cursor, g->uv, &here) && leap(g, &here, t, 2 * before);
}

/* The longest step worth trying: half way to a pole that is near. */
static double cap_step(const struct path *g, double h, struct vec3 *pole, bool *at_pole) {
    struct vec3 t;
    *at_pole = false;
    if (!g->surface->has_poles)
        return h;
    double distance = station_pole_distance(g->surface, point_of(g, &t), pole);
    *at_pole = distance <= pole_radius * g->surface->size;
    return h > distance / 2 ? distance / 2 : h;
}

/* The event that a step from here to y runs into first, by the share of the step that lies beyond
 * it; false when there is none. */
static bool first_event(const struct path *g, vec4 y, struct event *event) {
    double farthest = 0;
    for (int k = 0; k < 2; k++) {
        double edge, beyond = beyond_span(g, k, y[k], &edge) / fabs(y[k] - g->uv[k]);
        if (beyond > farthest) {
            farthest = beyond;
            *event = (struct event){k, edge, y[k] > edge ? 1 : -1, false};
        }
    }
    if (g->kind == PATH_CURVE) {
        int k = fabs(g->line[0]) > fabs(g->line[1]) ? 0 : 1;
        double to = surface_axis_inner(&g->surface->axis[k], g->curve[g->next][k]),
               beyond = (y[k] - to) / (y[k] - g->uv[k]);
        if (beyond >= 0 && beyond >= farthest) {
            farthest = 1;
            *event = (struct event){k, to, y[k] > g->uv[k] ? 1 : -1, true};
        }
    }
    return farthest > 0;
}

/* Whether the path is more than a domain's length beyond an open boundary: the continuation is of
 * no use there, and may be singular. */
static bool far_outside(const struct path *g) {
    for (int k = 0; k < 2; k++) {
        const struct surface_axis *axis = &g->surface->axis[k];
        double low = surface_axis_lower(axis), high = surface_axis_upper(axis);
        if (!axis->closed && !(fabs(g->uv[k] - (low + high) / 2) <= 1.5 * (high - low)))
            return true;
    }
    return false;
}

/* Whether the path is beyond an open boundary. */
static bool is_outside(const struct path *g) {
    for (int k = 0; k < 2; k++) {
        const struct surface_axis *axis = &g->surface->axis[k];
        if (!axis->closed &&
            !(g->uv[k] >= surface_axis_lower(axis) && g->uv[k] <= surface_axis_upper(axis)))
            return true;
    }
    return false;
}

/* The length to the edge of the span that the path meets first, to second order, and that edge;
 * infinite where it meets none. */
static double length_to_edge(const struct path *g, const struct footing *at, struct event *event) {
    double least = HUGE_VAL;
    for (int k = 0; k < 2; k++) {
        const struct surface_axis *axis = &g->surface->axis[k];
        double p = at->state[1][k], bend = at->state[1][2 + k];
        int s = g->span[k], next = p > 0 ? s + 1 : s - 1;
        if (!axis->closed && (next < 0 || next == axis->span_count))
            continue;
        double edge = axis->breaks[p > 0 ? s + 1 : s] + g->turn[k], way = edge - g->uv[k];
        double root = p * p + 2 * bend * way;
        double length = root > 0 ? 2 * way / (p + (p > 0 ? 1 : -1) * sqrt(root)) : HUGE_VAL;
        if (length > 0 && length < least) {
            least = length;
            *event = (struct event){k, edge, p > 0 ? 1 : -1, false};
        }
    }
    return least;
}

/* From the end `y` of a step that was to reach the edge to that edge, where it is near enough, and
 * past it. False, with nothing done, where it is not. */
static bool touch_edge(struct path *g, const struct event *event, vec4 y, double *length) {
    struct event other;
    const struct surface_axis *axis = &g->surface->axis[event->k];
    double slack = 1e-14 * (surface_axis_upper(axis) - surface_axis_lower(axis)), gone = *length;
    for (int round = 0; round < 3; round++) {
        double way = event->at - y[event->k], by = way / y[2 + event->k];
        if (fabs(way) <= slack) {
            if (crosses_other(g, event->k, y, &other))
                return false;
            accept(g, y);
            *length = gone;
            return pass_event(g, event);
        }
        if (!(fabs(by) <= nudge_share * *length))
            return false;
        y = short_step(g, y, by);
        gone += by;
    }
    return false;
}

/* Of one advance: steps that were too long and steps, since the last edge of a span, and the
 * length.
 */
struct effort {
    int failures, steps;
    double whole;
};

/* Whether a step of h, which has to be shortened, is still worth trying. Near a pole steps are
 * short on the continuation, too. */
static bool worth_trying(const struct path *g, struct effort *effort, double h) {
    struct vec3 pole, tangent;
    bool near_pole =
        station_pole_distance(g->surface, point_of(g, &tangent), &pole) < effort->whole;
    bool outside = is_outside(g) && !near_pole;
    return ++effort->failures <= (outside ? FAILURES_OUTSIDE : FAILURES_MAX) &&
           h > (outside ? shortest_outside : shortest) * effort->whole;
}

/* A step that is about to be taken: how long it is, and where it then leads. */
struct attempt {
    struct footing at;
    double h;
    struct event edge; /* that of the span, if the step is to end there */
    bool at_edge;
    vec4 y;
    double error;
};

/* One of at most h that ends in this span or on its edge. */
static struct attempt plan_step(const struct path *g, double h) {
    struct attempt a = {.at = footing_of(g)};
    h = fmin(h, g->pace > 0 ? g->pace : first_pace_of(g, &a.at));
    double edge = length_to_edge(g, &a.at, &a.edge);
    a.at_edge = edge <= h;
    a.h = a.at_edge ? edge : h;
    return a;
}

/* Takes a step that has been tried, or a shorter one; the length it went. */
static bool take_step(struct path *g, struct attempt *a, struct effort *effort, double *length) {
    struct event event;
    while (!followed(a->error)) {
        a->h *= fmin(rescaling(a->error), 0.85);
        a->at_edge = false;
        if (!worth_trying(g, effort, a->h))
            return false;
        a->error = try_step(g, &a->at, a->h, &a->y);
    }
    double pace = a->h * rescaling(a->error);
    g->error += a->error * allowed_error(g, &a->at, a->h);
    g->pace = a->at_edge && g->pace > 0 ? fmax(g->pace, pace) : pace;
    *length = a->h;
    if (a->at_edge && g->kind != PATH_CURVE && touch_edge(g, &a->edge, a->y, length))
        return true;
    if (first_event(g, a->y, &event))
        return advance_to_event(g, &event, a->h, &a->y, length);
    accept(g, a->y);
    return true;
}

/* One step of at most h that ends in this span or on its edge; the length it went. */
static bool advance_in_span(struct path *g, double h, struct effort *effort, double *length) {
    struct attempt a = plan_step(g, h);
    a.error = try_step(g, &a.at, a.h, &a.y);
    return take_step(g, &a, effort, length);
}

/* ---- from face to face of a shell ---- */

/* The cubic through (u, v) and velocity at both ends of a step of h, at a share of it. */
static void cubic_at(const struct path *from, const struct path *to, double h, double share,
                     double uv[2]) {
    double s = share, r = 1 - share;
    for (int k = 0; k < 2; k++)
        uv[k] = r * r * (1 + 2 * s) * from->uv[k] + s * s * (1 + 2 * r) * to->uv[k] +
                h * s * r * (r * from->velocity[k] - s * to->velocity[k]);
}

/* The first joint that a step of h from `from` to `to` crosses, and about how far on that is. */
static bool find_joint(const struct path *from, const struct path *to, double h,
                       struct crossing *joint, double *length) {
    double at[JOINT_PIECES + 1][2], low[2], high[2], share;
    for (int k = 0; k <= JOINT_PIECES; k++) {
        cubic_at(from, to, h, (double)k / JOINT_PIECES, at[k]);
        for (int x = 0; x < 2; x++) {
            low[x] = k == 0 || at[k][x] < low[x] ? at[k][x] : low[x];
            high[x] = k == 0 || at[k][x] > high[x] ? at[k][x] : high[x];
        }
    }
    if (crossing_none_within(from->surface, low, high))
        return false;
    for (int k = 0; k < JOINT_PIECES; k++)
        if (crossing_on_way(from->surface, at[k], at[k + 1], &share, joint)) {
            *length = h * (k + share) / JOINT_PIECES;
            return true;
        }
    return false;
}

/* Moves `g` to where it meets the joint, about `*length` on: Newton's method for the length and the
 * edge's parameter. False when it does not get there. */
static bool meet_joint(struct path *g, struct crossing *joint, double *length) {
    struct footing at = footing_of(g);
    vec4 y = at.state[0];
    double here = 0, next = *length, least = 1e-15 * g->surface->size;
    for (int round = 0; round < EVENT_ROUNDS; round++) {
        double rate[2];
        if (fabs(next - here) <= nudge_share * *length && here > 0)
            y = short_step(g, y, next - here);
        else if (next != 0 && !followed(try_step(g, &at, next, &y)))
            return false;
        here = next;
        crossing_rate(g->surface, joint, rate);
        double du = joint->edge[0] - y[0], dv = joint->edge[1] - y[1];
        double cross = y[2] * rate[1] - y[3] * rate[0];
        double step = (du * rate[1] - dv * rate[0]) / cross;
        double along = (du * y[3] - dv * y[2]) / cross;
        if (!isfinite(step) || !crossing_move(g->surface, joint->t + along, joint))
            return false;
        next = fmax(here + step, 0);
        if (fabs(step) <= least || round == EVENT_ROUNDS - 1)
            break;
    }
    accept(g, y);
    *length = here;
    return true;
}

/* Over a joint: what the tangent has along the edge and across it stays. */
static bool cross_joint(struct path *g, const struct crossing *joint) {
    struct surface_jet jet;
    jet_here(g, g->uv, &jet);
    struct vec3 t = vec3_axpy(g->velocity[1], jet.v, vec3_scale(g->velocity[0], jet.u));
    double sides = g->surface->side * joint->beyond->side;
    g->surface = joint->beyond;
    if (g->kind == PATH_CURVE)
        g->kind = PATH_GEODESIC;
    g->plane = vec3_scale(sides, g->plane);
    return place(g, joint->entry, crossing_turn(joint, t));
}

/* A step as in one span, which ends on the joint that it meets; shorter ones first where that is
 * not found, as where the path all but touches it. */
static bool advance_on_face(struct path *g, double h, struct effort *effort, double *length) {
    struct path before = *g, beyond = *g;
    for (int round = 0; round < JOINT_ROUNDS; round++) {
        struct crossing joint;
        struct path there = before;
        *g = before;
        if (!advance_in_span(g, h, effort, length))
            return false;
        double way = *length;
        if (!find_joint(&before, g, *length, &joint, &way))
            return true;
        beyond = *g;
        if (meet_joint(&there, &joint, &way) && cross_joint(&there, &joint)) {
            *g = there;
            *length = way;
            return true;
        }
        h = *length / 2;
    }
    *g = beyond;
    return true;
}

/* Where a path ends beyond a joint that it has not met, it goes on from what is next to there. */
static bool settle(struct path *g) {
    struct surface_cursor cursor = {0, 0};
    struct crossing joint;
    struct station here;
    double uv[2];
    struct vec3 t;
    if (crossing_within(g->surface, g->uv))
        return true;
    (void)point_of(g, &t);
    if (!station_at(g->surface, &cursor, g->uv, &here))
        return true;
    crossing_find(&here, NULL, &joint);
    if (joint.kind != CROSSING_JOINT ||
        !crossing_carry(&joint, &cursor, &here, SETTLE_ROUNDS, uv) ||
        !crossing_within(joint.beyond, uv))
        return true;
    memcpy(joint.entry, uv, sizeof uv);
    return cross_joint(g, &joint);
}

/* The sum of the squares of the two principal curvatures: tr (I^-1 II)^2. */
static double squared_curvature(const struct surface_jet *jet) {
    struct vec3 across = vec3_cross(jet->u, jet->v);
    double e = vec3_norm2(jet->u), f = vec3_dot(jet->u, jet->v), g = vec3_norm2(jet->v);
    double area2 = vec3_norm2(across), l = vec3_dot(jet->uu, across);
    double m = vec3_dot(jet->uv, across), n = vec3_dot(jet->vv, across);
    double a = g * l - f * m, b = g * m - f * n, c = e * m - f * l, d = e * n - f * m;
    return (a * a + 2 * b * c + d * d) / (area2 * area2 * area2);
}

void path_follow_net(struct path *path, double d, int order) {
    if (!path->has_jet)
        jet_here(path, path->uv, &path->jet);
    path->has_jet = true;
    double bend = squared_curvature(&path->jet) * d * d;
    bool second = order == 2;
    double share = share_of_order[!second] * (second ? bend : bend * bend);
    path->accuracy = fmin(fmax(share, finest_of_order[!second]), coarsest);
}

/* Whether an advance makes so many steps that it leads nowhere. Towards a pole many are needed. */
static bool is_endless(const struct path *g, struct effort *effort) {
    int most = STEPS_MAX;
    if (is_outside(g))
        for (size_t k = sizeof outside_most / sizeof *outside_most; k > 0; k--)
            if (g->accuracy < outside_most[k - 1].accuracy)
                most = outside_most[k - 1].steps;
    return effort->steps++ >= most && !g->surface->has_poles;
}

/* Steps, the first with the number `round`, until `remaining` is gone. */
static bool go_on(struct path *path, double remaining, struct effort *effort, int round) {
    for (; round < rounds_max && remaining > 0 && !path->ended; round++) {
        if (far_outside(path) || is_endless(path, effort))
            return false;
        const struct surface *surface = path->surface;
        const int span[2] = {path->span[0], path->span[1]};
        struct vec3 pole;
        bool at_pole;
        double gone = 0, h = cap_step(path, remaining, &pole, &at_pole);
        if (at_pole && !pass_pole(path, pole))
            return false;
        if (path->ahead > 0)
            gone = path->ahead;
        else if (!(path->surface->shell ? advance_on_face : advance_in_span)(path, h, effort,
                                                                             &gone))
            return false;
        path->ahead = 0;
        remaining -= gone;
        if (path->surface != surface || path->span[0] != span[0] || path->span[1] != span[1])
            effort->steps = effort->failures = 0;
    }
    if (remaining < 0)
        path->ahead = -remaining;
    if (!path->has_jet)
        jet_here(path, path->uv, &path->jet);
    path->has_jet = true;
    return remaining <= 0 && !path->ended &&
           (!path->surface->shell || path->ahead > 0 || settle(path));
}

bool path_advance(struct path *path, double length) {
    struct effort effort = {.whole = length};
    double remaining = length - path->ahead;
    path->ahead = 0;
    return go_on(path, remaining, &effort, 0);
}

/* Whether nothing but a step in a span can be next. */
static bool steps_in_span(const struct path *g) {
    return g->ahead == 0 && !g->surface->has_poles && !far_outside(g);
}

bool path_advance_both(struct path path[2], const double length[2]) {
    struct attempt a[2];
    struct dormand_error error[2];
    struct dormand_task task[2];
    if (!steps_in_span(&path[0]) || !steps_in_span(&path[1]) || !(length[0] > 0 && length[1] > 0))
        return path_advance(&path[0], length[0]) && path_advance(&path[1], length[1]);
    for (int k = 0; k < 2; k++) {
        a[k] = plan_step(&path[k], length[k]);
        task[k] = (struct dormand_task){&path[k], a[k].h, a[k].at.state, &a[k].y, &error[k]};
    }
    dormand_two_steps(slope_at, task);
    for (int k = 0; k < 2; k++) {
        struct effort effort = {.whole = length[k]};
        double gone = 0, way;
        struct path before = path[k];
        struct crossing joint;
        a[k].y = with_given_velocity(&path[k], a[k].y);
        a[k].error = error_of_step(&path[k], &a[k].at, a[k].h, &error[k]);
        bool taken = take_step(&path[k], &a[k], &effort, &gone);
        if (before.surface->shell &&
            (!taken || find_joint(&before, &path[k], gone, &joint, &way))) {
            path[k] = before;
            if (!path_advance(&path[k], length[k]))
                return false;
            continue;
        }
        if (!taken || !go_on(&path[k], length[k] - gone, &effort, 1))
            return false;
    }
    return true;
}

/* Whether a step next to nothing that ends at y crosses a joint. */
static bool leaves_face(const struct path *g, vec4 y) {
    struct crossing joint;
    const double to[2] = {y[0], y[1]};
    double share;
    return crossing_on_way(g->surface, g->uv, to, &share, &joint);
}

/* Moves on by `length`, next to nothing and of either sign, within the span. False when that leads
 * out of it or round a corner. */
static bool nudge(struct path *g, double length) {
    struct event event;
    vec4 y = short_step(g, state_of(g), length);
    if (g->surface->shell && leaves_face(g, y))
        return false;
    if (g->ahead > 0 || first_event(g, y, &event))
        return false;
    accept(g, y);
    return true;
}

/* The length of the path with the chord d from here, to fourth order: with the curvature k of the
 * path in space, d (1 + (k d)^2 / 24). */
static double length_of_chord(const struct path *g, double d) {
    struct surface_jet jet;
    jet_here(g, g->uv, &jet);
    double p = g->velocity[0], q = g->velocity[1];
    vec4 slope = slope_of(g, &jet, state_of(g));
    struct vec3 bend =
        vec3_axpy(q * q, jet.vv, vec3_axpy(2 * p * q, jet.uv, vec3_scale(p * p, jet.uu)));
    if (g->kind == PATH_GEODESIC)
        bend = vec3_axpy(slope[3], jet.v, vec3_axpy(slope[2], jet.u, bend));
    else
        bend = vec3_make(0, 0, 0);
    return d * (1 + fmin(vec3_norm2(bend) * d * d / 24, 0.1));
}

bool path_advance_chord(struct path *path, struct surface_cursor *cursor, double d) {
    struct station from, to;
    struct vec3 tangent;
    struct path ahead = *path;
    if (!path_station(path, cursor, &from, NULL))
        return false;
    double length = length_of_chord(path, d), correction = HUGE_VAL;
    double enough = chord_tolerance * d + chord_rounding * path->surface->magnitude;
    const struct shell *shell = path->surface->shell;
    double jump = shell ? 2 * shell_edges(shell).largest_gap : 0;
    for (int round = 0; round < CHORD_ROUNDS; round++) {
        if (!(fabs(correction) <= nudge_share * d) || !nudge(&ahead, correction)) {
            ahead = *path;
            if (!path_advance(&ahead, length))
                return false;
        }
        if (!path_station(&ahead, cursor, &to, &tangent))
            return false;
        struct vec3 chord = vec3_sub(to.jet.r, from.jet.r);
        double size = vec3_norm(chord), rate = vec3_dot(chord, tangent) / size;
        if (fabs(size - d) <= enough || round == CHORD_ROUNDS - 1) {
            *path = ahead;
            return fabs(size - d) <= 1e3 * enough + jump;
        }
        if (!(rate > 0.1))
            return false;
        correction = (d - size) / rate;
        length += correction;
    }
    return false;
}
