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

/* The bits of a row of a window's places. */
static uint32_t around_bits(const struct net_window *window, int y) {
    uint64_t row = net_window_row(window, NET_BIT_PLACE, y) >> (NET_TILE - SIDE);
    return (uint32_t)row & ((1u << AROUND) - 1);
}

/* The positions of row y, one tile of the window after the other. */
static void load_row(const struct net_window *net, int y, struct around *a) {
    static const int first[4] = {-SIDE, 0, NET_TILE, NET_TILE + SIDE};
    for (int t = 0; t < 3; t++) {
        const struct net_node *node = net_window_find(net, first[t], y);
        for (int x = first[t]; x < first[t + 1]; x++) {
            struct vec3 r = node ? node++->r : vec3_make(0, 0, 0);
            vec3_to_columns(r, a->r[0][y + SIDE], a->r[1][y + SIDE], a->r[2][y + SIDE],
                            (size_t)(x + SIDE));
        }
    }
}

/* The errors at the places of row y and next to them; where there is none, 0. */
static void load_errors(const struct net_window *before, int y, struct around *a) {
    for (int x = -1; x <= NET_TILE; x++) {
        struct vec3 error[ESTIMATE_MODES] = {{0, 0, 0}};
        if (a->known[y + SIDE] >> (x + SIDE) & 1)
            estimate_errors(net_window_find(before, x, y), error);
        for (int mode = 0; mode < ESTIMATE_MODES; mode++) {
            double(*to)[AROUND][AROUND] = a->error[mode];
            vec3_to_columns(error[mode], to[0][y + SIDE], to[1][y + SIDE], to[2][y + SIDE],
                            (size_t)(x + SIDE));
        }
    }
}

static void load_around(const struct net_window *net, const struct net_window *before,
                        struct around *a) {
    const uint32_t crossed = ((1u << (NET_TILE + 2)) - 1) << (SIDE - 1);
    for (int y = -SIDE; y < NET_TILE + SIDE; y++) {
        bool own = y >= -1 && y <= NET_TILE;
        a->place[y + SIDE] = around_bits(net, y);
        a->known[y + SIDE] = own ? around_bits(before, y) & crossed : 0;
        load_row(net, y, a);
        if (own)
            load_errors(before, y, a);
    }
}

/* The bits of row y that have places from `from` to `to` along a family, each for the tile's own
 * columns: bit x. */
INLINE uint32_t bits_along(const uint32_t *rows, int y, int family, int from, int to) {
    uint32_t all = (1u << NET_TILE) - 1;
    for (int k = from; k <= to; k++)
        all &= family ? rows[y + SIDE + k] >> SIDE : rows[y + SIDE] >> (SIDE + k);
    return all;
}

/* Most rows are whole. */
INLINE void lanes_of_bits(uint32_t bits, double lane[NET_TILE]) {
    if (bits == (1u << NET_TILE) - 1)
        for (int x = 0; x < NET_TILE; x++)
            lane[x] = 1;
    else
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

WIDE_CLONES
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

/* The fifth differences of a family from the places on that are up to five before the tile's own,
 * and what is added of their size to those across. */
struct fifths {
    double of[3][NET_TILE + SIDE][NET_TILE + SIDE], passing[NET_TILE + SIDE][NET_TILE + SIDE];
};

INLINE void find_fifths_along(const struct around *a, int k, int rows, int columns,
                              struct fifths *f) {
    int s = k ? AROUND : 1;
    for (int y = 0; y < rows; y++) {
        for (int c = 0; c < 3; c++) {
            const double *p = &a->r[c][y + SIDE - k * SIDE][k * SIDE];
            double *to = f->of[c][y];
            for (int x = 0; x < columns; x++)
                to[x] = p[x + 5 * s] - p[x] + 5 * (p[x + s] - p[x + 4 * s]) +
                        10 * (p[x + 3 * s] - p[x + 2 * s]);
        }
        const double *u = f->of[0][y], *v = f->of[1][y], *w = f->of[2][y];
        for (int x = 0; x < columns; x++)
            f->passing[y][x] = passing_share * sqrt(u[x] * u[x] + v[x] * v[x] + w[x] * w[x]);
    }
}

/* Each is looked at by six places. */
WIDE_CLONES
static void find_fifths(const struct around *a, struct fifths fifths[2]) {
    find_fifths_along(a, 0, NET_TILE, NET_TILE + SIDE, &fifths[0]);
    find_fifths_along(a, 1, NET_TILE + SIDE, NET_TILE, &fifths[1]);
}

/* The step of a row of values along a yarn: over both sides of a place half of it, over one all. */
INLINE double row_step(const double *at, int x, int step, double back, double ahead) {
    double both = back * ahead, by = both > 0 ? 0.5 : 1;
    return by * (ahead * (at[x + step] - at[x]) + back * (at[x] - at[x - step]));
}

/* Of a row: what the errors of nodes and, in `left`, what stencils leave of the shear, in radians.
 */
WIDE_CLONES
static void row_errors(const struct around *a, const struct fifths fifths[2],
                       const struct row_weights *w, int y, const double spacing[2],
                       double nodes[NET_TILE], double left[NET_TILE]) {
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
        const struct fifths *f = &fifths[k];
        double most[NET_TILE] = {0};
        for (int n = 0; n < WINDOWS; n++)
            for (int x = 0; x < NET_TILE; x++) {
                int row = k ? y + n : y, at = k ? x : x + n;
                double dot = 0;
                for (int c = 0; c < 3; c++)
                    dot += f->of[c][row][at] * across[k][c][x];
                double size = (fabs(dot) + f->passing[row][at]) * w->window[k][n][x];
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
    struct fifths fifths[2];
    load_around(window, &before->window, &around);
    find_fifths(&around, fifths);
    for (int y = 0; y < NET_TILE; y++) {
        uint32_t inside = tile->bits[NET_BIT_INSIDE][y];
        uint32_t rough = any_rough ? net_window_near_rough(window, y, SHEAR_REACH) : 0;
        double nodes[NET_TILE], left[NET_TILE];
        struct row_weights weights;
        if (!inside)
            continue;
        weigh_row(&around, y, &weights);
        row_errors(&around, fifths, &weights, y, net->spacing, nodes, left);
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
