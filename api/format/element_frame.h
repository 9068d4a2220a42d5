/* SPDX-License-Identifier: MIT */
/*
 * An element's own directions, and the angles of yarns in them: the one place where an angle gets
 * its sign. docs/figures/angles.svg shows it.
 *
 * - The normal n follows the order of the corners: of a triangle 12 x 13, of a quadrilateral, which
 *   need not be plane, the product of its diagonals 13 x 24.
 * - The reference direction is the first edge, from corner 1 to 2, or a direction of the caller's,
 *   projected on the plane normal to n.
 * - A yarn is projected likewise. Its angle runs from the reference direction, positive about n:
 *   counted counter-clockwise by who sees n point at them.
 * - The weft is 90 degrees less the shear from the warp, to the left about the cloth's own normal
 *   warp x weft. Where the element's looks to the other side, that is to the right: `mirrored`.
 */
#ifndef API_FORMAT_ELEMENT_FRAME_H
#define API_FORMAT_ELEMENT_FRAME_H

#include "format.h"

struct element_frame {
    struct vec3 reference, across, normal; /* unit, right-handed: across = normal x reference */
    double edge_deg; /* the angle of the reference direction from the first edge, about the normal;
                        0 without one of the caller's */
};

enum element_fault {
    ELEMENT_SOUND,
    ELEMENT_FLAT,         /* it has no area, or its first two corners coincide */
    ELEMENT_PERPENDICULAR /* the caller's direction is normal to it */
};

/* How many corners an element has: 3 or 4. */
static inline int element_corner_count(const int32_t corners[4]) {
    return corners[3] < 0 ? 3 : 4;
}

/* The frame of an element of a mesh, its corners as `map_fields.elements` has them. `reference`:
 * the caller's direction, of any length but zero; NULL: the first edge. */
enum element_fault element_frame_make(const struct vec3 *vertices, const int32_t corners[4],
                                      const struct vec3 *reference, struct element_frame *frame);

/* The middle of an element's corners. */
struct vec3 element_middle(const struct vec3 *vertices, const int32_t corners[4]);

/* The angle of a direction from the reference direction in degrees, -180..180. */
double element_angle_deg(const struct element_frame *frame, struct vec3 direction);

/* The unit direction of an angle: the inverse. */
struct vec3 element_direction(const struct element_frame *frame, double angle_deg);

/* Sets `angle_deg` and `mirrored` of a ply whose yarns have these directions at the element. */
void element_lay(const struct element_frame *frame, struct vec3 warp, struct vec3 weft,
                 struct map_ply_row *row);

/* A fibre's angle between -90 (excluded) and 90: where it points to and from is the same. */
double element_fold_deg(double angle_deg);

/* The angle of the row's weft from the reference direction in degrees, -270..270. */
double element_weft_deg(const struct map_ply_row *row);

/* An edge of an element or cell, its `number`-th, between vertices a < b; and the order by these,
 * for qsort. */
struct element_edge {
    int32_t a, b, element, number;
};
int element_edge_compare(const void *x, const void *y);

#endif
