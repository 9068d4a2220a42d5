/* SPDX-License-Identifier: MIT */
#include "path_step.h"

#include "solver/wide.h"

/* Rounding in the sums of one step, as a share of the surface's coordinates. */
static const double rounding = 4e-15;

/* Beyond the domain rounding may be this share of a step. */
static const double noise_most = 1e-6;

/* A step is next to nothing where it leaves out this share of what its velocity may be wrong by. */
static const double parabola_share = 1e-2;

/* The first step of a path, as a share of the length over which its velocity changes, by the eighth
 * root of its accuracy. */
static const double first_pace = 11;

/* A Jacobi field turns by no more than this in a step, as the square of an angle: the series do not
 * reach further. */
static const double field_turn = 4;

bool path_head_for(const struct surface_jet *jet, struct vec3 t, double velocity[2]) {
    struct surface_point point = {
        .jet = *jet, .first = {vec3_norm2(jet->u), vec3_dot(jet->u, jet->v), vec3_norm2(jet->v)}};
    if (!surface_point_components(&point, t, velocity))
        return false;
    double speed = vec3_norm(vec3_axpy(velocity[1], jet->v, vec3_scale(velocity[0], jet->u)));
    velocity[0] /= speed;
    velocity[1] /= speed;
    return speed > 0;
}

void path_jet(const struct path *g, const double uv[2], struct surface_jet *jet) {
    surface_evaluate_span(g->surface, g->span[0], g->span[1], uv[0] - g->turn[0],
                          uv[1] - g->turn[1], jet);
}

