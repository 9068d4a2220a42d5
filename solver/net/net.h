/* SPDX-License-Identifier: MIT */
/*
 * The net while it grows: nodes at integer places (i, j) without bounds, kept in square tiles that
 * are found by hashing, so that a long thin net costs no more than a square one.
 */
#ifndef SOLVER_NET_NET_H
#define SOLVER_NET_NET_H

#include "solver/arena.h"
#include "solver/status.h"
#include "solver/vec.h"
#include <stdbool.h>
#include <stdint.h>

enum net_state {
    NET_UNKNOWN = 0,
    NET_INSIDE, /* a node of the result */
    NET_GHOST,  /* beyond the boundary: carries the net on, is not reported */
    NET_FAILED  /* there can be no node here */
};

/* The edges of a node by the family of yarn that they belong to, 0 warp and 1 weft, and the side on
 * which the other end lies, 0 lower index and 1 higher. */
#define NET_EDGE_BIT(family, side) ((uint8_t)(1u << (2 * (family) + (side))))

enum { NET_REASON_BITS = 7 };

struct net_node {
    struct vec3 r;
    double uv[2];
    uint8_t state : 2;  /* enum net_state */
    uint8_t reason : 3; /* enum drape_reason, of ghosts and failures */
    int8_t turn : 2;    /* of ghosts: 1 beyond a cut to its left, -1 to its right */
    uint8_t
        grown : 1;       /* 1 where it rests on a yarn that went straight on along a free edge, or
                        that  set off across another one: the generators alone do not fix it; else 0 */
    uint8_t rough : 6;   /* NET_EDGE_BIT of the edges that end here and are rough (`rough.h`) */
    int8_t across : 2;   /* as `turn`, of the second cut of a shell that closes both ways */
    uint16_t face;       /* of a shell, that uv are parameters of */
    uint32_t yarns : 27; /* where the directions of those edges are (`net_yarns`) */
    uint32_t beside : 1; /* 1 where a cut is within a cell's reach */
    uint32_t parted : 4; /* NET_EDGE_BIT of the sides whose neighbour lies across a cut */
};

/* The directions of the rough edges that a node was found by, one of each family at the most: unit
 * tangents of the yarn towards the higher index, in the tangent plane at that end; where the
 * surface has a crease in that of the span that `surface_evaluate` takes. */
struct net_edge {
    struct vec3 lower, higher;
};

struct net_yarns {
    struct net_edge edge[2]; /* warp, weft; set where the node's `rough` has a bit */
};

enum { NET_TILE_BITS = 4, NET_TILE = 1 << NET_TILE_BITS };
/* So many numbers are those of all blocks. */
enum { NET_YARN_BLOCKS = 20, NET_YARN_FIRST = 64, NET_YARNS_MOST = (1 << 27) - 1 };

/* What a tile keeps a bit of for each of its places. */
enum net_bit {
    NET_BIT_INSIDE, /* the node there is NET_INSIDE */
    NET_BIT_PLACE,  /* that or NET_GHOST */
    NET_BIT_KNOWN,  /* it is not NET_UNKNOWN */
    NET_BIT_GROWN,  /* it is grown */
    NET_BIT_ROUGH,  /* it has rough edges, or a cut beside it */
    NET_BITS
};

struct net_tile {
    int32_t ti, tj;                    /* it holds i = ti * NET_TILE .. + NET_TILE - 1, j alike */
    uint16_t bits[NET_BITS][NET_TILE]; /* bit x of row y */
    struct net_node node[NET_TILE][NET_TILE]; /* [j][i] */
};

/* The tiles of one quadrant, i or j from 0 or below it: each is a table of its own, so that four
 * threads can fill the quadrants at the same time. */
struct net_table {
    _Alignas(64) struct arena *arena;
    struct net_tile **slots; /* open addressing; NULL is free */
    size_t slot_count;       /* a power of two */
    size_t tile_count;
    struct net_tile *last;                    /* found last */
    struct net_yarns *yarns[NET_YARN_BLOCKS]; /* each block twice as long as the one before */
    uint32_t yarn_count;
    bool beside; /* some node has a cut beside it */
};

enum { NET_TABLES = 4 };

struct net {
    struct arena *arena;
    struct net_table table[NET_TABLES]; /* + 1 for i < 0, + 2 for j < 0 */
};

/* An empty net whose memory comes from `arena`, and from children of it, one for each quadrant, if
 * it is `divided`. Errors: STATUS_OUT_OF_MEMORY. */
