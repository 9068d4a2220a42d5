/* SPDX-License-Identifier: MIT */
/*
 * A shell that is a tube is cut open opposite the start, as a surface that is closed one way is
 * (`surface_point_zone`): the cloth that has gone round it from both sides meets there. Where that
 * is, is found on a coarse mesh of it (`mesh/tube_cut.h`); exactly, however it is cut into faces,
 * where the part is its own mirror image about a plane through the start, as all turned parts are:
 * in that plane; and of other tubes along a line of curvature (`curvature_cut.h`), where there is
 * one. A shell that closes both ways, as a ring does, is cut open along two.
 */
#include "curvature_cut.h"

#include "solver/mesh/tessellation.h"
#include "solver/mesh/tube_cut.h"
#include <stdlib.h>
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

/* The mesh is right to this share of the triangles' sides. */
static const double mesh_error = 0.3;

/* Triangles that tell whether a part is its own mirror image; steps of Newton's method to a place.
 */
enum { MIRROR_SAMPLES = 64, ROUNDS = 4 };

/* Between two places of the cut it is looked for one between them, and so on so many times, where
 * it bends away from their chord by more than this, in spacings. */
enum { HALVINGS = 4, PER_EDGE = 1 << HALVINGS };
static const double bend_most = 0.002;

/* A line of curvature has so many steps along a triangle's side; it is no longer than so many times
 * the part's size, and its place opposite the start is no further from the mesh's cut than this
 * share of the girth. */
enum { STEPS_PER_SIDE = 4 };
static const double lengths_most = 4, off_most = 1.0 / 6;

/* A place of the cut: parameters of its face, the edge of the mesh it is on, and where it is. */
struct cut_place {
    double uv[2];
    struct vec3 edge, r;
};

/* The pieces of the cut, each on one face, while they are made of the slits in the mesh. */
struct cut_pieces {
    const struct shell *shell;
    const struct mesh *mesh;
    const struct surface_point *start;
    struct vec3 mirror; /* unit normal of the plane through the start about which the shell is its
                           own mirror image; zero: there is none */
    struct shell_slit_piece *piece;
    struct cut_place *place; /* of the pieces, one after the other */
    size_t count, used;      /* pieces, and places */
    double least;            /* length of an edge */
    double size;             /* of the triangles' sides */
    double bend;             /* away from a chord that is let be */
};

/* The place of a slit's end, by the inner parameters of its triangle's face. */
static struct cut_place slit_place(const struct cut_pieces *p, const struct mesh_slit *slit,
                                   int which) {
    const struct mesh *mesh = p->mesh;
    int32_t half = slit->half[which], triangle = half / 3;
    const struct surface *surface = shell_surface(p->shell, mesh->faces[triangle]);
    struct cut_place place;
    double from[2], to[2];
    surface_inner(surface, mesh->parameters[mesh->corners[triangle][half % 3]], from);
    surface_inner(surface, mesh->parameters[mesh->corners[triangle][(half + 1) % 3]], to);
    for (int k = 0; k < 2; k++)
        place.uv[k] = from[k] + slit->share[which] * (to[k] - from[k]);
    place.edge = vec3_sub(mesh_corner_point(mesh, triangle, (half + 1) % 3),
                          mesh_corner_point(mesh, triangle, half % 3));
    return place;
}

static struct vec3 point_on_face(const struct shell *shell, int32_t face, const double uv[2]) {
    struct surface_cursor cursor = {0};
    struct surface_jet jet;
    surface_jet_at(shell_surface(shell, face), &cursor, uv[0], uv[1], &jet);
    return jet.r;
}

/* The length of the last edge of the last piece. */
static double last_edge(const struct cut_pieces *p) {
    return vec3_distance(p->place[p->used - 1].r, p->place[p->used - 2].r);
}

/* Adds a place to the last piece, instead of its last one where that is next to the one before. */
static void add_cut_place(struct cut_pieces *p, const struct cut_place *place) {
    struct shell_slit_piece *piece = &p->piece[p->count - 1];
    bool replaces = piece->count >= 2 && last_edge(p) < p->least;
    piece->count -= replaces;
    p->used -= replaces;
    struct cut_place *added = &p->place[p->used];
    *added = *place;
    added->r = point_on_face(p->shell, piece->face, place->uv);
    bool moves = piece->count == 0 || vec3_distance(added[-1].r, added->r) > 0;
    piece->count += moves;
    p->used += moves;
}

