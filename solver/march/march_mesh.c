/* SPDX-License-Identifier: MIT */
/* The march over a mesh: flat triangles, for the method mosaic, or the smooth surface that they
 * stand for. What is different there. */
#include "march.h"

#include "solver/fishnet/unfolding.h"
#include "solver/mesh/ring.h"
#include "solver/mesh/smooth_corner.h"

/* A generator's next place this near to the mesh, as a share of the chord, is on it; where it is on
 * the mesh may be wrong by so much of the chord from the last. */
static const double beside_mesh = 0.02, chord_gap = 1e-3;

/* A place off the edge of the mesh by this share of the chord is on it. */
static const double edge_gap = 1e-9;

/* An edge that turns by more than this, or whose curvature changes by more along it, in radians, is
 * no arc of a circle. */
static const double bend_most = 0.5, change_most = 0.05;

/* Over folds of less than 72 degrees chords still find the right corner, if not to the last. */
static const double gentle_cosine = 0.3;

struct surface_point march_mesh_point(const struct march *march, const struct mesh_point *place) {
    struct surface_point point = {.uv = {place->triangle, 0},
                                  .jet.r = place->r,
                                  .normal = march->mesh->normals[place->triangle]};
    point.first[0] = point.first[2] = 1;
    if (!march->smooth) {
        point.jet.u = vec3_unit(mesh_edge_vector(march->mesh, 3 * place->triangle));
        point.jet.v = vec3_cross(point.normal, point.jet.u);
        return point;
    }
    struct mesh_jet jet;
    mesh_smooth_jet(march->smooth, place, &jet);
    const struct mesh_fit *fit =
        &march->smooth->fits.fit[march->smooth->fits.of[place->triangle][0]];
    point.normal = vec3_unit(jet.gradient);
    point.jet.u = vec3_unit(vec3_cross(fit->y, point.normal));
    point.jet.v = vec3_cross(point.normal, point.jet.u);
    point.second[0] = mesh_jet_form(&jet, point.jet.u, point.jet.u);
    point.second[1] = mesh_jet_form(&jet, point.jet.u, point.jet.v);
    point.second[2] = mesh_jet_form(&jet, point.jet.v, point.jet.v);
    return point;
}

struct mesh_point march_mesh_point_of(const struct surface_point *point) {
    return (struct mesh_point){.triangle = (int32_t)point->uv[0], .r = point->jet.r};
}

/* A place this near to an edge of its triangle, as a share of the edge, lies on it. */
static const double on_edge = 1e-9;

static struct vec3 more_across(struct vec3 normal, struct vec3 other, struct vec3 v) {
    return fabs(vec3_dot(other, v)) < fabs(vec3_dot(normal, v)) ? other : normal;
}

bool march_mesh_folds(const struct march *march) {
    return march->mesh && !march->smooth && march->mesh->sharpest < MARCH_MESH_CREASE;
}

/* Of the triangles in which a point lies, on an edge or a vertex of the mesh more than one, the
 * normal of that whose plane has the direction `v`. */
static struct vec3 normal_of_way(const struct march *march, const struct surface_point *point,
                                 struct vec3 v) {
    const struct mesh *mesh = march->mesh;
    const struct mesh_point place = march_mesh_point_of(point), *at = &place;
    struct vec3 normal = mesh->normals[at->triangle];
    for (int k = 0; k < 3; k++) {
        int32_t half = 3 * at->triangle + k, twin = mesh->twins[half];
        struct vec3 edge = mesh_edge_vector(mesh, half);
        struct vec3 from = vec3_sub(at->r, mesh_corner_point(mesh, at->triangle, k));
        double size2 = vec3_norm2(edge), near2 = on_edge * on_edge * size2;
        if (twin != MESH_NONE && vec3_norm2(vec3_cross(edge, from)) <= near2 * size2)
            normal = more_across(normal, mesh->normals[twin / 3], v);
        if (vec3_norm2(from) > near2)
            continue;
        const struct mesh_ring ring = mesh_ring_make(mesh, at->triangle, k);
        int32_t around = ring.first;
        do {
            normal = more_across(normal, mesh->normals[around / 3], v);
            around = mesh_ring_next(mesh, around);
        } while (around != MESH_NONE && around != ring.first);
    }
    return normal;
}

