/* SPDX-License-Identifier: MIT */
/* A result and a mesh small enough to be written down: three cells in an L, with every column, and
 * a quadrilateral and a triangle with mapped fields. */
#ifndef UNIT_SMALL_H
#define UNIT_SMALL_H

#include "api/format/format.h"
#include "support.h"

/* A result of these cells, which are sorted by j, then i; the nodes are their corners. */
struct bytes small_result_of(const int (*cells)[2], size_t count, const char *unit);

/* The L. */
struct bytes small_result(void);

/* The mesh; what it points to lives for good. */
struct map_fields small_mesh(void);

/* The mesh with a stack of two plies against warp x weft, of which the triangle, which looks to the
 * other side, has the second alone; the quadrilateral shares its numbers with the file. */
struct map_fields small_stack(void);

/* Sets a value of the last mesh; the next one has its own again. */
void small_mesh_set(const char *column, size_t element, double value);

/* The same in a strip of `count` quadrilaterals whose k1 turns by `turn_deg` from one to the next.
 */
struct map_fields small_strip(size_t count, double turn_deg);
void small_strip_free(struct map_fields *fields);

#endif
