/* SPDX-License-Identifier: MIT */
#include "shape_mesh.h"

#include <stdio.h>

/* Where the fault lies in the request. */
static void add_fault(struct api_problem *problem, const struct mesh_fault *fault) {
    char pointer[API_POINTER_MAX];
    switch (fault->kind) {
    case MESH_FAULT_EMPTY:
    case MESH_FAULT_TOO_LARGE:
        (void)snprintf(pointer, sizeof pointer, "/surface/triangles");
        break;
    case MESH_FAULT_VERTEX:
        (void)snprintf(pointer, sizeof pointer, "/surface/vertices/%zu", fault->index);
        break;
    case MESH_FAULT_INDEX:
        (void)snprintf(pointer, sizeof pointer, "/surface/triangles/%zu/%d", fault->index,
                       fault->corner);
        break;
    default:
        (void)snprintf(pointer, sizeof pointer, "/surface/triangles/%zu", fault->index);
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

enum api_problem_id api_shape_mesh(const struct api_request *request,
                                   const struct api_limits *limits, struct arena *arena,
                                   struct mesh **mesh, struct api_problem *problem) {
    const struct api_mesh *from = &request->surface.mesh;
    const struct drape_settings *settings = &request->settings;
    struct mesh_source source = {.vertices = from->vertices,
                                 .vertex_count = from->vertex_count,
                                 .triangles = from->triangles,
                                 .triangle_count = from->triangle_count};
    struct mesh_fault fault;
    enum status status = mesh_make(&source, arena, mesh, &fault);
    if (status == STATUS_OUT_OF_MEMORY)
        api_problem_set(problem, API_OUT_OF_MEMORY, "the mesh needs more memory than allowed");
    else if (status != STATUS_OK)
        add_fault(problem, &fault);
    if (status != STATUS_OK)
        return problem->id;
    double nodes = largest_area(*mesh) / (settings->spacing[0] * settings->spacing[1]);
    if (nodes > (double)limits->max_nodes && !settings->has_extent[0] && !settings->has_extent[1])
        api_problem_add(problem, "/fabric/spacing",
                        "is too small: covering the mesh takes about %.3g nodes, and %zu are "
                        "allowed",
                        nodes, limits->max_nodes);
    return problem->id;
}
