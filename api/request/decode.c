/* SPDX-License-Identifier: MIT */
#include "decode.h"

#include "api/json/value.h"
#include "digest.h"
#include "members.h"
#include "prepared_form.h"
#include "prepared_shell.h"
#include "solver/shell/shell.h"
#include <stdio.h>
#include <string.h>

static const struct value_range angles = {-1e6, 1e6, false}; /* of the warp, deg */
static const double parallel = 1e-6; /* sine of the angle between axes that span no plane */
enum { INDEX_MAX = 100000000 /* of an extent */ };

/* Exactly one of two keys of an object is given: which (0 or 1), or -1 after reporting. */
static int read_alternative(const struct json_value *json, const char *first, const char *second) {
    const char *const keys[] = {first, second, NULL};
    if (!value_object(json, keys))
        return -1;
    struct json_value a = value_member(json, first), b = value_member(json, second);
    if (value_given(&a) != value_given(&b))
        return value_given(&a) ? 0 : 1;
    value_fault(json, "must have either \"%s\" or \"%s\"", first, second);
    return -1;
}

/* A point, or with `direction` a vector that gives one. */
static void read_vec3(const struct json_value *json, bool direction, struct vec3 *vector) {
    double values[3];
    if (!value_vector(json, decode_coordinates, 3, values))
        return;
    *vector = vec3_make(values[0], values[1], values[2]);
    if (direction && vec3_norm(*vector) < decode_lengths.low)
        value_fault(json, "must be longer than %g", decode_lengths.low);
}

/* The face whose parameters a start has; NULL after a fault, or where it is not known yet. */
static const struct api_surface *decode_start_face(const struct json_value *json,
                                                   struct api_request *request) {
    const struct api_surface *surface = &request->surface;
    struct json_value face = value_member(json, "face");
    int number = 0;
    if (surface->kind != API_SURFACE_SHELL && surface->kind != API_SURFACE_NAMED) {
        if (value_given(&face))
            value_fault(&face, "must be left out: only surfaces of several faces have it");
        return value_given(&face) ? NULL : surface;
    }
    if (surface->kind == API_SURFACE_NAMED && !value_given(&face))
        return NULL;
    if (!value_integer(&face, 0, SHELL_FACES_MAX - 1, &number))
        return NULL;
    request->settings.start_face = number;
    request->start_on_face = true;
    if (surface->kind == API_SURFACE_NAMED)
        return NULL;
    if ((size_t)number < surface->face_count)
        return &surface->faces[number];
    value_fault(&face, "must be less than %zu, the number of faces", surface->face_count);
    return NULL;
}

void decode_start(const struct json_value *json, struct api_request *request) {
    static const char *const keys[] = {"uv", "point", "face", NULL};
    struct drape_settings *settings = &request->settings;
    struct json_value uv = value_member(json, "uv"), point = value_member(json, "point");
    struct json_value face = value_member(json, "face");
    if (!value_object(json, keys))
        return;
    if (value_given(&uv) == value_given(&point)) {
        value_fault(json, "must have either \"uv\" or \"point\"");
        return;
    }
    if (value_given(&uv)) {
        const struct api_surface *surface = decode_start_face(json, request);
        settings->start_kind = DRAPE_START_UV;
        if (!value_vector(&uv, decode_coordinates, 2, settings->start_uv) || !surface)
            return;
        if (surface->kind == API_SURFACE_MESH)
            value_fault(&uv, "a triangle mesh has no u and v: give the start as a point");
        if (surface->kind != API_SURFACE_NURBS)
            return;
        /* A NURBS surface, the request's or the face that it starts on, has a domain; whether a
         * point in space is near the surface is found later. */
        const struct nurbs_axis *axis[2] = {&surface->nurbs.u, &surface->nurbs.v};
        const double *start = settings->start_uv;
        bool on_face = request->surface.kind == API_SURFACE_SHELL;
        char title[API_FACE_TITLE_SIZE] = "";
        if (on_face)
            prepared_shell_face_title(&request->surface, settings->start_face, title);
        for (size_t k = 0; k < 2; k++) {
            double low = axis[k]->knots[axis[k]->degree], high = axis[k]->knots[axis[k]->size];
            if (start[k] < low || start[k] > high) {
                value_fault(&uv, "%c must lie in the domain of %s%s, between %g and %g", "uv"[k],
                            on_face ? "face " : "the surface", title, low, high);
                return;
            }
        }
        return;
    }
    settings->start_kind = DRAPE_START_POINT;
    read_vec3(&point, false, &settings->start_point);
    if (value_given(&face))
        value_fault(&face, "needs \"uv\"");
}

