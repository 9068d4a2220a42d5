/* SPDX-License-Identifier: MIT */
#include "band.h"

#include <math.h>

static const double half_turn = 3.14159265358979323846;

/* Cloth that is sheared to a line is none. */
static const double most_sine = 0.97;

/* The shear beside an edge. */
struct band_metric {
    double s, c;
};

static struct band_metric band_metric(double sine) {
    double s = isnan(sine) ? 0 : fmax(fmin(sine, most_sine), -most_sine);
    return (struct band_metric){s, sqrt(1 - s * s)};
}

/* The direction of a way on the part, from the warp. */
static double way_angle(struct band_metric m, double x, double y) {
    return atan2(m.c * y, x + m.s * y);
}

/* The direction to the left of an edge. */
static double left_of(struct band_metric m, const struct polygons_point *from,
                      const struct polygons_point *to) {
    return way_angle(m, to->x - from->x, to->y - from->y) + half_turn / 2;
}

/* Adds the place that is so far from a point on the part. */
static bool add_place(struct polygons *shapes, const struct polygons_point *at,
                      struct band_metric m, double distance, double angle) {
    double y = distance * sin(angle) / m.c;
    return polygons_add(shapes, at->x + distance * cos(angle) - m.s * y, at->y + y);
}

/* A sector about a point from one direction over an angle, counter-clockwise. */
static bool add_sector(struct polygons *shapes, const struct polygons_point *at,
                       struct band_metric m, double reach, double from, double angle) {
    static const double chord = 0.0625; /* off by 5e-4 of the radius */
    int steps = (int)ceil(angle / chord);
    bool good = polygons_add(shapes, at->x, at->y);
    for (int k = 0; k <= steps && good; k++)
        good = add_place(shapes, at, m, reach, from + angle * k / steps);
    polygons_close(shapes);
    return good;
}

/* What opens between the rectangles of an edge and the next one about the point between them, from
 * the left of one to that of the other: left where that turns right, and right where it turns left.
 */
static bool add_corner(struct polygons *shapes, const struct polygons_point *at,
                       struct band_metric m, double reach, double left, struct band_metric next,
                       double next_left) {
    double y = sin(next_left) / next.c, x = cos(next_left) - next.s * y;
    double turn = remainder(way_angle(m, x, y) - left, 2 * half_turn);
    double from = turn > 0 ? left - half_turn : left + turn;
    return turn == 0 || add_sector(shapes, at, m, reach, from, fabs(turn));
}

bool band_make(const struct polygons *polygons, const struct band_edge *edges,
               struct polygons *shapes) {
    const struct polygons_point *p = polygons->points;
    bool good = true;
    for (size_t first = 0, end; first < polygons->count && good; first = end) {
        for (end = first + 1; !p[end - 1].last;)
            end++;
        for (size_t k = first; k < end && good; k++) {
            size_t next = k + 1 < end ? k + 1 : first, before = k > first ? k - 1 : end - 1;
            size_t after = next + 1 < end ? next + 1 : first;
            double reach = edges[k].reach;
            struct band_metric m = band_metric(edges[k].sine), on = band_metric(edges[next].sine);
            double left = left_of(m, &p[k], &p[next]);
            if (!(reach > 0))
                continue;
            good = add_place(shapes, &p[k], m, reach, left) &&
                   add_place(shapes, &p[k], m, -reach, left) &&
                   add_place(shapes, &p[next], m, -reach, left) &&
                   add_place(shapes, &p[next], m, reach, left);
            polygons_close(shapes);
            if (good && !(edges[before].reach > 0))
                good = add_sector(shapes, &p[k], m, reach, left, half_turn);
            if (good && !(edges[next].reach > 0))
                good = add_sector(shapes, &p[next], m, reach, left - half_turn, half_turn);
            else if (good)
                good = add_corner(shapes, &p[next], m, reach, left, on,
                                  left_of(on, &p[next], &p[after]));
        }
    }
    return good;
}
