/* SPDX-License-Identifier: MIT */
#include "run.h"

#include "api/json/value.h"
#include "api/request/decode.h"
#include "api/request/digest.h"
#include "api/request/prepared_part.h"
#include "api/result/columns.h"
#include "api/result/fields.h"
#include "api/result/warnings.h"
#include "refusal.h"
#include "solver/mesh/mesh.h"
#include "threads.h"
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

bool api_prepare(void) {
    return json_tree_prepare() && api_digest_prepare();
}

static double now_ms(void) {
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec * 1e3 + (double)now.tv_nsec * 1e-6;
}

/* ---- what to do instead ---- */

/* The place of the part that is nearest to a point, and its distance; false without memory. */
static bool find_nearest_start(const struct drape_part *part, const struct api_surface *definition,
                               struct vec3 point, struct arena *arena, struct vec3 *at,
                               double *distance) {
    if (part->mesh) {
        struct mesh_point place;
        bool found = mesh_nearest(part->mesh, point, MESH_ANY, &place, distance);
        *at = place.r;
        return found;
    }
    const struct shell_patch patch = {
        .surface = part->surface, .loops = definition->trims, .loop_count = definition->trim_count};
    struct shell *own = NULL;
    if (!part->shell && shell_make_lenient(&patch, 1, 0, arena, &own) != STATUS_OK)
        return false;
    const struct shell *shell = part->shell ? part->shell : own;
    struct surface_cursor cursor = {0};
    struct surface_jet jet;
    struct shell_point place;
    shell_nearest(shell, point, SHELL_ANY, &place, distance);
    surface_evaluate(shell_surface(shell, place.face), &cursor, place.uv[0], place.uv[1], &jet);
    *at = jet.r;
    return true;
}

/* Where the start could be instead. */
static enum api_problem_id refuse_start(const struct api_request *request,
                                        const struct drape_part *part, struct arena *arena,
                                        struct api_problem *problem) {
    const struct drape_settings *settings = &request->settings;
    const char *unit = request->length_unit->name;
    bool by_uv = settings->start_kind == DRAPE_START_UV;
    struct vec3 point = settings->start_point, at;
    double distance;
    if (by_uv && !part->mesh) {
        struct surface_cursor cursor = {0};
        struct surface_jet jet;
        const struct surface *surface =
            part->shell ? shell_surface(part->shell, settings->start_face) : part->surface;
        surface_evaluate(surface, &cursor, settings->start_uv[0], settings->start_uv[1], &jet);
        point = jet.r;
    }
    if (!find_nearest_start(part, &request->surface, point, arena, &at, &distance))
        return api_problem_set_at(problem, API_START_OFF_SURFACE, "/start",
                                  "must be on the surface, or within the spacing of it");
    return api_problem_set_at(
        problem, API_START_OFF_SURFACE, "/start",
        "must be on the surface%s: it is %.4g %s away from (%.6g, %.6g, %.6g), the nearest point",
        by_uv ? ", not where it is cut away" : ", or within the spacing of it", distance, unit,
        at.x, at.y, at.z);
}

/* A net without a cell tells nothing. Refused with a spacing that makes some, which is tried. */
static enum api_problem_id refuse_no_cell(const struct api_request *request,
                                          const struct drape_part *part,
                                          const struct drape_monitor *monitor, double area,
                                          struct arena *arena, struct api_problem *problem) {
    enum { TRIES = 6, NODES_MOST = 10000 };
    const char *unit = request->length_unit->name;
    struct drape_settings settings = request->settings;
    settings.max_nodes = settings.max_nodes < NODES_MOST ? settings.max_nodes : NODES_MOST;
    double spacing = fmin(warnings_fine_spacing(area), settings.spacing[0]);
    spacing = warnings_two_digits(fmin(spacing, settings.spacing[1]));
    for (int k = 0; k < TRIES; k++, spacing = warnings_two_digits(spacing / 2)) {
        struct drape_result finer = {0};
        struct arena_mark mark = arena_mark(arena);
        settings.spacing[0] = settings.spacing[1] = spacing;
        enum status status = drape_solve(part, &settings, monitor, arena, &finer);
        size_t cells = finer.cells.count;
        arena_rewind(arena, mark);
        if (status == STATUS_CANCELLED)
            return refusal_of_status(problem, status, &settings, 0);
        if (status == STATUS_OK && cells > 0)
            return api_problem_set_at(problem, API_INVALID_REQUEST, "/fabric/spacing",
                                      "is so large that the net has no cell: a spacing of %.2g %s "
                                      "gives %zu",
                                      spacing, unit, cells);
    }
    return api_problem_set_at(problem, API_INVALID_REQUEST, "/fabric/spacing",
                              "gives a net without a cell, and so does one of %.2g %s: move the "
                              "start, or turn the direction",
                              2 * spacing, unit);
}

