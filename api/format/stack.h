/* SPDX-License-Identifier: MIT */
/* The plies at an element of a map, from its bottom along its own normal; and elements by stacks
 * that are alike, for formats that state a stack once for many elements. */
#ifndef API_FORMAT_STACK_H
#define API_FORMAT_STACK_H

#include "element_frame.h"

/* Whether the plies follow each other along the element's normal; it has plies. */
bool stack_is_upward(const struct map_fields *fields, size_t element);

/* How many plies an element has, and the k-th from its bottom. */
size_t stack_layers(const struct map_fields *fields, size_t element);
const struct map_ply_row *stack_layer(const struct map_fields *fields, size_t element, size_t k);

/* The row of a ply at an element, NULL when it is not there. */
const struct map_ply_row *stack_row(const struct map_fields *fields, size_t element, int ply);

/* The frame of an element that has plies. */
struct element_frame stack_frame(const struct map_fields *fields, size_t element);

/* The least thickness that a ply has: what thinning factors refer to. 0: it is nowhere. */
double stack_least_thickness(const struct map_fields *fields, int ply);

/* All arrays are of malloc. */
struct stack_groups {
    size_t count;
    int32_t *group;  /* of each element; -1: it has no plies */
    int32_t *member; /* elements by group; `start` has `count` + 1 entries */
    size_t *start;
};

/*
 * Two stacks are alike when they have the same plies in the same order along the element's normal,
 * thicknesses that differ by at most `within` percent, and, if `angles` matter, angles from the
 * first ply's that differ by at most `within` degrees; with 0 by at most a millionth of that. A
 * group has the values of its first member. False without memory; stack_groups_free in any case.
 */
bool stack_groups_make(struct stack_groups *groups, const struct map_fields *fields, bool angles,
                       double within);
void stack_groups_free(struct stack_groups *groups);

#endif
