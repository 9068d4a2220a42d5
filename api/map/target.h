/* SPDX-License-Identifier: MIT */
/*
 * Where a caller wants the fields of a drape: points, or the middles of a mesh's elements, read
 * from the body of a map request. Its arrays lie in the arena it was read with. Both readers go
 * through the text without a tree of it, so that a mesh of a million elements takes little more
 * memory than its numbers.
 *
 * Coordinates are in the length unit of the drape and lie within +-1e12.
 */
#ifndef API_MAP_TARGET_H
#define API_MAP_TARGET_H

#include "api/format/element_frame.h"
#include "api/problem.h"
#include "solver/arena.h"
#include "solver/status.h"
#include "solver/vec.h"
#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

struct api_request;

/* The largest coordinate, and height of a cavity. */
static const double MAP_COORDINATE_MAX = 1e12;

/* Refuses the request as it stands, with a printf-style detail; false. */
#define MAP_REFUSE(problem, ...) (api_problem_set(problem, API_INVALID_REQUEST, __VA_ARGS__), false)

/* For what is kept of a mesh; false. */
static inline bool map_target_no_memory(struct api_problem *problem) {
    api_problem_set(problem, API_OUT_OF_MEMORY, "the mesh needs more memory than allowed");
    return false;
}

/* The elements of ids first, first + step, ... last are in a set. */
struct map_range {
    int32_t set, first, last, step; /* set: its number in the list, from 1 */
};

struct map_target {
    const struct vec3 *vertices;
    size_t vertex_count;
    const int32_t (*elements)[4]; /* vertices from 0; the fourth of a triangle is -1; NULL: the
                                     vertices themselves are the points */
    size_t element_count;         /* 1..INT32_MAX; without elements that of the points */
    const int32_t *ids;           /* of each element, as the file has them; NULL: from 0 */
    const int32_t *vertex_ids;    /* of each vertex, likewise */
    const int32_t *pids;          /* of each element, its property; NULL: there are none */
    const struct map_set *sets;   /* of elements, that have names in the file */
    size_t set_count;
    const struct map_range *ranges; /* what is in them, beside the elements of their property */
    size_t range_count;
    const char *warning;      /* what the reader passed over; NULL: nothing */
    uint8_t *roles;           /* of each element, enum map_role; NULL: there are none */
    bool has_role[MAP_ROLES]; /* which of them have been given */
    struct vec3 reference;    /* the direction that angles of plies run from, not zero, ... */
    bool has_reference;       /* ... or each element's first edge */
    const double *heights; /* of the cavity at each element, > 0; 0 or NULL: that of what is mapped
                            */
    const struct api_request *cloth; /* of a drape in a rigid cavity, by heights or a punch: what
                                        is pressed (`cavity.h`); else NULL */
    const int32_t (*punch)[4]; /* elements that are not mapped: the other side of the cavity, ... */
    const struct vec3 *punch_vertices; /* ... and their vertices */
    size_t punch_count;                /* 0: there is none */
    double channel_width;              /* with a channel: what is so near to the rim is it */
    bool wants_outlines;               /* and their edges, of a laminate */
    bool wants_yarns;                  /* the plies' kinds are asked for; of a drape it is */
    const struct map_ply_kind *yarns;  /* what its ply is of; NULL: not known */
    double channel_permeability;       /* and has this, m^2, in all directions */
};

/*
 * Reads {"points": [[x, y, z]...]} or {"mesh": {"vertices": [[x, y, z]...], "triangles":
 * [[a, b, c]...], "quads": [[a, b, c, d]...], "ids": [number...], "vertex_ids": [number...]}}:
 * triangles or quads or both, which are then the elements in this order; the numbers of elements
 * and vertices are positive and all different, and may be left out. With a mesh also
 * "inlet_elements": [index...]; with either "cavity_heights": [number...], positive or 0 for none,
 * of each element or point, or "punch": {"vertices", "triangles", "quads"}. Returns API_OK,
 * API_MALFORMED_JSON with line and column, API_INVALID_REQUEST with the place, or
 * API_OUT_OF_MEMORY; the first error is the only one.
 */
enum api_problem_id map_target_json(const char *bytes, size_t length, struct arena *arena,
                                    struct map_target *target,
                                    struct api_problem *problem) STATUS_MUST_USE;

/*
 * Reads Nastran bulk data as pre-processors write it: GRID, in the basic coordinate system or in
 * one that a CORD1x or CORD2x card defines, GRDSET, and the shell elements CTRIA3, CTRIAR, CTRIA6,
 * CQUAD4, CQUADR, CQUAD8, CQUAD9 and CQUAD by their corners; in small, large (NAME*) and free
 * fields, with comments ($) and continuations, in any order and case, with or without what stands
 * before BEGIN BULK. All other cards (bars, rigid elements, solids, constraints, loads, properties,
 * materials, systems that nothing is in) are passed over, and counted by name in the target's
 * warning. Refused with their line: an id that is there twice, an element whose GRID or a GRID
 * whose system is missing, systems that are none, a coordinate beyond the end of its line, INCLUDE.
 * Returns API_OK, API_INVALID_REQUEST with the line in the detail, or API_OUT_OF_MEMORY.
 */
enum api_problem_id map_target_nastran(const char *bytes, size_t length, struct arena *arena,
                                       struct map_target *target,
                                       struct api_problem *problem) STATUS_MUST_USE;

/* Read likewise the meshes of other programs, with their own ids; the first set of elements, or
 * physical group, that an element is in is its property, and the warning has the names: input decks
 * of Abaqus and CalculiX (.inp), keyword decks of LS-DYNA (.k), meshes of Gmsh (.msh, 2.2 and 4.1
 * as text), universal files (.unv); and grids of VTK (.vtu), whose ids and properties are arrays of
 * cells named id and pid, if there are such. */
typedef enum api_problem_id map_target_reader(const char *bytes, size_t length, struct arena *arena,
                                              struct map_target *target,
                                              struct api_problem *problem);
map_target_reader map_target_abaqus, map_target_lsdyna, map_target_gmsh, map_target_universal,
    map_target_vtu;

/*
 * Sets what a query parameter or command-line flag `name` says of the target: inlet (also as
 * inlet_elements) and outlet, each a list "17,18,pid:3,set:NAME" of elements by the file's ids,
 * else by index, of properties, of sets by their names in any case, and of all elements whose
 * middle lies in a ball, "sphere:x:y:z:radius", or so near to a straight line,
 * "line:x:y:z:x:y:z:distance", in the length unit of the drape; edge_channel, "width,permeability"
 * in that unit and m^2; reference, "x,y,z"; cavity_height and punch (`cavity.h`). False with
 * `problem` set: API_INVALID_REQUEST (it names no such elements, points, no direction, or it is
 * given twice) or API_OUT_OF_MEMORY; false with `problem` unset when there is no option of that
 * name.
 */
bool map_target_option(struct map_target *target, const char *name, const char *value,
                       struct arena *arena, struct api_problem *problem);

/* Where the fields of an element are wanted: the mean of its corners; or the point itself. */
static inline struct vec3 map_target_point(const struct map_target *target, size_t element) {
    return target->elements ? element_middle(target->vertices, target->elements[element])
                            : target->vertices[element];
}

#endif
