/* SPDX-License-Identifier: MIT */
#include "prepared_surface.h"

#include "api/json/text.h"
#include "prepared_form.h"
#include "solver/shell/offset.h"
#include "solver/shell/shell.h"
#include "solver/surface/bounds.h"
#include "solver/surface/measure.h"
#include <stdio.h>

/* `pointer` leads to what `status` is of. */
static enum api_problem_id check_made(enum status status, const char *pointer,
                                      struct api_problem *problem) {
    if (status == STATUS_OUT_OF_MEMORY)
        return api_problem_no_memory(problem, "the surface");
    return status == STATUS_OK ? API_OK
                               : api_problem_set_at(problem, API_DEGENERATE_SURFACE, pointer,
                                                    "the surface has no area");
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
        return api_problem_add(
            problem, pointer,
            "trim %zu of %s is open: a curve ends at u = %.6g, v = %.6g and the next "
            "begins at u = %.6g, v = %.6g; join them",
            fault->loop, what, fault->uv[0], fault->uv[1], fault->uv[0] + fault->gap[0],
            fault->uv[1] + fault->gap[1]);
    return api_problem_add(problem, pointer,
                           "trim %zu of %s crosses itself, or goes round more than once, near u = "
                           "%.6g, v = %.6g: it must enclose one region",
                           fault->loop, what, fault->uv[0], fault->uv[1]);
}

/* What the tolerance of a shell of this surface alone would be. */
static double tolerance_of(const struct surface *surface) {
    struct vec3 lower, upper;
    surface_bounds(surface, &lower, &upper);
    return SHELL_TOLERANCE * vec3_distance(lower, upper);
}

static double usable_area(const struct trim *trim, const struct surface *surface) {
    struct vec3 centroid;
    return trim ? trim_area(trim, &centroid) : surface_area(surface, NULL);
}

enum api_problem_id prepared_surface_offset_fault(struct api_problem *problem, double offset,
                                                  const char *what, struct vec3 at, double radius,
                                                  double fold_deg) {
    if (radius > 0)
        return api_problem_add(problem, "/offset",
                               "moves %s by %.6g near (%.6g, %.6g, %.6g), but its radius of "
                               "curvature on that side is only %.6g: make the offset smaller",
                               what, fabs(offset), at.x, at.y, at.z, radius);
    return api_problem_add(problem, "/offset",
                           "moves %s near (%.6g, %.6g, %.6g), where they fold by %.4g degrees: "
                           "give the fold a radius, or use no offset",
                           what, at.x, at.y, at.z, fold_deg);
}

/* The surface and its trims, NULL where it has none; `base` leads to the definition in the caller's
 * document. The surface is moved by `offset` before it is trimmed. */
static enum api_problem_id make_trimmed(const struct api_surface *definition, const char *base,
                                        double offset, struct arena *arena,
                                        struct surface **surface, struct trim **trim,
                                        struct api_problem *problem) {
    char trims[16];
    (void)snprintf(trims, sizeof trims, "%s/trims", base);
    if (check_made(surface_make(&definition->nurbs, arena, surface), base, problem) != API_OK ||
        (offset != 0 && check_made(surface_offset(*surface, offset, arena, surface), "/offset",
                                   problem) != API_OK))
        return problem->id;
    struct loop_fault fault;
    *trim = NULL;
    if (definition->trim_count == 0)
        return API_OK;
    enum status status =
        trim_make(*surface, definition->trims, definition->trim_count, arena, trim);
    if (status == STATUS_OK)
        status =
            loops_check(definition->trims, *trim, *surface, tolerance_of(*surface), arena, &fault);
    if (status == STATUS_OUT_OF_MEMORY)
        return api_problem_no_memory(problem, "the trims");
    if (status != STATUS_OK)
        return api_problem_set_at(problem, API_DEGENERATE_SURFACE, trims,
                                  "the trims leave no area of the surface");
    if (fault.kind == LOOP_SOUND)
        return API_OK;
    char loop[API_POINTER_MAX];
    (void)snprintf(loop, sizeof loop, "%s/%zu", trims, fault.loop);
    return prepared_surface_loop_fault(problem, loop, "the surface", &fault);
}

