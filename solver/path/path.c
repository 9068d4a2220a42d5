/* SPDX-License-Identifier: MIT */
#include "path.h"

#include "path_event.h"
#include "path_joint.h"
#include "solver/shell/shell.h"

enum {
    CHORD_ROUNDS = 8,  /* Newton on the length to a chord */
    JOINT_ROUNDS = 8,  /* steps, each half of the last, to a joint */
    FAILURES_MAX = 40, /* steps of one advance in one span that were too long */
    STEPS_MAX = 200,   /* steps of one advance in one span */
    ASTRAY_MOST = 3,   /* steps that end where the continuation is not trusted */
};

/* Local error allowed, as a share of the step, unless the owner of the path says more. */
static const double accuracy = 1e-12;

/* With k the curvature of the surface and d the spacing, that of a net's own yarns: as a share of
 * (k d)^2 or (k d)^4, which the errors of a method of that order are a multiple of; and its limits.
 */
static const double share_of_order[2] = {1e-6, 1e-7}, finest_of_order[2] = {1e-9, 1e-11};
static const double coarsest_of_order[2] = {1e-5, 1e-7};

/* Steps shorter than this share of the whole are not tried: the line cannot be followed. */
static const double shortest = 1e-10;

/* A joint that is met within this share of a step is where the step begins. */
static const double at_joint = 1e-9;

/* Relative accuracy of a chord along a path; and what is left of it where polynomials cancel far
 * beyond the domain. */
static const double chord_tolerance = 1e-13, chord_rounding = 2e-15, chord_known = 1e-7;

/* Steps and crossings of one advance; far more than any line needs. */
static const int rounds_max = 4 * NURBS_SIZE_MAX;

/* Nearer to a pole than this share of the surface's size, the line goes straight through it: the
 * turn it misses is the square of this. */
static const double pole_radius = 1e-7;

bool path_surface_point(const struct path *path, struct surface_cursor *cursor,
                        struct surface_point *point, struct vec3 *tangent) {
    struct surface_jet jet;
    double uv[2] = {path->uv[0], path->uv[1]};
    if (path->has_jet)
        jet = path->jet;
    else
        path_jet(path, uv, &jet);
    struct vec3 t =
        vec3_unit(vec3_axpy(path->velocity[1], jet.v, vec3_scale(path->velocity[0], jet.u)));
    if (tangent)
        *tangent = t;
    bool regular, own_span = true;
    for (int k = 0; k < 2; k++) {
        const struct surface_axis *axis = &path->surface->axis[k];
        double at = surface_axis_wrap(axis, uv[k]);
        own_span = own_span && at == uv[k] - path->turn[k] &&
                   surface_axis_span(axis, path->span[k], at) == path->span[k];
    }
    if (own_span) {
        *point = (struct surface_point){.uv = {uv[0], uv[1]}, .jet = jet};
        regular = surface_point_complete(path->surface, point);
    } else {
        regular = surface_point_at(path->surface, cursor, uv, point);
    }
    if (!regular || !(path->ahead > 0))
        return regular;
    return surface_point_move(cursor, point, vec3_scale(-path->ahead, t), point);
}

/* Leaps straight on by `length`, which is next to nothing, through a pole. */
static bool leap(struct path *g, const struct surface_point *from, struct vec3 direction,
                 double length) {
    struct surface_cursor cursor = {0, 0};
    struct surface_place place;
    g->ahead += length;
    return surface_point_pull(&cursor, from, vec3_scale(length, direction), &place) &&
           path_enter(g, &place, direction);
}

bool path_geodesic(struct path *path, const struct surface *surface,
                   const struct surface_point *from, struct vec3 direction) {
    struct vec3 pole, tangent = surface_point_tangent(from, direction);
    *path = (struct path){.surface = surface, .accuracy = accuracy};
    if (!(vec3_norm2(tangent) > 0))
        return false;
    double radius = pole_radius * surface->size;
    if (surface_point_pole_distance(surface, from->jet.r, &pole) < radius)
        return leap(path, from, tangent, radius);
    return path_put(path, from->uv, tangent) && (!surface->shell || path_set_off(path));
}

bool path_steered(struct path *path, const struct surface *surface,
                  const struct surface_point *from, struct vec3 direction,
                  const struct drape_curvature *curvature, int sense) {
    if (!path_geodesic(path, surface, from, direction))
        return false;
    path->curvature = curvature_is_none(curvature) ? NULL : curvature;
    path->sense = sense;
    path->gone = path->ahead;
    return true;
}

