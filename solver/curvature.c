/* SPDX-License-Identifier: MIT */
#include "curvature.h"

#include <math.h>

/* The arc length of knot m, any whole number: the middle of a part. */
static double knot_at(const struct drape_curvature *c, int m) {
    double part = m - c->points + 0.5;
    return part * c->length[part > 0] / c->points;
}

/* The four values that the curvature at a place depends on, from `first` on, of which those before
 * the first are that, and those after the last the last; and de Boor's shares of them. */
struct spline_place {
    int first;
    double share[3][4];
};

static struct spline_place spline_place_at(const struct drape_curvature *c, double s) {
    int n = 2 * c->points;
    double at = floor(s * c->points / c->length[s > 0] + c->points - 0.5);
    struct spline_place place = {at < 0 ? -4 : n, {{0}}};
    if (at < -2 || at > n)
        return place;
    place.first = (int)at - 1;
    double knot[6];
    for (int k = 0; k < 6; k++)
        knot[k] = knot_at(c, place.first - 1 + k);
    for (int r = 1; r < 4; r++)
        for (int k = r; k < 4; k++) {
            double low = knot[k - 1], high = knot[k + 3 - r];
            place.share[r - 1][k] = (s - low) / (high - low);
        }
    return place;
}

static int value_index(const struct drape_curvature *c, int k) {
    return k < 0 ? 0 : k < 2 * c->points ? k : 2 * c->points - 1;
}

/* de Boor's algorithm. */
static double blend_values(const struct spline_place *place, double d[4]) {
    for (int r = 0; r < 3; r++)
        for (int k = 3; k > r; k--)
            d[k] = (1 - place->share[r][k]) * d[k - 1] + place->share[r][k] * d[k];
    return d[3];
}

double curvature_at(const struct drape_curvature *c, double s) {
    double d[4];
    if (c->points == 0)
        return 0;
    struct spline_place place = spline_place_at(c, s);
    for (int k = 0; k < 4; k++)
        d[k] = c->value[value_index(c, place.first + k)];
    return blend_values(&place, d);
}

void curvature_weights(const struct drape_curvature *c, double s, double *weight) {
    struct spline_place place = spline_place_at(c, s);
    for (int n = 0; n < 2 * c->points; n++)
        weight[n] = 0;
    for (int k = 0; k < 4; k++) {
        double d[4] = {k == 0, k == 1, k == 2, k == 3};
        weight[value_index(c, place.first + k)] += blend_values(&place, d);
    }
}

/* A knot this near, by a part of its side, has been reached. */
static const double reached = 1e-9;

double curvature_to_knot(const struct drape_curvature *c, double s, int sense) {
    double part = s * c->points / c->length[s > 0] + c->points - 0.5, most = 2.0 * c->points + 2;
    double next = sense > 0 ? floor(part + reached) + 1 : ceil(part - reached) - 1;
    if (next < -2 || next > most)
        return HUGE_VAL;
    return fabs(knot_at(c, (int)next) - s);
}

double curvature_most(const struct drape_curvature *c) {
    double most = 0;
    for (int k = 0; k < 2 * c->points; k++)
        most = fmax(most, fabs(c->value[k]));
    return most;
}

bool curvature_is_none(const struct drape_curvature *c) {
    return curvature_most(c) == 0;
}
