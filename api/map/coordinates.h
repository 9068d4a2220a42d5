/* SPDX-License-Identifier: MIT */
/*
 * The coordinate systems of Nastran bulk data: rectangular (R), cylindrical (C: r, theta, z) and
 * spherical (S: r, theta from the z axis, phi about it), angles in degrees, each defined by three
 * points: A, its origin; B, on its z axis; C, in its half plane of zero azimuth. CORD2R, CORD2C and
 * CORD2S give the points in another system, CORD1R, CORD1C and CORD1S name three GRIDs.
 */
#ifndef API_MAP_COORDINATES_H
#define API_MAP_COORDINATES_H

#include "solver/status.h"
#include "solver/vec.h"
#include <stdbool.h>

enum coordinates_kind { COORDINATES_RECTANGULAR, COORDINATES_CYLINDRICAL, COORDINATES_SPHERICAL };

/* In basic coordinates; the axes are orthonormal and right-handed. */
struct coordinates {
    enum coordinates_kind kind;
    struct vec3 origin, x, y, z;
};

/* The system of the points, given in basic coordinates. False when they lie on a line, to 1e-9 of
 * their distances. */
bool coordinates_make(enum coordinates_kind kind, const struct vec3 points[3],
                      struct coordinates *system) STATUS_MUST_USE;

/* The basic coordinates of a point whose coordinates in the system are `p`. */
struct vec3 coordinates_basic(const struct coordinates *system, struct vec3 p);

#endif
