/* SPDX-License-Identifier: MIT */
/*
 * The parts of a request document, one decoder each, used by `decode.c`. Each fills its struct,
 * reports every error it finds at its place and returns whether all was well.
 */
#ifndef API_REQUEST_PARTS_H
#define API_REQUEST_PARTS_H

#include "api/json/place.h"
#include "request.h"

/* Ranges that more than one part uses; see `decode.h`. */
static const struct tree_range decode_coordinates = {-1e12, 1e12, false};
static const struct tree_range decode_lengths = {1e-12, 1e12, false};
static const struct tree_range decode_fractions = {0, 1, true};

/* In any of the forms of the contract; one named by its id alone becomes API_SURFACE_NAMED. */
bool decode_surface(const struct tree_place *place, struct api_surface *surface);

/* geomdl's `trims`: {"count", "data": [...]}, or the list alone. */
bool decode_trims(const struct tree_place *place, struct api_surface *surface);

bool decode_permeability(const struct tree_place *place, struct api_permeability *permeability);

/* The definition itself: `surface`, or the surface in the file that geomdl's export_json writes.
 * `file` has the way to it: not to be copied. */
struct decode_definition {
    struct tree_place shape, data, first;
};
const struct tree_place *decode_definition_find(const struct tree_place *surface,
                                                struct decode_definition *file);

/* Where control points and weights are: together in an object, or the bare list of points with the
 * weights beside it. Points to its own members: not to be copied. */
struct decode_control {
    struct tree_place net, points, weights;
};
void decode_control_find(const struct tree_place *owner, struct decode_control *control);

#endif
