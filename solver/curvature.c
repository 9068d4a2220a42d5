/* SPDX-License-Identifier: MIT */
#include "curvature.h"

#include <math.h>

/* The arc length of knot m, any whole number: the middle of a part. */
static double knot_at(const struct drape_curvature *c, int m) {
    double part = m - c->points + 0.5;
    return part * c->length[part > 0] / c->points;
}

/* de Boor's algorithm: between the knots m and m + 1, from the values m - 1 .. m + 2. */
double curvature_at(const struct drape_curvature *c, double s) {
    int n = 2 * c->points;
    if (n == 0)
        return 0;
    double at = floor(s * c->points / c->length[s > 0] + c->points - 0.5), d[4];
    if (at < -2 || at > n)
        return c->value[at < 0 ? 0 : n - 1];
    int m = (int)at;
    for (int k = 0; k < 4; k++) {
        int from = m - 1 + k;
        d[k] = c->value[from < 0 ? 0 : from < n ? from : n - 1];
    }
    for (int r = 1; r < 4; r++)
        for (int k = 3; k >= r; k--) {
            double low = knot_at(c, m - 3 + k), high = knot_at(c, m + 1 + k - r);
            double share = (s - low) / (high - low);
            d[k] = (1 - share) * d[k - 1] + share * d[k];
        }
    return d[3];
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

int curvature_sides(const struct drape_curvature *c, int n) {
    int last = 2 * c->points - 1;
    return (n == 0 || knot_at(c, n - 2) < 0) + 2 * (n == last || knot_at(c, n + 2) > 0);
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
