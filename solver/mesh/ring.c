/* SPDX-License-Identifier: MIT */
#include "ring.h"

#include "solver/angle.h"

int32_t mesh_ring_next(const struct mesh *mesh, int32_t leaving) {
    return mesh->twins[mesh_previous_half(leaving)];
}

int32_t mesh_ring_previous(const struct mesh *mesh, int32_t leaving) {
    int32_t twin = mesh->twins[leaving];
    return twin == MESH_NONE ? MESH_NONE : mesh_next_half(twin);
}

double mesh_corner_angle(const struct mesh *mesh, int32_t half) {
    struct vec3 a = mesh_edge_vector(mesh, half);
    struct vec3 b = vec3_scale(-1, mesh_edge_vector(mesh, mesh_previous_half(half)));
    return angle_atan2_deg(vec3_norm(vec3_cross(a, b)), vec3_dot(a, b));
}

struct mesh_ring mesh_ring_make(const struct mesh *mesh, int32_t triangle, int corner) {
    int32_t asked = 3 * triangle + corner, at = asked, back;
    while ((back = mesh_ring_previous(mesh, at)) != MESH_NONE && back != asked)
        at = back;
    struct mesh_ring ring = {.mesh = mesh, .first = at, .closed = back == asked};
    if (ring.closed)
        ring.first = asked;
    at = ring.first;
    do {
        if (at == asked)
            ring.before = ring.total;
        ring.total += mesh_corner_angle(mesh, at);
        at = mesh_ring_next(mesh, at);
    } while (at != MESH_NONE && at != ring.first);
    return ring;
}

double mesh_ring_angle(const struct mesh *mesh, int32_t triangle, int corner,
                       struct vec3 direction) {
    struct vec3 x = vec3_unit(mesh_edge_vector(mesh, 3 * triangle + corner));
    struct vec3 y = vec3_cross(mesh->normals[triangle], x);
    return angle_atan2_deg(vec3_dot(direction, y), vec3_dot(direction, x));
}

void mesh_ring_direction(const struct mesh_ring *ring, double angle, int32_t *triangle, int *corner,
                         struct vec3 *direction) {
    const struct mesh *mesh = ring->mesh;
    int32_t at = ring->first;
    double here, sine, cosine;
    while (angle > (here = mesh_corner_angle(mesh, at))) {
        int32_t next = mesh_ring_next(mesh, at);
        if (next == MESH_NONE || next == ring->first) {
            angle = here;
            break;
        }
        angle -= here;
        at = next;
    }
    angle_sincos_deg(angle, &sine, &cosine);
    struct vec3 x = vec3_unit(mesh_edge_vector(mesh, at));
    struct vec3 y = vec3_cross(mesh->normals[at / 3], x);
    *triangle = at / 3;
    *corner = at % 3;
    *direction = vec3_axpy(sine, y, vec3_scale(cosine, x));
}
