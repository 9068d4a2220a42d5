/* SPDX-License-Identifier: MIT */
#include "path.h"
#include <stdint.h>

#include <string.h>

enum {
    STATE = 4,        /* u, v, p, q */
    LEVELS = 8,       /* columns of the extrapolation: order 16 */
    EVENT_ROUNDS = 30 /* Newton on the length to a span's edge */
};

/* Local error allowed, as a share of the step. */
static const double tolerance = 1e-14;

/* Rounding in the sums of one step, as a share of the surface's coordinates; and the error, as a
 * share of the step, below which no further fall from level to level means that only rounding is
 * left. */
static const double rounding = 4e-15;
static const double rounding_at_most = 1e-10;

/* Steps shorter than this share of the whole are not tried: the line cannot be followed. */
static const double shortest = 1e-12;

/* Steps and crossings of one advance; a line has no more in earnest. */
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
static void given_velocity(const struct path *g, const struct surface_jet *jet,
                           double velocity[2]) {
    double a = g->line[0], b = g->line[1];
    if (g->kind == PATH_SECTION) {
        a = vec3_dot(g->plane, jet->v);
        b = -vec3_dot(g->plane, jet->u);
    }
    double speed = vec3_norm(vec3_axpy(b, jet->v, vec3_scale(a, jet->u)));
    velocity[0] = a / speed;
    velocity[1] = b / speed;
}

/* y' of the equations at the top of path.h. */
static void derivative(const struct path *g, const double y[STATE], double dy[STATE]) {
    struct surface_jet jet;
    jet_here(g, y, &jet);
    dy[2] = dy[3] = 0;
    if (g->kind != PATH_GEODESIC) {
        given_velocity(g, &jet, dy);
        return;
    }
    double p = y[2], q = y[3];
    struct vec3 a = vec3_scale(p * p, jet.uu);
    a = vec3_axpy(2 * p * q, jet.uv, a);
    a = vec3_axpy(q * q, jet.vv, a);
    double e = vec3_norm2(jet.u), f = vec3_dot(jet.u, jet.v), h = vec3_norm2(jet.v);
    double au = vec3_dot(a, jet.u), av = vec3_dot(a, jet.v);
    double inverse = 1 / (e * h - f * f);
    dy[0] = p;
    dy[1] = q;
    dy[2] = -(h * au - f * av) * inverse;
    dy[3] = -(e * av - f * au) * inverse;
}

/* Gragg's modified midpoint rule with n substeps: its error is a series in (h/n)^2. */
static void midpoint_rule(const struct path *g, const double y[STATE], const double slope[STATE],
                          double h, int n, double out[STATE]) {
    double before[STATE], now[STATE], dy[STATE], step = h / n;
    for (int k = 0; k < STATE; k++) {
        before[k] = y[k];
        now[k] = y[k] + step * slope[k];
    }
    for (int m = 1; m < n; m++) {
        derivative(g, now, dy);
        for (int k = 0; k < STATE; k++) {
            double next = before[k] + 2 * step * dy[k];
            before[k] = now[k];
            now[k] = next;
        }
    }
    derivative(g, now, dy);
    for (int k = 0; k < STATE; k++)
        out[k] = (now[k] + before[k] + step * dy[k]) / 2;
}

/* The distance in space that a difference of two states makes over the step h. */
static double spatial_error(const struct surface_jet *jet, const double a[STATE],
                            const double b[STATE], double h) {
    double nu = vec3_norm(jet->u), nv = vec3_norm(jet->v);
    return nu * fabs(a[0] - b[0]) + nv * fabs(a[1] - b[1]) +
           h * (nu * fabs(a[2] - b[2]) + nv * fabs(a[3] - b[3]));
}

/* One step by extrapolation of the midpoint rule with 2, 4, 6, .. substeps to h -> 0
 * (Bulirsch-Stoer). False when it has not converged at the last level. */