static void decode_generator(const struct json_value *json, struct drape_generator *generator) {
    static const char *const names[] = {"geodesic", "least_energy"};
    struct json_value steered = value_member(json, "steered");
    struct json_value places = value_member(json, "places");
    struct json_value curve = value_member(json, "uv"), plane = value_member(json, "plane");
    double *rows;
    int index;
    if (value_type(json) == VALUE_STRING) {
        if (value_choice(json, names, 2, &index) && index == 1) {
            generator->kind = DRAPE_GENERATOR_LEAST;
            generator->curvature = (struct drape_curvature){.points = DECODE_STEERED_POINTS};
        }
        return;
    }
    if (value_given(&steered)) {
        static const char *const keys[] = {"steered", NULL};
        if (value_object(json, keys))
            decode_steered(&steered, generator);
        return;
    }
    if (value_given(&places)) {
        decode_places(json, generator);
        return;
    }
    int which = read_alternative(json, "uv", "plane");
    if (which == 0) {
        generator->kind = DRAPE_GENERATOR_CURVE;
        if (value_rows(&curve, decode_coordinates, 2, 2, &rows, &generator->curve_count))
            generator->curve = (const double(*)[2])rows;
    } else if (which == 1) {
        generator->kind = DRAPE_GENERATOR_PLANE;
        read_vec3(&plane, true, &generator->plane_normal);
    }
}

static const char *const yarn_keys[] = {"warp", "weft", NULL};

/* Whether `generators` say one thing of warp and weft: "least_energy", or {"steered"}. */
static bool are_alike(const struct json_value *generators) {
    struct json_value steered = value_member(generators, "steered");
    return value_type(generators) == VALUE_STRING || value_given(&steered);
}

/* Of each or of both alike; weft that slides follows the warp, whatever both are. */
static void decode_generators(const struct json_value *json, struct drape_settings *settings) {
    struct drape_generator *generator = settings->generator;
    if (are_alike(json)) {
        decode_generator(json, &generator[0]);
        if (!(settings->slide > 0))
            generator[1] = generator[0];
        return;
    }
    if (!value_object(json, yarn_keys))
        return;
    for (int k = 0; k < 2; k++) {
        struct json_value own = value_member(json, yarn_keys[k]);
        if (value_given(&own))
            decode_generator(&own, &generator[k]);
        if (k == 1 && settings->slide > 0 && generator[k].kind != DRAPE_GENERATOR_GEODESIC)
            value_fault(&own, "must be \"geodesic\" where weft slides along warp "
                              "(fabric.kinematics): fibres follow the warp generator");
    }
}

bool decode_name(const struct json_value *json, size_t most, char *name) {
    const char *given;
    if (!value_string(json, &given))
        return false;
    size_t length = strlen(given);
    bool good = length >= 1 && length <= most;
    for (size_t k = 0; k < length; k++)
        good = good && given[k] >= ' ' && given[k] <= '~';
    if (!good)
        return value_fault(json, "must have 1 to %zu printable ASCII characters", most);
    memcpy(name, given, length + 1);
    return true;
}

void decode_cut_path(const struct json_value *json, struct drape_cut_line *cut) {
    double *rows;
    if (!value_rows(json, decode_coordinates, 3, 2, &rows, &cut->count))
        return;
    if (cut->count > API_CUT_POINTS_MAX)
        value_fault(json, "must have at most %d points", API_CUT_POINTS_MAX);
    cut->path = (const struct vec3 *)rows;
    for (size_t k = 1; k < cut->count; k++)
        if (vec3_distance(cut->path[k], cut->path[k - 1]) == 0) {
            struct json_value point = value_element(json, k);
            value_fault(&point, "is the same point as the one before: leave it out");
            return;
        }
}

