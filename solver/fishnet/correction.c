/* SPDX-License-Identifier: MIT */
#include "correction.h"

#include <math.h>

enum difference { DIFFERENCE_MADE, DIFFERENCE_SHORT, DIFFERENCE_ROUGH };

/* The nodes at (i + k di, j + k dj), k = first .. first + count - 1, and whether there is a
 * difference over them. */
static enum difference find_nodes(const struct net_view *net, int32_t i, int32_t j, int di, int dj,
                                  int first, int count, const struct net_node *node[]) {
    int family = di ? 0 : 1, ahead = di + dj > 0;
    unsigned rough = 0;
    for (int k = 0; k < count; k++) {
        int at = first + k;
        node[k] = net_view_place(net, i + at * di, j + at * dj);
        if (!node[k] || (k > 0 && net_is_parted_to(node[k - 1], node[k], family, ahead)))
            return DIFFERENCE_SHORT;
        rough |= node[k]->grown;
        if (k > 0)
            rough |= node[k]->rough & (unsigned)NET_EDGE_BIT(family, 1 - ahead);
        if (k < count - 1)
            rough |= node[k]->rough & (unsigned)NET_EDGE_BIT(family, ahead);
    }
    return rough ? DIFFERENCE_ROUGH : DIFFERENCE_MADE;
}

/* At the first of four nodes. */
static enum difference at_first(const struct net_view *net, int32_t i, int32_t j, int di, int dj,
                                struct vec3 *d2) {
    static const double one_sided[] = {2, -5, 4, -1};
    const struct net_node *node[4];
    enum difference made = find_nodes(net, i, j, di, dj, 0, 4, node);
    *d2 = vec3_make(0, 0, 0);
    for (int k = 0; k < 4 && made != DIFFERENCE_SHORT; k++)
        *d2 = vec3_axpy(one_sided[k], node[k]->r, *d2);
    return made;
}

/* D2 at (i, j) along (di, dj), for an edge that lies ahead. The quadrants are marched each for
 * itself, so that the net's error has a kink where they meet: on a generator it is taken one-sided,
 * towards the edge. It is at the yarn's ends, too, and next to rough edges. */
static enum difference second_difference(const struct net_view *net, int32_t i, int32_t j, int di,
                                         int dj, struct vec3 *d2) {
    const struct net_node *node[3];
    bool on_generator = di ? i == 0 : j == 0;
    enum difference made = DIFFERENCE_SHORT;
    if (!on_generator)
        made = find_nodes(net, i, j, di, dj, -1, 3, node);
    if (made == DIFFERENCE_MADE) {
        *d2 = correction_bend(node[0]->r, node[1]->r, node[2]->r);
        return made;
    }
    bool rough = made == DIFFERENCE_ROUGH;
    made = at_first(net, i, j, di, dj, d2);
    if (made == DIFFERENCE_SHORT && !on_generator)
        made = at_first(net, i, j, -di, -dj, d2);
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
    if (!from || !to || net_is_parted_to(from, to, family, ahead) ||
        from->rough & NET_EDGE_BIT(family, ahead) || to->rough & NET_EDGE_BIT(family, 1 - ahead))
        return false;
    struct vec3 *bend = correction->bend;
    enum difference near = second_difference(before, i, j, di, dj, &bend[0]);
    enum difference far = second_difference(before, i + di, j + dj, -di, -dj, &bend[1]);
    correction->along = vec3_sub(to->r, from->r);
    correction->whole = near == DIFFERENCE_MADE && far == DIFFERENCE_MADE;
    return near != DIFFERENCE_SHORT && far != DIFFERENCE_SHORT;
}

bool correction_chord(const struct correction *correction, double *chord) {
    bool holds;
    *chord = correction_chord_of(correction->bend[0], correction->bend[1], correction->d, &holds);
    return holds;
}

double correction_sideways(const struct correction *correction, const struct surface_point *from,
                           const struct surface_point *to, double arc_chord) {
    struct vec3 along = correction->along;
    double sideways = vec3_dot(correction->bend[0], vec3_cross(from->normal, along)) +
                      vec3_dot(correction->bend[1], vec3_cross(to->normal, along));
    double q = sideways * sideways / (4 * vec3_norm2(along) * correction->d * correction->d);
    return q < 0.25 ? arc_chord * sqrt(1 - q / 12) : arc_chord;
}
