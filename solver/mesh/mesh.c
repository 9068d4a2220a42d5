/* SPDX-License-Identifier: MIT */
#include "mesh.h"

#include "topology.h"
#include "tree.h"

/* Beyond it products of four lengths overflow. */
static const double coordinate_max = 1e60;

/* A triangle whose height is less than this share of the coordinates' size has none but rounding:
 * its normal would be off by more than 1e-3. */
static const double height_of_rounding = 1e-13;

static enum status refuse_mesh(struct mesh_fault *fault, enum mesh_fault_kind kind, size_t index) {
    fault->kind = kind;
    fault->index = index;
    return STATUS_INVALID;
}

static enum status check_source(const struct mesh_source *source, struct mesh_fault *fault) {
    if (source->triangle_count == 0)
        return refuse_mesh(fault, MESH_FAULT_EMPTY, 0);
    if (source->triangle_count > INT32_MAX / 3 || source->vertex_count > INT32_MAX)
        return refuse_mesh(fault, MESH_FAULT_TOO_LARGE, 0);
    for (size_t i = 0; i < source->vertex_count; i++) {
        struct vec3 p = source->vertices[i];
        if (!(fabs(p.x) <= coordinate_max && fabs(p.y) <= coordinate_max &&
              fabs(p.z) <= coordinate_max))
            return refuse_mesh(fault, MESH_FAULT_VERTEX, i);
    }
    for (size_t t = 0; t < source->triangle_count; t++)
        for (int k = 0; k < 3; k++) {
            int32_t at = source->triangles[t][k];
            fault->corner = k;
            if (at < 0 || (size_t)at >= source->vertex_count)
                return refuse_mesh(fault, MESH_FAULT_INDEX, t);
        }
    return STATUS_OK;
}

/* And the box around its triangles. */
static enum status copy_source(const struct mesh_source *source, struct arena *arena,
                               struct mesh *mesh) {
    size_t n = source->triangle_count, m = source->vertex_count;
    mesh->triangle_count = n;
    mesh->vertex_count = m;
    mesh->vertices = arena_copy(arena, source->vertices, m, m, sizeof *mesh->vertices);
    mesh->corners = arena_copy(arena, source->triangles, n, n, sizeof *mesh->corners);
    mesh->twins = arena_alloc(arena, n, 3 * sizeof *mesh->twins);
    mesh->normals = arena_alloc(arena, n, sizeof *mesh->normals);
    mesh->component = arena_alloc(arena, n, sizeof *mesh->component);
    if (source->parameters)
        mesh->parameters = arena_copy(arena, source->parameters, m, m, sizeof *mesh->parameters);
    if (source->faces)
        mesh->faces = arena_copy(arena, source->faces, n, n, sizeof *mesh->faces);
    if (!mesh->vertices || !mesh->corners || !mesh->twins || !mesh->normals || !mesh->component ||
        (source->parameters && !mesh->parameters) || (source->faces && !mesh->faces))
        return STATUS_OUT_OF_MEMORY;
    struct vec3 low = mesh_corner_point(mesh, 0, 0), high = low;
    for (size_t t = 0; t < n; t++) /* vertices that no triangle has do not count */
        for (int k = 0; k < 3; k++) {
            struct vec3 p = mesh_corner_point(mesh, (int32_t)t, k);
            low = vec3_min(low, p);
            high = vec3_max(high, p);
        }
    mesh->lower = low;
    mesh->upper = high;
    mesh->size = vec3_distance(low, high);
    mesh->magnitude = fmax(fmax(fmax(-low.x, high.x), fmax(-low.y, high.y)),
                           fmax(fmax(-low.z, high.z), mesh->size));
    return STATUS_OK;
}

/* With a, b the edges at a corner, |a x b| is the longest edge times the smallest height. */
static enum status find_normals(struct mesh *mesh, double least_height, struct mesh_fault *fault) {
    double rounding = height_of_rounding * mesh->magnitude;
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        struct vec3 p[3];
        mesh_corner_points(mesh, (int32_t)t, p);
        struct vec3 a = vec3_sub(p[1], p[0]), b = vec3_sub(p[2], p[0]), cross = vec3_cross(a, b);
        double twice_area = vec3_norm(cross);
        double longest2 =
            fmax(fmax(vec3_norm2(a), vec3_norm2(b)), vec3_norm2(vec3_sub(p[2], p[1])));
        if (!(twice_area > rounding * sqrt(longest2)))
            return refuse_mesh(fault, MESH_FAULT_NO_AREA, t);
        if (!(twice_area > least_height * longest2))
            return refuse_mesh(fault, MESH_FAULT_SLIVER, t);
        mesh->normals[t] = vec3_scale(1 / twice_area, cross);
    }
    return STATUS_OK;
}

