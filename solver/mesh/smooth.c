/* SPDX-License-Identifier: MIT */
#include "smooth.h"

enum { FOLLOW_MAX = 4000, PROJECT_MAX = 4 };

/* A foot this share of a triangle's height outside is inside: between triangles, and at the rim,
 * which runs beside the surface's own edge by O(h^3) where the surface bends: as a share of the
 * height of O(h^2), like 1 less the cosine between the normals there. */
static const double between = 1e-12, rim = 1e-9, rim_bend = 1;

/* The arc over a chord that turns by 30 degrees rises by a fifteenth of it; twice that. Over such
 * an edge a foot may be this share of the triangles' heights beyond both. */
static const double bulge_most = 0.13, outside_most = 0.1;

enum status mesh_smooth_make(const struct mesh *mesh, struct arena *arena,
                             struct mesh_smooth **smooth) {
    int32_t count = (int32_t)mesh->triangle_count, patches = 0;
    struct mesh_smooth *made = arena_alloc(arena, 1, sizeof *made);
    if (!made)
        return STATUS_OUT_OF_MEMORY;
    made->mesh = mesh;
    *smooth = made;
    enum status status = mesh_fits_make(mesh, arena, &made->fits);
    if (status != STATUS_OK)
        return status;
    made->patch = arena_take(arena, mesh->triangle_count, sizeof *made->patch);
    struct arena_mark mark = arena_mark(arena);
    int32_t *stack = arena_take(arena, mesh->triangle_count, sizeof *stack);
    if (!made->patch || !stack)
        return STATUS_OUT_OF_MEMORY;
    /* numbers the patches; each spreads over a stack of triangles */
    for (int32_t t = 0; t < count; t++)
        made->patch[t] = MESH_NONE;
    for (int32_t first = 0; first < count; first++) {
        int32_t height = 0;
        if (made->patch[first] != MESH_NONE)
            continue;
        stack[height++] = first;
        made->patch[first] = patches;
        while (height > 0) {
            int32_t t = stack[--height];
            for (int32_t edge = 3 * t; edge < 3 * t + 3; edge++) {
                int32_t next = mesh->twins[edge] == MESH_NONE ? t : mesh->twins[edge] / 3;
                if (made->patch[next] != MESH_NONE || mesh_is_fold(mesh, edge))
                    continue;
                made->patch[next] = patches;
                stack[height++] = next;
            }
        }
        patches++;
    }
    arena_rewind(arena, mark);
    return STATUS_OK;
}

static const struct mesh_fit *fit_at(const struct mesh_smooth *smooth, int32_t t, int corner) {
    return &smooth->fits.fit[smooth->fits.of[t][corner]];
}

void mesh_smooth_jet(const struct mesh_smooth *smooth, const struct mesh_point *at,
                     struct mesh_jet *jet) {
    double weights[3], sum = 0;
    mesh_weights(smooth->mesh, at, weights);
    for (int k = 0; k < 3; k++) {
        weights[k] = fmax(weights[k], 0); /* beyond the rim as at it */
        sum += weights[k];
    }
    *jet = (struct mesh_jet){.height = 0};
    for (int k = 0; k < 3; k++) {
        if (!(weights[k] > 0))
            continue;
        /* the weight times the fit's F and derivatives */
        const struct mesh_fit *fit = fit_at(smooth, at->triangle, k);
        struct vec3 offset = vec3_sub(at->r, fit->origin);
        double weight = weights[k] / sum;
        double x = vec3_dot(offset, fit->x), y = vec3_dot(offset, fit->y);
        const double *c = fit->slope, *s = fit->second, *t = fit->third;
        double p = c[0] * x + c[1] * y + s[0] * x * x + s[1] * x * y + s[2] * y * y +
                   t[0] * x * x * x + t[1] * x * x * y + t[2] * x * y * y + t[3] * y * y * y;
        double px =
            c[0] + 2 * s[0] * x + s[1] * y + 3 * t[0] * x * x + 2 * t[1] * x * y + t[2] * y * y;
        double py =
            c[1] + s[1] * x + 2 * s[2] * y + t[1] * x * x + 2 * t[2] * x * y + 3 * t[3] * y * y;
        double pxx = weight * (2 * s[0] + 6 * t[0] * x + 2 * t[1] * y);
        double pxy = weight * (s[1] + 2 * t[1] * x + 2 * t[2] * y);
        double pyy = weight * (2 * s[2] + 2 * t[2] * x + 6 * t[3] * y);
        struct vec3 g = vec3_axpy(-px, fit->x, vec3_axpy(-py, fit->y, fit->normal));
        struct vec3 u = vec3_axpy(pxy, fit->y, vec3_scale(pxx, fit->x));
        struct vec3 v = vec3_axpy(pyy, fit->y, vec3_scale(pxy, fit->x));
        jet->height += weight * (vec3_dot(offset, fit->normal) - p);
        jet->gradient = vec3_axpy(weight, g, jet->gradient);
        jet->xx += u.x * fit->x.x + v.x * fit->y.x;
        jet->xy += u.x * fit->x.y + v.x * fit->y.y;
        jet->xz += u.x * fit->x.z + v.x * fit->y.z;
        jet->yy += u.y * fit->x.y + v.y * fit->y.y;
        jet->yz += u.y * fit->x.z + v.y * fit->y.z;
        jet->zz += u.z * fit->x.z + v.z * fit->y.z;
    }
}

