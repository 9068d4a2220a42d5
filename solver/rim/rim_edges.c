/* SPDX-License-Identifier: MIT */
#include "rim_builder.h"

#include <math.h>
#include <string.h>

/* Tangents whose sine is less than this, beside singular corners, give no sure normal; nor do those
 * that vanish at poles. */
static const double parallel = 1e-6;

void rim_edges_point(struct march *march, const struct rim_vertex *from,
                     const struct rim_vertex *to, double t, struct rim_edge_point *spot) {
    struct surface_jet *jet = &spot->jet;
    double duv[2];
    spot->face = from->face;
    spot->t = t;
    for (int k = 0; k < 2; k++) {
        duv[k] = to->uv[k] - from->uv[k];
        spot->uv[k] = t == 1 ? to->uv[k] : from->uv[k] + t * duv[k];
    }
    if (!march->surface) {
        memcpy(spot->uv, from->uv, sizeof spot->uv);
        spot->dr = vec3_sub(to->r, from->r);
        spot->r = vec3_axpy(t, spot->dr, from->r);
        spot->normal = march->mesh->normals[from->face];
        return;
    }
    const struct surface *surface = rim_edges_surface(march, from->face);
    surface_jet_at(surface, &march->cursor, spot->uv[0], spot->uv[1], jet);
    spot->r = jet->r;
    spot->dr = vec3_axpy(duv[1], jet->v, vec3_scale(duv[0], jet->u));
    spot->normal = vec3_scale(surface->side, vec3_cross(jet->u, jet->v));
    double nu = vec3_norm2(jet->u), nv = vec3_norm2(jet->v), area = vec3_norm2(spot->normal);
    const double *least = surface->least_tangent2;
    if (!(nu > least[0] && nv > least[1] && area > parallel * parallel * nu * nv))
        spot->normal = vec3_make(0, 0, 0);
}

/* ---- the border of the domain ---- */

/* The sides of the domain round which the other direction closes, each a ring of its own; else the
 * whole border. */
static void add_border(struct rim_builder *b, const struct rim_window *w) {
    if (w->endless[0] && w->endless[1])
        return;
    for (int k = 0; k < 2; k++)
        for (int end = 0; end < 2 && w->endless[1 - k]; end++)
            if (!rim_builder_is_pole(b, k, end)) {
                bool forward = (k == 1) == (end == 0);
                for (int quarter = 0; quarter <= 4; quarter++) {
                    double share = (forward ? quarter : 4 - quarter) / 4.0, uv[2];
                    uv[k] = end ? w->high[k] : w->low[k];
                    uv[1 - k] = w->low[1 - k] + share * w->length[1 - k];
                    rim_builder_add_point(b, uv[0], uv[1]);
                }
                rim_builder_end_loop(b, true);
            }
    if (w->endless[0] || w->endless[1])
        return;
    rim_builder_add_point(b, w->low[0], w->low[1]);
    rim_builder_add_point(b, w->high[0], w->low[1]);
    rim_builder_add_point(b, w->high[0], w->high[1]);
    rim_builder_add_point(b, w->low[0], w->high[1]);
    rim_builder_end_loop(b, false);
}

/* ---- meshes ---- */

static void add_mesh_borders(struct rim_builder *b) {
    const struct mesh *mesh = b->march->mesh;
    int32_t halves = (int32_t)(3 * mesh->triangle_count);
    int32_t own = mesh->component[march_mesh_point_of(&b->march->start.point).triangle];
    uint8_t *seen = arena_alloc(b->march->arena, (size_t)halves, sizeof *seen);
    b->failed = !seen;
    for (int32_t first = 0; !b->failed && first < halves; first++) {
        if (mesh->twins[first] != MESH_NONE || seen[first] || mesh->component[first / 3] != own)
            continue;
        for (int32_t half = first; !seen[half]; half = mesh_next_on_border(mesh, half)) {
            struct mesh_point place = {half / 3, mesh_corner_point(mesh, half / 3, half % 3)};
            struct rim_vertex vertex = {.face = half / 3, .r = place.r};
            seen[half] = 1;
            mesh_parameters(mesh, &place, vertex.uv);
            rim_builder_add_vertex(b, &vertex);
        }
        rim_builder_end_loop(b, false);
    }
}

enum status rim_edges_make(struct march *march, double tolerance, struct rim_edges *edges,
                           struct cut_fault *fault) {
    struct rim_builder b = {.march = march, .edges = edges, .tolerance = tolerance};
    *edges = (struct rim_edges){.sights = 1};
    if (!march->surface)
        add_mesh_borders(&b);
    else if (march->surface->shell)
        rim_builder_add_shell(&b);
    else {
        struct rim_window window;
        for (int k = 0; k < 2; k++) {
            const struct surface_axis *axis = &march->surface->axis[k];
            double turn = march->mesh ? HUGE_VAL : surface_point_cut_turn(march->surface, k);
            bool cut = axis->closed && turn < HUGE_VAL && !march->cut.passed;
            window.low[k] = surface_axis_lower(axis);
            window.length[k] = surface_axis_upper(axis) - window.low[k];
            if (cut)
                window.low[k] = march->cut.centre[k] - turn;
            window.high[k] = window.low[k] + window.length[k];
            window.endless[k] = axis->closed && !cut;
        }
        if (march->trim)
            rim_builder_add_trims(&b, &window);
        else
            add_border(&b, &window);
    }
    if (b.failed)
        return STATUS_OUT_OF_MEMORY;
    return march->cuts ? rim_builder_add_cuts(&b, fault) : STATUS_OK;
}
