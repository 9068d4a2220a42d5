/* SPDX-License-Identifier: MIT */
#include "fishnet_geodesic.h"

#include "fishnet_collocation.h"
#include "solver/shell/crossing.h"
#include "solver/shell/shell.h"

enum { ROUNDS = 30, HALVINGS_MAX = 8 };

/* How far the two ends of geodesic edges may be apart, against the shorter length, and where
 * rounding hides it. */
static const double tolerance = 1e-11;

/* Local errors of rays against what their ends may be apart; of the first ones, which miss each
 * other anyway; and of the next, against how far the last ended apart. */
static const double ray_share = 0.1, first_accuracy = 1e-7, next_share = 1e-4;
static const double finest_accuracy = 1e-12;

/* A last step that is wrong by less than this share of what ends may be apart is taken without
 * rays. */
static const double settled_share = 0.5;
static const double rounding = 4e-15;

/* A geodesic of fixed length from a corner of the cell. */
struct ray {
    const struct station *from;
    double length, accuracy; /* of each step's share of it */
    double error;            /* estimated, by its length */
    struct vec3 direction;   /* at its start: unit, tangential */
    struct station end;
    struct vec3 end_tangent; /* in the tangent plane there */
};

/* How the end moves for each radian of the direction about the normal. */
static struct vec3 jacobi_field(const struct ray *ray) {
    double d = ray->length;
    double k = (station_gauss_curvature(ray->from) + station_gauss_curvature(&ray->end)) / 2;
    double size = d * (1 - fmin(k * d * d / 6, 0.5));
    return vec3_scale(size, vec3_cross(ray->end.normal, ray->end_tangent));
}

static void turn(struct ray *ray, double angle) {
    struct vec3 across = vec3_cross(ray->from->normal, ray->direction);
    ray->direction = vec3_unit(vec3_axpy(angle, across, ray->direction));
}

/* The angles for which x b - y c = gap, in the least-squares sense of the tangent plane. */
static bool solve_angles(struct vec3 b, struct vec3 c, struct vec3 gap, double *x, double *y) {
    struct vec3 normal = vec3_cross(b, c);
    double area2 = vec3_norm2(normal);
    if (!(area2 > 1e-12 * vec3_norm2(b) * vec3_norm2(c)))
        return false;
    *x = vec3_dot(vec3_cross(gap, c), normal) / area2;
    *y = vec3_dot(vec3_cross(gap, b), normal) / area2;
    return true;
}

/* ---- two sides of a knot line ---- */

/* A place in a span, as that span has it. */
struct side {
    const struct surface *surface;
    int span[2];
    double turn[2]; /* what to take off uv to be in its domain */
    double uv[2];
    struct vec3 r;
    const struct station *station; /* NULL of a path */
};

/* An edge of two spans unfolded: orthonormal frames of both sides (along the edge, across it within
 * the surface, normal), and a point of the edge; `flat` when there is nothing to unfold. */
struct unfolding {
    bool flat;
    struct vec3 at, from[3], to[3];
};

static void frame_at(const struct surface *surface, const struct side *side, int k,
                     const double uv[2], struct vec3 frame[3], struct vec3 *at) {
    struct surface_jet jet;
    surface_evaluate_span(surface, side->span[0], side->span[1], uv[0] - side->turn[0],
                          uv[1] - side->turn[1], &jet);
    frame[0] = vec3_unit(k == 0 ? jet.v : jet.u);
    frame[2] = vec3_unit(vec3_cross(jet.u, jet.v));
    frame[1] = vec3_cross(frame[2], frame[0]);
    *at = jet.r;
}

/* Two places on both sides of a joint of a shell. */
static struct unfolding unfold_joint(const struct side *from, const struct side *to) {
    struct crossing c;
    if (!from->station || !to->station || !crossing_between(from->station, to->surface, &c))
        return (struct unfolding){.flat = true};
    return (struct unfolding){.at = c.from.at,
                              .from = {c.from.along, c.from.across, c.from.normal},
                              .to = {c.to.along, c.to.across, c.to.normal}};
}