static bool extrapolated_step(const struct path *g, double h, double out[STATE]) {
    double y[STATE] = {g->uv[0], g->uv[1], g->velocity[0], g->velocity[1]}, slope[STATE];
    double table[LEVELS][STATE], previous = HUGE_VAL;
    struct surface_jet jet;
    jet_here(g, g->uv, &jet);
    double allowed = tolerance * h + rounding * (g->surface->size + vec3_norm(jet.r));
    derivative(g, y, slope);
    for (int level = 0; level < LEVELS; level++) {
        double best[STATE];
        for (int k = 0; k < STATE; k++)
            best[k] = level ? table[0][k] : 0;
        midpoint_rule(g, y, slope, h, 2 * (level + 1), table[level]);
        for (int m = level - 1; m >= 0; m--) {
            double ratio = (double)(level + 1) / (m + 1), weight = 1 / (ratio * ratio - 1);
            for (int k = 0; k < STATE; k++)
                table[m][k] = table[m + 1][k] + weight * (table[m + 1][k] - table[m][k]);
        }
        double error = spatial_error(&jet, best, table[0], h);
        bool stalled = error >= previous && error <= rounding_at_most * h;
        if (level >= 2 && (error <= allowed || stalled)) {
            double last[STATE];
            for (int k = 0; k < STATE; k++)
                out[k] = table[0][k];
            if (g->kind != PATH_GEODESIC) {
                derivative(g, out, last);
                out[2] = last[0];
                out[3] = last[1];
            }
            return true;
        }
        previous = error;
    }
    return false;
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

/* Moves into the next span of direction k. The tangent keeps its components along the common edge
 * and across it: the two tangent planes are unfolded about the edge. */
static bool cross_edge(struct path *g, int k, double edge) {
    const struct surface_axis *axis = &g->surface->axis[k];
    struct surface_jet from, to;
    g->uv[k] = edge;
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
        given_velocity(g, &to, g->velocity);
        return isfinite(g->velocity[0]) && isfinite(g->velocity[1]);
    }
    struct vec3 along = vec3_unit(k == 0 ? from.v : from.u);
    struct vec3 side_from = k == 0 ? from.u : from.v, side_to = k == 0 ? to.u : to.v;
    side_from = vec3_unit(vec3_axpy(-vec3_dot(side_from, along), along, side_from));
    side_to = vec3_unit(vec3_axpy(-vec3_dot(side_to, along), along, side_to));
    struct vec3 t = vec3_axpy(g->velocity[1], from.v, vec3_scale(g->velocity[0], from.u));
    struct vec3 turned =
        vec3_axpy(vec3_dot(t, side_from), side_to, vec3_scale(vec3_dot(t, along), along));
    return set_velocity(&to, turned, g->velocity);
}

static void accept(struct path *g, const double y[STATE]) {
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
        given_velocity(g, &jet, velocity);
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
    double y[STATE];
    for (int round = 0; round < EVENT_ROUNDS; round++, h /= 2)
        if (extrapolated_step(g, h, y) && event->sign * (event->at - y[event->k]) > 0) {
            accept(g, y);
            *length = h;
            return true;
        }
    return false;
}

/* The length to the event, at most h: Newton on uv[k](length) = at, kept between 0 and h by
 * bisection, and the state there. False when the step to there is too long to be followed; `length`
 * then is one that was too long. */
static bool find_event(const struct path *g, const struct event *event, double h, double y[STATE],
                       double *length) {
    int k = event->k;
    double low = 0, high = h, next = h / 2;
    double slack = 1e-14 * fabs(surface_axis_upper(&g->surface->axis[k]) -
                                surface_axis_lower(&g->surface->axis[k]));
    for (int round = 0; round < EVENT_ROUNDS; round++) {
        *length = next;
        if (!extrapolated_step(g, *length, y))
            return false;
        double miss = event->sign * (event->at - y[k]);
        if (fabs(miss) <= slack)
            break;
        *(miss > 0 ? &low : &high) = *length;
        next = *length + miss / (event->sign * y[2 + k]);
        if (!(next > low && next < high))
            next = (low + high) / 2;
    }
    return true;
}

