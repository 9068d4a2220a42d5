/* SPDX-License-Identifier: MIT */
#include "tree.h"

#include <string.h>

enum { LEAF = 4, STACK_MAX = 64 };

/* Boxes round the circle are widened by this share of its reach, against rounding. */
static const double slack = 1e-9;

/* A triangle to be sorted into the tree by its centre, in shares of the mesh's size: single
 * precision is enough to divide them. */
struct item {
    float at[3];
    int32_t triangle;
};

/* A node and the leaves under it. */
struct span {
    size_t node, leaf, leaves;
};

static struct span left_child(struct span s) {
    return (struct span){s.node + 1, s.leaf, s.leaves / 2};
}

static struct span right_child(struct span s) {
    size_t left = s.leaves / 2;
    return (struct span){s.node + 2 * left, s.leaf + left, s.leaves - left};
}

/* ---- building ---- */

/* A total order, without branches. */
static bool comes_first(const struct item *a, const struct item *b, int axis) {
    return (a->at[axis] < b->at[axis]) |
           ((a->at[axis] == b->at[axis]) & (a->triangle < b->triangle));
}

/* Hoare's selection: the `rank` least items come first. The pivot is the middle one of three items
 * at scattered places (a linear congruential generator), so that no order of the triangles makes
 * it slow. Items are exchanged always and counted when they should be, for a processor cannot
 * foresee which way a branch would go. */
static void select_least(struct item *items, size_t count, size_t rank, int axis) {
    uint64_t scatter = count;
    while (count > 1) {
        struct item pick[3];
        for (int k = 0; k < 3; k++) {
            scatter = scatter * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
            pick[k] = items[(size_t)(scatter >> 33) % count];
        }
        bool ab = comes_first(&pick[0], &pick[1], axis), bc = comes_first(&pick[1], &pick[2], axis);
        bool ac = comes_first(&pick[0], &pick[2], axis);
        struct item pivot = pick[ab == bc ? 1 : ab == ac ? 2 : 0];
        size_t less = 0;
        for (size_t i = 0; i < count; i++) {
            struct item item = items[i];
            items[i] = items[less];
            items[less] = item;
            less += comes_first(&item, &pivot, axis);
        }
        if (less == rank)
            return;
        if (less > rank) {
            count = less;
        } else if (less > 0) {
            items += less;
            count -= less;
            rank -= less;
        } /* else the pivot was the least, and another one will be drawn */
    }
}

/* The triangles of a leaf: `first` and how many. */
static size_t leaf_range(const struct mesh *mesh, size_t leaf, size_t *first) {
    *first = LEAF * leaf;
    size_t rest = mesh->triangle_count - *first;
    return rest < LEAF ? rest : LEAF;
}

/* The boxes of a node over `items` and of all below it. As deep as the logarithm of the number of
 * leaves. */
static void build_node(struct mesh *mesh, struct item *items, struct span s) {
    struct mesh_box *box = &mesh->boxes[s.node];
    if (s.leaves == 1) {
        size_t first, count = leaf_range(mesh, s.leaf, &first);
        *box = (struct mesh_box){{HUGE_VAL, HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}};
        for (size_t i = 0; i < 3 * count; i++) {
            int32_t t = mesh->order[first + i / 3] = items[first + i / 3].triangle;
            struct vec3 p = mesh_corner_point(mesh, t, (int)(i % 3));
            const double at[3] = {p.x, p.y, p.z};
            for (int k = 0; k < 3; k++) {
                box->lower[k] = at[k] < box->lower[k] ? at[k] : box->lower[k];
                box->upper[k] = at[k] > box->upper[k] ? at[k] : box->upper[k];
            }
        }
        return;
    }
    struct span left = left_child(s), right = right_child(s);
    size_t first = LEAF * s.leaf, middle = LEAF * right.leaf, last = LEAF * (s.leaf + s.leaves);
    if (last > mesh->triangle_count)
        last = mesh->triangle_count;
    /* in the direction in which the centres spread most */
    float low[3], high[3];
    memcpy(low, items[first].at, sizeof low);
    memcpy(high, items[first].at, sizeof high);
    for (size_t i = first + 1; i < last; i++)
        for (int k = 0; k < 3; k++) {
            low[k] = items[i].at[k] < low[k] ? items[i].at[k] : low[k];
            high[k] = items[i].at[k] > high[k] ? items[i].at[k] : high[k];
        }
    int axis = 0;
    for (int k = 1; k < 3; k++)
        if (high[k] - low[k] > high[axis] - low[axis])
            axis = k;
    select_least(items + first, last - first, middle - first, axis);
    build_node(mesh, items, left);
    build_node(mesh, items, right);
    const struct mesh_box *a = &mesh->boxes[left.node], *b = &mesh->boxes[right.node];
    for (int k = 0; k < 3; k++) {
        box->lower[k] = fmin(a->lower[k], b->lower[k]);
        box->upper[k] = fmax(a->upper[k], b->upper[k]);
    }
}

