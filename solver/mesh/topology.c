/* SPDX-License-Identifier: MIT */
#include "topology.h"

#include <string.h>

/* Scratch of the whole step. */
struct topology {
    struct mesh *mesh;
    struct mesh_fault *fault;
    int32_t *same;     /* of each vertex: the first vertex at exactly the same point */
    bool merged;       /* whether that is ever another one */
    int32_t *slots;    /* of the hash of points: vertex + 1, 0 is free */
    size_t slot_count; /* a power of two */
    int32_t *first;    /* of each vertex: where its edges begin in `edges` */
    int32_t *edges;    /* half-edges by the lower one of their ends */
    int32_t *seen;     /* of each vertex: the half-edge last met that ends there */
    int32_t *queue;    /* triangles of a component, as they are reached */
    uint8_t *turned;   /* whether a triangle is to be turned over */
};

/* Keeps the fault of the first triangle. */
static void note_fault(struct topology *g, enum mesh_fault_kind kind, int32_t triangle) {
    if ((size_t)triangle < g->fault->index)
        *g->fault = (struct mesh_fault){.kind = kind, .index = (size_t)triangle};
}

/* ---- vertices at the same point ---- */

/* Finds the vertices at exactly the same point, by a hash of open addressing. It mixes
 * the bits of the coordinates; -0 and 0 are the same. */
static void find_same_points(struct topology *g) {
    const struct vec3 *vertices = g->mesh->vertices;
    for (size_t v = 0; v < g->mesh->vertex_count; v++) {
        struct vec3 p = vertices[v];
        const double coordinates[3] = {p.x + 0.0, p.y + 0.0, p.z + 0.0};
        uint64_t hash = 0;
        for (int k = 0; k < 3; k++) {
            uint64_t bits;
            memcpy(&bits, &coordinates[k], sizeof bits);
            hash = (hash ^ bits) * UINT64_C(0x9E3779B97F4A7C15);
            hash ^= hash >> 29;
            hash *= UINT64_C(0xBF58476D1CE4E5B9);
            hash ^= hash >> 32;
        }
        size_t at = (size_t)hash & (g->slot_count - 1);
        for (; g->slots[at]; at = (at + 1) & (g->slot_count - 1)) {
            struct vec3 other = vertices[g->slots[at] - 1];
            if (other.x == p.x && other.y == p.y && other.z == p.z)
                break;
        }
        if (!g->slots[at])
            g->slots[at] = (int32_t)v + 1;
        g->same[v] = g->slots[at] - 1;
        g->merged = g->merged || (size_t)g->same[v] != v;
    }
}

/* ---- neighbours ---- */

/* The k-th vertex on from the start of a half-edge, by its index or (`by_point`) by its point: 0
 * and 1 are the edge's ends, 2 is the corner opposite. */
static int32_t vertex_of(const struct topology *g, bool by_point, int32_t edge, int k) {
    int32_t v = g->mesh->corners[edge / 3][(edge + k) % 3];
    return by_point ? g->same[v] : v;
}

/* The lower one of its two ends, or the other. */
static int32_t edge_end(const struct topology *g, bool by_point, int32_t edge, bool lower) {
    int32_t a = vertex_of(g, by_point, edge, 0), b = vertex_of(g, by_point, edge, 1);
    return (a < b) == lower ? a : b;
}

/* Joins the half-edges without a twin that have the same ends: sorted by the lower one of them (a
 * counting sort), those with the same upper one meet. */
static void join_half_edges(struct topology *g, bool by_point) {
    int32_t count = (int32_t)(3 * g->mesh->triangle_count), *twins = g->mesh->twins;
    size_t m = g->mesh->vertex_count;
    memset(g->first, 0, (m + 1) * sizeof *g->first);
    for (int32_t e = 0; e < count; e++)
        if (twins[e] == MESH_NONE)
            g->first[edge_end(g, by_point, e, true) + 1]++;
    for (size_t v = 0; v < m; v++)
        g->first[v + 1] += g->first[v];
    for (int32_t e = 0; e < count; e++)
        if (twins[e] == MESH_NONE)
            g->edges[g->first[edge_end(g, by_point, e, true)]++] = e;
    memmove(g->first + 1, g->first, m * sizeof *g->first);
    g->first[0] = 0;
    memset(g->seen, 0xff, m * sizeof *g->seen);
    for (size_t v = 0; v < m; v++)
        for (int32_t k = g->first[v]; k < g->first[v + 1]; k++) {
            int32_t edge = g->edges[k], *seen = &g->seen[edge_end(g, by_point, edge, false)];
            if (*seen == MESH_NONE || edge_end(g, by_point, *seen, true) != (int32_t)v) {
                *seen = edge;
                continue;
            }
            /* `edge` lies where `*seen`, an earlier one, does */
            int32_t opposite = vertex_of(g, true, edge, 2), third = twins[*seen];
            if (vertex_of(g, true, *seen, 2) == opposite ||
                (third != MESH_NONE && vertex_of(g, true, third, 2) == opposite))
                note_fault(g, MESH_FAULT_DUPLICATE, edge / 3);
            else if (third != MESH_NONE)
                note_fault(g, MESH_FAULT_NON_MANIFOLD, edge / 3);
            if (third == MESH_NONE) {
                twins[*seen] = edge;
                twins[edge] = *seen;
            }
        }
}

