/* SPDX-License-Identifier: MIT */
#include "shear_error.h"

#include "estimate.h"
#include "solver/angle.h"
#include "solver/net/shear.h"
#include "solver/wide.h"
#include <string.h>

/* The nodes of a fifth difference, and those in whose reach it is told: five to each side. */
enum { FIFTH = 6, WINDOWS = FIFTH, SIDE = FIFTH - 1, AROUND = NET_TILE + 2 * SIDE };

/* What stencils leave of the tangent, as shares of the fifth difference: centred ones, those one
 * place off, and those at an end. */
static const double centred = 1.0 / 30, off_one = 1.0 / 20, at_end = 1.0 / 5;

/* How often that may be more, since differences change from node to node; and the share of all of
 * them that is added to those across, which may pass zero just there. */
static const double stencil_share = 2.5, passing_share = 0.1;

/* Rounding of the nodes, in radians. */
static const double shear_floor = 1e-10;

/* Yarns that cross under less than this cosine of the shear are taken as crossing so. */
static const double least_cosine = 0.02;

/* The nodes of a tile and those around it: by coordinates, and where there are any, bit SIDE + x of
 * a row; of the net before the errors, by coordinates. */
struct around {
    double r[3][AROUND][AROUND];
    uint32_t place[AROUND], known[AROUND];
    double error[ESTIMATE_MODES][3][AROUND][AROUND];
};

static void load_around(const struct net_window *net, const struct net_window *before,
                        struct around *a) {
    for (int y = 0; y < AROUND; y++) {
        bool crossed = y >= SIDE - 1 && y <= SIDE + NET_TILE;
        a->place[y] = a->known[y] = 0;
        for (int x = 0; x < AROUND; x++) {
            const struct net_node *node = net_window_place(net, x - SIDE, y - SIDE);
            struct vec3 r = node ? node->r : vec3_make(0, 0, 0);
            vec3_to_columns(r, a->r[0][y], a->r[1][y], a->r[2][y], (size_t)x);
            a->place[y] |= (uint32_t)(node != NULL) << x;
            if (!crossed || x < SIDE - 1 || x > SIDE + NET_TILE)
                continue;
            const struct net_node *kept = net_window_place(before, x - SIDE, y - SIDE);
            a->known[y] |= (uint32_t)(kept != NULL) << x;
            for (int mode = 0; mode < ESTIMATE_MODES; mode++) {
                struct vec3 e = kept ? estimate_error(kept, (enum estimate_mode)mode) : r;
                vec3_to_columns(e, a->error[mode][0][y], a->error[mode][1][y], a->error[mode][2][y],
                                (size_t)x);
            }
        }
    }
}

/* The bits of row y that have places from `from` to `to` along a family, each for the tile's own
 * columns: bit x. */
static uint32_t bits_along(const uint32_t *rows, int y, int family, int from, int to) {
    uint32_t all = (1u << NET_TILE) - 1;
    for (int k = from; k <= to; k++)
        all &= family ? rows[y + SIDE + k] >> SIDE : rows[y + SIDE] >> (SIDE + k);
    return all;
}

static void lanes_of_bits(uint32_t bits, double lane[NET_TILE]) {
    for (int x = 0; x < NET_TILE; x++)
        lane[x] = bits >> x & 1;
}

/* For a row, of each family: the weights of the fifth differences, those of the place before and
 * after for tangents and for errors, and the stencils' shares. */
struct row_weights {
    double window[2][WINDOWS][NET_TILE], back[2][NET_TILE], ahead[2][NET_TILE];
    double error_back[2][NET_TILE], error_ahead[2][NET_TILE], share[2][NET_TILE];
    uint32_t told; /* the places of which the net says something, bits */
};

static void weigh_row(const struct around *a, int y, struct row_weights *w) {
    w->told = bits_along(a->known, y, 0, 0, 0);
    for (int k = 0; k < 2; k++) {
        uint32_t any = 0;
        for (int n = 0; n < WINDOWS; n++) {
            uint32_t whole = bits_along(a->place, y, k, n - SIDE, n);
            any |= whole;
            lanes_of_bits(whole, w->window[k][n]);
        }
        uint32_t two = bits_along(a->place, y, k, -2, 2);
        uint32_t one = bits_along(a->place, y, k, -1, 3) | bits_along(a->place, y, k, -3, 1);
        for (int x = 0; x < NET_TILE; x++)
            w->share[k][x] = two >> x & 1 ? centred : one >> x & 1 ? off_one : at_end;
        lanes_of_bits(bits_along(a->place, y, k, -1, 0), w->back[k]);
        lanes_of_bits(bits_along(a->place, y, k, 0, 1), w->ahead[k]);
        lanes_of_bits(bits_along(a->known, y, k, -1, 0), w->error_back[k]);
        lanes_of_bits(bits_along(a->known, y, k, 0, 1), w->error_ahead[k]);
        w->told &= any & (bits_along(a->known, y, k, -1, 0) | bits_along(a->known, y, k, 0, 1));
    }
}

/* The step of a row of values along a yarn: over both sides of a place half of it, over one all. */
INLINE double row_step(const double *at, int x, int step, double back, double ahead) {
    double both = back * ahead, by = both > 0 ? 0.5 : 1;
    return by * (ahead * (at[x + step] - at[x]) + back * (at[x] - at[x - step]));
}

