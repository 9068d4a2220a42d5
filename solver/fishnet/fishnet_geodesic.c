/* SPDX-License-Identifier: MIT */
#include "fishnet_geodesic.h"

#include "fishnet_collocation.h"
#include "solver/shell/crossing.h"
#include "solver/shell/shell.h"
#include "unfolding.h"

enum { ROUNDS = 30, HALVINGS_MAX = 8, STALLS_MAX = 2 };

/* How far the two ends of geodesic edges may be apart, against the shorter length, and where
 * rounding hides it. */
static const double tolerance = 1e-11;

/* Local errors of rays against what their ends may be apart; of the first ones, which miss each
 * other anyway; and of the next, against how far the last ended apart. */
static const double ray_share = 0.1, first_accuracy = 1e-6, next_share = 0.1;
static const double finest_accuracy = 1e-12;

/* A last step that is wrong by less than this share of what ends may be apart is taken without
 * rays. */
static const double settled_share = 0.5;
static const double rounding = 4e-15;

/* Fields whose sine, squared, is less are parallel. */
static const double least_sine2 = 1e-12;

/* A geodesic of fixed length from a corner of the cell. */
struct ray {
    const struct surface_point *from;
    double length, accuracy; /* of each step's share of it */
    bool stays;              /* on its face's continuation */
    double reach;            /* as a path's */
    double error;            /* estimated, by its length */
    double moves;            /* its end, to the left, for each radian of its direction */
    struct vec3 direction;   /* at its start: unit, tangential */
    struct surface_point end;
    struct vec3 end_tangent; /* in the tangent plane there */
};

bool fishnet_pull_to(struct surface_cursor *cursor, const struct surface_point *from,
                     struct vec3 target, double enough, int pulls, struct surface_point *to) {
    for (int pull = 0; pull < pulls; pull++, from = to) {
        if (!surface_point_move(cursor, from, vec3_sub(target, from->jet.r), to))
            return false;
        struct vec3 left = surface_point_projection(to, vec3_sub(target, to->jet.r));
        if (vec3_norm2(left) < enough * enough)
            return true;
    }
    return false;
}

/* How the end moves for each radian of the direction about the normal. */
static struct vec3 jacobi_field(const struct ray *ray) {
    return vec3_scale(ray->moves, vec3_cross(ray->end.normal, ray->end_tangent));
}

static void turn_ray(struct ray *ray, double angle) {
    struct vec3 across = vec3_cross(ray->from->normal, ray->direction);
    ray->direction = vec3_unit(vec3_axpy(angle, across, ray->direction));
}

struct vec3 fishnet_path_tangent(const struct path *path, const struct surface_point *point,
                                 struct vec3 tangent) {
    struct unfolding_side here = unfolding_point(point);
    struct unfolding_side last = unfolding_path(path, point->jet.r);
    struct unfolding unfolding = unfolding_between(&here, &last);
    return surface_point_tangent(point, unfolding_back(&unfolding, tangent));
}

static bool aim_path(const struct ray *ray, struct path *path) {
    bool made = path_geodesic(path, ray->from->surface, ray->from, ray->direction);
    path->accuracy = ray->accuracy;
    path->stays = ray->stays;
    path->reach = ray->reach;
    path->carries = true;
    path->field[1] = 1;
    return made;
}

static bool end_ray(struct surface_cursor *cursor, const struct path *path, struct ray *ray) {
    struct vec3 tangent;
    if (!path_surface_point(path, cursor, &ray->end, &tangent))
        return false;
    ray->error = path->error / ray->length;
    ray->moves = path->field[0];
    ray->end_tangent = fishnet_path_tangent(path, &ray->end, tangent);
    return true;
}

/* ---- the cell ---- */

/* Cells whose rays have made this many steps are given up. Over fillets of a tenth of the spacing
 * they make a few hundred. */
enum { TRIED_MOST = 2000 };

/* Ends that come no nearer than to this share of the gap, so many rounds in a row, do not meet. */
static const double stalled_share = 0.95;

/* Gaps of more than so many estimated errors of their rays are none of these errors. */
static const double sure = 30;

/* Two rays, and what is between their ends: in the tangent plane of the first end, with how that
 * changes for each radian of either. */
