/* SPDX-License-Identifier: MIT */
#include "shape.h"

#include <stdio.h>
#include <string.h>

/* What is wrong with the drape, by where it is in the study. */
static void pass_on(const struct api_problem *inner, struct api_problem *problem) {
    *problem = *inner;
    for (size_t k = 0; inner->has_pointer && k < inner->count; k++)
        (void)snprintf(problem->error[k].pointer, API_POINTER_MAX, "/drape%.*s",
                       API_POINTER_MAX - 7, inner->error[k].pointer);
}

static int32_t largest_component(const struct study_shape *shape) {
    size_t count = shape->part.mesh ? shape->part.mesh->component_count
                                    : shell_component_count(shape->part.shell);
    double area = 0;
    int32_t largest = 0;
    for (size_t k = 0; k < count; k++) {
        double own = shape->part.mesh ? shape->part.mesh->components[k].area
                                      : shell_area(shape->part.shell, (int32_t)k, NULL);
        if (own > area) {
            area = own;
            largest = (int32_t)k;
        }
    }
    return largest;
}

/* The component with the drape's own start, which is the largest where it has none. */
static void find_component(const struct drape_settings *settings, struct study_shape *shape) {
    struct spread_place place;
    double distance;
    if (shape->part.surface)
        return;
    shape->component = SHELL_ANY;
    if (settings->start_kind == DRAPE_START_CENTROID) {
        shape->component = largest_component(shape);
    } else if (settings->start_kind == DRAPE_START_UV) {
        shape->component = shell_component(shape->part.shell, settings->start_face);
    } else {
        study_shape_nearest(shape, settings->start_point, &place, &distance);
        shape->component = shape->part.mesh ? shape->part.mesh->component[place.face]
                                            : shell_component(shape->part.shell, place.face);
    }
}

static double find_area(const struct study_shape *shape) {
    struct vec3 centroid;
    const struct trim *trim = shape->part.trim;
    if (shape->part.mesh)
        return shape->part.mesh->components[shape->component].area;
    if (shape->part.surface)
        return trim ? trim_area(trim, &centroid) : surface_area(shape->part.surface, NULL);
    return shell_area(shape->part.shell, shape->component, NULL);
}

enum api_problem_id study_shape_make(struct study_request *request, const struct api_limits *limits,
                                     struct arena *arena, struct study_shape *shape,
                                     struct api_problem *problem) {
    struct api_problem inner = {0};
    struct prepared_part made;
    struct drape_settings *settings = &request->drape.settings;
    if (prepared_part_make(&request->drape, limits, arena, &made, &inner) != API_OK) {
        pass_on(&inner, problem);
        return problem->id;
    }
    *shape = (struct study_shape){.part = made.part, .shell = made.shell};
    settings->start_face = made.shell.start_face;
    find_component(settings, shape);
    shape->area = find_area(shape);
    return API_OK;
}

static const struct surface *plain_surface(const struct study_shape *shape, int32_t face) {
    return shape->part.surface ? shape->part.surface : shell_plain_surface(shape->part.shell, face);
}

struct spread_place study_shape_at(const struct study_shape *shape, int32_t face,
                                   const double uv[2]) {
    struct surface_cursor cursor = {0};
    struct surface_jet jet;
    surface_evaluate(plain_surface(shape, face), &cursor, uv[0], uv[1], &jet);
    return (struct spread_place){face, {uv[0], uv[1]}, jet.r};
}

void study_shape_nearest(const struct study_shape *shape, struct vec3 point,
                         struct spread_place *place, double *distance) {
    *place = (struct spread_place){0};
    if (shape->part.mesh) {
        struct mesh_point nearest = {0};
        if (!mesh_nearest(shape->part.mesh, point, shape->component, &nearest, distance))
            *distance = HUGE_VAL;
        *place = (struct spread_place){nearest.triangle, {nearest.triangle, 0}, nearest.r};
        return;
    }
    if (shape->part.surface) {
        surface_nearest(shape->part.surface, point, place->uv, distance);
    } else {
        struct shell_point nearest;
        shell_nearest(shape->part.shell, point, shape->component, &nearest, distance);
        place->face = nearest.face;
        memcpy(place->uv, nearest.uv, sizeof place->uv);
    }
    *place = study_shape_at(shape, place->face, place->uv);
}

