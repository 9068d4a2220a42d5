/* SPDX-License-Identifier: MIT */
#include "estimate.h"

#include <stdlib.h>
#include <string.h>

/* Coefficients of estimate.h. */
static const double by_moved = 1.0 / 6;
static const double by_fourth = 5.0 / 144 + 1.0 / 240;
static const double by_one_sided = 5.0 / 144 + 1.0 / 240 + 5.0 / 72; /* of D4 at a yarn's end */
static const double by_third = 3.0 / 960 - 1.0 / 576;

/* A rough edge is a geodesic; its yarn may turn sideways by this angle over it. */
static const double rough_turn = 0.05;

/* What solving and following a generator leave of an edge, as a share of it. */
static const double rounding = 2e-12;

/* Where yarns turn by much over an edge, what is left out grows with the angle. */
static const double unresolved = 10;

/* What the estimate takes of the sum of the edges' errors, and of the distance to the first net. */
static const double share_of_sum = 2;
static const double share_of_moved = 0.003;

/* Each step of a yarn that goes straight on moves its end by this share of the spacing at the most,
 * and by this share of what the net has moved before it. */
static const double grown_step = 0.35;
static const double grown_factor = 1.05;

/* Yarns that cross under less than this sine are taken as crossing so. */
static const double least_sine = 0.02;

struct place {
    int32_t i, j;
};

struct estimate {
    struct net *net, *before;
    const double *spacing;
};

/* The largest components of a node's error along warp and weft, and of itself. */
struct error {
    double along[2], size;
};

static struct net_node *store(const struct estimate *e, int32_t i, int32_t j) {
    struct net_node *node = net_find(e->before, i, j);
    return node && (node->state == NET_INSIDE || node->state == NET_GHOST) ? node : NULL;
}

/* sum_k weight[k] r(i + k di, j + k dj), k = first .. first + count - 1; of what the correction
 * moved the nodes by, with `moved`. */
static bool combine(const struct estimate *e, bool moved, struct place at, const int step[2],
                    int first, int count, const double *weight, struct vec3 *sum) {
    *sum = vec3_make(0, 0, 0);
    for (int k = 0; k < count; k++) {
        int32_t i = at.i + (first + k) * step[0], j = at.j + (first + k) * step[1];
        const struct net_node *now = net_place(e->net, i, j);
        const struct net_node *then = moved ? net_place(e->before, i, j) : now;
        if (!now || !then)
            return false;
        struct vec3 r = moved ? vec3_sub(then->r, now->r) : now->r;
        *sum = vec3_axpy(weight[k], r, *sum);
    }
    return true;
}

/* A difference of an edge from `at` on by one of the windows of `count` places that the yarn has;
 * false where it has none. `centred` says whether it was the first. */
static bool difference(const struct estimate *e, bool moved, struct place at, const int step[2],
                       int first, int count, const double *weight, struct vec3 *sum,
                       bool *centred) {
    static const int8_t shift[] = {0, 1, -1, 2, -2};
    for (size_t k = 0; k < sizeof shift; k++)
        if (combine(e, moved, at, step, first + shift[k], count, weight, sum)) {
            *centred = k == 0;
            return true;
        }
    return false;
}

static const double second[] = {1, -2, 1}, third[] = {-1, 3, -3, 1}, fourth[] = {1, -4, 6, -4, 1};

/* Whether the edge from `at` on is rough. */
static bool is_rough(const struct estimate *e, struct place at, const int step[2]) {
    int family = step[0] ? 0 : 1, ahead = step[0] + step[1] > 0;
    const struct net_node *from = net_place(e->net, at.i, at.j);
    const struct net_node *to = net_place(e->net, at.i + step[0], at.j + step[1]);
    return (from && from->rough & NET_EDGE_BIT(family, ahead)) ||
           (to && to->rough & NET_EDGE_BIT(family, 1 - ahead));
}

