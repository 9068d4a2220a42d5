/* SPDX-License-Identifier: MIT */
#include "corner.h"

#include "path.h"
#include "tree.h"

/* D is in a triangle also this share of the longer chord outside: between two triangles, where
 * rounding could have it in neither; beyond the edge of the mesh, where yarns along it lie. */
static const double between = 1e-13, beyond = 1e-9;

/* What rounding leaves of coordinates. */
static const double rounding = 4e-16;

/* The cosine of 95 degrees. */
static const double sheet_cosine = -0.087;

/* Below this sine of the angle between the yarns at A a cell that finds no corner has collapsed. */
static const double collapsed_sine = 0.12;

/* A plane whose normal has a smaller sine with BC is parallel to the circle. */
static const double parallel_sine = 1e-6;

/* A way ends after so many triangles, or this many chords. */
enum { STEPS_MAX = 20000 };
static const double reach = 2;

/* The circle |x - middle| = radius about the axis along BC, and the cell it belongs to. */
struct circle {
    const struct mesh *mesh;
    const struct mesh_cell *cell;
    struct vec3 middle, axis;
    double radius2;
    double inside2, outside2; /* squares of how far D may be outside a triangle */
};

/* Where the circle passes the plane of triangle t on the side of BC away from A; false when it does
 * not reach it, and then its foot there. With m the part of the normal n across the axis and h = n
 * . (v - middle): D = middle + h m / |m|^2 +- tau axis x m / |m|, and n . ((D - C) x (B - C)) has
 * the opposite sign of that of tau. */
static bool solve_in_plane(const struct circle *circle, int32_t t, struct vec3 *d) {
    struct vec3 normal = circle->mesh->normals[t];
    struct vec3 v = mesh_corner_point(circle->mesh, t, 0);
    struct vec3 m = vec3_axpy(-vec3_dot(normal, circle->axis), circle->axis, normal);
    double m2 = vec3_norm2(m), h = vec3_dot(normal, vec3_sub(v, circle->middle));
    *d = circle->middle;
    if (!(m2 > parallel_sine * parallel_sine))
        return false;
    double tau2 = circle->radius2 - h * h / m2;
    double tau = -circle->cell->orientation * sqrt(fmax(tau2, 0) / m2);
    *d = vec3_axpy(h / m2, m, vec3_axpy(tau, vec3_cross(circle->axis, m), circle->middle));
    return tau2 >= 0;
}

/* Twice the area of the triangle p q r as seen along the normal. */
static double area_seen(struct vec3 p, struct vec3 q, struct vec3 r, struct vec3 normal) {
    return vec3_dot(vec3_cross(vec3_sub(q, p), vec3_sub(r, p)), normal);
}

bool mesh_cell_is_upright(const struct mesh_cell *cell, struct vec3 na, struct vec3 nb,
                          struct vec3 nc) {
    struct vec3 sum = vec3_add(vec3_add(nb, nc), na);
    return cell->orientation * area_seen(cell->a.r, cell->c.r, cell->b.r, sum) > 0;
}

bool mesh_cell_has_corner(const struct mesh_cell *cell, struct vec3 nb, struct vec3 nc,
                          struct vec3 d, struct vec3 nd) {
    struct vec3 sum = vec3_add(nd, vec3_add(nb, nc));
    return vec3_dot(nd, nb) > sheet_cosine && vec3_dot(nd, nc) > sheet_cosine &&
           cell->orientation * area_seen(cell->c.r, d, cell->b.r, sum) > 0;
}

double mesh_cell_residual(const struct mesh_cell *cell, struct vec3 d) {
    return fmax(fabs(vec3_distance(d, cell->b.r) / cell->bd - 1),
                fabs(vec3_distance(d, cell->c.r) / cell->cd - 1));
}

bool mesh_cell_has_collapsed(const struct mesh *mesh, const struct mesh_cell *cell) {
    struct vec3 ab = vec3_sub(cell->b.r, cell->a.r), ac = vec3_sub(cell->c.r, cell->a.r);
    double sine = cell->orientation *
                  vec3_dot(vec3_cross(ac, ab), mesh->normals[cell->a.triangle]) /
                  (vec3_norm(ab) * vec3_norm(ac));
    double apart = vec3_distance(cell->b.r, cell->c.r);
    return sine < collapsed_sine || apart > (1 - collapsed_sine / 10) * (cell->bd + cell->cd);
}

