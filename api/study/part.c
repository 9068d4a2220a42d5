/* SPDX-License-Identifier: MIT */
#include "part.h"

#include "study.h"

#include "api/laminate/course_limits.h"
#include <stdio.h>
#include <string.h>

/* Whether the part has room for the courses, at both ends of what is varied. */
static enum api_problem_id check_courses(const struct study_request *request,
                                         const struct drape_part *part,
                                         struct api_problem *problem) {
    const struct study_courses *courses = &request->courses;
    for (int end = 0; end < 2 && problem->id == API_OK; end++) {
        double unknowns[API_STUDY_UNKNOWNS];
        struct course_plan plan;
        struct courses_settings settings;
        for (size_t k = 0; k < course_plan_unknowns(courses); k++) {
            struct study_span span = course_plan_span(courses, k);
            unknowns[k] = end ? span.to : span.from;
        }
        course_plan_make(courses, unknowns, &plan);
        course_limits_settle(&plan.lay, &request->drape.settings, &settings);
        const struct course_limits limits = {
            .part = part, .unit = request->drape.length_unit, .problem = problem};
        (void)!course_limits_check(&limits, &settings);
    }
    return problem->id;
}

enum api_problem_id study_part_make(struct study_request *request, const struct api_limits *limits,
                                    struct arena *arena, struct study_part *part,
                                    struct api_problem *problem) {
    struct drape_settings *settings = &request->drape.settings;
    struct api_problem own = {0};
    struct prepared_part made;
    if (prepared_part_make(&request->drape, limits, arena, &made, &own) != API_OK) {
        *problem = own;
        for (size_t k = 0; own.has_pointer && k < own.count; k++)
            (void)snprintf(problem->error[k].pointer, API_POINTER_MAX, "/drape%.*s",
                           API_POINTER_MAX - 7, own.error[k].pointer);
        return problem->id;
    }
    *part =
        (struct study_part){.geometry = made.part, .shell = made.shell, .zero = &settings->zero};
    settings->start_face = made.shell.start_face;
    if (request->courses.base && check_courses(request, &made.part, problem) != API_OK)
        return problem->id;
    const struct drape_part *g = &part->geometry;
    if (g->surface) {
        struct vec3 centroid;
        part->area = g->trim ? trim_area(g->trim, &centroid) : surface_area(g->surface, NULL);
        return API_OK;
    }
    /* The component with the drape's own start, which is the largest where it has none. */
    bool largest = settings->start_kind == DRAPE_START_CENTROID;
    size_t count = g->mesh ? g->mesh->component_count : shell_component_count(g->shell);
    struct part_point start = {.face = settings->start_face};
    double distance;
    part->component = SHELL_ANY;
    if (settings->start_kind == DRAPE_START_POINT)
        study_part_nearest(part, settings->start_point, &start, &distance);
    if (!largest)
        part->component =
            g->mesh ? g->mesh->component[start.face] : shell_component(g->shell, start.face);
    for (size_t k = 0; k < count; k++) {
        double area =
            g->mesh ? g->mesh->components[k].area : shell_area(g->shell, (int32_t)k, NULL);
        if (largest ? k == 0 || area > part->area : part->component == (int32_t)k) {
            part->component = (int32_t)k;
            part->area = area;
        }
    }
    return API_OK;
}

/* ---- points ---- */

static const struct surface *surface_of(const struct study_part *part, int32_t face) {
    const struct drape_part *g = &part->geometry;
    return g->surface ? g->surface : shell_plain_surface(g->shell, face);
}

struct part_point study_part_at(const struct study_part *part, int32_t face, const double uv[2]) {
    struct surface_cursor cursor = {0};
    struct surface_jet jet;
    surface_evaluate(surface_of(part, face), &cursor, uv[0], uv[1], &jet);
    return (struct part_point){face, {uv[0], uv[1]}, jet.r};
}

