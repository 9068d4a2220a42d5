/* SPDX-License-Identifier: MIT */
#include "facets.h"

#include <stdlib.h>

enum { STACK = 64 }; /* twice the depth of a tree of 2^31 cells */

/* How far beyond the rim is outside, as a share of the edge there: more than rounding. */
static const double beyond = 1e-6;

/* Of squares of distances. */
static const double rounding = 1e-12;

/* ---- making ---- */

struct key {
    uint64_t morton;
    int32_t cell;
};

/* The bits of x, each followed by a zero. */
static uint64_t spread(uint32_t x) {
    uint64_t b = x;
    b = (b | b << 16) & 0x0000ffff0000ffffU;
    b = (b | b << 8) & 0x00ff00ff00ff00ffU;
    b = (b | b << 4) & 0x0f0f0f0f0f0f0f0fU;
    b = (b | b << 2) & 0x3333333333333333U;
    return (b | b << 1) & 0x5555555555555555U;
}

static int compare_keys(const void *a, const void *b) {
    const struct key *x = a, *y = b;
    return x->morton != y->morton ? (x->morton < y->morton ? -1 : 1)
                                  : (x->cell > y->cell) - (x->cell < y->cell);
}

/* The sign bit is turned over so that negative places come first. */
static enum status sort_cells(struct facets *facets, struct arena *arena) {
    struct arena_mark mark = arena_mark(arena);
    size_t count = facets->source.cell_count;
    struct key *keys = arena_take(arena, count, sizeof *keys);
    if (!keys)
        return STATUS_OUT_OF_MEMORY;
    for (size_t k = 0; k < count; k++) {
        const int32_t *place = facets->source.places[k];
        uint32_t i = (uint32_t)place[0] ^ 0x80000000U, j = (uint32_t)place[1] ^ 0x80000000U;
        keys[k] = (struct key){spread(i) | spread(j) << 1, (int32_t)k};
    }
    qsort(keys, count, sizeof *keys, compare_keys);
    for (size_t k = 0; k < count; k++)
        facets->order[k] = keys[k].cell;
    arena_rewind(arena, mark);
    return STATUS_OK;
}

static void list_cells_around(struct facets *facets) {
    for (size_t node = 0; node < facets->source.node_count; node++)
        for (int k = 0; k < 4; k++)
            facets->around[node][k] = FACETS_NONE;
    /* A cell has its own place at each corner, since it lies on another side of each. */
    for (size_t cell = 0; cell < facets->source.cell_count; cell++)
        for (int k = 0; k < 4; k++)
            facets->around[facets->source.corners[cell][k]][k] = (int32_t)cell;
}

static void extend(struct facets_box *box, struct vec3 r) {
    const double x[3] = {r.x, r.y, r.z};
    for (int k = 0; k < 3; k++) {
        box->lower[k] = x[k] < box->lower[k] ? x[k] : box->lower[k];
        box->upper[k] = x[k] > box->upper[k] ? x[k] : box->upper[k];
    }
}

static void join(struct facets_box *box, const struct facets_box *other) {
    extend(box, vec3_make(other->lower[0], other->lower[1], other->lower[2]));
    extend(box, vec3_make(other->upper[0], other->upper[1], other->upper[2]));
}

static struct facets_box leaf_box(const struct facets *facets, size_t leaf) {
    const struct facets_source *source = &facets->source;
    size_t end = (leaf + 1) * FACETS_LEAF;
    end = end < source->cell_count ? end : source->cell_count;
    struct vec3 first = source->nodes[source->corners[facets->order[leaf * FACETS_LEAF]][0]];
    struct facets_box box = {{first.x, first.y, first.z}, {first.x, first.y, first.z}};
    for (size_t k = leaf * FACETS_LEAF; k < end; k++)
        for (int corner = 0; corner < 4; corner++)
            extend(&box, source->nodes[source->corners[facets->order[k]][corner]]);
    return box;
}

static void make_boxes(struct facets *facets, size_t node, size_t leaf, size_t count) {
    if (count == 1) {
        facets->boxes[node] = leaf_box(facets, leaf);
        return;
    }
    size_t half = count / 2, right = node + 2 * half;
    make_boxes(facets, node + 1, leaf, half);
    make_boxes(facets, right, leaf + half, count - half);
    facets->boxes[node] = facets->boxes[node + 1];
    join(&facets->boxes[node], &facets->boxes[right]);
}