/* Ends the last piece: one of one place, where the line touches a face, is left out, and so is a
 * place next to its end. */
static void end_piece(struct cut_pieces *p) {
    struct shell_slit_piece *last = &p->piece[p->count - 1];
    if (last->count >= 3 && last_edge(p) < p->least) {
        last->count--;
        p->used--;
        p->place[p->used - 1] = p->place[p->used];
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
    struct cut_place start = slit_place(p, slit, 0), to = slit_place(p, slit, 1);
    const double from[2] = {start.uv[0], start.uv[1]};
    const struct shell_slit_piece *last = begins ? NULL : &p->piece[p->count - 1];
    bool goes_on = last && !last->ends && last->face == face;
    const struct surface *surface = shell_surface(p->shell, face);
    for (int k = 0; k < 2 && goes_on; k++) {
        const struct surface_axis *axis = &surface->axis[k];
        double length = surface_axis_upper(axis) - surface_axis_lower(axis);
        goes_on = !(fabs(p->place[p->used - 1].uv[k] - from[k]) > length / 2);
    }
    if (goes_on) {
        add_cut_place(p, &to);
        return;
    }
    if (last) {
        end_piece(p);
        (void)surface_nearest_from(surface, p->place[p->used - 1].r, start.uv);
    }
    for (int k = 0; k < 2 && last; k++) {
        const struct surface_axis *axis = &surface->axis[k];
        double length = surface_axis_upper(axis) - surface_axis_lower(axis);
        if (axis->closed)
            start.uv[k] -= length * round((start.uv[k] - from[k]) / length);
    }
    p->piece[p->count++] = (struct shell_slit_piece){.face = face, .begins = begins};
    add_cut_place(p, &start);
    add_cut_place(p, &to);
}

/* ---- exactly ---- */

/* How far a place is from the plane of the mirror through the start. */
static double off_mirror(const struct cut_pieces *p, struct vec3 r) {
    return vec3_dot(vec3_sub(r, p->start->jet.r), p->mirror);
}

/* The middle of a triangle's parameters, on the surface. */
static struct vec3 middle_of_triangle(const struct cut_pieces *p, size_t triangle) {
    const struct mesh *mesh = p->mesh;
    double uv[2] = {0, 0}, inner[2];
    for (int n = 0; n < 3; n++) {
        surface_inner(shell_surface(p->shell, mesh->faces[triangle]),
                      mesh->parameters[mesh->corners[triangle][n]], inner);
        for (int k = 0; k < 2; k++)
            uv[k] += inner[k] / 3;
    }
    return point_on_face(p->shell, mesh->faces[triangle], uv);
}

/* Whether the shell is its own mirror image about the plane, by samples, and the cut in it. */
static bool is_mirror(const struct cut_pieces *p) {
    const struct surface_point *start = p->start;
    struct surface_cursor cursor = {0};
    size_t count = p->mesh->triangle_count, step = 1 + count / MIRROR_SAMPLES;
    for (size_t k = 0; k < p->used; k++)
        if (fabs(off_mirror(p, p->place[k].r)) > mesh_error * p->size)
            return false;
    for (size_t t = 0; t < count; t += step) {
        struct vec3 r = middle_of_triangle(p, t);
        struct surface_point image;
        double distance;
        r = vec3_axpy(-2 * off_mirror(p, r), p->mirror, r);
        if (!surface_point_nearest(start->surface, &cursor, r, &image, &distance) ||
            !(distance <= shell_joint_width(p->shell)))
            return false;
    }
    return true;
}

/* Such a plane is normal to a direction of principal curvature at the start. */
static void find_mirror(struct cut_pieces *p) {
    const struct surface_point *start = p->start;
    struct vec3 principal[2];
    for (int k = 0; k < 2 && surface_point_principal(start, principal); k++) {
        p->mirror = principal[k];
        if (is_mirror(p))
            return;
    }
    p->mirror = vec3_make(0, 0, 0);
}

/* Where the line on the surface, or an edge unless that is zero, that leads to the plane of the
 * mirror meets it. */
static bool find_place_in_mirror(struct cut_pieces *p, const struct surface *surface,
                                 struct vec3 edge, double uv[2]) {
    struct surface_cursor cursor = {0};
    struct surface_point point;
    for (int round = 0; round < ROUNDS; round++) {
        if (!surface_point_at(surface, &cursor, uv, &point))
            return false;
        struct vec3 line = vec3_norm2(edge) > 0 ? edge : p->mirror;
        line = vec3_axpy(-vec3_dot(line, point.normal), point.normal, line);
        double by = -off_mirror(p, point.jet.r) / vec3_dot(line, p->mirror);
        if (!surface_point_pull_on_face(&cursor, &point, vec3_scale(by, line), uv))
            return false;
    }
    return true;
}

/* Moves a place of the mesh's cut to where it is opposite the start exactly, along its edge unless
 * `freely`; false, and it stays where it is, when that cannot be found. */
static bool find_exact_place(struct cut_pieces *p, int32_t face, bool freely,
                             struct cut_place *place) {
    const struct surface *surface = shell_surface(p->shell, face);
    struct cut_place exact = *place;
    struct vec3 edge = freely ? vec3_make(0, 0, 0) : place->edge;
    bool found = vec3_norm2(p->mirror) > 0 && find_place_in_mirror(p, surface, edge, exact.uv);
    exact.r = point_on_face(p->shell, face, exact.uv);
    place->r = point_on_face(p->shell, face, place->uv);
    found = found && vec3_distance(exact.r, place->r) < mesh_error * p->size;
    *place = found ? exact : *place;
    return found;
}

static void add_piece_point(struct shell_slit_piece *piece, const struct cut_place *place) {
    memcpy(piece->uv[piece->count], place->uv, sizeof *piece->uv);
    piece->r[piece->count++] = place->r;
}

/* Adds the places between two, and the second. */
static void add_between(struct cut_pieces *p, struct shell_slit_piece *piece,
                        const struct cut_place *from, const struct cut_place *to, int halvings) {
    struct cut_place middle;
    for (int k = 0; k < 2; k++)
        middle.uv[k] = (from->uv[k] + to->uv[k]) / 2;
    struct vec3 chord = vec3_unit(vec3_sub(to->r, from->r));
    if (halvings > 0 && find_exact_place(p, piece->face, true, &middle) &&
        vec3_norm(vec3_cross(vec3_sub(middle.r, from->r), chord)) > p->bend) {
        add_between(p, piece, from, &middle, halvings - 1);
        add_between(p, piece, &middle, to, halvings - 1);
    } else
        add_piece_point(piece, to);
}

/* The pieces' points: the places of the mesh's cut, exactly, and between them as many as keep it
 * near its chords. */
static bool find_exact_pieces(struct cut_pieces *p, struct arena *arena) {
    struct cut_place *place = p->place;
    double(*uv)[2] = arena_alloc(arena, PER_EDGE * p->used, sizeof *uv);
    struct vec3 *r = arena_alloc(arena, PER_EDGE * p->used, sizeof *r);
    if (!uv || !r)
        return false;
    for (size_t n = 0; n < p->count; n++) {
        struct shell_slit_piece *piece = &p->piece[n];
        size_t count = piece->count;
        bool exact = true;
        piece->count = 0;
        piece->uv = uv;
        piece->r = r;
        for (size_t k = 0; k < count; k++, place++) {
            bool inner = k > 0 && k + 1 < count, before = exact;
            exact = find_exact_place(p, piece->face, inner, place);
            if (k == 0)
                add_piece_point(piece, place);
            else
                add_between(p, piece, place - 1, place, before && exact ? HALVINGS : 0);
        }
        uv += piece->count;
        r += piece->count;
    }
    return true;
}

/* ---- along a line of curvature ---- */

/* Whether a place is on the border of the mesh that a half-edge is part of. */
static bool reaches_border(const struct cut_pieces *p, int32_t half, struct vec3 r) {
    int32_t at = half;
    double least = HUGE_VAL;
    do {
        least = fmin(least, vec3_distance(mesh_corner_point(p->mesh, at / 3, at % 3), r));
        at = mesh_next_on_border(p->mesh, at);
    } while (at != half);
    return least < p->size;
}

/* Whether a line leads past the start opposite it, as the mesh's cut does, and from the same border
 * to the same. */
static bool line_cuts_tube(const struct cut_pieces *p, const struct mesh_tube_cuts *cuts,
                           const struct curvature_cut *line) {
    struct vec3 start = p->start->jet.r;
    double away = vec3_distance(start, line->opposite), off = HUGE_VAL;
    for (size_t k = 0; k < p->used; k++)
        off = fmin(off, vec3_distance(p->place[k].r, line->opposite));
    if (line->count == 0 || !(off < off_most * line->girth))
        return false;
    for (size_t n = 0; n < line->count; n++)
        for (size_t k = 0; k < line->pieces[n].count; k++)
            if (vec3_distance(line->pieces[n].r[k], start) < away / 2)
                return false;
    const struct shell_slit_piece *last = &line->pieces[line->count - 1];
    const struct vec3 end[2] = {line->pieces[0].r[0], last->r[last->count - 1]};
    int32_t from = cuts->slits[0].half[0], to = cuts->slits[cuts->from[1] - 1].half[1];
    return (reaches_border(p, from, end[0]) && reaches_border(p, to, end[1])) ||
           (reaches_border(p, from, end[1]) && reaches_border(p, to, end[0]));
}

/* Puts the line of curvature opposite the start in the place of the mesh's cut, if there is one. */
static enum status follow_curvature(struct cut_pieces *p, const struct mesh_tube_cuts *cuts,
                                    struct arena *arena, struct curvature_cut *line, bool *found) {
    double most = lengths_most * shell_size(p->shell);
    enum status status = curvature_cut_make(p->start, p->size / STEPS_PER_SIDE, most, arena, line);
    *found = status == STATUS_OK && line_cuts_tube(p, cuts, line);
    if (*found) {
        p->piece = line->pieces;
        p->count = line->count;
    }
    return status;
}

static double side_of_squares(const struct surface *surface) {
    const struct shell *shell = surface->shell;
    return sqrt(shell_area(shell, shell_component(shell, surface->face), NULL) / squares);
}

enum status march_tube_mesh(const struct surface *surface, struct arena *arena,
                            const struct mesh **tube) {
    struct mesh *mesh = NULL;
    enum status status = STATUS_OK;
    if (shell_may_be_tube(surface->shell, surface->face))
        status = mesh_from_shell(surface->shell, surface->face, side_of_squares(surface),
                                 triangles_most, arena, &mesh);
    *tube = status == STATUS_OK ? mesh : NULL;
    return status == STATUS_OUT_OF_MEMORY ? status : STATUS_OK;
}

static enum status open_tube(struct march *march) {
    const struct surface *surface = march->surface;
    const struct shell *shell = surface->shell;
    const double *d = march->settings->spacing;
    const struct mesh *mesh = march->tube;
    struct mesh_point place;
    struct mesh_tube_cuts cuts;
    struct shell_slit *slit = NULL;
    enum status status = mesh ? STATUS_OK : march_tube_mesh(surface, march->arena, &mesh);
    if (!mesh || !mesh_nearest(mesh, march->start.point.jet.r, MESH_ANY, &place, NULL))
        return status;
    double size = side_of_squares(surface);
    status = mesh_find_tube_cuts(mesh, &place, march->arena, &cuts);
    if (status != STATUS_OK || cuts.count == 0)
        return status;
    size_t slits = cuts.from[cuts.count];
    struct cut_pieces pieces = {.shell = shell,
                                .mesh = mesh,
                                .start = &march->start.point,
                                .piece = arena_alloc(march->arena, slits, sizeof *pieces.piece),
                                .place = arena_alloc(march->arena, 2 * slits, sizeof *pieces.place),
                                .least = least_piece * size,
                                .size = size,
                                .bend = bend_most * fmin(d[0], d[1])};
    if (!pieces.piece || !pieces.place)
        return STATUS_OUT_OF_MEMORY;
    for (size_t n = 0; n < cuts.count; n++) {
        for (size_t k = cuts.from[n]; k < cuts.from[n + 1]; k++)
            add_slit(&pieces, &cuts.slits[k], k == cuts.from[n]);
        end_piece(&pieces);
        pieces.piece[pieces.count - 1].ends = true;
    }
    find_mirror(&pieces);
    struct curvature_cut line;
    bool curved = vec3_norm2(pieces.mirror) == 0 && cuts.count == 1;
    if (curved)
        status = follow_curvature(&pieces, &cuts, march->arena, &line, &curved);
    if (status != STATUS_OK || (!curved && !find_exact_pieces(&pieces, march->arena)))
        return STATUS_OUT_OF_MEMORY;
    const struct shell_slit_lines lines = {.pieces = pieces.piece,
                                           .count = pieces.count,
                                           .reach = longest_way * fmax(d[0], d[1]),
                                           .beyond = beyond * shell_size(shell),
                                           .ahead = mesh->vertices,
                                           .ahead_count = mesh->vertex_count};
    status = shell_slit_make(shell, &lines, march->arena, &slit);
    march->cut.slit[0] = status == STATUS_OK ? slit : NULL;
    return status;
}

/* How often one line passes another, to whichever side. */
static int count_crossings(const struct shell_slit *slit, const struct curvature_cut *line) {
    int count = 0;
    struct shell_slit_point from = {.r = line->pieces[0].r[0]}, to = from;
    for (size_t n = 0; n < line->count; n++)
        for (size_t k = 0; k < line->pieces[n].count; k++, from = to) {
            to.r = line->pieces[n].r[k];
            count += abs(shell_slit_passes(slit, &from, &to));
        }
    return count;
}

/* A shell without ends is cut open both ways, so that the quadrants share it evenly, along the
 * lines of curvature opposite the start where there are such that cross once: on what is like a
 * sphere no two closed lines do. */
static enum status open_both_ways(struct march *march) {
    const struct shell *shell = march->surface->shell;
    double step = side_of_squares(march->surface) / STEPS_PER_SIDE;
    double reach = longest_way * fmax(march->settings->spacing[0], march->settings->spacing[1]);
    struct curvature_cut line[2];
    struct shell_slit *slit[2] = {NULL, NULL};
    enum status status = curvature_cut_rings(&march->start.point, step,
                                             lengths_most * shell_size(shell), march->arena, line);
    for (int k = 0; k < 2 && status == STATUS_OK && line[0].count > 0; k++) {
        const struct shell_slit_lines lines = {.pieces = line[k].pieces,
                                               .count = line[k].count,
                                               .closed = true,
                                               .reach = fmax(reach, step)};
        status = shell_slit_make(shell, &lines, march->arena, &slit[k]);
    }
    if (status == STATUS_OK && slit[1] && count_crossings(slit[0], &line[1]) == 1)
        memcpy(march->cut.slit, slit, sizeof slit);
    return status;
}

/* A surface of a smaller mean curvature, by the spacing, is flat: its sign is rounding. */
static const double flat_bend = 1e-6;

/* Whether the surface bends to the side of its normal, by its mean curvature
 * (E N - 2 F M + G L) / (2 (E G - F^2)). */
static bool bends_inward(const struct surface_point *point, double d) {
    const double *first = point->first, *second = point->second;
    double bend = first[0] * second[2] - 2 * first[1] * second[1] + first[2] * second[0];
    return bend * d > 2 * flat_bend * (first[0] * first[2] - first[1] * first[1]);
}

/* A closed direction of one face is cut opposite the start; one that the trims leave bare somewhere
 * is cut there, where the cut divides nothing. */
enum status march_open(struct march *march) {
    const struct surface *surface = march->surface;
    const struct trim *trim = march->trim;
    march->cut.inward = bends_inward(&march->start.point, march->settings->spacing[0]);
    if (surface->shell)
        return shell_is_closed(surface->shell, surface->face) ? open_both_ways(march)
                                                              : open_tube(march);
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