/* Whether the state y lies beyond an edge of the direction other than k, and that edge. */
static bool crosses_other(const struct path *g, int k, const double y[STATE], struct event *event) {
    double edge, beyond = beyond_span(g, 1 - k, y[1 - k], &edge);
    *event = (struct event){1 - k, edge, y[1 - k] > edge ? 1 : -1, false};
    return beyond > 0;
}

/* Moves to the event, at most h away, and past it; next to a corner of the span to that edge which
 * comes first. Less far when the step to there is too long to be followed. */
static bool advance_to_event(struct path *g, const struct event *first, double h, double *length) {
    struct event event = *first, other;
    double y[STATE];
    *length = 0;
    if (event.sign * (event.at - g->uv[event.k]) <= 0)
        return pass_event(g, &event);
    if (!find_event(g, &event, h, y, length))
        return advance_towards(g, &event, *length / 2, length);
    if (crosses_other(g, event.k, y, &other)) {
        event = other;
        if (!find_event(g, &event, *length, y, length))
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

bool path_station(const struct path *path, struct surface_cursor *cursor, struct station *station,
                  struct vec3 *tangent) {
    struct vec3 t;
    double uv[2];
    (void)point_of(path, &t);
    if (tangent)
        *tangent = t;
    if (!station_at(path->surface, cursor, path->uv, station))
        return false;
    if (!(path->ahead > 0))
        return true;
    return station_pull(path->surface, cursor, station, vec3_scale(-path->ahead, t), uv) &&
           station_at(path->surface, cursor, uv, station);
}

/* Puts the path at uv, in the span there, heading along the projection of `direction`. */
static bool place(struct path *g, const double uv[2], struct vec3 direction) {
    struct surface_jet jet;
    for (int k = 0; k < 2; k++) {
        const struct surface_axis *axis = &g->surface->axis[k];
        double wrapped = surface_axis_wrap(axis, uv[k]);
        g->uv[k] = uv[k];
        g->turn[k] = uv[k] - wrapped;
        g->span[k] = surface_axis_span(axis, 0, wrapped);
    }
    jet_here(g, g->uv, &jet);
    return set_velocity(&jet, direction, g->velocity);
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
    *path = (struct path){.surface = surface};
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
                          .kind = PATH_CURVE,
                          .curve = curve,
                          .curve_count = count,
                          .next = next,
                          .sense = sense};
    struct vec3 direction;
    for (int k = 0; k < 2; k++)
        path->line[k] = curve[next][k] - from->uv[k];
    direction = vec3_axpy(path->line[1], from->jet.v, vec3_scale(path->line[0], from->jet.u));
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
    double distance = station_pole_distance(g->surface, point_of(g, &t), pole);
    *at_pole = distance <= pole_radius * g->surface->size;
    return h > distance / 2 ? distance / 2 : h;
}

/* The event that a step from here to y runs into first, by the share of the step that lies beyond
 * it; false when there is none. */
static bool first_event(const struct path *g, const double y[STATE], struct event *event) {
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
        double to = g->curve[g->next][k], beyond = (y[k] - to) / (y[k] - g->uv[k]);
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

/* One step of at most h that ends in this span or on its edge; the length it went. */
static bool advance_in_span(struct path *g, double h, double least, double *length) {
    double y[STATE];
    struct event event;
    while (!extrapolated_step(g, h, y)) {
        h /= 2;
        if (!(h > least))
            return false;
    }
    if (first_event(g, y, &event))
        return advance_to_event(g, &event, h, length);
    accept(g, y);
    *length = h;
    return true;
}

bool path_advance(struct path *path, double length) {
    double remaining = length - path->ahead;
    path->ahead = 0;
    for (int round = 0; round < rounds_max && remaining > 0; round++) {
        if (far_outside(path))
            return false;
        struct vec3 pole;
        bool at_pole;
        double gone = 0, h = cap_step(path, remaining, &pole, &at_pole);
        if (at_pole && !pass_pole(path, pole))
            return false;
        if (path->ahead > 0)
            gone = path->ahead;
        else if (!advance_in_span(path, h, shortest * length, &gone))
            return false;
        path->ahead = 0;
        remaining -= gone;
    }
    if (remaining < 0)
        path->ahead = -remaining;
    return remaining <= 0;
}