static void summarise(const struct api_request *request, const struct drape_result *result,
                      double solve_ms, struct api_summary *summary) {
    const struct drape_summary *s = &result->summary;
    *summary = (struct api_summary){
        .outcome = s->outcome,
        .nodes = result->nodes.count,
        .cells = result->cells.count,
        .coverage = s->coverage,
        .cloth_coverage = s->cloth_coverage,
        .part_area = s->part_area,
        .cloth_area = s->cloth_area,
        .flat_area = s->flat_area,
        .max_shear_deg = s->max_shear_deg,
        .max_shear_at = {s->max_shear_at[0], s->max_shear_at[1], s->max_shear_point.x,
                         s->max_shear_point.y, s->max_shear_point.z},
        .max_shear_pinned_deg = s->max_shear_pinned_deg,
        .max_shear_grown_deg = s->max_shear_grown_deg,
        .grown_area = s->grown_area,
        .p95_shear_deg = s->p95_shear_deg,
        .mean_shear_deg = s->mean_shear_deg,
        .locked_cells = api_fields_count(COLUMN_CELLS_locked, request, &result->cells),
        .severity_max = api_fields_most(COLUMN_CELLS_severity, request, &result->cells),
        .packing_exceeded_cells =
            api_fields_count(COLUMN_CELLS_packing_exceeded, request, &result->cells),
        .steering = result->steering,
        .residual_max = s->residual_max,
        .newton_iterations_mean = s->newton_iterations_mean,
        .error_estimate_max = s->error_estimate_max,
        .max_shear_error_deg = s->max_shear_error_deg,
        .thickness_error_max = api_fields_thickness_error(request, &result->nodes),
        .solve_ms = solve_ms,
        .solver_version = DRAPE_VERSION,
    };
    vec3_to_columns(result->start_zero, &summary->start_axes[0], &summary->start_axes[1],
                    &summary->start_axes[2], 0);
    vec3_to_columns(result->start_side, &summary->start_axes[3], &summary->start_axes[4],
                    &summary->start_axes[5], 0);
    memcpy(summary->front_reasons, s->front_reasons, sizeof summary->front_reasons);
    /* The fibres keep their volume; the ply has that of its unsheared area, or fills the cavity. */
    const struct api_fabric *fabric = &request->fabric;
    double ply = summary->flat_area * fabric->plies * fabric->thickness;
    double fraction = fabric->fiber_volume_fraction;
    bool given = ply > 0 && fraction > 0, rigid = request->cavity.rigid;
    double whole = rigid ? summary->cloth_area * request->cavity.height : ply;
    summary->fiber_volume = given ? fraction * ply : -1;
    summary->pore_volume = given ? fmax(whole - fraction * ply, 0) : -1;
    double limit_deg[2];
    verdict_shear_limits(request, limit_deg);
    struct verdict_case judged = verdict_case_of(result, limit_deg);
    judged.packed_cells = summary->packing_exceeded_cells;
    judged.remedy =
        "another start or direction may do (a study finds it), else cut the cloth there";
    verdict_judge(&judged, &summary->verdict);
}

