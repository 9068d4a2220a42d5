/* SPDX-License-Identifier: MIT */
#include "defect.h"

#include "correction.h"
#include "fishnet.h"
#include "rough.h"
#include "yarn.h"

/* Coefficients of defect.h. */
static const double by_fourth = 5.0 / 144 - 1.0 / 240, by_third = 1.0 / 720;

/* What is unsure of it: a share of it and of its terms, more where the yarn turns by much over the
 * edge; what solving leaves of an edge, as a share of its length; and where the net says nothing,
 * at the least where an edge is not rough, a turn sideways by this angle. */
static const double of_known = 0.2, of_terms = 1, of_turned = 10;
static const double rounding = 2e-12;
static const double unknown_turn = 0.05;

/* The net along one yarn about the edge from Q to P: D2 at the places -2 .. 3, counted from Q,
 * where there are any. None reaches over rough edges, or from nodes that have grown to others. */
enum { AT_Q = 2, AT_P, BENDS = 6 };

struct bends {
    struct vec3 of[BENDS];
    bool has[BENDS];
};

static void find_bends(const struct defect_net *net, int32_t i, int32_t j, int di, int dj,
                       struct bends *bends) {
    int family = di ? 0 : 1, ahead = di + dj > 0;
    unsigned out = NET_EDGE_BIT(family, ahead), in = NET_EDGE_BIT(family, 1 - ahead);
    const struct net_node *node[BENDS + 2];
    bool whole[BENDS + 1];
    for (int k = 0; k < BENDS + 2; k++) {
        int at = k - AT_Q - 1;
        node[k] = net_view_place(&net->net, i + at * di, j + at * dj);
        if (k > 0)
            whole[k - 1] = node[k] && node[k - 1] && !(node[k - 1]->rough & out) &&
                           !(node[k]->rough & in) && node[k]->grown == node[k - 1]->grown;
    }
    for (int k = 0; k < BENDS; k++) {
        bends->has[k] = whole[k] && whole[k + 1];
        if (bends->has[k])
            bends->of[k] = vec3_add(vec3_sub(node[k]->r, node[k + 1]->r),
                                    vec3_sub(node[k + 2]->r, node[k + 1]->r));
    }
}

/* a - 2 b + c */
static struct vec3 second(struct vec3 a, struct vec3 b, struct vec3 c) {
    return vec3_add(a, vec3_axpy(-2, b, c));
}

/* D4, the mean of both ends as far as there are differences for it. At a yarn's end, where there is
 * no D2, it is taken to go on evenly. */
static bool fourth_difference(struct bends *b, struct vec3 *d4) {
    struct vec3 *of = b->of;
    const bool *has = b->has;
    if (has[AT_Q] && has[AT_P]) {
        bool low = has[AT_Q - 1], high = has[AT_P + 1];
        struct vec3 at_q = low ? second(of[AT_Q - 1], of[AT_Q], of[AT_P]) : vec3_make(0, 0, 0);
        struct vec3 at_p = high ? second(of[AT_Q], of[AT_P], of[AT_P + 1]) : vec3_make(0, 0, 0);
        *d4 = vec3_scale(low && high ? 0.5 : 1, vec3_add(at_q, at_p));
        return low || high;
    }
    int end = has[AT_Q] ? AT_P : AT_Q, step = has[AT_Q] ? -1 : 1;
    if (!has[end + step] || !has[end + 2 * step] || !has[end + 3 * step])
        return false;
    *d4 = second(of[end + step], of[end + 2 * step], of[end + 3 * step]);
    of[end] = vec3_add(*d4, vec3_axpy(2, of[end + step], vec3_scale(-1, of[end + 2 * step])));
    return true;
}

