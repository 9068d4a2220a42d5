/* SPDX-License-Identifier: MIT */
#include "api/request/digest.h"
#include "api/request/prepared_part.h"
#include "laminate.h"
#include "solver/mesh/mesh.h"
#include <stdio.h>
#include <string.h>

/* How finely a loop in the parameters is followed in space, as a share of the domain. */
static const double step_share = 1.0 / 256;

void laminate_fault_of_ply(const struct laminate *laminate, size_t k, const struct api_problem *own,
                           struct api_problem *problem) {
    for (size_t n = 0; n < own->count; n++) {
        const struct api_problem_error *error = &own->error[n];
        bool common = strncmp(error->pointer, "/surface", 8) == 0 ||
                      strncmp(error->pointer, "/rosette", 8) == 0;
        bool moved = strcmp(error->pointer, "/offset") == 0;
        char pointer[API_POINTER_MAX];
        (void)snprintf(pointer, sizeof pointer, "/plies/%zu%.100s", k, moved ? "" : error->pointer);
        if (common)
            (void)snprintf(pointer, sizeof pointer, "%s", error->pointer);
        if (own->id == API_INVALID_REQUEST)
            api_problem_add(problem, pointer, "ply %zu (\"%s\"): %s", k + 1,
                            laminate->plies[k].name, error->detail);
        else
            api_problem_set_at(problem, own->id, pointer, "ply %zu (\"%s\"): %s", k + 1,
                               laminate->plies[k].name, error->detail);
    }
}

/* ---- the surface that boundaries are on, made when first asked for ---- */

struct boundary_surface {
    struct laminate *laminate;
    const struct api_limits *limits;
    struct arena *arena;
    struct api_problem *problem;
    bool made;
    struct prepared_part shape;
};

/* ---- loops in space ---- */

/* A loop of the surface's parameters as points in space, its edges cut finely. */
static bool follow_on_surface(const struct surface *surface, const double (*uv)[2], size_t count,
                              struct arena *arena, struct laminate_loop *loop) {
    double lower[2], upper[2];
    struct surface_cursor cursor = {0, 0};
    size_t total = 0, *pieces = arena_alloc(arena, count, sizeof *pieces);
    if (!pieces)
        return false;
    surface_domain(surface, lower, upper);
    for (size_t k = 0; k < count; k++) {
        const double *a = uv[k], *b = uv[(k + 1) % count];
        double share = fmax(fabs(b[0] - a[0]) / (upper[0] - lower[0]),
                            fabs(b[1] - a[1]) / (upper[1] - lower[1]));
        pieces[k] = 1 + (size_t)fmin(share / step_share, 1e4);
        total += pieces[k];
    }
    struct vec3 *points = arena_alloc(arena, total, sizeof *points);
    for (size_t k = 0; points && k < count; k++)
        for (size_t n = 0; n < pieces[k]; n++) {
            const double *a = uv[k], *b = uv[(k + 1) % count];
            double share = (double)n / (double)pieces[k], at[2];
            struct surface_jet jet;
            for (int x = 0; x < 2; x++)
                at[x] = fmin(fmax(a[x] + share * (b[x] - a[x]), lower[x]), upper[x]);
            surface_evaluate(surface, &cursor, at[0], at[1], &jet);
            points[loop->count++] = jet.r;
        }
    loop->points = points;
    return points != NULL;
}

/* The loops of trims in space; where all of them cut away, with the domain's own edge about them.
 */
static enum api_problem_id loops_of_trims(struct boundary_surface *on, struct laminate_ply *ply,
                                          struct trim *trim) {
    struct laminate_boundary *boundary = &ply->boundary;
    struct laminate_loop *loops = arena_alloc(on->arena, boundary->trim_count + 1, sizeof *loops);
    double low[2], high[2];
    bool keeps = false, good = loops != NULL;
    for (size_t k = 0; k < boundary->trim_count; k++)
        keeps = keeps || boundary->trims[k].reversed;
    surface_domain(on->shape.part.surface, low, high);
    const double edge[4][2] = {
        {low[0], low[1]}, {high[0], low[1]}, {high[0], high[1]}, {low[0], high[1]}};
    boundary->count = 0;
    if (good && !keeps)
        good = follow_on_surface(on->shape.part.surface, edge, 4, on->arena,
                                 &loops[boundary->count++]);
    for (size_t k = 0; good && k < boundary->trim_count; k++) {
        const double(*points)[2];
        size_t count = trim_loop_points(trim, k, &points);
        /* Its last point is its first. */
        good = follow_on_surface(on->shape.part.surface, points, count > 1 ? count - 1 : count,
                                 on->arena, &loops[boundary->count++]);
    }
    boundary->loops = loops;
    boundary->trim_count = 0;
    return good ? API_OK : api_problem_no_memory(on->problem, "the laminate");
}

/* ---- starts ---- */

/* The centroid of what a loop spans, by its vector area. */
static struct vec3 centre_of(const struct laminate_loop *loop) {
    struct vec3 mean = {0, 0, 0}, area = {0, 0, 0}, moment = {0, 0, 0};
    double whole = 0;
    for (size_t k = 0; k < loop->count; k++)
        mean = vec3_axpy(1 / (double)loop->count, loop->points[k], mean);
    for (int pass = 0; pass < 2; pass++)
        for (size_t k = 0; k < loop->count; k++) {
            struct vec3 a = vec3_sub(loop->points[k], mean);
            struct vec3 b = vec3_sub(loop->points[(k + 1) % loop->count], mean);
            struct vec3 cross = vec3_cross(a, b);
            if (pass == 0) {
                area = vec3_add(area, cross);
                continue;
            }
            double part = vec3_dot(cross, area);
            whole += part;
            moment = vec3_axpy(part / 3, vec3_add(a, b), moment);
        }
    return whole > 0 ? vec3_axpy(1 / whole, moment, mean) : mean;
}

