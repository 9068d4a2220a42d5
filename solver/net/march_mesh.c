/* SPDX-License-Identifier: MIT */
/* The march over flat triangles, for the method mosaic: what is different there. */
#include "march.h"

#include "solver/mesh/corner.h"

/* A generator's next place this near to the mesh, as a share of the chord, is on it. */
static const double beside_mesh = 0.02;

struct station march_mesh_station(const struct mesh *mesh, const struct mesh_place *place) {
    return (struct station){
        .uv = {place->triangle, 0}, .jet.r = place->r, .normal = mesh->normals[place->triangle]};
}

struct mesh_place march_mesh_place(const struct station *station) {
    return (struct mesh_place){.triangle = (int32_t)station->uv[0], .r = station->jet.r};
}

bool march_mesh_corner(struct march *march, const struct march_cell *at, struct vec3 guess,
                       struct fishnet_node *node, enum drape_reason *reason) {
    static const enum drape_reason reasons[] = {
        [MESH_CORNER_COLLAPSED] = DRAPE_REASON_COLLAPSED,
        [MESH_CORNER_BOUNDARY] = DRAPE_REASON_BOUNDARY,
        [MESH_CORNER_NO_CONVERGENCE] = DRAPE_REASON_NO_CONVERGENCE,
    };
    struct mesh_cell cell = {.a = march_mesh_place(at->a),
                             .b = march_mesh_place(at->b),
                             .c = march_mesh_place(at->c),
                             .bd = march->settings->spacing[0],
                             .cd = march->settings->spacing[1],
                             .guess = guess,
                             .orientation = at->si * at->sj};
    struct mesh_corner corner;
    enum mesh_corner_end end = mesh_corner_solve(march->mesh, &cell, &corner);
    if (end != MESH_CORNER_FOUND) {
        *reason = reasons[end];
        return false;
    }
    *node = (struct fishnet_node){.station = march_mesh_station(march->mesh, &corner.place),
                                  .iterations = corner.steps,
                                  .residual = corner.residual};
    return true;
}

bool march_mesh_arm(const struct march *march, const struct drape_generator *generator,
                    struct vec3 direction, struct mesh_walk *walk) {
    struct mesh_place from = march_mesh_place(&march->start.station);
    if (generator->kind == DRAPE_GENERATOR_PLANE)
        return mesh_walk_section(walk, march->mesh, &from, vec3_unit(generator->plane_normal),
                                 direction);
    return mesh_walk_straight(walk, march->mesh, &from, direction);
}

bool march_mesh_advance(struct mesh_walk *walk, double chord, struct station *station, bool *lost) {
    enum mesh_walk_end end = mesh_walk_chord(walk, chord);
    *lost = end == MESH_WALK_LOST;
    if (end == MESH_WALK_DONE)
        *station = march_mesh_station(walk->mesh, &walk->place);
    return end == MESH_WALK_DONE;
}

bool march_mesh_towards(struct march *march, const struct station *from, struct vec3 target,
                        double chord, struct station *station, bool *lost) {
    struct mesh_walk walk;
    struct mesh_place place = march_mesh_place(from);
    if (mesh_walk_towards(&walk, march->mesh, &place, target) &&
        march_mesh_advance(&walk, chord, station, lost))
        return true;
    /* Along a curved edge of the surface the way lies beside the mesh by the height of a patch:
     * there the nearest place is as good. */
    double distance;
    int32_t component = march->mesh->component[place.triangle];
    *lost = !mesh_nearest(march->mesh, target, component, &place, &distance);
    *station = march_mesh_station(march->mesh, &place);
    return !*lost && distance <= beside_mesh * chord;
}

bool march_mesh_straight_on(struct march *march, const struct station *from, struct vec3 direction,
                            double d, struct station *station) {
    struct mesh_walk walk;
    bool lost;
    struct mesh_place place = march_mesh_place(from);
    return mesh_walk_straight(&walk, march->mesh, &place, direction) &&
           march_mesh_advance(&walk, d, station, &lost);
}
