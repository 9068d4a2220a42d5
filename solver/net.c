/* SPDX-License-Identifier: MIT */
#include "net.h"

#include <stdlib.h>

enum { FIRST_SLOTS = 256 };

static size_t slot_of(const struct net *net, int32_t ti, int32_t tj) {
    uint64_t key = (uint64_t)(uint32_t)ti << 32 | (uint32_t)tj;
    key *= UINT64_C(0x9E3779B97F4A7C15); /* Fibonacci hashing */
    return (size_t)(key >> 32) & (net->slot_count - 1);
}

/* The slot that holds the tile, or the free one where it belongs. */
static struct net_tile **probe(const struct net *net, int32_t ti, int32_t tj) {
    size_t at = slot_of(net, ti, tj);
    while (net->slots[at] && (net->slots[at]->ti != ti || net->slots[at]->tj != tj))
        at = (at + 1) & (net->slot_count - 1);
    return &net->slots[at];
}

enum status net_make(struct net *net, struct arena *arena) {
    *net = (struct net){.arena = arena, .slot_count = FIRST_SLOTS};
    net->slots = arena_alloc(arena, FIRST_SLOTS, sizeof(struct net_tile *));
    return net->slots ? STATUS_OK : STATUS_OUT_OF_MEMORY;
}

static bool grow(struct net *net) {
    struct net old = *net;
    net->slot_count *= 2;
    net->slots = arena_alloc(net->arena, net->slot_count, sizeof(struct net_tile *));
    if (!net->slots) {
        *net = old;
        return false;
    }
    for (size_t k = 0; k < old.slot_count; k++)
        if (old.slots[k])
            *probe(net, old.slots[k]->ti, old.slots[k]->tj) = old.slots[k];
    return true;
}

static struct net_tile *find_tile(struct net *net, int32_t ti, int32_t tj) {
    struct net_tile *last = net->last;
    if (last && last->ti == ti && last->tj == tj)
        return last;
    struct net_tile *tile = *probe(net, ti, tj);
    if (tile)
        net->last = tile;
    return tile;
}

static struct net_node *in_tile(struct net_tile *tile, int32_t i, int32_t j) {
    return &tile->node[j & (NET_TILE - 1)][i & (NET_TILE - 1)];
}

struct net_node *net_find(struct net *net, int32_t i, int32_t j) {
    struct net_tile *tile = find_tile(net, i >> NET_TILE_BITS, j >> NET_TILE_BITS);
    return tile ? in_tile(tile, i, j) : NULL;
}

struct net_node *net_touch(struct net *net, int32_t i, int32_t j) {
    int32_t ti = i >> NET_TILE_BITS, tj = j >> NET_TILE_BITS;
    struct net_tile *tile = find_tile(net, ti, tj);
    if (!tile) {
        if (net->tile_count * 2 >= net->slot_count && !grow(net))
            return NULL;
        tile = arena_alloc(net->arena, 1, sizeof *tile);
        if (!tile)
            return NULL;
        tile->ti = ti;
        tile->tj = tj;
        *probe(net, ti, tj) = tile;
        net->tile_count++;
        net->last = tile;
    }
    return in_tile(tile, i, j);
}

struct net_window net_window(struct net *net, int32_t ti, int32_t tj) {
    struct net_window window;
    for (int row = 0; row < 3; row++)
        for (int column = 0; column < 3; column++)
            window.tile[row][column] = *probe(net, ti + column - 1, tj + row - 1);
    return window;
}

static int compare_tiles(const void *a, const void *b) {
    const struct net_tile *p = *(struct net_tile *const *)a, *q = *(struct net_tile *const *)b;
    if (p->tj != q->tj)
        return p->tj < q->tj ? -1 : 1;
    return (p->ti > q->ti) - (p->ti < q->ti);
}

struct net_tile **net_sorted_tiles(struct net *net) {
    struct net_tile **tiles = arena_alloc(net->arena, net->tile_count, sizeof *tiles);
    size_t count = 0;
    for (size_t k = 0; tiles && k < net->slot_count; k++)
        if (net->slots[k])
            tiles[count++] = net->slots[k];
    if (tiles)
        qsort(tiles, count, sizeof *tiles, compare_tiles);
    return tiles;
}
