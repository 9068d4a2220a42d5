/* SPDX-License-Identifier: MIT */
/* What two sets of closed polygons of the plane enclose both. */
#ifndef API_LAMINATE_CLIP_H
#define API_LAMINATE_CLIP_H

#include "api/result/polygons.h"

/* The boundary of what both enclose, into `both` (zero-initialised): pieces of the edges of each
 * that are inside the other, joined where they cross; edges on each other count as those of `a`.
 * O(n m). False without memory; the caller frees `both` in any case. */
bool clip_make(const struct polygons *a, const struct polygons *b, struct polygons *both);

#endif
