/* SPDX-License-Identifier: MIT */
#include "prepared_surface.h"

#include "api/json/text.h"
#include "digest.h"
#include "prepared_mesh.h"
#include "prepared_shell.h"
#include "solver/shell/offset.h"
#include "solver/surface/bounds.h"
#include "solver/surface/measure.h"
#include <stdio.h>

bool prepared_surface_is_large(const struct api_surface *surface) {
    return surface->kind == API_SURFACE_SHELL
               ? prepared_shell_bytes(surface) > PREPARED_SPANS_MAX
               : surface->kind == API_SURFACE_NURBS &&
                     surface_span_bytes(&surface->nurbs) > PREPARED_SPANS_MAX;
}

static enum api_problem_id check_made(enum status status, const char *pointer,
                                      struct api_problem *problem) {
    if (status == STATUS_OUT_OF_MEMORY)
        api_problem_set(problem, API_OUT_OF_MEMORY, "the surface needs more memory than allowed");
    else if (status != STATUS_OK)
        api_problem_set_at(problem, API_DEGENERATE_SURFACE, pointer, "the surface has no area");
    return problem->id;
}

/* `pointer` leads to the definition in the caller's document. */
static enum api_problem_id make(const struct api_surface *definition, const char *pointer,
                                struct arena *arena, struct surface **surface,
                                struct api_problem *problem) {
    if (definition->kind != API_SURFACE_NURBS) {
        api_problem_add(problem, pointer, "must be the definition of a NURBS surface");
        return problem->id;
    }
    return check_made(surface_make(&definition->nurbs, arena, surface), pointer, problem);
}

/* The least number of nodes that can cover the area: cells are no larger than spacing squared. A
 * net bounded in one direction covers a strip, of which nothing is known beforehand. */
static double least_nodes(const struct drape_settings *settings, double area) {
    double nodes = area / (settings->spacing[0] * settings->spacing[1]);
    if (!settings->has_extent[0] && !settings->has_extent[1])
        return nodes;
    if (!settings->has_extent[0] || !settings->has_extent[1])
        return 1;
    const int(*extent)[2] = settings->extent;
    double warp = (double)extent[0][1] - extent[0][0] + 1;
    double weft = (double)extent[1][1] - extent[1][0] + 1;
    return fmin(nodes, warp * weft);
}

enum api_problem_id prepared_surface_loop_fault(struct api_problem *problem, const char *pointer,
                                                const char *what, const struct loop_fault *fault) {
    if (fault->kind == LOOP_OPEN)
        api_problem_add(problem, pointer,
                        "trim %zu of %s is open: a curve ends at u = %.6g, v = %.6g and the next "
                        "begins at u = %.6g, v = %.6g; join them",
                        fault->loop, what, fault->uv[0], fault->uv[1], fault->uv[0] + fault->gap[0],
                        fault->uv[1] + fault->gap[1]);
    else
        api_problem_add(problem, pointer,
                        "trim %zu of %s crosses itself, or goes round more than once, about u = "
                        "%.6g, v = %.6g: what it encloses is not one region",
                        fault->loop, what, fault->uv[0], fault->uv[1]);
    return problem->id;
}

/* `base` leads to the trims of a surface of one face. */
static enum api_problem_id loop_problem(const char *base, const struct loop_fault *fault,
                                        struct api_problem *problem) {
    char pointer[API_POINTER_MAX];
    (void)snprintf(pointer, sizeof pointer, "%s/%zu", base, fault->loop);
    return prepared_surface_loop_fault(problem, pointer, "the surface", fault);
}

/* What the tolerance of a shell of this surface alone would be. */
static double tolerance_of(const struct surface *surface) {
    struct vec3 lower, upper;
    surface_bounds(surface, &lower, &upper);
    return SHELL_TOLERANCE * vec3_distance(lower, upper);
}

