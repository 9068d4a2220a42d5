/* SPDX-License-Identifier: MIT */
/*
 * A picture with depth: triangles and lines in pixels, x to the right, y down, and of what lies
 * behind each other that with the greatest z is seen. A pixel holds the number of a colour, 0 where
 * nothing was drawn. Coordinates may lie outside the picture.
 */
#ifndef API_FORMAT_RASTER_H
#define API_FORMAT_RASTER_H

#include <stdbool.h>
#include <stdint.h>

enum { RASTER_COLOURS = 256 };

struct raster {
    int width, height;
    uint8_t *pixels; /* by rows; malloc'ed, as `depth` */
    float *depth;
    uint8_t palette[RASTER_COLOURS][3]; /* RGB of the colours, the caller's to set */
};

/* False without memory; raster_free in any case. */
bool raster_begin(struct raster *raster, int width, int height);
void raster_free(struct raster *raster);

/* The pixels whose middles it has, its edges included; with `hatch` > 0 of three stripes
 * of so many pixels one. Without an area it has none. */
void raster_triangle(struct raster *raster, const double a[3], const double b[3], const double c[3],
                     uint8_t colour, int hatch);

/* A line `width` pixels wide that hides what it lies on, up to `lift` behind it: pixels of colour k
 * get the colour over[k]. It is drawn once, so that it may make them darker. */
void raster_line(struct raster *raster, const double from[3], const double to[3], int width,
                 double lift, const uint8_t over[RASTER_COLOURS]);

#endif