/* Whether D in triangle t is the one wanted. */
static bool is_wanted_corner(const struct circle *circle, int32_t t, struct vec3 d) {
    const struct mesh_cell *cell = circle->cell;
    const struct vec3 *normals = circle->mesh->normals;
    return mesh_cell_has_corner(cell, normals[cell->b.triangle], normals[cell->c.triangle], d,
                                normals[t]);
}

/* The way from p in triangle t to d in its plane: `edge` is where it leaves, MESH_NONE when d is
 * inside, and `share` how far that is. `entry` is not left through; `stuck`: d is beyond it. */
struct crossing {
    int edge;
    double share;
    bool stuck;
};

static struct crossing find_crossing(const struct circle *circle, int32_t t, int entry,
                                     struct vec3 p, struct vec3 d) {
    const struct mesh *mesh = circle->mesh;
    struct crossing found = {MESH_NONE, HUGE_VAL, false};
    struct vec3 v[3], normal = mesh->normals[t];
    mesh_corner_points(mesh, t, v);
    for (int k = 0; k < 3; k++) {
        struct vec3 x = vec3_sub(v[(k + 1) % 3], v[k]), inward = vec3_cross(normal, x);
        double gap = vec3_dot(inward, vec3_sub(d, v[k]));
        double slack2 = mesh->twins[3 * t + k] == MESH_NONE ? circle->outside2 : circle->inside2;
        if (gap >= 0 || gap * gap <= slack2 * vec3_norm2(x))
            continue;
        if (k == entry) {
            found.stuck = true;
            continue;
        }
        double before = fmax(vec3_dot(inward, vec3_sub(p, v[k])), 0);
        double share = before / (before - gap);
        if (share < found.share) {
            found.edge = k;
            found.share = share;
        }
    }
    found.stuck = found.stuck && found.edge == MESH_NONE;
    return found;
}

static enum mesh_corner_end found_corner(const struct circle *circle, int32_t t, struct vec3 d,
                                         struct mesh_corner *corner) {
    corner->at = (struct mesh_point){t, d};
    corner->residual = mesh_cell_residual(circle->cell, d);
    return MESH_CORNER_FOUND;
}

/* Heads for D from B or C. It ends at the mesh's edge with MESH_CORNER_BOUNDARY when the mesh,
 * going on flat, would lead to D, with MESH_CORNER_COLLAPSED when even so it would not. */
static enum mesh_corner_end head_from(const struct circle *circle, const struct mesh_point *from,
                                      struct mesh_corner *corner) {
    const struct mesh *mesh = circle->mesh;
    struct vec3 p = from->r, d;
    int32_t t = from->triangle;
    int entry = MESH_NONE;
    double left = reach * (circle->cell->bd + circle->cell->cd);
    for (int step = 0; step < STEPS_MAX && left >= 0; step++) {
        bool real = solve_in_plane(circle, t, &d);
        struct crossing way = find_crossing(circle, t, entry, p, d);
        corner->steps++;
        if (way.stuck)
            return MESH_CORNER_NO_CONVERGENCE;
        if (way.edge == MESH_NONE)
            return real && is_wanted_corner(circle, t, d) ? found_corner(circle, t, d, corner)
                                                          : MESH_CORNER_NO_CONVERGENCE;
        int32_t twin = mesh->twins[3 * t + way.edge];
        if (twin == MESH_NONE)
            return real ? MESH_CORNER_BOUNDARY : MESH_CORNER_COLLAPSED;
        struct vec3 to = vec3_axpy(way.share, vec3_sub(d, p), p);
        left -= vec3_distance(p, to);
        p = to;
        t = twin / 3;
        entry = twin % 3;
    }
    return MESH_CORNER_NO_CONVERGENCE;
}

/* ---- all triangles on the circle ---- */

