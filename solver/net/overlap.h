/* SPDX-License-Identifier: MIT */
/*
 * Where the net would meet itself. On a surface that closes over a pole, and where yarns run free
 * round an obstacle, the net can come back to a place it covers already. A spatial hash of
 * patches of 4 by 4 nodes, by boxes round what they reach, finds those near a new one; it folds
 * when it lies in the cells round a node that is not its neighbour in the net, as that node's own
 * yarns measure it: so shear does not matter.
 */
#ifndef SOLVER_NET_OVERLAP_H
#define SOLVER_NET_OVERLAP_H

#include "curtain.h"
#include "net.h"
#include "solver/shell/shell_slit.h"
#include "solver/shell/surface_point.h"

struct overlap;

/* What tells the unit normal of the surface at a node; zero where there is none. */
struct overlap_normals {
    struct vec3 (*at)(void *context, const struct net_node *node);
    void *context;
};

/* For nodes of `net`, which are `spacing` apart, in its arena; there are none yet, but room for
 * about `count`. Nodes that differ by more than turn[k] in parameter k lie on either side of a slit
 * and do not meet, HUGE_VAL where there is none; nor do those with a `slit` or `curtain` between
 * them, each of which may be NULL. NULL without memory. */
struct overlap *overlap_make(struct net *net, size_t count, const double spacing[2],
                             const double turn[2], const struct shell_slit *const slit[2],
                             const struct curtain *curtain, struct overlap_normals normals);

/* From now on there are no slits. */
void overlap_pass_slits(struct overlap *overlap);

/* Adds the node inside at (i, j), which is at r; and all of a tile. Errors: STATUS_OUT_OF_MEMORY.
 */
enum status overlap_add(struct overlap *overlap, int32_t i, int32_t j,
                        struct vec3 r) STATUS_MUST_USE;
enum status overlap_add_tile(struct overlap *overlap, const struct net_tile *tile,
                             bool shaped) STATUS_MUST_USE;

/* To be called when the node (i, j) has been taken out of the net. */
void overlap_forget(struct overlap *overlap, int32_t i, int32_t j);

/* The patches of a tile that has been added shaped with nodes that may lie on another part of the
 * net, as bits: of patch p in i and q in j that of p + 4 q. The others do not: what is near them is
 * near in the net, too, where yarns bend too little to come back, or lies apart from them
 * (`separation.h`). Only where all nodes are fourth corners of cells, each the one after its
 * neighbours on the side of the generators. */
unsigned overlap_suspects(struct overlap *overlap, const struct net_tile *tile);

/* The same of any net whose tiles have all been added. */
unsigned overlap_layers(struct overlap *overlap, const struct net_tile *tile);

/* A patch is a square of so many places a side, as a power of two; a quarter of a tile's. */
enum { OVERLAP_PATCH_BITS = 2 };

/* The bit of the patch with the node at column x and row y of a tile. */
static inline int overlap_patch_of(int x, int y) {
    return (x >> OVERLAP_PATCH_BITS) + (y >> OVERLAP_PATCH_BITS) * (NET_TILE >> OVERLAP_PATCH_BITS);
}

/* What a tile is, as far as a look at its yarns' steps tells. */
enum overlap_tile {
    OVERLAP_TILE_APART,  /* no node of it is in the cells round another but a neighbour's */
    OVERLAP_TILE_NEAR,   /* the same, but it lies near one of the others */
    OVERLAP_TILE_SUSPECT /* some may be */
};

/* What the tiles of a net are, given all in their order, as an array from its arena; for nodes that
 * are `spacing` apart. A look is had at less than a tenth of the cost of an index. NULL without
 * memory. */
enum overlap_tile *overlap_look(struct net *net, struct net_tile *const *tiles,
                                const double spacing[2]);

/* Whether some other part of the net is near enough to a node (i, j) at r for that to be asked. */
bool overlap_is_near(struct overlap *overlap, int32_t i, int32_t j, struct vec3 r);

/* Whether a node (i, j) at the point would lie on another part of the net; and on one that comes
 * before it: not on nodes of its own quadrant in rows further from the generator, or further along
 * its own. */
bool overlap_meets(struct overlap *overlap, int32_t i, int32_t j,
                   const struct surface_point *point);
bool overlap_meets_before(struct overlap *overlap, int32_t i, int32_t j,
                          const struct surface_point *point);

/* Whether a cell from a node of the tile on is whole and turned over, by the normals of the
 * surface. */
bool overlap_turns_over(struct net *net, const struct net_tile *tile, const double spacing[2],
                        struct overlap_normals normals);

/* Whether the node (i, j), where the surface has this normal, lies in a cell of the net that has no
 * corner there, or the middle of the cell from it on in another one, well inside and on the same
 * sheet; `cell` gets its lower corner. */
bool overlap_lies_on(struct overlap *overlap, int32_t i, int32_t j, struct vec3 normal,
                     int32_t cell[2]);

#endif
