/* SPDX-License-Identifier: MIT */
/* Whether patches of nets lie apart (solver/net/separation.h), and tiles from all the rest
 * (solver/net/overlap_tiles.h), against their nodes one by one. */
#include "solver/net/overlap.h"
#include "solver/net/separation.h"

#include "own_arena.h"
#include "tests/check.h"
#include <math.h>
#include <stdio.h>

enum { ROUNDS = 3000, FIRST = 4, LAST = FIRST + SEPARATION_SIDE };

static uint64_t dice;

/* From -1 to 1. */
static double roll(void) {
    dice = dice * UINT64_C(6364136223846793005) + UINT64_C(1442695040888963407);
    return (double)(dice >> 11) * 0x1p-52 - 1;
}

static struct vec3 roll_vector(double size) {
    double x = roll(), y = roll(), z = roll();
    return vec3_scale(size, vec3_make(x, y, z));
}

/* A tile of nodes round a middle, sheared and bent: r = r0 + i a + j b + i^2 p + i j q + j^2 s.
 * Some have no node. */
static void put_tile(struct net *net, int32_t ti, struct vec3 middle, double bend, bool holes) {
    double angle = 0.05 + 1.45 * fabs(roll()), turn = 4 * roll();
    struct vec3 a = {cos(turn), sin(turn), 0.1 * roll()};
    struct vec3 b = {cos(turn + angle), sin(turn + angle), 0.1 * roll()};
    struct vec3 p = roll_vector(bend), q = roll_vector(bend), s = roll_vector(bend);
    for (int y = 0; y < NET_TILE; y++)
        for (int x = 0; x < NET_TILE; x++) {
            double i = x - FIRST - 1.5, j = y - FIRST - 1.5;
            struct vec3 r = vec3_axpy(i, a, vec3_axpy(j, b, middle));
            r = vec3_axpy(i * i, p, vec3_axpy(i * j, q, vec3_axpy(j * j, s, r)));
            struct net_node node = {.r = r,
                                    .state = holes && roll() > 0.7 ? NET_FAILED : NET_INSIDE};
            assert_int_equal(net_put(net, ti * NET_TILE + x, y, &node), STATUS_OK);
        }
}

static struct vec3 step(const struct net_window *w, int x, int y, int dx, int dy) {
    const struct net_node *here = net_window_find(w, x, y);
    const struct net_node *ahead = net_window_place(w, x + dx, y + dy);
    const struct net_node *back = net_window_place(w, x - dx, y - dy);
    double share = ahead && back ? 0.5 : 1;
    return vec3_scale(share, vec3_sub(ahead ? ahead->r : here->r, back ? back->r : here->r));
}

/* Whether a place is in the cells round a node, as the header has them. */
static bool in_cells(const struct net_window *w, int x, int y, struct vec3 place) {
    struct vec3 a = step(w, x, y, 1, 0), b = step(w, x, y, 0, 1), n = vec3_cross(a, b);
    struct vec3 off = vec3_sub(place, net_window_find(w, x, y)->r);
    double area2 = vec3_norm2(n), height = vec3_dot(off, n) / sqrt(area2);
    return fabs(vec3_dot(vec3_cross(off, b), n)) < area2 &&
           fabs(vec3_dot(vec3_cross(a, off), n)) < area2 && fabs(height) < vec3_norm(a) / 2;
}

/* Whether a place with these numbers is in the cells of a square's nodes that are within `reach`
 * and not its neighbours. */
static bool in_square(const struct net_window *w, struct vec3 place, const int32_t at[2],
                      double reach, double least) {
    bool in = false;
    for (int y = FIRST; y < LAST; y++)
        for (int x = FIRST; x < LAST; x++) {
            const struct net_node *node = net_window_find(w, x, y);
            double di = fabs(w->tile[1][1]->ti * NET_TILE + x - (double)at[0]);
            double dj = fabs(w->tile[1][1]->tj * NET_TILE + y - (double)at[1]);
            in = in || (node->state == NET_INSIDE && (di >= least || dj >= least) &&
                        vec3_distance(node->r, place) < reach && in_cells(w, x, y, place));
        }
    return in;
}

/* The square of one tile against that `shift` places on in its own row, or of the next tile. */
static bool ask(const struct net_window *from, const struct net_window *to, int shift,
                double least) {
    const double reach = 2.1;
    struct separation_points points;
    struct separation_frame frame;
    separation_points(to, FIRST + shift, FIRST, &points);
    separation_frame(from, FIRST, FIRST, &frame);
    bool apart = separation_holds(&frame, &points, reach, least);
    for (int n = 0; n < points.count; n++) {
        bool away = separation_holds_at(&frame, points.r[n]);
        if (apart || away)
            assert_false(in_square(from, points.r[n], points.at[n], reach, away ? 0 : least));
    }
    return apart;
}

