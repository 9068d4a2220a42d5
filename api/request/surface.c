/* SPDX-License-Identifier: MIT */
#include "parts.h"

#include <math.h>
#include <string.h>

_Static_assert(sizeof(struct vec3) == 3 * sizeof(double), "rows of three numbers are vectors");

/* Knots that differ by less than this share of the domain, but do differ, would make derivatives
 * overflow; it is far below the last digit of any knot but one near 0. */
static const double SPAN_LEAST = 1e-20;

void decode_control_find(const struct tree_place *owner, struct decode_control *control) {
    static const char *const keys[] = {"points", "weights", NULL};
    control->net = tree_member(owner, "control_points");
    if (tree_type(&control->net) != TREE_OBJECT) {
        control->points = control->net;
        control->weights = tree_member(owner, "weights");
        return;
    }
    tree_object(&control->net, keys);
    control->points = tree_member(&control->net, "points");
    control->weights = tree_member(&control->net, "weights");
    struct tree_place beside = tree_member(owner, "weights");
    if (tree_given(&beside))
        tree_fault(&beside, "must be in control_points, where the points are");
}

/* Where each part of a definition is, by `enum nurbs_part`. */
struct nurbs_places {
    struct decode_control control;
    struct tree_place part[NURBS_WEIGHTS + 1];
};

static void find_parts(const struct tree_place *place, struct nurbs_places *places) {
    static const char *const keys[] = {
        [NURBS_DEGREE_U] = "degree_u",    [NURBS_DEGREE_V] = "degree_v",
        [NURBS_SIZE_U] = "size_u",        [NURBS_SIZE_V] = "size_v",
        [NURBS_KNOTS_U] = "knotvector_u", [NURBS_KNOTS_V] = "knotvector_v",
    };
    decode_control_find(place, &places->control);
    for (size_t i = 0; i < sizeof keys / sizeof *keys; i++)
        places->part[i] = tree_member(place, keys[i]);
    places->part[NURBS_POINTS] = places->control.points;
    places->part[NURBS_WEIGHTS] = places->control.weights;
}

/* What `nurbs_validate` does not ask, but finite derivatives need. */
static bool check_spans(const struct nurbs_axis *axis, const struct tree_place *knots) {
    double domain = axis->knots[axis->size] - axis->knots[axis->degree];
    if (domain < decode_lengths.low) {
        tree_fault(knots, "the domain must be at least %g long", decode_lengths.low);
        return false;
    }
    for (size_t i = 1; i < axis->knot_count; i++) {
        double span = axis->knots[i] - axis->knots[i - 1];
        if (span > 0 && span < SPAN_LEAST * domain) {
            struct tree_place knot = tree_element(knots, i);
            tree_fault(&knot, "is too close to the knot before it, but not equal");
            return false;
        }
    }
    return true;
}

static bool fault_part(const struct nurbs_places *places, const struct nurbs_fault *fault) {
    const struct tree_place *place = &places->part[fault->part];
    struct tree_place element = tree_element(place, fault->index);
    tree_fault(fault->has_index ? &element : place, "%s", fault->reason);
    return false;
}

/* Checks one direction alone, so that its faults are found beside those of the rest: the other
 * one is a plain span, and the control points, which come last, are not looked at. */
static bool check_axis(const struct nurbs_places *places, const struct nurbs_axis *axis,
                       int direction) {
    static const double knots[] = {0, 0, 1, 1};
    static const struct nurbs_axis plain = {1, 2, knots, 4};
    struct nurbs nurbs = {.u = direction == 0 ? *axis : plain, .v = direction == 0 ? plain : *axis};
    struct nurbs_fault fault;
    if (nurbs_validate(&nurbs, &fault) != STATUS_OK && fault.part < NURBS_POINTS)
        return fault_part(places, &fault);
    return check_spans(axis, &places->part[direction == 0 ? NURBS_KNOTS_U : NURBS_KNOTS_V]);
}

