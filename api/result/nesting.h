/* SPDX-License-Identifier: MIT */
/*
 * Flat shapes on a roll of cloth, as short of it as can be found: x runs along the roll, as the
 * warp does, y across. A shape lies as it is or turned by half a turn, which leaves the yarns and
 * the face of the cloth as they were; it is never turned otherwise, nor mirrored.
 *
 * The shapes are laid one after the other, each as far down the roll as those before it let it, by
 * their true outline in bands across the roll. Some orders by size are tried, then exchanges of two
 * in the best of them; what is found is no longer than shelves of their rectangles. The same shapes
 * give the same places.
 */
#ifndef API_RESULT_NESTING_H
#define API_RESULT_NESTING_H

#include "polygons.h"
#include "solver/arena.h"

struct nesting_shape {
    const struct polygons *cut;
    double low[2], high[2]; /* the box round it */
    double area;
    int layers; /* so many of it, at least 1 */
};

struct nesting_roll {
    double width; /* no shape is wider */
    double gap;   /* at least so much lies between shapes, along the roll or across */
    bool turn;    /* half turns are allowed */
};

struct nesting_place {
    size_t shape; /* its number, */
    int layer;    /* and which of its layers, from 0 */
    double x, y;  /* of the lower left corner of its box */
    bool turned;
};

/* Where a point of a shape lies. */
void nesting_point(const struct nesting_shape *shape, const struct nesting_place *place, double x,
                   double y, double on_roll[2]);

/* The places of all layers of `count` shapes, as many as these have together, in the arena, sorted
 * along the roll; and how long the roll has to be. False without memory. */
bool nesting_make(const struct nesting_shape *shapes, size_t count, const struct nesting_roll *roll,
                  struct arena *arena, struct nesting_place **places, double *length);

#endif
