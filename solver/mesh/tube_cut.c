/* SPDX-License-Identifier: MIT */
#include "tube_cut.h"

#include "ring.h"
#include <math.h>
#include <string.h>

/* Passages of the fence that ways are told apart by: -PASSES_MOST .. PASSES_MOST. */
enum { PASSES_MOST = 2, LAYERS = 2 * PASSES_MOST + 1, NOWHERE = -1 };

/* A border that turns by more degrees than this is no end of a tube: of a cone that of 48 degrees
 * to its axis. */
static const double turn_most = 270;

/* A hole whose border is shorter than this share of the only other one is no end: cloth that has
 * gone round it on both sides is hardly out of step. */
static const double hole_most = 0.2;

struct heap_entry {
    double key;
    int32_t at;
};

struct heap {
    struct heap_entry *entries;
    size_t count, room;
    struct arena *arena;
};

struct tube {
    const struct mesh *mesh;
    struct arena *arena;
    int32_t component;
    int32_t *vertex; /* of half-edge h: the number of the vertex where it begins */
    size_t vertex_count;
    int32_t *first, *around; /* of vertex v: the half-edges that begin there, around[first[v]] .. */
    int32_t *border; /* of half-edge h: the number of the border it is part of, or NOWHERE */
    int32_t ends[2]; /* the borders that are ends */
    int32_t *fence;  /* the vertices of the shortest way along edges from one to the other */
    size_t fence_count;
    uint8_t *right;   /* of half-edge h: it begins on the fence, its triangle lies right of it */
    double *distance; /* of vertex v in layer l: LAYERS v + l */
    uint8_t *settled;
    int8_t *nearest; /* of vertex v: the layer of its least distance */
};

/* ---- a heap of vertices by distance ---- */

/* Lowers the distance of `at`, if it is greater, and has it looked at; false without memory. */
static bool lower_distance(struct heap *heap, double *distances, int32_t at, double distance) {
    if (!(distance < distances[at]))
        return true;
    distances[at] = distance;
    if (heap->count == heap->room)
        heap->entries = arena_enlarge(heap->arena, heap->entries, heap->count,
                                      sizeof *heap->entries, &heap->room);
    if (!heap->entries)
        return false;
    size_t k = heap->count++;
    for (; k > 0 && heap->entries[(k - 1) / 2].key > distance; k = (k - 1) / 2)
        heap->entries[k] = heap->entries[(k - 1) / 2];
    heap->entries[k] = (struct heap_entry){distance, at};
    return true;
}

static struct heap_entry heap_pop(struct heap *heap) {
    struct heap_entry top = heap->entries[0], last = heap->entries[--heap->count];
    size_t k = 0;
    for (size_t child = 1; child < heap->count; child = 2 * k + 1) {
        child += child + 1 < heap->count && heap->entries[child + 1].key < heap->entries[child].key;
        if (!(heap->entries[child].key < last.key))
            break;
        heap->entries[k] = heap->entries[child];
        k = child;
    }
    heap->entries[k] = last;
    return top;
}

/* ---- vertices ---- */

static struct vec3 start_of_half(const struct tube *o, int32_t half) {
    return mesh_corner_point(o->mesh, half / 3, half % 3);
}

static int32_t root_vertex(int32_t *parent, int32_t v) {
    while (parent[v] != v)
        v = parent[v] = parent[parent[v]];
    return v;
}

/* Numbers the vertices; those that edges with the same ends share are one. */
static bool number_vertices(struct tube *o) {
    const struct mesh *mesh = o->mesh;
    size_t halves = 3 * mesh->triangle_count;
    int32_t *parent = arena_alloc(o->arena, mesh->vertex_count, sizeof *parent);
    o->vertex = arena_alloc(o->arena, halves, sizeof *o->vertex);
    o->first = arena_alloc(o->arena, mesh->vertex_count + 2, sizeof *o->first);
    o->around = arena_alloc(o->arena, halves, sizeof *o->around);
    if (!parent || !o->vertex || !o->first || !o->around)
        return false;
    for (size_t v = 0; v < mesh->vertex_count; v++)
        parent[v] = (int32_t)v;
    const int32_t *corner = &mesh->corners[0][0];
    for (size_t h = 0; h < halves; h++) {
        int32_t twin = mesh->twins[h];
        if (twin != MESH_NONE)
            parent[root_vertex(parent, corner[h])] =
                root_vertex(parent, corner[mesh_next_half(twin)]);
    }
    o->vertex_count = mesh->vertex_count;
    for (size_t h = 0; h < halves; h++) {
        o->vertex[h] = root_vertex(parent, corner[h]);
        o->first[o->vertex[h] + 2]++;
    }
    for (size_t v = 2; v < o->vertex_count + 2; v++)
        o->first[v] += o->first[v - 1];
    for (size_t h = 0; h < halves; h++)
        o->around[o->first[o->vertex[h] + 1]++] = (int32_t)h;
    return true;
}

