/* SPDX-License-Identifier: MIT */
/*
 * A shell that is a tube is cut open opposite the start, as a surface that is closed one way is
 * (`surface_point_zone`): the cloth that has gone round it from both sides meets there. Where that
 * is, is found on a coarse mesh of it (`mesh/tube_cut.h`).
 */
#include "march.h"

#include "solver/mesh/tessellation.h"
#include "solver/mesh/tube_cut.h"
#include <string.h>

/* Triangles of the mesh have sides of about sqrt(area / squares); more of them than this are too
 * many. */
static const double squares = 1500;
static const size_t triangles_most = 1000000;

/* Beyond the ends of the tube the cut goes on for so many times its size: further than ghosts are
 * away from it. */
static const double beyond = 1;

/* In spacings: no further apart are places of which it is asked whether it lies between. */
static const double longest_way = 2.2;

/* Pieces of the cut shorter than this share of the triangles' sides say little of where it leads.
 */
static const double least_piece = 0.1;

/* Parts of the cut while they are made of slits. */
struct parts {
    struct shell_slit_piece *part;
    double (*uv)[2];
    size_t count, used; /* parts, and points of uv */
    double least;       /* length of a piece */
    struct vec3 r[2];   /* the last two points of the last part */
};

/* The place of a slit's end in the inner parameters of its triangle's face. */
static void parameters_of(const struct shell *shell, const struct mesh *mesh, int32_t half,
                          double share, double uv[2]) {
    const struct surface *surface = shell_surface(shell, mesh->faces[half / 3]);
    double from[2], to[2];
    surface_inner(surface, mesh->parameters[mesh->corners[half / 3][half % 3]], from);
    surface_inner(surface, mesh->parameters[mesh->corners[half / 3][(half + 1) % 3]], to);
    for (int k = 0; k < 2; k++)
        uv[k] = from[k] + share * (to[k] - from[k]);
}

static struct vec3 point_at(const struct shell *shell, int32_t face, const double uv[2]) {
    struct surface_cursor cursor = {0};
    struct surface_jet jet;
    surface_jet_at(shell_surface(shell, face), &cursor, uv[0], uv[1], &jet);
    return jet.r;
}

/* Whether the last part goes on on a face at uv: not over a joint, nor over the seam of a closed
 * direction. */
static bool goes_on(const struct shell *shell, const struct parts *parts, int32_t face,
                    const double uv[2]) {
    const struct shell_slit_piece *last = &parts->part[parts->count - 1];
    if (last->ends || last->face != face)
        return false;
    for (int k = 0; k < 2; k++) {
        const struct surface_axis *axis = &shell_surface(shell, face)->axis[k];
        double length = surface_axis_upper(axis) - surface_axis_lower(axis);
        if (fabs(last->uv[last->count - 1][k] - uv[k]) > length / 2)
            return false;
    }
    return true;
}

/* Adds a point to the last part, in place of its last one where that is next to the one before. */
static void add_point(const struct shell *shell, struct parts *parts, const double uv[2]) {
    struct shell_slit_piece *part = &parts->part[parts->count - 1];
    bool replaces = part->count >= 2 && vec3_distance(parts->r[0], parts->r[1]) < parts->least;
    part->count -= replaces;
    parts->used -= replaces;
    parts->r[0] = replaces ? parts->r[0] : parts->r[1];
    parts->r[1] = point_at(shell, part->face, uv);
    if (part->count > 0 && vec3_distance(parts->r[0], parts->r[1]) == 0)
        return;
    memcpy(part->uv[part->count++], uv, sizeof *part->uv);
    parts->used++;
}

/* By whole turns as near to `to` as can be: at the seam of a closed direction both its ends are one
 * place. */
static void turn_towards(const struct surface *surface, const double to[2], double uv[2]) {
    for (int k = 0; k < 2; k++) {
        const struct surface_axis *axis = &surface->axis[k];
        double length = surface_axis_upper(axis) - surface_axis_lower(axis);
        if (axis->closed)
            uv[k] -= length * round((uv[k] - to[k]) / length);
    }
}

/* A new part, which begins where the last one of its line ends. */
static void begin_part(const struct shell *shell, struct parts *parts, int32_t face,
                       const double uv[2], bool begins) {
    const struct shell_slit_piece *last = begins ? NULL : &parts->part[parts->count - 1];
    const struct surface *surface = shell_surface(shell, face);
    double from[2] = {uv[0], uv[1]};
    if (last) {
        struct vec3 end = point_at(shell, last->face, last->uv[last->count - 1]);
        (void)surface_nearest_from(surface, end, from);
        turn_towards(surface, uv, from);
    }
    parts->part[parts->count++] =
        (struct shell_slit_piece){.face = face, .uv = parts->uv + parts->used, .begins = begins};
    add_point(shell, parts, from);
}