/* The trimmed region, NULL where the surface has no trims; `pointer` leads to them. */
static enum api_problem_id make_trim(const struct api_surface *definition, const char *pointer,
                                     const struct surface *surface, struct arena *arena,
                                     struct trim **trim, struct api_problem *problem) {
    struct loop_fault fault;
    *trim = NULL;
    if (definition->trim_count == 0)
        return API_OK;
    enum status status = trim_make(surface, definition->trims, definition->trim_count, arena, trim);
    if (status == STATUS_OK)
        status =
            loops_check(definition->trims, *trim, surface, tolerance_of(surface), arena, &fault);
    switch (status) {
    case STATUS_OK:
        return fault.kind == LOOP_SOUND ? API_OK : loop_problem(pointer, &fault, problem);
    case STATUS_OUT_OF_MEMORY:
        api_problem_set(problem, API_OUT_OF_MEMORY, "the trims need more memory than allowed");
        break;
    default:
        api_problem_set_at(problem, API_DEGENERATE_SURFACE, pointer,
                           "the trims leave nothing of the surface");
        break;
    }
    return problem->id;
}

static double usable_area(const struct trim *trim, const struct surface *surface) {
    struct vec3 centroid;
    return trim ? trim_area(trim, &centroid) : surface_area(surface, NULL);
}

enum api_problem_id prepared_surface_offset_fault(struct api_problem *problem, double offset,
                                                  const char *what, struct vec3 at, double radius,
                                                  double fold_deg) {
    if (radius > 0)
        api_problem_add(problem, "/offset",
                        "moves %s by %.6g near (%.6g, %.6g, %.6g), where its radius of curvature "
                        "on that side is %.6g: there is no surface so far away",
                        what, fabs(offset), at.x, at.y, at.z, radius);
    else
        api_problem_add(problem, "/offset",
                        "moves %s near (%.6g, %.6g, %.6g), where they fold by %.4g degrees: give "
                        "the fold a radius, or leave the surface where it is",
                        what, at.x, at.y, at.z, fold_deg);
    return problem->id;
}

/* The surface that the request wants draped: moved, if it says so. */
static enum api_problem_id move(const struct api_request *request, struct arena *arena,
                                struct surface **surface, struct api_problem *problem) {
    if (request->offset == 0)
        return API_OK;
    return check_made(surface_offset(*surface, request->offset, arena, surface), "/offset",
                      problem);
}

/* Whether the moved surface has no place that is curved too much, or creased. */
static bool holds(const struct surface *surface, const struct trim *trim,
                  struct surface_offset_fault *fault) {
    return surface_offset_height(surface) == 0 ||
           surface_offset_holds(surface, trim, tolerance_of(surface), fault);
}

static enum api_problem_id make_patch(const struct api_request *request,
                                      const struct api_limits *limits, struct arena *arena,
                                      struct drape_part *part, struct api_problem *problem) {
    struct surface_offset_fault fault;
    struct surface *surface;
    struct trim *trim;
    if (make(&request->surface, "/surface", arena, &surface, problem) != API_OK ||
        move(request, arena, &surface, problem) != API_OK ||
        make_trim(&request->surface, "/surface/trims", surface, arena, &trim, problem) != API_OK)
        return problem->id;
    *part = (struct drape_part){.surface = surface, .trim = trim};
    if (!holds(surface, trim, &fault))
        return prepared_surface_offset_fault(problem, request->offset, "the surface", fault.at,
                                             fault.radius, fault.fold_deg);
    double nodes = least_nodes(&request->settings, usable_area(trim, surface));
    if (nodes <= (double)limits->max_nodes)
        return API_OK;
    api_problem_add(
        problem, "/fabric/spacing",
        "is too small: covering the surface takes about %.3g nodes, and %zu are allowed", nodes,
        limits->max_nodes);
    return problem->id;
}

enum api_problem_id prepared_part_make(const struct api_request *request,
                                       const struct api_limits *limits, struct arena *arena,
                                       struct prepared_part *shape, struct api_problem *problem) {
    struct mesh *mesh = NULL;
    enum api_problem_id id;
    *shape = (struct prepared_part){0};
    switch (request->surface.kind) {
    case API_SURFACE_MESH:
        id = prepared_mesh_make(request, limits, arena, &mesh, problem);
        shape->part.mesh = mesh;
        return id;
    case API_SURFACE_SHELL:
        id = prepared_shell_make(request, limits, arena, &shape->shell, problem);
        shape->part.shell = shape->shell.shell;
        return id;
    default:
        return make_patch(request, limits, arena, &shape->part, problem);
    }
}

