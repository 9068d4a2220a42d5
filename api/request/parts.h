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
static const struct place_range decode_coordinates = {-1e12, 1e12, false};
static const struct place_range decode_lengths = {1e-12, 1e12, false};
static const struct place_range decode_fractions = {0, 1, true};

/* In any of the forms of the contract; one named by its id alone becomes API_SURFACE_NAMED. */
bool decode_surface(const struct json_place *place, struct api_surface *surface);

/* geomdl's `trims`: {"count", "data": [...]}, or the list alone. */
bool decode_trims(const struct json_place *place, struct api_surface *surface);

bool decode_permeability(const struct json_place *place, struct api_permeability *permeability);

/* The definition itself: `surface`, or the surface in the file that geomdl's export_json writes.
 * `file` has the way to it: not to be copied. */
struct decode_definition {
    struct json_place shape, data, first;
};
const struct json_place *decode_definition_find(const struct json_place *surface,
                                                struct decode_definition *file);

#endif
