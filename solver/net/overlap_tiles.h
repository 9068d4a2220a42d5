/* SPDX-License-Identifier: MIT */
/*
 * Tiles that cannot lie on the rest of the net, found at a small share of what it costs to look at
 * their nodes. Let a be all steps along warp, and b along weft, in a tile and those round it, and A
 * and B dual to their means: A . a is about 1 and A . b about 0. Where any two places there are
 * joined by a way along the yarns without a turn back, those that are m >= n places apart along
 * warp and weft are at least m (min A . a - max |A . b|) apart along A. That is more than the cells
 * round a node reach (`separation.h`) for all that are not neighbours, unless yarns bend much
 * within two tiles.
 */
#ifndef SOLVER_NET_OVERLAP_TILES_H
#define SOLVER_NET_OVERLAP_TILES_H

#include "overlap_patches.h"

/* What the tiles of a net, all of them, are in their order, as an array from the net's arena: of
 * nodes whose cells reach so far, and that are neighbours if their places differ by no more than
 * `neighbours` along both yarns. Space is hashed by cubes of that side. NULL without memory. */
enum overlap_tile *overlap_tiles(struct net *net, struct net_tile *const *tiles, double cube,
                                 double reach, int neighbours);

#endif
