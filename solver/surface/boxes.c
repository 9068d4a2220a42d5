/* SPDX-License-Identifier: MIT */
#include "boxes.h"

/* ROUNDS: of partition, before the rest is sorted; a million items take some thirty. */
enum { LEAF = 4, DEPTH_MAX = 64, ROUNDS = 60, NO_AXIS = -1 };

struct item {
    struct box box;
    int32_t number;
};

/* A node of items first .. first + count - 1; its left half follows it, the right one is at
 * `right`, 0 in a leaf. */
struct node {
    struct box box;
    uint32_t first, count, right;
};

struct boxes {
    struct item *items;
    struct node *nodes;
    uint32_t node_count;
};

struct box box_round(struct vec3 a, struct vec3 b, double margin) {
    struct vec3 wider = {margin, margin, margin};
    return (struct box){vec3_sub(vec3_min(a, b), wider), vec3_add(vec3_max(a, b), wider)};
}

struct box box_join(const struct box *a, const struct box *b) {
    return (struct box){vec3_min(a->lower, b->lower), vec3_max(a->upper, b->upper)};
}

double box_distance2(const struct box *box, struct vec3 p) {
    double x = fmax(fmax(box->lower.x - p.x, p.x - box->upper.x), 0);
    double y = fmax(fmax(box->lower.y - p.y, p.y - box->upper.y), 0);
    double z = fmax(fmax(box->lower.z - p.z, p.z - box->upper.z), 0);
    return x * x + y * y + z * z;
}

/* ---- half of the items by one coordinate ---- */

/* Twice the middle of a box along x, y or z. */
static double middle(const struct box *box, int axis) {
    return axis == 0   ? box->lower.x + box->upper.x
           : axis == 1 ? box->lower.y + box->upper.y
                       : box->lower.z + box->upper.z;
}

static bool is_before(const struct item *a, const struct item *b, int axis) {
    double x = middle(&a->box, axis), y = middle(&b->box, axis);
    return x < y || (x == y && a->number < b->number);
}

static void swap_items(struct item *a, struct item *b) {
    struct item kept = *a;
    *a = *b;
    *b = kept;
}

/* Moves items[root] down until the heap of `count` items has the last in order on top. */
static void sink(struct item *items, uint32_t root, uint32_t count, int axis) {
    for (uint32_t child; (child = 2 * root + 1) < count; root = child) {
        child += child + 1 < count && is_before(&items[child], &items[child + 1], axis);
        if (!is_before(&items[root], &items[child], axis))
            return;
        swap_items(&items[root], &items[child]);
    }
}

static void sort(struct item *items, uint32_t count, int axis) {
    for (uint32_t k = count / 2; k-- > 0;)
        sink(items, k, count, axis);
    while (count > 1) {
        swap_items(&items[0], &items[--count]);
        sink(items, 0, count, axis);
    }
}

/* Puts the first half of the items in order before the others: partitions what holds the middle
 * again and again, in O(n) as a rule, and sorts it where an order was made to defeat that: O(n log
 * n). */
static void halve_items(struct item *items, uint32_t count, int axis) {
    uint32_t half = count / 2;
    for (int rounds = 0; count > 2 * LEAF && rounds < ROUNDS; rounds++) {
        /* at the middle one in order of the first, the middle and the last: those before it come
         * first and those after it last; at least one lies on either side */
        struct item *low = &items[0], *pivot = &items[count / 2], *high = &items[count - 1];
        if (is_before(pivot, low, axis))
            swap_items(pivot, low);
        if (is_before(high, pivot, axis))
            swap_items(high, pivot);
        if (is_before(pivot, low, axis))
            swap_items(pivot, low);
        swap_items(pivot, high - 1);
        uint32_t at = 1;
        for (uint32_t k = 1; k + 2 < count; k++)
            if (is_before(&items[k], &items[count - 2], axis))
                swap_items(&items[k], &items[at++]);
        swap_items(&items[at], &items[count - 2]);
        if (at == half)
            return;
        if (at > half) {
            count = at;
        } else {
            items += at + 1;
            count -= at + 1;
            half -= at + 1;
        }
    }
    sort(items, count, axis);
}

/* Halves the items at the middle of the longest side; depth first. Those of a leaf are in order
 * along the `axis` that halved the last. */
static uint32_t make_nodes(struct boxes *boxes, uint32_t first, uint32_t count, int axis) {
    uint32_t at = boxes->node_count++;
    struct item *items = boxes->items + first;
    struct box box = items[0].box;
    for (uint32_t k = 1; k < count; k++)
        box = box_join(&box, &items[k].box);
    boxes->nodes[at] = (struct node){box, first, count, 0};
    if (count <= LEAF) {
        if (axis != NO_AXIS)
            sort(items, count, axis);
        return at;
    }
    struct vec3 side = vec3_sub(box.upper, box.lower);
    axis = side.x >= side.y && side.x >= side.z ? 0 : side.y >= side.z ? 1 : 2;
    halve_items(items, count, axis);
    make_nodes(boxes, first, count / 2, axis);
    uint32_t right = make_nodes(boxes, first + count / 2, count - count / 2, axis);
    boxes->nodes[at].right = right;
    return at;
}

enum status boxes_make(const struct box *from, size_t count, struct arena *arena,
                       struct boxes **boxes) {
    struct boxes *made = arena_alloc(arena, 1, sizeof *made);
    if (!made || count > UINT32_MAX / 2)
        return STATUS_OUT_OF_MEMORY;
    made->items = arena_take(arena, count, sizeof *made->items);
    made->nodes = arena_take(arena, count + 1, sizeof *made->nodes);
    if (!made->items || !made->nodes)
        return STATUS_OUT_OF_MEMORY;
    for (size_t k = 0; k < count; k++)
        made->items[k] = (struct item){from[k], (int32_t)k};
    if (count > 0)
        make_nodes(made, 0, (uint32_t)count, NO_AXIS);
    *boxes = made;
    return STATUS_OK;
}

void boxes_visit(const struct boxes *boxes, const struct box *box,
                 bool (*visit)(void *context, int32_t number), void *context) {
    uint32_t stack[DEPTH_MAX], depth = 0;
    if (boxes->node_count == 0)
        return;
    stack[depth++] = 0;
    while (depth > 0) {
        uint32_t at = stack[--depth];
        const struct node *node = &boxes->nodes[at];
        if (!boxes_overlap(&node->box, box))
            continue;
        if (node->right) {
            stack[depth++] = node->right;
            stack[depth++] = at + 1;
            continue;
        }
        for (uint32_t k = node->first; k < node->first + node->count; k++)
            if (boxes_overlap(&boxes->items[k].box, box) && !visit(context, boxes->items[k].number))
                return;
    }
}