bool decode_count(const struct json_value *json, size_t least, int most, const char *what,
                  size_t *count) {
    if (!value_array(json, least))
        return false;
    *count = value_length(json);
    return *count <= (size_t)most || value_fault(json, "must have at most %d %s", most, what);
}

/* The cuts, their names and allowances beside them. */
static void decode_cuts(const struct json_value *json, struct api_request *request) {
    static const char *const keys[] = {"path", "name", "allowance", NULL};
    static const struct value_range allowances = {0, 1e12, false};
    struct drape_settings *settings = &request->settings;
    size_t count;
    if (!decode_count(json, 0, API_CUTS_MAX, "cuts", &count))
        return;
    struct drape_cut_line *cuts = json_tree_alloc(json->tree, count + 1, sizeof *cuts);
    char(*names)[API_CUT_NAME_MAX + 1] = json_tree_alloc(json->tree, count + 1, sizeof *names);
    double *own = json_tree_alloc(json->tree, count + 1, sizeof *own);
    if (!cuts || !names || !own)
        return;
    for (size_t k = 0; k < count; k++) {
        struct json_value cut = value_element(json, k);
        struct json_value path = value_member(&cut, "path"), name = value_member(&cut, "name");
        struct json_value allowance = value_member(&cut, "allowance");
        (void)snprintf(names[k], sizeof names[k], "cut_%zu", k + 1);
        if (!value_object(&cut, keys))
            continue;
        decode_cut_path(&path, &cuts[k]);
        if (value_given(&name))
            decode_name(&name, API_CUT_NAME_MAX, names[k]);
        if (value_given(&allowance))
            value_number(&allowance, allowances, &own[k]);
    }
    settings->cuts = cuts;
    settings->cut_count = count;
    request->cut_names = (const char(*)[API_CUT_NAME_MAX + 1]) names;
    request->cut_allowances = own;
}

static void decode_method(const struct json_value *root, struct api_request *request) {
    struct drape_settings *settings = &request->settings;
    struct json_value method = value_member(root, "method"), path = value_member(root, "yarn_path");
    int index = (int)settings->method;
    if (value_given(&method))
        value_choice(&method, drape_method_names, DRAPE_METHOD_COUNT, &index);
    settings->method = (enum drape_method)index;
    index = (int)settings->yarn_path;
    if (value_given(&path))
        value_choice(&path, api_yarn_path_names, DRAPE_PATH_RELAXATION + 1, &index);
    settings->yarn_path = (enum drape_yarn_path)index;
    if (settings->yarn_path == DRAPE_PATH_RELAXATION && settings->method != DRAPE_GIB)
        value_fault(&path, "relaxation is for the method \"gib\"");
    bool on_mesh = request->surface.kind == API_SURFACE_MESH;
    if (on_mesh && !drape_method_traits[settings->method].on_meshes)
        value_fault(&method,
                    "must not be \"gib4\" on a triangle mesh, whose curvature is not known "
                    "to fourth order");
    if (on_mesh && settings->yarn_path == DRAPE_PATH_RELAXATION)
        value_fault(&path, "relaxation needs a surface with parameters, not a triangle mesh");
    for (int k = 0; k < 2; k++) {
        struct json_value generators = value_member(root, "generators");
        struct json_value generator =
            are_alike(&generators) ? generators : value_member(&generators, yarn_keys[k]);
        decode_check_steered(&generator, settings, k, on_mesh);
        if (settings->generator[k].kind == DRAPE_GENERATOR_PLACES && (k == 1 || on_mesh))
            value_fault(&generator, k == 1 ? "must not be places, which only warp can follow"
                                           : "must not be places of parameters, which a triangle "
                                             "mesh does not have");
        if (on_mesh && settings->generator[k].kind == DRAPE_GENERATOR_CURVE)
            value_fault(&generator,
                        "must not be a curve in u and v, which a triangle mesh does not have");
    }
}

