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

/* Edges of the cut shorter than this share of the triangles' sides say little of where it leads.
 */
static const double least_piece = 0.1;

/* The pieces of the cut, each on one face, while they are made of the slits in the mesh. */
struct cut_pieces {
    const struct shell *shell;
    const struct mesh *mesh;
    struct shell_slit_piece *piece;
    double (*uv)[2];
    size_t count, used; /* pieces, and points of uv */
    double least;       /* length of an edge */
    struct vec3 r[2];   /* the last two points of the last piece */
};

/* The place of a slit's end in the inner parameters of its triangle's face. */
static void slit_parameters(const struct cut_pieces *p, int32_t half, double share, double uv[2]) {
    const struct mesh *mesh = p->mesh;
    const struct surface *surface = shell_surface(p->shell, mesh->faces[half / 3]);
    double from[2], to[2];
    surface_inner(surface, mesh->parameters[mesh->corners[half / 3][half % 3]], from);
    surface_inner(surface, mesh->parameters[mesh->corners[half / 3][(half + 1) % 3]], to);
    for (int k = 0; k < 2; k++)
        uv[k] = from[k] + share * (to[k] - from[k]);
}

static struct vec3 point_on_face(const struct shell *shell, int32_t face, const double uv[2]) {
    struct surface_cursor cursor = {0};
    struct surface_jet jet;
    surface_jet_at(shell_surface(shell, face), &cursor, uv[0], uv[1], &jet);
    return jet.r;
}

/* Adds a point to the last piece, in place of its last one where that is next to the one before. */
static void add_cut_point(struct cut_pieces *p, const double uv[2]) {
    struct shell_slit_piece *piece = &p->piece[p->count - 1];
    bool replaces = piece->count >= 2 && vec3_distance(p->r[0], p->r[1]) < p->least;
    piece->count -= replaces;
    p->used -= replaces;
    p->r[0] = replaces ? p->r[0] : p->r[1];
    p->r[1] = point_on_face(p->shell, piece->face, uv);
    if (piece->count > 0 && vec3_distance(p->r[0], p->r[1]) == 0)
        return;
    memcpy(piece->uv[piece->count++], uv, sizeof *piece->uv);
    p->used++;
}

/* Ends the last piece: one of one point, where the line touches a face, is left out, and so is a
 * point next to its end. */
static void end_piece(struct cut_pieces *p) {
    struct shell_slit_piece *last = &p->piece[p->count - 1];
    if (last->count >= 3 && vec3_distance(p->r[0], p->r[1]) < p->least) {
        last->count--;
        p->used--;
        memcpy(last->uv[last->count - 1], last->uv[last->count], sizeof *last->uv);
    }
    if (last->count >= 2 || last->begins)
        return;
    p->used -= last->count;
    p->count--;
}

/* A slit goes on from the last piece on the same face, but not over the seam of a closed direction.
 * A new piece begins where the last one of its line ends: at the seam, both ends of which are one
 * place, as near to the slit's end as whole turns can be. */
static void add_slit(struct cut_pieces *p, const struct mesh_slit *slit, bool begins) {
    int32_t face = p->mesh->faces[slit->half[0] / 3];
    double from[2], to[2];
    slit_parameters(p, slit->half[0], slit->share[0], from);
    slit_parameters(p, slit->half[1], slit->share[1], to);
    const struct shell_slit_piece *last = begins ? NULL : &p->piece[p->count - 1];
    bool goes_on = last && !last->ends && last->face == face;
    const struct surface *surface = shell_surface(p->shell, face);
    for (int k = 0; k < 2 && goes_on; k++) {
        const struct surface_axis *axis = &surface->axis[k];
        double length = surface_axis_upper(axis) - surface_axis_lower(axis);
        goes_on = !(fabs(last->uv[last->count - 1][k] - from[k]) > length / 2);
    }
    if (goes_on) {
        add_cut_point(p, to);
        return;
    }
    double start[2] = {from[0], from[1]};
    if (last) {
        end_piece(p);
        last = &p->piece[p->count - 1];
        struct vec3 end = point_on_face(p->shell, last->face, last->uv[last->count - 1]);
        (void)surface_nearest_from(surface, end, start);
    }
    for (int k = 0; k < 2 && last; k++) {
        const struct surface_axis *axis = &surface->axis[k];
        double length = surface_axis_upper(axis) - surface_axis_lower(axis);
        if (axis->closed)
            start[k] -= length * round((start[k] - from[k]) / length);
    }
    p->piece[p->count++] =
        (struct shell_slit_piece){.face = face, .uv = p->uv + p->used, .begins = begins};
    add_cut_point(p, start);
    add_cut_point(p, to);
}

static enum status open_tube(struct march *march) {
    const struct surface *surface = march->surface;
    const struct shell *shell = surface->shell;
    const double *d = march->settings->spacing;
    struct mesh *mesh;
    struct mesh_point place;
    struct mesh_tube_cuts cuts;
    struct shell_slit *slit = NULL;
    if (!shell_may_be_tube(shell, surface->face))
        return STATUS_OK;
    double size = sqrt(march_area(march) / squares);
    enum status status =
        mesh_from_shell(shell, surface->face, size, triangles_most, march->arena, &mesh);
    if (status == STATUS_OUT_OF_MEMORY)
        return status;
    if (status != STATUS_OK ||
        !mesh_nearest(mesh, march->start.point.jet.r, MESH_ANY, &place, NULL))
        return STATUS_OK;
    status = mesh_find_tube_cuts(mesh, &place, march->arena, &cuts);
    if (status != STATUS_OK || cuts.count == 0)
        return status;
    size_t slits = cuts.from[cuts.count];
    struct cut_pieces pieces = {.shell = shell,
                                .mesh = mesh,
                                .piece = arena_alloc(march->arena, slits, sizeof *pieces.piece),
                                .uv = arena_alloc(march->arena, 2 * slits, sizeof *pieces.uv),
                                .least = least_piece * size};
    if (!pieces.piece || !pieces.uv)
        return STATUS_OUT_OF_MEMORY;
    for (size_t n = 0; n < cuts.count; n++) {
        for (size_t k = cuts.from[n]; k < cuts.from[n + 1]; k++)
            add_slit(&pieces, &cuts.slits[k], k == cuts.from[n]);
        end_piece(&pieces);
        pieces.piece[pieces.count - 1].ends = true;
    }
    const struct shell_slit_lines lines = {.pieces = pieces.piece,
                                           .count = pieces.count,
                                           .reach = longest_way * fmax(d[0], d[1]),
                                           .beyond = beyond * shell_size(shell),
                                           .ahead = mesh->vertices,
                                           .ahead_count = mesh->vertex_count};
    status = shell_slit_make(shell, &lines, march->arena, &slit);
    march->cut.slit = status == STATUS_OK ? slit : NULL;
    return status;
}

/* A closed direction of one face is cut opposite the start; one that the trims leave bare somewhere
 * is cut there, where the cut divides nothing. */
enum status march_open(struct march *march) {
    const struct surface *surface = march->surface;
    const struct trim *trim = march->trim;
    if (surface->shell)
        return open_tube(march);
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
