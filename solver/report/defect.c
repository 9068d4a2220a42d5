/* SPDX-License-Identifier: MIT */
#include "defect.h"

#include "solver/fishnet/correction.h"
#include "solver/fishnet/fishnet.h"
#include "solver/fishnet/logarithm.h"
#include "solver/fishnet/yarn.h"
#include "solver/wide.h"

/* Coefficients of defect.h. */
static const double by_fourth = 5.0 / 144 - 1.0 / 240, by_third = 1.0 / 720;

/* What is unsure of it: a share of it and of its terms, more where the yarn turns by much over the
 * edge; what solving leaves of an edge, as a share of its length; and where the net says nothing,
 * at the least where an edge is not rough, a turn sideways by this angle. */
static const double of_known = 0.2, of_terms = 1, of_turned = 10;
static const double rounding = 2e-12;
static const double unknown_turn = 0.05;

/* And so much of a bend all at once in a rough edge, whose ends tell it only roughly; and what
 * measuring it in pieces leaves of its length (march_cell.c), as a share of that. */
static const double of_at_once = 2, of_measured = 5e-7;

/* To what a geodesic is measured here, as a share of it, and how often that it may be wrong. */
static const double measured = 1e-8, of_logarithm = 3;

/* The net along one yarn about the edge from Q to P: D2 at the places -2 .. 3, counted from Q,
 * where there are any. None reaches over rough edges, or from nodes that have grown to others. */
enum { AT_Q = 2, AT_P, BENDS = 6 };

struct bends {
    struct vec3 of[BENDS];
    bool has[BENDS];
};

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
    double m2 = vec3_norm2(mean), q = m2 / (d * d), third2 = vec3_norm2(d3);
    double across = correction_across(m2, vec3_dot(mean, d3), third2);
    if (!correction_chord(&arc, &chord))
        return false;
    double fourth = by_fourth * (vec3_dot(mean, d4) + across);
    double third = by_third * (third2 - across);
    double terms = fabs(fourth) + fabs(third);
    if (!found->has[AT_Q] || !found->has[AT_P])
        terms += vec3_norm(mean) * vec3_norm(d4) / 24;
    defect->known = (vec3_norm2(edge) - chord * chord - fourth + third) / (2 * d);
    defect->unsure = of_known * fabs(defect->known) + (of_terms + of_turned * q) * terms / (2 * d) +
                     rounding * d;
    return true;
}

/* The angle by which the yarn at (i, j) that goes along (di, dj) turns sideways there, in the
 * surface; less than 0 when it is not known. */
static double sideways_turn(struct defect_net *net, int32_t i, int32_t j, int di, int dj) {
    int family = di ? 0 : 1, ahead = di + dj > 0;
    struct yarn_net yarns = {net->net.net, net->march->surface, &net->cursor};
    struct yarn_place place[3];
    struct surface_point point;
    for (int k = 0; k < 3; k++) {
        int32_t at[2] = {i + (k - 1) * di, j + (k - 1) * dj};
        place[k] = (struct yarn_place){at[0], at[1], net_view_place(&net->net, at[0], at[1])};
        if (!place[k].node)
            return -1;
    }
    const struct net_node *node = place[1].node;
    if (!surface_point_at(march_surface(net->march, node), &net->cursor, node->uv, &point))
        return -1;
    struct vec3 out = yarn_leave(&yarns, &place[1], &place[2], family, ahead, &point);
    struct vec3 back = yarn_leave(&yarns, &place[1], &place[0], family, 1 - ahead, &point);
    return fabs(vec3_dot(vec3_cross(out, back), point.normal));
}

double defect_turn(struct defect_net *net, int32_t i, int32_t j, int di, int dj, double end[2]) {
    end[0] = sideways_turn(net, i, j, di, dj);
    end[1] = sideways_turn(net, i + di, j + dj, di, dj);
    return end[0] >= 0 && end[1] >= 0 ? (end[0] + end[1]) / 2 : fmax(end[0], end[1]);
}

/* By how much an edge that its ends tell is longer than d: they may tell it wrong by more than the
 * rest of the defect, so its geodesic is measured. False where only that tells it: it has been. */
