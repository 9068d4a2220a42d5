/* SPDX-License-Identifier: MIT */
#include "zero.h"

#include <stdbool.h>

/* A direction whose projection is shorter than this share of it lies along the normal. */
static const double along_normal = 1e-9;

/* A place whose normal has a larger x lies across the x axis. */
static const double across_x = 0.9;

struct vec3 zero_across(struct vec3 vector, struct vec3 normal) {
    struct vec3 part = vec3_axpy(-vec3_dot(vector, normal), normal, vector);
    bool along = !(vec3_norm(vec3_cross(normal, vec3_unit(vector))) > along_normal);
    return along ? vec3_make(0, 0, 0) : vec3_unit(part);
}

int drape_zero_direction(const struct drape_zero *zero, struct vec3 normal, struct vec3 tangent,
                         struct vec3 *direction) {
    bool rosette = zero->kind == DRAPE_ZERO_ROSETTE;
    struct vec3 axis = fabs(normal.x) < across_x ? vec3_make(1, 0, 0) : vec3_make(0, 1, 0);
    if (rosette)
        axis = zero->x;
    else if (zero->kind == DRAPE_ZERO_TANGENT && vec3_norm2(tangent) > 0)
        axis = tangent;
    *direction = zero_across(axis, normal);
    return rosette && vec3_dot(vec3_unit(zero->z), normal) < -along_normal ? -1 : 1;
}
