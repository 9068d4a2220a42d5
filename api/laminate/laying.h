/* SPDX-License-Identifier: MIT */
/*
 * How a ply is laid by hand, as its net grew: fixed at one place, smoothed along the warp and the
 * weft through it, then worked outwards in the four sectors between these, where the shear is. Of
 * a ply on which its start does not lie the place is the middle of its longest line along the warp.
 */
#ifndef API_LAMINATE_LAYING_H
#define API_LAMINATE_LAYING_H

#include "flat_plies.h"

enum { LAYING_SECTORS = 4 };

struct laying_sector {
    int warp, weft; /* the directions between which it lies, 1 or -1 */
    size_t cells;   /* 0: the ply has none there */
    size_t locked;  /* of whole ones beyond the locking angle */
    double mean_deg;
    double greatest_deg; /* with its sign: above 0 warp and weft close */
    double flat[2];      /* the place of that, in lengths from the start of the drape, ... */
    struct vec3 place;   /* ... and on the part */
};

struct laying {
    bool at_start;   /* it begins at the start of its drape */
    double begin[2]; /* where it begins, in lengths, ... */
    struct vec3 place;
    double reach[2][2]; /* ... and how far it goes from there back and ahead, of warp and weft */
    struct laying_sector sectors[LAYING_SECTORS]; /* those with the least shear first */
};

/* Of a shape and its net, whose columns are open. False where these cannot be read. */
bool laying_find(const struct api_reader *net, const struct api_columns *columns,
                 const struct api_fabric *fabric, const struct flat_ply *shape,
                 struct laying *laying);

#endif
