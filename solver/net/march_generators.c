/* SPDX-License-Identifier: MIT */
/* The four arms of the two generator yarns. */
#include "march.h"

#include "correction.h"
#include "solver/surface/path.h"

static bool advance(const struct march *march, struct path *path, struct surface_cursor *cursor,
                    double d) {
    if (march->settings->method != DRAPE_GEODESIC)
        path_follow_net(path, d);
    return march->settings->method == DRAPE_BASIC ? path_advance_chord(path, cursor, d)
                                                  : path_advance(path, d);
}

bool march_straight_on(struct march *march, const struct station *from, struct vec3 direction,
                       double d, struct station *station) {
    struct path path;
    if (march->mesh)
        return march_mesh_straight_on(march, from, direction, d, station);
    return path_geodesic(&path, march->surface, from, direction) &&
           advance(march, &path, &march->cursor, d) &&
           path_station(&path, &march->cursor, station, NULL);
}

/* A generator on one side of the start, nodes k (di, dj), k = 1, 2, .. */
struct arm {
    struct path path;
    struct mesh_walk walk; /* on a mesh of the caller's, instead of the path */
    struct station last;   /* on a mesh made of a surface: where the arm is on the mesh */
    int di, dj;
    bool started, ended;
};

/* An arm along a polyline from the start on; where its points end, a geodesic. */
static bool start_curve(const struct march *march, int k, int sign, struct vec3 direction,
                        struct path *path) {
    const struct drape_generator *generator = &march->settings->generator[k];
    const struct march_curve *curve = &march->start.curve[k];
    int sense = sign * curve->sense, side = sense > 0 ? 0 : 1;
    if (curve->ends[side])
        return path_geodesic(path, march->surface, &curve->from, direction);
    return path_curve(path, march->surface, &curve->from, generator->curve, generator->curve_count,
                      curve->next[side], sense);
}

static struct arm make_arm(const struct march *march, int number) {
    int sign = number % 2 ? -1 : 1, k = number / 2;
    const struct drape_generator *generator = &march->settings->generator[k];
    const struct march_start *start = &march->start;
    const struct station *from = march->mesh ? &start->smooth : &start->station;
    struct vec3 direction = vec3_scale(sign, k == 0 ? start->warp : start->weft);
    struct arm arm = {.di = k == 0 ? sign : 0, .dj = k == 0 ? 0 : sign, .last = start->station};
    if (march->mesh && march->surface)
        direction = vec3_scale(sign, start->smooth_direction[k]);
    if (!march->surface)
        arm.started = march_mesh_arm(march, generator, direction, &arm.walk);
    else if (generator->kind == DRAPE_GENERATOR_CURVE)
        arm.started = start_curve(march, k, sign, direction, &arm.path);
    else if (generator->kind == DRAPE_GENERATOR_PLANE)
        arm.started = path_section(&arm.path, march->surface, from,
                                   vec3_unit(generator->plane_normal), direction);
    else
        arm.started = path_geodesic(&arm.path, march->surface, from, direction);
    return arm;
}

/* To the next node on a mesh: along the generator of the surface it was made of, if there is one.
 */
static bool advance_on_mesh(struct march *march, struct arm *arm, double d, struct station *station,
                            bool *lost) {
    struct station ahead;
    if (!march->surface)
        return march_mesh_advance(&arm->walk, d, station, lost);
    *lost = false;
    if (!path_advance_chord(&arm->path, &march->cursor, d) ||
        !path_station(&arm->path, &march->cursor, &ahead, NULL) ||
        !march_mesh_towards(march, &arm->last, ahead.jet.r, d, station, lost))
        return false;
    arm->last = *station;
    return true;
}

/* To node k. In a second march the edge's chord is the corrected one, like those of the yarns
 * beside it, so that they fit to the last order. */
static bool advance_arm(struct march *march, struct arm *arm, int32_t k, double d,
                        struct station *station, bool *lost) {
    double chord;
    *lost = false;
    if (march->mesh)
        return advance_on_mesh(march, arm, d, station, lost);
    int32_t i = (k - 1) * arm->di, j = (k - 1) * arm->dj;
    bool corrected = march->before.net != NULL;
    if (corrected) {
        net_view_move(&march->before, i, j);
        corrected = correction_chord(&march->before, i, j, arm->di, arm->dj, d, &chord);
    }
    bool moved = corrected ? path_advance_chord(&arm->path, &march->cursor, chord)
                           : advance(march, &arm->path, &march->cursor, d);
    return moved && path_station(&arm->path, &march->cursor, station, NULL);
}

static enum status grow_arm(struct march *march, struct arm *arm, int32_t k) {
    struct station station;
    enum station_zone zone;
    int32_t i = k * arm->di, j = k * arm->dj;
    double d = march->settings->spacing[arm->dj != 0];
    arm->ended = true;
    if (!march_in_extent(march, i, j))
        return march_fail(march, i, j, DRAPE_REASON_EXTENT);
    bool lost = false;
    if (!arm->started || !advance_arm(march, arm, k, d, &station, &lost))
        return march_fail(march, i, j, lost ? DRAPE_REASON_NO_CONVERGENCE : DRAPE_REASON_BOUNDARY);
    enum status status = march_place(march, i, j, &station, &zone);
    arm->ended = zone == STATION_BEYOND;
    return status;
}

/* All four side by side, so that on a closed surface they meet half way. */
enum status march_generators(struct march *march) {
    struct arm arms[4];
    enum station_zone zone;
    enum status status = march_place(march, 0, 0, &march->start.station, &zone);
    for (int a = 0; a < 4; a++)
        arms[a] = make_arm(march, a);
    bool going = true;
    for (int32_t k = 1; going && status == STATUS_OK; k++) {
        going = false;
        for (int a = 0; a < 4 && status == STATUS_OK; a++) {
            if (!arms[a].ended)
                status = grow_arm(march, &arms[a], k);
            going = going || !arms[a].ended;
        }
    }
    return status;
}
