/* SPDX-License-Identifier: MIT */
#include "decode.h"

#include "api/json/place.h"
#include "parts.h"
#include "shape_shell.h"
#include "solver/shell/shell.h"
#include <string.h>

static const struct place_range angles = {-1e6, 1e6, false}; /* of the warp, deg */
enum { INDEX_MAX = 100000000 /* of an extent */ };

/* Exactly one of two keys of an object is given: which (0 or 1), or -1 after reporting. */
static int read_alternative(const struct json_place *place, const char *first, const char *second) {
    const char *const keys[] = {first, second, NULL};
    if (!place_object(place, keys))
        return -1;
    struct json_place a = place_member(place, first), b = place_member(place, second);
    if (place_given(&a) != place_given(&b))
        return place_given(&a) ? 0 : 1;
    place_fault(place, "must have either \"%s\" or \"%s\"", first, second);
    return -1;
}

/* A point, or with `direction` a vector that gives one. */
static void read_vec3(const struct json_place *place, bool direction, struct vec3 *vector) {
    double values[3];
    if (!place_vector(place, decode_coordinates, 3, values))
        return;
    *vector = vec3_make(values[0], values[1], values[2]);
    if (direction && vec3_norm(*vector) < decode_lengths.low)
        place_fault(place, "must be longer than %g", decode_lengths.low);
}

/* A surface that was imported has the unit of its file. */
static void decode_unit(const struct json_place *place, const struct api_surface *surface,
                        const struct api_unit **unit) {
    const char *names[API_UNIT_COUNT];
    int index = 0;
    for (int i = 0; i < API_UNIT_COUNT; i++)
        names[i] = api_units[i].name;
    if (!place_given(place) || place_choice(place, names, API_UNIT_COUNT, &index))
        *unit = &api_units[index];
    if (!surface->length_unit)
        return;
    if (place_given(place) && *unit != surface->length_unit)
        place_fault(place, "must be \"%s\", as the surface says", surface->length_unit->name);
    *unit = surface->length_unit;
}

/* A NURBS surface, the request's or the face that it starts on, has a domain; whether a point in
 * space is near the surface is found later. */
static void check_start(const struct json_place *uv, const struct api_request *request,
                        const struct api_surface *surface) {
    const struct nurbs_axis *axis[2] = {&surface->nurbs.u, &surface->nurbs.v};
    const double *start = request->settings.start_uv;
    bool on_face = request->surface.kind == API_SURFACE_SHELL;
    char title[API_FACE_TITLE_SIZE] = "";
    if (surface->kind == API_SURFACE_MESH)
        place_fault(uv, "a triangle mesh has no u and v: give the start as a point");
    if (surface->kind != API_SURFACE_NURBS)
        return;
    if (on_face)
        api_shape_face_title(&request->surface, request->settings.start_face, title);
    for (size_t k = 0; k < 2; k++) {
        double low = axis[k]->knots[axis[k]->degree], high = axis[k]->knots[axis[k]->size];
        if (start[k] < low || start[k] > high) {
            place_fault(uv, "%c must lie in the domain of %s%s, between %g and %g", "uv"[k],
                        on_face ? "face " : "the surface", title, low, high);
            return;
        }
    }
}

/* The face whose parameters a start has; NULL after a fault, or where it is not known yet. */
static const struct api_surface *decode_start_face(const struct json_place *place,
                                                   struct api_request *request) {
    const struct api_surface *surface = &request->surface;
    struct json_place face = place_member(place, "face");
    int number = 0;
    if (surface->kind != API_SURFACE_SHELL && surface->kind != API_SURFACE_NAMED) {
        if (place_given(&face))
            place_fault(&face, "is of a surface of several faces, and this one has none");
        return place_given(&face) ? NULL : surface;
    }
    if (surface->kind == API_SURFACE_NAMED && !place_given(&face))
        return NULL;
    if (!place_integer(&face, 0, SHELL_FACES_MAX - 1, &number))
        return NULL;
    request->settings.start_face = number;
    request->start_on_face = true;
    if (surface->kind == API_SURFACE_NAMED)
        return NULL;
    if ((size_t)number < surface->face_count)
        return &surface->faces[number];
    place_fault(&face, "must be a number below %zu: there are that many faces",
                surface->face_count);
    return NULL;
}