enum status net_make(struct net *net, struct arena *arena, bool divided) STATUS_MUST_USE;

/* Gives back what its arenas hold; `arena` must have been the net's and its march's alone. */
void net_free(struct net *net);

/* The tile (ti, tj) of a table by its hash, which is then the one found last; NULL: none. */
struct net_tile *net_seek(struct net_table *table, int32_t ti, int32_t tj);

static inline struct net_tile *net_find_tile(struct net_table *table, int32_t ti, int32_t tj) {
    struct net_tile *last = table->last;
    return last && last->ti == ti && last->tj == tj ? last : net_seek(table, ti, tj);
}

/* Which of a net's tables has a tile. */
static inline int net_table_of(int32_t ti, int32_t tj) {
    return (ti < 0) + 2 * (tj < 0);
}

/* The node at (i, j), NULL when nothing was ever put near it. */
static inline struct net_node *net_find(struct net *net, int32_t i, int32_t j) {
    int32_t ti = i >> NET_TILE_BITS, tj = j >> NET_TILE_BITS;
    struct net_tile *tile = net_find_tile(&net->table[net_table_of(ti, tj)], ti, tj);
    return tile ? &tile->node[j & (NET_TILE - 1)][i & (NET_TILE - 1)] : NULL;
}

/* The tile of (i, j), made if there is none; NULL without memory. */
struct net_tile *net_touch(struct net *net, int32_t i, int32_t j);

static inline void net_set_bit(struct net_tile *tile, enum net_bit which, int x, int y, bool on) {
    unsigned bit = 1u << x, bits = tile->bits[which][y];
    tile->bits[which][y] = (uint16_t)(on ? bits | bit : bits & ~bit);
}

/* All bits of the place at column x and row y of a tile, for the node there. */
static inline void net_set_bits(struct net_tile *tile, int x, int y, const struct net_node *node) {
    net_set_bit(tile, NET_BIT_INSIDE, x, y, node->state == NET_INSIDE);
    net_set_bit(tile, NET_BIT_PLACE, x, y, node->state == NET_INSIDE || node->state == NET_GHOST);
    net_set_bit(tile, NET_BIT_KNOWN, x, y, node->state != NET_UNKNOWN);
    net_set_bit(tile, NET_BIT_ROUGH, x, y, node->rough || node->beside);
    net_set_bit(tile, NET_BIT_GROWN, x, y, node->grown);
}

/* Puts a node at (i, j), in place of what was there. Errors: STATUS_OUT_OF_MEMORY. */
enum status net_put(struct net *net, int32_t i, int32_t j,
                    const struct net_node *node) STATUS_MUST_USE;

/* Marks the place (i, j), if there is one, as grown. */
void net_mark_grown(struct net *net, int32_t i, int32_t j);
/* Puts a node with rough edges, whose directions are copied. Errors: STATUS_OUT_OF_MEMORY. */
enum status net_put_rough(struct net *net, int32_t i, int32_t j, const struct net_node *node,
                          const struct net_yarns *yarns) STATUS_MUST_USE;

/* The directions of the rough edges of the node at (i, j), which must have some. */
const struct net_yarns *net_yarns(const struct net *net, int32_t i, int32_t j,
                                  const struct net_node *node);

static inline enum net_state net_state_at(struct net *net, int32_t i, int32_t j) {
    const struct net_node *node = net_find(net, i, j);
    return node ? (enum net_state)node->state : NET_UNKNOWN;
}

/* The node at (i, j) if it has a place, inside or ghost; else NULL. */
static inline const struct net_node *net_place(struct net *net, int32_t i, int32_t j) {
    const struct net_node *node = net_find(net, i, j);
    return node && (node->state == NET_INSIDE || node->state == NET_GHOST) ? node : NULL;
}

/* Whether a cut parts two neighbours along a family of yarns, the one of lower index first. */
static inline bool net_is_parted(const struct net_node *lower, const struct net_node *higher,
                                 int family) {
    return (lower->parted & NET_EDGE_BIT(family, 1)) || (higher->parted & NET_EDGE_BIT(family, 0));
}

/* The same, the other one on this side, 0 lower index and 1 higher. */
static inline bool net_is_parted_to(const struct net_node *node, const struct net_node *other,
                                    int family, int side) {
    return side ? net_is_parted(node, other, family) : net_is_parted(other, node, family);
}

/* The step of a yarn at a node, by the places before and after it, NULL where there is none; zero
 * where there is neither. */
