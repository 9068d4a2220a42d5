/* SPDX-License-Identifier: MIT */
/*
 * Which neighbours a cut parts. A yarn goes on one side of a tip or on the other, and where the
 * part folds there, or comes to a point, the places of its ends do not tell on which: both ways may
 * even be as long. Its own path does. Of a rough edge by which a node was found the path is known:
 * the geodesic that leaves the neighbour as the cell has it. To a neighbour by which the node was
 * not found there is a yarn if the geodesic that goes straight on along the one which comes from
 * the opposite side leads to it in a spacing. Elsewhere chords tell.
 */
#include "march.h"

#include "cuts.h"
#include "solver/fishnet/fishnet_geodesic.h"
#include "solver/net/curtain.h"

/* Beside the tip of a cut, this near in spacings, paths are followed, in steps of at least this
 * share of their length over which normals turn by less than this cosine, and which are no longer
 * than this share of the way to the tip; where their chord passes the cut than that one. */
static const double beside_tip = 2, least_step = 1.0 / 4096, fold_cosine = 0.8, tip_share = 0.5,
                    sure_share = 0.125;

/* Not where the part is all but flat, so that normals at both ends and at the tip have at least
 * this cosine, and the chord keeps as far from the tip as this share of its length. */
static const double flat_cosine = 0.98, clear_share = 0.05;

/* Where a way that begins on a lip is certainly off it, and how near it may come to a tip, in
 * spacings: the curtain ends a little before that. */
static const double at_lip = 0.01, past_tip = 2e-3;

/* A geodesic to a neighbour is its yarn if it is as long but for this share, and found and followed
 * to that. */
static const double as_long = 2e-2, found_to = 1e-6;

bool march_is_beside_cut(const struct march *march, struct vec3 at) {
    const double *d = march->settings->spacing;
    return march->cuts && cuts_may_be_near(march->cuts, at) &&
           curtain_is_near(march->cuts->curtain, at, CUTS_CELL_REACH * fmax(d[0], d[1]));
}

bool march_is_beside_tip(const struct march *march, struct vec3 at) {
    return march_is_near_tip(march, at, beside_tip);
}

bool march_is_at_point(const struct march *march, struct vec3 at) {
    return march->cuts && march->method->yarn != DRAPE_YARN_CHORD &&
           cuts_may_be_near(march->cuts, at) && march_is_near_tip(march, at, CUTS_POINT_REACH);
}

bool march_is_near_tip(const struct march *march, struct vec3 at, double reach) {
    const double *d = march->settings->spacing;
    return march->cuts && curtain_end_distance(march->cuts->curtain, at) < reach * fmax(d[0], d[1]);
}

enum status march_fail_cell(struct march *march, int32_t i, int32_t j, enum drape_reason reason,
                            const struct surface_point *b) {
    return march_is_beside_cut(march, b->jet.r) ? STATUS_OK : march_fail(march, i, j, reason);
}

/* Whether the chord between two places passes a cut. */
static bool chord_passes_cut(const struct march *march, const struct surface_point *from,
                             const struct surface_point *to) {
    struct vec3 normal;
    return curtain_parts(march->cuts->curtain, from->jet.r, to->jet.r, &normal) &&
           vec3_dot(from->normal, normal) >= 0;
}

/* A path that is followed, where it is, and how far from tips it has to keep. */
struct walk {
    struct march *march;
    struct path path;
    struct surface_point at;
    double clear;
};

/* Follows the way for a length and says whether that passes a cut: whether the chord of a step
 * does, as long as that tells it. Where it may leave the curtain, over a fold or as near to a tip
 * as it is long, the step is halved, or made as short as the way to the tip is wherever it leads.
 */
static bool walk_passes_cut(struct walk *walk, double length) {
    walk->path.accuracy = found_to;
    const struct curtain *curtain = walk->march->cuts->curtain;
    const double least = least_step * length, nearer = tip_share / (1 + tip_share);
    double far = curtain_end_distance(curtain, walk->at.jet.r), step = length;
    for (double left = length; left > 0;) {
        struct path ahead = walk->path;
        struct surface_point point;
        step = fmin(fmax(fmin(step, tip_share * far), least), left);
        if (!path_advance(&ahead, step) ||
            !path_surface_point(&ahead, &walk->march->cursor, &point, NULL))
            return true;
        bool parts = curtain_parts(curtain, walk->at.jet.r, point.jet.r, NULL);
        double there = curtain_end_distance(curtain, point.jet.r);
        bool folds = vec3_dot(walk->at.normal, point.normal) < fold_cosine;
        if (step > least &&
            (folds || step > tip_share * there || (parts && step > sure_share * there))) {
            step = folds || parts || step <= nearer * far ? step / 2 : nearer * far;
            continue;
        }
        if (parts || there < walk->clear)
            return true;
        walk->path = ahead;
        walk->at = point;
        left -= step;
        far = there;
        step = left;
    }
    return false;
}

