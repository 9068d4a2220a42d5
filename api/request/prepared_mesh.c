/* SPDX-License-Identifier: MIT */
#include "prepared_mesh.h"

#include <stdio.h>

/* Where the fault lies in the request. */
static void add_fault(struct api_problem *problem, const char *base,
                      const struct mesh_fault *fault) {
    char pointer[API_POINTER_MAX];
    switch (fault->kind) {
    case MESH_FAULT_EMPTY:
    case MESH_FAULT_TOO_LARGE:
        (void)snprintf(pointer, sizeof pointer, "%s/triangles", base);
        break;
    case MESH_FAULT_VERTEX:
        (void)snprintf(pointer, sizeof pointer, "%s/vertices/%zu", base, fault->index);
        break;
    case MESH_FAULT_INDEX:
        (void)snprintf(pointer, sizeof pointer, "%s/triangles/%zu/%d", base, fault->index,
                       fault->corner);
        break;
    default:
        (void)snprintf(pointer, sizeof pointer, "%s/triangles/%zu", base, fault->index);
        break;
    }
    api_problem_add(problem, pointer, "%s", fault->reason);
}

static double largest_area(const struct mesh *mesh) {
    double largest = 0;
    for (size_t k = 0; k < mesh->component_count; k++)
        largest = fmax(largest, mesh->components[k].area);
    return largest;
}

/* `base` leads to the mesh in the caller's document. */
static enum api_problem_id make(const struct api_mesh *from, const char *base, struct arena *arena,
                                struct mesh **mesh, struct api_problem *problem) {
    struct mesh_source source = {.vertices = from->vertices,
                                 .vertex_count = from->vertex_count,
                                 .triangles = from->triangles,
                                 .triangle_count = from->triangle_count};
    struct mesh_fault fault;
    enum status status = mesh_make(&source, arena, mesh, &fault);
    if (status == STATUS_OUT_OF_MEMORY)
        api_problem_set(problem, API_OUT_OF_MEMORY, "the mesh needs more memory than allowed");
    else if (status != STATUS_OK)
        add_fault(problem, base, &fault);
    return problem->id;
}

enum api_problem_id prepared_mesh_make(const struct api_request *request,
                                       const struct api_limits *limits, struct arena *arena,
                                       struct mesh **mesh, struct api_problem *problem) {
    const struct drape_settings *settings = &request->settings;
    if (make(&request->surface.mesh, "/surface", arena, mesh, problem) != API_OK)
        return problem->id;
    double nodes = largest_area(*mesh) / (settings->spacing[0] * settings->spacing[1]);
    if (nodes > (double)limits->max_nodes && !settings->has_extent[0] && !settings->has_extent[1])
        api_problem_add(problem, "/fabric/spacing",
                        "is too small: covering the mesh takes about %.3g nodes, and %zu are "
                        "allowed",
                        nodes, limits->max_nodes);
    return problem->id;
}

static void write_vector(struct api_text *text, const char *key, struct vec3 v) {
    api_text_key_numbers(text, key, (const double[]){v.x, v.y, v.z}, 3);
}

static void write_box(struct api_text *text, const struct mesh *mesh) {
    api_text_key(text, "bounding_box");
    api_text_raw(text, "[");
    api_text_numbers(text, &mesh->lower.x, 3);
    api_text_raw(text, ",");
    api_text_numbers(text, &mesh->upper.x, 3);
    api_text_raw(text, "]");
}

/* The mesh as the one face of itself. */
static void write_face(struct api_text *text, const struct mesh *mesh) {
    struct vec3 normal = {0};
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        struct vec3 p[3];
        mesh_corner_points(mesh, (int32_t)t, p);
        normal = vec3_add(normal, vec3_cross(vec3_sub(p[1], p[0]), vec3_sub(p[2], p[0])));
    }
    double length = vec3_norm(normal);
    api_text_key(text, "faces");
    api_text_raw(text, "[{");
    api_text_key_integer(text, "index", 0);
    api_text_key_number(text, "area", mesh->area);
    write_box(text, mesh);
    write_vector(text, "centre", mesh->centroid);
    write_vector(text, "normal", vec3_scale(length > 1e-9 * mesh->area ? 1 / length : 0, normal));
    api_text_key_string(text, "kind", "mesh");
    api_text_raw(text, "}]");
}

static void write_edges(struct api_text *text, const struct mesh *mesh) {
    size_t rim = 0;
    for (size_t k = 0; k < mesh->component_count; k++)
        rim += mesh->components[k].rim_count;
    api_text_key_object(text, "edges");
    api_text_key_integer(text, "shared", (int64_t)((3 * mesh->triangle_count - rim) / 2));
    api_text_key_integer(text, "free", (int64_t)rim);
    api_text_key_integer(text, "faulty", 0);
    api_text_key_number(text, "largest_gap", 0);
    api_text_raw(text, "}");
}

enum api_problem_id prepared_mesh_describe(const struct api_surface *surface, struct api_text *text,
                                           struct arena *arena, struct api_problem *problem) {
    struct mesh *mesh;
    if (make(&surface->mesh, "", arena, &mesh, problem) != API_OK)
        return problem->id;
    api_text_key_integer(text, "vertices", (int64_t)surface->mesh.vertex_count);
    api_text_key_integer(text, "triangles", (int64_t)mesh->triangle_count);
    write_face(text, mesh);
    write_edges(text, mesh);
    api_text_key_integer(text, "components", (int64_t)mesh->component_count);
    write_box(text, mesh);
    api_text_key_number(text, "area", mesh->area);
    return API_OK;
}
