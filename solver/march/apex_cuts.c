/* SPDX-License-Identifier: MIT */
/*
 * A part may come to a point: a pole without a tangent plane, as a cone's apex. With T the angle of
 * all directions there, T < 360 degrees, unrolled about its apex a cone is a sector of T. Yarns
 * that pass the apex on its left and on its right come round it to the ray that lies T / 2 from the
 * start either way, and fit nowhere beyond it: there the cloth is cut, as that of tubes is
 * (`march_cut.c`), from the part's edge to the apex.
 *
 * What is missing about the apex may be given back further out, as by the brim of a pointed hat.
 * With J the distance of two rays from the apex by the angle between them there, of the ring of
 * rays 360 degrees - T dJ/ds is missing at a distance s, by Gauss-Bonnet as the part is even all
 * round.
 */
#include "cuts.h"

#include "solver/angle.h"
#include "solver/path/path.h"
#include "solver/shell/shell.h"

/* Cloth passes an apex where no more is missing, there or at the edge, in degrees: it shears by up
 * to about that beyond it. Past cones that lack 40 nets do not all come together any more. */
static const double passed_most = 36;

/* The apex is looked at on a ring round it this large, in spacings, in so many steps for half a
 * turn of a plane; a step that goes on by less than this share of itself is at an edge. */
static const double ring_radius = 0.05, goes_on = 0.5;
enum { RING_STEPS = 48 };

/* Poles whose normals turn by less than this, in degrees, have a tangent plane; so many are looked
 * at. */
static const double even_turn = 0.05;
enum { NORMALS = 4 };

/* The ray is followed in steps of this, in spacings, for so many sizes of the part, and found to
 * end within a share of a step. */
static const double ray_step = 0.5, ray_longest = 4, ray_end = 1e-9;

/* Rays are compared at these shares of the way to the edge. */
static const double compared_at[2] = {0.9, 0.95};

struct apex {
    struct march *march;
    struct vec3 at;
    double spacing, radius;      /* of the ring */
    struct surface_point across; /* the place of it half way round from the start */
    double angle;                /* of all directions, T */
};

static struct vec3 ray_of(const struct apex *apex, const struct surface_point *place) {
    return vec3_unit(vec3_sub(place->jet.r, apex->at));
}

static double degrees_between(struct vec3 a, struct vec3 b) {
    return angle_atan2_deg(vec3_norm(vec3_cross(a, b)), vec3_dot(a, b));
}

static bool is_on_march(struct march *march, const struct surface_point *place) {
    enum drape_reason reason;
    return march_zone(march, place, false, &reason) == SURFACE_POINT_INSIDE;
}

/* The place of the ring next to `r`, from one near it; false where there is none. */
static bool find_on_ring(const struct apex *apex, const struct surface_point *near, struct vec3 r,
                         struct surface_point *place) {
    enum { ROUNDS = 3 };
    struct surface_point from = *near;
    double distance;
    for (int round = 0; round < ROUNDS; round++, from = *place) {
        r = vec3_axpy(apex->radius, vec3_unit(vec3_sub(r, apex->at)), apex->at);
        if (!surface_point_nearest_from(&apex->march->cursor, &from, r, place, &distance))
            return false;
        r = place->jet.r;
    }
    return is_on_march(apex->march, place);
}

/* A step on round the ring, on from where the last one led, which it becomes; false at an edge. */
static bool step_round(const struct apex *apex, struct surface_point *place, struct vec3 *way) {
    double length = M_PI * apex->radius / RING_STEPS;
    struct vec3 from = place->jet.r;
    struct vec3 along = vec3_unit(vec3_cross(place->normal, ray_of(apex, place)));
    if (vec3_dot(along, *way) < 0)
        along = vec3_scale(-1, along);
    if (!find_on_ring(apex, place, vec3_axpy(length, along, from), place))
        return false;
    *way = vec3_sub(place->jet.r, from);
    return vec3_dot(*way, along) > goes_on * length;
}