/* Where the line in (u, v) from one place to the other crosses the one knot between them. More than
 * one are taken as none: Newton's method comes nearer, or has to do without. */
static struct unfolding unfold(const struct side *from, const struct side *to) {
    struct unfolding unfolding = {.flat = true};
    const struct surface *surface = from->surface;
    int across = -1, differ = 0;
    if (to->surface != surface)
        return unfold_joint(from, to);
    for (int k = 0; k < 2; k++)
        if (from->span[k] != to->span[k]) {
            across = k;
            differ++;
        }
    if (differ != 1)
        return unfolding;
    const struct surface_axis *axis = &surface->axis[across];
    int a = from->span[across], b = to->span[across], last = axis->span_count - 1;
    bool up = b == a + 1 || (axis->closed && a == last && b == 0 && last > 1);
    bool down = b == a - 1 || (axis->closed && a == 0 && b == last && last > 1);
    if (!up && !down)
        return unfolding;
    double knot = axis->breaks[a + up] + from->turn[across], uv[2];
    double share = (knot - from->uv[across]) / (to->uv[across] - from->uv[across]);
    share = share >= 0 && share <= 1 ? share : 0.5;
    uv[across] = knot;
    uv[1 - across] = from->uv[1 - across] + share * (to->uv[1 - across] - from->uv[1 - across]);
    struct vec3 other;
    frame_at(surface, from, across, uv, unfolding.from, &unfolding.at);
    frame_at(surface, to, across, uv, unfolding.to, &other);
    unfolding.flat = false;
    return unfolding;
}

/* A vector at the far side as it is on the near one. */
static struct vec3 carry_back(const struct unfolding *unfolding, struct vec3 v) {
    struct vec3 sum = vec3_make(0, 0, 0);
    if (unfolding->flat)
        return v;
    for (int k = 0; k < 3; k++)
        sum = vec3_axpy(vec3_dot(v, unfolding->to[k]), unfolding->from[k], sum);
    return sum;
}

static struct side side_of_path(const struct path *path, struct vec3 r) {
    return (struct side){.surface = path->surface,
                         .span = {path->span[0], path->span[1]},
                         .turn = {path->turn[0], path->turn[1]},
                         .uv = {path->uv[0], path->uv[1]},
                         .r = r};
}

static struct side side_of_station(const struct station *station) {
    const struct surface *surface = station->surface;
    struct side side = {.surface = surface,
                        .uv = {station->uv[0], station->uv[1]},
                        .r = station->jet.r,
                        .station = station};
    for (int k = 0; k < 2; k++) {
        double wrapped = surface_axis_wrap(&surface->axis[k], station->uv[k]);
        side.turn[k] = station->uv[k] - wrapped;
        side.span[k] = surface_axis_span(&surface->axis[k], 0, wrapped);
    }
    return side;
}

/* The way from one place to a near one, in the tangent plane of the first. */
static struct vec3 gap_between(const struct side *from, const struct side *to,
                               const struct unfolding *unfolding) {
    if (unfolding->flat)
        return vec3_sub(to->r, from->r);
    struct vec3 beyond = carry_back(unfolding, vec3_sub(to->r, unfolding->at));
    return vec3_add(vec3_sub(unfolding->at, from->r), beyond);
}

struct vec3 fishnet_path_tangent(const struct path *path, const struct station *station,
                                 struct vec3 tangent) {
    struct side here = side_of_station(station);
    struct side last = side_of_path(path, station->jet.r);
    struct unfolding unfolding = unfold(&here, &last);
    return station_tangent(station, carry_back(&unfolding, tangent));
}

static bool aim_path(const struct ray *ray, struct path *path) {
    bool made = path_geodesic(path, ray->from->surface, ray->from, ray->direction);
    path->accuracy = ray->accuracy;
    return made;
}

static bool end_ray(struct surface_cursor *cursor, const struct path *path, struct ray *ray) {
    struct vec3 tangent;
    if (!path_station(path, cursor, &ray->end, &tangent))
        return false;
    ray->error = path->error / ray->length;
    ray->end_tangent = fishnet_path_tangent(path, &ray->end, tangent);
    return true;
}

