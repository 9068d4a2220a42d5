/* SPDX-License-Identifier: MIT */
#include "march.h"

#include <stdlib.h>
#include <string.h>

/* A net of more ghosts than this for each node allowed is running away. */
static const size_t ghosts_per_node = 8, ghosts_least = 100000;

bool march_in_extent(const struct march *march, int32_t i, int32_t j) {
    const struct drape_settings *s = march->settings;
    return (!s->has_extent[0] || (i >= s->extent[0][0] && i <= s->extent[0][1])) &&
           (!s->has_extent[1] || (j >= s->extent[1][0] && j <= s->extent[1][1]));
}

enum status march_fail(struct march *march, int32_t i, int32_t j, enum drape_reason reason) {
    march->counts.broken = march->counts.broken || march_breaks_net(reason);
    struct net_node node = {.state = NET_FAILED, .reason = reason & NET_REASON_BITS};
    return net_put(march->net, i, j, &node);
}

bool march_parameters(const struct march *march, const struct surface_point *point, double uv[2]) {
    bool inside = true;
    if (!point->surface) {
        struct mesh_point place = march_mesh_point_of(point);
        mesh_parameters(march->mesh, &place, uv);
        return true;
    }
    for (int k = 0; k < 2; k++) {
        const struct surface_axis *axis = &point->surface->axis[k];
        double at = surface_axis_wrap(axis, point->uv[k]);
        inside = inside && at >= surface_axis_lower(axis) && at <= surface_axis_upper(axis);
        uv[k] = surface_axis_outer(axis, at);
    }
    return inside;
}

bool march_has_left(const struct march *march, const struct surface_point *point) {
    double uv[2];
    const struct trim *trim = march->trim;
    if (!march->mesh && march->surface->shell)
        trim = shell_trim(point->surface->shell, point->surface->face);
    return !trim || !march_parameters(march, point, uv) || !trim_near(trim, uv);
}

double march_area(const struct march *march) {
    struct vec3 centroid;
    const struct trim *trim = march->trim;
    if (trim)
        return trim_area(trim, &centroid);
    if (march->surface && march->surface->shell)
        return shell_area(march->surface->shell,
                          shell_component(march->surface->shell, march->surface->face), NULL);
    if (march->surface)
        return surface_area(march->surface, NULL);
    int32_t start = march_mesh_point_of(&march->start.point).triangle;
    return march->mesh->components[march->mesh->component[start]].area;
}

static double part_size(const struct march *march) {
    const struct surface *surface = march->surface;
    if (!surface)
        return HUGE_VAL;
    double gyration2 =
        march->trim ? trim_gyration2(march->trim)
        : surface->shell
            ? shell_gyration2(surface->shell, shell_component(surface->shell, surface->face))
            : surface_gyration2(surface);
    return sqrt(12 * gyration2);
}

/* The continuation is trusted up to this share of the part's size from it. */
static const double reach = 0.3;

double march_reach(const struct march *march) {
    return reach * march->size;
}

/* How often the net has passed each cut to its left on the way to (i, j), less the passages to its
 * right: by a neighbour, those towards the start first. */
static void count_turns(struct march *march, int32_t i, int32_t j,
                        const struct surface_point *point, int turns[2]) {
    const struct shell_slit_point to = {point->jet.r, point->normal};
    int si = i < 0 ? -1 : 1, sj = j < 0 ? -1 : 1;
    const int8_t sides[4][2] = {
        {(int8_t)-si, 0}, {0, (int8_t)-sj}, {(int8_t)si, 0}, {0, (int8_t)sj}};
    turns[0] = turns[1] = 0;
    if (!march->cut.slit[0] || (i == 0 && j == 0))
        return;
    for (int k = 0; k < 4; k++) {
        const struct net_node *node = march_node_at(march, i + sides[k][0], j + sides[k][1]);
        if (!node || (node->state != NET_INSIDE && node->state != NET_GHOST))
            continue;
        const struct shell_slit_point from = {node->r, march_normal_at(march, node)};
        turns[0] = node->turn + shell_slit_passes(march->cut.slit[0], &from, &to);
        if (march->cut.slit[1])
            turns[1] = node->across + shell_slit_passes(march->cut.slit[1], &from, &to);
        return;
    }
}

const struct crossing *march_look_over(struct march *march, const struct surface_point *point) {
    struct march_look *look = &march->look;
    if (look->surface != point->surface || look->uv[0] != point->uv[0] ||
        look->uv[1] != point->uv[1]) {
        look->surface = point->surface;
        memcpy(look->uv, point->uv, sizeof look->uv);
        crossing_find(point, NULL, &look->crossing);
    }
    return &look->crossing;
}

