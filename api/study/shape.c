/* SPDX-License-Identifier: MIT */
#include "shape.h"

#include "api/request/shape.h"
#include "api/request/shape_mesh.h"
#include <stdio.h>
#include <string.h>

/* What is wrong with the drape, by where it is in the study. */
static void pass_on(const struct api_problem *inner, struct api_problem *problem) {
    *problem = *inner;
    for (size_t k = 0; inner->has_pointer && k < inner->count; k++)
        (void)snprintf(problem->place[k].pointer, API_POINTER_MAX, "/drape%.*s",
                       API_POINTER_MAX - 7, inner->place[k].pointer);
}

static enum api_problem_id make(struct study_request *request, const struct api_limits *limits,
                                struct arena *arena, struct study_shape *shape,
                                struct api_problem *problem) {
    switch (request->drape.surface.kind) {
    case API_SURFACE_MESH:
        return api_shape_mesh(&request->drape, limits, arena, &shape->mesh, problem);
    case API_SURFACE_SHELL:
        return api_shape_shell(&request->drape, limits, arena, &shape->shell, problem);
    default:
        return api_shape_make(&request->drape, limits, arena, &shape->surface, problem);
    }
}

static int32_t largest_component(const struct study_shape *shape) {
    size_t count =
        shape->mesh ? shape->mesh->component_count : shell_component_count(shape->shell.shell);
    double area = 0;
    int32_t largest = 0;
    for (size_t k = 0; k < count; k++) {
        double own = shape->mesh ? shape->mesh->components[k].area
                                 : shell_area(shape->shell.shell, (int32_t)k, NULL);
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
    if (shape->surface)
        return;
    shape->component = SHELL_ANY;
    if (settings->start_kind == DRAPE_START_CENTROID) {
        shape->component = largest_component(shape);
    } else if (settings->start_kind == DRAPE_START_UV) {
        shape->component = shell_component(shape->shell.shell, settings->start_face);
    } else {
        study_shape_nearest(shape, settings->start_point, &place, &distance);
        shape->component = shape->mesh ? shape->mesh->component[place.face]
                                       : shell_component(shape->shell.shell, place.face);
    }
}

static double find_area(const struct study_request *request, const struct study_shape *shape) {
    struct vec3 centroid;
    const struct trim *trim = request->drape.settings.trim;
    if (shape->mesh)
        return shape->mesh->components[shape->component].area;
    if (shape->surface)
        return trim ? trim_area(trim, &centroid) : surface_area(shape->surface, NULL);
    return shell_area(shape->shell.shell, shape->component, NULL);
}

enum api_problem_id study_shape_make(struct study_request *request, const struct api_limits *limits,
                                     struct arena *arena, struct study_shape *shape,
                                     struct api_problem *problem) {
    struct api_problem inner = {0};
    *shape = (struct study_shape){0};
    if (make(request, limits, arena, shape, &inner) != API_OK) {
        pass_on(&inner, problem);
        return problem->id;
    }
    request->drape.settings.start_face = shape->shell.start_face;
    struct drape_settings *settings = &request->drape.settings;
    if (shape->mesh &&
        drape_prepare_mesh(shape->mesh, settings->method, arena, &settings->smooth) != STATUS_OK) {
        api_problem_set(problem, API_OUT_OF_MEMORY, "the mesh needs more memory than allowed");
        return problem->id;
    }
    find_component(settings, shape);
    shape->area = find_area(request, shape);
    return API_OK;
}

struct spread_part study_shape_part(const struct study_request *request,
                                    const struct study_shape *shape) {
    return (struct spread_part){.surface = shape->surface,
                                .trim = request->drape.settings.trim,
                                .shell = shape->shell.shell,
                                .mesh = shape->mesh,
                                .component = shape->component};
}

static const struct surface *plain_surface(const struct study_shape *shape, int32_t face) {
    return shape->surface ? shape->surface : shell_plain_surface(shape->shell.shell, face);
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
    if (shape->mesh) {
        struct mesh_point nearest = {0};
        if (!mesh_nearest(shape->mesh, point, shape->component, &nearest, distance))
            *distance = HUGE_VAL;
        *place = (struct spread_place){nearest.triangle, {nearest.triangle, 0}, nearest.r};
        return;
    }
    if (shape->surface) {
        surface_nearest(shape->surface, point, place->uv, distance);
    } else {
        struct shell_point nearest;
        shell_nearest(shape->shell.shell, point, shape->component, &nearest, distance);
        place->face = nearest.face;
        memcpy(place->uv, nearest.uv, sizeof place->uv);
    }
    *place = study_shape_at(shape, place->face, place->uv);
}

static bool usable(const struct study_request *request, const struct study_shape *shape,
                   const struct spread_place *place) {
    const struct trim *trim = request->drape.settings.trim;
    return !shape->surface || !trim || trim_contains(trim, place->uv);
}

struct spread_place study_shape_shift(const struct study_request *request,
                                      const struct study_shape *shape,
                                      const struct spread_place *from, struct vec3 shift) {
    enum { HALVINGS = 12 };
    struct spread_place place, reached = *from;
    double distance, low = 0, high = 1, share = 1;
    for (int k = 0; k < HALVINGS && low < 1; k++) {
        study_shape_nearest(shape, vec3_axpy(share, shift, from->r), &place, &distance);
        bool there = usable(request, shape, &place);
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
    if (shape->mesh) {
        *normal = shape->mesh->normals[place->face];
        bool x = fabs(normal->x) < across_x;
        *along =
            mesh_tangent(shape->mesh, place->face, x ? vec3_make(1, 0, 0) : vec3_make(0, 1, 0));
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
bool study_shape_nudge(const struct study_request *request, const struct study_shape *shape,
                       const struct spread_place *from, const double shift[2],
                       struct spread_place *to) {
    struct surface_cursor cursor = {0};
    struct surface_jet jet;
    struct vec3 normal, along;
    double lower[2], upper[2], distance;
    bool within = true;
    if (!study_shape_axes(shape, from, &normal, &along))
        return false;
    struct vec3 by = vec3_axpy(shift[1], vec3_cross(normal, along), vec3_scale(shift[0], along));
    if (shape->mesh) {
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
    if (shape->shell.shell && !(within && in_face(shape->shell.shell, to)))
        study_shape_nearest(shape, vec3_add(from->r, by), to, &distance);
    else
        *to = study_shape_at(shape, to->face, to->uv);
    return usable(request, shape, to);
}