struct search {
    const struct circle *circle;
    struct mesh_corner *corner;
    struct mesh_point best;
    double distance2; /* of the best to the guess */
    bool unreached;   /* a root was left out because it does not hang together with B and C */
};

static void try_triangle(void *context, int32_t t) {
    struct search *search = context;
    const struct circle *circle = search->circle;
    const struct mesh_cell *cell = circle->cell;
    struct mesh_point d = {t, {0, 0, 0}};
    search->corner->steps++;
    if (!solve_in_plane(circle, t, &d.r))
        return;
    struct crossing way = find_crossing(circle, t, MESH_NONE, d.r, d.r);
    double distance2 = vec3_norm2(vec3_sub(d.r, cell->guess));
    bool better = distance2 < search->distance2 ||
                  (distance2 == search->distance2 && t < search->best.triangle);
    if (way.edge != MESH_NONE || !better || !is_wanted_corner(circle, t, d.r))
        return;
    /* the sheet has to lead from D to B or C without detour */
    if (!mesh_path_connects(circle->mesh, &d, &cell->c, reach * cell->cd) &&
        !mesh_path_connects(circle->mesh, &d, &cell->b, reach * cell->bd)) {
        search->unreached = true;
        return;
    }
    search->best = d;
    search->distance2 = distance2;
}

enum mesh_corner_end mesh_corner_solve(const struct mesh *mesh, const struct mesh_cell *cell,
                                       struct mesh_corner *corner) {
    /* middle = P + x (Q - P) / L, with P that of B and C which has the shorter chord p, and so is
     * not lost beside the other: x = (L^2 + p^2 - q^2) / (2 L) */
    bool from_b = cell->bd <= cell->cd;
    double shorter = from_b ? cell->bd : cell->cd, longer = from_b ? cell->cd : cell->bd;
    struct vec3 base = vec3_sub(cell->c.r, cell->b.r);
    double length = vec3_norm(base);
    double x = ((length - longer) * (length + longer) + shorter * shorter) / (2 * length);
    double inside = between * longer + rounding * mesh->magnitude;
    double outside = beyond * longer + rounding * mesh->magnitude;
    struct circle circle = {.mesh = mesh,
                            .cell = cell,
                            .axis = vec3_unit(base),
                            .radius2 = (shorter - x) * (shorter + x),
                            .inside2 = inside * inside,
                            .outside2 = outside * outside};
    circle.middle = vec3_axpy(from_b ? x : -x, circle.axis, from_b ? cell->b.r : cell->c.r);
    enum mesh_corner_end ends[2];
    corner->steps = 0;
    if (!(circle.radius2 > 0) ||
        !mesh_cell_is_upright(cell, mesh->normals[cell->a.triangle],
                              mesh->normals[cell->b.triangle], mesh->normals[cell->c.triangle]))
        return MESH_CORNER_COLLAPSED;
    for (int k = 0; k < 2; k++) {
        ends[k] = head_from(&circle, k ? &cell->b : &cell->c, corner);
        if (ends[k] == MESH_CORNER_FOUND)
            return ends[k];
    }
    /* neither way found it: looks everywhere */
    struct search search = {
        .circle = &circle, .corner = corner, .best = {MESH_NONE, {0, 0, 0}}, .distance2 = HUGE_VAL};
    const struct mesh_circle shape = {cell->b.r, cell->c.r, cell->bd, cell->cd};
    mesh_tree_visit(mesh, &shape, try_triangle, &search);
    if (search.best.triangle != MESH_NONE)
        return found_corner(&circle, search.best.triangle, search.best.r, corner);
    if (ends[0] == MESH_CORNER_BOUNDARY || ends[1] == MESH_CORNER_BOUNDARY)
        return MESH_CORNER_BOUNDARY;
    if (mesh_cell_has_collapsed(mesh, cell))
        return MESH_CORNER_COLLAPSED;
    if (ends[0] == MESH_CORNER_COLLAPSED || ends[1] == MESH_CORNER_COLLAPSED)
        return MESH_CORNER_BOUNDARY;
    return search.unreached ? MESH_CORNER_NO_CONVERGENCE : MESH_CORNER_COLLAPSED;
}
