/* SPDX-License-Identifier: MIT */
#include "part_foot.h"

#include "solver/mesh/mesh.h"
#include "solver/shell/shell.h"
#include "solver/shell/surface_point.h"

bool part_foot(const struct drape_part *part, struct vec3 r, struct vec3 *foot,
               struct vec3 *normal) {
    struct surface_cursor cursor = {0};
    struct surface_point at;
    double distance;
    bool found;
    if (part->mesh) {
        struct mesh_point near;
        found = mesh_nearest(part->mesh, r, MESH_ANY, &near, NULL);
        *foot = near.r;
        *normal = found ? part->mesh->normals[near.triangle] : *normal;
        return found;
    }
    if (part->shell) {
        struct shell_point near;
        shell_nearest(part->shell, r, SHELL_ANY, &near, &distance);
        found = surface_point_at(shell_surface(part->shell, near.face), &cursor, near.inner, &at);
    } else {
        found = surface_point_nearest(part->surface, &cursor, r, &at, &distance);
    }
    *foot = at.jet.r;
    *normal = found ? at.normal : *normal;
    return found;
}