/* By the differences; false where there are too few. At a yarn's end D2 may be wrong by D4. */
static bool by_differences(const struct bends *found, struct vec3 edge, double d,
                           struct defect *defect) {
    struct bends b = *found;
    struct vec3 d4;
    double chord;
    if (!fourth_difference(&b, &d4))
        return false;
    struct correction arc = {.bend = {b.of[AT_Q], b.of[AT_P]}, .d = d};
    struct vec3 mean = vec3_scale(0.5, vec3_add(b.of[AT_Q], b.of[AT_P]));
    struct vec3 d3 = vec3_sub(b.of[AT_P], b.of[AT_Q]);
    double q = vec3_norm2(mean) / (d * d), edge2 = vec3_norm2(edge);
    if (!correction_chord(&arc, &chord))
        return false;
    double fourth = by_fourth * vec3_dot(mean, vec3_axpy(q, mean, d4));
    double third = by_third * (vec3_norm2(d3) - q * q * edge2);
    double terms = fabs(fourth) + fabs(third);
    if (!found->has[AT_Q] || !found->has[AT_P])
        terms += vec3_norm(mean) * vec3_norm(d4) / 24;
    defect->known = (edge2 - chord * chord - fourth + third) / (2 * d);
    defect->unsure = of_known * fabs(defect->known) + (of_terms + of_turned * q) * terms / (2 * d) +
                     rounding * d;
    return true;
}

/* The angle by which the yarn at (i, j) that goes along (di, dj) turns sideways there, in the
 * surface; less than 0 when it is not known. */
static double turn_at(struct defect_net *net, int32_t i, int32_t j, int di, int dj) {
    int family = di ? 0 : 1, ahead = di + dj > 0;
    struct yarn_net yarns = {net->net.net, net->march->surface, &net->cursor};
    struct yarn_place place[3];
    struct station station;
    for (int k = 0; k < 3; k++) {
        int32_t at[2] = {i + (k - 1) * di, j + (k - 1) * dj};
        place[k] = (struct yarn_place){at[0], at[1], net_view_place(&net->net, at[0], at[1])};
        if (!place[k].node)
            return -1;
    }
    const struct net_node *node = place[1].node;
    if (!station_at(march_surface(net->march, node), &net->cursor, node->uv, &station))
        return -1;
    struct vec3 out = yarn_leave(&yarns, &place[1], &place[2], family, ahead, &station);
    struct vec3 back = yarn_leave(&yarns, &place[1], &place[0], family, 1 - ahead, &station);
    return fabs(vec3_dot(vec3_cross(out, back), station.normal));
}

bool defect_turn(struct defect_net *net, int32_t i, int32_t j, int di, int dj, double *turn) {
    double near = turn_at(net, i, j, di, dj), far = turn_at(net, i + di, j + dj, di, dj);
    *turn = near >= 0 && far >= 0 ? (near + far) / 2 : fmax(near, far);
    return *turn >= 0;
}

/* By how much an edge is longer than the geodesic between its ends has to be; false where only that
 * geodesic itself tells. */
static bool excess_of(struct defect_net *net, const struct net_node *from,
                      const struct net_node *to, double d, double *excess) {
    struct station p, q;
    struct vec3 edge = vec3_sub(to->r, from->r);
    if (!station_at(march_surface(net->march, from), &net->cursor, from->uv, &p) ||
        !station_at(march_surface(net->march, to), &net->cursor, to->uv, &q))
        return false;
    double curvature = station_normal_curvature(&p, edge), chord = fishnet_arc_chord(d, curvature);
    if (rough_edge(&p, &q, curvature, d, &chord) == ROUGH_EDGE)
        return false;
    *excess = vec3_norm(edge) - chord;
    return true;
}

/* By the angle by which the yarn turns sideways at its ends. */
static struct defect by_turn(struct defect_net *net, int32_t i, int32_t j, int di, int dj, double d,
                             bool rough) {
    double turn, excess = 0, least = d * unknown_turn * unknown_turn / 24;
    const struct net_node *from = net_view_place(&net->net, i, j);
    const struct net_node *to = net_view_place(&net->net, i + di, j + dj);
    bool measured = excess_of(net, from, to, d, &excess);
    if (!defect_turn(net, i, j, di, dj, &turn))
        return (struct defect){excess, least};
    double sideways = d * turn * turn / 24;
    double unsure =
        of_known * fabs(excess + sideways) + (of_known + turn) * sideways + rounding * d;
    return (struct defect){excess + sideways, rough || measured ? unsure : fmax(unsure, least)};
}

struct defect defect_of(struct defect_net *net, int32_t i, int32_t j, int di, int dj) {
    int family = di ? 0 : 1, ahead = di + dj > 0;
    const struct net_node *from = net_view_place(&net->net, i, j);
    const struct net_node *to = net_view_place(&net->net, i + di, j + dj);
    struct bends bends;
    struct defect defect;
    find_bends(net, i, j, di, dj, &bends);
    bool rough =
        from->rough & NET_EDGE_BIT(family, ahead) || to->rough & NET_EDGE_BIT(family, 1 - ahead);
    if (rough || !by_differences(&bends, vec3_sub(to->r, from->r), net->spacing[family], &defect))
        return by_turn(net, i, j, di, dj, net->spacing[family], rough);
    return defect;
}