bool path_section(struct path *path, const struct surface *surface,
                  const struct surface_point *from, struct vec3 plane, struct vec3 direction) {
    struct vec3 along = vec3_cross(plane, from->normal);
    if (!path_geodesic(path, surface, from,
                       vec3_dot(along, direction) < 0 ? vec3_scale(-1, along) : along))
        return false;
    path->kind = PATH_SECTION;
    path->plane = vec3_dot(along, direction) < 0 ? vec3_scale(-1, plane) : plane;
    return true;
}

bool path_curve(struct path *path, const struct surface *surface, const struct surface_point *from,
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
    return path_put(path, from->uv, direction);
}

/* Shortens a step to half the way to a pole that is near. Within a pole's radius and heading for
 * it, the path goes straight on to the mirrored point on the other side. */
static bool pass_poles(struct path *g, double *h) {
    struct surface_cursor cursor = {0, 0};
    struct surface_point here;
    struct vec3 pole, t;
    if (!g->surface->has_poles)
        return true;
    struct vec3 r = path_point(g, &t);
    double distance = surface_point_pole_distance(g->surface, r, &pole);
    *h = *h > distance / 2 ? distance / 2 : *h;
    if (!(distance <= pole_radius * g->surface->size))
        return true;
    double before = vec3_dot(vec3_sub(pole, r), t);
    if (before <= 0)
        return true;
    return g->kind != PATH_CURVE && surface_point_at(g->surface, &cursor, g->uv, &here) &&
           leap(g, &here, t, 2 * before);
}

/* Whether the path is more than a domain's length beyond an open boundary of a surface that a pole
 * closes: its lines meet there a second time, or fan out without an end. */
static bool past_pole(const struct path *g) {
    for (int k = 0; k < 2; k++) {
        const struct surface_axis *axis = &g->surface->axis[k], *other = &g->surface->axis[1 - k];
        double length = surface_axis_length(axis), low = surface_axis_lower(axis);
        if (!axis->closed && (other->pole[0] || other->pole[1]) &&
            fabs(g->uv[k] - low - length / 2) > 1.5 * length)
            return true;
    }
    return false;
}

/* Of one advance: steps that were too long and steps, since the last knot line, and the length. */
struct effort {
    int failures, steps;
    double whole;
};

/* A step that is about to be taken: how long it is, and where it then leads. */
struct attempt {
    struct path_footing at;
    double h;
    struct path_event knot; /* the knot line, if the step is to end there */
    bool at_knot;
    bool cut_short; /* it ends at a knot of the curvature */
    vec4 y;
    double error;
};

/* One of at most h that ends in this span or on a knot line. */
static struct attempt plan_step(const struct path *g, double h) {
    struct attempt a = {.at = path_footing_of(g)};
    h = fmin(h, g->pace > 0 ? g->pace : path_first_pace(g, &a.at));
    double bend =
        g->curvature ? curvature_to_knot(g->curvature, g->sense * g->gone, g->sense) : HUGE_VAL;
    a.cut_short = bend < h;
    h = fmin(h, bend);
    double knot = path_length_to_knot(g, &a.at, &a.knot);
    a.at_knot = knot <= h;
    a.h = a.at_knot ? knot : h;
    return a;
}

/* Notes how wrong the change of the velocity is where polynomials cancel far beyond the domain: a
 * shorter step's error has not fallen there with the cube of its length, as it does with the eighth
 * power. Steps that get shorter and shorter would end the path. */
static void note_noise(struct path *g, struct attempt *a, const struct attempt *longer) {
    double inside[2], share = a->h / longer->h;
    double error = a->error * path_allowed_error(g, &a->at, a->h);
    double before = longer->error * path_allowed_error(g, &a->at, longer->h);
    if (!(error > share * share * share * before) || !path_clamp(g, inside))
        return;
    g->noise = fmax(g->noise, 2 * error / (a->h * a->h));
    a->error = error / path_allowed_error(g, &a->at, a->h);
}

/* Takes a step that has been tried, or a shorter one as long as that is worth trying; the length it
 * went. */
static bool take_step(struct path *g, struct attempt *a, struct effort *effort, double *length) {
    struct path_event event;
    g->tried++;
    while (!path_followed(a->error)) {
        const struct attempt longer = *a;
        a->h *= fmin(path_rescaling(a->error), 0.85);
        a->at_knot = a->cut_short = false;
        bool many = ++effort->failures > FAILURES_MAX && !g->surface->has_poles;
        if (many || !(a->h > shortest * effort->whole))
            return false;
        g->tried++;
        a->error = path_try_step(g, &a->at, a->h, &a->y);
        note_noise(g, a, &longer);
    }
    double pace = a->h * path_rescaling(a->error);
    g->error += a->error * path_allowed_error(g, &a->at, a->h);
    g->pace = (a->at_knot || a->cut_short) && g->pace > 0 ? fmax(g->pace, pace) : pace;
    *length = a->h;
    if (a->at_knot && g->kind != PATH_CURVE && path_touch_knot(g, &a->knot, &a->y, length))
        return true;
    if (path_first_event(g, &a->y, &event))
        return path_advance_to(g, &event, a->h, &a->y, length);
    path_accept(g, &a->y);
    return true;
}

