/* SPDX-License-Identifier: MIT */
/* What the angle of the warp is counted from at the start, and which way. */
#ifndef SOLVER_ZERO_H
#define SOLVER_ZERO_H

#include "vec.h"

enum drape_zero_kind {
    DRAPE_ZERO_TANGENT, /* the u-tangent, at a pole where it vanishes the v-tangent; as
                           DRAPE_ZERO_AXES where there are no parameters */
    DRAPE_ZERO_AXES,    /* the x axis or, where the normal n has |n_x| >= 0.9, the y axis: the same
                           on whichever face the start is */
    DRAPE_ZERO_ROSETTE  /* `x`, of any length but zero */
};

/* A rosette turns about that of the two normals to whose side z points; about r_u x r_v where z
 * lies in the tangent plane or is zero. */
struct drape_zero {
    enum drape_zero_kind kind;
    struct vec3 x, z; /* of a rosette, any lengths */
};

/*
 * The unit direction that angles are counted from in the plane across the unit `normal` (of several
 * faces, on the side of the first): what the kind says, projected on that; zero where it lies along
 * the normal. `tangent` is of DRAPE_ZERO_TANGENT, zero on triangles. The answer is 1 where the
 * angles turn about this normal and -1 where about its opposite.
 */
int drape_zero_direction(const struct drape_zero *zero, struct vec3 normal, struct vec3 tangent,
                         struct vec3 *direction);

/* The unit direction of a vector's part across the unit normal; zero where it has none. */
struct vec3 zero_across(struct vec3 vector, struct vec3 normal);

#endif
