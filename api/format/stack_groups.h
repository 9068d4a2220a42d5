/* SPDX-License-Identifier: MIT */
/* Elements by stacks that are alike, for formats that state a stack once for many elements. */
#ifndef API_FORMAT_STACK_GROUPS_H
#define API_FORMAT_STACK_GROUPS_H

#include "deck.h"

/* All arrays are of malloc. */
struct stack_groups {
    size_t count;
    int32_t *group;  /* of each element; -1: bare */
    int32_t *member; /* elements by group; `start` has `count` + 1 entries */
    size_t *start;
};

/*
 * Two stacks are alike when they have the same plies in the same order along the element's normal,
 * thicknesses that differ by at most `within` percent, and, if `angles` matter, angles from the
 * first ply's that differ by at most `within` degrees; with 0 by at most a millionth of that. A
 * group has the values of its first member. False without memory.
 */
bool stack_groups_make(struct stack_groups *groups, const struct map_fields *fields, bool angles,
                       double within);

/* NULL-safe within. */
void stack_groups_free(struct stack_groups *groups);

/* ---- of a deck whose `encoder->state` is a struct stack_groups ---- */

/* Checks the stacks of the encoder's map and groups them, as its option `within` says. False with
 * the problem set. */
bool stack_groups_begin(struct encoder *encoder, bool angles, struct api_problem *problem);

/* How many groups there are, as the count of a part. */
size_t stack_groups_count(const struct encoder *encoder);

void stack_groups_end(struct encoder *encoder);

#endif