/* ---- borders ---- */

/* By how many degrees the border from a half-edge on turns to the left: at each of its vertices
 * half a turn less the angles of the triangles there; and its length. Numbers its half-edges. */
static double turn_of_border(struct tube *o, int32_t half, int32_t number, double *length) {
    double turn = 0;
    for (int32_t at = half; o->border[at] == NOWHERE; at = mesh_next_on_border(o->mesh, at)) {
        int32_t v = o->vertex[at];
        o->border[at] = number;
        *length += vec3_distance(start_of_half(o, at), start_of_half(o, mesh_next_half(at)));
        turn += 180;
        for (int32_t k = o->first[v]; k < o->first[v + 1]; k++)
            turn -= mesh_corner_angle(o->mesh, o->around[k]);
    }
    return turn;
}

/* Whether the component is a tube; finds its borders. */
static bool find_ends(struct tube *o) {
    const struct mesh *mesh = o->mesh;
    int32_t halves = (int32_t)(3 * mesh->triangle_count), borders = 0, ends = 0, plates = 0;
    int64_t corners = 0, edges = 0, triangles = 0;
    double length[2] = {0, 0}; /* of the last two */
    for (int32_t h = 0; h < halves; h++)
        o->border[h] = NOWHERE;
    for (int32_t h = 0; h < halves; h++) {
        if (mesh->component[h / 3] != o->component)
            continue;
        bool free = mesh->twins[h] == MESH_NONE;
        triangles += h % 3 == 0;
        edges += free || h < mesh->twins[h];
        corners += o->around[o->first[o->vertex[h]]] == h;
        if (!free || o->border[h] != NOWHERE)
            continue;
        length[borders % 2] = 0;
        double turn = turn_of_border(o, h, borders, &length[borders % 2]);
        bool plate = turn > turn_most, end = !plate && turn >= -turn_most;
        if (end && ends < 2)
            o->ends[ends] = borders;
        ends += end;
        plates += plate;
        borders++;
    }
    bool alike = fmin(length[0], length[1]) >= hole_most * fmax(length[0], length[1]);
    if (borders == 2 && plates != 1 && alike)
        for (ends = 0, plates = 0; ends < 2; ends++)
            o->ends[ends] = ends;
    return ends == 2 && plates == 0 && corners - edges + triangles == 2 - borders;
}

/* ---- the fence: the shortest way along edges from one end to the other ---- */

static bool find_fence(struct tube *o) {
    struct heap heap = {.arena = o->arena};
    double *distance = arena_alloc(o->arena, o->vertex_count, sizeof *distance);
    int32_t *from = arena_alloc(o->arena, o->vertex_count, sizeof *from);
    int32_t halves = (int32_t)(3 * o->mesh->triangle_count), end = NOWHERE;
    o->fence = arena_alloc(o->arena, o->vertex_count, sizeof *o->fence);
    if (!distance || !from || !o->fence)
        return false;
    for (size_t v = 0; v < o->vertex_count; v++) {
        distance[v] = HUGE_VAL;
        from[v] = NOWHERE;
    }
    for (int32_t h = 0; h < halves; h++)
        if (o->border[h] == o->ends[0] && !lower_distance(&heap, distance, o->vertex[h], 0))
            return false;
    while (heap.count > 0 && end == NOWHERE) {
        struct heap_entry top = heap_pop(&heap);
        if (top.key > distance[top.at])
            continue;
        for (int32_t k = o->first[top.at]; k < o->first[top.at + 1]; k++) {
            int32_t h = o->around[k];
            end = o->border[h] == o->ends[1] ? top.at : end;
            const int32_t ends[2] = {mesh_next_half(h), mesh_previous_half(h)};
            for (int n = 0; n < 2; n++) {
                int32_t to = o->vertex[ends[n]];
                double by = vec3_distance(start_of_half(o, h), start_of_half(o, ends[n]));
                if (distance[top.at] + by < distance[to])
                    from[to] = top.at;
                if (!lower_distance(&heap, distance, to, distance[top.at] + by))
                    return false;
            }
        }
    }
    for (int32_t v = end; v != NOWHERE; v = from[v])
        o->fence[o->fence_count++] = v;
    return true;
}