enum surface_point_zone march_zone(struct march *march, const struct surface_point *point,
                                   bool start, enum drape_reason *reason) {
    const double *cut_from = march->cut.passed ? point->uv : march->cut.centre;
    const struct trim *trim = march->trim;
    enum surface_point_zone zone = SURFACE_POINT_INSIDE;
    double uv[2];
    if (point->surface && point->surface->shell)
        zone = surface_point_zone_on_face(point, march_look_over(march, point), march_reach(march));
    else if (point->surface)
        zone = surface_point_zone(march->surface, &march->cursor, cut_from, point,
                                  march_reach(march), reason);
    if (zone != SURFACE_POINT_INSIDE || start || !trim)
        return zone;
    (void)march_parameters(march, point, uv);
    bool away = !trim_contains(trim, uv);
    for (int k = 0; k < 4 && away && point->surface; k++) {
        double beside[2];
        for (int axis = 0; axis < 2; axis++) {
            const double *outer = march->surface->axis[axis].outer;
            double by = SURFACE_POINT_BOUNDARY_WIDTH * (outer[1] - outer[0]);
            beside[axis] = fmin(fmax(uv[axis] + (k >> axis & 1 ? by : -by), outer[0]), outer[1]);
        }
        away = !trim_contains(trim, beside);
    }
    *reason = away ? DRAPE_REASON_BOUNDARY : *reason;
    return away ? SURFACE_POINT_GHOST : SURFACE_POINT_INSIDE;
}

enum status march_place(struct march *march, int32_t i, int32_t j,
                        const struct surface_point *point, enum surface_point_zone *zone) {
    enum drape_reason reason = DRAPE_REASON_BOUNDARY;
    *zone = march_zone(march, point, i == 0 && j == 0, &reason);
    bool beside = march_is_beside_cut(march, point->jet.r);
    march->edges.parted = beside ? march_find_parted(march, i, j, point) : 0;
    int turns[2];
    count_turns(march, i, j, point, turns);
    if (turns[0] != 0 || turns[1] != 0) {
        bool beyond = *zone == SURFACE_POINT_BEYOND || abs(turns[0]) > 1 || abs(turns[1]) > 1;
        *zone = beyond ? SURFACE_POINT_BEYOND : SURFACE_POINT_GHOST;
        reason = DRAPE_REASON_FOLD;
    }
    bool watched = march->overlap && !march->by_rows;
    if (*zone == SURFACE_POINT_INSIDE && watched && overlap_meets(march->overlap, i, j, point)) {
        *zone = SURFACE_POINT_BEYOND;
        reason = DRAPE_REASON_FOLD;
    }
    if (march->growing && *zone != SURFACE_POINT_BEYOND &&
        !march_joins(march, i, j, point, *zone)) {
        march->counts.out_of_step += *zone == SURFACE_POINT_INSIDE;
        reason = *zone == SURFACE_POINT_INSIDE ? DRAPE_REASON_FOLD : reason;
        *zone = SURFACE_POINT_BEYOND;
    }
    if (*zone == SURFACE_POINT_BEYOND)
        return march_fail(march, i, j, reason);
    struct net_node node = {.r = point->jet.r,
                            .uv = {point->uv[0], point->uv[1]},
                            .state = *zone == SURFACE_POINT_INSIDE ? NET_INSIDE : NET_GHOST,
                            .reason = reason & NET_REASON_BITS,
                            .turn = turns[0] > 0   ? 1
                                    : turns[0] < 0 ? -1
                                                   : 0,
                            .across = turns[1] > 0   ? 1
                                      : turns[1] < 0 ? -1
                                                     : 0,
                            .face = (uint16_t)march_face(march, point)};
    node.parted = march->edges.parted & 15u;
    node.beside = beside;
    node.rough = march->edges.rough & 63u;
    march->edges.rough = 0;
    enum status put = node.rough ? net_put_rough(march->net, i, j, &node, &march->edges.yarns)
                                 : net_put(march->net, i, j, &node);
    if (put != STATUS_OK)
        return put;
    *(*zone == SURFACE_POINT_INSIDE ? &march->counts.inside : &march->counts.ghosts) += 1;
    size_t most = march->max_nodes;
    if (march->counts.inside > most || march->counts.ghosts / ghosts_per_node > most + ghosts_least)
        return STATUS_TOO_MANY_NODES;
    return watched && *zone == SURFACE_POINT_INSIDE ? overlap_add(march->overlap, i, j, node.r)
                                                    : STATUS_OK;
}

/* An estimate of the share that is done: the area of the nodes so far. */
bool march_progress(struct march *march) {
    const struct drape_monitor *monitor = march->monitor;
    const double *d = march->settings->spacing;
    struct march_watch *watch = march->watch;
    if (!monitor || !monitor->progress)
        return true;
    atomic_fetch_add(&watch->inside, march->counts.inside - march->counts.reported);
    march->counts.reported = march->counts.inside;
    size_t inside = atomic_load(&watch->inside);
    if (!atomic_flag_test_and_set(&watch->busy)) {
        if (inside >= watch->next) {
            double expected = march_area(march) / (d[0] * d[1]);
            watch->next = inside + (size_t)fmin(expected / 200, 1e9) + 1;
            if (!monitor->progress(monitor->context, fmin((double)inside / expected, 0.99)))
                atomic_store(&watch->stopped, true);
        }
        atomic_flag_clear(&watch->busy);
    }
    return !atomic_load(&watch->stopped);
}

