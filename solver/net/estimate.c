/* SPDX-License-Identifier: MIT */
#include "estimate.h"

#include "defect.h"
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

/* What a step straight on is wrong by, across the yarn, of what the yarn beside it turns sideways;
 * as a share of its length where there is no telling, and where the yarn sets off across another.
 */
static const double straight_share = 3, straight_unknown = 0.03, across_share = 0.3;

/* How well a generator is followed over an edge: this share of it, times the fourth power of the
 * angle by which it turns there. */
static const double generator_share = 1e-3;

/* Yarns that cross under less than this sine are taken as crossing so. */
static const double least_sine = 0.02;

/* What the estimate takes of the sum of what is known of the defects; of the others once. */
static const double share_of_known = 3;

/* A node's error, to first order: by what is known of the edges, and by what is not, once with both
 * families longer by it, once with warp longer and weft shorter. */
enum { KNOWN, LONGER, APART, ERRORS };

struct error {
    struct vec3 of[ERRORS];
};

/* How it is kept, in place of the node of the net before. */
struct kept {
    float of[ERRORS][3], estimate;
};

/* The mark of one that is to be estimated later, in place of what edges are rough. */
enum { AWAITED = 0xff };

_Static_assert(sizeof(struct kept) <= offsetof(struct net_node, rough), "a node's place and uv");

struct estimate {
    struct defect_net net;
    struct net_view before;
    struct net *kept; /* the net of `before` */
};

static bool error_at(const struct estimate *e, int32_t i, int32_t j, struct error *error) {
    const struct net_node *node = net_view_place(&e->before, i, j);
    struct kept kept;
    if (!node || node->rough == AWAITED)
        return false;
    memcpy(&kept, node, sizeof kept);
    for (int k = 0; k < ERRORS; k++)
        error->of[k] =
            vec3_make((double)kept.of[k][0], (double)kept.of[k][1], (double)kept.of[k][2]);
    return true;
}

/* No node of either net is further from the start than its yarns are long. */
static void keep_error(const struct estimate *e, int32_t i, int32_t j, const struct error *error) {
    const double *d = e->net.spacing;
    double most = 2 * ((double)labs(i) * d[0] + (double)labs(j) * d[1]);
    double sum = share_of_known * vec3_norm(error->of[KNOWN]) + vec3_norm(error->of[LONGER]) +
                 vec3_norm(error->of[APART]);
    struct kept kept = {.estimate = (float)(sum < most ? sum : most)};
    if (!net_view_place(&e->before, i, j))
        return;
    for (int k = 0; k < ERRORS; k++) {
        kept.of[k][0] = (float)error->of[k].x;
        kept.of[k][1] = (float)error->of[k].y;
        kept.of[k][2] = (float)error->of[k].z;
    }
    struct net_node *node = net_find(e->kept, i, j);
    memcpy(node, &kept, sizeof kept);
    node->rough = 0;
}

/* One end of an edge that a node hangs on: the chord from there, the error there, and the defect of
 * the edge, which may be known (else NULL). */
struct link {
    struct vec3 chord;
    struct error from;
    struct defect edge;
};

static bool find_link(struct estimate *e, int32_t i, int32_t j, int di, int dj,
                      const struct defect *edge, struct link *link) {
    const struct net_node *from = net_view_place(&e->net.net, i - di, j - dj);
    const struct net_node *to = net_view_place(&e->net.net, i, j);
    if (!from || !error_at(e, i - di, j - dj, &link->from))
        return false;
    link->chord = vec3_unit(vec3_sub(to->r, from->r));
    link->edge = edge ? *edge : defect_of(&e->net, i - di, j - dj, di, dj);
    return true;
}

/* Of the fourth corner of a cell in the direction (si, sj) of its A: along BD it is that of B and
 * of the edge, along CD that of C and of the edge. */
static bool cell_error(struct estimate *e, int32_t i, int32_t j, int si, int sj,
                       const struct defect *const edge[2], struct error *error) {
    struct link b, c;
    if (!find_link(e, i, j, si, 0, edge[0], &b) || !find_link(e, i, j, 0, sj, edge[1], &c))
        return false;
    double cosine = vec3_dot(b.chord, c.chord), sine2 = 1 - cosine * cosine;
    double inverse = 1 / (sine2 > least_sine * least_sine ? sine2 : least_sine * least_sine);
    const double by_b[ERRORS] = {b.edge.known, b.edge.unsure, b.edge.unsure};
    const double by_c[ERRORS] = {c.edge.known, c.edge.unsure, -c.edge.unsure};
    for (int k = 0; k < ERRORS; k++) {
        double x = vec3_dot(b.chord, b.from.of[k]) + by_b[k];
        double y = vec3_dot(c.chord, c.from.of[k]) + by_c[k];
        error->of[k] = vec3_axpy((x - cosine * y) * inverse, b.chord,
                                 vec3_scale((y - cosine * x) * inverse, c.chord));
    }
    return true;
}

