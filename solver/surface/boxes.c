/* SPDX-License-Identifier: MIT */
#include "boxes.h"

#include <stdlib.h>

enum { LEAF = 4, DEPTH_MAX = 64 };

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
    return (struct box){
        {fmin(a.x, b.x) - margin, fmin(a.y, b.y) - margin, fmin(a.z, b.z) - margin},
        {fmax(a.x, b.x) + margin, fmax(a.y, b.y) + margin, fmax(a.z, b.z) + margin}};
}

struct box box_join(const struct box *a, const struct box *b) {
    return (struct box){
        {fmin(a->lower.x, b->lower.x), fmin(a->lower.y, b->lower.y), fmin(a->lower.z, b->lower.z)},
        {fmax(a->upper.x, b->upper.x), fmax(a->upper.y, b->upper.y), fmax(a->upper.z, b->upper.z)}};
}

double box_distance2(const struct box *box, struct vec3 p) {
    double x = fmax(fmax(box->lower.x - p.x, p.x - box->upper.x), 0);
    double y = fmax(fmax(box->lower.y - p.y, p.y - box->upper.y), 0);
    double z = fmax(fmax(box->lower.z - p.z, p.z - box->upper.z), 0);
    return x * x + y * y + z * z;
}

static bool meet(const struct box *a, const struct box *b) {
    return a->lower.x <= b->upper.x && b->lower.x <= a->upper.x && a->lower.y <= b->upper.y &&
           b->lower.y <= a->upper.y && a->lower.z <= b->upper.z && b->lower.z <= a->upper.z;
}

static int compare(double a, double b, const struct item *p, const struct item *q) {
    return a < b ? -1 : a > b ? 1 : (p->number > q->number) - (p->number < q->number);
}

static int by_x(const void *a, const void *b) {
    const struct item *p = a, *q = b;
    return compare(p->box.lower.x + p->box.upper.x, q->box.lower.x + q->box.upper.x, p, q);
}

static int by_y(const void *a, const void *b) {
    const struct item *p = a, *q = b;
    return compare(p->box.lower.y + p->box.upper.y, q->box.lower.y + q->box.upper.y, p, q);
}

static int by_z(const void *a, const void *b) {
    const struct item *p = a, *q = b;
    return compare(p->box.lower.z + p->box.upper.z, q->box.lower.z + q->box.upper.z, p, q);
}

/* Halves the items at the middle of the longest side; depth first. */
static uint32_t divide(struct boxes *boxes, uint32_t first, uint32_t count) {
    uint32_t at = boxes->node_count++;
    struct item *items = boxes->items + first;
    struct box box = items[0].box;
    for (uint32_t k = 1; k < count; k++)
        box = box_join(&box, &items[k].box);
    boxes->nodes[at] = (struct node){box, first, count, 0};
    if (count <= LEAF)
        return at;
    struct vec3 side = vec3_sub(box.upper, box.lower);
    qsort(items, count, sizeof *items,
          side.x >= side.y && side.x >= side.z ? by_x
          : side.y >= side.z                   ? by_y
                                               : by_z);
    divide(boxes, first, count / 2);
    uint32_t right = divide(boxes, first + count / 2, count - count / 2);
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
        divide(made, 0, (uint32_t)count);
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
        if (!meet(&node->box, box))
            continue;
        if (node->right) {
            stack[depth++] = node->right;
            stack[depth++] = at + 1;
            continue;
        }
        for (uint32_t k = node->first; k < node->first + node->count; k++)
            if (meet(&boxes->items[k].box, box) && !visit(context, boxes->items[k].number))
                return;
    }
}
