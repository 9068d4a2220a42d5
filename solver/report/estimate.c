/* SPDX-License-Identifier: MIT */
#include "estimate.h"

#include "defect.h"
#include "solver/team.h"
#include "solver/wide.h"
#include <stddef.h>
#include <stdlib.h>
#include <string.h>

/* What a step straight on is wrong by, across the yarn, of what the yarn beside it turns sideways;
 * as a share of its length where there is no telling, and where the yarn sets off across another.
 */
static const double straight_share = 10, straight_unknown = 0.03, across_share = 0.3;

/* How well a generator is followed over an edge: this share of it, times the fourth power of the
 * angle by which it turns there. */
static const double generator_share = 1e-3;

/* Yarns that cross under less than this sine are taken as crossing so. */
static const double least_sine = 0.02;

/* What the estimate takes of the sum of what is known of the defects; of the others once. */
const double estimate_share_of_known = 3;

/* A node's error, to first order. */
struct error {
    struct vec3 of[ESTIMATE_MODES];
};

/* How it is kept, by coordinates, in place of the node of the net before. */
struct kept {
    float of[3][ESTIMATE_MODES], estimate;
};

/* The mark of one that is to be estimated later, in place of what edges are rough. */
enum { AWAITED = 0x3f };

_Static_assert(sizeof(struct kept) <= offsetof(struct net_node, uv) + sizeof(double[2]),
               "a node's place and uv");

struct estimate {
    struct defect_net net;
    struct net_view before;
    struct net *kept; /* the net of `before` */
};

static bool error_at(const struct estimate *e, int32_t i, int32_t j, struct error *error) {
    const struct net_node *node = net_view_place(&e->before, i, j);
    if (!node || node->rough == AWAITED)
        return false;
    estimate_errors(node, error->of);
    return true;
}

/* No node of either net is further from the start than its yarns are long. */
static double most_at(const struct estimate *e, int32_t i, int32_t j) {
    const double *d = e->net.spacing;
    return 2 * ((double)labs(i) * d[0] + (double)labs(j) * d[1]);
}

static void keep_error(const struct estimate *e, int32_t i, int32_t j, const struct error *error) {
    double most = most_at(e, i, j);
    double sum = estimate_share_of_known * vec3_norm(error->of[ESTIMATE_KNOWN]) +
                 vec3_norm(error->of[ESTIMATE_LONGER]) + vec3_norm(error->of[ESTIMATE_APART]);
    struct kept kept = {.estimate = (float)(sum < most ? sum : most)};
    if (!net_view_place(&e->before, i, j))
        return;
    for (int k = 0; k < ESTIMATE_MODES; k++) {
        kept.of[0][k] = (float)error->of[k].x;
        kept.of[1][k] = (float)error->of[k].y;
        kept.of[2][k] = (float)error->of[k].z;
    }
    struct net_node *node = net_find(e->kept, i, j);
    memcpy(node, &kept, sizeof kept);
    node->rough = 0;
}

/* One end of an edge that a node hangs on: the chord from there, the error there, and the defect of
 * the edge. */
struct link {
    struct vec3 chord;
    struct error from;
    struct defect edge;
};

static bool find_estimate_link(struct estimate *e, int32_t i, int32_t j, int di, int dj,
                               struct link *link) {
    const struct net_node *from = net_view_place(&e->net.net, i - di, j - dj);
    const struct net_node *to = net_view_place(&e->net.net, i, j);
    if (!from || !error_at(e, i - di, j - dj, &link->from))
        return false;
    link->chord = vec3_unit(vec3_sub(to->r, from->r));
    link->edge = defect_of(&e->net, i - di, j - dj, di, dj);
    return true;
}

INLINE double inverse_sine2(double cosine) {
    double sine2 = 1 - cosine * cosine, least2 = least_sine * least_sine;
    return 1 / (sine2 > least2 ? sine2 : least2);
}

/* Of the fourth corner of a cell in the direction (si, sj) of its A: along BD it is that of B and
 * of the edge, along CD that of C and of the edge. Where the net does not say what the node hangs
 * on it is that of a neighbour, or a spacing. */
