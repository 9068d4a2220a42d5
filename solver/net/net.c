/* SPDX-License-Identifier: MIT */
#include "net.h"

#include <stdlib.h>

enum { FIRST_SLOTS = 256 };

/* The slot that holds the tile, or the free one where it belongs. */
static struct net_tile **probe(const struct net_table *table, int32_t ti, int32_t tj) {
    uint64_t key = (uint64_t)(uint32_t)ti << 32 | (uint32_t)tj;
    key *= UINT64_C(0x9E3779B97F4A7C15); /* Fibonacci hashing */
    size_t at = (size_t)(key >> 32) & (table->slot_count - 1);
    while (table->slots[at] && (table->slots[at]->ti != ti || table->slots[at]->tj != tj))
        at = (at + 1) & (table->slot_count - 1);
    return &table->slots[at];
}

enum status net_make(struct net *net, struct arena *arena, bool divided) {
    *net = (struct net){.arena = arena};
    for (int k = 0; k < NET_TABLES; k++) {
        struct net_table *table = &net->table[k];
        table->arena = divided ? arena_child(arena) : arena;
        table->slot_count = FIRST_SLOTS;
        table->slots =
            table->arena ? arena_alloc(table->arena, FIRST_SLOTS, sizeof *table->slots) : NULL;
        if (!table->slots)
            return STATUS_OUT_OF_MEMORY;
    }
    return STATUS_OK;
}

void net_free(struct net *net) {
    struct arena *arena = net->arena;
    for (int k = 0; k < NET_TABLES; k++)
        if (net->table[k].arena != arena)
            arena_rewind(net->table[k].arena, (struct arena_mark){0});
    arena_rewind(arena, (struct arena_mark){0});
}

struct net_tile *net_seek(struct net_table *table, int32_t ti, int32_t tj) {
    struct net_tile *tile = *probe(table, ti, tj);
    if (tile)
        table->last = tile;
    return tile;
}

struct net_tile *net_touch(struct net *net, int32_t i, int32_t j) {
    int32_t ti = i >> NET_TILE_BITS, tj = j >> NET_TILE_BITS;
    struct net_table *table = &net->table[net_table_of(ti, tj)];
    struct net_tile *tile = net_find_tile(table, ti, tj);
    if (tile)
        return tile;
    if (table->tile_count * 2 >= table->slot_count) { /* it grows */
        struct net_table old = *table;
        table->slot_count *= 2;
        table->slots = arena_alloc(table->arena, table->slot_count, sizeof *table->slots);
        if (!table->slots) {
            *table = old;
            return NULL;
        }
        for (size_t k = 0; k < old.slot_count; k++)
            if (old.slots[k])
                *probe(table, old.slots[k]->ti, old.slots[k]->tj) = old.slots[k];
    }
    tile = arena_alloc(table->arena, 1, sizeof *tile);
    if (!tile)
        return NULL;
    tile->ti = ti;
    tile->tj = tj;
    *probe(table, ti, tj) = tile;
    table->tile_count++;
    table->last = tile;
    return tile;
}

enum status net_put(struct net *net, int32_t i, int32_t j, const struct net_node *node) {
    struct net_tile *tile = net_touch(net, i, j);
    int x = i & (NET_TILE - 1), y = j & (NET_TILE - 1);
    if (!tile)
        return STATUS_OUT_OF_MEMORY;
    tile->node[y][x] = *node;
    net_set_bits(tile, x, y, node);
    if (node->beside)
        net->table[net_table_of(tile->ti, tile->tj)].beside = true;
    return STATUS_OK;
}

void net_mark_grown(struct net *net, int32_t i, int32_t j) {
    int32_t ti = i >> NET_TILE_BITS, tj = j >> NET_TILE_BITS;
    int x = i & (NET_TILE - 1), y = j & (NET_TILE - 1);
    struct net_tile *tile = net_find_tile(&net->table[net_table_of(ti, tj)], ti, tj);
    if (!tile || tile->node[y][x].state == NET_UNKNOWN)
        return;
    tile->node[y][x].grown = 1;
    net_set_bit(tile, NET_BIT_GROWN, x, y, true);
}