/* Of a node of which the net does not say what it hangs on: that of a neighbour, or a spacing. */
static void loose_error(const struct estimate *e, int32_t i, int32_t j, int si, int sj,
                        struct error *error) {
    const double *d = e->net.spacing;
    if (!error_at(e, i - si, j, error) && !error_at(e, i, j - sj, error))
        *error = (struct error){.of[LONGER] = {fmax(d[0], d[1]), 0, 0}};
}

/* By how much a step straight on goes aside, in length: the yarn beside it turns sideways, and it
 * does not, for the part of a spacing by which the free edge may lie nearer. */
static double straight_error(struct estimate *e, int32_t i, int32_t j, int di, int dj) {
    double d = e->net.spacing[di == 0], most = -1;
    for (int side = -1; side <= 1; side += 2) {
        int32_t bi = i - di + side * (dj != 0), bj = j - dj + side * (di != 0);
        double turn;
        if (net_view_place(&e->net.net, bi, bj) && net_view_place(&e->net.net, bi + di, bj + dj) &&
            defect_turn(&e->net, bi, bj, di, dj, &turn))
            most = fmax(most, turn);
    }
    return d * (most < 0 ? straight_unknown : straight_share * most);
}

/* Of a node by a yarn from Q = (i - di, j - dj): it goes on as it went before Q, and a step aside.
 */
static void step_error(struct estimate *e, const struct march_step *s, struct error *error) {
    int family = s->di ? 0 : 1;
    double d = e->net.spacing[family];
    int32_t i = s->i, j = s->j;
    struct error from, last;
    const struct net_node *q = net_view_place(&e->net.net, i - s->di, j - s->dj);
    const struct net_node *node = net_view_place(&e->net.net, i, j);
    *error = (struct error){.of[LONGER] = {d, 0, 0}};
    if (!q || !node || !error_at(e, i - s->di, j - s->dj, &from))
        return;
    struct vec3 chord = vec3_unit(vec3_sub(node->r, q->r));
    struct vec3 other = fabs(chord.x) < 0.6 ? vec3_make(1, 0, 0) : vec3_make(0, 1, 0);
    struct station station;
    struct vec3 normal =
        station_at(march_surface(e->net.march, node), &e->net.cursor, node->uv, &station)
            ? station.normal
            : other;
    struct vec3 across = vec3_unit(vec3_cross(normal, chord));
    bool straight = s->way == MARCH_STRAIGHT && error_at(e, i - 2 * s->di, j - 2 * s->dj, &last);
    double step = straight ? straight_error(e, i, j, s->di, s->dj) : across_share * d;
    for (int k = 0; k < ERRORS; k++) {
        double aside = straight ? vec3_dot(vec3_sub(from.of[k], last.of[k]), across) : 0;
        double more = k == KNOWN ? 0 : vec3_dot(from.of[k], across) + aside < 0 ? -step : step;
        error->of[k] = vec3_axpy(aside + more, across, from.of[k]);
    }
}

static void move_views(struct estimate *e, int32_t i, int32_t j) {
    net_view_move(&e->net.net, i, j);
    net_view_move(&e->before, i, j);
}

static bool is_awaited(const struct estimate *e, int32_t i, int32_t j) {
    const struct net_node *kept = net_view_place(&e->before, i, j);
    return kept && kept->rough == AWAITED;
}

/* The nodes of an arm, which lie on the generator: only how far along it is not exact. */
static void estimate_arm(struct estimate *e, int di, int dj) {
    struct link link;
    struct vec3 last = vec3_make(0, 0, 0);
    double known = 0, unsure = 0;
    for (int32_t i = di, j = dj;; i += di, j += dj) {
        move_views(e, i, j);
        if (!net_view_place(&e->net.net, i, j) || is_awaited(e, i, j) ||
            !find_link(e, i, j, di, dj, NULL, &link))
            return;
        known += link.edge.known;
        double turn2 = vec3_norm2(last) > 0 ? vec3_norm2(vec3_sub(link.chord, last)) : 0;
        unsure += link.edge.unsure + generator_share * turn2 * turn2 * e->net.spacing[dj != 0];
        last = link.chord;
        struct error error = {{vec3_scale(known, link.chord), vec3_scale(unsure, link.chord),
                               vec3_scale(dj ? -unsure : unsure, link.chord)}};
        keep_error(e, i, j, &error);
    }
}