/* Lets the ply start at the place nearest to the point. */
static void start_near(const struct boundary_surface *on, struct vec3 point,
                       struct api_request *drape) {
    struct drape_settings *settings = &drape->settings;
    double distance;
    if (on->shape.part.mesh) {
        struct mesh_point place;
        if (!mesh_nearest(on->shape.part.mesh, point, MESH_ANY, &place, &distance))
            return;
        settings->start_kind = DRAPE_START_POINT;
        settings->start_point = place.r;
    } else if (on->shape.part.shell) {
        struct shell_point place;
        shell_nearest(on->shape.part.shell, point, SHELL_ANY, &place, &distance);
        settings->start_kind = DRAPE_START_UV;
        settings->start_face = on->shape.shell.numbers[place.face];
        drape->start_on_face = true;
        memcpy(settings->start_uv, place.uv, sizeof settings->start_uv);
    } else {
        double uv[2];
        surface_nearest(on->shape.part.surface, point, uv, &distance);
        if (on->shape.part.trim && !trim_contains(on->shape.part.trim, uv))
            return;
        settings->start_kind = DRAPE_START_UV;
        memcpy(settings->start_uv, uv, sizeof settings->start_uv);
    }
}

static enum api_problem_id resolve_ply(struct boundary_surface *on, size_t k) {
    struct laminate_ply *ply = &on->laminate->plies[k];
    struct laminate_boundary *boundary = &ply->boundary;
    bool starts = ply->drape.settings.start_kind == DRAPE_START_CENTROID;
    bool known = on->laminate->surface.kind != API_SURFACE_NAMED;
    if (boundary->trim_count == 0 && (boundary->count == 0 || !starts || !known))
        return API_OK;
    if (!on->made) {
        /* Whether a net fits is another question, asked for each ply. */
        struct api_request request = on->laminate->plies[0].drape;
        request.offset = 0;
        request.settings.has_extent[0] = request.settings.has_extent[1] = true;
        request.settings.extent[0][0] = request.settings.extent[0][1] = 0;
        request.settings.extent[1][0] = request.settings.extent[1][1] = 0;
        request.settings.start_kind = DRAPE_START_CENTROID;
        if (prepared_part_make(&request, on->limits, on->arena, &on->shape, on->problem) != API_OK)
            return on->problem->id;
        on->made = true;
    }
    if (boundary->trim_count == 0) {
        start_near(on, centre_of(&boundary->loops[0]), &ply->drape);
        return API_OK;
    }
    char pointer[API_POINTER_MAX];
    struct trim *trim = NULL;
    (void)snprintf(pointer, sizeof pointer, "/plies/%zu/boundary/trims", k);
    if (!on->shape.part.surface)
        return api_problem_add(on->problem, pointer,
                               "need a part of one NURBS surface, in whose parameters they are: "
                               "give a polygon instead");
    enum status status =
        trim_make(on->shape.part.surface, boundary->trims, boundary->trim_count, on->arena, &trim);
    if (status == STATUS_OUT_OF_MEMORY)
        return api_problem_no_memory(on->problem, "the laminate");
    if (status != STATUS_OK)
        return api_problem_add(on->problem, pointer, "leave no area of the ply");
    if (starts) {
        ply->drape.settings.start_kind = DRAPE_START_UV;
        trim_middle(trim, ply->drape.settings.start_uv);
    }
    return loops_of_trims(on, ply, trim);
}

enum api_problem_id laminate_resolve(struct laminate *laminate, const struct api_limits *limits,
                                     struct arena *arena, struct api_problem *problem) {
    struct boundary_surface on = {
        .laminate = laminate, .limits = limits, .arena = arena, .problem = problem};
    char id[API_ID_SIZE];
    for (size_t k = 0; k < laminate->count; k++)
        if (resolve_ply(&on, k) != API_OK)
            return problem->id;
    /* Which plies share a drape. */
    size_t *net_ply = arena_alloc(arena, laminate->count, sizeof *net_ply);
    laminate->net_digest = arena_alloc(arena, laminate->count, sizeof *laminate->net_digest);
    laminate->net_ply = net_ply;
    if (!net_ply || !laminate->net_digest || !api_digest_surface(&laminate->surface, arena, id))
        return api_problem_no_memory(problem, "the laminate");
    for (size_t k = 0; k < laminate->count; k++) {
        struct laminate_ply *ply = &laminate->plies[k];
        struct api_request named = laminate_drape(laminate, k);
        char digest[API_ID_SIZE];
        memcpy(named.surface.id, id, sizeof id);
        if (!api_digest_request(&named, arena, digest))
            return api_problem_no_memory(problem, "the laminate");
        for (ply->net = 0; ply->net < laminate->net_count; ply->net++)
            if (memcmp(laminate->net_digest[ply->net], digest, sizeof digest) == 0)
                break;
        if (ply->net < laminate->net_count)
            continue;
        memcpy(laminate->net_digest[laminate->net_count], digest, sizeof digest);
        net_ply[laminate->net_count++] = k;
    }
    return API_OK;
}