/* Blocks double in length, so that entry `at` lies in the block of the highest bit of its number
 * counted from NET_YARN_FIRST; entries never move. */
static struct net_yarns *yarns_slot(const struct net_table *table, uint32_t at, int *block) {
    uint32_t number = at + NET_YARN_FIRST;
    int highest = 31 - __builtin_clz(number), first = 31 - __builtin_clz(NET_YARN_FIRST);
    *block = highest - first;
    struct net_yarns *yarns = *block < NET_YARN_BLOCKS ? table->yarns[*block] : NULL;
    return yarns ? yarns + (number - (1u << highest)) : NULL;
}

enum status net_put_rough(struct net *net, int32_t i, int32_t j, const struct net_node *node,
                          const struct net_yarns *yarns) {
    struct net_table *table = &net->table[net_table_of(i >> NET_TILE_BITS, j >> NET_TILE_BITS)];
    struct net_node rough = *node;
    int block;
    struct net_yarns *slot = yarns_slot(table, table->yarn_count, &block);
    if (!slot && block < NET_YARN_BLOCKS) {
        table->yarns[block] =
            arena_take(table->arena, (size_t)NET_YARN_FIRST << block, sizeof *yarns);
        slot = yarns_slot(table, table->yarn_count, &block);
    }
    if (!slot)
        return STATUS_OUT_OF_MEMORY;
    *slot = *yarns;
    rough.yarns = table->yarn_count++ & NET_YARNS_MOST;
    return net_put(net, i, j, &rough);
}

const struct net_yarns *net_yarns(const struct net *net, int32_t i, int32_t j,
                                  const struct net_node *node) {
    int block;
    const struct net_table *table =
        &net->table[net_table_of(i >> NET_TILE_BITS, j >> NET_TILE_BITS)];
    return yarns_slot(table, node->yarns, &block);
}

struct net_window net_window(const struct net *net, int32_t ti, int32_t tj) {
    struct net_window window;
    for (int row = 0; row < 3; row++)
        for (int column = 0; column < 3; column++) {
            int32_t i = ti + column - 1, j = tj + row - 1;
            window.tile[row][column] = *probe(&net->table[net_table_of(i, j)], i, j);
        }
    return window;
}

uint32_t net_window_near_rough(const struct net_window *w, int y, int reach) {
    uint64_t row = net_window_row(w, NET_BIT_ROUGH, y), near = row;
    for (int k = 1; k <= reach; k++)
        near |= row << k | row >> k | net_window_row(w, NET_BIT_ROUGH, y + k) |
                net_window_row(w, NET_BIT_ROUGH, y - k);
    return (uint32_t)(near >> NET_TILE) & ((1u << (NET_TILE + 1)) - 1);
}

bool net_window_has_rough(const struct net_window *w, int y, int reach) {
    uint64_t any = 0;
    for (int k = -reach; k <= reach; k++)
        any |= net_window_row(w, NET_BIT_ROUGH, y + k);
    return any != 0;
}

bool net_has_rough(const struct net *net) {
    bool any = false;
    for (int k = 0; k < NET_TABLES; k++)
        any = any || net->table[k].yarn_count > 0 || net->table[k].beside;
    return any;
}

size_t net_tile_count(const struct net *net) {
    size_t count = 0;
    for (int k = 0; k < NET_TABLES; k++)
        count += net->table[k].tile_count;
    return count;
}

static int compare_tiles(const void *a, const void *b) {
    const struct net_tile *p = *(struct net_tile *const *)a, *q = *(struct net_tile *const *)b;
    if (p->tj != q->tj)
        return p->tj < q->tj ? -1 : 1;
    return (p->ti > q->ti) - (p->ti < q->ti);
}

struct net_tile **net_sorted_tiles(struct net *net) {
    struct net_tile **tiles = arena_take(net->arena, net_tile_count(net), sizeof *tiles);
    size_t count = 0;
    for (int k = 0; tiles && k < NET_TABLES; k++)
        for (size_t slot = 0; slot < net->table[k].slot_count; slot++)
            if (net->table[k].slots[slot])
                tiles[count++] = net->table[k].slots[slot];
    if (tiles)
        qsort(tiles, count, sizeof *tiles, compare_tiles);
    return tiles;
}