static inline struct vec3 net_step(const struct net_node *back, const struct net_node *here,
                                   const struct net_node *ahead) {
    if (ahead && back)
        return vec3_scale(0.5, vec3_sub(ahead->r, back->r));
    return ahead  ? vec3_sub(ahead->r, here->r)
           : back ? vec3_sub(here->r, back->r)
                  : vec3_make(0, 0, 0);
}

/* A tile with those round it, NULL where there is none: its places by their position in it,
 * without looking tiles up again. */
struct net_window {
    const struct net_tile *tile[3][3]; /* [row][column], [1][1] the tile itself */
};

struct net_window net_window(const struct net *net, int32_t ti, int32_t tj);

/* The node at column x and row y counted from the tile's first, both -NET_TILE..2 NET_TILE - 1;
 * NULL when nothing was ever put near it. */
static inline const struct net_node *net_window_find(const struct net_window *w, int x, int y) {
    const struct net_tile *tile = w->tile[(y >> NET_TILE_BITS) + 1][(x >> NET_TILE_BITS) + 1];
    return tile ? &tile->node[y & (NET_TILE - 1)][x & (NET_TILE - 1)] : NULL;
}

/* The same if it has a place, inside or ghost; else NULL. */
static inline const struct net_node *net_window_place(const struct net_window *w, int x, int y) {
    const struct net_node *node = net_window_find(w, x, y);
    return node && (node->state == NET_INSIDE || node->state == NET_GHOST) ? node : NULL;
}

/* A net that is only read, near one place and then near the next: a window that moves along. */
struct net_view {
    const struct net *net; /* NULL: none */
    int32_t ti, tj;
    struct net_window window;
};

static inline struct net_view net_view(const struct net *net) {
    return (struct net_view){net, 0, 0, net_window(net, 0, 0)};
}

/* Moves to the tile of (i, j): from there places up to NET_TILE off can be seen. */
static inline void net_view_move(struct net_view *view, int32_t i, int32_t j) {
    int32_t ti = i >> NET_TILE_BITS, tj = j >> NET_TILE_BITS;
    if (ti != view->ti || tj != view->tj)
        *view = (struct net_view){view->net, ti, tj, net_window(view->net, ti, tj)};
}

/* As net_place. */
static inline const struct net_node *net_view_place(const struct net_view *view, int32_t i,
                                                    int32_t j) {
    return net_window_place(&view->window, i - view->ti * NET_TILE, j - view->tj * NET_TILE);
}

/* The bits of all places of row y of a window, that at x as bit NET_TILE + x. */
static inline uint64_t net_window_row(const struct net_window *w, enum net_bit which, int y) {
    const struct net_tile *const *row = w->tile[(y >> NET_TILE_BITS) + 1];
    uint64_t bits = 0;
    for (int k = 0; k < 3; k++)
        if (row[k])
            bits |= (uint64_t)row[k]->bits[which][y & (NET_TILE - 1)] << (k * NET_TILE);
    return bits;
}

/* Those of places x = -1 .. NET_TILE, as bit x + 1. */
static inline uint32_t net_window_bits(const struct net_window *w, enum net_bit which, int y) {
    return (uint32_t)(net_window_row(w, which, y) >> (NET_TILE - 1)) & ((1u << (NET_TILE + 2)) - 1);
}

/* Those that have a node, inside or ghost, neither grown nor with rough edges, as in
 * net_window_row. */
static inline uint64_t net_window_plain(const struct net_window *w, int y) {
    return net_window_row(w, NET_BIT_PLACE, y) &
           ~(net_window_row(w, NET_BIT_GROWN, y) | net_window_row(w, NET_BIT_ROUGH, y));
}

/* The places x = 0 .. NET_TILE of row y, as bits, that have a node with rough edges no more than
 * `reach` places away along their own row or column; 0 <= y <= NET_TILE, reach < NET_TILE. */
uint32_t net_window_near_rough(const struct net_window *w, int y, int reach);

/* Whether the window has any such node in the rows from y - reach to y + reach. */
bool net_window_has_rough(const struct net_window *w, int y, int reach);

/* Whether any edge of the net is rough, or any node beside a cut. */
bool net_has_rough(const struct net *net);

/* How many tiles there are. */
size_t net_tile_count(const struct net *net);

/* All tiles sorted by (tj, ti), as an array of net_tile_count pointers from the arena; NULL without
 * memory. */
struct net_tile **net_sorted_tiles(struct net *net);

#endif
