/* SPDX-License-Identifier: MIT */
/* Elements by stacks that are alike, for formats that state a stack once for many elements. */
#ifndef API_FORMAT_STACKS_H
#define API_FORMAT_STACKS_H

#include "cards.h"

/* All arrays are of malloc. */
struct stacks {
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
bool stacks_make(struct stacks *stacks, const struct map_fields *fields, bool angles,
                 double within);

/* NULL-safe within. */
void stacks_free(struct stacks *stacks);

/* ---- of a deck whose `encoder->state` is a struct stacks ---- */

/* Checks the stacks of the encoder's map and groups them, as its option `within` says. False with
 * the problem set. */
bool stacks_begin(struct encoder *encoder, bool angles, struct api_problem *problem);

/* How many groups there are, as the count of a part. */
size_t stacks_groups(const struct encoder *encoder);

void stacks_end(struct encoder *encoder);

#endif
