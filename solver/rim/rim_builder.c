/* SPDX-License-Identifier: MIT */
#include "rim_builder.h"

#include <math.h>

void rim_builder_add_vertex(struct rim_builder *b, const struct rim_vertex *vertex) {
    struct rim_edges *e = b->edges;
    if (b->failed)
        return;
    if (e->vertex_count == e->vertex_room)
        e->vertices = arena_enlarge(b->march->arena, e->vertices, e->vertex_count,
                                    sizeof *e->vertices, &e->vertex_room);
    b->failed = !e->vertices;
    if (!b->failed)
        e->vertices[e->vertex_count++] = *vertex;
}

void rim_builder_add_point(struct rim_builder *b, double u, double v) {
    struct surface_jet jet;
    surface_jet_at(b->march->surface, &b->march->cursor, u, v, &jet);
    rim_builder_add_vertex(b, &(struct rim_vertex){.uv = {u, v}, .r = jet.r});
}

void rim_builder_end_loop(struct rim_builder *b, bool closed) {
    struct rim_edges *e = b->edges;
    const struct rim_loop *last = e->loop_count ? &e->loops[e->loop_count - 1] : NULL;
    size_t first = last ? last->first + last->count + 1 : 0;
    if (b->failed)
        return;
    struct rim_vertex begin = e->vertices[first];
    begin.leaps = false;
    if (!closed)
        rim_builder_add_vertex(b, &begin);
    if (e->loop_count == e->loop_room && !b->failed)
        e->loops = arena_enlarge(b->march->arena, e->loops, e->loop_count, sizeof *e->loops,
                                 &e->loop_room);
    b->failed = b->failed || !e->loops;
    if (!b->failed)
        e->loops[e->loop_count++] = (struct rim_loop){first, e->vertex_count - first - 1};
}

static double chord_deviation(const struct surface_jet *at_m, const double a[2], const double c[2],
                              const double m[2], double *share) {
    double chord[2] = {c[0] - a[0], c[1] - a[1]}, off[2] = {m[0] - a[0], m[1] - a[1]};
    struct vec3 along = vec3_axpy(chord[1], at_m->v, vec3_scale(chord[0], at_m->u));
    struct vec3 to = vec3_axpy(off[1], at_m->v, vec3_scale(off[0], at_m->u));
    double length2 = vec3_norm2(along), at = length2 > 0 ? vec3_dot(to, along) / length2 : 0;
    *share = at < 0 ? 0 : at > 1 ? 1 : at;
    return vec3_norm(vec3_axpy(-*share, along, to));
}

double rim_builder_deviation(const struct rim_builder *b, const struct surface *surface,
                             const double a[2], const double c[2], const double m[2],
                             double *share) {
    struct surface_jet at_m;
    surface_jet_at(surface, &b->march->cursor, m[0], m[1], &at_m);
    return chord_deviation(&at_m, a, c, m, share);
}

uint8_t *rim_builder_keep_points(struct rim_builder *b, const struct surface *surface,
                                 const double (*uv)[2], size_t count) {
    /* Douglas and Peucker: of the stretch between two that are kept the one farthest off, as long
     * as it is too far. */
    size_t(*stack)[2] = arena_alloc(b->march->arena, count + 4, sizeof *stack);
    struct surface_jet *jets = arena_take(b->march->arena, count, sizeof *jets);
    uint8_t *kept = arena_alloc(b->march->arena, count, sizeof *kept);
    size_t depth = 0;
    b->failed = b->failed || !stack || !jets || !kept;
    if (b->failed)
        return NULL;
    for (size_t k = 0; k < count; k++)
        surface_jet_at(surface, &b->march->cursor, uv[k][0], uv[k][1], &jets[k]);
    for (size_t quarter = 0; quarter < 4; quarter++) {
        size_t first = quarter * (count - 1) / 4, last = (quarter + 1) * (count - 1) / 4;
        kept[first] = kept[last] = 1;
        stack[depth][0] = first;
        stack[depth++][1] = last;
    }
    while (depth > 0) {
        size_t first = stack[--depth][0], last = stack[depth][1], at = first;
        double most = b->tolerance;
        for (size_t k = first + 1; k < last; k++) {
            double share, off = chord_deviation(&jets[k], uv[first], uv[last], uv[k], &share);
            at = off > most ? k : at;
            most = fmax(most, off);
        }
        if (at == first)
            continue;
        kept[at] = 1;
        stack[depth][0] = first;
        stack[depth++][1] = at;
        stack[depth][0] = at;
        stack[depth++][1] = last;
    }
    return kept;
}
