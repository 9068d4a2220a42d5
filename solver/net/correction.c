/* SPDX-License-Identifier: MIT */
#include "correction.h"

#include <math.h>

enum difference { DIFFERENCE_MADE, DIFFERENCE_SHORT, DIFFERENCE_ROUGH };

/* sum_k weight[k] r(i + k di, j + k dj), k = first .. first + count - 1. */
static enum difference combine(const struct net_view *net, int32_t i, int32_t j, int di, int dj,
                               int first, int count, const double *weight, struct vec3 *sum) {
    int family = di ? 0 : 1, ahead = di + dj > 0;
    unsigned rough = 0;
    *sum = vec3_make(0, 0, 0);
    for (int k = 0; k < count; k++) {
        int at = first + k;
        const struct net_node *node = net_view_place(net, i + at * di, j + at * dj);
        if (!node)
            return DIFFERENCE_SHORT;
        rough |= node->grown;
        if (k > 0)
            rough |= node->rough & (unsigned)NET_EDGE_BIT(family, 1 - ahead);
        if (k < count - 1)
            rough |= node->rough & (unsigned)NET_EDGE_BIT(family, ahead);
        *sum = vec3_axpy(weight[k], node->r, *sum);
    }
    return rough ? DIFFERENCE_ROUGH : DIFFERENCE_MADE;
}

/* D2 at (i, j) along (di, dj), for an edge that lies ahead. The quadrants are marched each for
 * itself, so that the net's error has a kink where they meet: on a generator it is taken one-sided,
 * towards the edge. It is at the yarn's ends, too, and next to rough edges. */
static enum difference second_difference(const struct net_view *net, int32_t i, int32_t j, int di,
                                         int dj, struct vec3 *d2) {
    static const double centred[] = {1, -2, 1}, one_sided[] = {2, -5, 4, -1};
    bool on_generator = di ? i == 0 : j == 0;
    enum difference made = DIFFERENCE_SHORT;
    if (!on_generator)
        made = combine(net, i, j, di, dj, -1, 3, centred, d2);
    if (made == DIFFERENCE_MADE)
        return made;
    bool rough = made == DIFFERENCE_ROUGH;
    made = combine(net, i, j, di, dj, 0, 4, one_sided, d2);
    if (made == DIFFERENCE_SHORT && !on_generator)
        made = combine(net, i, j, -di, -dj, 0, 4, one_sided, d2);
    if (made != DIFFERENCE_MADE)
        *d2 = vec3_make(0, 0, 0);
    return rough ? DIFFERENCE_ROUGH : made;
}

bool correction_find(const struct net_view *before, int32_t i, int32_t j, int di, int dj, double d,
                     struct correction *correction) {
    const struct net_node *from = net_view_place(before, i, j);
    const struct net_node *to = net_view_place(before, i + di, j + dj);
    int family = di ? 0 : 1, ahead = di + dj > 0;
    *correction = (struct correction){.d = d};
    if (!from || !to || from->rough & NET_EDGE_BIT(family, ahead) ||
        to->rough & NET_EDGE_BIT(family, 1 - ahead))
        return false;
    struct vec3 *bend = correction->bend;
    enum difference near = second_difference(before, i, j, di, dj, &bend[0]);
    enum difference far = second_difference(before, i + di, j + dj, -di, -dj, &bend[1]);
    correction->along = vec3_sub(to->r, from->r);
    correction->whole = near == DIFFERENCE_MADE && far == DIFFERENCE_MADE;
    return near != DIFFERENCE_SHORT && far != DIFFERENCE_SHORT;
}

bool correction_chord(const struct correction *correction, double *chord) {
    double d = correction->d;
    struct vec3 sum = vec3_add(correction->bend[0], correction->bend[1]);
    double q = vec3_norm2(sum) / (4 * d * d);
    double share = correction_share(q);
    *chord = d * sqrt(share);
    return share > 0.5; /* more is no yarn of this spacing but a crease */
}

double correction_sideways(const struct correction *correction, const struct station *from,
                           double arc_chord) {
    struct vec3 across = vec3_cross(from->normal, correction->along);
    struct vec3 sum = vec3_add(correction->bend[0], correction->bend[1]);
    double sideways = vec3_dot(sum, across), size2 = vec3_norm2(correction->along);
    double q = sideways * sideways / (4 * size2 * correction->d * correction->d);
    return q < 0.25 ? arc_chord * sqrt(1 - q / 12) : arc_chord;
}