enum { MARGIN = 3, SPAN = NET_TILE + 2 * MARGIN };

/* Positions by their coordinates, from MARGIN places before a tile to as many beyond. */
struct patch {
    double r[3][SPAN][SPAN];
};

/* Whether places of a tile, in columns `x` as bits and rows from `first` on, are all inside, and
 * neither rough nor grown. */
static bool is_plain(const struct net_tile *tile, unsigned x, int first, int count) {
    if (!tile)
        return false;
    unsigned inside = x, other = 0;
    for (int y = first; y < first + count; y++) {
        inside &= tile->bits[NET_BIT_INSIDE][y];
        other |= tile->bits[NET_BIT_ROUGH][y] | tile->bits[NET_BIT_GROWN][y];
    }
    return inside == x && !(other & x);
}

static void load(const struct net_window *window, struct patch *patch) {
    for (int y = 0; y < SPAN; y++) {
        bool own = y >= MARGIN && y < NET_TILE + MARGIN;
        for (int x = own ? 0 : MARGIN; x < (own ? SPAN : NET_TILE + MARGIN); x++) {
            struct vec3 r = net_window_find(window, x - MARGIN, y - MARGIN)->r;
            patch->r[0][y][x] = r.x;
            patch->r[1][y][x] = r.y;
            patch->r[2][y][x] = r.z;
        }
    }
}

/* As by_differences, of the edges of a row; P is `step` on from Q. */
static void along_row(const struct patch *patch, int y, int step, double d,
                      struct defect defect[NET_TILE]) {
    for (int x = 0; x < NET_TILE; x++) {
        double m2 = 0, m4 = 0, third2 = 0, edge2 = 0;
        for (int c = 0; c < 3; c++) {
            const double *p = &patch->r[c][y + MARGIN][x + MARGIN];
            double r0 = p[-3 * step], r1 = p[-2 * step], q = p[-step], r4 = p[step];
            double b0 = r0 - 2 * r1 + q, b1 = r1 - 2 * q + p[0], b2 = q - 2 * p[0] + r4;
            double b3 = p[0] - 2 * r4 + p[2 * step];
            double mean = (b1 + b2) / 2, d3 = b2 - b1, d4 = ((b3 - b2) - (b1 - b0)) / 2;
            m2 += mean * mean;
            m4 += mean * d4;
            third2 += d3 * d3;
            edge2 += (p[0] - q) * (p[0] - q);
        }
        double q = m2 / (d * d), fourth = by_fourth * (m4 + q * m2);
        double third = by_third * (third2 - q * q * edge2);
        double known = (edge2 - d * d * correction_share(q) - fourth + third) / (2 * d);
        double terms = fabs(fourth) + fabs(third);
        defect[x].known = known;
        defect[x].unsure =
            of_known * fabs(known) + (of_terms + of_turned * q) * terms / (2 * d) + rounding * d;
    }
}

bool defect_of_tile(const struct defect_net *net, const struct net_window *window,
                    struct defect_tile *tile) {
    const struct net_tile *own = window->tile[1][1];
    const unsigned all = (1u << NET_TILE) - 1, low = (1u << MARGIN) - 1;
    struct patch patch;
    if (!is_plain(own, all, 0, NET_TILE) ||
        !is_plain(window->tile[1][0], low << (NET_TILE - MARGIN), 0, NET_TILE) ||
        !is_plain(window->tile[1][2], low, 0, NET_TILE) ||
        !is_plain(window->tile[0][1], all, NET_TILE - MARGIN, MARGIN) ||
        !is_plain(window->tile[2][1], all, 0, MARGIN))
        return false;
    load(window, &patch);
    int warp = own->ti < 0 ? -1 : 1, weft = own->tj < 0 ? -SPAN : SPAN;
    for (int y = 0; y < NET_TILE; y++) {
        along_row(&patch, y, warp, net->spacing[0], tile->of[0][y]);
        along_row(&patch, y, weft, net->spacing[1], tile->of[1][y]);
    }
    return true;
}