static bool measure_excess(struct defect_net *net, const struct net_node *from,
                           const struct net_node *to, double d, struct defect *excess) {
    struct surface_point p, q;
    struct logarithm geodesic;
    if (!surface_point_at(march_surface(net->march, from), &net->cursor, from->uv, &p) ||
        !surface_point_at(march_surface(net->march, to), &net->cursor, to->uv, &q))
        return false;
    double curvature = surface_point_normal_curvature(&p, vec3_sub(to->r, from->r));
    double chord = fishnet_arc_chord(d, curvature);
    if (rough_edge(&p, &q, curvature, d, &chord) == ROUGH_EDGE ||
        !logarithm_find(&net->cursor, &p, &q, measured, &geodesic))
        return false;
    *excess = (struct defect){geodesic.length - d, of_logarithm * measured * d};
    return true;
}

/* By the angles by which the yarn turns sideways at its ends: evenly over the edge, or all at once
 * at a fillet or crease in it, which the geodesic between the ends cuts short. That crosses at x of
 * the edge and turns by (1 - x) of the angle at the near end and by x at the far one; the yarn is
 * longer by half their product. */
static struct defect by_turn(struct defect_net *net, int32_t i, int32_t j, int di, int dj, double d,
                             bool rough) {
    struct defect excess = {0, 0};
    double least = d * unknown_turn * unknown_turn / 24;
    double end[2], turn = defect_turn(net, i, j, di, dj, end);
    const struct net_node *from = net_view_place(&net->net, i, j);
    const struct net_node *to = net_view_place(&net->net, i + di, j + dj);
    bool known = measure_excess(net, from, to, d, &excess);
    if (turn < 0)
        return (struct defect){excess.known, excess.unsure + least};
    double sideways = d * turn * turn / 24, sum = excess.known + sideways;
    double at_once = rough && end[0] >= 0 && end[1] >= 0 ? d * end[0] * end[1] / 2 : 0;
    double unsure = excess.unsure + of_known * fabs(sum) + (of_known + turn) * sideways +
                    of_at_once * at_once + rounding * d;
    if (!known)
        unsure = rough ? unsure + of_measured * d : fmax(unsure, least);
    return (struct defect){sum, unsure};
}

struct defect defect_of(struct defect_net *net, int32_t i, int32_t j, int di, int dj) {
    int family = di ? 0 : 1, ahead = di + dj > 0;
    const struct net_node *from = net_view_place(&net->net, i, j);
    const struct net_node *to = net_view_place(&net->net, i + di, j + dj);
    unsigned out = NET_EDGE_BIT(family, ahead), in = NET_EDGE_BIT(family, 1 - ahead);
    const struct net_node *node[BENDS + 2];
    bool whole[BENDS + 1];
    struct bends bends;
    struct defect defect;
    for (int k = 0; k < BENDS + 2; k++) {
        int at = k - AT_Q - 1;
        node[k] = net_view_place(&net->net, i + at * di, j + at * dj);
        if (k > 0)
            whole[k - 1] = node[k] && node[k - 1] && !(node[k - 1]->rough & out) &&
                           !(node[k]->rough & in) && node[k]->grown == node[k - 1]->grown;
    }
    for (int k = 0; k < BENDS; k++) {
        bends.has[k] = whole[k] && whole[k + 1];
        if (bends.has[k])
            bends.of[k] = correction_bend(node[k]->r, node[k + 1]->r, node[k + 2]->r);
    }
    bool rough = from->rough & out || to->rough & in;
    if (rough || !by_differences(&bends, vec3_sub(to->r, from->r), net->spacing[family], &defect))
        return by_turn(net, i, j, di, dj, net->spacing[family], rough);
    return defect;
}

enum { MARGIN = 3, SPAN = NET_TILE + 2 * MARGIN };

/* Positions by their coordinates, from MARGIN places before a tile to as many beyond. */
struct patch {
    double r[3][SPAN][SPAN];
};

/* Places first[0] .. end[0] - 1 of rows first[1] .. end[1] - 1 of a window, all of one tile. */
static void load_positions(const struct net_window *window, const int first[2], const int end[2],
                           struct patch *patch) {
    for (int y = first[1]; y < end[1]; y++) {
        const struct net_node *node = net_window_find(window, first[0], y);
        for (int x = first[0]; x < end[0]; x++) {
            struct vec3 r = node ? node++->r : vec3_make(0, 0, 0);
            vec3_to_columns(r, patch->r[0][y + MARGIN], patch->r[1][y + MARGIN],
                            patch->r[2][y + MARGIN], (size_t)(x + MARGIN));
        }
    }
}