/* One step of at most h that ends in this span or on a knot line; the length it went. */
static bool advance_in_span(struct path *g, double h, struct effort *effort, double *length) {
    struct attempt a = plan_step(g, h);
    a.error = path_try_step(g, &a.at, a.h, &a.y);
    return take_step(g, &a, effort, length);
}

/* A step as in one span, which ends on the joint that it meets; shorter ones first where that is
 * not found, as where the path all but touches it. A path that meets a joint where it is and leads
 * away from it has come over it, all but along it, and leaves the face again within the step. */
static bool advance_on_face(struct path *g, double h, struct effort *effort, double *length) {
    struct path before = *g, beyond = *g;
    for (int round = 0; round < JOINT_ROUNDS; round++) {
        struct crossing joint;
        struct path there = before;
        *g = before;
        if (!advance_in_span(g, h, effort, length))
            return false;
        double way = *length;
        if (g->stays || !path_find_joint(&before, g, *length, &joint, &way))
            return true;
        g->met = before.met = there.met = true;
        beyond = *g;
        struct vec3 t;
        (void)path_point(&before, &t);
        bool entered = way <= at_joint * *length && vec3_dot(t, joint.from.across) < 0;
        if (!entered && path_pass_joint(&there, &joint, &way)) {
            *g = there;
            *length = way;
            return true;
        }
        h = *length / 2;
    }
    *g = beyond;
    return true;
}

void path_follow_net(struct path *path, double d, int order) {
    if (!path->has_jet)
        path_jet(path, path->uv, &path->jet);
    path->has_jet = true;
    const struct surface_jet *jet = &path->jet;
    struct tangent_basis i = tangent_basis_of(jet->u, jet->v);
    struct vec3 across = vec3_cross(jet->u, jet->v);
    double area2 = vec3_norm2(across), l = vec3_dot(jet->uu, across);
    double m = vec3_dot(jet->uv, across), n = vec3_dot(jet->vv, across);
    /* the sum of the squares of the two principal curvatures, tr (I^-1 II)^2 */
    double a = i.g * l - i.f * m, b = i.g * m - i.f * n, c = i.e * m - i.f * l;
    double k = i.e * n - i.f * m;
    double bend = (a * a + 2 * b * c + k * k) / (area2 * area2 * area2) * d * d;
    bool second = order == 2;
    double share = share_of_order[!second] * (second ? bend : bend * bend);
    path->accuracy = fmin(fmax(share, finest_of_order[!second]), coarsest_of_order[!second]);
}

bool path_is_astray(const struct path *path) {
    return path->astray > ASTRAY_MOST;
}

/* Counts the steps that end beyond the boundary where the continuation is not trusted, for the path
 * is lost after a few. */
static bool goes_astray(struct path *path) {
    struct surface_cursor cursor = {0, 0};
    struct surface_point here;
    double inside[2];
    if (path->reach == 0 || path->stays || !path_clamp(path, inside))
        return false;
    if (!path->has_jet)
        path_jet(path, path->uv, &path->jet);
    path->has_jet = true;
    path->astray += !path_surface_point(path, &cursor, &here, NULL) ||
                    !surface_point_is_trusted(&here, &cursor, path->reach);
    return path_is_astray(path);
}

/* Notes that the path has gone so far from where it was before. */
static void note_way(struct path *path, const struct path *before, double gone) {
    if (path->carries && gone > 0)
        path_carry_field(before, gone, path);
    path->gone += gone;
}

/* Steps, the first with the number `round`, until `remaining` is gone, or so many that the advance
 * leads nowhere. Towards a pole many are needed, and each may be tried more than once. */