/* What the header of a result tells beside its summary. */
static void make_header(const struct api_request *request, const struct drape_result *result,
                        bool on_faces, struct api_columns *header) {
    const struct drape_settings *settings = &request->settings;
    const struct drape_zero *zero = &settings->zero;
    *header = (struct api_columns){
        .grid = {.warp = {result->warp_range[0], result->warp_range[1]},
                 .weft = {result->weft_range[0], result->weft_range[1]},
                 .spacing = {settings->spacing[0], settings->spacing[1]}},
        .start = {.face = on_faces ? result->start_face : -1,
                  .uv = {result->start_uv[0], result->start_uv[1]},
                  .point = result->start_point,
                  .warp = result->start_warp,
                  .weft = result->start_weft},
        .unit = request->length_unit,
        .cut_count = settings->cut_count,
    };
    if (zero->kind == DRAPE_ZERO_ROSETTE) {
        header->start.zero = result->start_zero;
        header->start.rosette =
            (struct api_rosette){request->rosette_origin, zero->x,
                                 vec3_norm2(zero->z) > 0 ? zero->z : result->start_side};
    }
    for (size_t k = 0; k < header->cut_count; k++)
        memcpy(header->cut_names[k], request->cut_names[k], sizeof header->cut_names[k]);
}

enum api_problem_id api_run_in(struct arena *arena, const struct api_input *input,
                               const struct api_limits *limits, const struct drape_monitor *monitor,
                               const struct api_sink *sink, struct api_problem *problem) {
    struct api_request request;
    struct drape_result result = {0};
    if (api_decode(input, limits, arena, &request, problem) != API_OK)
        return problem->id;
    if (request.surface.kind == API_SURFACE_NAMED)
        return api_problem_add(problem, "/surface/id", "no surface is stored under this id");
    struct prepared_part prepared;
    if (prepared_part_make(&request, limits, arena, &prepared, problem) != API_OK)
        return problem->id;
    const struct drape_part *part = &prepared.part;
    if (prepared_part_settle(&prepared, arena, &request.settings, problem) != API_OK)
        return problem->id;
    struct api_threads threads;
    request.settings.team = api_threads_make(&threads, limits->threads);
    double begin = now_ms();
    enum status status = drape_solve(part, &request.settings, monitor, arena, &result);
    double solve_ms = now_ms() - begin;
    if (part->shell && status == STATUS_START_OFF_SURFACE)
        prepared_shell_name_left_out(&request, &prepared.shell, arena, problem);
    if (status == STATUS_START_OFF_SURFACE && problem->id == API_OK)
        return refuse_start(&request, part, arena, problem);
    if (refusal_of_status(problem, status, &request.settings, &result) != API_OK)
        return problem->id;
    if (result.cells.count == 0 && !request.settings.has_extent[0] &&
        !request.settings.has_extent[1])
        return refuse_no_cell(&request, part, monitor, result.summary.part_area, arena, problem);
    /* Faces by their numbers in the request's surface, where the shell has a part of them. */
    const int32_t *numbers = prepared.shell.numbers;
    struct shell_apart apart = {.distance = HUGE_VAL};
    if (prepared.shell.shell) {
        if (shell_nearest_apart(part->shell, result.start_face, arena, &apart) != STATUS_OK)
            return api_problem_no_memory(problem, "the drape");
        apart.face = numbers[apart.face];
        result.start_face = numbers[result.start_face];
        for (size_t k = 0; result.nodes.face && k < result.nodes.count; k++)
            result.nodes.face[k] = numbers[result.nodes.face[k]];
        for (size_t k = 0; result.rim.face && k < result.rim.count; k++)
            result.rim.face[k] = numbers[result.rim.face[k]];
    }
    size_t components = part->mesh    ? part->mesh->component_count
                        : part->shell ? shell_component_count(part->shell)
                                      : 1;
    const struct warnings_subject subject = {&request, &result, &prepared, components, &apart};
    struct api_fields fields;
    struct api_columns header;
    make_header(&request, &result, part->shell, &header);
    summarise(&request, &result, solve_ms, &header.summary);
    warnings_make(&subject, &header.summary);
    if (api_fields_list(&fields, &request, &result, arena) != STATUS_OK)
        return api_problem_no_memory(problem, "the drape");
    return api_columns_write(&header, fields.source, fields.count, sink, arena, problem);
}

enum api_problem_id api_run(const struct api_input *input, const struct api_limits *limits,
                            const struct drape_monitor *monitor, const struct api_sink *sink,
                            struct api_problem *problem) {
    struct arena *arena = arena_new(limits->max_memory);
    if (!arena)
        return api_problem_no_memory(problem, "the drape");
    enum api_problem_id id = api_run_in(arena, input, limits, monitor, sink, problem);
    arena_free(arena);
    return id;
}
