/* SPDX-License-Identifier: MIT */
/*
 * The plies on a mesh as they are laid: element by element, and on each ply by ply. The angle of a
 * ply is measured here (`api/format/element_frame.h`), whatever it is that knows the yarns.
 */
#ifndef API_MAP_PLIES_H
#define API_MAP_PLIES_H

#include "api/format/element_frame.h"
#include "api/problem.h"
#include "solver/arena.h"
#include "target.h"

enum { MAP_PLY_COLUMNS = 7 };

/* Not to be moved once it has columns. */
struct map_stack {
    struct map_plies plies;
    size_t flat; /* elements that have no direction, and so no rows */
    /* for its own functions */
    const struct map_target *target;
    struct map_ply_row *rows;
    size_t *first;
    size_t room, element;
    struct element_frame frame;
    bool sound;
    struct map_ply_column {
        const struct map_stack *stack;
        int of;
    } column[MAP_PLY_COLUMNS];
};

/* What is known of a ply at an element. */
struct map_ply {
    struct vec3 warp, weft; /* unit */
    double shear_deg;
    double thickness, fiber_volume_fraction; /* 0: not known */
};

/* What the cloth of a request is made of: unidirectional where its fibres stay parallel, otherwise
 * half warp and half weft unless it says so. */
struct map_ply_kind map_ply_kind_of(const struct api_request *cloth);

/* An empty stack of `plies->ply_count` plies with their `names` and what they know, with room for
 * `room` rows in `arena`; false without memory. `target` has elements; both outlive the stack. */
bool map_stack_begin(struct map_stack *stack, const struct map_target *target,
                     const struct map_plies *plies, size_t room, struct arena *arena);

/* Goes on to the next element, from 0 on. API_INVALID_REQUEST when the caller's direction is normal
 * to it. */
enum api_problem_id map_stack_next(struct map_stack *stack, size_t element,
                                   struct api_problem *problem) STATUS_MUST_USE;

/* Lays a ply on that element, in the order of plies; on one without a direction does nothing. */
void map_stack_lay(struct map_stack *stack, int ply, const struct map_ply *laid);

/* After the last element: `plies` is complete. Writes its columns, of the table plies, and returns
 * how many. */
size_t map_stack_end(struct map_stack *stack, struct api_column_source columns[MAP_PLY_COLUMNS]);

/* Elements without any ply. */
size_t map_stack_bare(const struct map_stack *stack);

#endif