static void cell_error(struct estimate *e, int32_t i, int32_t j, int si, int sj,
                       struct error *error) {
    const double *d = e->net.spacing;
    struct link b, c;
    if (!find_estimate_link(e, i, j, si, 0, &b) || !find_estimate_link(e, i, j, 0, sj, &c)) {
        if (!error_at(e, i - si, j, error) && !error_at(e, i, j - sj, error))
            *error = (struct error){.of[ESTIMATE_LONGER] = {fmax(d[0], d[1]), 0, 0}};
        return;
    }
    double cosine = vec3_dot(b.chord, c.chord), inverse = inverse_sine2(cosine);
    const double by_b[ESTIMATE_MODES] = {b.edge.known, b.edge.unsure, b.edge.unsure};
    const double by_c[ESTIMATE_MODES] = {c.edge.known, c.edge.unsure, -c.edge.unsure};
    for (int k = 0; k < ESTIMATE_MODES; k++) {
        double x = vec3_dot(b.chord, b.from.of[k]) + by_b[k];
        double y = vec3_dot(c.chord, c.from.of[k]) + by_c[k];
        error->of[k] = vec3_axpy((x - cosine * y) * inverse, b.chord,
                                 vec3_scale((y - cosine * x) * inverse, c.chord));
    }
}

/* Of a node by a yarn from Q = (i - di, j - dj): it goes on as it went before Q, and a step aside.
 */
static void error_of_step(struct estimate *e, const struct march_step *s, struct error *error) {
    int family = s->di ? 0 : 1;
    double d = e->net.spacing[family];
    int32_t i = s->i, j = s->j;
    struct error from, last;
    const struct net_node *q = net_view_place(&e->net.net, i - s->di, j - s->dj);
    const struct net_node *node = net_view_place(&e->net.net, i, j);
    *error = (struct error){.of[ESTIMATE_LONGER] = {d, 0, 0}};
    if (!q || !node || !error_at(e, i - s->di, j - s->dj, &from))
        return;
    struct vec3 chord = vec3_unit(vec3_sub(node->r, q->r));
    struct vec3 other = fabs(chord.x) < 0.6 ? vec3_make(1, 0, 0) : vec3_make(0, 1, 0);
    struct surface_point point;
    struct vec3 normal =
        surface_point_at(march_surface(e->net.march, node), &e->net.cursor, node->uv, &point)
            ? point.normal
            : other;
    struct vec3 across = vec3_unit(vec3_cross(normal, chord));
    bool straight = s->way == MARCH_STRAIGHT && error_at(e, i - 2 * s->di, j - 2 * s->dj, &last);
    double step = across_share * d;
    if (straight) {
        /* the yarn beside it turns sideways, and it does not, for the part of a spacing by which
         * the free edge may lie nearer */
        double most = -1, end[2];
        for (int side = -1; side <= 1; side += 2) {
            int32_t bi = i - s->di + side * (s->dj != 0), bj = j - s->dj + side * (s->di != 0);
            if (net_view_place(&e->net.net, bi, bj) &&
                net_view_place(&e->net.net, bi + s->di, bj + s->dj))
                most = fmax(most, defect_turn(&e->net, bi, bj, s->di, s->dj, end));
        }
        step = d * (most < 0 ? straight_unknown : straight_share * most);
    }
    for (int k = 0; k < ESTIMATE_MODES; k++) {
        double aside = straight ? vec3_dot(vec3_sub(from.of[k], last.of[k]), across) : 0;
        double more = k == ESTIMATE_KNOWN                        ? 0
                      : vec3_dot(from.of[k], across) + aside < 0 ? -step
                                                                 : step;
        error->of[k] = vec3_axpy(aside + more, across, from.of[k]);
    }
}

static void move_views(struct estimate *e, int32_t i, int32_t j) {
    net_view_move(&e->net.net, i, j);
    net_view_move(&e->before, i, j);
}

static bool estimate_awaited(const struct estimate *e, int32_t i, int32_t j) {
    const struct net_node *kept = net_view_place(&e->before, i, j);
    return kept && kept->rough == AWAITED;
}

/* The errors of a node side by side, by coordinates; the last lane is none. */
typedef double lanes __attribute__((vector_size(32)));

struct error_lanes {
    lanes of[3];
};

INLINE struct error_lanes lanes_error(const struct net_node *node) {
    struct error_lanes error;
    struct kept kept;
    memcpy(&kept, node, sizeof kept);
    for (int c = 0; c < 3; c++)
        error.of[c] =
            (lanes){(double)kept.of[c][ESTIMATE_KNOWN], (double)kept.of[c][ESTIMATE_LONGER],
                    (double)kept.of[c][ESTIMATE_APART], 0};
    return error;
}

/* Places `first`, first + si, .. before `end` of row y of a tile, whose edges are even. B of the
 * first is `b`, C are the places of `below`. No error is greater than `most` at x. */