static void test_separation_is_right_of_every_node(void **state) {
    int others = 0, neighbours = 0;
    (void)state;
    dice = check_seed(1);
    for (int round = 0; round < ROUNDS; round++) {
        struct arena_mark mark = arena_mark(arena);
        struct net net;
        assert_int_equal(net_make(&net, arena, false), STATUS_OK);
        put_tile(&net, 0, vec3_make(0, 0, 0), round % 2 ? 0.02 : 0.003, round % 3 == 0);
        put_tile(&net, 3, roll_vector(6), 0.02, false);
        struct net_window here = net_window(&net, 0, 0), there = net_window(&net, 3, 0);
        others += ask(&here, &there, 0, 4);
        neighbours += ask(&here, &here, round % 5, round % 7 ? 4 : 1.6);
        arena_rewind(arena, mark);
    }
    printf("  apart: %d of other parts, %d of neighbours\n", others, neighbours);
    check_above(others, ROUNDS / 4);
    check_above(neighbours, ROUNDS / 4);
}

/* ---- tiles ---- */

enum { NETS = 60, WIDE = 2 * NET_TILE };

/* A net round the start on a bent strip, which may come round to itself. Beyond a column without
 * nodes it may have slipped back onto what is near it or far off, or it is pressed together. */
static void put_net(struct net *net, int round) {
    const double slip[] = {0, 9, 34, 0}, pressed[] = {1, 1, 1, 0.1};
    const int kind = round % 4, from = (int)(10 * roll());
    double radius = round % 3 ? 40 + 200 * fabs(roll()) : 4 + 8 * fabs(roll()), rise = 0.3 * roll();
    double shear = 0.6 * roll();
    for (int j = -NET_TILE; j < NET_TILE; j++)
        for (int i = -WIDE; i < WIDE; i++) {
            double along = i > from ? from + pressed[kind] * (i - from) - slip[kind] : i;
            double x = along + shear * j, turn = x / radius, out = radius + 0.1 * j;
            struct vec3 r = {out * sin(turn), out * cos(turn), j + rise * x};
            bool none = (slip[kind] > 0 && i == from) || (round % 5 == 0 && roll() > 0.95);
            struct net_node node = {.r = r, .state = none ? NET_FAILED : NET_INSIDE};
            assert_int_equal(net_put(net, i, j, &node), STATUS_OK);
        }
}

/* Whether a node of a tile is in the cells round one that is no neighbour. */
static bool tile_meets(struct net *net, const struct net_tile *tile, const double reach) {
    for (int k = 0; k < NET_TILE * NET_TILE; k++) {
        const struct net_node *node = &tile->node[k / NET_TILE][k % NET_TILE];
        int32_t at[2] = {tile->ti * NET_TILE + k % NET_TILE, tile->tj * NET_TILE + k / NET_TILE};
        for (int32_t j = -NET_TILE; node->state == NET_INSIDE && j < NET_TILE; j++)
            for (int32_t i = -WIDE; i < WIDE; i++) {
                const struct net_node *other = net_find(net, i, j);
                bool near = abs(i - at[0]) <= 3 && abs(j - at[1]) <= 3;
                if (near || other->state != NET_INSIDE ||
                    !(vec3_distance(other->r, node->r) < reach))
                    continue;
                struct net_window w = net_window(net, i >> NET_TILE_BITS, j >> NET_TILE_BITS);
                if (in_cells(&w, i & (NET_TILE - 1), j & (NET_TILE - 1), node->r))
                    return true;
            }
    }
    return false;
}

static void test_separation_of_tiles_is_right_of_every_node(void **state) {
    const double spacing[2] = {1, 1};
    int apart = 0, meet = 0;
    (void)state;
    dice = check_seed(2);
    for (int round = 0; round < NETS; round++) {
        struct arena_mark mark = arena_mark(arena);
        struct net net;
        assert_int_equal(net_make(&net, arena, false), STATUS_OK);
        put_net(&net, round);
        struct net_tile **tiles = net_sorted_tiles(&net);
        const enum overlap_tile *what = tiles ? overlap_look(&net, tiles, spacing) : NULL;
        assert_non_null(what);
        for (size_t t = 0; t < net_tile_count(&net); t++) {
            bool meets = tile_meets(&net, tiles[t], 2.1);
            meet += meets;
            apart += what[t] != OVERLAP_TILE_SUSPECT;
            if (meets)
                assert_int_equal(what[t], OVERLAP_TILE_SUSPECT);
        }
        arena_rewind(arena, mark);
    }
    printf("  tiles: %d apart, %d meet others\n", apart, meet);
    check_above(apart, NETS);
    check_above(meet, NETS);
}

int main(void) {
    const struct CMUnitTest tests[] = {
        cmocka_unit_test_setup_teardown(test_separation_is_right_of_every_node, set_up, tear_down),
        cmocka_unit_test_setup_teardown(test_separation_of_tiles_is_right_of_every_node, set_up,
                                        tear_down)};
    return cmocka_run_group_tests(tests, NULL, NULL);
}
