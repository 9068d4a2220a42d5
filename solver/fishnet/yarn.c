/* SPDX-License-Identifier: MIT */
#include "yarn.h"

#include "fishnet_geodesic.h"
#include "logarithm.h"
#include "solver/angle.h"
#include "solver/shell/shell.h"

/* The direction of a rough edge, as it was laid; false of another. */
static bool laid_edge(const struct yarn_net *yarns, const struct yarn_place *here,
                      const struct yarn_place *there, int family, int side, struct vec3 *leave) {
    bool own = here->node->rough & NET_EDGE_BIT(family, side);
    const struct yarn_place *laid = own ? here : there;
    if (!own && !(there->node->rough & NET_EDGE_BIT(family, 1 - side)))
        return false;
    const struct net_edge *edge =
        &net_yarns(yarns->net, laid->i, laid->j, laid->node)->edge[family];
    *leave = side ? edge->lower : vec3_scale(-1, edge->higher);
    return true;
}

static struct rough_end neighbour_end(const struct yarn_net *yarns, const struct yarn_place *there,
                                      const struct surface_point *point) {
    const struct surface *surface = yarns->surface;
    if (surface && surface->shell)
        surface = shell_surface(surface->shell, there->node->face);
    return (struct rough_end){surface, there->node->uv, there->node->r, point};
}

struct vec3 yarn_leave(const struct yarn_net *yarns, const struct yarn_place *here,
                       const struct yarn_place *there, int family, int side,
                       const struct surface_point *point) {
    struct vec3 leave;
    if (laid_edge(yarns, here, there, family, side, &leave))
        return leave;
    const struct rough_end end = neighbour_end(yarns, there, NULL);
    return rough_leave(yarns->cursor, point, &end, NULL);
}

/* Directions beside cuts are found to this. */
static const double beside_cut = 1e-7;

struct vec3 yarn_leave_well(const struct surface *surface, struct surface_cursor *cursor,
                            const struct surface_point *point, const struct rough_end *end) {
    struct vec3 leave = logarithm_leave(cursor, point, end), start = leave, arrive;
    double length = vec3_distance(point->jet.r, end->r);
    struct surface_point to;
    bool found =
        end->surface && surface_point_at(end->surface, cursor, end->uv, &to) &&
        fishnet_geodesic_between(surface, cursor, point, &to, beside_cut, &length, &start, &arrive);
    return found ? start : leave;
}

static struct yarn_place window_place(const struct net_window *window, int x, int y) {
    const struct net_tile *tile = window->tile[1][1];
    return (struct yarn_place){tile->ti * NET_TILE + x, tile->tj * NET_TILE + y,
                               net_window_place(window, x, y)};
}

/* The yarn's direction towards the higher index, by its neighbour on one side, which is at `next`
 * if that is known; zero where there is none. */
static struct vec3 onward(const struct yarn_net *yarns, const struct net_window *window, int x,
                          int y, int family, int side, const struct yarn_spot *next,
                          struct yarn_spot *spot) {
    struct vec3 *direction = &spot->onward[family][side];
    int step = side ? 1 : -1;
    if (spot->known & NET_EDGE_BIT(family, side))
        return *direction;
    spot->known |= NET_EDGE_BIT(family, side);
    struct yarn_place here = window_place(window, x, y);
    struct yarn_place there =
        window_place(window, x + (family == 0 ? step : 0), y + (family == 0 ? 0 : step));
    *direction = vec3_make(0, 0, 0);
    if (!there.node || net_is_parted_to(here.node, there.node, family, side))
        return *direction;
    struct vec3 leave;
    if (!laid_edge(yarns, &here, &there, family, side, &leave)) {
        const struct rough_end end = neighbour_end(yarns, &there, next ? &next->point : NULL);
        leave = here.node->beside
                    ? yarn_leave_well(yarns->surface, yarns->cursor, &spot->point, &end)
                    : logarithm_leave(yarns->cursor, &spot->point, &end);
    }
    *direction = vec3_scale(step, leave);
    return *direction;
}

/* From a to b about the normal, in degrees. */
static double angle_between(struct vec3 a, struct vec3 b, struct vec3 normal) {
    return angle_atan2_deg(vec3_dot(vec3_cross(a, b), normal), vec3_dot(a, b));
}

double yarn_node_angle(const struct yarn_net *yarns, const struct net_window *window, int x, int y,
                       struct yarn_spot *spot) {
    struct vec3 mean[2];
    for (int k = 0; k < 2; k++)
        mean[k] = vec3_add(onward(yarns, window, x, y, k, 0, NULL, spot),
                           onward(yarns, window, x, y, k, 1, NULL, spot));
    bool both = vec3_norm2(mean[0]) > 0 && vec3_norm2(mean[1]) > 0;
    return both ? fabs(angle_between(mean[0], mean[1], spot->point.normal)) : 90;
}

bool yarn_is_developable(const struct surface_point *point, const double spacing[2]) {
    static const double most = 1e-4;
    return fabs(surface_point_gauss_curvature(point)) * spacing[0] * spacing[1] < most;
}

bool yarn_cell_is_rough(const struct net_window *window, int x, int y) {
    const struct net_node *a = net_window_find(window, x, y);
    const struct net_node *b = net_window_find(window, x + 1, y);
    const struct net_node *c = net_window_find(window, x + 1, y + 1);
    const struct net_node *d = net_window_find(window, x, y + 1);
    return (a->rough & (NET_EDGE_BIT(0, 1) | NET_EDGE_BIT(1, 1))) ||
           (b->rough & (NET_EDGE_BIT(0, 0) | NET_EDGE_BIT(1, 1))) ||
           (c->rough & (NET_EDGE_BIT(0, 0) | NET_EDGE_BIT(1, 0))) ||
           (d->rough & (NET_EDGE_BIT(0, 1) | NET_EDGE_BIT(1, 0)));
}

/* The angles from warp to weft at the corners, in degrees. */
static void corner_angles(const struct yarn_net *yarns, const struct net_window *window, int x,
                          int y, struct yarn_spot *const corner[4], double angle[4]) {
    static const int8_t at[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    for (int k = 0; k < 4; k++) {
        int cx = x + at[k][0], cy = y + at[k][1];
        struct vec3 warp = onward(yarns, window, cx, cy, 0, 1 - at[k][0], corner[k ^ 1], corner[k]);
        struct vec3 weft = onward(yarns, window, cx, cy, 1, 1 - at[k][1], corner[3 - k], corner[k]);
        angle[k] = angle_between(warp, weft, corner[k]->point.normal);
    }
}

double yarn_cell_angle(const struct yarn_net *yarns, const struct net_window *window, int x, int y,
                       struct yarn_spot *const corner[4]) {
    double angle[4];
    corner_angles(yarns, window, x, y, corner, angle);
    return fabs(angle[0] + angle[1] + angle[2] + angle[3]) / 4;
}

bool yarn_cell_is_open(const struct yarn_net *yarns, const struct net_window *window, int x, int y,
                       struct yarn_spot *const corner[4]) {
    double angle[4];
    corner_angles(yarns, window, x, y, corner, angle);
    for (int k = 0; k < 4; k++)
        if (!(angle[k] * angle[0] > 0))
            return false;
    return true;
}
