/* SPDX-License-Identifier: MIT */
#include "topology.h"

#include <string.h>

/* Scratch of the whole step. */
struct topology {
    struct mesh *mesh;
    struct mesh_fault *fault;
    int32_t *place;    /* of each vertex: the first vertex at exactly its place */
    bool merged;       /* whether that is ever another one */
    int32_t *slots;    /* of the hash of places: vertex + 1, 0 is free */
    size_t slot_count; /* a power of two */
    int32_t *first;    /* of each vertex: where its edges begin in `edges` */
    int32_t *edges;    /* half-edges by the lower one of their ends */
    int32_t *seen;     /* of each vertex: the half-edge last met that ends there */
    int32_t *queue;    /* triangles of a component, as they are reached */
    uint8_t *turned;   /* whether a triangle is to be turned over */
};

static size_t ceil_power(size_t n) {
    size_t power = 16;
    while (power < n)
        power *= 2;
    return power;
}

static bool alloc_scratch(struct topology *g, struct arena *arena) {
    size_t n = g->mesh->triangle_count, m = g->mesh->vertex_count;
    g->slot_count = ceil_power(2 * m);
    g->place = arena_alloc(arena, m, sizeof *g->place);
    g->slots = arena_alloc(arena, g->slot_count, sizeof *g->slots);
    g->first = arena_alloc(arena, m + 1, sizeof *g->first);
    g->edges = arena_alloc(arena, n, 3 * sizeof *g->edges);
    g->seen = arena_alloc(arena, m, sizeof *g->seen);
    g->queue = arena_alloc(arena, n, sizeof *g->queue);
    g->turned = arena_alloc(arena, n, sizeof *g->turned);
    return g->place && g->slots && g->first && g->edges && g->seen && g->queue && g->turned;
}

/* Keeps the fault of the first triangle. */
static void blame(struct topology *g, enum mesh_fault_kind kind, int32_t triangle) {
    if ((size_t)triangle < g->fault->index)
        *g->fault = (struct mesh_fault){.kind = kind, .index = (size_t)triangle};
}

/* ---- vertices in the same place ---- */

/* Mixes the coordinates' bits; -0 and 0 are the same place. */
static uint64_t hash_point(struct vec3 p) {
    const double at[3] = {p.x + 0.0, p.y + 0.0, p.z + 0.0};
    uint64_t hash = 0;
    for (int k = 0; k < 3; k++) {
        uint64_t bits;
        memcpy(&bits, &at[k], sizeof bits);
        hash = (hash ^ bits) * UINT64_C(0x9E3779B97F4A7C15);
        hash ^= hash >> 29;
        hash *= UINT64_C(0xBF58476D1CE4E5B9);
        hash ^= hash >> 32;
    }
    return hash;
}

static bool same_point(struct vec3 a, struct vec3 b) {
    return a.x == b.x && a.y == b.y && a.z == b.z;
}

static void find_places(struct topology *g) {
    const struct vec3 *vertices = g->mesh->vertices;
    for (size_t v = 0; v < g->mesh->vertex_count; v++) {
        size_t at = (size_t)hash_point(vertices[v]) & (g->slot_count - 1);
        while (g->slots[at] && !same_point(vertices[g->slots[at] - 1], vertices[v]))
            at = (at + 1) & (g->slot_count - 1);
        if (!g->slots[at])
            g->slots[at] = (int32_t)v + 1;
        g->place[v] = g->slots[at] - 1;
        g->merged = g->merged || (size_t)g->place[v] != v;
    }
}

/* ---- neighbours ---- */

/* The k-th vertex on from the start of a half-edge, by its index or (`by_place`) by its place: 0
 * and 1 are the edge's ends, 2 is the corner opposite. */
static int32_t end_of(const struct topology *g, bool by_place, int32_t edge, int k) {
    int32_t v = g->mesh->corners[edge / 3][(edge + k) % 3];
    return by_place ? g->place[v] : v;
}

static int32_t lower_end(const struct topology *g, bool by_place, int32_t edge) {
    int32_t a = end_of(g, by_place, edge, 0), b = end_of(g, by_place, edge, 1);
    return a < b ? a : b;
}

static int32_t upper_end(const struct topology *g, bool by_place, int32_t edge) {
    int32_t a = end_of(g, by_place, edge, 0), b = end_of(g, by_place, edge, 1);
    return a < b ? b : a;
}

/* Half-edges without a twin, sorted by the lower one of their ends (a counting sort). */
static void sort_edges(struct topology *g, bool by_place) {
    int32_t count = (int32_t)(3 * g->mesh->triangle_count);
    size_t m = g->mesh->vertex_count;
    memset(g->first, 0, (m + 1) * sizeof *g->first);
    for (int32_t e = 0; e < count; e++)
        if (g->mesh->twins[e] == MESH_NONE)
            g->first[lower_end(g, by_place, e) + 1]++;
    for (size_t v = 0; v < m; v++)
        g->first[v + 1] += g->first[v];
    for (int32_t e = 0; e < count; e++)
        if (g->mesh->twins[e] == MESH_NONE)
            g->edges[g->first[lower_end(g, by_place, e)]++] = e;
    memmove(g->first + 1, g->first, m * sizeof *g->first);
    g->first[0] = 0;
}