/* The form of a document that has its surface in itself. */
static const struct prepared_form *form_of_text(const struct api_input *input,
                                                struct arena *arena) {
    char digest[API_ID_SIZE];
    if (!input->form_length && !input->opened)
        return NULL;
    api_digest_bytes(input->request, input->request_length, digest);
    return prepared_form_find(input, digest, arena);
}

static void check_point_count(const struct json_value *json, const struct api_surface *surface,
                              const struct api_limits *limits) {
    struct json_value points = value_member(json, "control_points");
    struct json_value faces = value_member(json, "faces");
    size_t count = surface->nurbs.point_count;
    for (size_t k = 0; k < surface->face_count; k++)
        count += surface->faces[k].nurbs.point_count;
    if (surface->kind != API_SURFACE_MESH && count > limits->max_control_points)
        value_fault(surface->kind == API_SURFACE_SHELL ? &faces : &points,
                    "has %zu points, and %zu are allowed", count, limits->max_control_points);
}

/* The definition of the stored surface that the request names, of which the caller has either the
 * form or the text. It was sound when it was stored, so what may be wrong with it is no fault of
 * the request's. */
static void decode_stored(const struct json_tree *tree, const struct api_input *input,
                          const struct api_limits *limits, struct api_surface *surface) {
    const struct prepared_form *form = prepared_form_find(input, surface->id, tree->arena);
    struct api_surface stored;
    struct api_problem inner = {0};
    enum api_problem_id id = API_OK;
    if (form)
        stored = form->request.surface;
    else if (input->form_length > 0 && input->surface_length == 0)
        id = api_problem_no_memory(&inner, "the surface");
    else if (input->surface_length > 0)
        id = api_decode_surface(input->surface, input->surface_length, limits, tree->arena, &stored,
                                &inner);
    else
        return;
    if (id == API_OUT_OF_MEMORY) {
        api_problem_set(tree->problem, id, "%s", inner.error[0].detail);
    } else if (id != API_OK) {
        api_problem_set(tree->problem, API_INTERNAL, "the stored surface cannot be read: %s",
                        inner.error[0].detail);
    } else {
        memcpy(stored.id, surface->id, API_ID_SIZE);
        stored.selection = surface->selection;
        *surface = stored;
    }
}

/* Where the drape is, and in which unit. */
static void decode_ground(const struct json_value *root, const struct api_input *input,
                          const struct api_limits *limits, struct api_request *request) {
    const struct json_tree *tree = root->tree;
    struct json_value surface = value_member(root, "surface");
    struct json_value unit = value_member(root, "length_unit");
    const struct prepared_form *form = form_of_text(input, tree->arena);
    if (form)
        request->surface = form->request.surface;
    else if (!decode_surface(&surface, &request->surface))
        request->surface = (struct api_surface){.kind = API_SURFACE_NAMED};
    else if (request->surface.kind == API_SURFACE_NAMED)
        decode_stored(tree, input, limits, &request->surface);
    check_point_count(&surface, &request->surface, limits);
    if (value_given(&unit))
        decode_unit_name(&unit, &request->length_unit);
    /* A surface that was imported has the unit of its file. */
    const struct api_unit *own = request->surface.length_unit;
    if (own && value_given(&unit) && request->length_unit != own)
        value_fault(&unit, "must be \"%s\", as the surface says", own->name);
    if (own)
        request->length_unit = own;
    request->unit_of_surface = request->surface.kind == API_SURFACE_NAMED && !value_given(&unit);
}

/* What angles are counted from: a rosette or, on several faces, an axis that has nothing to do with
 * their parameters. */