static void estimate_tile(struct estimate *e, const struct net_tile *tile) {
    int si = tile->ti < 0 ? -1 : 1, sj = tile->tj < 0 ? -1 : 1;
    struct defect_tile defects;
    const struct defect *edge[2] = {NULL, NULL};
    move_views(e, tile->ti * NET_TILE, tile->tj * NET_TILE);
    bool plain = defect_of_tile(&e->net, &e->net.net.window, &defects);
    for (int k = 0; k < NET_TILE * NET_TILE; k++) {
        int x = k % NET_TILE, y = k / NET_TILE;
        int32_t i = tile->ti * NET_TILE + (si < 0 ? NET_TILE - 1 - x : x);
        int32_t j = tile->tj * NET_TILE + (sj < 0 ? NET_TILE - 1 - y : y);
        struct error error;
        if (i == 0 || j == 0 || !net_view_place(&e->net.net, i, j) || is_awaited(e, i, j))
            continue;
        if (plain) {
            edge[0] = &defects.of[0][j & (NET_TILE - 1)][i & (NET_TILE - 1)];
            edge[1] = &defects.of[1][j & (NET_TILE - 1)][i & (NET_TILE - 1)];
        }
        if (!cell_error(e, i, j, si, sj, edge, &error))
            loose_error(e, i, j, si, sj, &error);
        keep_error(e, i, j, &error);
    }
}

/* The tiles of one quadrant, each after those between it and the generators. */
struct task {
    struct estimate estimate;
    struct net_tile **tiles;
    size_t count;
};

static void estimate_quadrant(void *data, int number) {
    struct task *task = &((struct task *)data)[number];
    bool left = number % 2, down = number / 2;
    size_t all = task->count;
    for (size_t k = 0, end; k < all; k = end) {
        int32_t row = task->tiles[down ? all - 1 - k : k]->tj;
        for (end = k; end < all && task->tiles[down ? all - 1 - end : end]->tj == row;)
            end++;
        size_t low = down ? all - end : k, count = end - k;
        for (size_t n = 0; n < count; n++) {
            const struct net_tile *tile = task->tiles[low + (left ? count - 1 - n : n)];
            if ((tile->ti < 0) == left && (tile->tj < 0) == down)
                estimate_tile(&task->estimate, tile);
        }
    }
}

/* Marks the nodes that the growth placed, which are to be estimated in its order. */
static void mark_steps(struct estimate *e, const struct march_steps *steps) {
    for (size_t k = 0; k < steps->count; k++) {
        struct net_node *node = net_find(e->kept, steps->step[k].i, steps->step[k].j);
        if (node)
            node->rough = AWAITED;
    }
}

static void estimate_steps(struct estimate *e, const struct march_steps *steps) {
    static const struct defect *const unknown[2] = {NULL, NULL};
    for (size_t k = 0; k < steps->count; k++) {
        const struct march_step *s = &steps->step[k];
        struct error error;
        move_views(e, s->i, s->j);
        if (s->way != MARCH_CELL)
            step_error(e, s, &error);
        else if (!cell_error(e, s->i, s->j, s->di, s->dj, unknown, &error))
            loose_error(e, s->i, s->j, s->di, s->dj, &error);
        keep_error(e, s->i, s->j, &error);
    }
}

enum status estimate_make(struct march *march) {
    static const int8_t side[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
    const struct drape_team *team = march->settings->team;
    const struct error exact = {{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}};
    struct estimate e = {
        .net = {.march = march, .net = net_view(march->net), .spacing = march->settings->spacing},
        .before = net_view(march->first),
        .kept = march->first};
    struct net_tile **tiles = net_sorted_tiles(march->net);
    struct task task[NET_TABLES];
    if (!tiles)
        return STATUS_OUT_OF_MEMORY;
    mark_steps(&e, &march->grown);
    keep_error(&e, 0, 0, &exact);
    for (int k = 0; k < 4; k++)
        estimate_arm(&e, side[k][0], side[k][1]);
    for (int k = 0; k < NET_TABLES; k++)
        task[k] = (struct task){e, tiles, net_tile_count(march->net)};
    if (team)
        team->run(team->context, NET_TABLES, estimate_quadrant, task);
    for (int k = 0; !team && k < NET_TABLES; k++)
        estimate_quadrant(task, k);
    estimate_steps(&e, &march->grown);
    return STATUS_OK;
}

double estimate_of(const struct net_node *before) {
    struct kept kept;
    memcpy(&kept, before, sizeof kept);
    return (double)kept.estimate;
}
