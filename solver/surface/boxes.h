/* SPDX-License-Identifier: MIT */
/* A tree of boxes in space, to find those that meet another one: n log n to make. */
#ifndef SOLVER_SURFACE_BOXES_H
#define SOLVER_SURFACE_BOXES_H

#include "solver/arena.h"
#include "solver/status.h"
#include "solver/vec.h"
#include <stdbool.h>
#include <stdint.h>

struct box {
    struct vec3 lower, upper;
};

struct boxes;

/* `count` boxes, copied; they are known by their number. Errors: STATUS_OUT_OF_MEMORY. */
enum status boxes_make(const struct box *from, size_t count, struct arena *arena,
                       struct boxes **boxes) STATUS_MUST_USE;

/* Calls `visit` for every box that meets `box`, in an order that depends on the boxes alone, until
 * it answers false. */
void boxes_visit(const struct boxes *boxes, const struct box *box,
                 bool (*visit)(void *context, int32_t number), void *context);

/* The box round two points, wider by `margin` on all sides. */
struct box box_round(struct vec3 a, struct vec3 b, double margin);

struct box box_join(const struct box *a, const struct box *b);

static inline bool boxes_overlap(const struct box *a, const struct box *b) {
    return a->lower.x <= b->upper.x && b->lower.x <= a->upper.x && a->lower.y <= b->upper.y &&
           b->lower.y <= a->upper.y && a->lower.z <= b->upper.z && b->lower.z <= a->upper.z;
}

/* The square of the distance of a point from a box. */
double box_distance2(const struct box *box, struct vec3 point);

#endif
