/* SPDX-License-Identifier: MIT */
/*
 * The step over yarns that are geodesics: D at given distances from B and C along the surface. The
 * method `geodesic` takes it for every node, the others of arcs where an edge is rough (`rough.h`).
 *
 * Geodesics of the wanted lengths leave B and C at unknown angles beta and gamma; D is where their
 * ends meet. The end of one moves at right angles to it, by J = d - K d^3 / 6 + .. for each radian
 * of its angle (the Jacobi field; K is the Gaussian curvature), so that a Newton step for both
 * angles is a system of two equations. Ends on two sides of a knot line are compared in one plane,
 * unfolded about it: on a developable surface, creased or not, J and the step are exact. Where
 * there is no crease the geodesics are found by collocation (`fishnet_collocation.h`), elsewhere
 * integrated with J beside them, and shot.
 */
#ifndef SOLVER_FISHNET_FISHNET_GEODESIC_H
#define SOLVER_FISHNET_FISHNET_GEODESIC_H

#include "fishnet.h"
#include "solver/path/path.h"

/* The yarns BD and CD of a cell: unit tangents at their starts, in the tangent planes at B and C,
 * and at their ends in that at D. */
struct fishnet_yarns {
    struct vec3 start[2], end[2];
    bool stays[2]; /* on the continuation of B's or C's face, over no joint */
    bool met[2];   /* set: theirs or another tried on the way to D has met a joint */
    double reach;  /* of the geodesics, as a path's */
};

/* Moves `node`, a point near D on the right side (`fishnet_solve` with the chords of `gib`), to
 * where the geodesics of these lengths from B and C meet, to 1e-11 of them, which is
 * node->residual; `lanes` as drape_settings'. */
enum fishnet_end fishnet_geodesic_solve(const struct surface *surface,
                                        struct surface_cursor *cursor,
                                        const struct fishnet_cell *cell, const double length[2],
                                        int lanes, struct fishnet_node *node);

/* The same from the directions yarns->start, wherever that is: nothing is asked of chords, so that
 * folds of any angle may lie in the cell. Ends meet to accuracy[0] of their length, and geodesics
 * are followed to accuracy[1] a step. Sets node and all of `yarns`. Given up when node->tried, to
 * which the geodesics' steps are added, becomes too many. */
enum fishnet_end fishnet_geodesic_meet(const struct surface *surface, struct surface_cursor *cursor,
                                       const struct fishnet_cell *cell, double bd, double cd,
                                       const double accuracy[2], struct fishnet_yarns *yarns,
                                       struct fishnet_node *node);

/* The geodesic from p to q (its logarithm), to `accuracy` of its length: its unit tangents at both
 * ends, in the tangent planes there, and its length, from about `length` and the direction *start,
 * which is in the tangent plane at p. False, with the outputs unset, when Newton's method does not
 * find it. */
bool fishnet_geodesic_between(const struct surface *surface, struct surface_cursor *cursor,
                              const struct surface_point *p, const struct surface_point *q,
                              double accuracy, double *length, struct vec3 *start,
                              struct vec3 *end);

/* The angles for which angle[0] b - angle[1] c = gap, in the least-squares sense of the tangent
 * plane. False where the square of the sine between b and c is less than `sine2`. */
static inline bool fishnet_close_gap(struct vec3 b, struct vec3 c, struct vec3 gap, double sine2,
                                     double angle[2]) {
    struct vec3 normal = vec3_cross(b, c);
    double area2 = vec3_norm2(normal);
    angle[0] = vec3_dot(vec3_cross(gap, c), normal) / area2;
    angle[1] = vec3_dot(vec3_cross(gap, b), normal) / area2;
    return area2 > sine2 * vec3_norm2(b) * vec3_norm2(c);
}

/* Pulls at most so many times from the point `from` towards the point `target`, until `to` is as
 * near to that, along the surface, as is `enough`; `to` may be `from`. False when it does not get
 * there. */
bool fishnet_pull_to(struct surface_cursor *cursor, const struct surface_point *from,
                     struct vec3 target, double enough, int pulls, struct surface_point *to);

/* The unit tangent `tangent` of a path where it is now, which is at `point`, in the tangent plane
 * there: a path that has come up to a crease may still be on the side it came from. */
struct vec3 fishnet_path_tangent(const struct path *path, const struct surface_point *point,
                                 struct vec3 tangent);

#endif
