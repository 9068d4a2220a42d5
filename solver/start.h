/* SPDX-License-Identifier: MIT */
/* Where the net starts, and the directions of its two generators there. */
#ifndef DRAPE_START_H
#define DRAPE_START_H

#include "march.h"

/* Finds the start that the settings ask for. Warp by angle is r_u turned about the normal, at a
 * pole where r_u vanishes r_v takes its place; by vector its projection on the tangent plane. Weft
 * is 90 degrees less the pre-shear further. Errors: STATUS_START_OFF_SURFACE (parameters outside
 * the domain, or a point further from the surface than a spacing), STATUS_DEGENERATE_SURFACE (no
 * tangent plane there), STATUS_INVALID (a direction along the normal). */
enum status start_find(const struct surface *surface, const struct drape_settings *settings,
                       struct march_start *start) STATUS_MUST_USE;

#endif
