/* SPDX-License-Identifier: MIT */
/*
 * Where the net would meet itself. On a surface that closes over a pole, and where yarns run free
 * round an obstacle, the net can come back to a place it covers already. A spatial hash of the
 * nodes finds those near a new one; it folds when it lies in the cells round a node that is not
 * its neighbour in the net, as that node's own yarns measure it: so shear does not matter.
 */
#ifndef SOLVER_NET_FOLD_H
#define SOLVER_NET_FOLD_H

#include "net.h"
#include "solver/shell/station.h"

struct fold;

/* An empty hash for nodes of `net`, which are `spacing` apart, with room for `count` of them, in
 * its arena. Nodes that differ by more than turn[k] in parameter k lie on either side of a cut and
 * do not meet; HUGE_VAL where there is none. NULL without memory. */
struct fold *fold_make(struct net *net, size_t count, const double spacing[2],
                       const double turn[2]);

/* From now on there is no cut. */
void fold_pass_cut(struct fold *fold);

/* Adds the place (i, j) of the net, which is at r. Errors: STATUS_OUT_OF_MEMORY. */
enum status fold_add(struct fold *fold, int32_t i, int32_t j, struct vec3 r) STATUS_MUST_USE;

/* Whether some other part of the net is near enough to a node (i, j) at r for that to be asked. */
bool fold_is_near(struct fold *fold, int32_t i, int32_t j, struct vec3 r);

/* Whether a node (i, j) at the station would lie on another part of the net. */
bool fold_meets(struct fold *fold, int32_t i, int32_t j, const struct station *station);

#endif