static bool go_on(struct path *path, double remaining, struct effort *effort, int round) {
    for (; round < rounds_max && remaining > 0 && !path->ended; round++) {
        double gone = 0, h = remaining;
        if ((round > 0 && goes_astray(path)) || past_pole(path) ||
            (effort->steps++ >= STEPS_MAX && !path->surface->has_poles))
            return false;
        const struct surface *surface = path->surface;
        const int span[2] = {path->span[0], path->span[1]};
        struct path before = *path;
        if (!pass_poles(path, &h))
            return false;
        if (path->ahead > 0)
            gone = path->ahead;
        else if (!(path->surface->shell ? advance_on_face : advance_in_span)(path, h, effort,
                                                                             &gone))
            return false;
        path->ahead = 0;
        note_way(path, &before, gone);
        remaining -= gone;
        if (path->surface != surface || path->span[0] != span[0] || path->span[1] != span[1])
            effort->steps = effort->failures = 0;
    }
    if (remaining < 0)
        path->ahead = -remaining;
    if (!path->has_jet)
        path_jet(path, path->uv, &path->jet);
    path->has_jet = true;
    return remaining <= 0 && !path->ended &&
           (!path->surface->shell || path->ahead > 0 || path->stays || path_settle(path));
}

bool path_advance(struct path *path, double length) {
    struct effort effort = {.whole = length};
    double remaining = length - path->ahead;
    path->ahead = 0;
    return go_on(path, remaining, &effort, 0);
}

/* Whether nothing but a step of order 8 in a span can be next. */
static bool steps_in_span(const struct path *g) {
    return g->ahead == 0 && !g->surface->has_poles && !path_is_rough(g);
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
    dormand_two_steps(path_slope, task);
    for (int k = 0; k < 2; k++) {
        struct effort effort = {.whole = length[k]};
        double gone = 0, way;
        struct path before = path[k];
        struct crossing joint;
        path_redirect(&path[k], &a[k].y);
        a[k].error = path_error_of_step(&path[k], &a[k].at, a[k].h, &error[k]);
        bool taken = take_step(&path[k], &a[k], &effort, &gone);
        if (before.surface->shell &&
            (!taken || (!before.stays && path_find_joint(&before, &path[k], gone, &joint, &way)))) {
            path[k] = before;
            if (!path_advance(&path[k], length[k]))
                return false;
            continue;
        }
        note_way(&path[k], &before, gone);
        if (!taken || !go_on(&path[k], length[k] - gone, &effort, 1))
            return false;
    }
    return true;
}

/* Moves on by `length`, next to nothing and of either sign, within the span. False when that leads
 * out of it or round a corner. */
static bool nudge(struct path *g, double length) {
    struct path_event event;
    struct path_footing at = path_footing_of(g);
    struct crossing_exit exit;
    vec4 y;
    if (!path_parabola(g, &at, length, &y)) {
        y = at.state[0];
        path_short_step(g, 0, length, &y);
    }
    const double uv[2] = {y[0], y[1]};
    if (g->surface->shell && crossing_leaves(g->surface, g->uv, uv, &exit))
        return false;
    if (g->ahead > 0 || path_first_event(g, &y, &event))
        return false;
    path_accept(g, &y);
    g->gone += length;
    return true;
}

bool path_advance_chord(struct path *path, struct surface_cursor *cursor, double d) {
    struct surface_point from, to;
    struct vec3 tangent;
    struct path ahead = *path;
    if (!path_surface_point(path, cursor, &from, NULL))
        return false;
    /* The length with the chord d, to fourth order: with the curvature k of the path in space,
     * d (1 + (k d)^2 / 24). */
    struct path_footing at = path_footing_of(path);
    struct vec3 bend = vec3_make(0, 0, 0);
    if (path->kind == PATH_GEODESIC)
        bend = vec3_axpy(at.state[1][3], at.jet.v,
                         vec3_axpy(at.state[1][2], at.jet.u, jet_bend(&at.jet, path->velocity)));
    double length = d * (1 + fmin(vec3_norm2(bend) * d * d / 24, 0.1)), correction = HUGE_VAL;
    double enough = chord_tolerance * d + chord_rounding * path->surface->magnitude;
    const struct shell *shell = path->surface->shell;
    double jump = shell ? 2 * shell_edges(shell).largest_gap : 0;
    for (int round = 0; round < CHORD_ROUNDS; round++) {
        if (!(fabs(correction) <= path_nudge_share * d) || !nudge(&ahead, correction)) {
            ahead = *path;
            if (!path_advance(&ahead, length)) {
                *path = ahead;
                return false;
            }
        }
        if (!path_surface_point(&ahead, cursor, &to, &tangent))
            return false;
        struct vec3 chord = vec3_sub(to.jet.r, from.jet.r);
        double size = vec3_norm(chord), rate = vec3_dot(chord, tangent) / size;
        if (fabs(size - d) <= enough || round == CHORD_ROUNDS - 1) {
            *path = ahead;
            return fabs(size - d) <= chord_known * d + jump;
        }
        if (!(rate > 0.1))
            return false;
        correction = (d - size) / rate;
        length += correction;
    }
    return false;
}
