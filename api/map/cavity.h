/* SPDX-License-Identifier: MIT */
/*
 * The height of the cavity at each place of a target, where that is not the same everywhere: given
 * by element or by property, or between the mesh, which then lies on the tool, and a punch.
 */
#ifndef API_MAP_CAVITY_H
#define API_MAP_CAVITY_H

#include "target.h"

/* The surface of a punch, searched along lines. */
struct punch;

/* In `arena`; NULL without memory. `target` has a punch and outlives it. */
struct punch *punch_make(const struct map_target *target, struct arena *arena);

/* How far the punch is from a point along the line through it with this unit direction, on the side
 * on which it is nearer; 0 where it is further than a tenth of its box's diagonal, or nowhere. */
double punch_height(const struct punch *punch, struct vec3 point, struct vec3 direction);

/* Sets what the option `cavity_height` says: "H", or a list "pid:3:0.002,pid:4:0.003,0.0025" by the
 * mesh's properties, in which what stands later holds. False with the problem set. */
bool cavity_take_heights(struct map_target *target, const char *value, struct arena *arena,
                         struct api_problem *problem);

/* Sets what the option `punch` says: "pid:7,pid:8", properties whose elements are the punch; they
 * are taken out of the target. False with the problem set. */
bool cavity_take_punch(struct map_target *target, const char *value, struct arena *arena,
                       struct api_problem *problem);

#endif
