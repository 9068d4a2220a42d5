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

struct builder {
    struct mesh *mesh;
    struct item *items;
};

/* A node and the leaves under it. */
struct span {
    size_t node, leaf, leaves;
};

static struct span left_of(struct span s) {
    return (struct span){s.node + 1, s.leaf, s.leaves / 2};
}

static struct span right_of(struct span s) {
    size_t left = s.leaves / 2;
    return (struct span){s.node + 2 * left, s.leaf + left, s.leaves - left};
}

/* ---- building ---- */

static void fill_items(struct builder *b) {
    const struct mesh *mesh = b->mesh;
    double scale = 1 / (3 * mesh->size);
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        struct vec3 p[3];
        mesh_corner_points(mesh, (int32_t)t, p);
        struct vec3 middle = vec3_add(p[0], vec3_add(p[1], p[2]));
        middle = vec3_scale(scale, vec3_axpy(-3, mesh->lower, middle));
        b->items[t] =
            (struct item){{(float)middle.x, (float)middle.y, (float)middle.z}, (int32_t)t};
    }
}

/* The direction in which the centres of the items spread most. */
static int widest(const struct item *items, size_t count) {
    float low[3], high[3];
    memcpy(low, items[0].at, sizeof low);
    memcpy(high, items[0].at, sizeof high);
    for (size_t i = 1; i < count; i++)
        for (int k = 0; k < 3; k++) {
            low[k] = items[i].at[k] < low[k] ? items[i].at[k] : low[k];
            high[k] = items[i].at[k] > high[k] ? items[i].at[k] : high[k];
        }
    int best = 0;
    for (int k = 1; k < 3; k++)
        if (high[k] - low[k] > high[best] - low[best])
            best = k;
    return best;
}

/* A total order, without branches. */
static bool before(const struct item *a, const struct item *b, int axis) {
    return (a->at[axis] < b->at[axis]) |
           ((a->at[axis] == b->at[axis]) & (a->triangle < b->triangle));
}

/* Brings the items before `pivot` to the front; how many they are. The exchange is made always and
 * counted when it should be, for a processor cannot foresee which way a branch would go. */
static size_t divide(struct item *items, size_t count, struct item pivot, int axis) {
    size_t less = 0;
    for (size_t i = 0; i < count; i++) {
        struct item item = items[i];
        items[i] = items[less];
        items[less] = item;
        less += before(&item, &pivot, axis);
    }
    return less;
}

static uint64_t scattered(uint64_t state) {
    return state * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
}

/* The middle one of three items, whose places are scattered, so that no order of the triangles
 * makes the selection slow. */
static struct item choose_pivot(const struct item *items, size_t count, int axis,
                                uint64_t *scatter) {
    struct item pick[3];
    for (int k = 0; k < 3; k++) {
        *scatter = scattered(*scatter);
        pick[k] = items[(size_t)(*scatter >> 33) % count];
    }
    bool ab = before(&pick[0], &pick[1], axis), bc = before(&pick[1], &pick[2], axis);
    bool ac = before(&pick[0], &pick[2], axis);
    return ab == bc ? pick[1] : ab == ac ? pick[2] : pick[0];
}