struct vec3 march_normal_at(struct march *march, const struct net_node *node) {
    struct surface_point point;
    return march_point_at(march, node, &point) ? point.normal : vec3_make(0, 0, 0);
}

/* Whether the net may come back to itself from any side: on a surface that closes over a pole, or
 * both ways. Others are cut open opposite the start (`surface_point_zone`). A mesh may do so
 * anywhere; a shell that is cut open both ways does so once it passes the cuts. */
static bool closes_all_round(const struct surface *surface) {
    const struct surface_axis *u = &surface->axis[0], *v = &surface->axis[1];
    if (surface->shell)
        return shell_may_close(surface->shell, surface->face);
    return (u->closed && (v->closed || v->pole[0] || v->pole[1])) ||
           (v->closed && (u->pole[0] || u->pole[1]));
}

/* A net that is not watched is given up when it has so many times the nodes that its cells would
 * have unsheared. */
static const double layers_most = 4;
static const size_t nodes_least = 1000;

/* Nets of a shell flatter than this hardly ever meet themselves. */
static const double flat_enough = 0.9;

/* One net. A shell may be a deep cup, whose nets meet themselves, as those round a tube do: unless
 * it is flat it is watched, but where a team marches the quadrants at the same time. A net that
 * lies on itself then is marched again and watched from its first node on; that of an open patch
 * does so only where it broke. Round the cup's wall one that is not watched may go on without an
 * end. */
static enum status march_net(struct march *march) {
    static const int8_t sides[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
    bool of_shell = !march->mesh && march->surface->shell, folded = false;
    march->size = part_size(march);
    memcpy(march->length, march->settings->spacing, sizeof march->length);
    bool deep =
        of_shell && shell_flatness(march->surface->shell, march->surface->face) < flat_enough;
    march->watched =
        march->watched || march->mesh || (deep && !march->settings->team) ||
        (!march->cut.slit[0] == !march->cut.slit[1] && closes_all_round(march->surface));
    const struct march begun = *march;
    bool unexpected = march->surface && !march->mesh && !march->watched;
    const double *d = march->settings->spacing;
    march->max_nodes = march->settings->max_nodes;
    if (unexpected) {
        double most = layers_most * (march_area(march) / (d[0] * d[1]));
        size_t unwatched = nodes_least + (size_t)fmin(most, (double)SIZE_MAX / 4);
        march->max_nodes = unwatched < march->max_nodes ? unwatched : march->max_nodes;
    }
    for (;;) {
        march->net = arena_alloc(march->arena, 1, sizeof *march->net);
        if (!march->net)
            return STATUS_OUT_OF_MEMORY;
        enum status status = net_make(march->net, march->arena, march->settings->team != NULL);
        if (status == STATUS_OK && march->watched)
            status = march_watch_overlaps(march);
        if (status == STATUS_OK)
            status = march_generators(march);
        if (status == STATUS_OK)
            status = march_quadrants(march);
        if (status == STATUS_OK)
            status = march_growth(march);
        /* All four yarns left the surface with their first step, although it is larger than a cell.
         */
        bool stuck = status == STATUS_OK && d[0] * d[1] < march_area(march);
        for (int k = 0; k < 4 && stuck; k++) {
            const struct net_node *next = net_find(march->net, sides[k][0], sides[k][1]);
            stuck = next && next->state == NET_FAILED && next->reason == DRAPE_REASON_BOUNDARY;
        }
        if (stuck)
            return STATUS_START_STUCK;
        if (unexpected && status == STATUS_OK && (of_shell || march->counts.broken))
            status = march_find_overlap(march, &folded);
        if (!unexpected || !(folded || status == STATUS_TOO_MANY_NODES))
            return status;
        *march = begun;
        march->max_nodes = march->settings->max_nodes;
        march->watched = true;
        unexpected = false;
    }
}

/* Ghosts beyond the last node inside: what the stencils of the shear angle reach, and in a first
 * march those of the correction beyond them. */
enum { FRINGE = 2, FRINGE_BEFORE = 4 };

/* A first net that is corrected has an arena of its own: the report needs it no longer than to take
 * the estimates from it. */
enum status march_run(struct march *march) {
    struct arena *arena = march->arena;
    if (!march->method->corrected) {
        march->fringe = FRINGE;
        return march_net(march);
    }
    const struct march_cut cut = march->cut;
    march->arena = arena_child(arena);
    march->fringe = FRINGE_BEFORE;
    if (!march->arena)
        return STATUS_OUT_OF_MEMORY;
    enum status status = march_net(march);
    if (status != STATUS_OK)
        return status;
    *march = (struct march){.surface = march->surface,
                            .trim = march->trim,
                            .cuts = march->cuts,
                            .cut = cut,
                            .settings = march->settings,
                            .method = march->method,
                            .monitor = march->monitor,
                            .arena = arena,
                            .start = march->start,
                            .first = march->net,
                            .before = net_view(march->net),
                            .watch = march->watch,
                            .watched = march->watched,
                            .fringe = FRINGE};
    return march_net(march);
}