/* Whether the chord between two places tells whether the geodesic passes a cut. */
static bool chord_tells(const struct march *march, const struct surface_point *from,
                        const struct surface_point *to) {
    const struct curtain_post *tip = curtain_end(march->cuts->curtain, from->jet.r);
    struct vec3 along = vec3_sub(to->jet.r, from->jet.r), off = vec3_sub(tip->r, from->jet.r);
    double length2 = vec3_norm2(along), share = vec3_dot(off, along) / length2;
    struct vec3 nearest = vec3_scale(share > 0 ? fmin(share, 1) : 0, along);
    return vec3_dot(from->normal, to->normal) > flat_cosine &&
           vec3_dot(from->normal, tip->normal) > flat_cosine &&
           vec3_dot(to->normal, tip->normal) > flat_cosine &&
           vec3_norm2(vec3_sub(off, nearest)) > clear_share * clear_share * length2;
}

/* How near a way may come to a tip. One that passes it nearer is taken to pass the cut, as the
 * curtain ends a little before the tip; not one from or to the tip itself. */
static double least_clearance(const struct march *march, const struct surface_point *from,
                              const struct surface_point *to) {
    const double *d = march->settings->spacing;
    const struct curtain *curtain = march->cuts->curtain;
    double clear = past_tip * fmin(d[0], d[1]);
    return fmin(curtain_end_distance(curtain, from->jet.r),
                curtain_end_distance(curtain, to->jet.r)) > 2 * clear
               ? clear
               : 0;
}

/* Whether a geodesic that leads from one place to another passes a cut. */
static bool geodesic_passes_cut(struct march *march, const struct surface_point *from,
                                const struct surface_point *to, struct vec3 direction,
                                double length) {
    struct walk walk = {.march = march, .at = *from, .clear = least_clearance(march, from, to)};
    if (chord_tells(march, from, to))
        return chord_passes_cut(march, from, to);
    return !path_geodesic(&walk.path, from->surface, from, direction) ||
           walk_passes_cut(&walk, length);
}

/* Where the yarn of a family through a node that is about to be placed leaves it to a side:
 * straight on from the neighbour on the other one, by which it was found. Zero where that is not
 * known. */
static struct vec3 leave_straight_on(struct march *march, int32_t i, int32_t j, int di, int dj,
                                     const struct surface_point *at) {
    int family = di ? 0 : 1, step = di + dj;
    const struct net_node *behind = march_node_at(march, i - di, j - dj);
    if (march->edges.rough & NET_EDGE_BIT(family, step < 0)) {
        const struct net_edge *edge = &march->edges.yarns.edge[family];
        return vec3_scale(step, step > 0 ? edge->higher : edge->lower);
    }
    return behind && (behind->state == NET_INSIDE || behind->state == NET_GHOST)
               ? surface_point_tangent(at, vec3_sub(at->jet.r, behind->r))
               : vec3_make(0, 0, 0);
}

/* The same where its neighbour's yarn, which is at `from`, comes to it, straight on from beyond
 * that. In a quadrant what lies there may be another's. */
static struct vec3 come_straight_on(struct march *march, int32_t i, int32_t j, int di, int dj,
                                    const struct surface_point *from) {
    struct vec3 away;
    return march->growing && march_yarn(march, i + di, j + dj, di, dj, from, &away)
               ? vec3_scale(-1, away)
               : vec3_make(0, 0, 0);
}

/* Beside a tip: whether there is a yarn between a node about to be placed and its neighbour, and no
 * cut on its way. */
