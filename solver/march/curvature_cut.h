/* SPDX-License-Identifier: MIT */
/*
 * The lines along which shells are cut open. That of a tube: the line of curvature, from end to
 * end, through the place opposite the start. Half way round the section of the tube by the plane
 * that is normal to its line of curvature through the start is opposite. It follows from the
 * surface alone, and goes on along bends: of a torus it is a parallel circle, of what is turned a
 * meridian.
 */
#ifndef SOLVER_MARCH_CURVATURE_CUT_H
#define SOLVER_MARCH_CURVATURE_CUT_H

#include "march.h"

struct curvature_cut {
    struct shell_slit_piece *pieces; /* from border to border; `count` 0: there is none */
    size_t count;
    struct vec3 opposite; /* the place opposite the start */
    double girth;         /* the length of that section */
};

/* The line, in an arena, with places `step` apart, a small share of the girth. There is none where
 * sections are not closed, where the surface is flat or as round as a sphere, over folds, and where
 * the line does not come from border to border within the length `most`. Errors:
 * STATUS_OUT_OF_MEMORY. */
enum status curvature_cut_make(const struct surface_point *start, double step, double most,
                               struct arena *arena, struct curvature_cut *cut) STATUS_MUST_USE;

/* The lines of curvature along which a shell that closes both ways is cut open, in an arena: each
 * through the place half way round the line of the other family through the start, and back to
 * there. Only their pieces are set, `count` 0 for both where a line does not come back within the
 * length `most`. Errors as above. */
enum status curvature_cut_rings(const struct surface_point *start, double step, double most,
                                struct arena *arena, struct curvature_cut cut[2]) STATUS_MUST_USE;

#endif