/* From the ray that leads towards the start by equal steps to both sides until they meet; false
 * where the part is not all round the apex. */
static bool meet_round_apex(struct apex *apex) {
    struct vec3 towards = vec3_sub(apex->march->start.point.jet.r, apex->at), way[2], ray[2];
    struct surface_point first, side[2];
    double step = M_PI * apex->radius / RING_STEPS, distance;
    struct vec3 near = vec3_axpy(apex->radius, vec3_unit(towards), apex->at);
    if (!surface_point_nearest(apex->march->surface, &apex->march->cursor, near, &first,
                               &distance) ||
        !find_on_ring(apex, &first, first.jet.r, &first))
        return false;
    apex->angle = 0;
    for (int k = 0; k < 2; k++) {
        side[k] = first;
        ray[k] = ray_of(apex, &first);
        way[k] = vec3_scale(k ? -1 : 1, vec3_cross(first.normal, ray[k]));
    }
    for (int n = 0; n < 2 * RING_STEPS; n++) {
        struct vec3 gap = vec3_sub(side[1].jet.r, side[0].jet.r);
        if (n > 1 && vec3_norm(gap) < 2 * step && vec3_dot(gap, way[0]) > 0) {
            apex->angle += degrees_between(ray[0], ray[1]);
            return find_on_ring(apex, &side[0], vec3_axpy(0.5, gap, side[0].jet.r), &apex->across);
        }
        for (int k = 0; k < 2; k++) {
            if (!step_round(apex, &side[k], &way[k]))
                return false;
            struct vec3 next = ray_of(apex, &side[k]);
            apex->angle += degrees_between(ray[k], next);
            ray[k] = next;
        }
    }
    return false;
}

/* The line from the edge to the apex along the ray half way round, and its length; without points
 * where that leads to no edge. */
static enum status find_ray(const struct apex *apex, struct drape_cut_line *line, double *length) {
    struct march *march = apex->march;
    const struct surface *surface = apex->across.surface;
    double size = surface->shell ? shell_size(surface->shell) : surface->size;
    double step = ray_step * apex->spacing, end = ray_end * apex->spacing;
    struct vec3 *points = NULL;
    size_t count = 0, room = 0;
    struct path path;
    bool followed = path_geodesic(&path, surface, &apex->across, ray_of(apex, &apex->across));
    for (*length = 0; followed && *length < ray_longest * size && step > end;) {
        struct path ahead = path;
        struct surface_point place;
        if (!path_advance(&ahead, step) ||
            !path_surface_point(&ahead, &march->cursor, &place, NULL) ||
            !is_on_march(march, &place)) {
            step /= 2;
            continue;
        }
        path = ahead;
        *length += step;
        if (count == room)
            points = arena_enlarge(march->arena, points, count, sizeof *points, &room);
        if (!points)
            return STATUS_OUT_OF_MEMORY;
        points[count++] = place.jet.r;
    }
    if (count == 0 || step > end)
        return STATUS_OK;
    struct vec3 *back = arena_alloc(march->arena, count + 1, sizeof *back);
    if (!back)
        return STATUS_OUT_OF_MEMORY;
    for (size_t k = 0; k < count; k++)
        back[k] = points[count - 1 - k];
    back[count] = apex->at;
    *line = (struct drape_cut_line){back, count + 1};
    return STATUS_OK;
}