struct meeting {
    struct ray ray[2];
    struct vec3 gap, by[2], end_tangent;
    bool stalled, astray; /* shorter steps and smaller angles do not help */
    bool *met;            /* as of yarns: a joint, each ray */
};

/* `tried` gathers the rays' steps. */
static bool shoot_both(struct surface_cursor *cursor, struct meeting *m, int *tried) {
    struct path path[2];
    const double length[2] = {m->ray[0].length, m->ray[1].length};
    if (*tried > TRIED_MOST || !aim_path(&m->ray[0], &path[0]) || !aim_path(&m->ray[1], &path[1]))
        return false;
    bool gone = path_advance_both(path, length);
    *tried += path[0].tried + path[1].tried;
    for (int k = 0; k < 2; k++)
        m->met[k] = m->met[k] || path[k].met;
    m->astray = path_is_astray(&path[0]) || path_is_astray(&path[1]);
    if (!gone || !end_ray(cursor, &path[0], &m->ray[0]) || !end_ray(cursor, &path[1], &m->ray[1]))
        return false;
    struct unfolding_side from = unfolding_point(&m->ray[0].end);
    struct unfolding_side to = unfolding_point(&m->ray[1].end);
    struct unfolding unfolding = unfolding_between(&from, &to);
    m->gap = unfolding_gap(&from, &to, &unfolding);
    m->by[0] = jacobi_field(&m->ray[0]);
    m->by[1] = unfolding_back(&unfolding, jacobi_field(&m->ray[1]));
    m->end_tangent = unfolding_back(&unfolding, m->ray[1].end_tangent);
    return true;
}

/* Whether the yarns cross at D as they do at A. */
static bool crosses_rightly(const struct fishnet_cell *cell, const struct meeting *m) {
    struct vec3 cross = vec3_cross(m->ray[0].end_tangent, m->end_tangent);
    return cell->orientation * vec3_dot(cross, m->ray[0].end.normal) > 0;
}

/* Whether D is on the right side: by chords, as of a smooth cell, or the yarns' own. */
static bool ends_rightly(const struct fishnet_cell *cell, bool chords, const struct meeting *m) {
    return chords ? fishnet_right_root(cell, &m->ray[0].end) : crosses_rightly(cell, m);
}

/* Whether the yarns cross the other way before and after a step, and so after a smaller one. */
static bool stay_crossed(const struct fishnet_cell *cell, const struct meeting *before,
                         const struct meeting *after) {
    return !crosses_rightly(cell, before) && !crosses_rightly(cell, after);
}

/* What a Newton step is wrong by, as a share of it: by the step itself, and by what the Jacobi
 * field leaves out, at least. */
static const double bent_step = 4, field_error = 3e-3;

static double left_of_step(double step, double slow) {
    return step * (bent_step * step + fmax(field_error, slow));
}

/* Rays on their way to each other. */
struct approach {
    double coarsest, finest;   /* what they are held to: at first, and in the end */
    double least, gap, enough; /* the shorter length; in it, how far they are apart and may be */
    double angle[2];           /* that are to close the gap, halved so often: */
    int halvings, stalls;
    double slow; /* the share of a gap that the last step left, beyond its own square */
};

/* Moves the end of the first ray by the angles' share of the gap, and turns both, where that is
 * exact enough and in one span: in place of two more rays. */
static bool settle_ends(struct surface_cursor *cursor, struct meeting *m,
                        const struct approach *to) {
    struct surface_point end;
    double step = fmax(fabs(to->angle[0]), fabs(to->angle[1]));
    struct ray *ray = m->ray;
    if (!(left_of_step(fmax(step, to->gap), to->slow) < settled_share * to->enough) ||
        ray[0].end.surface->has_poles ||
        !surface_point_move(cursor, &ray[0].end, vec3_scale(to->angle[0], m->by[0]), &end))
        return false;
    struct unfolding_side from = unfolding_point(&ray[0].end), here = unfolding_point(&end);
    if (end.surface->shell && !crossing_within(end.surface, end.uv))
        return false;
    if (from.span[0] != here.span[0] || from.span[1] != here.span[1])
        return false;
    struct vec3 normal = end.normal, *tangent[2] = {&ray[0].end_tangent, &m->end_tangent};
    for (int k = 0; k < 2; k++) {
        turn_ray(&ray[k], to->angle[k]);
        *tangent[k] = surface_point_tangent(
            &end, vec3_axpy(to->angle[k], vec3_cross(normal, *tangent[k]), *tangent[k]));
    }
    ray[0].end = end;
    return true;
}