static bool lies_on_fold(const struct march *march, const struct surface_point *point) {
    return march_mesh_folds(march) &&
           vec3_dot(normal_of_way(march, point, point->normal), point->normal) < MARCH_MESH_CREASE;
}

struct vec3 march_mesh_unfolded(const struct march *march, const struct surface_point *point,
                                struct vec3 way) {
    struct vec3 normal = normal_of_way(march, point, way);
    return surface_point_tangent(point, unfolding_turned(way, normal, point->normal));
}

void march_mesh_note(struct march *march, const struct surface_point *from,
                     const struct surface_point *to, bool folded, int di, int dj, struct vec3 start,
                     struct vec3 end) {
    march->edges.rough = 0;
    if (folded || lies_on_fold(march, from) || lies_on_fold(march, to))
        march_note_edge(march, di ? 0 : 1, di + dj, march_mesh_unfolded(march, from, start),
                        march_mesh_unfolded(march, to, end));
}

static bool is_over_fold(const struct march *march, const struct mesh_point *a,
                         const struct mesh_point *b) {
    return march->smooth->patch[a->triangle] != march->smooth->patch[b->triangle];
}

/* Whether the curvature along an edge is so large, or changes so much, that it is no arc. */
static bool is_rough(const struct surface_point *from, const struct surface_point *to, double d) {
    struct vec3 edge = vec3_sub(to->jet.r, from->jet.r);
    double k1 = surface_point_normal_curvature(from, edge),
           k2 = surface_point_normal_curvature(to, edge);
    return fabs(k1) * d > bend_most || fabs(k1 - k2) * d > change_most;
}

/* On the smooth surface: chords of arcs, where the edges are such; geodesics elsewhere, but for the
 * method basic. `cell` has the spacings. */
static enum mesh_corner_end solve_smooth(struct march *march, const struct march_cell *at,
                                         const struct mesh_cell *cell, struct mesh_corner *corner) {
    const double *d = march->length;
    struct fishnet_cell chords = {.a = at->a, .b = at->b, .c = at->c};
    struct mesh_cell by_chords = *cell, by_geodesics = *cell;
    fishnet_chords(NULL, march->method->yarn, DRAPE_PATH_CHORD, d, &chords);
    by_chords.bd = chords.bd;
    by_chords.cd = chords.cd;
    enum mesh_corner_end end = mesh_smooth_corner(march->smooth, &by_chords, corner);
    if (march->method->yarn == DRAPE_YARN_CHORD)
        return end;
    bool found = end == MESH_CORNER_FOUND, rough = !found;
    bool folded = is_over_fold(march, &cell->b, &cell->c);
    bool gentle = vec3_dot(at->b->normal, at->c->normal) > gentle_cosine;
    if (found) {
        struct surface_point to = march_mesh_point(march, &corner->at);
        by_geodesics.guess = corner->at.r;
        folded = folded || is_over_fold(march, &cell->b, &corner->at);
        gentle = gentle && vec3_dot(at->b->normal, to.normal) > gentle_cosine &&
                 vec3_dot(at->c->normal, to.normal) > gentle_cosine;
        rough = folded || is_rough(at->b, &to, d[0]) || is_rough(at->c, &to, d[1]);
    }
    bool geodesic = march->method->yarn == DRAPE_YARN_GEODESIC;
    if (!rough && !geodesic)
        return end;
    struct mesh_corner other = {.steps = corner->steps};
    const struct mesh_sheet sheet = {march->mesh, march->smooth};
    struct mesh_yarns yarns;
    struct vec3 back[2];
    enum mesh_corner_end other_end = MESH_CORNER_NO_CONVERGENCE;
    if (march_turn_as_at_a(march, at, back, yarns.start))
        other_end = mesh_cell_geodesics(&sheet, &by_geodesics, back, &other, &yarns);
    if (other_end == MESH_CORNER_FOUND) {
        *corner = other;
        if (rough)
            march_note_edges(march, at, yarns.start, yarns.end);
    }
    bool settled = other_end == MESH_CORNER_FOUND || geodesic || (folded && !gentle);
    return settled ? other_end : end;
}

/* Whether the triangles of two places are so far from parallel that there may be a fold between. */
static bool may_fold(const struct surface_point *a, const struct surface_point *b) {
    return vec3_dot(a->normal, b->normal) < MARCH_MESH_CREASE;
}