/* As by_differences, of the edges of family k that end in row y. */
WIDE_CLONES
static void along_row(const struct patch *patch, int y, int k, int step, double d,
                      struct defect_tile *tile) {
    /* M^2, M . D3, M . D4, D3^2, and the edges' squares, added up over the coordinates */
    double m2[NET_TILE] = {0}, m3[NET_TILE] = {0}, m4[NET_TILE] = {0};
    double third2[NET_TILE] = {0}, edge2[NET_TILE] = {0}, (*along)[NET_TILE] = tile->along[k][y];
    for (int c = 0; c < 3; c++) {
        const double *p = &patch->r[c][y + MARGIN][MARGIN]; /* P, which is `step` on from Q */
        for (int x = 0; x < NET_TILE; x++) {
            double r0 = p[x - 3 * step], r1 = p[x - 2 * step], q = p[x - step], r3 = p[x];
            double r4 = p[x + step], r5 = p[x + 2 * step];
            double b0 = r0 - 2 * r1 + q, b1 = r1 - 2 * q + r3, b2 = q - 2 * r3 + r4;
            double b3 = r3 - 2 * r4 + r5;
            double mean = (b1 + b2) / 2, d3 = b2 - b1, d4 = ((b3 - b2) - (b1 - b0)) / 2;
            m2[x] += mean * mean;
            m3[x] += mean * d3;
            m4[x] += mean * d4;
            third2[x] += d3 * d3;
            edge2[x] += (r3 - q) * (r3 - q);
            along[c][x] = r3 - q;
        }
    }
    for (int x = 0; x < NET_TILE; x++) {
        double q = m2[x] / (d * d), across = correction_across(m2[x], m3[x], third2[x]);
        double fourth = by_fourth * (m4[x] + across), third = by_third * (third2[x] - across);
        double share = correction_share(q, across / (d * d));
        double known = (edge2[x] - d * d * share - fourth + third) / (2 * d);
        double terms = fabs(fourth) + fabs(third);
        tile->known[k][y][x] = known;
        tile->unsure[k][y][x] =
            of_known * fabs(known) + (of_terms + of_turned * q) * terms / (2 * d) + rounding * d;
    }
    for (int x = 0; x < NET_TILE; x++) {
        double inverse = 1 / sqrt(edge2[x]);
        for (int c = 0; c < 3; c++)
            along[c][x] *= inverse;
    }
}

void defect_of_tile(const struct defect_net *net, const struct net_window *window,
                    struct defect_tile *tile) {
    static const int range[3][2] = {{-MARGIN, 0}, {0, NET_TILE}, {NET_TILE, NET_TILE + MARGIN}};
    const struct net_tile *own = window->tile[1][1];
    struct patch patch;
    int warp = own->ti < 0 ? -1 : 1, weft = own->tj < 0 ? -1 : 1;
    for (int k = 0; k < 3; k++) {
        load_positions(window, (int[]){range[k][0], 0}, (int[]){range[k][1], NET_TILE}, &patch);
        if (k != 1)
            load_positions(window, (int[]){0, range[k][0]}, (int[]){NET_TILE, range[k][1]}, &patch);
    }
    uint64_t plain[SPAN];
    for (int y = 0; y < SPAN; y++)
        plain[y] = net_window_plain(window, y - MARGIN);
    for (int y = 0; y < NET_TILE; y++) {
        /* the places that have plain nodes all the way from 3 steps back to 2 on, along rows and
         * columns */
        uint64_t row = plain[y + MARGIN], both = row;
        for (int k = 1; k <= MARGIN; k++)
            both &= (warp > 0 ? row << k : row >> k) & plain[y + MARGIN - k * weft];
        for (int k = 1; k < MARGIN; k++)
            both &= (warp > 0 ? row >> k : row << k) & plain[y + MARGIN + k * weft];
        tile->even[y] = (uint32_t)(both >> NET_TILE) & ((1u << NET_TILE) - 1);
        if (!tile->even[y])
            continue;
        along_row(&patch, y, 0, warp, net->spacing[0], tile);
        along_row(&patch, y, 1, weft * SPAN, net->spacing[1], tile);
    }
}
