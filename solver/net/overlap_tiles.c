/* SPDX-License-Identifier: MIT */
#include "overlap_tiles.h"

#include "solver/wide.h"

#include <string.h>

/* For rounding. */
static const double certain = 1.001;

/* The box of all steps along a family of yarns; its middle, and half its sides. */
struct steps {
    struct vec3 low, high;
};

/* Of the places of a tile, along warp and along weft; if each of its nodes has a step along both.
 */
struct tile_steps {
    struct steps of[2];
    bool known;
};

static const struct steps no_steps = {{HUGE_VAL, HUGE_VAL, HUGE_VAL},
                                      {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL}};

/* The same while it is made, in a register each: lane 3 says nothing. */
typedef double four __attribute__((vector_size(32)));
typedef int64_t four_masks __attribute__((vector_size(32)));

struct wide_steps {
    four low, high;
};

static const struct wide_steps no_wide_steps = {{HUGE_VAL, HUGE_VAL, HUGE_VAL, HUGE_VAL},
                                                {-HUGE_VAL, -HUGE_VAL, -HUGE_VAL, -HUGE_VAL}};

_Static_assert(offsetof(struct net_node, r) == 0, "a node's coordinates are its first numbers");

/* Takes in the step between two nodes; from NULL, where one is. */
INLINE void widen_steps(struct wide_steps *steps, const struct net_node *from,
                        const struct net_node *to) {
    four start = {0}, step;
    memcpy(&step, to, sizeof step);
    if (from) {
        memcpy(&start, from, sizeof start);
        step -= start;
    }
    four_masks lower = step<steps->low, higher = step> steps->high;
    steps->low = (four)(((four_masks)step & lower) | ((four_masks)steps->low & ~lower));
    steps->high = (four)(((four_masks)step & higher) | ((four_masks)steps->high & ~higher));
}

static struct steps narrow_steps(const struct wide_steps *of) {
    return (struct steps){vec3_make(of->low[0], of->low[1], of->low[2]),
                          vec3_make(of->high[0], of->high[1], of->high[2])};
}

static void join_steps(struct steps *steps, const struct steps *other) {
    const struct vec3 *l = &steps->low, *h = &steps->high, *low = &other->low, *high = &other->high;
    *steps =
        (struct steps){vec3_make(low->x < l->x ? low->x : l->x, low->y < l->y ? low->y : l->y,
                                 low->z < l->z ? low->z : l->z),
                       vec3_make(high->x > h->x ? high->x : h->x, high->y > h->y ? high->y : h->y,
                                 high->z > h->z ? high->z : h->z)};
}

/* Those of a family, as the step (dx, dy) between places, that begin in a tile. */
INLINE struct steps steps_along(const struct net_window *window, const int dx, const int dy,
                                bool *known) {
    enum { LAST = NET_TILE - 1 };
    const struct net_tile *tile = window->tile[1][1];
    struct wide_steps steps = no_wide_steps;
    uint64_t joined =
        dy ? net_window_row(window, NET_BIT_PLACE, 0) & net_window_row(window, NET_BIT_PLACE, -1)
           : 0; /* to the place below */
    for (int y = 0; y < NET_TILE; y++) {
        uint64_t row = net_window_row(window, NET_BIT_PLACE, y);
        uint64_t ahead = row & (dy ? net_window_row(window, NET_BIT_PLACE, y + 1) : row >> 1);
        uint64_t alone = ~(ahead | (dy ? joined : ahead << 1)) >> NET_TILE;
        joined = ahead;
        *known = *known && !(alone & tile->bits[NET_BIT_INSIDE][y]);
        for (unsigned bits = ahead >> NET_TILE & UINT16_MAX; bits; bits &= bits - 1) {
            int x = __builtin_ctz(bits);
            bool within = x + dx <= LAST && y + dy <= LAST;
            widen_steps(&steps, &tile->node[y][x],
                        within ? &tile->node[y + dy][x + dx]
                               : net_window_find(window, x + dx, y + dy));
        }
    }
    return narrow_steps(&steps);
}

WIDE_CLONES static struct tile_steps steps_of_tile(const struct net *net,
                                                   const struct net_tile *tile) {
    struct net_window window = net_window(net, tile->ti, tile->tj);
    struct tile_steps steps = {.known = true};
    steps.of[0] = steps_along(&window, 1, 0, &steps.known);
    steps.of[1] = steps_along(&window, 0, 1, &steps.known);
    return steps;
}

/* The box that the cells of a tile's nodes reach over. */
WIDE_CLONES static struct overlap_box box_of_tile(const struct net_tile *tile, double reach) {
    struct wide_steps nodes = no_wide_steps;
    struct overlap_box box;
    for (int y = 0; y < NET_TILE; y++)
        for (unsigned bits = tile->bits[NET_BIT_INSIDE][y]; bits; bits &= bits - 1)
            widen_steps(&nodes, NULL, &tile->node[y][__builtin_ctz(bits)]);
    for (int k = 0; k < 3; k++) {
        box.low[k] = nodes.low[k] - reach;
        box.high[k] = nodes.high[k] + reach;
    }
    return box;
}

/* Whether any two places of a tile and those round it are joined by a way that goes along warp to
 * one side only, and along weft: they are in one piece, and without a gap in a row or a column. */