/* ---- windings ---- */

static enum status connect_and_wind(struct topology *g) {
    struct mesh *mesh = g->mesh;
    g->fault->index = SIZE_MAX;
    find_same_points(g);
    memset(mesh->twins, 0xff, 3 * mesh->triangle_count * sizeof *mesh->twins);
    join_half_edges(g, false);
    if (g->merged)
        join_half_edges(g, true);
    if (g->fault->index != SIZE_MAX)
        return STATUS_INVALID;
    memset(mesh->component, 0xff, mesh->triangle_count * sizeof *mesh->component);
    for (size_t seed = 0; seed < mesh->triangle_count; seed++) {
        size_t length = 1;
        double area[2] = {0, 0};
        if (mesh->component[seed] != MESH_NONE)
            continue;
        /* a component, wound as its first triangle, or the other way when most of the area was */
        mesh->component[seed] = (int32_t)mesh->component_count++;
        g->queue[0] = (int32_t)seed;
        for (size_t at = 0; at < length; at++) {
            int32_t t = g->queue[at];
            area[g->turned[t]] += mesh_twice_area(mesh, t);
            /* neighbours whose edges run the same way are wound differently */
            for (int32_t edge = 3 * t; edge < 3 * t + 3; edge++) {
                int32_t twin = mesh->twins[edge], next = twin / 3;
                if (twin == MESH_NONE)
                    continue;
                bool same_way = vertex_of(g, true, edge, 0) == vertex_of(g, true, twin, 0);
                uint8_t turned = g->turned[t] ^ (uint8_t)same_way;
                if (mesh->component[next] == MESH_NONE) {
                    mesh->component[next] = mesh->component[t];
                    g->turned[next] = turned;
                    g->queue[length++] = next;
                } else if (g->turned[next] != turned) {
                    note_fault(g, MESH_FAULT_ONE_SIDED, next > t ? next : t);
                }
            }
        }
        for (size_t at = 0; at < length && area[1] > area[0]; at++)
            g->turned[g->queue[at]] ^= 1;
    }
    return g->fault->index == SIZE_MAX ? STATUS_OK : STATUS_INVALID;
}

enum status mesh_topology_find(struct mesh *mesh, struct arena *arena, struct mesh_fault *fault) {
    struct topology g = {.mesh = mesh, .fault = fault, .slot_count = 16};
    struct arena_mark mark = arena_mark(arena);
    size_t n = mesh->triangle_count, m = mesh->vertex_count;
    while (g.slot_count < 2 * m)
        g.slot_count *= 2;
    g.same = arena_alloc(arena, m, sizeof *g.same);
    g.slots = arena_alloc(arena, g.slot_count, sizeof *g.slots);
    g.first = arena_alloc(arena, m + 1, sizeof *g.first);
    g.edges = arena_alloc(arena, n, 3 * sizeof *g.edges);
    g.seen = arena_alloc(arena, m, sizeof *g.seen);
    g.queue = arena_alloc(arena, n, sizeof *g.queue);
    g.turned = arena_alloc(arena, n, sizeof *g.turned);
    bool room = g.same && g.slots && g.first && g.edges && g.seen && g.queue && g.turned;
    enum status status = room ? connect_and_wind(&g) : STATUS_OUT_OF_MEMORY;
    /* Turning a triangle over swaps its corners 1 and 2, and so its edges 0 and 2. */
    for (size_t t = 0; status == STATUS_OK && t < n; t++) {
        int32_t *twin = &mesh->twins[3 * t], *corner = mesh->corners[t];
        for (int k = 0; k < 3; k++)
            if (twin[k] != MESH_NONE && g.turned[twin[k] / 3])
                twin[k] = 3 * (twin[k] / 3) + 2 - twin[k] % 3;
        if (!g.turned[t])
            continue;
        int32_t first = twin[0], second = corner[1];
        twin[0] = twin[2];
        twin[2] = first;
        corner[1] = corner[2];
        corner[2] = second;
        mesh->normals[t] = vec3_scale(-1, mesh->normals[t]);
    }
    arena_rewind(arena, mark);
    return status;
}