/* Areas and centroids of the components and of them all, and the sharpest edge. */
static enum status find_areas(struct mesh *mesh, struct arena *arena) {
    mesh->components = arena_alloc(arena, mesh->component_count, sizeof *mesh->components);
    mesh->sharpest = 1;
    if (!mesh->components)
        return STATUS_OUT_OF_MEMORY;
    for (size_t t = 0; t < mesh->triangle_count; t++) {
        struct mesh_component *component = &mesh->components[mesh->component[t]];
        struct vec3 p[3];
        mesh_corner_points(mesh, (int32_t)t, p);
        double area = mesh_twice_area(mesh, (int32_t)t) / 2;
        struct vec3 middle = vec3_scale(1.0 / 3, vec3_add(p[0], vec3_add(p[1], p[2])));
        component->triangle_count++;
        for (int k = 0; k < 3; k++) {
            int32_t twin = mesh->twins[3 * t + (size_t)k];
            component->rim_count += twin == MESH_NONE;
            if (twin != MESH_NONE)
                mesh->sharpest =
                    fmin(mesh->sharpest, vec3_dot(mesh->normals[t], mesh->normals[twin / 3]));
        }
        component->area += area;
        component->centroid = vec3_axpy(area, middle, component->centroid);
    }
    for (size_t k = 0; k < mesh->component_count; k++) {
        struct mesh_component *c = &mesh->components[k];
        c->centroid = vec3_scale(1 / c->area, c->centroid);
        mesh->area += c->area;
        mesh->centroid = vec3_axpy(c->area, c->centroid, mesh->centroid);
    }
    mesh->centroid = vec3_scale(1 / mesh->area, mesh->centroid);
    return STATUS_OK;
}

enum status mesh_make(const struct mesh_source *source, struct arena *arena, struct mesh **result,
                      struct mesh_fault *fault) {
    static const char *const reasons[] = {
#define X(id, reason) reason,
        MESH_FAULT_LIST(X)
#undef X
    };
    double least_height = source->least_height > 0 ? source->least_height : MESH_SLIVER;
    struct mesh_fault found = {0};
    struct mesh *mesh = *result = arena_alloc(arena, 1, sizeof *mesh);
    enum status status = mesh ? check_source(source, &found) : STATUS_OUT_OF_MEMORY;
    if (status == STATUS_OK)
        status = copy_source(source, arena, mesh);
    if (status == STATUS_OK)
        status = find_normals(mesh, least_height, &found);
    if (status == STATUS_OK)
        status = mesh_topology_find(mesh, arena, &found);
    if (status == STATUS_OK)
        status = find_areas(mesh, arena);
    if (status == STATUS_OK)
        status = mesh_tree_build(mesh, arena);
    if (status == STATUS_INVALID && fault) {
        *fault = found;
        fault->reason = reasons[found.kind];
    }
    return status;
}

void mesh_relocate(struct relocation *relocation, void *field) {
    struct mesh *mesh = relocate_once(relocation, field, 1, sizeof *mesh);
    if (!mesh)
        return;
    size_t vertices = mesh->vertex_count, triangles = mesh->triangle_count;
    relocate(relocation, &mesh->vertices, vertices, sizeof *mesh->vertices);
    relocate(relocation, &mesh->parameters, vertices, sizeof *mesh->parameters);
    relocate(relocation, &mesh->faces, triangles, sizeof *mesh->faces);
    relocate(relocation, &mesh->corners, triangles, sizeof *mesh->corners);
    relocate(relocation, &mesh->twins, triangles, 3 * sizeof *mesh->twins);
    relocate(relocation, &mesh->normals, triangles, sizeof *mesh->normals);
    relocate(relocation, &mesh->component, triangles, sizeof *mesh->component);
    relocate(relocation, &mesh->components, mesh->component_count, sizeof *mesh->components);
    relocate(relocation, &mesh->boxes, 2 * mesh->leaf_count - 1, sizeof *mesh->boxes);
    relocate(relocation, &mesh->order, triangles, sizeof *mesh->order);
}

int32_t mesh_largest_component(const struct mesh *mesh) {
    size_t largest = 0;
    for (size_t k = 1; k < mesh->component_count; k++)
        if (mesh->components[k].area > mesh->components[largest].area)
            largest = k;
    return (int32_t)largest;
}

/* With edges a, b at corner 0 and d = r - p_0 in the plane: the areas of the triangles that r makes
 * with two corners, over the whole. */
void mesh_weights(const struct mesh *mesh, const struct mesh_point *at, double weight[3]) {
    struct vec3 p[3], normal = mesh->normals[at->triangle];
    mesh_corner_points(mesh, at->triangle, p);
    struct vec3 a = vec3_sub(p[1], p[0]), b = vec3_sub(p[2], p[0]), d = vec3_sub(at->r, p[0]);
    double whole = vec3_dot(vec3_cross(a, b), normal);
    weight[1] = vec3_dot(vec3_cross(d, b), normal) / whole;
    weight[2] = vec3_dot(vec3_cross(a, d), normal) / whole;
    weight[0] = 1 - weight[1] - weight[2];
}

void mesh_parameters(const struct mesh *mesh, const struct mesh_point *at, double uv[2]) {
    double weight[3];
    uv[0] = at->triangle;
    uv[1] = 0;
    if (!mesh->parameters)
        return;
    mesh_weights(mesh, at, weight);
    const int32_t *corner = mesh->corners[at->triangle];
    for (int k = 0; k < 2; k++) {
        double a = mesh->parameters[corner[0]][k], b = mesh->parameters[corner[1]][k];
        double c = mesh->parameters[corner[2]][k];
        double x = weight[0] * a + weight[1] * b + weight[2] * c;
        uv[k] = fmin(fmax(x, fmin(a, fmin(b, c))), fmax(a, fmax(b, c))); /* but for rounding, x */
    }
}