void decode_start(const struct json_place *place, struct api_request *request) {
    static const char *const keys[] = {"uv", "point", "face", NULL};
    struct drape_settings *settings = &request->settings;
    struct json_place uv = place_member(place, "uv"), point = place_member(place, "point");
    struct json_place face = place_member(place, "face");
    if (!place_object(place, keys))
        return;
    if (place_given(&uv) == place_given(&point)) {
        place_fault(place, "must have either \"uv\" or \"point\"");
        return;
    }
    if (place_given(&uv)) {
        const struct api_surface *surface = decode_start_face(place, request);
        settings->start_kind = DRAPE_START_UV;
        if (place_vector(&uv, decode_coordinates, 2, settings->start_uv) && surface)
            check_start(&uv, request, surface);
        return;
    }
    settings->start_kind = DRAPE_START_POINT;
    read_vec3(&point, false, &settings->start_point);
    if (place_given(&face))
        place_fault(&face, "goes with \"uv\"");
}

static void decode_direction(const struct json_place *place, struct drape_settings *settings) {
    struct json_place angle = place_member(place, "angle_deg");
    struct json_place vector = place_member(place, "vector");
    switch (read_alternative(place, "angle_deg", "vector")) {
    case 0:
        settings->direction_kind = DRAPE_DIRECTION_ANGLE;
        place_number(&angle, angles, &settings->direction_deg);
        break;
    case 1:
        settings->direction_kind = DRAPE_DIRECTION_VECTOR;
        read_vec3(&vector, true, &settings->direction_vector);
        break;
    }
}

static void decode_generator(const struct json_place *place, struct drape_generator *generator) {
    static const char *const names[] = {"geodesic"};
    struct json_place curve = place_member(place, "uv"), plane = place_member(place, "plane");
    double *rows;
    int index;
    if (place_type(place) == PLACE_STRING) {
        place_choice(place, names, 1, &index);
        return;
    }
    switch (read_alternative(place, "uv", "plane")) {
    case 0:
        generator->kind = DRAPE_GENERATOR_CURVE;
        if (place_rows(&curve, decode_coordinates, 2, 2, &rows, &generator->curve_count))
            generator->curve = (const double(*)[2])rows;
        break;
    case 1:
        generator->kind = DRAPE_GENERATOR_PLANE;
        read_vec3(&plane, true, &generator->plane_normal);
        break;
    }
}

static const char *const yarn_keys[] = {"warp", "weft", NULL};

static void decode_generators(const struct json_place *place, struct drape_settings *settings) {
    if (!place_object(place, yarn_keys))
        return;
    for (int k = 0; k < 2; k++) {
        struct json_place generator = place_member(place, yarn_keys[k]);
        if (place_given(&generator))
            decode_generator(&generator, &settings->generator[k]);
    }
}

static void decode_extent(const struct json_place *place, struct drape_settings *settings) {
    if (!place_object(place, yarn_keys))
        return;
    for (int k = 0; k < 2; k++) {
        struct json_place yarn = place_member(place, yarn_keys[k]);
        struct json_place low = place_element(&yarn, 0), high = place_element(&yarn, 1);
        if (!place_given(&yarn))
            continue;
        settings->has_extent[k] = true;
        if (place_type(&yarn) != PLACE_ARRAY || place_length(&yarn) != 2) {
            place_fault(&yarn, "must be an array of two whole numbers");
            continue;
        }
        place_integer(&low, -INDEX_MAX, 0, &settings->extent[k][0]);
        place_integer(&high, 0, INDEX_MAX, &settings->extent[k][1]);
    }
}

static void decode_cavity(const struct json_place *place, struct api_cavity *cavity) {
    static const char *const keys[] = {"height", NULL};
    static const char *const names[] = {"flexible"};
    int index;
    if (place_type(place) == PLACE_STRING) {
        place_choice(place, names, 1, &index);
        return;
    }
    struct json_place height = place_member(place, "height");
    cavity->rigid = true;
    if (place_object(place, keys))
        place_number(&height, decode_lengths, &cavity->height);
}

static void decode_offset(const struct json_place *place, struct api_request *request) {
    if (place_number(place, decode_coordinates, &request->offset) &&
        request->surface.kind == API_SURFACE_MESH && request->offset != 0)
        place_fault(place, "needs a surface with a curvature, not a triangle mesh");
}

