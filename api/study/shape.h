/* SPDX-License-Identifier: MIT */
/* The part of a study, ready to be draped many times. */
#ifndef API_STUDY_SHAPE_H
#define API_STUDY_SHAPE_H

#include "api/request/prepared_surface.h"
#include "request.h"
#include "solver/mesh/mesh.h"
#include "solver/mesh/spread.h"

struct study_shape {
    struct drape_part part;
    struct prepared_shell shell; /* with the numbers of its faces, if it is one */
    double area;                 /* of the component that is draped */
    int32_t component;
};

/* Makes it in `arena`, and the settings of the study's drape what the solver takes. Problems as of
 * a drape, their pointers below `/drape`. */
enum api_problem_id study_shape_make(struct study_request *request, const struct api_limits *limits,
                                     struct arena *arena, struct study_shape *shape,
                                     struct api_problem *problem) STATUS_MUST_USE;

/* The place of a face, of a surface or shell, at its parameters. */
struct spread_place study_shape_at(const struct study_shape *shape, int32_t face,
                                   const double uv[2]);

/* The place of the part that is nearest to a point, and how far that is. */
void study_shape_nearest(const struct study_shape *shape, struct vec3 point,
                         struct spread_place *place, double *distance);

/* The place of the part next to `from` moved by `shift` in space; where that is trimmed away, as
 * far towards it as the part goes. */
struct spread_place study_shape_shift(const struct study_shape *shape,
                                      const struct spread_place *from, struct vec3 shift);

/* About the same, quickly: a place moved by `shift` along the direction that angles are measured
 * from and across it, no further than the surface's domain; on a mesh, and beyond the face of a
 * shell, to the nearest place. False where a surface is trimmed away, or where there is no tangent
 * plane. */
bool study_shape_nudge(const struct study_shape *shape, const struct spread_place *from,
                       const double shift[2], struct spread_place *to);

/* The unit normal there, and the unit direction from which angles of the warp are measured. False
 * at poles and where the surface has no tangent plane. */
bool study_shape_axes(const struct study_shape *shape, const struct spread_place *place,
                      struct vec3 *normal, struct vec3 *along);

#endif