void path_given_velocity(const struct path *g, const double uv[2], const struct surface_jet *jet,
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

/* What steering adds to the change of the velocity (p, q) `s` further on: the curvature there times
 * the unit tangent turned to the left, n x (r_u p + r_v q) = (-(F p + G q), E p + F q) / |r_u x
 * r_v| in parameters. */
static vec4 steered_change(const struct path *g, const struct tangent_basis *basis, double s,
                           double p, double q) {
    double k = g->sense * curvature_at(g->curvature, g->sense * (g->gone + s));
    k *= g->surface->side * sqrt(basis->inverse);
    return (vec4){0, 0, -k * (basis->f * p + basis->g * q), k * (basis->e * p + basis->f * q)};
}

/* The slope of the state y, `s` further on than the path, where the jet is that of (u, v). */
static vec4 slope_of(const struct path *g, const struct surface_jet *jet, double s, vec4 y) {
    double given[2], change[2], uv[2] = {y[0], y[1]}, p = y[2], q = y[3];
    if (g->kind != PATH_GEODESIC) {
        path_given_velocity(g, uv, jet, given);
        return (vec4){given[0], given[1], 0, 0};
    }
    struct tangent_basis basis = tangent_basis_of(jet->u, jet->v);
    tangent_components(&basis, jet_bend(jet, (const double[2]){p, q}), change);
    vec4 straight = {p, q, -change[0], -change[1]};
    return g->curvature ? straight + steered_change(g, &basis, s, p, q) : straight;
}

WIDE_CLONES
void path_slope(const void *context, double s, const vec4 *y, vec4 *slope) {
    const struct path *g = context;
    struct surface_jet jet;
    double uv[2] = {(*y)[0], (*y)[1]};
    path_jet(g, uv, &jet);
    *slope = slope_of(g, &jet, s, *y);
}

void path_redirect(const struct path *g, vec4 *y) {
    vec4 slope;
    if (g->kind == PATH_GEODESIC)
        return;
    path_slope(g, 0, y, &slope);
    *y = (vec4){(*y)[0], (*y)[1], slope[0], slope[1]};
}

bool path_clamp(const struct path *g, double uv[2]) {
    bool outside = false;
    for (int k = 0; k < 2; k++) {
        const struct surface_axis *axis = &g->surface->axis[k];
        double low = surface_axis_lower(axis), high = surface_axis_upper(axis);
        uv[k] = axis->closed ? g->uv[k] : fmin(fmax(g->uv[k], low), high);
        outside = outside || uv[k] != g->uv[k];
    }
    return outside;
}

/* The distance in space that a difference of states makes over the step h. */
static double spatial_size(const struct surface_jet *jet, vec4 difference, double h) {
    double nu = vec3_norm(jet->u), nv = vec3_norm(jet->v);
    return nu * fabs(difference[0]) + nv * fabs(difference[1]) +
           h * (nu * fabs(difference[2]) + nv * fabs(difference[3]));
}

struct path_footing path_footing_of(const struct path *g) {
    struct path_footing at = {.state = {{g->uv[0], g->uv[1], g->velocity[0], g->velocity[1]}}};
    if (g->has_jet)
        at.jet = g->jet;
    else
        path_jet(g, g->uv, &at.jet);
    at.state[1] = slope_of(g, &at.jet, 0, at.state[0]);
    return at;
}

double path_allowed_error(const struct path *g, const struct path_footing *at, double h) {
    double inside[2],
        error = g->accuracy * h + rounding * (g->surface->size + vec3_norm(at->jet.r));
    bool noisy = g->noise > 0 && path_clamp(g, inside);
    return noisy ? error + fmin(g->noise * h, noise_most) * h : error;
}

/* The length over which the velocity in parameters turns or changes by much. */
static double length_of_change(const struct path_footing *at) {
    vec4 slope = at->state[1];
    struct vec3 change = vec3_axpy(slope[3], at->jet.v, vec3_scale(slope[2], at->jet.u));
    return 1 / vec3_norm(change);
}

double path_first_pace(const struct path *g, const struct path_footing *at) {
    return first_pace * sqrt(sqrt(sqrt(g->accuracy))) * length_of_change(at);
}

double path_error_of_step(const struct path *g, const struct path_footing *at, double h,
                          const struct dormand_error *error) {
    double fifth = spatial_size(&at->jet, error->fifth, h);
    double third = spatial_size(&at->jet, error->third, h);
    double size = sqrt(fifth * fifth + 0.01 * third * third);
    return (size > 0 ? fifth * fifth / size : size) / path_allowed_error(g, at, h);
}

double path_try_step(const struct path *g, const struct path_footing *at, double h, vec4 *out) {
    struct dormand_error error;
    (path_is_rough(g) ? dormand_rough_step : dormand_step)(path_slope, g, h, at->state, out,
                                                           &error);
    path_redirect(g, out);
    return path_error_of_step(g, at, h, &error);
}

static double gauss_curvature_of(const struct surface_jet *jet) {
    struct vec3 across = vec3_cross(jet->u, jet->v);
    double area2 = vec3_norm2(across), m = vec3_dot(jet->uv, across);
    return (vec3_dot(jet->uu, across) * vec3_dot(jet->vv, across) - m * m) / (area2 * area2);
}

/* y'' = -K y with the K of the middle of the step, by the series of cosine and sine of sqrt(K) h.
 */
void path_carry_field(const struct path *from, double h, struct path *to) {
    const bool over_joint = from->surface != to->surface;
    struct surface_jet jet;
    double uv[2];
    for (int k = 0; k < 2; k++)
        uv[k] = over_joint
                    ? from->uv[k] + h / 2 * from->velocity[k]
                    : (from->uv[k] + to->uv[k]) / 2 + h / 8 * (from->velocity[k] - to->velocity[k]);
    path_jet(from, uv, &jet);
    double x = gauss_curvature_of(&jet) * h * h;
    x = isfinite(x) ? fmin(fmax(x, -field_turn), field_turn) : 0;
    double cosine = 1 - x / 2 * (1 - x / 12 * (1 - x / 30));
    double sine = 1 - x / 6 * (1 - x / 20 * (1 - x / 42));
    const double moves = from->field[0], rate = h * from->field[1];
    to->field[0] = cosine * moves + sine * rate;
    to->field[1] = (cosine * rate - x * sine * moves) / h;
}

bool path_parabola(const struct path *g, const struct path_footing *at, double h, vec4 *y) {
    double share = h / length_of_change(at);
    const vec4 slope = at->state[1], bend = {slope[2], slope[3], 0, 0};
    *y = at->state[0] + h * (slope + h / 2 * bend);
    return g->kind == PATH_GEODESIC && share * share < parabola_share * g->accuracy;
}

void path_short_step(const struct path *g, double s, double h, vec4 *y) {
    vec4 k[4], at;
    path_slope(g, s, y, &k[0]);
    at = *y + h / 2 * k[0];
    path_slope(g, s + h / 2, &at, &k[1]);
    at = *y + h / 2 * k[1];
    path_slope(g, s + h / 2, &at, &k[2]);
    at = *y + h * k[2];
    path_slope(g, s + h, &at, &k[3]);
    *y += h / 6 * (k[0] + 2 * k[1] + 2 * k[2] + k[3]);
    path_redirect(g, y);
}

void path_accept(struct path *g, const vec4 *y) {
    g->has_jet = false;
    g->uv[0] = (*y)[0];
    g->uv[1] = (*y)[1];
    g->velocity[0] = (*y)[2];
    g->velocity[1] = (*y)[3];
}

struct vec3 path_point(const struct path *g, struct vec3 *tangent) {
    struct surface_jet jet;
    path_jet(g, g->uv, &jet);
    *tangent = vec3_unit(vec3_axpy(g->velocity[1], jet.v, vec3_scale(g->velocity[0], jet.u)));
    return jet.r;
}

bool path_put(struct path *g, const double uv[2], struct vec3 direction) {
    for (int k = 0; k < 2; k++) {
        const struct surface_axis *axis = &g->surface->axis[k];
        double wrapped = surface_axis_wrap(axis, uv[k]);
        g->uv[k] = uv[k];
        g->turn[k] = uv[k] - wrapped;
        g->span[k] = surface_axis_span(axis, 0, wrapped);
    }
    path_jet(g, g->uv, &g->jet);
    g->has_jet = true;
    return path_head_for(&g->jet, direction, g->velocity);
}

bool path_enter(struct path *g, const struct surface_place *place, struct vec3 direction) {
    if (place->surface != g->surface && g->kind == PATH_CURVE)
        g->kind = PATH_GEODESIC;
    g->plane = vec3_scale(g->surface->side * place->surface->side, g->plane);
    g->surface = place->surface;
    g->noise = 0;
    return path_put(g, place->uv, direction);
}