static bool read_axis(const struct nurbs_places *places, int direction, struct nurbs_axis *axis) {
    const struct tree_place *part = places->part;
    bool ok = tree_integer(&part[direction == 0 ? NURBS_DEGREE_U : NURBS_DEGREE_V], 1,
                           NURBS_DEGREE_MAX, &axis->degree);
    ok = tree_integer(&part[direction == 0 ? NURBS_SIZE_U : NURBS_SIZE_V], 2, NURBS_SIZE_MAX,
                      &axis->size) &&
         ok;
    ok = tree_numbers(&part[direction == 0 ? NURBS_KNOTS_U : NURBS_KNOTS_V], decode_coordinates, 4,
                      &axis->knots, &axis->knot_count) &&
         ok;
    return ok && check_axis(places, axis, direction);
}

static bool read_control(const struct decode_control *control, struct nurbs *nurbs) {
    double *rows;
    bool ok = tree_rows(&control->points, decode_coordinates, 3, 4, &rows, &nurbs->point_count);
    if (ok)
        nurbs->points = (const void *)rows;
    if (tree_given(&control->weights))
        ok = tree_numbers(&control->weights, decode_lengths, 4, &nurbs->weights,
                          &nurbs->weight_count) &&
             ok;
    return ok;
}

/* One of the columns of control points, against the sizes where those are known. */
static bool check_count(const struct nurbs *nurbs, const struct tree_place *column, size_t count,
                        const char *noun) {
    size_t wanted = (size_t)nurbs->u.size * (size_t)nurbs->v.size;
    if (count == 0 || wanted == 0 || count == wanted)
        return true;
    tree_fault(column, "the number of %s must be size_u * size_v", noun);
    return false;
}

/* Weights that are all 1 say nothing. */
static void drop_unit_weights(struct nurbs *nurbs) {
    for (size_t i = 0; i < nurbs->weight_count; i++)
        if (nurbs->weights[i] != 1)
            return;
    nurbs->weights = NULL;
    nurbs->weight_count = 0;
}

static bool decode_nurbs(const struct tree_place *place, struct api_surface *surface) {
    static const char *const keys[] = {
        "degree_u", "degree_v", "size_u", "size_v", "knotvector_u", "knotvector_v",
        "control_points", "weights", "trims",
        /* written by geomdl, rw3dm, Sverchok or CurvesWB; they do not matter here */
        "type", "rational", "dimension", "pdimension", "delta", "sample_size", "name", "id", "bbox",
        "reversed", "precision", NULL};
    if (!tree_object(place, keys))
        return false;
    struct nurbs *nurbs = &surface->nurbs;
    struct nurbs_places places;
    struct nurbs_fault fault;
    find_parts(place, &places);
    bool ok = read_axis(&places, 0, &nurbs->u);
    ok = read_axis(&places, 1, &nurbs->v) && ok;
    ok = read_control(&places.control, nurbs) && ok;
    ok = check_count(nurbs, &places.control.points, nurbs->point_count, "control points") && ok;
    ok = check_count(nurbs, &places.control.weights, nurbs->weight_count, "weights") && ok;
    if (ok && nurbs_validate(nurbs, &fault) != STATUS_OK)
        ok = fault_part(&places, &fault);
    if (ok)
        drop_unit_weights(nurbs);
    struct tree_place trims = tree_member(place, "trims");
    if (tree_given(&trims))
        ok = decode_trims(&trims, surface) && ok;
    return ok;
}

const struct tree_place *decode_definition_find(const struct tree_place *surface,
                                                struct decode_definition *file) {
    file->shape = tree_member(surface, "shape");
    file->data = tree_member(&file->shape, "data");
    file->first = tree_element(&file->data, 0);
    return tree_given(&file->shape) ? &file->first : surface;
}