enum status facets_make(const struct facets_source *source, struct arena *arena,
                        struct facets **result) {
    if (source->cell_count == 0)
        return STATUS_INVALID;
    struct facets *facets = arena_alloc(arena, 1, sizeof *facets);
    if (!facets)
        return STATUS_OUT_OF_MEMORY;
    facets->source = *source;
    facets->leaf_count = (source->cell_count + FACETS_LEAF - 1) / FACETS_LEAF;
    facets->around = arena_take(arena, source->node_count, sizeof *facets->around);
    facets->order = arena_take(arena, source->cell_count, sizeof *facets->order);
    facets->boxes = arena_take(arena, 2 * facets->leaf_count - 1, sizeof *facets->boxes);
    if (!facets->around || !facets->order || !facets->boxes ||
        sort_cells(facets, arena) != STATUS_OK)
        return STATUS_OUT_OF_MEMORY;
    list_cells_around(facets);
    make_boxes(facets, 0, 0, facets->leaf_count);
    *result = facets;
    return STATUS_OK;
}

/* ---- one triangle ---- */

/* The weights of a and b on the edge a b at the foot of p, within it. */
static void project_on_edge(struct vec3 p, struct vec3 a, struct vec3 b, double *wa, double *wb) {
    struct vec3 ab = vec3_sub(b, a);
    double length2 = vec3_norm2(ab), t = length2 > 0 ? vec3_dot(vec3_sub(p, a), ab) / length2 : 0;
    *wb = t > 0 ? (t < 1 ? t : 1) : 0;
    *wa = 1 - *wb;
}

/* The weights of the place in the triangle nearest to p (C. Ericson, Real-time collision detection,
 * 5.1.5): the regions of the corners and edges first, by the signs of dot products. A triangle
 * without area has only edges. */
static void project(struct vec3 p, const struct vec3 t[3], double weight[3]) {
    struct vec3 ab = vec3_sub(t[1], t[0]), ac = vec3_sub(t[2], t[0]), ap = vec3_sub(p, t[0]);
    struct vec3 bp = vec3_sub(p, t[1]), cp = vec3_sub(p, t[2]);
    double d1 = vec3_dot(ab, ap), d2 = vec3_dot(ac, ap), d3 = vec3_dot(ab, bp);
    double d4 = vec3_dot(ac, bp), d5 = vec3_dot(ab, cp), d6 = vec3_dot(ac, cp);
    double va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
    weight[0] = weight[1] = weight[2] = 0;
    if (d1 <= 0 && d2 <= 0)
        weight[0] = 1;
    else if (d3 >= 0 && d4 <= d3)
        weight[1] = 1;
    else if (d6 >= 0 && d5 <= d6)
        weight[2] = 1;
    else if (vc <= 0 && d1 >= 0 && d3 <= 0)
        project_on_edge(p, t[0], t[1], &weight[0], &weight[1]);
    else if (vb <= 0 && d2 >= 0 && d6 <= 0)
        project_on_edge(p, t[0], t[2], &weight[0], &weight[2]);
    else if (va <= 0)
        project_on_edge(p, t[1], t[2], &weight[1], &weight[2]);
    else {
        double sum = va + vb + vc;
        weight[1] = vb / sum;
        weight[2] = vc / sum;
        weight[0] = 1 - weight[1] - weight[2];
        weight[0] = weight[0] > 0 ? weight[0] : 0;
    }
}

/* ---- the search ---- */

struct search {
    const struct facets *facets;
    struct vec3 point;
    struct facets_place *best;
    double distance2;
};

static struct vec3 corner_point(const struct facets_source *source, int32_t cell, int corner) {
    return source->nodes[source->corners[cell][corner & 3]];
}

static struct vec3 combine(const struct vec3 t[3], const double weight[3]) {
    struct vec3 r = vec3_scale(weight[0], t[0]);
    return vec3_axpy(weight[2], t[2], vec3_axpy(weight[1], t[1], r));
}

/* Whether the ball about the middle of a cell through its farthest corner, in which all of it lies,
 * is further away than what is known; rounding in its favour. */
static bool is_far(const struct search *search, const struct vec3 corner[4], struct vec3 middle) {
    double away2 = vec3_norm2(vec3_sub(search->point, middle)), reach2 = 0;
    for (int k = 0; k < 4; k++) {
        double own = vec3_norm2(vec3_sub(corner[k], middle));
        reach2 = own > reach2 ? own : reach2;
    }
    double known2 = search->distance2;
    return away2 > (1 + rounding) * (known2 + reach2 + 2 * sqrt(known2 * reach2));
}

