/* SPDX-License-Identifier: MIT */
/* The four arms of the two generator yarns. */
#include "march.h"

#include "correction.h"
#include "fishnet_geodesic.h"
#include "rough.h"
#include "solver/surface/path.h"

static bool advance(const struct march *march, struct path *path, struct surface_cursor *cursor,
                    double d) {
    enum drape_method method = march->settings->method;
    if (method != DRAPE_GEODESIC)
        path_follow_net(path, d, method == DRAPE_GIB4 ? 4 : 2);
    return method == DRAPE_BASIC ? path_advance_chord(path, cursor, d) : path_advance(path, d);
}

/* Notes for march_place whether the edge to the neighbour on the side (di, dj), along which a path
 * went from `from` to `to` at `station`, is rough. */
static void note_edge(struct march *march, const struct path *from, const struct path *to, int di,
                      int dj, const struct station *station) {
    struct station start, end;
    struct vec3 leave, arrive;
    double d = march->settings->spacing[dj != 0], chord = d, curvature;
    march->edges.rough = 0;
    if (march->settings->method == DRAPE_BASIC ||
        !path_station(from, &march->cursor, &start, &leave) ||
        !path_station(to, &march->cursor, &end, &arrive))
        return;
    curvature = station_normal_curvature(&start, leave);
    if (rough_is_arc(&start, station, curvature, d) ||
        rough_edge(&start, station, curvature, d, &chord) < ROUGH_TOLD)
        return;
    int family = di ? 0 : 1, side = di + dj < 0, sign = side ? -1 : 1;
    struct vec3 a = vec3_scale(sign, fishnet_path_tangent(from, &start, leave));
    struct vec3 b = vec3_scale(sign, fishnet_path_tangent(to, station, arrive));
    march->edges.rough = NET_EDGE_BIT(family, side);
    march->edges.yarns.edge[family] = side ? (struct net_edge){b, a} : (struct net_edge){a, b};
}

bool march_straight_on(struct march *march, const struct station *from, struct vec3 direction,
                       int di, int dj, struct station *station) {
    struct path start, path;
    double d = march->settings->spacing[dj != 0];
    if (march->mesh)
        return march_mesh_straight_on(march, from, direction, di, dj, station);
    if (!path_geodesic(&start, from->surface, from, direction))
        return false;
    path = start;
    bool gone = advance(march, &path, &march->cursor, d) &&
                path_station(&path, &march->cursor, station, NULL);
    march->turned_back = path.ended;
    if (!gone)
        return false;
    note_edge(march, &start, &path, di, dj, station);
    return true;
}

/* A generator on one side of the start, nodes k (di, dj), k = 1, 2, .. */
struct arm {
    struct path path;
    struct march_mesh_yarn yarn; /* on a mesh of the caller's, instead of the path */
    struct station last;         /* on a mesh made of a surface: where the arm is on the mesh */
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
        arm.started = march_mesh_arm(march, generator, direction, &arm.yarn);
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
        return march_mesh_lay(march, &arm->yarn, arm->di, arm->dj, station, lost);
    *lost = false;
    if (!path_advance_chord(&arm->path, &march->cursor, d) ||
        !path_station(&arm->path, &march->cursor, &ahead, NULL) ||
        !march_mesh_towards(march, &arm->last, ahead.jet.r, d, station, lost))
        return false;
    arm->last = *station;
    return true;
}

/* To node k in a second march, the edge's chord being the corrected one like those of the yarns
 * beside it, so that they fit to the last order. False where there is none. */
static bool advance_corrected(struct march *march, struct arm *arm, int32_t k, double d,
                              struct station *station) {
    struct correction correction;
    struct station from;
    struct path path = arm->path;
    struct vec3 leave, arrive;
    double chord;
    int32_t i = (k - 1) * arm->di, j = (k - 1) * arm->dj;
    net_view_move(&march->before, i, j);
    if (!correction_find(&march->before, i, j, arm->di, arm->dj, d, &correction) ||
        !correction.whole || !correction_chord(&correction, &chord) ||
        !path_station(&path, &march->cursor, &from, &leave) ||
        !path_advance_chord(&path, &march->cursor, chord) ||
        !path_station(&path, &march->cursor, station, &arrive))
        return false;
    if (!correction_agrees(&correction, 0, &from, station_normal_curvature(&from, leave)) ||
        !correction_agrees(&correction, 1, station, station_normal_curvature(station, arrive)))
        return false;
    arm->path = path;
    return true;
}

/* To node k. */
static bool advance_arm(struct march *march, struct arm *arm, int32_t k, double d,
                        struct station *station, bool *lost) {
    *lost = false;
    if (march->mesh)
        return advance_on_mesh(march, arm, d, station, lost);
    if (march->before.net && advance_corrected(march, arm, k, d, station))
        return true;
    return advance(march, &arm->path, &march->cursor, d) &&
           path_station(&arm->path, &march->cursor, station, NULL);
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
    struct path before = arm->path;
    if (!arm->started || !advance_arm(march, arm, k, d, &station, &lost)) {
        lost = lost || arm->path.ended;
        return march_fail(march, i, j, lost ? DRAPE_REASON_NO_CONVERGENCE : DRAPE_REASON_BOUNDARY);
    }
    if (!march->mesh)
        note_edge(march, &before, &arm->path, arm->di, arm->dj, &station);
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