void study_part_nearest(const struct study_part *part, struct vec3 point,
                        struct part_point *nearest, double *distance) {
    const struct drape_part *g = &part->geometry;
    if (g->mesh) {
        struct mesh_point found = {0};
        if (!mesh_nearest(g->mesh, point, part->component, &found, distance))
            *distance = HUGE_VAL;
        *nearest = (struct part_point){found.triangle, {found.triangle, 0}, found.r};
    } else if (g->surface) {
        double uv[2];
        surface_nearest(g->surface, point, uv, distance);
        *nearest = study_part_at(part, 0, uv);
    } else {
        struct shell_point found;
        shell_nearest(g->shell, point, part->component, &found, distance);
        *nearest = study_part_at(part, found.face, found.uv);
    }
}

/* Whether a point is not trimmed away from its face, or with `whole` from a surface of one. */
static bool is_usable(const struct study_part *part, const struct part_point *point, bool whole) {
    const struct drape_part *g = &part->geometry;
    const struct trim *trim = NULL;
    if (whole && g->surface)
        trim = g->trim;
    else if (!whole && g->shell)
        trim = shell_trim(g->shell, point->face);
    return !trim || trim_contains(trim, point->uv);
}

struct part_point study_part_shift(const struct study_part *part, const struct part_point *from,
                                   struct vec3 shift) {
    enum { HALVINGS = 12 };
    struct part_point point, reached = *from;
    double distance, low = 0, high = 1, share = 1;
    for (int k = 0; k < HALVINGS && low < 1; k++) {
        study_part_nearest(part, vec3_axpy(share, shift, from->r), &point, &distance);
        bool there = is_usable(part, &point, true);
        reached = there ? point : reached;
        low = there ? share : low;
        high = there ? high : share;
        share = 0.5 * (low + high);
    }
    return reached;
}

/* Tangents this nearly parallel (sine of their angle) span no plane to measure in. */
static const double parallel = 1e-6;

bool study_part_axes(const struct study_part *part, const struct part_point *at,
                     struct vec3 *normal, struct vec3 *along) {
    const struct mesh *mesh = part->geometry.mesh;
    struct surface_cursor cursor = {0};
    struct surface_jet jet = {.u = {0, 0, 0}};
    bool plane = mesh != NULL;
    if (mesh) {
        *normal = mesh->normals[at->face];
    } else {
        surface_evaluate(surface_of(part, at->face), &cursor, at->uv[0], at->uv[1], &jet);
        struct vec3 across = vec3_cross(jet.u, jet.v);
        bool by_first = part->geometry.shell && part->zero->kind != DRAPE_ZERO_TANGENT;
        int side = by_first ? shell_side(part->geometry.shell, at->face) : 1;
        *normal = vec3_scale(side, vec3_unit(across));
        plane = vec3_norm(across) > parallel * vec3_norm(jet.u) * vec3_norm(jet.v);
    }
    int sense = drape_zero_direction(part->zero, *normal, jet.u, along);
    *normal = vec3_scale(sense, *normal);
    return plane && vec3_norm2(*along) > 0;
}

/* du and dv so that r_u du + r_v dv is the shift, in the tangent plane. */
bool study_part_nudge(const struct study_part *part, const struct part_point *from,
                      const double shift[2], struct part_point *to) {
    struct surface_cursor cursor = {0};
    struct surface_jet jet;
    struct vec3 normal, along;
    double lower[2], upper[2], distance;
    bool within = true;
    if (!study_part_axes(part, from, &normal, &along))
        return false;
    struct vec3 by = vec3_axpy(shift[1], vec3_cross(normal, along), vec3_scale(shift[0], along));
    if (part->geometry.mesh) {
        study_part_nearest(part, vec3_add(from->r, by), to, &distance);
        return true;
    }
    const struct surface *surface = surface_of(part, from->face);
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
    if (part->geometry.shell && !(within && is_usable(part, to, false)))
        study_part_nearest(part, vec3_add(from->r, by), to, &distance);
    else
        *to = study_part_at(part, to->face, to->uv);
    return is_usable(part, to, true);
}