/* What the next rays are held to: to the end where a step from theirs will settle it. */
static double next_accuracy(const struct approach *to) {
    double next = left_of_step(to->gap, to->slow);
    if (left_of_step(next, to->slow) < settled_share * to->enough)
        return to->finest;
    return fmax(to->finest, fmin(to->coarsest, next_share * next));
}

static double doubt_of(const struct meeting *m) {
    return sure * (m->ray[0].error + m->ray[1].error);
}

/* Both rays once more, as accurate as is asked for in the end. */
static bool shoot_finely(struct surface_cursor *cursor, struct approach *to, struct meeting *m,
                         int *tried) {
    m->ray[0].accuracy = m->ray[1].accuracy = to->finest;
    bool followed = shoot_both(cursor, m, tried);
    to->gap = vec3_norm(m->gap) / to->least;
    return followed;
}

/* What may help where the last angles left a gap of `missed`, infinite if rays could not be
 * followed: shorter steps of these rays, as the gap may have been their own error; smaller angles.
 * False when nothing does. */
static bool try_again(struct surface_cursor *cursor, struct approach *to, double missed,
                      struct meeting *m, int *tried) {
    bool followed = missed < HUGE_VAL;
    double doubt = doubt_of(m);
    if (m->ray[0].accuracy > to->finest && (!followed || fabs(missed - to->gap) <= doubt))
        return shoot_finely(cursor, to, m, tried);
    to->angle[0] /= 2;
    to->angle[1] /= 2;
    m->stalled = ++to->halvings == HALVINGS_MAX && followed && to->gap > doubt;
    return to->halvings < HALVINGS_MAX;
}

/* Takes the angles that led to `next`; false when the ends have come no nearer for long. */
static bool come_closer(struct approach *to, double closer, const struct meeting *next,
                        struct meeting *m) {
    bool certain = closer > doubt_of(m) + doubt_of(next);
    double step = fmax(fabs(to->angle[0]), fabs(to->angle[1]));
    *m = *next;
    to->slow = certain ? closer / to->gap - bent_step * step : 0;
    to->stalls = certain && closer > stalled_share * to->gap ? to->stalls + 1 : 0;
    to->halvings = 0;
    to->gap = closer;
    m->stalled = to->stalls == STALLS_MAX;
    return !m->stalled;
}

static bool are_fine(const struct meeting *m, const struct approach *to) {
    return m->ray[0].error + m->ray[1].error <= 2 * to->finest;
}

/* Shoots once more where rough rays end near enough to each other. False where fine ones cannot be
 * followed. */
static bool confirm_gap(struct surface_cursor *cursor, struct approach *to, struct meeting *m,
                        struct fishnet_node *node) {
    if (to->gap > to->enough || are_fine(m, to) || m->ray[0].accuracy <= to->finest)
        return true;
    if (!shoot_finely(cursor, to, m, &node->tried))
        return false;
    node->residual = to->gap;
    return true;
}

/* Shoots the next rays, by the angles. Where the yarns are nearly parallel, D is nearly a double
 * root: it is lost when the cell collapses, and close to that Newton may go to its twin on the side
 * of A. A step that does not reduce the gap or leaves the right side is therefore halved. False
 * when the ends come no nearer. */
static bool turn_both(struct surface_cursor *cursor, const struct fishnet_cell *cell, bool chords,
                      struct approach *to, struct meeting *m, struct fishnet_node *node) {
    struct meeting next = *m;
    for (int k = 0; k < 2; k++) {
        next.ray[k].accuracy = next_accuracy(to);
        turn_ray(&next.ray[k], to->angle[k]);
    }
    bool followed = shoot_both(cursor, &next, &node->tried);
    double closer = followed ? vec3_norm(next.gap) / to->least : HUGE_VAL;
    m->astray = next.astray;
    m->stalled = !chords && closer < to->gap && stay_crossed(cell, m, &next);
    if (m->astray || m->stalled)
        return false;
    return closer < to->gap && ends_rightly(cell, chords, &next)
               ? come_closer(to, closer, &next, m)
               : try_again(cursor, to, closer, m, &node->tried);
}