static void decode_method(const struct json_place *root, struct api_request *request) {
    struct drape_settings *settings = &request->settings;
    struct json_place method = place_member(root, "method"), path = place_member(root, "yarn_path");
    int index = DRAPE_GIB;
    if (place_given(&method))
        place_choice(&method, api_method_names, DRAPE_GIB4 + 1, &index);
    settings->method = (enum drape_method)index;
    index = DRAPE_PATH_CHORD;
    if (place_given(&path))
        place_choice(&path, api_yarn_path_names, DRAPE_PATH_RELAXATION + 1, &index);
    settings->yarn_path = (enum drape_yarn_path)index;
    if (settings->yarn_path == DRAPE_PATH_RELAXATION && settings->method != DRAPE_GIB)
        place_fault(&path, "relaxation is for the method \"gib\"");
    bool on_mesh = request->surface.kind == API_SURFACE_MESH;
    if (on_mesh && settings->method == DRAPE_GIB4)
        place_fault(&method,
                    "must not be \"gib4\" on a triangle mesh, whose curvature is not known "
                    "to fourth order");
    if (on_mesh && settings->yarn_path == DRAPE_PATH_RELAXATION)
        place_fault(&path, "relaxation needs a surface with parameters, not a triangle mesh");
    for (int k = 0; k < 2 && on_mesh; k++) {
        struct json_place generators = place_member(root, "generators");
        struct json_place generator = place_member(&generators, yarn_keys[k]);
        if (settings->generator[k].kind == DRAPE_GENERATOR_CURVE)
            place_fault(&generator,
                        "must not be a curve in u and v, which a triangle mesh does not have");
    }
}

/* The stored definition of the surface that the request named, if the caller has it. It was sound
 * when it was stored, so what may be wrong with it is no fault of the request's. */
static void decode_stored(const struct api_input *input, const struct api_limits *limits,
                          struct arena *arena, struct api_surface *surface,
                          struct api_problem *problem) {
    struct api_surface stored;
    struct api_problem inner = {0};
    if (surface->kind != API_SURFACE_NAMED || input->surface_length == 0)
        return;
    enum api_problem_id id =
        api_decode_surface(input->surface, input->surface_length, limits, arena, &stored, &inner);
    if (id == API_OUT_OF_MEMORY) {
        api_problem_set(problem, id, "%s", inner.place[0].detail);
    } else if (id != API_OK) {
        api_problem_set(problem, API_INTERNAL, "the stored surface cannot be read: %s",
                        inner.place[0].detail);
    } else {
        memcpy(stored.id, surface->id, API_ID_SIZE);
        stored.selection = surface->selection;
        *surface = stored;
    }
}

static void check_points(const struct json_place *place, const struct api_surface *surface,
                         const struct api_limits *limits) {
    struct json_place points = place_member(place, "control_points");
    struct json_place faces = place_member(place, "faces");
    size_t count = surface->nurbs.point_count;
    for (size_t k = 0; k < surface->face_count; k++)
        count += surface->faces[k].nurbs.point_count;
    if (surface->kind != API_SURFACE_MESH && count > limits->max_control_points)
        place_fault(surface->kind == API_SURFACE_SHELL ? &faces : &points,
                    "has %zu points, and %zu are allowed", count, limits->max_control_points);
}

/* Where the drape is, and in which unit. */
static void decode_ground(const struct json_place *root, const struct api_input *input,
                          const struct api_limits *limits, struct api_request *request) {
    const struct json_tree *tree = root->tree;
    struct json_place surface = place_member(root, "surface");
    struct json_place unit = place_member(root, "length_unit");
    if (decode_surface(&surface, &request->surface))
        decode_stored(input, limits, tree->arena, &request->surface, tree->problem);
    else
        request->surface = (struct api_surface){.kind = API_SURFACE_NAMED};
    check_points(&surface, &request->surface, limits);
    decode_unit(&unit, &request->surface, &request->length_unit);
    request->unit_of_surface = request->surface.kind == API_SURFACE_NAMED && !place_given(&unit);
}

/* What concerns the cloth alone; needs the surface's kind and domain. */
static void decode_cloth(const struct json_place *root, struct api_request *request) {
    struct json_place fabric = place_member(root, "fabric"), start = place_member(root, "start");
    struct json_place direction = place_member(root, "direction");
    struct json_place generators = place_member(root, "generators");
    struct json_place extent = place_member(root, "extent");
    struct json_place permeability = place_member(root, "permeability");
    decode_fabric(&fabric, request);
    if (place_given(&start))
        decode_start(&start, request);
    if (place_given(&direction))
        decode_direction(&direction, &request->settings);
    if (place_given(&generators))
        decode_generators(&generators, &request->settings);
    decode_method(root, request);
    if (place_given(&extent))
        decode_extent(&extent, &request->settings);
    if (place_given(&permeability)) {
        request->permeability = (struct api_permeability){.model = API_PERMEABILITY_NONE};
        decode_permeability(&permeability, &request->permeability);
    }
}

