/* SPDX-License-Identifier: MIT */
/*
 * The two sides of a knot line or a joint of a shell, unfolded about it into one plane: what lies
 * on one side as the other sees it, over a crease, too.
 */
#ifndef SOLVER_FISHNET_UNFOLDING_H
#define SOLVER_FISHNET_UNFOLDING_H

#include "solver/path/path.h"

/* A point in a span, as that span has it. */
struct unfolding_side {
    const struct surface *surface;
    int span[2];
    double turn[2]; /* what to take off uv to be in its domain */
    double uv[2];
    struct vec3 r;
    const struct surface_point *point; /* NULL of a path */
};

/* An edge of two spans unfolded: orthonormal frames of both sides (along the edge, across it within
 * the surface, normal), and a point of the edge; `flat` when there is nothing to unfold. */
struct unfolding {
    bool flat;
    struct vec3 at, from[3], to[3];
};

/* A path where it is, which is at `r`; and a point. */
struct unfolding_side unfolding_path(const struct path *path, struct vec3 r);
struct unfolding_side unfolding_point(const struct surface_point *point);

/* Where the line in (u, v) from one point to the other crosses the one knot between them. More than
 * one are taken as none: Newton's method comes nearer, or has to do without. */
struct unfolding unfolding_between(const struct unfolding_side *from,
                                   const struct unfolding_side *to);

/* A vector at the far side as it is on the near one. */
struct vec3 unfolding_back(const struct unfolding *unfolding, struct vec3 v);

/* A direction in the tangent plane with the normal `from` as it is in that with `to`, on the other
 * side of a fold: turned about the line in which the planes meet, as the one normal into the other.
 * As it is where the surface lies on itself, and that line is not known. */
struct vec3 unfolding_turned(struct vec3 direction, struct vec3 from, struct vec3 to);

/* The way from one point to a near one, in the tangent plane of the first. */
struct vec3 unfolding_gap(const struct unfolding_side *from, const struct unfolding_side *to,
                          const struct unfolding *unfolding);

#endif