/* `chords` says whether the sides of chords are looked at for a right D, as for a smooth cell, or
 * the yarns' own. Rays are as accurate as it takes to come nearer: first rays[0], in the end
 * rays[1] of their length. */
static enum fishnet_end approach_by(const struct surface *surface, struct surface_cursor *cursor,
                                    const struct fishnet_cell *cell, double accuracy,
                                    const double rays[2], bool chords, struct meeting *m,
                                    struct fishnet_node *node) {
    struct approach to = {
        .coarsest = rays[0], .finest = rays[1], .least = fmin(m->ray[0].length, m->ray[1].length)};
    to.enough = accuracy + rounding * surface->magnitude / to.least;
    m->ray[0].accuracy = m->ray[1].accuracy = rays[0];
    node->residual = HUGE_VAL;
    if (!shoot_both(cursor, m, &node->tried))
        return FISHNET_NO_CONVERGENCE;
    to.gap = vec3_norm(m->gap) / to.least;
    bool going = true;
    for (int round = 0; round < ROUNDS && going; round++) {
        node->residual = to.gap;
        node->iterations++;
        if (!confirm_gap(cursor, &to, m, node))
            break;
        if (to.gap <= to.enough) {
            node->point = m->ray[0].end;
            return chords || crosses_rightly(cell, m) ? FISHNET_FOUND : FISHNET_COLLAPSED;
        }
        if (to.halvings == 0 &&
            !fishnet_close_gap(m->by[0], m->by[1], m->gap, least_sine2, to.angle))
            break;
        if (to.halvings == 0 && are_fine(m, &to) && settle_ends(cursor, m, &to)) {
            node->residual = settled_share * to.enough;
            node->point = m->ray[0].end;
            return ends_rightly(cell, chords, m) ? FISHNET_FOUND : FISHNET_COLLAPSED;
        }
        going = turn_both(cursor, cell, chords, &to, m, node);
    }
    return fishnet_has_collapsed(cell) ? FISHNET_COLLAPSED : FISHNET_NO_CONVERGENCE;
}

/* By how much geodesics jump where they cross gaps between the faces of a shell. */
static double jump_at_joints(const struct surface *surface) {
    return surface->shell ? 4 * shell_edges(surface->shell).largest_gap : 0;
}

/* Rays whose ends rough steps have not brought as near to each other as this, by their length, are
 * not kept apart by the errors of these steps. */
static const double rough_gap = 1e-4;

/* Roughly at first and, should that fail, once more with rays that are right from the start; not
 * where even rough ones cannot be followed, or come no nearer to each other, or one is led to where
 * the continuation is not trusted. Rays that jump over gaps may not come nearer than these. */
static enum fishnet_end meet_rays(const struct surface *surface, struct surface_cursor *cursor,
                                  const struct fishnet_cell *cell, double accuracy, double last,
                                  bool chords, struct meeting *m, struct fishnet_node *node) {
    struct meeting begun = *m;
    struct surface_point start = node->point;
    int before = node->iterations;
    const double roughly[2] = {fmax(first_accuracy, last), last};
    const double finest = fmax(finest_accuracy, last / 100), strictly[2] = {finest, finest};
    enum fishnet_end end = approach_by(surface, cursor, cell, accuracy, roughly, chords, m, node);
    if (end != FISHNET_NO_CONVERGENCE || node->iterations == before || m->astray)
        return end;
    if (!m->stalled && node->residual < rough_gap) {
        *m = begun;
        node->point = start;
        end = approach_by(surface, cursor, cell, accuracy, strictly, chords, m, node);
    }
    double jump = jump_at_joints(surface) / fmin(m->ray[0].length, m->ray[1].length);
    if (end != FISHNET_NO_CONVERGENCE || !(node->residual <= accuracy + jump))
        return end;
    node->point = m->ray[0].end;
    return ends_rightly(cell, chords, m) ? FISHNET_FOUND : FISHNET_COLLAPSED;
}