/* On flat triangles: straight chords but, over a fold, straight paths, which unfold it. */
static enum mesh_corner_end solve_flat(struct march *march, const struct march_cell *at,
                                       const struct mesh_cell *cell, struct mesh_corner *corner) {
    const struct mesh_sheet sheet = {march->mesh, NULL};
    enum mesh_corner_end end = mesh_corner_solve(march->mesh, cell, corner);
    bool found = end == MESH_CORNER_FOUND;
    if (!march_mesh_folds(march))
        return end;
    struct surface_point to = *at->a;
    if (found)
        to = march_mesh_point(march, &corner->at);
    bool on_fold = lies_on_fold(march, at->a) || lies_on_fold(march, at->b) ||
                   lies_on_fold(march, at->c) || lies_on_fold(march, &to);
    if (found && !on_fold && !may_fold(at->a, at->b) && !may_fold(at->a, at->c) &&
        !may_fold(at->b, &to) && !may_fold(at->c, &to))
        return end;
    struct mesh_corner other = {.steps = corner->steps};
    struct mesh_yarns yarns;
    struct vec3 back[2];
    if (!march_turn_as_at_a(march, at, back, yarns.start))
        return end;
    enum mesh_corner_end other_end = mesh_cell_geodesics(&sheet, cell, back, &other, &yarns);
    bool folded = yarns.sharpest < MARCH_MESH_CREASE || on_fold || !found;
    if (folded && other_end == MESH_CORNER_FOUND) {
        *corner = other;
        march_note_edges(march, at, yarns.start, yarns.end);
    }
    bool gentle = found && vec3_dot(at->b->normal, to.normal) > gentle_cosine &&
                  vec3_dot(at->c->normal, to.normal) > gentle_cosine;
    bool settled = folded && (other_end == MESH_CORNER_FOUND || !gentle);
    return settled ? other_end : end;
}

bool march_mesh_corner(struct march *march, const struct march_cell *at, struct vec3 guess,
                       struct fishnet_node *node, enum drape_reason *reason) {
    static const enum drape_reason reasons[] = {
        [MESH_CORNER_COLLAPSED] = DRAPE_REASON_COLLAPSED,
        [MESH_CORNER_BOUNDARY] = DRAPE_REASON_BOUNDARY,
        [MESH_CORNER_NO_CONVERGENCE] = DRAPE_REASON_NO_CONVERGENCE,
    };
    struct mesh_cell cell = {.a = march_mesh_point_of(at->a),
                             .b = march_mesh_point_of(at->b),
                             .c = march_mesh_point_of(at->c),
                             .bd = march->length[0],
                             .cd = march->length[1],
                             .guess = guess,
                             .orientation = at->si * at->sj};
    struct mesh_corner corner;
    enum mesh_corner_end end = march->smooth ? solve_smooth(march, at, &cell, &corner)
                                             : solve_flat(march, at, &cell, &corner);
    if (end != MESH_CORNER_FOUND) {
        *reason = reasons[end];
        return false;
    }
    *node = (struct fishnet_node){.point = march_mesh_point(march, &corner.at),
                                  .iterations = corner.steps,
                                  .residual = corner.residual};
    return true;
}

bool march_mesh_arm(const struct march *march, const struct surface_point *from,
                    const struct drape_generator *generator, struct vec3 direction,
                    struct march_mesh_yarn *yarn) {
    struct mesh_point place = march_mesh_point_of(from);
    bool section = generator && generator->kind == DRAPE_GENERATOR_PLANE;
    struct vec3 plane = section ? vec3_unit(generator->plane_normal) : vec3_make(0, 0, 0);
    if (march->smooth)
        return mesh_smooth_path(&yarn->smooth, march->smooth, &place, direction, plane);
    if (section)
        return mesh_path_section(&yarn->flat, march->mesh, &place, plane, direction);
    return mesh_path_straight(&yarn->flat, march->mesh, &place, direction);
}

static bool advance_yarn(const struct march *march, struct march_mesh_yarn *yarn, double d,
                         struct surface_point *point, bool *lost) {
    enum mesh_path_end end = !march->smooth ? mesh_path_chord(&yarn->flat, d)
                             : march->method->yarn == DRAPE_YARN_CHORD
                                 ? mesh_smooth_chord(&yarn->smooth, d)
                                 : mesh_smooth_length(&yarn->smooth, d);
    *lost = end == MESH_PATH_LOST;
    if (end == MESH_PATH_DONE)
        *point = march_mesh_point(march, march->smooth ? &yarn->smooth.at : &yarn->flat.at);
    return end == MESH_PATH_DONE;
}

