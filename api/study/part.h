/* SPDX-License-Identifier: MIT */
/* The part of a study, ready to be draped many times. */
#ifndef API_STUDY_PART_H
#define API_STUDY_PART_H

#include "api/request/prepared_part.h"
#include "request.h"
#include "solver/mesh/even_points.h"
#include "solver/mesh/mesh.h"

struct study_part {
    struct drape_part geometry;
    struct prepared_shell shell; /* with the numbers of its faces, if it is one */
    double area;                 /* of the component that is draped */
    int32_t component;
    const struct drape_zero *zero; /* what angles are counted from */
};

/* Makes it in `arena`, and the settings of the study's drape what the solver takes. Problems as of
 * a drape, their pointers below `/drape`. */
enum api_problem_id study_part_make(struct study_request *request, const struct api_limits *limits,
                                    struct arena *arena, struct study_part *part,
                                    struct api_problem *problem) STATUS_MUST_USE;

/* The point of a face, of a surface or shell, at its parameters. */
struct part_point study_part_at(const struct study_part *part, int32_t face, const double uv[2]);

/* The point of the part that is nearest to a point, and how far that is. */
void study_part_nearest(const struct study_part *part, struct vec3 point,
                        struct part_point *nearest, double *distance);

/* The point of the part next to `from` moved by `shift` in space; where that is trimmed away, as
 * far towards it as the part goes. */
struct part_point study_part_shift(const struct study_part *part, const struct part_point *from,
                                   struct vec3 shift);

/* About the same, quickly: a point moved by `shift` along the direction that angles are measured
 * from and across it, no further than the surface's domain; on a mesh, and beyond the face of a
 * shell, to the nearest point. False where a surface is trimmed away, or where there is no tangent
 * plane. */
bool study_part_nudge(const struct study_part *part, const struct part_point *from,
                      const double shift[2], struct part_point *to);

/* The unit direction from which angles of the warp are measured there, and the unit normal about
 * which. False at poles, where the surface has no tangent plane, and where a rosette has no
 * direction. */
bool study_part_axes(const struct study_part *part, const struct part_point *at,
                     struct vec3 *normal, struct vec3 *along);

#endif