static bool shoot(struct surface_cursor *cursor, struct ray *ray) {
    struct path path;
    return aim_path(ray, &path) && path_advance(&path, ray->length) && end_ray(cursor, &path, ray);
}

/* ---- the cell ---- */

/* How accurate rays are from now on. */
static void aim(struct ray ray[2], double accuracy) {
    ray[0].accuracy = ray[1].accuracy = accuracy;
}

/* Two rays, and what is between their ends: in the tangent plane of the first end, with how that
 * changes for each radian of either. */
struct meeting {
    struct ray ray[2];
    struct vec3 gap, by[2], end_tangent;
};

static bool shoot_both(struct surface_cursor *cursor, struct meeting *m) {
    struct path path[2];
    const double length[2] = {m->ray[0].length, m->ray[1].length};
    if (!aim_path(&m->ray[0], &path[0]) || !aim_path(&m->ray[1], &path[1]) ||
        !path_advance_both(path, length) || !end_ray(cursor, &path[0], &m->ray[0]) ||
        !end_ray(cursor, &path[1], &m->ray[1]))
        return false;
    struct side from = side_of_station(&m->ray[0].end);
    struct side to = side_of_station(&m->ray[1].end);
    struct unfolding unfolding = unfold(&from, &to);
    m->gap = gap_between(&from, &to, &unfolding);
    m->by[0] = jacobi_field(&m->ray[0]);
    m->by[1] = carry_back(&unfolding, jacobi_field(&m->ray[1]));
    m->end_tangent = carry_back(&unfolding, m->ray[1].end_tangent);
    return true;
}

/* Whether the yarns cross at D as they do at A. */
static bool crosses_rightly(const struct fishnet_cell *cell, const struct meeting *m) {
    struct vec3 cross = vec3_cross(m->ray[0].end_tangent, m->end_tangent);
    return cell->orientation * vec3_dot(cross, m->ray[0].end.normal) > 0;
}

/* What a Newton step is wrong by, as a share of it: by the step itself, and by what the Jacobi
 * field leaves out, where curvature changes and where there is much of it. */
static double step_error(const struct ray *ray, double step) {
    double d2 = ray->length * ray->length, k = station_gauss_curvature(ray->from) * d2;
    double end = station_gauss_curvature(&ray->end) * d2, mean = (k + end) / 2;
    return 4 * step + fabs(end - k) / 20 + mean * mean / 60;
}

/* Moves the end of the first ray by the angles' share of the gap, and turns both, where that is
 * exact enough and in one span: in place of two more rays. */
static bool settle(struct surface_cursor *cursor, struct meeting *m, double x, double y, double gap,
                   double enough) {
    double uv[2], step = fmax(fabs(x), fabs(y));
    struct ray *ray = m->ray;
    double wrong = fmax(step_error(&ray[0], step), step_error(&ray[1], step));
    if (!(fmax(step, gap) * wrong < settled_share * enough) || ray[0].end.surface->has_poles ||
        !station_pull(ray[0].end.surface, cursor, &ray[0].end, vec3_scale(x, m->by[0]), uv))
        return false;
    struct station end;
    if (!station_at(ray[0].end.surface, cursor, uv, &end))
        return false;
    struct side from = side_of_station(&ray[0].end), to = side_of_station(&end);
    if (end.surface->shell && !crossing_within(end.surface, end.uv))
        return false;
    if (from.span[0] != to.span[0] || from.span[1] != to.span[1])
        return false;
    struct vec3 normal = end.normal, *tangent[2] = {&ray[0].end_tangent, &m->end_tangent};
    const double angle[2] = {x, y};
    for (int k = 0; k < 2; k++) {
        turn(&ray[k], angle[k]);
        *tangent[k] = station_tangent(
            &end, vec3_axpy(angle[k], vec3_cross(normal, *tangent[k]), *tangent[k]));
    }
    ray[0].end = end;
    return true;
}

/* Where the yarns are nearly parallel, D is nearly a double root: it is lost when the cell
 * collapses, and close to that Newton may go to its twin on the side of A. A step that does not
 * reduce the gap or leaves the right side is therefore halved. `chords` tells whether the sides of
 * chords are looked at for that, as for a smooth cell, or the yarns' own. Rays are as accurate as
 * it takes to come nearer: first rays[0], in the end rays[1] of their length. */
