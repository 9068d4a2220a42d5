/* SPDX-License-Identifier: MIT */
#include "smooth_corner.h"

enum { NEWTON_MAX = 30, SIDES_MAX = 4, FREE_STEPS = 4 };

/* After FREE_STEPS Newton's method stays in its triangle up to this share of its height outside:
 * the surface has a step of O(h^6) between triangles. */
static const double settled = 0.02;

/* Relative accuracy of the distances wanted, and still taken where rounding keeps from it. */
static const double wanted = 1e-12, taken = 1e-9;

enum newton_end { NEWTON_FOUND, NEWTON_BEYOND, NEWTON_FAILED };

/* Newton's method from `point` on one side of all folds; `edge` is what D lies beyond. */
static enum newton_end newton_on_side(const struct mesh_smooth *smooth,
                                      const struct mesh_cell *cell, struct mesh_point *at,
                                      int *steps, int32_t *edge) {
    double longest = (cell->bd + cell->cd) / 2, best = HUGE_VAL;
    struct mesh_point found = *at;
    for (int k = 0; k < NEWTON_MAX; k++) {
        struct mesh_jet jet;
        struct vec3 step, wb = vec3_sub(at->r, cell->b.r), wc = vec3_sub(at->r, cell->c.r);
        *edge = mesh_smooth_follow(smooth, at, false, k < FREE_STEPS ? 0 : settled);
        mesh_smooth_jet(smooth, at, &jet);
        double error = fmax(mesh_cell_residual(cell, at->r), fabs(jet.height) / longest);
        if (error < best) {
            best = error;
            found = *at;
        }
        if (error <= wanted)
            break;
        const struct vec3 rows[3] = {jet.gradient, wb, wc};
        const double f[3] = {jet.height, (vec3_norm2(wb) - cell->bd * cell->bd) / 2,
                             (vec3_norm2(wc) - cell->cd * cell->cd) / 2};
        /* the step s with rows[k] . s = -f[k], by Cramer's rule */
        struct vec3 a = vec3_cross(rows[1], rows[2]), b = vec3_cross(rows[2], rows[0]);
        struct vec3 c = vec3_cross(rows[0], rows[1]);
        double inverse = -1 / vec3_dot(rows[0], a);
        step = vec3_axpy(f[2], c, vec3_axpy(f[1], b, vec3_scale(f[0], a)));
        step = vec3_scale(inverse, step);
        if (!isfinite(inverse) || !isfinite(vec3_norm2(step)))
            return NEWTON_FAILED;
        ++*steps;
        double size = vec3_norm(step);
        at->r = vec3_axpy(size > longest ? longest / size : 1, step, at->r);
    }
    *at = found;
    *edge = mesh_smooth_follow(smooth, at, false, settled);
    if (!(best <= taken) || !mesh_smooth_is_sound(smooth, at))
        return NEWTON_FAILED;
    return *edge == MESH_NONE ? NEWTON_FOUND : NEWTON_BEYOND;
}

/* From a point on: over as many folds as D turns out to lie beyond. */
static enum newton_end search_sides(const struct mesh_smooth *smooth, const struct mesh_cell *cell,
                                    struct mesh_point *at, int *steps) {
    for (int side = 0; side < SIDES_MAX; side++) {
        int32_t edge;
        enum newton_end end = newton_on_side(smooth, cell, at, steps, &edge);
        if (end == NEWTON_FOUND)
            return mesh_cell_has_corner(cell, mesh_smooth_normal(smooth, &cell->b),
                                        mesh_smooth_normal(smooth, &cell->c), at->r,
                                        mesh_smooth_normal(smooth, at))
                       ? end
                       : NEWTON_FAILED;
        if (end == NEWTON_FAILED || smooth->mesh->twins[edge] == MESH_NONE)
            return end;
        at->triangle = smooth->mesh->twins[edge] / 3;
    }
    return NEWTON_FAILED;
}

/* The foot of a point in the plane of its triangle. */
static struct mesh_point foot_on_triangle(const struct mesh *mesh, const struct mesh_point *at) {
    struct vec3 normal = mesh->normals[at->triangle];
    struct vec3 offset = vec3_sub(at->r, mesh_corner_point(mesh, at->triangle, 0));
    return (struct mesh_point){at->triangle, vec3_axpy(-vec3_dot(offset, normal), normal, at->r)};
}

enum mesh_corner_end mesh_smooth_corner(const struct mesh_smooth *smooth,
                                        const struct mesh_cell *cell, struct mesh_corner *corner) {
    struct mesh_point d = {cell->c.triangle, cell->guess};
    enum newton_end end = NEWTON_FAILED;
    corner->steps = 0;
    if (!(cell->bd > 0) || !(cell->cd > 0) ||
        !mesh_cell_is_upright(cell, mesh_smooth_normal(smooth, &cell->a),
                              mesh_smooth_normal(smooth, &cell->b),
                              mesh_smooth_normal(smooth, &cell->c)))
        return MESH_CORNER_COLLAPSED;
    if (mesh_smooth_follow(smooth, &d, true, 0) == MESH_NONE)
        end = search_sides(smooth, cell, &d, &corner->steps);
    if (end != NEWTON_FOUND) {
        struct mesh_cell flat = *cell;
        flat.a = foot_on_triangle(smooth->mesh, &cell->a);
        flat.b = foot_on_triangle(smooth->mesh, &cell->b);
        flat.c = foot_on_triangle(smooth->mesh, &cell->c);
        enum mesh_corner_end flat_end = mesh_corner_solve(smooth->mesh, &flat, corner);
        if (flat_end != MESH_CORNER_FOUND)
            return flat_end;
        d = corner->at;
        end = search_sides(smooth, cell, &d, &corner->steps);
    }
    if (end == NEWTON_BEYOND)
        return MESH_CORNER_BOUNDARY;
    if (end == NEWTON_FAILED)
        return mesh_cell_has_collapsed(smooth->mesh, cell) ? MESH_CORNER_COLLAPSED
                                                           : MESH_CORNER_NO_CONVERGENCE;
    corner->at = d;
    corner->residual = mesh_cell_residual(cell, d.r);
    return MESH_CORNER_FOUND;
}
