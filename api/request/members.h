/* SPDX-License-Identifier: MIT */
/*
 * The parts of a request document, one decoder each, used by `decode.c`. Each fills its struct,
 * reports every error it finds at its place and returns whether all was well.
 */
#ifndef API_REQUEST_MEMBERS_H
#define API_REQUEST_MEMBERS_H

#include "api/input.h"
#include "api/json/value.h"
#include "material.h"
#include "request.h"

/* Ranges that more than one part uses; see `decode.h`. */
static const struct value_range decode_coordinates = {-1e12, 1e12, false};
static const struct value_range decode_lengths = {1e-12, 1e12, false};
static const struct value_range decode_fractions = {0, 1, true};
static const struct value_range decode_areal_weights = {1e-6, 1e6, false}; /* kg/m^2 */

static const struct value_range decode_prices = {1e-6, 1e9, false}; /* a m^2 */

/* A drape request, alone or within another document: all of `decode.h`. What is wrong is reported
 * to the tree's problem. */
void decode_drape(const struct json_value *json, const struct api_input *input,
                  const struct api_limits *limits, struct api_request *request);

/* One of the units that lengths may be in; `unit` stays as it is after a fault. */
bool decode_unit_name(const struct json_value *json, const struct api_unit **unit);

/* A start on the request's surface, into its settings. */
void decode_start(const struct json_value *json, struct api_request *request);

/* What the plies of a laminate have in common: `surface`, `length_unit` and `rosette` of an object,
 * and the defaults of all else; then, of a copy of that, what the object of one ply says of its
 * cloth. Keys are not checked. */
void decode_common(const struct json_value *json, const struct api_input *input,
                   const struct api_limits *limits, struct api_request *request);
void decode_ply(const struct json_value *json, struct api_request *request);

/* A name of 1 to `most` printable ASCII characters, as the cards of solvers need them, copied to
 * `name` with its end; `name` stays as it is after a fault. */
bool decode_name(const struct json_value *json, size_t most, char *name);

/* Whether angles rise from value to value by no less than a measurement resolves, so that slopes
 * between them are finite; otherwise reported at the first that does not. */
bool decode_rising(const struct json_value *column, const double *values, size_t count);

/* In any of the forms of the contract; one named by its id alone becomes API_SURFACE_NAMED. */
bool decode_surface(const struct json_value *json, struct api_surface *surface);

/* Where control points and weights are: together in an object, or the bare list of points with the
 * weights beside it. Points to its own members: not to be copied. */
struct decode_control {
    struct json_value net, points, weights;
};
void decode_control_find(const struct json_value *owner, struct decode_control *control);

/* geomdl's `trims`: {"count", "data": [...]}, or the list alone. */
bool decode_trims(const struct json_value *json, struct api_surface *surface);

/* {"faces": [S...], "tolerance": t}, with what an importer notes beside it. */
bool decode_shell(const struct json_value *json, struct api_surface *surface);

/* Several surfaces of a list as the faces of a shell. */
bool decode_faces(const struct json_value *list, struct api_surface *surface);

/* `id` with a selection of the faces of the stored shell. */
bool decode_selection(const struct json_value *json, struct api_surface *surface);

/* One NURBS surface with its trims, alone or as a face. */
bool decode_nurbs(const struct json_value *json, bool of_shell, struct api_surface *surface);

/* `length_unit` and `notes` beside a shell or a mesh, as an importer writes them. */
bool decode_origin(const struct json_value *json, struct api_surface *surface);

bool decode_permeability(const struct json_value *json, struct api_permeability *permeability);

/* `fabric`, with the figures of the material that it names or has; the unit of lengths is known. */
void decode_fabric(const struct json_value *json, struct api_request *request);

/* A steered generator: {"points", "values", "length"} or the values alone; without values it is to
 * be sought. */
enum { DECODE_STEERED_POINTS = 4 };
void decode_steered(const struct json_value *json, struct drape_generator *generator);

/* A generator's nodes, {"places", "start"}: rows of face, u, v and the direction there, and which
 * of them is the start. */
void decode_places(const struct json_value *json, struct drape_generator *generator);

/* What cloth costs: `shear_curve` and `bending` of a fabric; and {"norm", "min_radius"}. */
void decode_shear_energy(const struct json_value *fabric, struct drape_energy *energy);
void decode_energy(const struct json_value *json, struct drape_energy *energy);

/* Whether steered generator k suits all else, once that is known. */
void decode_check_steered(const struct json_value *generator, const struct drape_settings *settings,
                          int k, bool on_mesh);

/* The figures of a fabric, of a request or of a material: lengths are in `metres`, and become the
 * request's. */
void decode_figures(const struct json_value *json, double metres, struct api_request *request);

/* The document of a material: what it says of the fabric and the permeability. */
void decode_material(const struct json_value *json, struct api_request *request);

/* The material of the library whose name has these characters; NULL when there is none. */
const struct api_material *material_find(const char *name, size_t length);

/* Names are parts of paths, and stand in requests without escapes. */
bool material_is_name(const char *text, size_t length);

/* The same document written down again, in one line; what lacks a name or anything else has none.
 * False after a fault. */
bool material_read(const struct json_value *json, struct api_material *material);

/* How many elements an array has, between `least` and `most` of what it is called in the plural.
 * False after a fault. */
bool decode_count(const struct json_value *json, size_t least, int most, const char *what,
                  size_t *count);

/* The points of a cut or a split, at least two, none the same as the one before. */
void decode_cut_path(const struct json_value *json, struct drape_cut_line *cut);

/* {"a", "b"} */
void decode_compaction(const struct json_value *json, struct api_compaction *law);

/* The definition itself: `surface`, or the surface in the file that geomdl's export_json writes.
 * `file` has the way to it: not to be copied. */
struct decode_definition {
    struct json_value shape, data, first;
};
const struct json_value *decode_definition_find(const struct json_value *surface,
                                                struct decode_definition *file);

#endif
