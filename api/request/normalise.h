/* SPDX-License-Identifier: MIT */
/*
 * A request as it was understood, written down again: fixed key order, shortest numbers, every
 * default filled in. Decoding it gives the same request, so it is also what gets digested.
 * The strings are zero-terminated and lie in the arena; NULL without memory.
 */
#ifndef API_REQUEST_NORMALISE_H
#define API_REQUEST_NORMALISE_H

#include "api/json/text.h"
#include "request.h"
#include "solver/arena.h"

/* A rosette as a system of axes, of any lengths; x zero: there is none. Where the request gives no
 * z it is the normal that angles turn about at the start. */
struct api_rosette {
    struct vec3 origin, x, z;
};

/* What a solve chose to start from. */
struct api_start {
    int face;     /* on a shell: its number; else -1 */
    double uv[2]; /* parameters of that face */
    struct vec3 point;
    struct vec3 warp, weft; /* unit directions there */
    struct vec3 zero;       /* likewise: of 0 degrees of the rosette; zero without one */
    struct api_rosette rosette;
    int unit; /* of the drape's lengths, by its place in `api_units` */
};

/* The request. A surface that was given by id stays {"id": ...}. `chosen` (may be NULL) is written
 * as the start of a request that left the start to the solver. */
const char *api_normalise(const struct api_request *request, const struct api_start *chosen,
                          struct arena *arena);

/* Members of it, for documents that have them elsewhere: the surface and the unit (NULL: none);
 * the rosette, if there is one; fabric to extent; the permeability; the
 * locking angles and the limit curve, where there are any; how the fabric gives way,
 * unless as a weave; the law of compaction, if there
 * is one; and loops as `trims`. */
void api_normalise_ground(struct api_text *text, const struct api_surface *surface,
                          const struct api_unit *unit);
void api_normalise_rosette(struct api_text *text, const struct api_request *request);
void api_normalise_cloth(struct api_text *text, const struct api_request *request,
                         const struct api_start *chosen);
void api_normalise_permeability(struct api_text *text, const struct api_permeability *k);
void api_normalise_shear_limits(struct api_text *text, const struct api_fabric *fabric);
void api_normalise_kinematics(struct api_text *text, double slide);
void api_normalise_yarns(struct api_text *text, const struct api_fabric *fabric);
void api_normalise_compaction(struct api_text *text, const struct api_compaction *law);
void api_normalise_trims(struct api_text *text, const struct trim_loop *trims, size_t count);

/* The notes of an imported surface, with one more unless that is "". */
void api_normalise_notes(struct api_text *text, const struct api_surface *surface,
                         const char *more);

/* The definition of a surface (not API_SURFACE_NAMED). */
const char *api_normalise_surface(const struct api_surface *surface, struct arena *arena);

/* A steered generator as it can be posted, with its values or to be sought. */
void api_normalise_steered(struct api_text *text, const struct drape_curvature *curvature,
                           bool values);

#endif
