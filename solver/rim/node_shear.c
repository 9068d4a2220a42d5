/* SPDX-License-Identifier: MIT */
#include "node_shear.h"

#include "solver/fishnet/yarn.h"

/* So many places across are kept at the most: those along the rim of a net of a thousand nodes. */
enum { LEAST_ACROSS = 8, MOST_ACROSS = 32 };

enum status node_shear_make(struct march *march, const struct drape_nodes *nodes,
                            struct node_shear *shear) {
    int32_t across = LEAST_ACROSS;
    while (across < MOST_ACROSS && (size_t)(across * across) < 2 * nodes->count)
        across *= 2;
    *shear = (struct node_shear){
        .march = march,
        .nodes = nodes,
        .view = net_view(march->net),
        .places = arena_alloc(march->arena, (size_t)(across * across), sizeof *shear->places),
        .across = across};
    return shear->places ? STATUS_OK : STATUS_OUT_OF_MEMORY;
}

/* The angle between the yarns of a ghost. On a shell its neighbours, as far as it has them, have to
 * lie on its own face: what goes on beyond the end of a joint is on neither of two faces. */
static bool measure_ghost(struct node_shear *shear, struct node_shear_place *ghost) {
    static const int8_t sides[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
    struct march *march = shear->march;
    struct yarn_spot spot = {.filled = true};
    struct yarn_net net = {march->net, march->surface, &march->cursor};
    if (march->mesh || !march_point(march, ghost->i, ghost->j, &spot.point))
        return false;
    net_view_move(&shear->view, ghost->i, ghost->j);
    int x = ghost->i - shear->view.ti * NET_TILE, y = ghost->j - shear->view.tj * NET_TILE;
    for (int k = 0; k < 4 && march->surface->shell; k++) {
        const struct net_node *node =
            net_window_place(&shear->view.window, x + sides[k][0], y + sides[k][1]);
        if (node && node->face != spot.point.surface->face)
            return false;
    }
    ghost->shear_deg = 90 - yarn_node_angle(&net, &shear->view.window, x, y, &spot);
    for (int k = 0; k < 2; k++)
        if (!(vec3_norm2(vec3_add(spot.onward[k][0], spot.onward[k][1])) > 0))
            return false;
    return true;
}

bool node_shear_between(struct node_shear *shear, double p, double q, double *shear_deg) {
    const struct drape_nodes *n = shear->nodes;
    double x = p - floor(p), y = q - floor(q), weights = 0, sum = 0;
    int32_t last = shear->across - 1;
    for (int k = 0; k < 4; k++) {
        double weight = (k & 1 ? x : 1 - x) * (k / 2 ? y : 1 - y);
        int32_t i = (int32_t)floor(p) + (k & 1), j = (int32_t)floor(q) + k / 2;
        struct node_shear_place *place = &shear->places[(j & last) * shear->across + (i & last)];
        if (weight == 0)
            continue;
        if (!place->searched || place->i != i || place->j != j) {
            size_t low = 0, high = n->count; /* of the row of the node */
            while (low < high) {
                size_t middle = low + (high - low) / 2;
                bool before = n->j[middle] < j || (n->j[middle] == j && n->i[middle] < i);
                low = before ? middle + 1 : low;
                high = before ? high : middle;
            }
            *place = (struct node_shear_place){.i = i, .j = j, .searched = true};
            place->known = low < n->count && n->i[low] == i && n->j[low] == j;
            if (place->known)
                place->shear_deg = n->shear_deg[low];
            else
                place->known = measure_ghost(shear, place);
        }
        if (!place->known)
            continue;
        sum += weight * place->shear_deg;
        weights += weight;
    }
    *shear_deg = weights > 0 ? sum / weights : 0;
    return weights > 0;
}