static bool usable(const struct study_shape *shape, const struct spread_place *place) {
    const struct trim *trim = shape->part.trim;
    return !shape->part.surface || !trim || trim_contains(trim, place->uv);
}

struct spread_place study_shape_shift(const struct study_shape *shape,
                                      const struct spread_place *from, struct vec3 shift) {
    enum { HALVINGS = 12 };
    struct spread_place place, reached = *from;
    double distance, low = 0, high = 1, share = 1;
    for (int k = 0; k < HALVINGS && low < 1; k++) {
        study_shape_nearest(shape, vec3_axpy(share, shift, from->r), &place, &distance);
        bool there = usable(shape, &place);
        reached = there ? place : reached;
        low = there ? share : low;
        high = there ? high : share;
        share = 0.5 * (low + high);
    }
    return reached;
}

/* As the solver measures them: on a mesh from the x axis, or y where that is along the normal. */
static const double across_x = 0.9;

/* Tangents this nearly parallel (sine of their angle) span no plane to measure in. */
static const double parallel = 1e-6;

bool study_shape_axes(const struct study_shape *shape, const struct spread_place *place,
                      struct vec3 *normal, struct vec3 *along) {
    struct surface_cursor cursor = {0};
    struct surface_jet jet;
    if (shape->part.mesh) {
        *normal = shape->part.mesh->normals[place->face];
        bool x = fabs(normal->x) < across_x;
        *along = mesh_tangent(shape->part.mesh, place->face,
                              x ? vec3_make(1, 0, 0) : vec3_make(0, 1, 0));
        return true;
    }
    surface_evaluate(plain_surface(shape, place->face), &cursor, place->uv[0], place->uv[1], &jet);
    *normal = vec3_unit(vec3_cross(jet.u, jet.v));
    *along = vec3_unit(jet.u);
    return vec3_norm(vec3_cross(jet.u, jet.v)) > parallel * vec3_norm(jet.u) * vec3_norm(jet.v);
}

static bool in_face(const struct shell *shell, const struct spread_place *place) {
    const struct trim *trim = shell_trim(shell, place->face);
    return !trim || trim_contains(trim, place->uv);
}

/* du and dv so that r_u du + r_v dv is the shift, in the tangent plane. */
bool study_shape_nudge(const struct study_shape *shape, const struct spread_place *from,
                       const double shift[2], struct spread_place *to) {
    struct surface_cursor cursor = {0};
    struct surface_jet jet;
    struct vec3 normal, along;
    double lower[2], upper[2], distance;
    bool within = true;
    if (!study_shape_axes(shape, from, &normal, &along))
        return false;
    struct vec3 by = vec3_axpy(shift[1], vec3_cross(normal, along), vec3_scale(shift[0], along));
    if (shape->part.mesh) {
        study_shape_nearest(shape, vec3_add(from->r, by), to, &distance);
        return true;
    }
    const struct surface *surface = plain_surface(shape, from->face);
    surface_evaluate(surface, &cursor, from->uv[0], from->uv[1], &jet);
    surface_domain(surface, lower, upper);
    double area = vec3_dot(normal, vec3_cross(jet.u, jet.v));
    *to = *from;
    to->uv[0] += vec3_dot(normal, vec3_cross(by, jet.v)) / area;
    to->uv[1] += vec3_dot(normal, vec3_cross(jet.u, by)) / area;
    for (int k = 0; k < 2; k++) {
        double width = upper[k] - lower[k];
        if (surface_closed(surface, k))
            to->uv[k] -= width * floor((to->uv[k] - lower[k]) / width);
        within = within && to->uv[k] >= lower[k] && to->uv[k] <= upper[k];
        to->uv[k] = fmin(fmax(to->uv[k], lower[k]), upper[k]);
    }
    if (shape->part.shell && !(within && in_face(shape->part.shell, to)))
        study_shape_nearest(shape, vec3_add(from->r, by), to, &distance);
    else
        *to = study_shape_at(shape, to->face, to->uv);
    return usable(shape, to);
}