/* Permeability models that scale with the fibre volume fraction need one, which in a rigid cavity
 * follows from the thickness. */
static void check_permeability(const struct json_place *root, const struct api_request *request) {
    struct json_place fabric = place_member(root, "fabric");
    struct json_place fraction = place_member(&fabric, "fiber_volume_fraction");
    struct json_place thickness = place_member(&fabric, "thickness");
    enum api_permeability_model model = request->permeability.model;
    if (model == API_PERMEABILITY_NONE ||
        (model == API_PERMEABILITY_TABLE && request->permeability.fractions == 0))
        return;
    if (!place_given(&fraction) && request->fabric.fiber_volume_fraction == 0)
        place_fault(&fraction, "is required by this permeability model");
    if (request->cavity.rigid && !place_given(&thickness) && request->fabric.thickness == 0)
        place_fault(&thickness, "is required by this permeability model in a rigid cavity");
}

static struct api_request default_request(const struct api_limits *limits) {
    return (struct api_request){
        .length_unit = &api_units[0],
        .fabric = {.locking_angle_deg = -1, .plies = 1},
        .settings = {.method = DRAPE_GIB, .max_nodes = limits->max_nodes},
        .permeability = {.model = API_PERMEABILITY_NONE},
    };
}

void decode_drape(const struct json_place *place, const struct api_input *input,
                  const struct api_limits *limits, struct api_request *request) {
    static const char *const keys[] = {"surface",   "length_unit",  "offset", "fabric",    "start",
                                       "direction", "generators",   "method", "yarn_path", "extent",
                                       "cavity",    "permeability", NULL};
    struct json_place cavity = place_member(place, "cavity"),
                      offset = place_member(place, "offset");
    *request = default_request(limits);
    if (!place_object(place, keys))
        return;
    decode_ground(place, input, limits, request);
    if (place_given(&offset))
        decode_offset(&offset, request);
    decode_cloth(place, request);
    if (place_given(&cavity))
        decode_cavity(&cavity, &request->cavity);
    check_permeability(place, request);
}

void decode_common(const struct json_place *place, const struct api_input *input,
                   const struct api_limits *limits, struct api_request *request) {
    *request = default_request(limits);
    decode_ground(place, input, limits, request);
}

void decode_ply(const struct json_place *place, struct api_request *request) {
    decode_cloth(place, request);
    check_permeability(place, request);
}

enum api_problem_id api_decode(const struct api_input *input, const struct api_limits *limits,
                               struct arena *arena, struct api_request *request,
                               struct api_problem *problem) {
    struct json_tree tree;
    if (json_tree_parse(&tree, input->request, input->request_length, limits, arena, problem) !=
        API_OK)
        return problem->id;
    struct json_place root = place_root(&tree);
    decode_drape(&root, input, limits, request);
    json_tree_free(&tree);
    return problem->id;
}

enum api_problem_id api_decode_permeability(const char *bytes, size_t length,
                                            const struct api_limits *limits, struct arena *arena,
                                            struct api_permeability *permeability,
                                            struct api_problem *problem) {
    struct json_tree tree;
    *permeability = (struct api_permeability){.model = API_PERMEABILITY_NONE};
    if (json_tree_parse(&tree, bytes, length, limits, arena, problem) != API_OK)
        return problem->id;
    struct json_place root = place_root(&tree), member = place_member(&root, "permeability");
    decode_permeability(place_given(&member) ? &member : &root, permeability);
    json_tree_free(&tree);
    return problem->id;
}

enum api_problem_id api_decode_surface(const char *bytes, size_t length,
                                       const struct api_limits *limits, struct arena *arena,
                                       struct api_surface *surface, struct api_problem *problem) {
    struct json_tree tree;
    if (json_tree_parse(&tree, bytes, length, limits, arena, problem) != API_OK)
        return problem->id;
    struct json_place root = place_root(&tree);
    decode_surface(&root, surface);
    check_points(&root, surface, limits);
    if (problem->id == API_OK && surface->kind == API_SURFACE_NAMED) {
        struct json_place degree = place_member(&root, "degree_u");
        place_fault(&degree, "is required: a definition, not an id");
    }
    json_tree_free(&tree);
    return problem->id;
}