static void write_point(struct api_text *text, struct vec3 point) {
    api_text_numbers(text, (const double[]){point.x, point.y, point.z}, 3);
}

static void write_truth(struct api_text *text, const char *key, bool value) {
    api_text_key(text, key);
    api_text_raw(text, value ? "true" : "false");
}

/* What a description says of a surface. One of very many spans is measured without keeping them,
 * unless it has trims, whose area takes the whole surface. */
static enum api_problem_id measure(const struct api_surface *definition, struct arena *arena,
                                   struct surface_measure *measure, struct api_problem *problem) {
    struct surface *surface;
    struct trim *trim;
    if (definition->kind == API_SURFACE_NURBS && definition->trim_count == 0 &&
        surface_span_bytes(&definition->nurbs) > PREPARED_SPANS_MAX)
        return check_made(surface_measure(&definition->nurbs, arena, measure), "", problem);
    if (make(definition, "", arena, &surface, problem) != API_OK ||
        make_trim(definition, "/trims", surface, arena, &trim, problem) != API_OK)
        return problem->id;
    measure->area = usable_area(trim, surface);
    bounds_tight(surface, &measure->lower, &measure->upper);
    for (int k = 0; k < 2; k++)
        measure->closed[k] = surface_closed(surface, k);
    return API_OK;
}

/* A shell, whose faces are described one by one, or a mesh. */
static const char *describe_faces(const struct api_surface *definition, struct arena *arena,
                                  struct api_problem *problem) {
    char id[API_ID_SIZE];
    bool ok = api_digest_surface(definition, arena, id);
    struct api_text text = api_text_growing(arena);
    api_text_raw(&text, "{");
    api_text_key_string(&text, "id", ok ? id : "");
    if (definition->kind == API_SURFACE_MESH
            ? prepared_mesh_describe(definition, &text, arena, problem)
            : prepared_shell_describe(definition, &text, arena, problem))
        return NULL;
    if (definition->kind == API_SURFACE_MESH)
        prepared_shell_write_notes(&text, definition, "");
    if (definition->length_unit)
        api_text_key_string(&text, "length_unit", definition->length_unit->name);
    api_text_raw(&text, "}");
    const char *document = ok ? api_text_finish(&text) : NULL;
    if (!document)
        api_problem_set(problem, API_OUT_OF_MEMORY, "no memory to describe the surface");
    return document;
}

const char *prepared_surface_describe(const struct api_surface *definition, struct arena *arena,
                                      struct api_problem *problem) {
    if (definition->kind != API_SURFACE_NURBS)
        return describe_faces(definition, arena, problem);
    struct surface_measure size;
    char id[API_ID_SIZE];
    const struct nurbs *nurbs = &definition->nurbs;
    if (measure(definition, arena, &size, problem) != API_OK)
        return NULL;
    bool ok = api_digest_surface(definition, arena, id);
    struct api_text text = api_text_growing(arena);
    api_text_raw(&text, "{");
    api_text_key_string(&text, "id", ok ? id : "");
    api_text_key_integer(&text, "degree_u", nurbs->u.degree);
    api_text_key_integer(&text, "degree_v", nurbs->v.degree);
    api_text_key_integer(&text, "size_u", nurbs->u.size);
    api_text_key_integer(&text, "size_v", nurbs->v.size);
    write_truth(&text, "rational", nurbs->weights != NULL);
    write_truth(&text, "closed_u", size.closed[0]);
    write_truth(&text, "closed_v", size.closed[1]);
    api_text_key(&text, "bounding_box");
    api_text_raw(&text, "[");
    write_point(&text, size.lower);
    api_text_raw(&text, ",");
    write_point(&text, size.upper);
    api_text_raw(&text, "]");
    api_text_key_number(&text, "area", size.area);
    api_text_raw(&text, "}");
    const char *document = ok ? api_text_finish(&text) : NULL;
    if (!document)
        api_problem_set(problem, API_OUT_OF_MEMORY, "no memory to describe the surface");
    return document;
}