static void search_cell(struct search *search, int32_t cell) {
    struct vec3 corner[5], middle = {0, 0, 0};
    for (int k = 0; k < 4; k++) {
        corner[k] = corner_point(&search->facets->source, cell, k);
        middle = vec3_axpy(0.25, corner[k], middle);
    }
    corner[4] = corner[0];
    if (is_far(search, corner, middle))
        return;
    for (int side = 0; side < 4; side++) {
        const struct vec3 triangle[3] = {middle, corner[side], corner[side + 1]};
        double weight[3];
        project(search->point, triangle, weight);
        struct vec3 r = combine(triangle, weight);
        double distance2 = vec3_norm2(vec3_sub(search->point, r));
        bool nearer = distance2 < search->distance2 ||
                      (distance2 == search->distance2 && cell < search->best->cell);
        if (!nearer)
            continue;
        search->distance2 = distance2;
        *search->best = (struct facets_place){
            .cell = cell, .side = side, .weight = {weight[0], weight[1], weight[2]}, .r = r};
    }
}

static double box_distance2(const struct facets_box *box, struct vec3 p) {
    const double x[3] = {p.x, p.y, p.z};
    double sum = 0;
    for (int k = 0; k < 3; k++) {
        double under = box->lower[k] - x[k], over = x[k] - box->upper[k];
        double gap = under > over ? under : over;
        sum += gap > 0 ? gap * gap : 0;
    }
    return sum;
}

struct visit {
    size_t node, leaf, count;
    double distance2;
};

/* The nearer child is looked at first; the other one waits on the stack. */
static void search_tree(struct search *search) {
    const struct facets *facets = search->facets;
    struct visit stack[STACK];
    size_t height = 0;
    stack[height++] = (struct visit){0, 0, facets->leaf_count, 0};
    while (height > 0) {
        struct visit at = stack[--height];
        if (at.distance2 > search->distance2)
            continue;
        if (at.count == 1) {
            size_t end = (at.leaf + 1) * FACETS_LEAF;
            end = end < facets->source.cell_count ? end : facets->source.cell_count;
            for (size_t k = at.leaf * FACETS_LEAF; k < end; k++)
                search_cell(search, facets->order[k]);
            continue;
        }
        size_t half = at.count / 2;
        struct visit left = {at.node + 1, at.leaf, half, 0};
        struct visit right = {at.node + 2 * half, at.leaf + half, at.count - half, 0};
        left.distance2 = box_distance2(&facets->boxes[left.node], search->point);
        right.distance2 = box_distance2(&facets->boxes[right.node], search->point);
        bool left_first = left.distance2 <= right.distance2;
        stack[height++] = left_first ? right : left;
        stack[height++] = left_first ? left : right;
    }
}

/* ---- the rim ---- */

/* Whether no other cell has the edge from corner `side` of `cell` to the next. */
static bool is_rim(const struct facets *facets, int32_t cell, int side) {
    const int32_t *corners = facets->source.corners[cell];
    const int32_t *a = facets->around[corners[side & 3]];
    const int32_t *b = facets->around[corners[(side + 1) & 3]];
    for (int k = 0; k < 4; k++)
        for (int m = 0; m < 4; m++)
            if (a[k] != FACETS_NONE && a[k] != cell && a[k] == b[m])
                return false;
    return true;
}

/* Whether the place lies on the rim: on an edge of one cell, or at a corner that is not in the
 * middle of four. */
static bool on_rim(const struct facets *facets, const struct facets_place *place) {
    const int32_t *corners = facets->source.corners[place->cell];
    if (place->weight[0] > 0)
        return false;
    if (place->weight[1] > 0 && place->weight[2] > 0)
        return is_rim(facets, place->cell, place->side);
    const int32_t *around = facets->around[corners[(place->side + (place->weight[2] > 0)) & 3]];
    for (int k = 0; k < 4; k++)
        if (around[k] == FACETS_NONE)
            return true;
    return false;
}

/* How far the point is from the place along the plane of its triangle. */
static double tangential(const struct facets *facets, const struct facets_place *place,
                         struct vec3 point, double *edge) {
    const struct facets_source *source = &facets->source;
    struct vec3 a = corner_point(source, place->cell, place->side);
    struct vec3 b = corner_point(source, place->cell, place->side + 1);
    struct vec3 c = corner_point(source, place->cell, place->side + 2);
    struct vec3 ab = vec3_sub(b, a), gap = vec3_sub(point, place->r);
    struct vec3 normal = vec3_unit(vec3_cross(ab, vec3_sub(c, b)));
    *edge = vec3_norm(ab);
    return vec3_norm(vec3_axpy(-vec3_dot(gap, normal), normal, gap));
}

void facets_nearest(const struct facets *facets, struct vec3 point, int32_t hint,
                    struct facets_place *place) {
    bool useful = hint >= 0 && (size_t)hint < facets->source.cell_count;
    double edge;
    *place = (struct facets_place){.cell = INT32_MAX};
    struct search search = {facets, point, place, HUGE_VAL};
    search_cell(&search, useful ? hint : 0);
    search_tree(&search);
    place->distance = sqrt(search.distance2);
    place->outside =
        on_rim(facets, place) && tangential(facets, place, point, &edge) > beyond * edge;
}
