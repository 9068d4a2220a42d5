/* SPDX-License-Identifier: MIT */
/*
 * The gap between the rim of the cloth and the mould, in which resin runs ahead of the flow through
 * the cloth (race-tracking): elements near the rim that are to have a permeability of their own.
 */
#ifndef API_MAP_CHANNEL_H
#define API_MAP_CHANNEL_H

#include "api/result/columns.h"
#include "map.h"
#include "solver/vec.h"

/*
 * Makes those elements MAP_CHANNEL in `target->roles` whose middle is no further from the rim of
 * the result than `target->channel_width`, in space, but for what has a role already; `*marked`
 * says how many. The rim of holes and trims is a rim. Scratch comes from `arena`. Returns API_OK,
 * API_INTERNAL for a damaged container or API_OUT_OF_MEMORY.
 */
enum api_problem_id map_channel_mark(const struct map_target *target,
                                     const struct api_reader *reader,
                                     const struct api_columns *columns, struct arena *arena,
                                     size_t *marked, struct api_problem *problem) STATUS_MUST_USE;

/* Of those elements sets k1, k2, k3, `k`, and the tensor in VTK's order to the permeability of the
 * channel, the same in every direction. Without a permeability of the cloth `k[0]` is NULL: then
 * the map is warned that it has none. The columns have a row for each element. */
void map_channel_fill(const struct map_target *target, double *const k[3], double *const tensor[6],
                      struct api_map *map);

/* The distance of a point from the straight line between two others, which may be the same. */
double map_segment_distance(struct vec3 a, struct vec3 b, struct vec3 point);

#endif