/* The error of the edge from `at` on with the chord `along`, in length. Of a circle, on which it
 * has none, D3 and D4 are taken off. */
static double edge_error(const struct estimate *e, struct place at, const int step[2],
                         struct vec3 along) {
    int family = step[0] ? 0 : 1;
    double d = e->spacing[family];
    struct vec3 d2, d3, d4, moved;
    bool any, centred;
    if (is_rough(e, at, step) || !difference(e, false, at, step, -1, 3, second, &d2, &any))
        return d * rough_turn * rough_turn / 24;
    double turn2 = vec3_norm2(d2) / (d * d);
    if (!difference(e, false, at, step, -1, 4, third, &d3, &any) ||
        !difference(e, false, at, step, -2, 5, fourth, &d4, &centred) ||
        !difference(e, true, at, step, -1, 3, second, &moved, &any))
        return d * turn2 / 24 + rounding * d;
    centred = centred && (family ? at.j : at.i) != 0;
    double by_d4 = centred ? by_fourth : by_one_sided;
    double n4 = vec3_norm(centred ? vec3_axpy(turn2, d2, d4) : d4);
    double n3 = vec3_norm2(vec3_axpy(turn2, along, d3));
    double sum = vec3_norm(d2) * (by_moved * vec3_norm(moved) + by_d4 * n4) + by_third * n3;
    return (1 + unresolved * sqrt(turn2)) * sum / (2 * d) + rounding * d;
}

/* A node's error is kept in place of the parameters of the net before: its size, and the components
 * in single precision. */
static struct error error_at(const struct estimate *e, int32_t i, int32_t j) {
    const struct net_node *node = store(e, i, j);
    struct error error = {{0, 0}, 0};
    float along[2];
    if (!node)
        return error;
    memcpy(along, &node->uv[1], sizeof along);
    return (struct error){{along[0], along[1]}, node->uv[0]};
}

static void keep_error(const struct estimate *e, int32_t i, int32_t j, const struct error *error) {
    struct net_node *node = store(e, i, j);
    const float along[2] = {(float)error->along[0], (float)error->along[1]};
    if (!node)
        return;
    node->uv[0] = error->size;
    memcpy(&node->uv[1], along, sizeof along);
}

static void clear_errors(struct net *before) {
    struct net_tile **tiles = net_sorted_tiles(before);
    for (size_t t = 0; tiles && t < net_tile_count(before); t++)
        for (int k = 0; k < NET_TILE * NET_TILE; k++) {
            struct net_node *node = &tiles[t]->node[k / NET_TILE][k % NET_TILE];
            node->uv[0] = node->uv[1] = 0;
        }
}

/* The error of a node that the generators fix. */
static struct error fixed_error(const struct estimate *e, int32_t i, int32_t j,
                                const struct net_node *node) {
    const int32_t at[2] = {i, j};
    struct vec3 chord[2] = {{0, 0, 0}, {0, 0, 0}}, turn[2];
    struct error before[2] = {{{0, 0}, 0}, {{0, 0}, 0}}, sum = {{0, 0}, 0};
    bool known[2] = {true, true};
    for (int k = 0; k < 2; k++) {
        int sign = at[k] > 0 ? 1 : -1, step[2] = {k == 0 ? sign : 0, k == 0 ? 0 : sign};
        struct place from = {i - step[0], j - step[1]};
        const struct net_node *last = at[k] ? net_place(e->net, from.i, from.j) : NULL;
        turn[k] = vec3_make(0, 0, 0);
        if (!last)
            continue;
        chord[k] = vec3_unit(vec3_sub(node->r, last->r));
        before[k] = error_at(e, from.i, from.j);
        sum.along[k] = edge_error(e, from, step, vec3_sub(node->r, last->r));
        known[k] = store(e, from.i, from.j) != NULL;
        if (!combine(e, false, from, step, -1, 3, second, &turn[k]) &&
            !combine(e, false, from, step, 0, 3, second, &turn[k]))
            turn[k] = vec3_make(0, 0, 0);
    }
    double cosine = fabs(vec3_dot(chord[0], chord[1]));
    double sine = fmax(sqrt(fmax(0, 1 - cosine * cosine)), least_sine);
    for (int k = 0; k < 2; k++) {
        double sideways = fabs(vec3_dot(turn[k], chord[1 - k])) / (e->spacing[k] * sine);
        sum.along[k] +=
            known[k] ? before[k].along[k] + sideways * before[k].size : before[1 - k].size;
    }
    double a = sum.along[0], b = sum.along[1];
    sum.size = sqrt(a * a + b * b + 2 * a * b * cosine) / sine;
    return sum;
}