struct vec3 mesh_smooth_normal(const struct mesh_smooth *smooth, const struct mesh_point *at) {
    struct mesh_jet jet;
    mesh_smooth_jet(smooth, at, &jet);
    return vec3_unit(jet.gradient);
}

double mesh_jet_form(const struct mesh_jet *jet, struct vec3 a, struct vec3 b) {
    struct vec3 sum = {jet->xx * b.x + jet->xy * b.y + jet->xz * b.z,
                       jet->xy * b.x + jet->yy * b.y + jet->yz * b.z,
                       jet->xz * b.x + jet->yz * b.y + jet->zz * b.z};
    return vec3_dot(a, sum) / vec3_norm(jet->gradient);
}

int32_t mesh_smooth_follow(const struct mesh_smooth *smooth, struct mesh_point *at, bool folds,
                           double slack) {
    const struct mesh *mesh = smooth->mesh;
    int32_t before = MESH_NONE;
    for (int step = 0; step < FOLLOW_MAX; step++) {
        int32_t t = at->triangle, way = MESH_NONE, stop = MESH_NONE;
        double weight[3], least = -fmax(slack, between), beyond = 0;
        mesh_weights(mesh, at, weight);
        for (int k = 0; k < 3; k++) {
            int32_t edge = 3 * t + k, twin = mesh->twins[edge];
            double w = weight[(k + 2) % 3];
            bool open = twin != MESH_NONE && (folds || !mesh_is_fold(mesh, edge));
            if (open && w < least) {
                least = w;
                way = edge;
            } else if (!open && w < beyond) {
                beyond = w;
                stop = edge;
            }
        }
        int32_t next = way == MESH_NONE ? MESH_NONE : mesh->twins[way] / 3;
        if (next == MESH_NONE || next == before) { /* over an edge, beyond both of its triangles */
            double cosine = 1;
            for (int k = 0; k < 3; k++)
                cosine = fmin(cosine, vec3_dot(mesh->normals[t], fit_at(smooth, t, k)->normal));
            return beyond < -(rim + rim_bend * (1 - cosine)) ? stop : MESH_NONE;
        }
        before = t;
        at->triangle = next;
    }
    return MESH_NONE;
}

bool mesh_smooth_is_sound(const struct mesh_smooth *smooth, const struct mesh_point *at) {
    struct vec3 p[3];
    mesh_corner_points(smooth->mesh, at->triangle, p);
    double height = vec3_dot(vec3_sub(at->r, p[0]), smooth->mesh->normals[at->triangle]);
    double longest2 = 0, weight[3];
    mesh_weights(smooth->mesh, at, weight);
    if (fmin(weight[0], fmin(weight[1], weight[2])) < -outside_most)
        return false;
    for (int k = 0; k < 3; k++)
        longest2 = fmax(longest2, vec3_norm2(vec3_sub(p[(k + 1) % 3], p[k])));
    return height * height <= bulge_most * bulge_most * longest2;
}

void mesh_smooth_project(const struct mesh_smooth *smooth, struct mesh_point *at) {
    for (int k = 0; k < PROJECT_MAX; k++) {
        struct mesh_jet jet;
        mesh_smooth_jet(smooth, at, &jet);
        double step = jet.height / vec3_norm2(jet.gradient);
        at->r = vec3_axpy(-step, jet.gradient, at->r);
    }
}
