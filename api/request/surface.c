/* SPDX-License-Identifier: MIT */
#include "members.h"
#include "solver/shell/shell.h"

#include <math.h>
#include <string.h>

const struct json_value *decode_definition_find(const struct json_value *surface,
                                                struct decode_definition *file) {
    file->shape = value_member(surface, "shape");
    file->data = value_member(&file->shape, "data");
    file->first = value_element(&file->data, 0);
    return value_given(&file->shape) ? &file->first : surface;
}

/* The file that geomdl's export_json writes. */
static bool decode_shape(const struct json_value *json, struct api_surface *surface) {
    static const char *const file_keys[] = {"shape", NULL};
    static const char *const shape_keys[] = {"type", "count", "data", NULL};
    static const char *const types[] = {"surface"};
    struct decode_definition file;
    const struct json_value *definition = decode_definition_find(json, &file);
    if (!value_object(json, file_keys) || !value_object(&file.shape, shape_keys))
        return false;
    struct json_value type = value_member(&file.shape, "type");
    struct json_value count = value_member(&file.shape, "count");
    int index = 0, surfaces = 1;
    bool ok = !value_given(&type) || value_choice(&type, types, 1, &index);
    ok = (!value_given(&count) || value_integer(&count, 1, SHELL_FACES_MAX, &surfaces)) && ok;
    ok = value_array(&file.data, 1) && ok;
    if (ok && value_given(&count) && (size_t)surfaces != value_length(&file.data)) {
        bool fewer = (size_t)surfaces > value_length(&file.data);
        return value_fault(fewer ? &count : &file.data,
                           "there are %zu surfaces, and the count is %d", value_length(&file.data),
                           surfaces);
    }
    if (ok && value_length(&file.data) > 1)
        return decode_faces(&file.data, surface);
    return ok && decode_nurbs(definition, false, surface);
}

static bool decode_mesh(const struct json_value *json, struct api_surface *surface) {
    static const char *const keys[] = {"vertices", "triangles", "length_unit", "notes", NULL};
    struct api_mesh *mesh = &surface->mesh;
    struct json_value vertices = value_member(json, "vertices");
    struct json_value list = value_member(json, "triangles");
    double *rows;
    surface->kind = API_SURFACE_MESH;
    value_object(json, keys);
    if (!decode_origin(json, surface) ||
        !value_rows(&vertices, decode_coordinates, 3, 3, &rows, &mesh->vertex_count))
        return false;
    mesh->vertices = (const void *)rows;
    const struct value_range indices = {0, (double)mesh->vertex_count - 1, false};
    if (!value_rows(&list, indices, 3, 1, &rows, &mesh->triangle_count))
        return false;
    int32_t(*triangles)[3] = json_tree_alloc(json->tree, mesh->triangle_count, sizeof *triangles);
    if (!triangles)
        return false;
    for (size_t i = 0; i < mesh->triangle_count; i++) {
        const double *row = rows + 3 * i;
        int32_t *corners = triangles[i];
        bool whole = true;
        for (int k = 0; k < 3; k++) {
            whole = whole && row[k] == floor(row[k]);
            corners[k] = (int32_t)row[k];
        }
        bool different =
            corners[0] != corners[1] && corners[1] != corners[2] && corners[2] != corners[0];
        if (whole && different)
            continue;
        struct json_value triangle = value_element(&list, i);
        return value_fault(&triangle, whole ? "must name three different vertices"
                                            : "must be three whole numbers");
    }
    mesh->triangles = (const int32_t(*)[3])triangles;
    return true;
}

static bool has(const struct json_value *json, const char *key) {
    struct json_value member = value_member(json, key);
    return value_given(&member);
}

bool decode_surface(const struct json_value *json, struct api_surface *surface) {
    struct json_value id = value_member(json, "id");
    const char *text;
    *surface = (struct api_surface){.kind = API_SURFACE_NURBS};
    if (has(json, "shape"))
        return decode_shape(json, surface);
    if (has(json, "vertices") || has(json, "triangles"))
        return decode_mesh(json, surface);
    if (value_given(&id) && !has(json, "degree_u") && !has(json, "control_points")) {
        surface->kind = API_SURFACE_NAMED;
        if (!value_string(&id, &text))
            return false;
        if (strlen(text) != API_ID_LENGTH || strspn(text, "0123456789abcdef") != API_ID_LENGTH)
            return value_fault(&id, "must be the id of a stored surface: %d lower-case hex digits",
                               API_ID_LENGTH);
        memcpy(surface->id, text, API_ID_SIZE);
        return decode_selection(json, surface);
    }
    if (has(json, "faces"))
        return decode_shell(json, surface);
    return decode_nurbs(json, false, surface);
}
