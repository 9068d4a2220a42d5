/* SPDX-License-Identifier: MIT */
#include "raster.h"

#include <math.h>
#include <stdlib.h>

bool raster_begin(struct raster *raster, int width, int height) {
    size_t count = (size_t)width * (size_t)height;
    *raster = (struct raster){.width = width,
                              .height = height,
                              .pixels = calloc(count, 1),
                              .depth = malloc(count * sizeof(float))};
    if (!raster->pixels || !raster->depth)
        return false;
    for (size_t k = 0; k < count; k++)
        raster->depth[k] = -INFINITY;
    return true;
}

void raster_free(struct raster *raster) {
    free(raster->pixels);
    free(raster->depth);
}

/* The first and last of `size` pixels whose middles lie between two coordinates. */
static void pixel_span(double low, double high, int size, int range[2]) {
    range[0] = (int)fmin(fmax(ceil(low - 0.5), 0), size);
    range[1] = (int)fmax(fmin(floor(high - 0.5), size - 1), -1);
}

/* Twice the area of (a, b, (x, y)), positive when it turns as the triangle. */
static double turn_area(const double a[3], const double b[3], double x, double y) {
    return (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]);
}

/* Barycentric coordinates by the areas opposite to the corners. */
void raster_triangle(struct raster *raster, const double a[3], const double b[3], const double c[3],
                     uint8_t colour, int hatch) {
    double area = turn_area(a, b, c[0], c[1]);
    int x[2], y[2];
    if (!(fabs(area) > 0))
        return;
    pixel_span(fmin(fmin(a[1], b[1]), c[1]), fmax(fmax(a[1], b[1]), c[1]), raster->height, y);
    for (int row = y[0]; row <= y[1]; row++) {
        /* The columns about the stretch of the row's middle line that the triangle has; those
         * beside it are for rounding. */
        const double *const corner[3] = {a, b, c};
        double middle = row + 0.5, low = HUGE_VAL, high = -HUGE_VAL;
        for (int k = 0; k < 3; k++) {
            const double *p = corner[k], *q = corner[(k + 1) % 3];
            if (fmin(p[1], q[1]) > middle || fmax(p[1], q[1]) < middle)
                continue;
            bool level = !(fabs(q[1] - p[1]) > 0);
            double share = level ? 0 : (middle - p[1]) / (q[1] - p[1]);
            double from = p[0] + share * (q[0] - p[0]), to = level ? q[0] : from;
            low = fmin(low, fmin(from, to));
            high = fmax(high, fmax(from, to));
        }
        pixel_span(low - 1, high + 1, raster->width, x);
        for (int column = x[0]; column <= x[1]; column++) {
            double wa = turn_area(b, c, column + 0.5, middle) / area;
            double wb = turn_area(c, a, column + 0.5, middle) / area;
            size_t at = (size_t)row * (size_t)raster->width + (size_t)column;
            float z = (float)(wa * a[2] + wb * b[2] + (1 - wa - wb) * c[2]);
            if (wa < 0 || wb < 0 || wa + wb > 1 || z < raster->depth[at] ||
                (hatch && (column + row) / hatch % 3))
                continue;
            raster->depth[at] = z;
            raster->pixels[at] = colour;
        }
    }
}

/* A pixel of each column or row, whichever it crosses more of, and its neighbours across. */
void raster_line(struct raster *raster, const double from[3], const double to[3], int width,
                 double lift, const uint8_t over[RASTER_COLOURS]) {
    int along = fabs(to[0] - from[0]) >= fabs(to[1] - from[1]) ? 0 : 1, range[2];
    const double *low = from[along] < to[along] ? from : to, *high = low == from ? to : from;
    double length = high[along] - low[along];
    pixel_span(low[along], high[along], along ? raster->height : raster->width, range);
    for (int k = range[0]; k <= range[1] && length > 0; k++) {
        double t = (k + 0.5 - low[along]) / length;
        double across = low[1 - along] + t * (high[1 - along] - low[1 - along]);
        double z = low[2] + t * (high[2] - low[2]) + lift;
        if (!(fabs(across) < 1e6))
            continue;
        int first = (int)floor(across - 0.5 * width + 0.5);
        for (int w = first; w < first + width; w++) {
            int column = along ? w : k, row = along ? k : w;
            if (column < 0 || row < 0 || column >= raster->width || row >= raster->height)
                continue;
            size_t at = (size_t)row * (size_t)raster->width + (size_t)column;
            if (z < (double)raster->depth[at])
                continue;
            raster->depth[at] = (float)z;
            raster->pixels[at] = over[raster->pixels[at]];
        }
    }
}
