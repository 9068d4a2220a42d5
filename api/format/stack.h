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

/* A layer of a group's stack. */
struct stack_layer {
    int16_t ply; /* from 0 */
    double thickness;
    double angle_deg; /* from the bottom ply's, in (-90, 90] */
};

/* All arrays are of malloc. */
struct stack_groups {
    size_t count;
    int32_t *group;  /* of each element; -1: it has no plies */
    int32_t *member; /* elements by group; `start` has `count` + 1 entries */
    size_t *start;
    struct stack_layer *layer; /* by group, from the bottom; `first` has `count` + 1 entries */
    size_t *first;
    /* How far an element's stack is from its group's at most: angles, and thicknesses in percent */
    double angle_deg, thickness_percent;
};

/*
 * The stacks of a group have the same plies in the same order along the element's normal. The group
 * has the middles of their thicknesses and angles, which differ by at most `within` percent of
 * thickness and, if `angles` matter, `within` degrees from those of each; with 0 by at most
 * 1e-7 of each. False without memory; stack_groups_free in any case.
 */
bool stack_groups_make(struct stack_groups *groups, const struct map_fields *fields, bool angles,
                       double within);
void stack_groups_free(struct stack_groups *groups);

#endif
