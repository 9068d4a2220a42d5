/* SPDX-License-Identifier: MIT */
/* Where the net comes to lie on itself: looking for that node by node, and once it is done. */
#include "cuts.h"

#include <stdlib.h>
#include <string.h>

static struct vec3 normal_of_node(void *context, const struct net_node *node) {
    return march_normal_at(context, node);
}

/* An index of the net's nodes, of which there may come to be so many, and if `shaped` of the shapes
 * of its patches; without tiles that are apart by `what`, unless that is NULL. */
static enum status index_net(struct march *march, size_t count, bool shaped,
                             const enum overlap_tile *what) {
    struct net_tile **tiles = net_sorted_tiles(march->net);
    double turn[2];
    for (int k = 0; k < 2; k++)
        turn[k] = march->mesh || march->surface->shell ? HUGE_VAL
                                                       : surface_point_cut_turn(march->surface, k);
    march->overlap = overlap_make(march->net, count, march->settings->spacing, turn,
                                  march->cut.slit, march->cuts ? march->cuts->curtain : NULL,
                                  (struct overlap_normals){normal_of_node, march});
    enum status status = tiles && march->overlap ? STATUS_OK : STATUS_OUT_OF_MEMORY;
    for (size_t t = 0; status == STATUS_OK && t < net_tile_count(march->net); t++)
        if (!what || what[t] != OVERLAP_TILE_APART)
            status = overlap_add_tile(march->overlap, tiles[t], shaped);
    return status;
}

enum status march_watch_overlaps(struct march *march) {
    if (march->overlap)
        return STATUS_OK;
    const double *d = march->settings->spacing;
    /* Of a net that begins, with some for shear. */
    double nodes = fmin(1.4 * march_area(march) / (d[0] * d[1]), (double)march->max_nodes);
    return index_net(march, net_tile_count(march->net) ? march->counts.inside : (size_t)nodes,
                     false, NULL);
}

/* The next node inside of those patches of a tile, as bits, from number *k on; NULL: none. */
static const struct net_node *next_of_patches(const struct net_tile *tile, unsigned patches, int *k,
                                              int32_t *i, int32_t *j) {
    for (; patches && *k < NET_TILE * NET_TILE; ++*k) {
        int x = *k % NET_TILE, y = *k / NET_TILE;
        const struct net_node *node = &tile->node[y][x];
        if (!(patches >> overlap_patch_of(x, y) & 1) || node->state != NET_INSIDE)
            continue;
        *i = tile->ti * NET_TILE + x;
        *j = tile->tj * NET_TILE + y;
        ++*k;
        return node;
    }
    return NULL;
}

enum status march_find_overlap(struct march *march, bool *found) {
    struct overlap *watched = march->overlap;
    struct arena_mark mark = arena_mark(march->arena);
    struct net_tile **tiles = net_sorted_tiles(march->net);
    enum overlap_tile *what =
        tiles ? overlap_look(march->net, tiles, march->settings->spacing) : NULL;
    size_t count = net_tile_count(march->net), suspects = 0, indexed = 0;
    enum status status = what ? STATUS_OK : STATUS_OUT_OF_MEMORY;
    for (size_t t = 0; what && t < count; t++) {
        suspects += what[t] == OVERLAP_TILE_SUSPECT;
        indexed += what[t] != OVERLAP_TILE_APART;
    }
    if (suspects > 0)
        status = index_net(march, march->counts.inside * indexed / count, true, what);
    *found = false;
    for (size_t t = 0; status == STATUS_OK && t < count && suspects > 0 && !*found; t++) {
        if (what[t] != OVERLAP_TILE_SUSPECT)
            continue;
        unsigned patches = overlap_layers(march->overlap, tiles[t]);
        const struct net_node *node;
        struct surface_point point;
        int32_t i, j;
        for (int k = 0; !*found && (node = next_of_patches(tiles[t], patches, &k, &i, &j));)
            *found = overlap_is_near(march->overlap, i, j, node->r) &&
                     march_point_at(march, node, &point) &&
                     overlap_meets(march->overlap, i, j, &point);
    }
    march->overlap = watched;
    arena_rewind(march->arena, mark);
    return status;
}

/* A net that was looked over lies on itself about cells that are turned over alone. Of a node and
 * the corners of the cell on which it lies the one furthest from the start along the yarns goes. */
enum status march_separate_layers(struct march *march) {
    struct overlap *watched = march->overlap;
    struct net_tile **tiles;
    if (!march->counts.broken)
        return STATUS_OK;
    if (!(tiles = net_sorted_tiles(march->net)))
        return STATUS_OUT_OF_MEMORY;
    const struct overlap_normals normals = {normal_of_node, march};
    bool over = false;
    for (size_t t = 0; t < net_tile_count(march->net) && !over; t++)
        over = overlap_turns_over(march->net, tiles[t], march->settings->spacing, normals);
    if (!over)
        return STATUS_OK;
    enum status status = index_net(march, march->counts.inside, true, NULL);
    for (size_t t = 0; t < net_tile_count(march->net) && status == STATUS_OK; t++) {
        unsigned patches = overlap_layers(march->overlap, tiles[t]);
        const struct net_node *node;
        struct surface_point point;
        int32_t far[2], cell[2];
        for (int k = 0; status == STATUS_OK &&
                        (node = next_of_patches(tiles[t], patches, &k, &far[0], &far[1]));) {
            if (!march_point_at(march, node, &point) ||
                !overlap_lies_on(march->overlap, far[0], far[1], point.normal, cell))
                continue;
            for (int n = 0; n < 4; n++) {
                const int32_t at[2] = {cell[0] + (n & 1), cell[1] + n / 2};
                if (abs(at[0]) + abs(at[1]) > abs(far[0]) + abs(far[1]))
                    memcpy(far, at, sizeof far);
            }
            march->counts.inside--;
            status = march_fail(march, far[0], far[1], DRAPE_REASON_FOLD);
        }
    }
    march->overlap = watched;
    return status;
}
