/* SPDX-License-Identifier: MIT */
/* The triangles of a mesh file while it is read: corners by their places or by vertex. */
#ifndef API_FILES_TRIANGLES_H
#define API_FILES_TRIANGLES_H

#include "api/map/target.h"
#include "api/problem.h"
#include "solver/arena.h"
#include "solver/vec.h"
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct triangles {
    struct arena *arena;
    struct api_problem *problem;
    struct vec3 *vertices;
    size_t vertex_count, vertex_room;
    int32_t (*corners)[3];
    size_t count, room;
    size_t without_area, duplicate; /* left out by `triangles_weld` */
};

/* Add one; false with the problem set: API_OUT_OF_MEMORY, API_UNREADABLE_FILE. */
bool triangles_add_vertex(struct triangles *triangles, struct vec3 vertex);
bool triangles_add(struct triangles *triangles, const int32_t corners[3]);

/* Makes corners within 1e-7 of the box's diagonal one vertex, in order; leaves out triangles
 * without area and second ones on the same corners. */
bool triangles_weld(struct triangles *triangles);

/* The readers. False with the problem set. */
bool triangles_read_stl(struct triangles *triangles, const char *bytes, size_t length);
bool triangles_read_obj(struct triangles *triangles, const char *bytes, size_t length);
bool triangles_read_shells(struct triangles *triangles, map_target_reader *read, const char *bytes,
                           size_t length);

#endif