/* Of a row: what the errors of nodes and, in `left`, what stencils leave of the shear, in radians.
 */
WIDE_CLONES
static void row_errors(const struct around *a, const struct row_weights *w, int y,
                       const double spacing[2], double nodes[NET_TILE], double left[NET_TILE]) {
    static const int step[2] = {1, AROUND};
    double along[2][3][NET_TILE], across[2][3][NET_TILE], inverse[NET_TILE];
    for (int k = 0; k < 2; k++)
        for (int x = 0; x < NET_TILE; x++) {
            double square = 0;
            for (int c = 0; c < 3; c++) {
                along[k][c][x] =
                    row_step(&a->r[c][y + SIDE][SIDE], x, step[k], w->back[k][x], w->ahead[k][x]);
                square += along[k][c][x] * along[k][c][x];
            }
            double size = 1 / sqrt(square > 0 ? square : 1);
            for (int c = 0; c < 3; c++)
                along[k][c][x] *= size;
        }
    for (int x = 0; x < NET_TILE; x++) {
        double sine = 0;
        for (int c = 0; c < 3; c++)
            sine += along[0][c][x] * along[1][c][x];
        double square = 1 - sine * sine, least2 = least_cosine * least_cosine;
        inverse[x] = 1 / sqrt(square > least2 ? square : least2);
        for (int k = 0; k < 2; k++)
            for (int c = 0; c < 3; c++)
                across[k][c][x] = (along[1 - k][c][x] - sine * along[k][c][x]) * inverse[x];
        nodes[x] = left[x] = 0;
    }
    for (int k = 0; k < 2; k++) {
        int s = step[k];
        double most[NET_TILE] = {0};
        for (int n = 0; n < WINDOWS; n++)
            for (int x = 0; x < NET_TILE; x++) {
                double dot = 0, square = 0;
                for (int c = 0; c < 3; c++) {
                    const double *p = &a->r[c][y + SIDE][SIDE + x] + (n - SIDE) * s;
                    double d = p[5 * s] - p[0] + 5 * (p[s] - p[4 * s]) + 10 * (p[3 * s] - p[2 * s]);
                    dot += d * across[k][c][x];
                    square += d * d;
                }
                double size = (fabs(dot) + passing_share * sqrt(square)) * w->window[k][n][x];
                most[x] = size > most[x] ? size : most[x];
            }
        for (int x = 0; x < NET_TILE; x++)
            left[x] += stencil_share * w->share[k][x] * most[x] / spacing[k];
    }
    for (int mode = 0; mode < ESTIMATE_MODES; mode++)
        for (int x = 0; x < NET_TILE; x++) {
            double by = 0;
            for (int k = 0; k < 2; k++)
                for (int c = 0; c < 3; c++)
                    by += row_step(&a->error[mode][c][y + SIDE][SIDE], x, step[k],
                                   w->error_back[k][x], w->error_ahead[k][x]) *
                          across[k][c][x] / spacing[k];
            nodes[x] += (mode == ESTIMATE_KNOWN ? estimate_share_of_known : 1) * fabs(by);
        }
}

/* By how much the directions of the edges differ sideways at a node and at those beside it on the
 * yarn, the most of it; -1 where that is not known of any. */
static double turn_error(struct defect_net *net, int32_t i, int32_t j, int di, int dj) {
    double most = -1;
    for (int side = -1; side <= 1; side += 2) {
        double end[2];
        if (!net_view_place(&net->net, i + side * di, j + side * dj))
            continue;
        (void)defect_turn(net, i, j, side * di, side * dj, end);
        most = fmax(most, fmax(end[0], end[1]));
    }
    return most;
}

void shear_error_of_tile(struct defect_net *net, const struct net_view *before,
                         double error_deg[NET_TILE][NET_TILE]) {
    const struct net_window *window = &net->net.window;
    const struct net_tile *tile = window->tile[1][1];
    bool any_rough = net_has_rough(net->net.net);
    struct around around;
    load_around(window, &before->window, &around);
    for (int y = 0; y < NET_TILE; y++) {
        uint32_t inside = tile->bits[NET_BIT_INSIDE][y];
        uint32_t rough = any_rough ? net_window_near_rough(window, y, SHEAR_REACH) : 0;
        double nodes[NET_TILE], left[NET_TILE];
        struct row_weights weights;
        if (!inside)
            continue;
        weigh_row(&around, y, &weights);
        row_errors(&around, &weights, y, net->spacing, nodes, left);
        for (uint32_t bits = inside; bits; bits &= bits - 1) {
            int x = __builtin_ctz(bits);
            int32_t i = tile->ti * NET_TILE + x, j = tile->tj * NET_TILE + y;
            bool told = weights.told >> x & 1;
            if (rough >> x & 1) {
                double turn[2] = {turn_error(net, i, j, 1, 0), turn_error(net, i, j, 0, 1)};
                told = turn[0] >= 0 && turn[1] >= 0;
                left[x] = turn[0] + turn[1];
            }
            double sum = shear_floor + nodes[x] + left[x];
            error_deg[y][x] = told ? fmin(sum * (180 / ANGLE_PI), 180) : -1;
        }
    }
}