/* dJ/ds on the way to the edge; 1, as at the apex, where a ray cannot be followed. */
static double spread_of_rays(const struct apex *apex, double length) {
    struct surface_point side = apex->across, at;
    struct vec3 way = vec3_cross(side.normal, ray_of(apex, &side)), from[2];
    double apart[2], along[2];
    if (!step_round(apex, &side, &way))
        return 1;
    const struct surface_point *begin[2] = {&apex->across, &side};
    double angle = vec3_distance(ray_of(apex, begin[0]), ray_of(apex, begin[1]));
    for (int n = 0; n < 2; n++) {
        along[n] = compared_at[n] * length;
        for (int k = 0; k < 2; k++) {
            struct path path;
            if (!path_geodesic(&path, begin[k]->surface, begin[k], ray_of(apex, begin[k])) ||
                !path_advance(&path, along[n]) ||
                !path_surface_point(&path, &apex->march->cursor, &at, NULL))
                return 1;
            from[k] = at.jet.r;
        }
        apart[n] = vec3_distance(from[0], from[1]);
    }
    return (apart[1] - apart[0]) / (angle * (along[1] - along[0]));
}

/* Whether the normals at the pole at an end of an axis are not one. */
static bool turns_at_pole(const struct surface *surface, int axis, int end) {
    const struct surface_axis *round = &surface->axis[1 - axis], *along = &surface->axis[axis];
    struct surface_cursor cursor = {0};
    struct surface_point place;
    struct vec3 first = vec3_make(0, 0, 0);
    for (int k = 0; k < NORMALS; k++) {
        double uv[2];
        uv[axis] = end ? surface_axis_upper(along) : surface_axis_lower(along);
        uv[1 - axis] = surface_axis_lower(round) + surface_axis_length(round) * k / NORMALS;
        if (!surface_point_at(surface, &cursor, uv, &place))
            return false;
        first = k ? first : place.normal;
        if (degrees_between(first, place.normal) > even_turn)
            return true;
    }
    return false;
}

/* Adds the line to the pole at an end of an axis, if it is an apex that is not known yet. */
static enum status add_apex(struct march *march, const struct surface *surface, int axis, int end,
                            struct cuts_to_apexes *apexes, size_t *room) {
    const double *d = march->settings->spacing;
    struct apex apex = {
        .march = march, .spacing = fmin(d[0], d[1]), .at = surface->axis[axis].pole_point[end]};
    struct drape_cut_line line = {NULL, 0};
    double length;
    apex.radius = ring_radius * apex.spacing;
    for (size_t k = 0; k < apexes->count; k++)
        if (vec3_distance(apexes->line[k].path[apexes->line[k].count - 1], apex.at) < apex.radius)
            return STATUS_OK;
    if (!turns_at_pole(surface, axis, end) || !meet_round_apex(&apex) ||
        !(360 - apex.angle > passed_most))
        return STATUS_OK;
    enum status status = find_ray(&apex, &line, &length);
    if (status != STATUS_OK || line.count == 0 ||
        !(360 - apex.angle * spread_of_rays(&apex, length) > passed_most))
        return status;
    if (apexes->count == *room)
        apexes->line =
            arena_enlarge(march->arena, apexes->line, apexes->count, sizeof *apexes->line, room);
    if (!apexes->line)
        return STATUS_OUT_OF_MEMORY;
    apexes->line[apexes->count++] = line;
    return STATUS_OK;
}

enum status cuts_to_apexes(struct march *march, struct cuts_to_apexes *apexes) {
    const struct surface *whole = march->surface;
    const struct shell *shell = whole ? whole->shell : NULL;
    int32_t faces = shell ? (int32_t)shell_face_count(shell) : whole != NULL;
    int32_t component = shell ? shell_component(shell, whole->face) : 0;
    enum status status = STATUS_OK;
    size_t room = 0;
    *apexes = (struct cuts_to_apexes){NULL, 0};
    for (int32_t k = 0; k < faces; k++) {
        const struct surface *surface = shell ? shell_surface(shell, k) : whole;
        if (!surface->has_poles || (shell && shell_component(shell, k) != component))
            continue;
        for (int n = 0; n < 4 && status == STATUS_OK; n++)
            if (surface->axis[n / 2].pole[n % 2])
                status = add_apex(march, surface, n / 2, n % 2, apexes, &room);
    }
    return status;
}