static void decode_zero(const struct json_value *root, struct api_request *request) {
    static const char *const keys[] = {"origin", "x", "z", NULL};
    struct json_value rosette = value_member(root, "rosette");
    struct json_value origin = value_member(&rosette, keys[0]);
    struct json_value x = value_member(&rosette, keys[1]), z = value_member(&rosette, keys[2]);
    struct drape_zero *zero = &request->settings.zero;
    zero->kind = request->surface.kind == API_SURFACE_SHELL ? DRAPE_ZERO_AXES : DRAPE_ZERO_TANGENT;
    if (!value_given(&rosette) || !value_object(&rosette, keys))
        return;
    zero->kind = DRAPE_ZERO_ROSETTE;
    read_vec3(&origin, false, &request->rosette_origin);
    read_vec3(&x, true, &zero->x);
    if (!value_given(&z))
        return;
    read_vec3(&z, true, &zero->z);
    double sine = vec3_norm(vec3_cross(vec3_unit(zero->x), vec3_unit(zero->z)));
    if (vec3_norm2(zero->x) > 0 && vec3_norm2(zero->z) > 0 && !(sine > parallel))
        value_fault(&z, "must not be parallel to x");
}

/* What concerns the cloth alone; needs the surface's kind and domain. */
static void decode_cloth(const struct json_value *root, struct api_request *request) {
    struct json_value fabric = value_member(root, "fabric"), start = value_member(root, "start");
    struct json_value direction = value_member(root, "direction");
    struct json_value generators = value_member(root, "generators");
    struct json_value energy = value_member(root, "energy");
    struct json_value extent = value_member(root, "extent"), cuts = value_member(root, "cuts");
    struct json_value permeability = value_member(root, "permeability");
    struct drape_settings *settings = &request->settings;
    if (value_given(&fabric) || settings->spacing[0] == 0)
        decode_fabric(&fabric, request);
    if (value_given(&start))
        decode_start(&start, request);
    if (value_given(&direction)) {
        struct json_value angle = value_member(&direction, "angle_deg");
        struct json_value vector = value_member(&direction, "vector");
        int which = read_alternative(&direction, "angle_deg", "vector");
        if (which == 0) {
            settings->direction_kind = DRAPE_DIRECTION_ANGLE;
            value_number(&angle, angles, &settings->direction_deg);
        } else if (which == 1) {
            settings->direction_kind = DRAPE_DIRECTION_VECTOR;
            read_vec3(&vector, true, &settings->direction_vector);
        }
    }
    if (value_given(&generators))
        decode_generators(&generators, settings);
    if (settings->generator[0].kind == DRAPE_GENERATOR_PLACES && value_given(&start))
        value_fault(&start, "must be left out: the warp generator's places have their own");
    if (value_given(&energy))
        decode_energy(&energy, &settings->energy);
    decode_method(root, request);
    if (value_given(&extent) && value_object(&extent, yarn_keys))
        for (int k = 0; k < 2; k++) {
            struct json_value yarn = value_member(&extent, yarn_keys[k]);
            struct json_value low = value_element(&yarn, 0), high = value_element(&yarn, 1);
            if (!value_given(&yarn))
                continue;
            settings->has_extent[k] = true;
            if (value_type(&yarn) != VALUE_ARRAY || value_length(&yarn) != 2) {
                value_fault(&yarn, "must be an array of two whole numbers");
                continue;
            }
            value_integer(&low, -INDEX_MAX, 0, &settings->extent[k][0]);
            value_integer(&high, 0, INDEX_MAX, &settings->extent[k][1]);
        }
    if (value_given(&cuts))
        decode_cuts(&cuts, request);
    if (value_given(&permeability)) {
        request->permeability = (struct api_permeability){.model = API_PERMEABILITY_NONE};
        decode_permeability(&permeability, &request->permeability);
    }
}

/* Permeability models that scale with the fibre volume fraction need one, which in a rigid cavity
 * follows from the thickness. */
static void check_permeability(const struct json_value *root, const struct api_request *request) {
    struct json_value fabric = value_member(root, "fabric");
    struct json_value fraction = value_member(&fabric, "fiber_volume_fraction");
    struct json_value thickness = value_member(&fabric, "thickness");
    enum api_permeability_model model = request->permeability.model;
    if (model == API_PERMEABILITY_NONE ||
        (model == API_PERMEABILITY_TABLE && request->permeability.fractions == 0))
        return;
    if (!value_given(&fraction) && request->fabric.fiber_volume_fraction == 0)
        value_fault(&fraction, "is required by this permeability model");
    if (request->cavity.rigid && !value_given(&thickness) && request->fabric.thickness == 0)
        value_fault(&thickness, "is required by this permeability model in a rigid cavity");
}

