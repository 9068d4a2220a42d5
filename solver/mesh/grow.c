/* SPDX-License-Identifier: MIT */
#include "grow.h"

#include "fit.h"
#include "solver/angle.h"
#include <stdlib.h>
#include <string.h>

/* Of facets that are meant to be smooth or flat. */
static const double rounding_deg = 1e-6;

double mesh_edge_fold_deg(const struct mesh *mesh, int32_t half) {
    int32_t twin = mesh->twins[half];
    if (twin == MESH_NONE)
        return 180;
    struct vec3 a = mesh->normals[half / 3], b = mesh->normals[twin / 3];
    return angle_atan2_deg(vec3_norm(vec3_cross(a, b)), vec3_dot(a, b));
}

/* Gives `number` to the triangles on the stack, which have it, and to all that are reached from
 * them over triangles that have none (0). */
static void flood(const struct mesh *mesh, double up_to_deg, int32_t *stack, size_t depth,
                  int32_t number, int32_t *numbers) {
    while (depth > 0) {
        int32_t triangle = stack[--depth];
        for (int32_t half = 3 * triangle; half < 3 * triangle + 3; half++) {
            int32_t twin = mesh->twins[half];
            if (twin == MESH_NONE || numbers[twin / 3] ||
                mesh_edge_fold_deg(mesh, half) > up_to_deg + rounding_deg)
                continue;
            numbers[twin / 3] = number;
            stack[depth++] = twin / 3;
        }
    }
}

enum status mesh_grow(const struct mesh *mesh, double up_to_deg, struct arena *arena,
                      int32_t *reached) {
    struct arena_mark mark = arena_mark(arena);
    int32_t *stack = arena_alloc(arena, mesh->triangle_count, sizeof *stack);
    size_t depth = 0;
    if (!stack)
        return STATUS_OUT_OF_MEMORY;
    for (size_t t = 0; t < mesh->triangle_count; t++)
        if (reached[t])
            stack[depth++] = (int32_t)t;
    flood(mesh, up_to_deg, stack, depth, 1, reached);
    arena_rewind(arena, mark);
    return STATUS_OK;
}

size_t mesh_faces(const struct mesh *mesh, struct arena *arena, int32_t *face) {
    struct arena_mark mark = arena_mark(arena);
    int32_t *stack = arena_alloc(arena, mesh->triangle_count, sizeof *stack), count = 0;
    if (!stack)
        return 0;
    for (size_t t = 0; t < mesh->triangle_count; t++)
        face[t] = 0;
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        if (face[t])
            continue;
        face[t] = ++count;
        stack[0] = (int32_t)t;
        flood(mesh, MESH_FOLD_DEG, stack, 1, count, face);
    }
    for (size_t t = 0; t < mesh->triangle_count; t++)
        face[t]--;
    arena_rewind(arena, mark);
    return (size_t)count;
}

enum status mesh_part(const struct mesh *mesh, const int32_t *marked, struct arena *arena,
                      struct mesh **part) {
    struct mesh_source source = {.vertices = mesh->vertices, .vertex_count = mesh->vertex_count};
    int32_t(*triangles)[3] = arena_alloc(arena, mesh->triangle_count, sizeof *triangles);
    if (!triangles)
        return STATUS_OUT_OF_MEMORY;
    for (size_t t = 0; t < mesh->triangle_count; t++)
        if (marked[t])
            memcpy(triangles[source.triangle_count++], mesh->corners[t], sizeof *triangles);
    source.triangles = (const int32_t(*)[3])triangles;
    return mesh_make(&source, arena, part, NULL);
}

static int compare_openings(const void *x, const void *y) {
    const struct mesh_opening *a = x, *b = y;
    return (a->length < b->length) - (a->length > b->length);
}

/* The loop that half-edge `half` begins; its edges are marked as seen. */
static struct mesh_opening measure_opening(const struct mesh *mesh, int32_t half, uint8_t *seen) {
    struct mesh_opening opening = {0};
    for (int32_t at = half; !seen[at]; at = mesh_next_on_border(mesh, at)) {
        struct vec3 edge = mesh_edge_vector(mesh, at);
        struct vec3 from = mesh_corner_point(mesh, at / 3, at % 3);
        double length = vec3_norm(edge);
        seen[at] = 1;
        opening.edges++;
        opening.length += length;
        opening.centre = vec3_axpy(length, vec3_axpy(0.5, edge, from), opening.centre);
    }
    opening.centre = vec3_scale(1 / opening.length, opening.centre);
    return opening;
}

enum status mesh_openings(const struct mesh *mesh, struct arena *arena,
                          struct mesh_opening **openings, size_t *count) {
    size_t halves = 3 * mesh->triangle_count, rim = 0;
    for (size_t k = 0; k < mesh->component_count; k++)
        rim += mesh->components[k].rim_count;
    uint8_t *seen = arena_alloc(arena, halves, 1);
    *count = 0;
    *openings = arena_alloc(arena, rim + 1, sizeof **openings);
    if (!seen || !*openings)
        return STATUS_OUT_OF_MEMORY;
    for (size_t half = 0; half < halves; half++)
        if (mesh->twins[half] == MESH_NONE && !seen[half])
            (*openings)[(*count)++] = measure_opening(mesh, (int32_t)half, seen);
    qsort(*openings, *count, sizeof **openings, compare_openings);
    return STATUS_OK;
}
