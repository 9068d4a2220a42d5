/* SPDX-License-Identifier: MIT */
#include "path_joint.h"

#include "path_step.h"
#include "solver/shell/shell.h"
#include <string.h>

enum {
    SETTLE_ROUNDS = 3, /* to the point beyond a joint that was missed */
    JOINT_PIECES = 4,  /* straight ones, in which joints are looked for along a step */
};

/* Straight lines between points of the cubic through (u, v) and velocity at both ends of the step.
 */
bool path_find_joint(const struct path *from, const struct path *to, double h,
                     struct crossing *joint, double *length) {
    double at[JOINT_PIECES + 1][2], low[2], high[2], share;
    for (int k = 0; k <= JOINT_PIECES; k++) {
        double s = (double)k / JOINT_PIECES, r = 1 - s;
        for (int x = 0; x < 2; x++) {
            at[k][x] = r * r * (1 + 2 * s) * from->uv[x] + s * s * (1 + 2 * r) * to->uv[x] +
                       h * s * r * (r * from->velocity[x] - s * to->velocity[x]);
            low[x] = k == 0 || at[k][x] < low[x] ? at[k][x] : low[x];
            high[x] = k == 0 || at[k][x] > high[x] ? at[k][x] : high[x];
        }
    }
    if (crossing_all_within(from->surface, low, high))
        return false;
    for (int k = 0; k < JOINT_PIECES; k++)
        if (crossing_on_way(from->surface, at[k], at[k + 1], &share, joint)) {
            *length = h * (k + share) / JOINT_PIECES;
            return true;
        }
    return false;
}

/* A path that passes an edge by more than this share of its way does not meet it: the joint
 * may lie past a vertex, on the next edge. */
static const double missed_share = 1e-6;

/* Over a joint: what the tangent has along the edge and across it stays. */
static bool cross_joint(struct path *g, const struct crossing *joint) {
    struct surface_jet jet;
    g->met = true;
    path_jet(g, g->uv, &jet);
    struct vec3 t = vec3_axpy(g->velocity[1], jet.v, vec3_scale(g->velocity[0], jet.u));
    const struct surface_place entry = {joint->beyond, {joint->entry[0], joint->entry[1]}};
    return path_enter(g, &entry, crossing_turn(joint, t));
}

/* Newton's method for the length and the edge's parameter. */
bool path_pass_joint(struct path *g, struct crossing *joint, double *length) {
    struct path_footing at = path_footing_of(g);
    vec4 y = at.state[0];
    double here = 0, next = *length, least = 1e-15 * g->surface->size;
    for (int round = 0; round < PATH_ROUNDS; round++) {
        if (fabs(next - here) <= path_nudge_share * *length && here > 0)
            path_short_step(g, here, next - here, &y);
        else if (next != 0 && !path_followed(path_try_step(g, &at, next, &y)))
            return false;
        here = next;
        const double rate[2] = {joint->rate[0], joint->rate[1]};
        double du = joint->edge[0] - y[0], dv = joint->edge[1] - y[1];
        double cross = y[2] * rate[1] - y[3] * rate[0];
        double step = (du * rate[1] - dv * rate[0]) / cross;
        double along = (du * y[3] - dv * y[2]) / cross;
        if (!isfinite(step) || !crossing_move(g->surface, joint->t + along, joint))
            return false;
        next = fmax(here + step, 0);
        if (fabs(step) <= least || round == PATH_ROUNDS - 1)
            break;
    }
    path_accept(g, &y);
    *length = here;
    struct vec3 t, r = path_point(g, &t);
    return vec3_distance(r, joint->from.at) <=
               missed_share * here + shell_joint_width(g->surface->shell) &&
           cross_joint(g, joint);
}

/* The face beyond the joint that a path is outside its own face at: where it is there, which is
 * joint->entry. False where it is inside, or there is none. */
static bool find_next_face(const struct path *g, struct crossing *joint, struct surface_point *here,
                           struct surface_point *there) {
    struct surface_cursor cursor = {0, 0};
    struct surface_place place;
    if (crossing_within(g->surface, g->uv) || !surface_point_at(g->surface, &cursor, g->uv, here))
        return false;
    crossing_find(here, NULL, joint);
    if (joint->kind != CROSSING_JOINT ||
        !crossing_carry(joint, &cursor, here, SETTLE_ROUNDS, &place) ||
        !surface_point_at(place.surface, &cursor, place.uv, there))
        return false;
    joint->beyond = place.surface;
    memcpy(joint->entry, place.uv, sizeof place.uv);
    return true;
}

bool path_set_off(struct path *g) {
    struct crossing joint;
    struct surface_point here, there;
    struct vec3 t;
    if (!find_next_face(g, &joint, &here, &there))
        return true;
    (void)path_point(g, &t);
    if (!(vec3_dot(t, joint.from.across) > 0) ||
        !(vec3_distance(here.jet.r, there.jet.r) <= shell_joint_width(g->surface->shell)))
        return true;
    return cross_joint(g, &joint);
}

bool path_settle(struct path *g) {
    struct crossing joint, next;
    struct surface_point here, there;
    if (!find_next_face(g, &joint, &here, &there))
        return true;
    crossing_find(&there, g->surface, &next);
    if (next.kind == CROSSING_JOINT ||
        (next.kind == CROSSING_FREE && joint.at_corner && !joint.continued))
        return true;
    return cross_joint(g, &joint);
}
