/* SPDX-License-Identifier: MIT */
/* The plies of a stack as they lie flat: each up to the rim of its cloth and within its boundary,
 * the warp along x and the weft along y, from the start of its drape. */
#ifndef API_LAMINATE_SHAPES_H
#define API_LAMINATE_SHAPES_H

#include "api/result/columns.h"
#include "api/result/polygons.h"
#include "laminate.h"

enum { LAMINATE_ALL = -1 };

/* One ply's, whose layers are alike, in the laminate's unit. */
struct laminate_shape {
    struct polygons cut;
    double low[2], high[2], area;
    size_t ply;
};

struct laminate_shapes {
    struct laminate_shape *shapes;
    size_t count;
};

/* Of one ply (from 0) or of all; plies whose net is NULL have none. False with the problem set:
 * API_INVALID_REQUEST (a boundary that cannot be followed), API_INTERNAL, API_OUT_OF_MEMORY. To be
 * freed in any case. */
bool laminate_shapes_make(const struct laminate *laminate, const struct api_reader *const *nets,
                          int ply, struct arena *arena, struct laminate_shapes *shapes,
                          struct api_problem *problem);
void laminate_shapes_free(struct laminate_shapes *shapes);

#endif