struct even_run {
    const struct defect_tile *defects;
    int y, first, end, si;
    const struct net_node *b, *below;
    struct net_node *node;
    double most[NET_TILE];
};

WIDE_CLONES
static void estimate_run(const struct even_run *row) {
    const struct defect_tile *t = row->defects;
    const double(*b)[NET_TILE] = t->along[0][row->y], (*c)[NET_TILE] = t->along[1][row->y];
    double cosine[NET_TILE], inverse[NET_TILE], size[4 * NET_TILE] = {0};
    for (int x = 0; x < NET_TILE; x++) {
        cosine[x] = b[0][x] * c[0][x] + b[1][x] * c[1][x] + b[2][x] * c[2][x];
        inverse[x] = inverse_sine2(cosine[x]);
    }
    struct error_lanes error = lanes_error(row->b);
    for (int x = row->first; x != row->end; x += row->si) {
        /* as cell_error */
        struct error_lanes at_c = lanes_error(&row->below[x]);
        double unsure_b = t->unsure[0][row->y][x], unsure_c = t->unsure[1][row->y][x];
        lanes p = {t->known[0][row->y][x], unsure_b, unsure_b, 0};
        lanes q = {t->known[1][row->y][x], unsure_c, -unsure_c, 0}, size2 = {0};
        struct kept kept;
        for (int k = 0; k < 3; k++) {
            p += b[k][x] * error.of[k];
            q += c[k][x] * at_c.of[k];
        }
        lanes by_b = (p - cosine[x] * q) * inverse[x], by_c = (q - cosine[x] * p) * inverse[x];
        for (int k = 0; k < 3; k++) {
            error.of[k] = by_b * b[k][x] + by_c * c[k][x];
            size2 += error.of[k] * error.of[k];
            for (int n = 0; n < ESTIMATE_MODES; n++)
                kept.of[k][n] = (float)error.of[k][n];
        }
        kept.estimate = 0;
        memcpy(&size[4 * x], &size2, sizeof size2);
        memcpy(&row->node[x], &kept, sizeof kept);
    }
    for (int n = 0; n < 4 * NET_TILE; n++)
        size[n] = sqrt(size[n]);
    for (int x = row->first; x != row->end; x += row->si) {
        const double *of = &size[4 * x];
        double sum =
            estimate_share_of_known * of[ESTIMATE_KNOWN] + of[ESTIMATE_LONGER] + of[ESTIMATE_APART];
        float estimate = (float)(sum < row->most[x] ? sum : row->most[x]);
        memcpy((char *)&row->node[x] + offsetof(struct kept, estimate), &estimate, sizeof estimate);
    }
}

/* Row y of a tile: those of its places together that are `even` and hang on estimated ones. */
static void estimate_row(struct estimate *e, const struct net_tile *tile,
                         const struct defect_tile *defects, int y) {
    int si = tile->ti < 0 ? -1 : 1, sj = tile->tj < 0 ? -1 : 1;
    int32_t i = tile->ti * NET_TILE, j = tile->tj * NET_TILE + y;
    const struct net_window *before = &e->before.window;
    uint64_t own = net_window_plain(before, y), below = net_window_plain(before, y - sj);
    uint64_t hung = own & below & (si > 0 ? own << 1 : own >> 1);
    uint32_t even = defects->even[y] & (uint32_t)(hung >> NET_TILE);
    if (j == 0)
        return;
    if (i == 0)
        even &= ~1u;
    struct even_run run = {defects, y, .si = si, .node = even ? net_find(e->kept, i, j) : NULL};
    for (int x = 0; x < NET_TILE; x++)
        run.most[x] = most_at(e, i + x, j);
    run.below = net_window_find(before, 0, y - sj);
    int end = si > 0 ? NET_TILE : -1;
    for (int x = si > 0 ? 0 : NET_TILE - 1; x != end;) {
        if (!(even >> x & 1)) {
            struct error error;
            bool here = i + x != 0 && net_view_place(&e->net.net, i + x, j);
            if (here && !estimate_awaited(e, i + x, j)) {
                cell_error(e, i + x, j, si, sj, &error);
                keep_error(e, i + x, j, &error);
            }
            x += si;
            continue;
        }
        run.first = x;
        run.b = net_window_find(before, x - si, y);
        while (x != end && even >> x & 1)
            x += si;
        run.end = x;
        estimate_run(&run);
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
            struct estimate *e = &task->estimate;
            struct defect_tile defects;
            if ((tile->ti < 0) != left || (tile->tj < 0) != down)
                continue;
            move_views(e, tile->ti * NET_TILE, tile->tj * NET_TILE);
            defect_of_tile(&e->net, &e->net.net.window, &defects);
            for (int y = 0; y < NET_TILE; y++)
                estimate_row(e, tile, &defects, down ? NET_TILE - 1 - y : y);
        }
    }
}