/* Marks the triangles to the right of the fence round its vertex n: from the edge to the next
 * vertex on clockwise, and from that to the last one on the other way round, as far as there are
 * some. */
static void mark_right(struct tube *o, size_t n) {
    int32_t v = o->fence[n], last = n > 0 ? o->fence[n - 1] : NOWHERE;
    int32_t next = n + 1 < o->fence_count ? o->fence[n + 1] : NOWHERE;
    for (int way = 0; way < 2; way++)
        for (int32_t k = o->first[v]; k < o->first[v + 1]; k++) {
            int32_t at = o->around[k];
            int32_t from = o->vertex[way ? mesh_next_half(at) : mesh_previous_half(at)];
            if (from != (way ? last : next))
                continue;
            while (at != MESH_NONE && !o->right[at]) {
                int32_t to = o->vertex[way ? mesh_previous_half(at) : mesh_next_half(at)];
                o->right[at] = 1;
                at = to == (way ? next : last) ? MESH_NONE
                     : way                     ? mesh_ring_next(o->mesh, at)
                                               : mesh_ring_previous(o->mesh, at);
            }
        }
}

/* ---- distances ---- */

/* The distance of C over the edge A B from the point, on the other side of it, that has the
 * distances a and b from its ends; HUGE_VAL when the straight way does not pass between them. */
static double unfolded_distance(struct vec3 from_a, struct vec3 from_b, struct vec3 at, double a,
                                double b) {
    struct vec3 edge = vec3_sub(from_b, from_a), to = vec3_sub(at, from_a);
    double c = vec3_norm(edge), x = (a * a - b * b + c * c) / (2 * c), y2 = a * a - x * x;
    double cx = vec3_dot(to, edge) / c, cy2 = vec3_norm2(to) - cx * cx;
    if (!(y2 >= 0) || !(cy2 > 0))
        return HUGE_VAL;
    double y = sqrt(y2), cy = sqrt(cy2), passes = x + (cx - x) * (y / (y + cy));
    double dx = cx - x, dy = cy + y;
    return passes >= 0 && passes <= c ? sqrt(dx * dx + dy * dy) : HUGE_VAL;
}

/* The layer of the vertex where a half-edge begins, in the frame of its triangle. */
static int32_t entry_of(const struct tube *o, int32_t half, int frame) {
    int layer = frame + o->right[half];
    return layer < 0 || layer >= LAYERS ? NOWHERE : LAYERS * o->vertex[half] + layer;
}

static bool find_distances(struct tube *o, const struct mesh_point *start) {
    struct heap heap = {.arena = o->arena};
    size_t count = LAYERS * o->vertex_count;
    for (size_t k = 0; k < count; k++)
        o->distance[k] = HUGE_VAL;
    for (int32_t h = 3 * start->triangle; h < 3 * start->triangle + 3; h++)
        if (!lower_distance(&heap, o->distance, entry_of(o, h, PASSES_MOST),
                            vec3_distance(start_of_half(o, h), start->r)))
            return false;
    while (heap.count > 0) {
        struct heap_entry top = heap_pop(&heap);
        if (o->settled[top.at])
            continue;
        o->settled[top.at] = 1;
        int32_t v = top.at / LAYERS;
        for (int32_t n = 2 * o->first[v]; n < 2 * o->first[v + 1]; n++) {
            /* over each triangle there, to either of its other vertices */
            int32_t half = o->around[n / 2];
            int frame = top.at % LAYERS - o->right[half];
            int32_t to = n % 2 ? mesh_previous_half(half) : mesh_next_half(half),
                    third = n % 2 ? mesh_next_half(half) : mesh_previous_half(half);
            int32_t at = entry_of(o, to, frame), with = entry_of(o, third, frame);
            if (at == NOWHERE || o->settled[at])
                continue;
            struct vec3 r = start_of_half(o, half), end = start_of_half(o, to);
            double own = o->distance[top.at], distance = own + vec3_distance(r, end);
            if (with != NOWHERE && o->settled[with])
                distance = fmin(distance, unfolded_distance(r, start_of_half(o, third), end, own,
                                                            o->distance[with]));
            if (!lower_distance(&heap, o->distance, at, distance))
                return false;
        }
    }
    for (size_t v = 0; v < o->vertex_count; v++)
        for (int8_t l = 1; l < LAYERS; l++)
            if (o->distance[LAYERS * v + (size_t)l] <
                o->distance[LAYERS * v + (size_t)o->nearest[v]])
                o->nearest[v] = l;
    return true;
}

