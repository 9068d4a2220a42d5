/* SPDX-License-Identifier: MIT */
/*
 * Rough edges: pieces of yarn between two nodes over which the surface bends unevenly, or not a
 * little: a fillet no longer than a spacing, a crease, a joint where the curvature jumps. What a
 * method takes a smooth edge for (an arc of the curvature at one end, a second difference) does not
 * hold there; the yarn is its geodesic, of the spacing's length.
 *
 * An arc of curvature k and length d rises by k d^2 / 2 above the tangent plane at either end. So
 * does a smooth edge, seen from both ends and with the curvature at one of them; what differs from
 * that, as a share of d, is its misfit. It is half the change of curvature over the edge times d,
 * and the angle of a crease.
 */
#ifndef SOLVER_FISHNET_ROUGH_H
#define SOLVER_FISHNET_ROUGH_H

#include "solver/angle.h"
#include "solver/shell/surface_point.h"

#include "arc.h"

enum rough_kind {
    ROUGH_NOT,    /* an arc of the curvature at one end */
    ROUGH_BENT,   /* a curve that follows from both ends: it has another chord */
    ROUGH_UNEVEN, /* alike, but too uneven for differences of positions in space */
    ROUGH_EDGE    /* neither: a crease or a joint, or a small radius, lies between the ends */
};

/* What the edge from p to q is, d long, with this normal curvature at p and the *chord of an arc;
 * sets *chord to that of a bent one. */
enum rough_kind rough_edge(const struct surface_point *p, const struct surface_point *q,
                           double curvature, double d, double *chord);

/* Whether an edge d long from p to q is rough, and whether moreover the surface turns by more than
 * 26 degrees over it: a fold, which no straight chord of the length d crosses as a yarn does. */
bool rough_is_rough(const struct surface_point *p, const struct surface_point *q, double d);
bool rough_is_fold(const struct surface_point *p, const struct surface_point *q, double d);

/* The angle, in radians, with the sine x, |x| <= 1, by its tangent. */
double rough_steep_arcsine(double x);

/* The far end of an edge. */
struct rough_end {
    const struct surface *surface; /* that uv are parameters of; NULL on a mesh */
    const double *uv;
    struct vec3 r;
    const struct surface_point *point; /* NULL: not known yet */
};

/* The unit tangent at p of the geodesic to the end of a smooth edge: the chord's projection, turned
 * by d^2 k t / 6, k the normal curvature and t the geodesic torsion, of p or, where p lies on a
 * joint, of the other end. `sure` (may be NULL): it is right to 1e-4, because the edge rises from p
 * as an arc does, or what it rises else leads it aside by less, wherever that is along the edge. */
struct vec3 rough_leave(struct surface_cursor *cursor, const struct surface_point *p,
                        const struct rough_end *end, bool *sure);

/* The angle by which a yarn with this chord sets off from p to the left of it, taken as a helix. */
double rough_aside(const struct surface_point *p, struct vec3 chord);

/* Whether the edge from p to the point `to` is sure in that way. */
bool rough_leaves_surely(const struct surface_point *p, struct vec3 to);

/* The point of an end: that which is known, or else in `made`; NULL where there is none. */
const struct surface_point *rough_end_point(struct surface_cursor *cursor,
                                            const struct rough_end *end,
                                            struct surface_point *made);

/* The geodesic between two points as it follows from chord, normals and curvatures there. */
struct rough_geodesic {
    double length;
    double error;              /* what that may be wrong by, as a share of it, */
    double angle;              /* and the directions, in radians */
    struct vec3 leave, arrive; /* its unit tangents at p and, onward, at q */
};

/* False where the length does not follow from p and q. */
bool rough_estimate(const struct surface_point *p, const struct surface_point *q,
                    struct rough_geodesic *geodesic);

#endif