static bool is_convex(const struct net_window *window) {
    uint64_t before = 0, ended = 0;
    for (int y = -NET_TILE; y < 2 * NET_TILE; y++) {
        uint64_t row = net_window_row(window, NET_BIT_PLACE, y), first = row & (~row + 1);
        bool apart = (before | ended) && row && !(before & row);
        if (((row + first) & row) || apart || (row & ended))
            return false;
        ended |= before & ~row;
        before = row;
    }
    return true;
}

/* The most of v . s, less that of the middle, of steps s. */
static double spread_along(struct vec3 v, const struct steps *steps) {
    struct vec3 half = vec3_scale(0.5, vec3_sub(steps->high, steps->low));
    return fabs(v.x) * half.x + fabs(v.y) * half.y + fabs(v.z) * half.z;
}

/* Whether places more than `neighbours` apart are so by these steps. */
static bool lie_apart(const struct steps steps[2], int neighbours) {
    struct vec3 a = vec3_scale(0.5, vec3_add(steps[0].low, steps[0].high));
    struct vec3 b = vec3_scale(0.5, vec3_add(steps[1].low, steps[1].high));
    struct vec3 across = vec3_cross(a, b);
    double scale = 1 / vec3_norm2(across);
    const struct vec3 dual[2] = {vec3_scale(scale, vec3_cross(b, across)),
                                 vec3_scale(scale, vec3_cross(across, a))};
    double longest = vec3_norm(a) + vec3_distance(steps[0].low, steps[0].high) / 2;
    bool apart = true;
    for (int k = 0; k < 2; k++) {
        double spread = spread_along(dual[k], &steps[0]) + spread_along(dual[k], &steps[1]);
        double cells = 1 + spread + overlap_sheet_gap * longest * vec3_norm(dual[k]);
        apart = apart && (neighbours + 1) * (1 - spread) > certain * cells;
    }
    return apart;
}

/* A look at the tiles near one. */
struct look {
    const struct overlap_patches *tiles;
    const struct overlap_patch *tile;
    enum overlap_tile *mark; /* NULL: only whether one of them is no neighbour in the net */
};

static bool is_far_in_net(void *context, int32_t other) {
    const struct look *look = context;
    const struct overlap_patch *p = look->tile, *q = &look->tiles->patch[other];
    return q->pi < p->pi - 1 || q->pi > p->pi + 1 || q->pj < p->pj - 1 || q->pj > p->pj + 1;
}

static bool mark_near(void *context, int32_t other) {
    const struct look *look = context;
    enum overlap_tile *what = &look->mark[other];
    *what = *what == OVERLAP_TILE_APART ? OVERLAP_TILE_NEAR : *what;
    return false;
}

/* Whether the nodes of tile t lie apart from all that are not their neighbours. */
static bool lies_apart(struct net *net, const struct overlap_patches *tiles,
                       const struct tile_steps *steps, int32_t t, double reach, int neighbours) {
    struct look look = {.tiles = tiles, .tile = &tiles->patch[t]};
    struct net_window window = net_window(net, look.tile->pi, look.tile->pj);
    struct steps all[2] = {no_steps, no_steps};
    if (overlap_patches_meet(tiles, look.tile, reach, is_far_in_net, &look) || !is_convex(&window))
        return false;
    for (int k = 0; k < 9; k++) {
        const struct net_tile *tile = window.tile[k / 3][k % 3];
        if (!tile)
            continue;
        int32_t number = *overlap_patches_slot(tiles, tile->ti, tile->tj);
        if (!steps[number].known)
            return false;
        for (int family = 0; family < 2; family++)
            join_steps(&all[family], &steps[number].of[family]);
    }
    return lie_apart(all, neighbours);
}

enum overlap_tile *overlap_tiles(struct net *net, struct net_tile *const *tiles, double cube,
                                 double reach, int neighbours) {
    size_t count = net_tile_count(net);
    struct overlap_patches boxes;
    struct tile_steps *steps = arena_take(net->arena, count + 1, sizeof *steps);
    enum overlap_tile *what = arena_take(net->arena, count + 1, sizeof *what);
    bool fits = steps && what && overlap_patches_make(&boxes, net->arena, 0, cube);
    for (size_t t = 0; t < count && fits; t++) {
        const struct net_tile *tile = tiles[t];
        struct overlap_box box = box_of_tile(tile, reach);
        fits = overlap_patches_stretch(&boxes, tile->ti, tile->tj, tile, &box,
                                       (struct overlap_shape){HUGE_VAL, 0}) == STATUS_OK;
        steps[t] = steps_of_tile(net, tile);
        what[t] = OVERLAP_TILE_APART;
    }
    for (size_t t = 0; t < count && fits; t++)
        if (!lies_apart(net, &boxes, steps, (int32_t)t, reach, neighbours))
            what[t] = OVERLAP_TILE_SUSPECT;
    for (size_t t = 0; t < count && fits; t++) {
        struct look look = {.tiles = &boxes, .tile = &boxes.patch[t], .mark = what};
        if (what[t] == OVERLAP_TILE_SUSPECT)
            (void)overlap_patches_meet(&boxes, look.tile, reach, mark_near, &look);
    }
    return fits ? what : NULL;
}