/* ---- the line ---- */

/* The frame of its triangle in which the vertex where a half-edge begins is nearest to the start.
 */
static int nearest_frame(const struct tube *o, int32_t half) {
    return o->nearest[o->vertex[half]] - o->right[half];
}

/* Whether the cut passes a half-edge. */
static bool is_passed(const struct tube *o, int32_t half) {
    return nearest_frame(o, half) != nearest_frame(o, mesh_next_half(half));
}

/* Where it does, as a share of the edge: where the distances in the frames of its two ends are
 * equal, if they change evenly between. From either side the same. */
static double share_of(const struct tube *o, int32_t half) {
    int32_t end = mesh_next_half(half);
    int from = nearest_frame(o, half), to = nearest_frame(o, end);
    int32_t entry[4] = {entry_of(o, half, from), entry_of(o, half, to), entry_of(o, end, from),
                        entry_of(o, end, to)};
    for (int k = 0; k < 4; k++)
        if (entry[k] == NOWHERE || !(o->distance[entry[k]] < HUGE_VAL))
            return 0.5;
    double a = o->distance[entry[1]] - o->distance[entry[0]];
    double b = o->distance[entry[2]] - o->distance[entry[3]];
    return a + b > 0 ? a / (a + b) : 0.5;
}

/* From one end to the other, over the holes between: each line from a half-edge of the last border
 * that the cut passes and that is not seen yet, following the cut through the mesh up to a border.
 */
static bool find_cut_lines(struct tube *o, struct mesh_tube_cuts *cuts) {
    size_t triangles = o->mesh->triangle_count;
    uint8_t *seen = arena_alloc(o->arena, 3 * triangles, sizeof *seen);
    cuts->slits = arena_alloc(o->arena, triangles, sizeof *cuts->slits);
    cuts->from = arena_alloc(o->arena, triangles + 1, sizeof *cuts->from);
    if (!seen || !cuts->slits || !cuts->from)
        return false;
    for (int32_t border = o->ends[0]; border != o->ends[1];) {
        int32_t half = 0, end = (int32_t)(3 * triangles);
        while (half < end && !(o->border[half] == border && !seen[half] && is_passed(o, half)))
            half++;
        size_t count = cuts->from[cuts->count];
        int32_t last = half < end ? half : MESH_NONE;
        for (int32_t in = last; in != MESH_NONE; in = o->mesh->twins[last]) {
            int32_t out[2] = {mesh_next_half(in), mesh_previous_half(in)};
            bool second = !is_passed(o, out[0]);
            last = second == !is_passed(o, out[1]) || count >= triangles ? MESH_NONE : out[second];
            if (last == MESH_NONE)
                break;
            cuts->slits[count++] =
                (struct mesh_slit){{in, last}, {share_of(o, in), share_of(o, last)}};
        }
        if (last == MESH_NONE) { /* the cut does not go through */
            cuts->count = 0;
            return true;
        }
        cuts->from[++cuts->count] = count;
        seen[half] = seen[last] = 1;
        border = o->border[last];
    }
    return true;
}

enum status mesh_find_tube_cuts(const struct mesh *mesh, const struct mesh_point *start,
                                struct arena *arena, struct mesh_tube_cuts *cuts) {
    size_t halves = 3 * mesh->triangle_count;
    struct tube o = {.mesh = mesh, .arena = arena, .component = mesh->component[start->triangle]};
    *cuts = (struct mesh_tube_cuts){.count = 0};
    o.border = arena_alloc(arena, halves, sizeof *o.border);
    o.right = arena_alloc(arena, halves, sizeof *o.right);
    if (!o.border || !o.right || !number_vertices(&o))
        return STATUS_OUT_OF_MEMORY;
    if (!find_ends(&o))
        return STATUS_OK;
    o.distance = arena_alloc(arena, LAYERS * o.vertex_count, sizeof *o.distance);
    o.settled = arena_alloc(arena, LAYERS * o.vertex_count, sizeof *o.settled);
    o.nearest = arena_alloc(arena, o.vertex_count, sizeof *o.nearest);
    if (!o.distance || !o.settled || !o.nearest || !find_fence(&o))
        return STATUS_OUT_OF_MEMORY;
    for (size_t n = 0; n < o.fence_count; n++)
        mark_right(&o, n);
    bool found = find_distances(&o, start) && find_cut_lines(&o, cuts);
    return found ? STATUS_OK : STATUS_OUT_OF_MEMORY;
}