enum status mesh_tree_build(struct mesh *mesh, struct arena *arena) {
    double scale = 1 / (3 * mesh->size);
    mesh->leaf_count = (mesh->triangle_count + LEAF - 1) / LEAF;
    mesh->boxes = arena_alloc(arena, 2 * mesh->leaf_count - 1, sizeof *mesh->boxes);
    mesh->order = arena_alloc(arena, mesh->triangle_count, sizeof *mesh->order);
    struct arena_mark mark = arena_mark(arena);
    struct item *items = arena_alloc(arena, mesh->triangle_count, sizeof *items);
    if (!mesh->boxes || !mesh->order || !items)
        return STATUS_OUT_OF_MEMORY;
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        struct vec3 p[3];
        mesh_corner_points(mesh, (int32_t)t, p);
        struct vec3 middle = vec3_add(p[0], vec3_add(p[1], p[2]));
        middle = vec3_scale(scale, vec3_axpy(-3, mesh->lower, middle));
        items[t] = (struct item){{(float)middle.x, (float)middle.y, (float)middle.z}, (int32_t)t};
    }
    build_node(mesh, items, (struct span){0, 0, mesh->leaf_count});
    arena_rewind(arena, mark);
    return STATUS_OK;
}

/* ---- the nearest point ---- */

static double distance2_to_box(const struct mesh_box *box, const double at[3]) {
    double sum = 0;
    for (int k = 0; k < 3; k++) {
        double below = box->lower[k] - at[k], above = at[k] - box->upper[k];
        double outside = below > 0 ? below : above > 0 ? above : 0;
        sum += outside * outside;
    }
    return sum;
}

/* The point of a triangle nearest to `at`: its foot on the plane, or a point of one of the edges
 * beyond which the foot lies (the nearest of them). */
static struct vec3 nearest_on_triangle(const struct mesh *mesh, int32_t t, struct vec3 at) {
    struct vec3 p[3], normal = mesh->normals[t], best = at;
    mesh_corner_points(mesh, t, p);
    double least = HUGE_VAL;
    for (int k = 0; k < 3; k++) {
        struct vec3 from = p[k], to = p[(k + 1) % 3];
        struct vec3 along = vec3_sub(to, from), offset = vec3_sub(at, from);
        if (vec3_dot(vec3_cross(along, offset), normal) >= 0)
            continue;
        double share = vec3_dot(offset, along) / vec3_norm2(along);
        struct vec3 point = share <= 0 ? from : share >= 1 ? to : vec3_axpy(share, along, from);
        double distance2 = vec3_norm2(vec3_sub(point, at));
        if (distance2 < least) {
            least = distance2;
            best = point;
        }
    }
    return least < HUGE_VAL ? best : vec3_axpy(-vec3_dot(vec3_sub(at, p[0]), normal), normal, at);
}

/* A node that waits, with the distance to its box. */
struct waiting {
    struct span span;
    double distance2;
};

bool mesh_nearest(const struct mesh *mesh, struct vec3 point, int32_t component,
                  struct mesh_point *nearest, double *distance) {
    const double at[3] = {point.x, point.y, point.z};
    double least2 = HUGE_VAL;
    struct waiting stack[STACK_MAX] = {{{0, 0, mesh->leaf_count}, 0}};
    *nearest = (struct mesh_point){MESH_NONE, point};
    for (size_t depth = 1; depth > 0;) {
        struct waiting w = stack[--depth];
        if (w.distance2 > least2)
            continue;
        if (w.span.leaves > 1) {
            struct waiting near = {left_child(w.span), 0}, far = {right_child(w.span), 0};
            near.distance2 = distance2_to_box(&mesh->boxes[near.span.node], at);
            far.distance2 = distance2_to_box(&mesh->boxes[far.span.node], at);
            bool swapped = far.distance2 < near.distance2;
            stack[depth++] = swapped ? near : far;
            stack[depth++] = swapped ? far : near;
            continue;
        }
        size_t first, count = leaf_range(mesh, w.span.leaf, &first);
        for (size_t i = first; i < first + count; i++) {
            int32_t t = mesh->order[i];
            if (component != MESH_ANY && mesh->component[t] != component)
                continue;
            struct vec3 r = nearest_on_triangle(mesh, t, point);
            double own2 = vec3_norm2(vec3_sub(r, point));
            if (own2 < least2 || (own2 == least2 && t < nearest->triangle)) {
                *nearest = (struct mesh_point){t, r};
                least2 = own2;
            }
        }
    }
    if (distance)
        *distance = sqrt(least2);
    return nearest->triangle != MESH_NONE;
}

/* ---- triangles on a circle ---- */

/* Whether the box holds points nearer to `centre` than `radius` and points further away. */
static bool meets_sphere(const struct mesh_box *box, struct vec3 centre, double radius) {
    const double at[3] = {centre.x, centre.y, centre.z};
    double farthest2 = 0, low = radius * (1 - slack), high = radius * (1 + slack);
    for (int k = 0; k < 3; k++) {
        double reach = fmax(at[k] - box->lower[k], box->upper[k] - at[k]);
        farthest2 += reach * reach;
    }
    return distance2_to_box(box, at) <= high * high && farthest2 >= low * low;
}

void mesh_tree_visit(const struct mesh *mesh, const struct mesh_circle *circle,
                     void (*visit)(void *context, int32_t triangle), void *context) {
    struct span stack[STACK_MAX] = {{0, 0, mesh->leaf_count}};
    for (size_t depth = 1; depth > 0;) {
        struct span s = stack[--depth];
        const struct mesh_box *box = &mesh->boxes[s.node];
        if (!meets_sphere(box, circle->b, circle->bd) || !meets_sphere(box, circle->c, circle->cd))
            continue;
        if (s.leaves > 1) {
            stack[depth++] = right_child(s);
            stack[depth++] = left_child(s);
            continue;
        }
        size_t first, count = leaf_range(mesh, s.leaf, &first);
        for (size_t i = first; i < first + count; i++)
            visit(context, mesh->order[i]);
    }
}
