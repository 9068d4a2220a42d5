/* SPDX-License-Identifier: MIT */
/*
 * The parts of a net where they lie in space: patches of 4 by 4 nodes, each with a box round all
 * that its nodes reach. A patch is found by its place in the net, and by the cubes that its box
 * touches, which space is hashed by.
 */
#ifndef SOLVER_NET_OVERLAP_PATCHES_H
#define SOLVER_NET_OVERLAP_PATCHES_H

#include <math.h>

#include "overlap.h"

enum { OVERLAP_NONE = -1 };

struct overlap_box {
    double low[3], high[3];
};

/* A sheet of the surface that is further away than half a spacing is another one. */
static const double overlap_sheet_gap = 0.5;

static const struct overlap_box overlap_nothing = {{HUGE_VAL, HUGE_VAL, HUGE_VAL},
                                                   {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}};

static inline void overlap_stretch_box(struct overlap_box *box, struct vec3 r, double by) {
    const double at[3] = {r.x, r.y, r.z};
    for (int k = 0; k < 3; k++) {
        box->low[k] = at[k] - by < box->low[k] ? at[k] - by : box->low[k];
        box->high[k] = at[k] + by > box->high[k] ? at[k] + by : box->high[k];
    }
}

/* How a patch is bent: the square of the largest second difference of its yarns, and of the least
 * sine of the angle between them. */
struct overlap_shape {
    double bend2, sine2;
};

struct overlap_patch {
    int32_t pi, pj; /* it holds i = pi * 4 .. + 3, j alike */
    const struct net_tile *tile;
    struct overlap_box box; /* of all that its nodes reach */
    struct overlap_shape shape;
    int32_t frame; /* a number that whoever asks may keep with it, OVERLAP_NONE at first */
};

/* A patch in a cube that its box touches. */
struct overlap_entry {
    int32_t patch, next; /* the next one whose cube has the same hash, or OVERLAP_NONE */
};

struct overlap_patches {
    struct arena *arena;
    double cube; /* the side of the cubes */
    struct overlap_patch *patch;
    size_t count, room;
    int32_t *slots; /* patches by their numbers, open addressing; OVERLAP_NONE is free */
    size_t slot_count;
    struct overlap_entry *sites;
    size_t site_count, site_room;
    int32_t *cubes; /* the first site of each hash, or OVERLAP_NONE */
    size_t cube_count;
};

/* The cubes that a box touches: from the first to the last, along each axis; none of an empty one.
 */
struct overlap_cubes {
    int64_t first[3], last[3];
};

/* No patches, with room in the arena for those of about `nodes` nodes; false without memory. */
bool overlap_patches_make(struct overlap_patches *patches, struct arena *arena, size_t nodes,
                          double cube);

/* Asks of each patch that comes near the nodes of one, which reach so far, until that is `enough`:
 * whether it was. */
bool overlap_patches_meet(const struct overlap_patches *patches, const struct overlap_patch *patch,
                          double reach, bool (*enough)(void *context, int32_t other),
                          void *context);

/* Stretches the patch (pi, pj) of a tile by a box, and sets how it is bent. Errors:
 * STATUS_OUT_OF_MEMORY. */
enum status overlap_patches_stretch(struct overlap_patches *patches, int32_t pi, int32_t pj,
                                    const struct net_tile *tile, const struct overlap_box *box,
                                    struct overlap_shape shape) STATUS_MUST_USE;

static inline size_t overlap_hash(int64_t x, int64_t y, int64_t z) {
    uint64_t key = (uint64_t)x * UINT64_C(0x9E3779B97F4A7C15);
    key = (key ^ (uint64_t)y) * UINT64_C(0xC2B2AE3D27D4EB4F);
    key = (key ^ (uint64_t)z) * UINT64_C(0x165667B19E3779F9);
    return (size_t)(key >> 32);
}

/* The slot that holds a patch, or the free one where it belongs. */
static inline int32_t *overlap_patches_slot(const struct overlap_patches *patches, int32_t pi,
                                            int32_t pj) {
    size_t last = patches->slot_count - 1, at = overlap_hash(pi, pj, 0) & last;
    for (; patches->slots[at] != OVERLAP_NONE; at = (at + 1) & last) {
        const struct overlap_patch *patch = &patches->patch[patches->slots[at]];
        if (patch->pi == pi && patch->pj == pj)
            break;
    }
    return &patches->slots[at];
}

/* The patch (pi, pj), or NULL. */
static inline const struct overlap_patch *
overlap_patches_find(const struct overlap_patches *patches, int32_t pi, int32_t pj) {
    int32_t number = *overlap_patches_slot(patches, pi, pj);
    return number == OVERLAP_NONE ? NULL : &patches->patch[number];
}

/* The number of the first site of a cube; sites of other cubes with its hash are among those that
 * follow. */
static inline int32_t overlap_patches_first(const struct overlap_patches *patches,
                                            const int64_t at[3]) {
    return patches->cubes[overlap_hash(at[0], at[1], at[2]) & (patches->cube_count - 1)];
}

static inline struct overlap_cubes overlap_patches_cubes(const struct overlap_patches *patches,
                                                         const struct overlap_box *box) {
    struct overlap_cubes cubes = {{0, 0, 0}, {-1, -1, -1}};
    for (int k = 0; k < 3 && box->low[0] <= box->high[0]; k++) {
        cubes.first[k] = (int64_t)floor(box->low[k] / patches->cube);
        cubes.last[k] = (int64_t)floor(box->high[k] / patches->cube);
    }
    return cubes;
}

#endif