/* A yarn over flat triangles goes on by a straight chord or, over a fold, by its own length. */
static bool lay_flat(struct march *march, struct march_mesh_yarn *yarn, int di, int dj,
                     struct surface_point *point, bool *lost) {
    double d = march->length[dj != 0];
    const struct mesh_path from = yarn->flat;
    const struct surface_point start = march_mesh_point(march, &from.at);
    bool gone = advance_yarn(march, yarn, d, point, lost);
    bool folded = yarn->flat.sharpest < MARCH_MESH_CREASE && !(vec3_norm2(from.plane) > 0);
    if (folded) {
        yarn->flat = from;
        enum mesh_path_end end = mesh_path_length(&yarn->flat, d);
        gone = end == MESH_PATH_DONE;
        *lost = end == MESH_PATH_LOST;
        *point = march_mesh_point(march, &yarn->flat.at);
    }
    if (gone)
        march_mesh_note(march, &start, point, folded, di, dj, from.direction, yarn->flat.direction);
    return gone;
}

bool march_mesh_lay(struct march *march, struct march_mesh_yarn *yarn, int di, int dj,
                    struct surface_point *point, bool *lost) {
    double d = march->length[dj != 0];
    struct mesh_smooth_path from = yarn->smooth;
    march->edges.rough = 0;
    if (!march->smooth)
        return lay_flat(march, yarn, di, dj, point, lost);
    if (!advance_yarn(march, yarn, d, point, lost))
        return false;
    if (march->method->yarn == DRAPE_YARN_CHORD)
        return true;
    struct surface_point start = march_mesh_point(march, &from.at);
    if (!is_over_fold(march, &from.at, &yarn->smooth.at) && !is_rough(&start, point, d))
        return true;
    march_note_edge(march, di ? 0 : 1, di + dj, from.direction, yarn->smooth.direction);
    return true;
}

/* The place of the mesh that is nearest to `target`; false when it is not beside it. */
static bool find_beside(struct march *march, const struct surface_point *from, struct vec3 target,
                        double chord, struct surface_point *point) {
    struct mesh_point place = march_mesh_point_of(from);
    double distance;
    bool found = mesh_nearest(march->mesh, target, march->mesh->component[place.triangle], &place,
                              &distance);
    *point = march_mesh_point(march, &place);
    return found && distance <= beside_mesh * chord;
}

bool march_mesh_towards(struct march *march, const struct surface_point *from, struct vec3 target,
                        int family, bool folded, struct surface_point *point, bool *lost) {
    double chord = march->length[family];
    bool geodesic = march->settings->generator[family].kind == DRAPE_GENERATOR_GEODESIC;
    struct march_mesh_yarn yarn;
    struct mesh_point place = march_mesh_point_of(from);
    *lost = false;
    if (folded || lies_on_fold(march, from))
        return find_beside(march, from, target, chord, point);
    bool leads = mesh_path_towards(&yarn.flat, march->mesh, &place, target);
    if (leads && advance_yarn(march, &yarn, chord, point, lost))
        return true;
    /* Along a curved edge of the surface the way lies beside the mesh by the height of a patch, a
     * geodesic above or below it: there the nearest place is as good, if it is a chord away; else a
     * way that has come to the edge ends there. */
    bool at_edge = leads && !*lost, beside = find_beside(march, from, target, chord, point);
    struct vec3 off = vec3_sub(target, point->jet.r);
    double above = vec3_dot(off, from->normal), aside2 = vec3_norm2(off) - above * above;
    bool apart = fabs(vec3_distance(point->jet.r, from->jet.r) - chord) <= chord_gap * chord;
    apart =
        apart && (!geodesic || aside2 <= fmax(above * above, edge_gap * edge_gap * chord * chord));
    *lost = beside && !apart && !at_edge;
    return beside && apart;
}

bool march_mesh_straight_on(struct march *march, const struct surface_point *from,
                            struct vec3 direction, int di, int dj, struct surface_point *point) {
    struct march_mesh_yarn yarn;
    bool lost;
    return march_mesh_arm(march, from, NULL, direction, &yarn) &&
           march_mesh_lay(march, &yarn, di, dj, point, &lost);
}