static enum fishnet_end meet_by(const struct surface *surface, struct surface_cursor *cursor,
                                const struct fishnet_cell *cell, double accuracy,
                                const double rays[2], bool chords, struct meeting *m,
                                struct fishnet_node *node) {
    double least = fmin(m->ray[0].length, m->ray[1].length), x = 0, y = 0;
    double enough = accuracy + rounding * surface->magnitude / least;
    aim(m->ray, rays[0]);
    if (!shoot_both(cursor, m))
        return FISHNET_NO_CONVERGENCE;
    double gap = vec3_norm(m->gap) / least;
    for (int round = 0, halvings = 0; round < ROUNDS && halvings < HALVINGS_MAX; round++) {
        struct meeting next = *m;
        node->residual = gap;
        node->iterations++;
        if (gap <= enough && !(m->ray[0].error + m->ray[1].error <= 2 * rays[1]) &&
            m->ray[0].accuracy > rays[1]) {
            aim(m->ray, rays[1]);
            if (!shoot_both(cursor, m))
                break;
            gap = node->residual = vec3_norm(m->gap) / least;
            next = *m;
        }
        if (gap <= enough) {
            node->station = m->ray[0].end;
            return chords || crosses_rightly(cell, m) ? FISHNET_FOUND : FISHNET_COLLAPSED;
        }
        if (halvings == 0 && !solve_angles(m->by[0], m->by[1], m->gap, &x, &y))
            break;
        if (halvings == 0 && m->ray[0].error + m->ray[1].error <= 2 * rays[1] &&
            settle(cursor, m, x, y, gap, enough)) {
            node->residual = settled_share * enough;
            node->station = m->ray[0].end;
            bool right =
                chords ? fishnet_right_root(cell, &node->station) : crosses_rightly(cell, m);
            return right ? FISHNET_FOUND : FISHNET_COLLAPSED;
        }
        double closer = HUGE_VAL;
        aim(next.ray, fmax(rays[1], fmin(rays[0], next_share * gap)));
        turn(&next.ray[0], x);
        turn(&next.ray[1], y);
        if (shoot_both(cursor, &next))
            closer = vec3_norm(next.gap) / least;
        if (closer < gap &&
            (chords ? fishnet_right_root(cell, &next.ray[0].end) : crosses_rightly(cell, &next))) {
            *m = next;
            gap = closer;
            halvings = 0;
        } else if (m->ray[0].accuracy > rays[1]) {
            aim(m->ray, rays[1]); /* the gap may have been the rays' own error */
            if (!shoot_both(cursor, m))
                break;
            gap = vec3_norm(m->gap) / least;
        } else {
            x /= 2;
            y /= 2;
            halvings++;
        }
    }
    return fishnet_has_collapsed(cell) ? FISHNET_COLLAPSED : FISHNET_NO_CONVERGENCE;
}

/* By how much geodesics jump where they cross gaps between the faces of a shell. */
static double jump_at_joints(const struct surface *surface) {
    return surface->shell ? 4 * shell_edges(surface->shell).largest_gap : 0;
}

/* Roughly at first and, should that fail, once more with rays that are right from the start; not
 * where even rough ones cannot be followed. */
static enum fishnet_end meet(const struct surface *surface, struct surface_cursor *cursor,
                             const struct fishnet_cell *cell, double accuracy, double last,
                             bool chords, struct meeting *m, struct fishnet_node *node) {
    struct meeting begun = *m;
    struct station start = node->station;
    int before = node->iterations;
    const double roughly[2] = {fmax(first_accuracy, last), last};
    const double finest = fmax(finest_accuracy, last / 100), strictly[2] = {finest, finest};
    enum fishnet_end end = meet_by(surface, cursor, cell, accuracy, roughly, chords, m, node);
    if (end != FISHNET_NO_CONVERGENCE || node->iterations == before)
        return end;
    *m = begun;
    node->station = start;
    end = meet_by(surface, cursor, cell, accuracy, strictly, chords, m, node);
    double jump = jump_at_joints(surface) / fmin(m->ray[0].length, m->ray[1].length);
    if (end != FISHNET_NO_CONVERGENCE || !(node->residual <= accuracy + jump))
        return end;
    *m = begun;
    node->station = start;
    return meet_by(surface, cursor, cell, accuracy + jump, strictly, chords, m, node);
}

