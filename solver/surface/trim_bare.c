/* SPDX-License-Identifier: MIT */
/* Where a trimmed part leaves a strip of a closed surface bare. */
#include "spans.h"
#include "trim.h"

#include <stdlib.h>

enum { LINES = 64 };

static int compare_crossings_across(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

enum status trim_bare_line(const struct trim *trim, const struct surface *surface, int k,
                           struct arena *scratch, bool *found, double *at) {
    const struct surface_axis *axis = &surface->axis[k], *other = &surface->axis[1 - k];
    double length = axis->outer[1] - axis->outer[0];
    size_t room = 2;
    bool bare[LINES];
    for (size_t loop = 0; loop < trim_loop_count(trim); loop++) {
        const double(*points)[2];
        room += trim_loop_points(trim, loop, &points);
    }
    double *across = arena_alloc(scratch, room, sizeof *across);
    if (!across)
        return STATUS_OUT_OF_MEMORY;
    /* A line across direction k is bare if nothing of the region lies on it: between where it
     * crosses the loops' edges, and the ends of the domain, it is in the region or outside of it.
     */
    for (int n = 0; n < LINES; n++) {
        double x = axis->outer[0] + (n + 0.5) / LINES * length;
        size_t count = 0;
        across[count++] = other->outer[0];
        for (size_t loop = 0; loop < trim_loop_count(trim); loop++) {
            const double(*points)[2];
            size_t edges = trim_loop_points(trim, loop, &points);
            for (size_t m = 1; m < edges; m++) {
                const double *a = points[m - 1], *b = points[m];
                if ((a[k] < x) != (b[k] < x))
                    across[count++] = a[1 - k] + (x - a[k]) / (b[k] - a[k]) * (b[1 - k] - a[1 - k]);
            }
        }
        across[count++] = other->outer[1];
        qsort(across, count, sizeof *across, compare_crossings_across);
        bare[n] = true;
        for (size_t m = 1; m < count && bare[n]; m++) {
            double uv[2];
            uv[k] = x;
            uv[1 - k] = (across[m - 1] + across[m]) / 2;
            bare[n] = !(across[m] > across[m - 1] && trim_contains(trim, uv));
        }
    }
    int run = 0, widest = 0, last = 0;
    for (int n = 0; n < 2 * LINES; n++) { /* twice round: a run may pass the seam */
        run = bare[n % LINES] ? run + 1 : 0;
        if (run > widest && run <= LINES) {
            widest = run;
            last = n;
        }
    }
    *at = axis->outer[0] + ((last - widest / 2) % LINES + 0.5) / LINES * length;
    *found = widest > 0;
    return STATUS_OK;
}
