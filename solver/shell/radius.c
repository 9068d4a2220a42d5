/* SPDX-License-Identifier: MIT */
#include "solver/surface/trim.h"
#include "surface_point.h"

/* Samples of all spans together, and of one in each direction, at the most. */
enum { SAMPLES = 1024, SAMPLES_PER_SPAN = 25 };

/* Near poles the parameters' own bends grow beyond what the surface's can be told from. */
static const double regular_share = 1e-3;

double surface_least_radius(const struct surface *surface, const struct trim *trim) {
    const struct surface_axis *u = &surface->axis[0], *v = &surface->axis[1];
    double spans = (double)u->span_count * v->span_count, most = 0;
    int n = (int)fmin(fmax(sqrt(SAMPLES / spans), 1), SAMPLES_PER_SPAN);
    int step = 1 + (int)(spans / SAMPLES);
    struct surface_cursor cursor = {0};
    for (int span = 0; span < u->span_count * v->span_count; span += step)
        for (int k = 0; k < n * n; k++) {
            const double *low[2] = {&u->breaks[span / v->span_count],
                                    &v->breaks[span % v->span_count]};
            double share[2] = {(k / n + 0.5) / n, (k % n + 0.5) / n}, uv[2], outer[2];
            struct surface_point point;
            for (int m = 0; m < 2; m++)
                uv[m] = low[m][0] + share[m] * (low[m][1] - low[m][0]);
            surface_outer(surface, uv, outer);
            bool inside = !trim || trim_contains(trim, outer);
            if (!inside || !surface_point_at(surface, &cursor, uv, &point))
                continue;
            double area2 = point.first[0] * point.first[2], mean, radius;
            if (!(surface_point_determinant(&point) > regular_share * area2))
                continue;
            surface_point_principal_curvatures(&point, &mean, &radius);
            most = fmax(most, fabs(mean) + radius);
        }
    return 1 / most;
}
