/* SPDX-License-Identifier: MIT */
#include "api/json/place.h"
#include "api/request/parts.h"
#include "laminate.h"
#include <stdio.h>
#include <string.h>

static const struct place_range pressures = {1e-3, 1e12, false}; /* Pa */
enum { POLYGON_MAX = 100000 };

int laminate_layers(const struct laminate_ply *ply) {
    return ply->repeat * ply->drape.fabric.plies;
}

/* ---- one ply ---- */

/* Names go into the cards of solvers: printable ASCII. */
static void decode_name(const struct json_place *place, size_t number, struct laminate_ply *ply) {
    char *name = json_tree_alloc(place->tree, LAMINATE_NAME_MAX + 1, 1);
    const char *given;
    ply->name = name;
    if (!name)
        return;
    (void)snprintf(name, LAMINATE_NAME_MAX + 1, "ply_%zu", number + 1);
    if (!place_given(place) || !place_string(place, &given))
        return;
    size_t length = strlen(given);
    bool good = length >= 1 && length <= LAMINATE_NAME_MAX;
    for (size_t k = 0; k < length; k++)
        good = good && given[k] >= ' ' && given[k] <= '~';
    if (good)
        memcpy(name, given, length + 1);
    else
        place_fault(place, "must have 1 to %d printable ASCII characters", LAMINATE_NAME_MAX);
}

static void decode_polygon(const struct json_place *place, struct laminate_loop *loop) {
    double *rows;
    if (!place_rows(place, decode_coordinates, 3, 3, &rows, &loop->count))
        return;
    loop->points = (const void *)rows;
    if (loop->count > POLYGON_MAX)
        place_fault(place, "has %zu points, and %d are allowed", loop->count, POLYGON_MAX);
}

static void decode_polygons(const struct json_place *list, struct laminate_boundary *boundary) {
    if (!place_array(list, 1))
        return;
    boundary->count = place_length(list);
    struct laminate_loop *loops = json_tree_alloc(list->tree, boundary->count, sizeof *loops);
    boundary->loops = loops;
    for (size_t k = 0; loops && k < boundary->count; k++) {
        struct json_place polygon = place_element(list, k);
        decode_polygon(&polygon, &loops[k]);
    }
}

static void decode_loops(const struct json_place *place, const struct api_surface *surface,
                         struct laminate_boundary *boundary) {
    struct api_surface loops = {.kind = API_SURFACE_NURBS};
    if (surface->kind != API_SURFACE_NURBS && surface->kind != API_SURFACE_NAMED)
        place_fault(place, "are in the parameters of one NURBS surface, and this is not one: give "
                           "a polygon");
    if (decode_trims(place, &loops) && loops.trim_count == 0)
        place_fault(place, "must have at least one loop");
    boundary->trims = loops.trims;
    boundary->trim_count = loops.trim_count;
}

static void decode_boundary(const struct json_place *place, const struct api_surface *surface,
                            struct laminate_boundary *boundary) {
    static const char *const keys[] = {"polygon", "polygons", "trims", NULL};
    struct json_place polygon = place_member(place, keys[0]);
    struct json_place polygons = place_member(place, keys[1]);
    struct json_place trims = place_member(place, keys[2]);
    if (!place_object(place, keys))
        return;
    if (place_given(&polygon) + place_given(&polygons) + place_given(&trims) != 1) {
        place_fault(place, "must have either \"polygon\", \"polygons\" or \"trims\"");
    } else if (place_given(&polygon)) {
        struct laminate_loop *loop = json_tree_alloc(place->tree, 1, sizeof *loop);
        boundary->loops = loop;
        boundary->count = 1;
        if (loop)
            decode_polygon(&polygon, loop);
    } else if (place_given(&polygons)) {
        decode_polygons(&polygons, boundary);
    } else {
        decode_loops(&trims, surface, boundary);
    }
}

static void decode_one(const struct json_place *place, const struct api_request *common,
                       size_t number, struct laminate_ply *ply) {
    static const char *const keys[] = {"name",         "repeat",    "compaction", "boundary",
                                       "fabric",       "start",     "direction",  "generators",
                                       "method",       "yarn_path", "extent",     "permeability",
                                       "areal_weight", NULL};
    struct json_place name = place_member(place, "name"), repeat = place_member(place, "repeat");
    struct json_place law = place_member(place, "compaction");
    struct json_place boundary = place_member(place, "boundary");
    struct json_place weight = place_member(place, "areal_weight");
    *ply = (struct laminate_ply){.drape = *common, .repeat = 1};
    decode_name(&name, number, ply);
    if (!place_object(place, keys))
        return;
    decode_ply(place, &ply->drape);
    ply->areal_weight = ply->drape.fabric.areal_weight;
    ply->law = ply->drape.fabric.compaction;
    if (place_given(&weight))
        place_number(&weight, decode_areal_weights, &ply->areal_weight);
    if (place_given(&repeat))
        place_integer(&repeat, 1, LAMINATE_REPEAT_MAX, &ply->repeat);
    if (place_given(&law))
        decode_compaction(&law, &ply->law);
    if (place_given(&boundary))
        decode_boundary(&boundary, &common->surface, &ply->boundary);
}

/* ---- the stack ---- */

