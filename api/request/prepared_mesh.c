/* SPDX-License-Identifier: MIT */
#include "prepared_mesh.h"

#include "mesh_faces.h"
#include "prepared_form.h"
#include "prepared_surface.h"
#include <stdio.h>

/* `base` leads to the mesh in the caller's document, and to what is wrong with it from there. */
static enum api_problem_id make_mesh(const struct api_mesh *from, const char *base,
                                     struct arena *arena, struct mesh **mesh,
                                     struct api_problem *problem) {
    struct mesh_source source = {.vertices = from->vertices,
                                 .vertex_count = from->vertex_count,
                                 .triangles = from->triangles,
                                 .triangle_count = from->triangle_count};
    struct mesh_fault fault;
    char pointer[API_POINTER_MAX];
    enum status status = mesh_make(&source, arena, mesh, &fault);
    if (status == STATUS_OK)
        return API_OK;
    if (status == STATUS_OUT_OF_MEMORY)
        return api_problem_no_memory(problem, "the mesh");
    bool of_vertex = fault.kind == MESH_FAULT_VERTEX;
    int length =
        snprintf(pointer, sizeof pointer, "%s/%s", base, of_vertex ? "vertices" : "triangles");
    if (fault.kind != MESH_FAULT_EMPTY && fault.kind != MESH_FAULT_TOO_LARGE)
        length += snprintf(pointer + length, sizeof pointer - (size_t)length, "/%zu", fault.index);
    if (fault.kind == MESH_FAULT_INDEX)
        (void)snprintf(pointer + length, sizeof pointer - (size_t)length, "/%d", fault.corner);
    return api_problem_add(problem, pointer, "%s", fault.reason);
}

enum api_problem_id prepared_mesh_make(const struct api_request *request,
                                       const struct api_limits *limits, struct arena *arena,
                                       const struct mesh **mesh, struct api_problem *problem) {
    const struct drape_settings *settings = &request->settings;
    const struct prepared_part *ready = prepared_form_part(request);
    struct mesh *made = NULL;
    double largest = 0;
    if (!ready && (make_mesh(&request->surface.mesh, "/surface", arena, &made, problem) != API_OK ||
                   mesh_faces_choose(&request->surface.selection, arena, &made, problem) != API_OK))
        return problem->id;
    *mesh = ready ? ready->part.mesh : made;
    for (size_t k = 0; k < (*mesh)->component_count; k++)
        largest = fmax(largest, (*mesh)->components[k].area);
    if (settings->has_extent[0] || settings->has_extent[1])
        return API_OK;
    return prepared_surface_check_nodes(largest / (settings->spacing[0] * settings->spacing[1]),
                                        "the mesh", limits, problem);
}

enum api_problem_id prepared_mesh_make_whole(const struct api_surface *surface, struct arena *arena,
                                             const struct mesh **mesh,
                                             struct api_problem *problem) {
    struct mesh *made = NULL;
    enum api_problem_id id = make_mesh(&surface->mesh, "", arena, &made, problem);
    *mesh = made;
    return id;
}

enum api_problem_id prepared_mesh_describe(const struct api_surface *surface,
                                           const struct mesh *mesh, struct api_text *text,
                                           struct arena *arena, struct api_problem *problem) {
    size_t rim = 0;
    for (size_t k = 0; k < mesh->component_count; k++)
        rim += mesh->components[k].rim_count;
    api_text_key_integer(text, "vertices", (int64_t)surface->mesh.vertex_count);
    api_text_key_integer(text, "triangles", (int64_t)mesh->triangle_count);
    if (!mesh_faces_describe(mesh, arena, text))
        return api_problem_no_memory(problem, "the faces");
    api_text_key_object(text, "edges");
    api_text_key_integer(text, "shared", (int64_t)((3 * mesh->triangle_count - rim) / 2));
    api_text_key_integer(text, "free", (int64_t)rim);
    api_text_key_integer(text, "faulty", 0);
    api_text_key_number(text, "largest_gap", 0);
    api_text_raw(text, "}");
    api_text_key_integer(text, "components", (int64_t)mesh->component_count);
    api_text_box(text, &mesh->lower.x, &mesh->upper.x);
    api_text_key_number(text, "area", mesh->area);
    return API_OK;
}
