/* SPDX-License-Identifier: MIT */
/* Where the net starts, and the directions of its two generators there. */
#ifndef SOLVER_MARCH_START_H
#define SOLVER_MARCH_START_H

#include "march.h"

/* Finds the start that the settings ask for, in the region `trim` (NULL: all), or at a place that
 * is known by its inner parameters unless they are NULL. Warp by angle is the direction of
 * `drape_zero_direction` turned about the normal; by vector its projection on the tangent plane.
 * Weft is 90 degrees less the pre-shear further. Generators that are curves or planes have the
 * direction they have. Errors: STATUS_START_OFF_SURFACE (parameters outside the domain, or a point
 * further from the surface than a spacing), STATUS_DEGENERATE_SURFACE (no tangent plane there),
 * STATUS_INVALID (a direction along the normal, or a rosette whose x lies there),
 * STATUS_GENERATOR_OFF_START and STATUS_GENERATOR_PARALLEL, for which `faulty` says which.
 */
enum status start_find(const struct surface *surface, const struct trim *trim,
                       const struct drape_settings *settings, const double inner[2],
                       struct march_start *start, int *faulty) STATUS_MUST_USE;

/* The place nearest to `target` among those of a grid of the domain that are in the region (NULL:
 * all of it), first in the middle half of each direction, in inner parameters, and its distance;
 * HUGE_VAL, and `inner` untouched, when there is none. For defaults that lie on the edge, where
 * every yarn leaves. */
double start_inside(const struct surface *surface, const struct trim *trim, struct vec3 target,
                    double inner[2]);

/* As `start_find` on the march's mesh, for its start: the default is the centroid of its largest
 * component, parameters are STATUS_INVALID. There is no u-tangent. Generators may be
 * planes, but not curves. */
enum status start_find_on_mesh(struct march *march, int *faulty) STATUS_MUST_USE;

/* Moves the march's start on a surface to the mesh made of it. */
enum status start_move_to_mesh(struct march *march) STATUS_MUST_USE;

#endif