static void decode_cavity(const struct json_place *place, struct stack_cavity *cavity) {
    static const char *const keys[] = {"pressure", "height", NULL};
    static const char *const names[] = {"flexible"};
    struct json_place pressure = place_member(place, "pressure");
    struct json_place height = place_member(place, "height");
    int index;
    if (place_type(place) == PLACE_STRING) {
        place_choice(place, names, 1, &index);
        return;
    }
    if (!place_object(place, keys))
        return;
    if (place_given(&pressure) == place_given(&height)) {
        place_fault(place, "must be \"flexible\", or have either \"pressure\" or \"height\"");
    } else if (place_given(&pressure)) {
        cavity->kind = STACK_PRESSURE;
        place_number(&pressure, pressures, &cavity->pressure);
    } else {
        cavity->kind = STACK_HEIGHT;
        place_number(&height, decode_lengths, &cavity->height);
    }
}

static void decode_offset(const struct json_place *root, struct laminate *laminate) {
    static const char *const names[] = {"none", "nominal"};
    struct json_place offset = place_member(root, "offset"), side = place_member(root, "side");
    int index = 0;
    if (place_given(&offset) && place_choice(&offset, names, 2, &index))
        laminate->nominal = index == 1;
    if (laminate->nominal && laminate->surface.kind == API_SURFACE_MESH)
        place_fault(&offset, "nominal needs a surface with a curvature, not a triangle mesh: take "
                             "\"none\"");
    if (place_given(&side) && place_integer(&side, -1, 1, &laminate->side) && laminate->side == 0)
        place_fault(&side, "must be 1 or -1");
}

/* What the stack needs of a ply. */
static void check_ply(const struct json_place *place, const struct laminate *laminate,
                      const struct laminate_ply *ply) {
    struct json_place fabric = place_member(place, "fabric");
    struct json_place thickness = place_member(&fabric, "thickness");
    struct json_place fraction = place_member(&fabric, "fiber_volume_fraction");
    bool thick = ply->drape.fabric.thickness > 0;
    if (laminate->nominal && !thick)
        place_fault(&thickness, "is required by the offset: plies lie on each other");
    else if (laminate->cavity.kind == STACK_HEIGHT && !thick)
        place_fault(&thickness, "is required in a cavity of a given height");
    else if (ply->law.a > 0 && !thick)
        place_fault(&thickness, "is required by the compaction");
    if (ply->law.a > 0 && !(ply->drape.fabric.fiber_volume_fraction > 0))
        place_fault(&fraction, "is required by the compaction");
}

/* h_k of the header. */
static void find_heights(struct laminate *laminate) {
    double below = 0;
    for (size_t k = 0; laminate->nominal && k < laminate->count; k++) {
        struct laminate_ply *ply = &laminate->plies[k];
        double own = laminate_layers(ply) * ply->drape.fabric.thickness;
        ply->drape.offset = laminate->side * (below + own / 2);
        below += own;
    }
}

static void decode_plies(const struct json_place *list, const struct api_request *common,
                         struct laminate *laminate) {
    if (!place_array(list, 1))
        return;
    laminate->count = place_length(list);
    if (laminate->count > LAMINATE_PLIES_MAX) {
        place_fault(list,
                    "has %zu plies, and %d are allowed: take \"repeat\" for equal ones on "
                    "each other",
                    laminate->count, LAMINATE_PLIES_MAX);
        laminate->count = 0;
        return;
    }
    laminate->plies = json_tree_alloc(list->tree, laminate->count, sizeof *laminate->plies);
    for (size_t k = 0; laminate->plies && k < laminate->count; k++) {
        struct json_place ply = place_element(list, k);
        decode_one(&ply, common, k, &laminate->plies[k]);
        check_ply(&ply, laminate, &laminate->plies[k]);
    }
    if (laminate->plies)
        find_heights(laminate);
}

static void decode_root(const struct json_place *root, const struct api_input *input,
                        const struct api_limits *limits, struct laminate *laminate) {
    static const char *const keys[] = {"surface", "length_unit", "plies", "cavity",
                                       "offset",  "side",        NULL};
    struct json_place plies = place_member(root, "plies"), cavity = place_member(root, "cavity");
    struct api_request common;
    if (!place_object(root, keys))
        return;
    decode_common(root, input, limits, &common);
    laminate->surface = common.surface;
    laminate->length_unit = common.length_unit;
    laminate->unit_of_surface = common.unit_of_surface;
    if (place_given(&cavity))
        decode_cavity(&cavity, &laminate->cavity);
    decode_offset(root, laminate);
    decode_plies(&plies, &common, laminate);
}

enum api_problem_id laminate_decode(const struct api_input *input, const struct api_limits *limits,
                                    struct arena *arena, struct laminate *laminate,
                                    struct api_problem *problem) {
    struct json_tree tree;
    *laminate = (struct laminate){.side = 1};
    if (json_tree_parse(&tree, input->request, input->request_length, limits, arena, problem) !=
        API_OK)
        return problem->id;
    struct json_place root = place_root(&tree);
    decode_root(&root, input, limits, laminate);
    json_tree_free(&tree);
    return problem->id;
}

bool laminate_is(const char *bytes, size_t length, const struct api_limits *limits) {
    struct api_problem problem = {.id = API_OK};
    struct json_tree tree;
    struct arena *arena = arena_new(limits->max_memory);
    bool is = false;
    if (arena && json_tree_parse(&tree, bytes, length, limits, arena, &problem) == API_OK) {
        struct json_place root = place_root(&tree), plies = place_member(&root, "plies");
        is = place_given(&plies);
        json_tree_free(&tree);
    }
    arena_free(arena);
    return is;
}