static struct api_request default_request(const struct api_limits *limits) {
    return (struct api_request){
        .length_unit = &api_units[0],
        .fabric = {.locking_angle_deg = {-1, -1}, .plies = 1},
        .settings = {.method = DRAPE_GIB, .max_nodes = limits->max_nodes},
        .permeability = {.model = API_PERMEABILITY_NONE},
    };
}

void decode_drape(const struct json_value *json, const struct api_input *input,
                  const struct api_limits *limits, struct api_request *request) {
    static const char *const keys[] = {"surface",   "length_unit", "offset",     "fabric",
                                       "start",     "direction",   "generators", "method",
                                       "yarn_path", "extent",      "cavity",     "permeability",
                                       "rosette",   "cuts",        "energy",     NULL};
    static const char *const cavity_keys[] = {"height", NULL}, *const cavity_names[] = {"flexible"};
    int index;
    struct json_value cavity = value_member(json, "cavity"), offset = value_member(json, "offset");
    *request = default_request(limits);
    if (!value_object(json, keys))
        return;
    decode_ground(json, input, limits, request);
    decode_zero(json, request);
    if (value_given(&offset) && value_number(&offset, decode_coordinates, &request->offset) &&
        request->surface.kind == API_SURFACE_MESH && request->offset != 0)
        value_fault(&offset, "must be left out on a triangle mesh, whose curvature is not known");
    decode_cloth(json, request);
    if (value_type(&cavity) == VALUE_STRING) {
        value_choice(&cavity, cavity_names, 1, &index);
    } else if (value_given(&cavity)) {
        struct json_value height = value_member(&cavity, "height");
        request->cavity.rigid = true;
        if (value_object(&cavity, cavity_keys))
            value_number(&height, decode_lengths, &request->cavity.height);
    }
    check_permeability(json, request);
}

void decode_common(const struct json_value *json, const struct api_input *input,
                   const struct api_limits *limits, struct api_request *request) {
    *request = default_request(limits);
    decode_ground(json, input, limits, request);
    decode_zero(json, request);
}

void decode_ply(const struct json_value *json, struct api_request *request) {
    decode_cloth(json, request);
    check_permeability(json, request);
}

enum api_problem_id api_decode(const struct api_input *input, const struct api_limits *limits,
                               struct arena *arena, struct api_request *request,
                               struct api_problem *problem) {
    struct json_tree tree;
    const struct prepared_form *form = form_of_text(input, arena);
    if (form) {
        *request = form->request;
        request->settings.max_nodes = limits->max_nodes;
        return API_OK;
    }
    if (json_tree_parse(&tree, input->request, input->request_length, limits, arena, problem) !=
        API_OK)
        return problem->id;
    struct json_value root = value_root(&tree);
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
    struct json_value root = value_root(&tree), member = value_member(&root, "permeability");
    decode_permeability(value_given(&member) ? &member : &root, permeability);
    json_tree_free(&tree);
    return problem->id;
}

enum api_problem_id api_decode_surface(const char *bytes, size_t length,
                                       const struct api_limits *limits, struct arena *arena,
                                       struct api_surface *surface, struct api_problem *problem) {
    struct json_tree tree;
    if (json_tree_parse(&tree, bytes, length, limits, arena, problem) != API_OK)
        return problem->id;
    struct json_value root = value_root(&tree);
    decode_surface(&root, surface);
    check_point_count(&root, surface, limits);
    if (problem->id == API_OK && surface->kind == API_SURFACE_NAMED) {
        struct json_value degree = value_member(&root, "degree_u");
        value_fault(&degree, "is required: a definition, not an id");
    }
    json_tree_free(&tree);
    return problem->id;
}