enum fishnet_end fishnet_geodesic_solve(const struct surface *surface,
                                        struct surface_cursor *cursor,
                                        const struct fishnet_cell *cell, const double length[2],
                                        int lanes, struct fishnet_node *node) {
    const struct fishnet_collocation wanted = {{length[0], length[1]}, tolerance, lanes};
    if (fishnet_collocation_solve(cursor, cell, &wanted, NULL, node))
        return fishnet_right_root(cell, &node->point) ? FISHNET_FOUND : FISHNET_COLLAPSED;
    node->tried = 0;
    bool met[2] = {false, false};
    struct meeting m = {
        .ray = {{.from = cell->b, .length = length[0]}, {.from = cell->c, .length = length[1]}},
        .met = met};
    for (int k = 0; k < 2; k++)
        m.ray[k].direction =
            surface_point_tangent(m.ray[k].from, vec3_sub(node->point.jet.r, m.ray[k].from->jet.r));
    return meet_rays(surface, cursor, cell, tolerance, ray_share * tolerance, true, &m, node);
}

enum fishnet_end fishnet_geodesic_meet(const struct surface *surface, struct surface_cursor *cursor,
                                       const struct fishnet_cell *cell, double bd, double cd,
                                       const double accuracy[2], struct fishnet_yarns *yarns,
                                       struct fishnet_node *node) {
    struct meeting m = {.ray = {{.from = cell->b, .length = bd, .direction = yarns->start[0]},
                                {.from = cell->c, .length = cd, .direction = yarns->start[1]}},
                        .met = yarns->met};
    for (int k = 0; k < 2; k++) {
        m.ray[k].stays = yarns->stays[k];
        m.ray[k].reach = yarns->reach;
    }
    node->iterations = 0;
    enum fishnet_end end =
        meet_rays(surface, cursor, cell, accuracy[0], accuracy[1], false, &m, node);
    for (int k = 0; k < 2 && end == FISHNET_FOUND; k++) {
        yarns->start[k] = m.ray[k].direction;
        yarns->end[k] = k ? m.end_tangent : m.ray[0].end_tangent;
    }
    return end;
}

bool fishnet_geodesic_between(const struct surface *surface, struct surface_cursor *cursor,
                              const struct surface_point *p, const struct surface_point *q,
                              double accuracy, double *length, struct vec3 *start,
                              struct vec3 *end) {
    struct ray ray = {
        .from = p, .length = *length, .accuracy = ray_share * accuracy, .direction = *start};
    struct unfolding_side to = unfolding_point(q);
    double enough = accuracy * *length + rounding * surface->magnitude, last = HUGE_VAL;
    for (int round = 0; round < ROUNDS; round++) {
        struct path path;
        if (!aim_path(&ray, &path) || !path_advance(&path, ray.length) ||
            !end_ray(cursor, &path, &ray))
            return false;
        struct unfolding_side from = unfolding_point(&ray.end);
        struct unfolding unfolding = unfolding_between(&from, &to);
        struct vec3 gap = unfolding_gap(&from, &to, &unfolding);
        double miss = vec3_norm(gap);
        struct vec3 field = jacobi_field(&ray);
        double angle = vec3_dot(gap, field) / vec3_norm2(field);
        bool found = miss <= enough;
        if (!found && ray.length * left_of_step(miss / ray.length, 0) < settled_share * enough) {
            struct vec3 normal = ray.end.normal;
            found = true;
            ray.length += vec3_dot(gap, ray.end_tangent);
            turn_ray(&ray, angle);
            ray.end_tangent =
                vec3_axpy(angle, vec3_cross(normal, ray.end_tangent), ray.end_tangent);
        }
        if (found || (!(miss < last) && miss <= enough + jump_at_joints(surface))) {
            /* As near in space may be the other side of a thin part. */
            if (unfolding.flat && vec3_dot(ray.end.normal, q->normal) < 0)
                return false;
            *length = ray.length;
            *start = ray.direction;
            struct unfolding back = unfolding_between(&to, &from);
            *end = surface_point_tangent(q, unfolding_back(&back, ray.end_tangent));
            return true;
        }
        if (!(miss < last))
            return false;
        turn_ray(&ray, angle);
        ray.length += vec3_dot(gap, ray.end_tangent);
        if (!(ray.length > 0))
            return false;
        last = miss;
    }
    return false;
}