static bool yarn_passes_cut(struct march *march, int32_t i, int32_t j, int di, int dj,
                            const struct surface_point *from, const struct surface_point *to) {
    int family = di ? 0 : 1, step = di + dj;
    bool slides = family == 1 && march->settings->slide > 0; /* its edges have any length */
    double d = slides ? vec3_distance(from->jet.r, to->jet.r) : march->settings->spacing[family];
    double length = d;
    const struct surface_point *ends[2] = {to, from};
    struct vec3 start, end;
    if (!slides && march->edges.rough & NET_EDGE_BIT(family, step > 0)) {
        const struct net_edge *edge = &march->edges.yarns.edge[family];
        start = step > 0 ? vec3_scale(-1, edge->higher) : edge->lower;
        return geodesic_passes_cut(march, from, to, start, d);
    }
    start = leave_straight_on(march, i, j, di, dj, to);
    bool leaves = vec3_norm2(start) > 0;
    if (!leaves)
        start = come_straight_on(march, i, j, di, dj, from);
    if (!(vec3_norm2(start) > 0))
        return chord_passes_cut(march, from, to);
    if (!fishnet_geodesic_between(march->surface, &march->cursor, ends[!leaves], ends[leaves],
                                  found_to, &length, &start, &end) ||
        (!slides && fabs(length / d - 1) > as_long) ||
        geodesic_passes_cut(march, ends[!leaves], ends[leaves], start, length))
        return true;
    uint8_t family_bits = NET_EDGE_BIT(family, 0) | NET_EDGE_BIT(family, 1);
    if (!(march->edges.rough & family_bits))
        march_note_edge(march, family, -step, leaves ? vec3_scale(-1, end) : start,
                        leaves ? vec3_scale(-1, start) : end);
    return false;
}

/* Whether a cut near a point parts it from a neighbour. */
static bool parts_neighbour(struct march *march, int32_t i, int32_t j, int di, int dj,
                            const struct surface_point *to) {
    const struct net_node *node = march_node_at(march, i + di, j + dj);
    struct surface_point from;
    if (!node || !(node->state == NET_INSIDE || node->state == NET_GHOST) ||
        !march_point_at(march, node, &from))
        return false;
    return march->mesh || !march_is_beside_tip(march, to->jet.r)
               ? chord_passes_cut(march, &from, to)
               : yarn_passes_cut(march, i, j, di, dj, &from, to);
}

bool march_is_parted(struct march *march, int32_t i, int32_t j, int di, int dj,
                     const struct surface_point *to) {
    return march_is_beside_cut(march, to->jet.r) && parts_neighbour(march, i, j, di, dj, to);
}

uint8_t march_find_parted(struct march *march, int32_t i, int32_t j,
                          const struct surface_point *point) {
    uint8_t parted = 0;
    for (int family = 0; family < 2; family++)
        for (int side = 0; side < 2; side++) {
            int step = side ? 1 : -1;
            if (parts_neighbour(march, i, j, family ? 0 : step, family ? step : 0, point))
                parted |= NET_EDGE_BIT(family, side);
        }
    return parted;
}

bool march_is_hidden(struct march *march, const struct net_node *node,
                     const struct surface_point *eye) {
    struct surface_point from;
    struct vec3 normal, end;
    if (march->mesh || !march_is_beside_tip(march, eye->jet.r))
        return curtain_parts(march->cuts->curtain, node->r, eye->jet.r, &normal) &&
               march_point_at(march, node, &from) && vec3_dot(from.normal, normal) >= 0;
    if (!march_point_at(march, node, &from))
        return false;
    struct vec3 chord = vec3_sub(eye->jet.r, from.jet.r),
                start = surface_point_tangent(&from, chord);
    double length = vec3_norm(chord);
    return !chord_tells(march, &from, eye) &&
                   fishnet_geodesic_between(march->surface, &march->cursor, &from, eye, found_to,
                                            &length, &start, &end)
               ? geodesic_passes_cut(march, &from, eye, start, length)
               : chord_passes_cut(march, &from, eye);
}

bool march_way_passes_cut(struct march *march, const struct surface_point *eye,
                          const struct surface_point *lip, struct vec3 direction, double length) {
    const double *d = march->settings->spacing;
    double spacing = fmin(d[0], d[1]), first = fmin(at_lip * spacing, length);
    struct walk walk = {.march = march, .clear = past_tip * spacing};
    return !path_geodesic(&walk.path, lip->surface, lip, direction) ||
           !path_advance(&walk.path, first) ||
           !path_surface_point(&walk.path, &march->cursor, &walk.at, NULL) ||
           curtain_parts(march->cuts->curtain, eye->jet.r, walk.at.jet.r, NULL) ||
           walk_passes_cut(&walk, length - first);
}
