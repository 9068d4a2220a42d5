/* SPDX-License-Identifier: MIT */
/*
 * The flat cut pattern: the net before it was sheared, node (i, j) at (i a, j b) for the spacings a
 * and b. It shows the outline of the cells, the start with the directions of warp and weft, the
 * cells beyond the locking angle hatched, a bar of a round length and a title.
 *
 * - svg: millimetres at true scale, warp to the right, weft up.
 * - dxf: R12 in ASCII, in the drape's own unit ($INSUNITS), the start at the origin; layers
 * OUTLINE, START, GRAIN, LOCKED and TITLE.
 *
 * Patterns are encoders (`encode.h`); columns and precision have no say in them.
 */
#ifndef API_FORMAT_PATTERN_H
#define API_FORMAT_PATTERN_H

#include "encode.h"
#include <stddef.h>

/* The formats of patterns by name, or walked, the default first; NULL when there is none. */
const struct api_format *api_pattern_named(const char *name);
const struct api_format *api_pattern_at(size_t index);

#endif