enum fishnet_end fishnet_geodesic_solve(const struct surface *surface,
                                        struct surface_cursor *cursor,
                                        const struct fishnet_cell *cell, const double length[2],
                                        int lanes, struct fishnet_node *node) {
    const struct fishnet_collocation wanted = {{length[0], length[1]}, tolerance, lanes};
    if (fishnet_collocation_solve(cursor, cell, &wanted, NULL, node))
        return fishnet_right_root(cell, &node->station) ? FISHNET_FOUND : FISHNET_COLLAPSED;
    struct meeting m = {
        .ray = {{.from = cell->b, .length = length[0]}, {.from = cell->c, .length = length[1]}}};
    for (int k = 0; k < 2; k++)
        m.ray[k].direction =
            station_tangent(m.ray[k].from, vec3_sub(node->station.jet.r, m.ray[k].from->jet.r));
    return meet(surface, cursor, cell, tolerance, ray_share * tolerance, true, &m, node);
}

enum fishnet_end fishnet_geodesic_meet(const struct surface *surface, struct surface_cursor *cursor,
                                       const struct fishnet_cell *cell, double bd, double cd,
                                       const double accuracy[2], struct fishnet_yarns *yarns,
                                       struct fishnet_node *node) {
    struct meeting m = {.ray = {{.from = cell->b, .length = bd, .direction = yarns->start[0]},
                                {.from = cell->c, .length = cd, .direction = yarns->start[1]}}};
    node->iterations = 0;
    enum fishnet_end end = meet(surface, cursor, cell, accuracy[0], accuracy[1], false, &m, node);
    for (int k = 0; k < 2 && end == FISHNET_FOUND; k++) {
        yarns->start[k] = m.ray[k].direction;
        yarns->end[k] = k ? m.end_tangent : m.ray[0].end_tangent;
    }
    return end;
}

bool fishnet_geodesic_between(const struct surface *surface, struct surface_cursor *cursor,
                              const struct station *p, const struct station *q, double accuracy,
                              double *length, struct vec3 *start, struct vec3 *end) {
    struct ray ray = {
        .from = p, .length = *length, .accuracy = ray_share * accuracy, .direction = *start};
    struct side to = side_of_station(q);
    double enough = accuracy * *length + rounding * surface->magnitude, last = HUGE_VAL;
    for (int round = 0; round < ROUNDS; round++) {
        if (!shoot(cursor, &ray))
            return false;
        struct side from = side_of_station(&ray.end);
        struct unfolding unfolding = unfold(&from, &to);
        struct vec3 gap = gap_between(&from, &to, &unfolding);
        double miss = vec3_norm(gap);
        struct vec3 field = jacobi_field(&ray);
        double angle = vec3_dot(gap, field) / vec3_norm2(field);
        bool found = miss <= enough;
        if (!found && miss * step_error(&ray, miss / ray.length) < settled_share * enough) {
            struct vec3 normal = ray.end.normal;
            found = true;
            ray.length += vec3_dot(gap, ray.end_tangent);
            turn(&ray, angle);
            ray.end_tangent =
                vec3_axpy(angle, vec3_cross(normal, ray.end_tangent), ray.end_tangent);
        }
        if (found || (!(miss < last) && miss <= enough + jump_at_joints(surface))) {
            /* As near in space may be the other side of a thin part. */
            if (unfolding.flat && vec3_dot(ray.end.normal, q->normal) < 0)
                return false;
            *length = ray.length;
            *start = ray.direction;
            struct unfolding back = unfold(&to, &from);
            *end = station_tangent(q, carry_back(&back, ray.end_tangent));
            return true;
        }
        if (!(miss < last))
            return false;
        turn(&ray, angle);
        ray.length += vec3_dot(gap, ray.end_tangent);
        last = miss;
    }
    return false;
}
