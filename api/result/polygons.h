/* SPDX-License-Identifier: MIT */
/* Closed polygons of the plane, what they enclose on their left, so that holes turn the other way;
 * and how they are made wider. */
#ifndef API_RESULT_POLYGONS_H
#define API_RESULT_POLYGONS_H

#include <stdbool.h>
#include <stddef.h>

struct polygons_point {
    double x, y;
    int part; /* of the edge, that goes on from here: what is made wider by a distance of its own */
    bool last; /* the polygon ends here, and is closed to its first point */
};

struct polygons {
    struct polygons_point *points; /* malloc'ed */
    size_t count, capacity;
};

/* Adds a point of part 0 to the polygon that is open; false without memory. */
bool polygons_add(struct polygons *polygons, double x, double y);

/* Closes it; one of fewer than three points is dropped. */
void polygons_close(struct polygons *polygons);

void polygons_free(struct polygons *polygons);

/* Drops points as long as the polygons stay within `tolerance` of all of them, but those where
 * another part begins. */
void polygons_simplify(struct polygons *polygons, double tolerance);

/* The area that they enclose, holes taken off. */
double polygons_area(const struct polygons *polygons);

/* The area within the polygon that begins at point `first`, below 0 for a hole; and the first point
 * behind it. */
double polygons_loop_area(const struct polygons *polygons, size_t first, size_t *end);

/* Whether a point is inside an odd number of the polygons. */
bool polygons_contain(const struct polygons *polygons, double x, double y);

/* The box round them; all 0 when there are none. */
void polygons_bounds(const struct polygons *polygons, double low[2], double high[2]);

/*
 * What is no further than `distance` of its part from an edge of the polygons, beyond what they
 * enclose: `wider` (zero-initialised) gets its boundary, which runs parallel to them, round their
 * corners in arcs of chords that are right to 2e-3 of the distance. `distance` has one for each
 * part, 0 or more, and one above 0. Where the part changes so does the distance, at right angles to
 * the edge. Holes become smaller, and close. Polygons that enclose nothing twice are expected.
 * False without memory; the caller frees `wider` in any case.
 */
bool polygons_widen(const struct polygons *polygons, const double *distance,
                    struct polygons *wider);

#endif
