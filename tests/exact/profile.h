/* SPDX-License-Identifier: MIT */
/*
 * Sheets rolled onto a profile: cylinders over a curve of straight pieces, circular fillets and
 * folds. They are developable, so that the net of a flat sheet laid on them is the square grid on
 * the unrolled surface, at any angle and without shear.
 */
#ifndef DRAPE_TESTS_PROFILE_H
#define DRAPE_TESTS_PROFILE_H

#include "measure.h"

enum { PROFILE_PARTS = 16 };

/* A fillet of a radius, or a fold where that is 0, by an angle in degrees; then a straight piece.
 */
struct profile_part {
    double radius, turn_deg, length;
};

struct profile_sheet {
    const struct profile_part *parts; /* the first has no turn */
    int count;
    double width;
    double total; /* length of the profile */
    struct shape shape;
};

/* Degree 2 along u, the parameter being the length of the profile, each piece a span of its own
 * (continuous knots: a fold is a crease of the patch); degree 1 along v. */
void profile_make(struct profile_sheet *sheet, const struct profile_part *parts, int count,
                  double width);

/* The sheet's profile carried along the parabola with the control points (y, z) `along`:
 * degree 2 in both directions. Each place is a sum of one of the profile and one of the parabola,
 * so that sheared yarns cross the fillets. */
void profile_carry(const struct profile_sheet *sheet, const double along[3][2],
                   struct shape *shape);

/* The point of the sheet at (s, t) when unrolled, and the unit tangent along the profile (may be
 * NULL). */
struct vec3 profile_point(const struct profile_sheet *sheet, double s, double t,
                          struct vec3 *tangent);

/* Drapes the sheet from (start[0], start[1]) unrolled, warp `angle_deg` from the profile. */
void profile_drape(struct profile_sheet *sheet, enum drape_method method, double d,
                   const double start[2], double angle_deg, struct drape_run *run);

/* The methods that get the square grid, and how closely. */
enum { PROFILE_METHODS = 3 };
struct profile_method {
    const char *name;
    enum drape_method id;
    double position; /* largest error of a node, in spacings */
};
extern const struct profile_method profile_methods[PROFILE_METHODS];
extern const struct profile_method profile_basic; /* over creases: flat between them */
static const double PROFILE_SHEAR_DEG = 0.01;     /* of nodes and cells, at most */

/* Of a drape by profile_drape: the largest distance of a node from the square grid, in spacings,
 * the grid's places on the sheet that have no node, and the largest shear angles: of nodes, of
 * cells, and of all cloth up to its rim. */
struct profile_error {
    double position, node_shear_deg, cell_shear_deg, most_shear_deg;
    int missing;
};
struct profile_error profile_measure(const struct profile_sheet *sheet, double d,
                                     const double start[2], double angle_deg,
                                     const struct drape_run *run);

#endif
