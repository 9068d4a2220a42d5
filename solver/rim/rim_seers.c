/* SPDX-License-Identifier: MIT */
/*
 * Places of the cloth by the geodesic from the nearest node to them: beside the tips of cuts, where
 * a cell may reach over the tip, and its corners lie on both sides of the cut.
 */
#include "rim_cloth.h"

#include "solver/fishnet/fishnet_geodesic.h"

/* Geodesics are found to this, by their length. */
static const double well_seen = 1e-11;

/* Nodes round a place: so many across, and so many of them are tried. */
enum { ACROSS = 4, TRIES = 8 };

/* The unit tangent of the yarn of a family at a node, towards the higher index: the mean of those
 * of its geodesics to both neighbours. False where it has none. */
static bool see_yarn(struct rim_cloth *cloth, const struct net_node *node, struct rim_seer *seer,
                     int family) {
    struct march *march = cloth->march;
    struct vec3 sum = {0, 0, 0};
    for (int side = 0; side < 2; side++) {
        int step = side ? 1 : -1, di = family ? 0 : step, dj = family ? step : 0;
        const struct net_node *other = net_place(march->net, seer->i + di, seer->j + dj);
        double length = march->settings->spacing[family];
        struct surface_point there;
        struct vec3 start, end;
        if (!other || net_is_parted_to(node, other, family, side) ||
            !march_point_at(march, other, &there) ||
            !march_yarn(march, seer->i, seer->j, di, dj, &seer->point, &start))
            continue;
        if (fishnet_geodesic_between(march->surface, &march->cursor, &seer->point, &there,
                                     well_seen, &length, &start, &end))
            sum = vec3_axpy(step, start, sum);
    }
    seer->yarn[family] = vec3_unit(sum);
    return vec3_norm2(sum) > 0;
}

/* The node at (i, j) with its yarns; NULL when there is none. */
static const struct rim_seer *find_seer(struct rim_cloth *cloth, int32_t i, int32_t j) {
    const int32_t wrap = RIM_SEERS - 1;
    struct rim_seer *seer = &cloth->seers[(j & wrap) * RIM_SEERS + (i & wrap)];
    if (!(seer->searched && seer->i == i && seer->j == j)) {
        const struct net_node *node = net_place(cloth->march->net, i, j);
        *seer = (struct rim_seer){.i = i, .j = j, .searched = true};
        seer->found = node && march_point_at(cloth->march, node, &seer->point) &&
                      see_yarn(cloth, node, seer, 0) && see_yarn(cloth, node, seer, 1);
    }
    return seer->found ? seer : NULL;
}

/* The place `to` by its geodesic to a node, unless a cut parts that from what is looked at. It is
 * looked for from the place: rays that come to a tip end far apart on both sides of it, those that
 * leave it do not. They set off to the side of what is looked at. */
static bool seen_along(struct rim_cloth *cloth, const struct rim_seer *seer,
                       const struct surface_point *to, struct rim_cloth_point *place) {
    struct march *march = cloth->march;
    const double *d = march->settings->spacing;
    const struct vec3 along[2] = {vec3_scale(d[0], seer->yarn[0]), vec3_scale(d[1], seer->yarn[1])};
    struct vec3 inward = surface_point_tangent(to, vec3_sub(cloth->eye.jet.r, to->jet.r));
    struct vec3 chord = vec3_sub(seer->point.jet.r, to->jet.r), end;
    struct vec3 start = surface_point_tangent(to, chord);
    double length = vec3_norm(chord), aside = vec3_dot(start, inward), ab[2];
    if (cloth->guarded && aside < 0)
        start = vec3_axpy(-2 * aside, inward, start);
    if (length < well_seen * d[0]) {
        *place =
            (struct rim_cloth_point){.p = seer->i, .q = seer->j, .along = {along[0], along[1]}};
    } else {
        if (!fishnet_geodesic_between(march->surface, &march->cursor, to, &seer->point, well_seen,
                                      &length, &start, &end) ||
            !rim_cloth_components(along, vec3_scale(-length, end), ab) ||
            (cloth->guarded && march_way_passes_cut(march, &cloth->eye, to, start, length)))
            return false;
        *place = (struct rim_cloth_point){.p = seer->i + ab[0], .q = seer->j + ab[1]};
        struct vec3 side = vec3_cross(seer->point.normal, end);
        struct vec3 left = vec3_cross(to->normal, start);
        for (int k = 0; k < 2; k++) /* the yarns, carried along the geodesic */
            place->along[k] = vec3_axpy(vec3_dot(along[k], end), start,
                                        vec3_scale(vec3_dot(along[k], side), left));
    }
    place->r = to->jet.r;
    place->rough = place->seen = true;
    return true;
}

bool rim_cloth_see_well(struct rim_cloth *cloth, const struct surface_point *to,
                        struct rim_cloth_point *place) {
    int32_t i = (int32_t)floor(place->p) - 1, j = (int32_t)floor(place->q) - 1;
    uint32_t tried = 0;
    for (int tries = 0; tries < TRIES && !cloth->march->mesh;) {
        int nearest = -1;
        double least = HUGE_VAL;
        for (int k = 0; k < ACROSS * ACROSS; k++) {
            double x = place->p - (i + k % ACROSS), y = place->q - (j + k / ACROSS);
            if (!(tried >> k & 1) && x * x + y * y < least) {
                least = x * x + y * y;
                nearest = k;
            }
        }
        if (nearest < 0)
            return false;
        tried |= 1u << nearest;
        const struct rim_seer *seer = find_seer(cloth, i + nearest % ACROSS, j + nearest / ACROSS);
        if (seer && seen_along(cloth, seer, to, place))
            return true;
        tries += seer != NULL;
    }
    return false;
}
