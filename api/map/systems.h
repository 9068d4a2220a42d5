/* SPDX-License-Identifier: MIT */
/*
 * The coordinate systems that a Nastran file defines: rectangular (R), cylindrical (C: r, theta, z)
 * and spherical (S: r, theta from the z axis, phi about it), angles in degrees, each by three
 * points: A, its origin; B, on its z axis; C, in its half plane of zero azimuth. They refer to
 * other systems (CORD2x), or to grids (CORD1x), which may lie in other systems themselves. They are
 * worked out as they are needed; those that nothing needs may be wrong.
 */
#ifndef API_MAP_SYSTEMS_H
#define API_MAP_SYSTEMS_H

#include "bulk_data.h"
#include "ids.h"
#include "solver/vec.h"

enum system_kind { SYSTEM_RECTANGULAR, SYSTEM_CYLINDRICAL, SYSTEM_SPHERICAL };
enum system_state { SYSTEM_UNUSED, SYSTEM_BUSY, SYSTEM_READY };

/* As the card has it. */
struct system {
    int32_t id;
    uint32_t line;
    char name[BULK_NAME_SIZE]; /* of its card */
    bool by_grids;
    int32_t grid[3];      /* ids, of CORD1x */
    int32_t reference;    /* of CORD2x: the system of its points, 0 for the basic one */
    struct vec3 point[3]; /* of CORD2x */
    enum system_kind kind;
    enum system_state state;
    struct vec3 origin, x, y, z; /* once it is ready, in basic coordinates; orthonormal axes */
};

struct grids {
    size_t count;
    struct vec3 *point; /* in its system; in the basic one once `system` is 0 */
    int32_t *id;
    int32_t *system; /* ids, 0 for the basic one */
    uint32_t *line;
    const struct map_id *by_id; /* sorted */
};

struct systems {
    size_t count;
    struct system *system;
    const struct map_id *by_id; /* sorted */
};

/* The systems of a card that defines some, CORD1x by three grids and CORD2x by three points: one,
 * or two of a long CORD1x. How many; 0: it is another card; -1 with the problem set. */
int systems_read(const struct bulk_card *card, struct system found[2],
                 struct api_problem *problem) STATUS_MUST_USE;

/* Puts every grid into basic coordinates. False with the problem set: a system that is not there,
 * that hangs on itself, or whose points lie on a line. */
bool systems_apply(struct systems *systems, struct grids *grids,
                   struct api_problem *problem) STATUS_MUST_USE;

#endif