/* The error of one that rests on yarns along free edges: what a neighbour has, and a step more. */
static struct error grown_error(const struct estimate *e, int32_t i, int32_t j) {
    struct error most = {{0, 0}, 0};
    for (int dj = -1; dj <= 1; dj++)
        for (int di = -1; di <= 1; di++) {
            struct error near = error_at(e, i + di, j + dj);
            if (near.size > most.size && net_place(e->net, i + di, j + dj))
                most = near;
        }
    double step = grown_step * fmax(e->spacing[0], e->spacing[1]);
    most.size = grown_factor * most.size + step;
    most.along[0] = most.along[1] = most.size;
    return most;
}

/* All places of the net by their distance from the start in the net. */
static struct place *sort_places(struct net *net, struct arena *arena, size_t *count) {
    struct net_tile **tiles = net_sorted_tiles(net);
    size_t places = net_tile_count(net) * NET_TILE * NET_TILE;
    uint32_t levels = 0;
    for (size_t t = 0; tiles && t < net_tile_count(net); t++) {
        uint32_t level = (uint32_t)(labs(tiles[t]->ti) + labs(tiles[t]->tj) + 2) * NET_TILE;
        levels = level > levels ? level : levels;
    }
    size_t *first = arena_alloc(arena, (size_t)levels + 2, sizeof *first);
    struct place *sorted = arena_take(arena, places, sizeof *sorted);
    if (!tiles || !first || !sorted)
        return NULL;
    for (int pass = 0; pass < 2; pass++) {
        for (size_t t = 0; t < net_tile_count(net); t++)
            for (int k = 0; k < NET_TILE * NET_TILE; k++) {
                int x = k % NET_TILE, y = k / NET_TILE;
                uint8_t state = tiles[t]->node[y][x].state;
                if (state != NET_INSIDE && state != NET_GHOST)
                    continue;
                int32_t i = tiles[t]->ti * NET_TILE + x, j = tiles[t]->tj * NET_TILE + y;
                size_t *next = &first[labs(i) + labs(j) + 1 - pass];
                if (pass)
                    sorted[*next] = (struct place){i, j};
                ++*next;
            }
        for (size_t k = 1; !pass && k < (size_t)levels + 2; k++)
            first[k] += first[k - 1];
        *count = first[levels + 1];
    }
    return sorted;
}

enum status estimate_make(struct march *march) {
    struct net *before = march->first;
    struct estimate e = {march->net, before, march->settings->spacing};
    size_t count = 0;
    struct place *places = sort_places(march->net, march->arena, &count);
    if (!places)
        return STATUS_OUT_OF_MEMORY;
    clear_errors(before);
    for (size_t k = 0; k < count; k++) {
        int32_t i = places[k].i, j = places[k].j;
        const struct net_node *node = net_find(march->net, i, j);
        struct error error = node->grown ? grown_error(&e, i, j) : fixed_error(&e, i, j, node);
        keep_error(&e, i, j, &error);
    }
    return STATUS_OK;
}

double estimate_of(const struct net_node *before, const struct net_node *now) {
    return share_of_sum * before->uv[0] + share_of_moved * vec3_distance(before->r, now->r);
}
