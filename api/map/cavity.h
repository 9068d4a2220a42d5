/* SPDX-License-Identifier: MIT */
/*
 * The height of the cavity at each point of a target, where that is not the same everywhere: given
 * by element or by property, or between the mesh, which then lies on the tool, and a punch.
 */
#ifndef API_MAP_CAVITY_H
#define API_MAP_CAVITY_H

#include "api/input.h"
#include "api/limits.h"
#include "map.h"
#include "net.h"

/* What a target says of the cavity; and of how many points a warning speaks, which who maps counts.
 */
struct cavity {
    const struct map_target *target;
    const struct punch *punch; /* its surface, searched along lines; NULL: there is none */
    size_t open;               /* the punch is not above them */
    size_t loose;              /* the cloth by itself is thinner than the cavity */
    size_t packed;             /* there are more fibres than can be packed */
};

/* Whether the target says anything of it. */
bool cavity_given(const struct map_target *target);

/* False without memory. `target` outlives it. */
bool cavity_begin(struct cavity *cavity, const struct map_target *target, struct arena *arena);

/* The height at a point, 0 where the target says nothing: what it has for this point, or how far
 * the punch is from it along the cloth's unit normal, on the side on which it is nearer, unless
 * that is more than a tenth of the diagonal of its box. */
double cavity_height(const struct cavity *cavity, size_t number, struct vec3 normal);

/* Warns of the points that were counted. `whose` cavity holds where the punch is not above: "drape"
 * or "laminate". */
void cavity_warn(const struct cavity *cavity, struct api_map *map, const char *whose);

/* Has the target know whose cloth it is that its heights press, or the drape's own rigid cavity,
 * and where it `wants_yarns` what that is made of: that of the request whose result `reader` has. A
 * stored surface need not be among the input. False with the problem set. */
bool cavity_take_cloth(struct map_target *target, const struct api_reader *reader,
                       const struct api_input *input, const struct api_limits *limits,
                       struct arena *arena, struct api_problem *problem);

/* How thick cloth of this shear is by itself: n t0 / cos gamma. */
double press_thickness(const struct api_request *cloth, double shear_deg);

/* Writes what a cavity of this height (> 0) makes of cloth of this shear into the row of a point,
 * in which all else stays (`api/result/fields.h`). Returns whether it has more fibres than can be
 * packed. */
bool press_row(const struct map_net *net, const struct api_request *cloth, double height,
               double shear_deg, double *row);

#endif
