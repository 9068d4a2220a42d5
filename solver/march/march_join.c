/* SPDX-License-Identifier: MIT */
/*
 * Where parts of the net come together that have gone round an obstacle on either side. With
 * curvature in the obstacle they are out of step there: places next to each other by their numbers
 * are not a spacing apart. No yarn leads from the one to the other, and the net ends there as it
 * does where it meets itself.
 */
#include "march.h"

#include "solver/fishnet/fishnet_geodesic.h"
#include "solver/fishnet/logarithm.h"
#include "solver/fishnet/rough.h"

/* A yarn that is wrong by more than this share of its spacing is none; of weft that slides, whose
 * length is known by the shear at one of its ends, so many times as much. */
static const double join_gap = 0.01, of_sliding = 5;

/* How far a yarn's length is measured, by its spacing: well within that. */
static const double measured = 1e-3;

/* Without a way to measure it a yarn is one whose chord is longer than this, by its spacing. */
static const double least_chord = 0.5;

/* By how much the yarn between two nodes differs from its spacing d, as a share of that. An arc of
 * curvature k has the chord d (1 - (k d)^2 / 24), and no yarn is shorter than its chord by more
 * than the share `stretch`. */
static double misfit(struct march *march, const struct surface_point *from,
                     const struct net_node *node, double d, double stretch) {
    struct vec3 chord = vec3_sub(node->r, from->jet.r), onward, end;
    double length = vec3_norm(chord), turn = surface_point_normal_curvature(from, chord) * d;
    double as_arc = fabs(length / d - (1 - turn * turn / 24));
    if (length > (1 + stretch) * d)
        return HUGE_VAL;
    struct surface_point to;
    struct logarithm l;
    if (as_arc < join_gap || march->method->yarn == DRAPE_YARN_CHORD)
        return as_arc;
    if (march->mesh || !march_point_at(march, node, &to))
        return length > least_chord * d ? 0 : as_arc;
    if (logarithm_find(&march->cursor, from, &to, measured, &l))
        return fabs(l.length / d - 1);
    onward = surface_point_tangent(from, chord);
    length = d;
    if (fishnet_geodesic_between(march->surface, &march->cursor, from, &to, measured, &length,
                                 &onward, &end))
        return fabs(length / d - 1);
    return vec3_norm(chord) > least_chord * d ? 0 : as_arc;
}

bool march_joins(struct march *march, int32_t i, int32_t j, const struct surface_point *point,
                 enum surface_point_zone zone) {
    static const int8_t sides[4][2] = {{1, 0}, {-1, 0}, {0, 1}, {0, -1}};
    const double *d = march->settings->spacing;
    /* Beside the tip of a cut it has been asked already how far apart they are (`march_is_parted`).
     */
    if (march_is_beside_tip(march, point->jet.r))
        return true;
    for (int k = 0; k < 4; k++) {
        const struct net_node *node = net_place(march->net, i + sides[k][0], j + sides[k][1]);
        bool laid = (march->edges.rough | march->edges.parted) & NET_EDGE_BIT(k / 2, k % 2 == 0);
        bool gives_way = node && node->state == NET_GHOST && zone == SURFACE_POINT_INSIDE;
        if (!node || laid || gives_way)
            continue;
        double length = d[k / 2], gap = join_gap, stretch = MARCH_STRETCH;
        struct surface_point at;
        if (k / 2 && march->settings->slide > 0 && march_point_at(march, node, &at)) {
            length = march_slide_length(march, i + sides[k][0], j + sides[k][1], &at,
                                        vec3_sub(point->jet.r, node->r));
            gap *= of_sliding;
            stretch = gap;
        }
        if (!(misfit(march, point, node, length, stretch) < gap))
            return false;
    }
    return true;
}
