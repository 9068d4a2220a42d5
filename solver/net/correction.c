/* SPDX-License-Identifier: MIT */
#include "correction.h"

#include <math.h>

/* sum_k weight[k] r(i + k di, j + k dj), k = first .. first + count - 1. */
static bool combine(const struct net_view *net, int32_t i, int32_t j, int di, int dj, int first,
                    int count, const double *weight, struct vec3 *sum) {
    *sum = vec3_make(0, 0, 0);
    for (int k = 0; k < count; k++) {
        int at = first + k;
        const struct net_node *node = net_view_place(net, i + at * di, j + at * dj);
        if (!node)
            return false;
        *sum = vec3_axpy(weight[k], node->r, *sum);
    }
    return true;
}

/* D2 at (i, j) along (di, dj), for an edge that lies ahead. The quadrants are marched each for
 * itself, so that the net's error has a kink where they meet: on a generator it is taken one-sided,
 * towards the edge. It is at the yarn's ends, too. */
static bool second_difference(const struct net_view *net, int32_t i, int32_t j, int di, int dj,
                              struct vec3 *d2) {
    static const double centred[] = {1, -2, 1}, one_sided[] = {2, -5, 4, -1};
    bool on_generator = di ? i == 0 : j == 0;
    if (!on_generator && combine(net, i, j, di, dj, -1, 3, centred, d2))
        return true;
    if (combine(net, i, j, di, dj, 0, 4, one_sided, d2))
        return true;
    return !on_generator && combine(net, i, j, -di, -dj, 0, 4, one_sided, d2);
}

bool correction_chord(const struct net_view *before, int32_t i, int32_t j, int di, int dj, double d,
                      double *chord) {
    struct vec3 here, there;
    if (!second_difference(before, i, j, di, dj, &here) ||
        !second_difference(before, i + di, j + dj, -di, -dj, &there))
        return false;
    double m = vec3_norm2(vec3_add(here, there)) / 4, share = 1 - m / (12 * d * d);
    *chord = d * sqrt(share);
    return share > 0.5; /* more is no yarn of this spacing but a crease */
}
