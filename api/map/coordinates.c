/* SPDX-License-Identifier: MIT */
#include "coordinates.h"

#include <math.h>

static const double degree = 3.14159265358979323846 / 180, least_sine = 1e-9;

/* z = AB / |AB|, y = z x AC / |z x AC|, x = y x z. */
bool coordinates_make(enum coordinates_kind kind, const struct vec3 points[3],
                      struct coordinates *system) {
    struct vec3 b = vec3_sub(points[1], points[0]), c = vec3_sub(points[2], points[0]);
    struct vec3 normal = vec3_cross(b, c);
    if (!(vec3_norm(normal) > least_sine * vec3_norm(b) * vec3_norm(c)))
        return false;
    system->kind = kind;
    system->origin = points[0];
    system->z = vec3_unit(b);
    system->y = vec3_unit(normal);
    system->x = vec3_cross(system->y, system->z);
    return true;
}

struct vec3 coordinates_basic(const struct coordinates *system, struct vec3 p) {
    double theta = p.y * degree, phi = p.z * degree;
    if (system->kind == COORDINATES_CYLINDRICAL)
        p = vec3_make(p.x * cos(theta), p.x * sin(theta), p.z);
    else if (system->kind == COORDINATES_SPHERICAL)
        p = vec3_make(p.x * sin(theta) * cos(phi), p.x * sin(theta) * sin(phi), p.x * cos(theta));
    struct vec3 at = vec3_axpy(p.x, system->x, system->origin);
    return vec3_axpy(p.z, system->z, vec3_axpy(p.y, system->y, at));
}