/* Hoare's selection: the `rank` least items come first. */
static void select_least(struct item *items, size_t count, size_t rank, int axis) {
    uint64_t scatter = count;
    while (count > 1) {
        struct item pivot = choose_pivot(items, count, axis, &scatter);
        size_t less = divide(items, count, pivot, axis);
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

static struct mesh_box empty_box(void) {
    return (struct mesh_box){{HUGE_VAL, HUGE_VAL, HUGE_VAL}, {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}};
}

static void include_point(struct mesh_box *box, struct vec3 p) {
    const double at[3] = {p.x, p.y, p.z};
    for (int k = 0; k < 3; k++) {
        box->lower[k] = at[k] < box->lower[k] ? at[k] : box->lower[k];
        box->upper[k] = at[k] > box->upper[k] ? at[k] : box->upper[k];
    }
}

static void include_box(struct mesh_box *box, const struct mesh_box *other) {
    for (int k = 0; k < 3; k++) {
        box->lower[k] = fmin(box->lower[k], other->lower[k]);
        box->upper[k] = fmax(box->upper[k], other->upper[k]);
    }
}

/* The triangles of a leaf: `first` and how many. */
static size_t leaf_range(const struct mesh *mesh, size_t leaf, size_t *first) {
    *first = LEAF * leaf;
    size_t rest = mesh->triangle_count - *first;
    return rest < LEAF ? rest : LEAF;
}

static void build_leaf(struct builder *b, struct span s) {
    struct mesh *mesh = b->mesh;
    struct mesh_box *box = &mesh->boxes[s.node];
    size_t first, count = leaf_range(mesh, s.leaf, &first);
    *box = empty_box();
    for (size_t i = first; i < first + count; i++) {
        int32_t t = mesh->order[i] = b->items[i].triangle;
        for (int k = 0; k < 3; k++)
            include_point(box, mesh_corner_point(mesh, t, k));
    }
}

/* As deep as the logarithm of the number of leaves. */
static void build_node(struct builder *b, struct span s) {
    if (s.leaves == 1) {
        build_leaf(b, s);
        return;
    }
    struct span left = left_of(s), right = right_of(s);
    size_t first = LEAF * s.leaf, middle = LEAF * right.leaf, last;
    last = LEAF * (s.leaf + s.leaves);
    if (last > b->mesh->triangle_count)
        last = b->mesh->triangle_count;
    struct item *items = b->items + first;
    select_least(items, last - first, middle - first, widest(items, last - first));
    build_node(b, left);
    build_node(b, right);
    b->mesh->boxes[s.node] = b->mesh->boxes[left.node];
    include_box(&b->mesh->boxes[s.node], &b->mesh->boxes[right.node]);
}

enum status mesh_tree_build(struct mesh *mesh, struct arena *arena) {
    struct builder b = {.mesh = mesh};
    mesh->leaf_count = (mesh->triangle_count + LEAF - 1) / LEAF;
    mesh->boxes = arena_alloc(arena, 2 * mesh->leaf_count - 1, sizeof *mesh->boxes);
    mesh->order = arena_alloc(arena, mesh->triangle_count, sizeof *mesh->order);
    struct arena_mark mark = arena_mark(arena);
    b.items = arena_alloc(arena, mesh->triangle_count, sizeof *b.items);
    if (!mesh->boxes || !mesh->order || !b.items)
        return STATUS_OUT_OF_MEMORY;
    fill_items(&b);
    build_node(&b, (struct span){0, 0, mesh->leaf_count});
    arena_rewind(arena, mark);
    return STATUS_OK;
}

/* ---- the nearest place ---- */

static double distance2_to_box(const struct mesh_box *box, const double at[3]) {
    double sum = 0;
    for (int k = 0; k < 3; k++) {
        double below = box->lower[k] - at[k], above = at[k] - box->upper[k];
        double outside = below > 0 ? below : above > 0 ? above : 0;
        sum += outside * outside;
    }
    return sum;
}

/* The point of the segment p q nearest to `at`. */
static struct vec3 nearest_on_edge(struct vec3 p, struct vec3 q, struct vec3 at) {
    struct vec3 along = vec3_sub(q, p);
    double share = vec3_dot(vec3_sub(at, p), along) / vec3_norm2(along);
    return share <= 0 ? p : share >= 1 ? q : vec3_axpy(share, along, p);
}

/* The point of a triangle nearest to `at`: its foot on the plane, or a point of one of the edges
 * beyond which the foot lies (the nearest of them). */
static struct vec3 nearest_on_triangle(const struct mesh *mesh, int32_t t, struct vec3 at) {
    struct vec3 p[3], normal = mesh->normals[t], best = at;
    mesh_corner_points(mesh, t, p);
    double least = HUGE_VAL;
    for (int k = 0; k < 3; k++) {
        struct vec3 from = p[k], to = p[(k + 1) % 3];
        if (vec3_dot(vec3_cross(vec3_sub(to, from), vec3_sub(at, from)), normal) >= 0)
            continue;
        struct vec3 point = nearest_on_edge(from, to, at);
        double distance2 = vec3_norm2(vec3_sub(point, at));
        if (distance2 < least) {
            least = distance2;
            best = point;
        }
    }
    return least < HUGE_VAL ? best : vec3_axpy(-vec3_dot(vec3_sub(at, p[0]), normal), normal, at);
}

struct search {
    const struct mesh *mesh;
    struct vec3 point;
    int32_t component;
    struct mesh_point best;
    double distance2;
};

static void search_leaf(struct search *search, size_t leaf) {
    const struct mesh *mesh = search->mesh;
    size_t first, count = leaf_range(mesh, leaf, &first);
    for (size_t i = first; i < first + count; i++) {
        int32_t t = mesh->order[i];
        if (search->component != MESH_ANY && mesh->component[t] != search->component)
            continue;
        struct vec3 r = nearest_on_triangle(mesh, t, search->point);
        double distance2 = vec3_norm2(vec3_sub(r, search->point));
        if (distance2 < search->distance2 ||
            (distance2 == search->distance2 && t < search->best.triangle)) {
            search->best = (struct mesh_point){t, r};
            search->distance2 = distance2;
        }
    }
}

/* A node that waits, with the distance to its box. */
struct waiting {
    struct span span;
    double distance2;
};

static void search_tree(struct search *search) {
    const struct mesh *mesh = search->mesh;
    const double at[3] = {search->point.x, search->point.y, search->point.z};
    struct waiting stack[STACK_MAX] = {{{0, 0, mesh->leaf_count}, 0}};
    for (size_t depth = 1; depth > 0;) {
        struct waiting w = stack[--depth];
        if (w.distance2 > search->distance2)
            continue;
        if (w.span.leaves == 1) {
            search_leaf(search, w.span.leaf);
            continue;
        }
        struct waiting near = {left_of(w.span), 0}, far = {right_of(w.span), 0};
        near.distance2 = distance2_to_box(&mesh->boxes[near.span.node], at);
        far.distance2 = distance2_to_box(&mesh->boxes[far.span.node], at);
        bool swapped = far.distance2 < near.distance2;
        stack[depth++] = swapped ? near : far;
        stack[depth++] = swapped ? far : near;
    }
}

bool mesh_nearest(const struct mesh *mesh, struct vec3 point, int32_t component,
                  struct mesh_point *nearest, double *distance) {
    struct search search = {mesh, point, component, {MESH_NONE, point}, HUGE_VAL};
    search_tree(&search);
    *nearest = search.best;
    if (distance)
        *distance = sqrt(search.distance2);
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
            stack[depth++] = right_of(s);
            stack[depth++] = left_of(s);
            continue;
        }
        size_t first, count = leaf_range(mesh, s.leaf, &first);
        for (size_t i = first; i < first + count; i++)
            visit(context, mesh->order[i]);
    }
}