/* The surface of a request, moved and trimmed. */
static enum api_problem_id make_moved(const struct api_request *request, struct arena *arena,
                                      struct drape_part *part, struct api_problem *problem) {
    struct surface_offset_fault fault;
    struct surface *surface;
    struct trim *trim;
    if (make_trimmed(&request->surface, "/surface", request->offset, arena, &surface, &trim,
                     problem) != API_OK)
        return problem->id;
    *part = (struct drape_part){.surface = surface, .trim = trim};
    /* Where the moved surface is curved too much, or creased, it is none. */
    if (surface_offset_height(surface) != 0 &&
        !surface_offset_holds(surface, trim, tolerance_of(surface), &fault))
        return prepared_surface_offset_fault(problem, request->offset, "the surface", fault.at,
                                             fault.radius, fault.fold_deg);
    return API_OK;
}

enum api_problem_id prepared_surface_make(const struct api_request *request,
                                          const struct api_limits *limits, struct arena *arena,
                                          struct drape_part *part, struct api_problem *problem) {
    const struct prepared_part *ready = prepared_form_part(request);
    if (request->surface.kind != API_SURFACE_NURBS)
        return api_problem_add(problem, "/surface", "must be the definition of a NURBS surface");
    if (ready)
        *part = ready->part;
    else if (make_moved(request, arena, part, problem) != API_OK)
        return problem->id;
    double nodes = least_nodes(&request->settings, usable_area(part->trim, part->surface));
    return prepared_surface_check_nodes(nodes, "the surface", limits, problem);
}

enum api_problem_id prepared_surface_make_whole(const struct api_surface *definition,
                                                struct arena *arena, struct drape_part *part,
                                                struct api_problem *problem) {
    struct surface *surface;
    struct trim *trim;
    if (definition->kind != API_SURFACE_NURBS)
        return api_problem_add(problem, "", "must be the definition of a NURBS surface");
    if (make_trimmed(definition, "", 0, arena, &surface, &trim, problem) == API_OK)
        *part = (struct drape_part){.surface = surface, .trim = trim};
    return problem->id;
}

enum api_problem_id prepared_surface_check_nodes(double nodes, const char *what,
                                                 const struct api_limits *limits,
                                                 struct api_problem *problem) {
    if (nodes <= (double)limits->max_nodes)
        return API_OK;
    return api_problem_add(problem, "/fabric/spacing",
                           "is too small: covering %s takes about %.3g nodes, and %zu are allowed",
                           what, nodes, limits->max_nodes);
}

enum api_problem_id prepared_surface_describe(const struct api_surface *definition,
                                              const struct drape_part *part, struct api_text *text,
                                              struct arena *arena, struct api_problem *problem) {
    const struct nurbs *nurbs = &definition->nurbs;
    struct drape_part made = *part;
    struct surface_measure size;
    if (!made.surface && definition->trim_count == 0) {
        if (check_made(surface_measure(nurbs, arena, &size), "", problem) != API_OK)
            return problem->id;
    } else {
        if (!made.surface &&
            prepared_surface_make_whole(definition, arena, &made, problem) != API_OK)
            return problem->id;
        size.area = usable_area(made.trim, made.surface);
        bounds_tight(made.surface, &size.lower, &size.upper);
        for (int k = 0; k < 2; k++)
            size.closed[k] = surface_closed(made.surface, k);
    }
    api_text_key_integer(text, "degree_u", nurbs->u.degree);
    api_text_key_integer(text, "degree_v", nurbs->v.degree);
    api_text_key_integer(text, "size_u", nurbs->u.size);
    api_text_key_integer(text, "size_v", nurbs->v.size);
    api_text_key_boolean(text, "rational", nurbs->weights != NULL);
    api_text_key_boolean(text, "closed_u", size.closed[0]);
    api_text_key_boolean(text, "closed_v", size.closed[1]);
    api_text_box(text, &size.lower.x, &size.upper.x);
    api_text_key_number(text, "area", size.area);
    return API_OK;
}