static bool same_opposite(const struct topology *g, int32_t a, int32_t b) {
    return end_of(g, true, a, 2) == end_of(g, true, b, 2);
}

/* Half-edge `b` lies where `a`, an earlier one, does. */
static void join(struct topology *g, int32_t a, int32_t b) {
    int32_t *twins = g->mesh->twins;
    bool third = twins[a] != MESH_NONE;
    if (same_opposite(g, a, b) || (third && same_opposite(g, twins[a], b)))
        blame(g, MESH_FAULT_DUPLICATE, b / 3);
    else if (third)
        blame(g, MESH_FAULT_NON_MANIFOLD, b / 3);
    if (third)
        return;
    twins[a] = b;
    twins[b] = a;
}

/* Joins the half-edges without a twin that have the same ends. */
static void join_edges(struct topology *g, bool by_place) {
    sort_edges(g, by_place);
    memset(g->seen, 0xff, g->mesh->vertex_count * sizeof *g->seen);
    for (size_t v = 0; v < g->mesh->vertex_count; v++)
        for (int32_t k = g->first[v]; k < g->first[v + 1]; k++) {
            int32_t edge = g->edges[k], *seen = &g->seen[upper_end(g, by_place, edge)];
            if (*seen != MESH_NONE && lower_end(g, by_place, *seen) == (int32_t)v)
                join(g, *seen, edge);
            else
                *seen = edge;
        }
}

/* ---- windings ---- */

/* Puts the neighbours of triangle t, the newest but for `*length` in the queue, into its component,
 * wound as t is to be. Neighbours whose edges run the same way are wound differently. */
static void reach_neighbours(struct topology *g, int32_t t, size_t *length) {
    struct mesh *mesh = g->mesh;
    for (int k = 0; k < 3; k++) {
        int32_t edge = 3 * t + k, twin = mesh->twins[edge];
        if (twin == MESH_NONE)
            continue;
        bool same_way = end_of(g, true, edge, 0) == end_of(g, true, twin, 0);
        uint8_t turned = g->turned[t] ^ (uint8_t)same_way;
        int32_t next = twin / 3;
        if (mesh->component[next] == MESH_NONE) {
            mesh->component[next] = mesh->component[t];
            g->turned[next] = turned;
            g->queue[(*length)++] = next;
        } else if (g->turned[next] != turned) {
            blame(g, MESH_FAULT_ONE_SIDED, next > t ? next : t);
        }
    }
}

/* The component of triangle `seed`, wound as it is, or the other way when most of the area was. */
static void flood(struct topology *g, int32_t seed) {
    size_t length = 1;
    double area[2] = {0, 0};
    g->mesh->component[seed] = (int32_t)g->mesh->component_count++;
    g->queue[0] = seed;
    for (size_t at = 0; at < length; at++) {
        reach_neighbours(g, g->queue[at], &length);
        area[g->turned[g->queue[at]]] += mesh_twice_area(g->mesh, g->queue[at]);
    }
    for (size_t at = 0; at < length && area[1] > area[0]; at++)
        g->turned[g->queue[at]] ^= 1;
}

/* Turning a triangle over swaps corners 1 and 2, and so edges 0 and 2. */
static int32_t renumbered(const struct topology *g, int32_t edge) {
    return edge == MESH_NONE || !g->turned[edge / 3] ? edge : 3 * (edge / 3) + 2 - edge % 3;
}

static void turn_over(struct topology *g) {
    struct mesh *mesh = g->mesh;
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        int32_t *twin = &mesh->twins[3 * t], *corner = mesh->corners[t];
        for (int k = 0; k < 3; k++)
            twin[k] = renumbered(g, twin[k]);
        if (!g->turned[t])
            continue;
        int32_t first = twin[0], second = corner[1];
        twin[0] = twin[2];
        twin[2] = first;
        corner[1] = corner[2];
        corner[2] = second;
        mesh->normals[t] = vec3_scale(-1, mesh->normals[t]);
    }
}

static enum status run(struct topology *g) {
    struct mesh *mesh = g->mesh;
    g->fault->index = SIZE_MAX;
    find_places(g);
    memset(mesh->twins, 0xff, 3 * mesh->triangle_count * sizeof *mesh->twins);
    join_edges(g, false);
    if (g->merged)
        join_edges(g, true);
    if (g->fault->index != SIZE_MAX)
        return STATUS_INVALID;
    memset(mesh->component, 0xff, mesh->triangle_count * sizeof *mesh->component);
    for (size_t t = 0; t < mesh->triangle_count; t++)
        if (mesh->component[t] == MESH_NONE)
            flood(g, (int32_t)t);
    if (g->fault->index != SIZE_MAX)
        return STATUS_INVALID;
    turn_over(g);
    return STATUS_OK;
}

enum status mesh_topology_find(struct mesh *mesh, struct arena *arena, struct mesh_fault *fault) {
    struct topology g = {.mesh = mesh, .fault = fault};
    struct arena_mark mark = arena_mark(arena);
    enum status status = alloc_scratch(&g, arena) ? run(&g) : STATUS_OUT_OF_MEMORY;
    arena_rewind(arena, mark);
    return status;
}