/* Ends the last part: one of one point, where the line touches a face, is left out, and so is a
 * point next to its end. */
static void end_part(struct parts *parts) {
    struct shell_slit_piece *last = &parts->part[parts->count - 1];
    if (last->count >= 3 && vec3_distance(parts->r[0], parts->r[1]) < parts->least) {
        last->count--;
        parts->used--;
        memcpy(last->uv[last->count - 1], last->uv[last->count], sizeof *last->uv);
    }
    if (last->count >= 2 || last->begins)
        return;
    parts->used -= last->count;
    parts->count--;
}

static void add_slit(const struct shell *shell, const struct mesh *mesh, struct parts *parts,
                     const struct mesh_slit *slit, bool begins) {
    int32_t face = mesh->faces[slit->half[0] / 3];
    double from[2], to[2];
    parameters_of(shell, mesh, slit->half[0], slit->share[0], from);
    parameters_of(shell, mesh, slit->half[1], slit->share[1], to);
    if (begins || !goes_on(shell, parts, face, from)) {
        if (!begins)
            end_part(parts);
        begin_part(shell, parts, face, from, begins);
    }
    add_point(shell, parts, to);
}

static enum status make_cut(struct march *march, const struct mesh *mesh, double size,
                            const struct mesh_tube_cuts *cuts) {
    const struct shell *shell = march->surface->shell;
    size_t slits = cuts->from[cuts->count];
    const double *d = march->settings->spacing;
    struct parts parts = {
        .part = arena_alloc(march->arena, slits, sizeof *parts.part),
        .uv = arena_alloc(march->arena, 2 * slits, sizeof *parts.uv),
        .least = least_piece * size,
    };
    struct shell_slit *slit;
    if (!parts.part || !parts.uv)
        return STATUS_OUT_OF_MEMORY;
    for (size_t n = 0; n < cuts->count; n++) {
        for (size_t k = cuts->from[n]; k < cuts->from[n + 1]; k++)
            add_slit(shell, mesh, &parts, &cuts->slits[k], k == cuts->from[n]);
        end_part(&parts);
        parts.part[parts.count - 1].ends = true;
    }
    enum status status = shell_slit_make(shell, parts.part, parts.count, beyond * shell_size(shell),
                                         longest_way * fmax(d[0], d[1]), march->arena, &slit);
    march->cut.slit = status == STATUS_OK ? slit : NULL;
    return status;
}

/* A closed direction of one face is cut opposite the start; one that the trims leave bare somewhere
 * is cut there, where the cut parts nothing. */
static enum status place_cuts(struct march *march) {
    const struct surface *surface = march->surface;
    const struct trim *trim = march->trim;
    for (int k = 0; k < 2; k++) {
        double half = surface_point_cut_turn(surface, k), start = march->start.point.uv[k], bare;
        bool found = false;
        march->cut.centre[k] = start;
        if (trim && half < HUGE_VAL &&
            trim_bare_line(trim, surface, k, march->arena, &found, &bare) != STATUS_OK)
            return STATUS_OUT_OF_MEMORY;
        if (!found)
            continue;
        double cut = surface_axis_inner(&surface->axis[k], bare);
        march->cut.centre[k] = cut + half * (2 * floor((start - cut) / (2 * half)) + 1);
    }
    return STATUS_OK;
}

static enum status open_tube(struct march *march) {
    const struct surface *surface = march->surface;
    struct mesh *mesh;
    struct mesh_point place;
    struct mesh_tube_cuts cuts;
    if (!shell_may_be_tube(surface->shell, surface->face))
        return STATUS_OK;
    double size = sqrt(march_area(march) / squares);
    enum status status =
        mesh_from_shell(surface->shell, surface->face, size, triangles_most, march->arena, &mesh);
    if (status == STATUS_OUT_OF_MEMORY)
        return status;
    if (status != STATUS_OK ||
        !mesh_nearest(mesh, march->start.point.jet.r, MESH_ANY, &place, NULL))
        return STATUS_OK;
    status = mesh_find_tube_cuts(mesh, &place, march->arena, &cuts);
    return status == STATUS_OK && cuts.count > 0 ? make_cut(march, mesh, size, &cuts) : status;
}

enum status march_open(struct march *march) {
    return march->surface->shell ? open_tube(march) : place_cuts(march);
}