/* Where weft slides an error changes the lengths of the edges that it goes on over, and the sums do
 * not hold: there the correction itself bounds what is left of it. */
static void estimate_by_correction(struct estimate *e, struct net_tile *const *tiles) {
    for (size_t t = 0; t < net_tile_count(e->net.march->net); t++)
        for (int at = 0; at < NET_TILE * NET_TILE; at++) {
            int x = at % NET_TILE, y = at / NET_TILE;
            int32_t i = tiles[t]->ti * NET_TILE + x, j = tiles[t]->tj * NET_TILE + y;
            move_views(e, i, j);
            const struct net_node *before = net_view_place(&e->before, i, j);
            const struct net_node *node = net_view_place(&e->net.net, i, j);
            if (before && node)
                keep_error(e, i, j,
                           &(struct error){.of[ESTIMATE_LONGER] = vec3_sub(node->r, before->r)});
        }
}

enum status estimate_make(struct march *march) {
    static const int8_t side[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
    const struct error exact = {{{0, 0, 0}, {0, 0, 0}, {0, 0, 0}}};
    struct estimate e = {
        .net = {.march = march, .net = net_view(march->net), .spacing = march->settings->spacing},
        .before = net_view(march->first),
        .kept = march->first};
    struct net_tile **tiles = net_sorted_tiles(march->net);
    struct task task[NET_TABLES];
    if (!tiles)
        return STATUS_OUT_OF_MEMORY;
    if (march->settings->slide > 0) {
        estimate_by_correction(&e, tiles);
        return STATUS_OK;
    }
    /* Nodes that the growth placed are estimated later, and are plain no longer. */
    for (size_t k = 0; k < march->grown.count; k++) {
        const struct march_step *step = &march->grown.step[k];
        struct net_node *node = net_find(e.kept, step->i, step->j);
        if (!node)
            continue;
        node->rough = AWAITED;
        net_mark_grown(e.kept, step->i, step->j);
    }
    keep_error(&e, 0, 0, &exact);
    /* The nodes of an arm lie on the generator: only how far along it is not exact. */
    for (int k = 0; k < 4; k++) {
        int di = side[k][0], dj = side[k][1];
        struct vec3 last = vec3_make(0, 0, 0);
        double known = 0, unsure = 0;
        for (int32_t i = di, j = dj;; i += di, j += dj) {
            struct link link;
            move_views(&e, i, j);
            if (!net_view_place(&e.net.net, i, j) || estimate_awaited(&e, i, j) ||
                !find_estimate_link(&e, i, j, di, dj, &link))
                break;
            known += link.edge.known;
            double turn2 = vec3_norm2(last) > 0 ? vec3_norm2(vec3_sub(link.chord, last)) : 0;
            unsure += link.edge.unsure + generator_share * turn2 * turn2 * e.net.spacing[dj != 0];
            last = link.chord;
            struct error error = {{vec3_scale(known, link.chord), vec3_scale(unsure, link.chord),
                                   vec3_scale(dj ? -unsure : unsure, link.chord)}};
            keep_error(&e, i, j, &error);
        }
    }
    for (int k = 0; k < NET_TABLES; k++)
        task[k] = (struct task){e, tiles, net_tile_count(march->net)};
    team_run(march->settings->team, NET_TABLES, estimate_quadrant, task);
    for (size_t k = 0; k < march->grown.count; k++) { /* in the order of the growth */
        const struct march_step *s = &march->grown.step[k];
        struct error error;
        move_views(&e, s->i, s->j);
        if (s->way != MARCH_CELL)
            error_of_step(&e, s, &error);
        else
            cell_error(&e, s->i, s->j, s->di, s->dj, &error);
        keep_error(&e, s->i, s->j, &error);
    }
    return STATUS_OK;
}

double estimate_of(const struct net_node *before) {
    struct kept kept;
    memcpy(&kept, before, sizeof kept);
    return (double)kept.estimate;
}

void estimate_errors(const struct net_node *before, struct vec3 error[ESTIMATE_MODES]) {
    struct kept kept;
    memcpy(&kept, before, sizeof kept);
    for (int k = 0; k < ESTIMATE_MODES; k++)
        error[k] = vec3_make(kept.of[0][k], kept.of[1][k], kept.of[2][k]);
}