/* The file that geomdl's export_json writes. */
static bool decode_shape(const struct tree_place *place, struct api_surface *surface) {
    static const char *const file_keys[] = {"shape", NULL};
    static const char *const shape_keys[] = {"type", "count", "data", NULL};
    static const char *const types[] = {"surface"};
    struct decode_definition file;
    const struct tree_place *definition = decode_definition_find(place, &file);
    if (!tree_object(place, file_keys) || !tree_object(&file.shape, shape_keys))
        return false;
    struct tree_place type = tree_member(&file.shape, "type");
    struct tree_place count = tree_member(&file.shape, "count");
    int index = 0, surfaces = 1;
    bool ok = !tree_given(&type) || tree_choice(&type, types, 1, &index);
    ok = (!tree_given(&count) || tree_integer(&count, 1, NURBS_SIZE_MAX, &surfaces)) && ok;
    ok = tree_array(&file.data, 1) && ok;
    if (surfaces > 1 || tree_length(&file.data) > 1) {
        tree_fault(surfaces > 1 ? &count : &file.data,
                   "the file must hold one surface, and this one has more: send them one by one");
        return false;
    }
    return ok && decode_nurbs(definition, surface);
}

static bool read_triangle(const struct tree_place *place, const double *row, int32_t *triangle) {
    for (int k = 0; k < 3; k++) {
        if (row[k] != floor(row[k])) {
            tree_fault(place, "must be three whole numbers");
            return false;
        }
        triangle[k] = (int32_t)row[k];
    }
    if (triangle[0] != triangle[1] && triangle[1] != triangle[2] && triangle[2] != triangle[0])
        return true;
    tree_fault(place, "must name three different vertices");
    return false;
}

static bool read_triangles(const struct tree_place *place, struct api_mesh *mesh) {
    const struct tree_range indices = {0, (double)mesh->vertex_count - 1, false};
    double *rows;
    if (!tree_rows(place, indices, 3, 1, &rows, &mesh->triangle_count))
        return false;
    int32_t(*triangles)[3] = tree_alloc(place->tree, mesh->triangle_count, sizeof *triangles);
    if (!triangles)
        return false;
    for (size_t i = 0; i < mesh->triangle_count; i++) {
        struct tree_place triangle = tree_element(place, i);
        if (!read_triangle(&triangle, rows + 3 * i, triangles[i]))
            return false;
    }
    mesh->triangles = (const int32_t(*)[3])triangles;
    return true;
}

static bool decode_mesh(const struct tree_place *place, struct api_surface *surface) {
    static const char *const keys[] = {"vertices", "triangles", NULL};
    struct api_mesh *mesh = &surface->mesh;
    struct tree_place vertices = tree_member(place, "vertices");
    struct tree_place triangles = tree_member(place, "triangles");
    double *rows;
    surface->kind = API_SURFACE_MESH;
    tree_object(place, keys);
    if (!tree_rows(&vertices, decode_coordinates, 3, 3, &rows, &mesh->vertex_count))
        return false;
    mesh->vertices = (const void *)rows;
    return read_triangles(&triangles, mesh);
}

static bool decode_name(const struct tree_place *place, struct api_surface *surface) {
    struct tree_place id = tree_member(place, "id");
    const char *text;
    surface->kind = API_SURFACE_NAMED;
    if (!tree_string(&id, &text))
        return false;
    if (strlen(text) != API_ID_LENGTH || strspn(text, "0123456789abcdef") != API_ID_LENGTH) {
        tree_fault(&id, "must be the id of a stored surface: %d lower-case hex digits",
                   API_ID_LENGTH);
        return false;
    }
    memcpy(surface->id, text, API_ID_SIZE);
    return true;
}

static bool has(const struct tree_place *place, const char *key) {
    struct tree_place member = tree_member(place, key);
    return tree_given(&member);
}

bool decode_surface(const struct tree_place *place, struct api_surface *surface) {
    *surface = (struct api_surface){.kind = API_SURFACE_NURBS};
    if (has(place, "shape"))
        return decode_shape(place, surface);
    if (has(place, "vertices") || has(place, "triangles"))
        return decode_mesh(place, surface);
    if (has(place, "id") && tree_length(place) == 1)
        return decode_name(place, surface);
    return decode_nurbs(place, surface);
}
