/* SPDX-License-Identifier: MIT */
/*
 * Paths on the surface at unit speed: what the generators of the net run along.
 *
 * - Geodesics, the straightest lines. In parameters, with a = r_uu p^2 + 2 r_uv p q + r_vv q^2 for
 *   the velocity (p, q),
 *
 *     u' = p,  v' = q,  (p', q') = -I^-1 (a . r_u, a . r_v)
 *
 *   (paper, equations 33-36, with the Christoffel symbols multiplied out; I is the first
 *   fundamental form).
 * - The same steered sideways by a curvature k(s), n x t being the tangent turned to the left: k
 *   (n x t) is added, (-(F p + G q), E p + F q) k / |r_u x r_v|.
 * - Sections by a plane: (u', v') along (n . r_v, -n . r_u).
 * - Polylines in the caller's (u, v), past their ends geodesics.
 *
 * Each span is integrated as the analytic surface it is, and the path is carried over from span to
 * span; a geodesic by unfolding the two tangent planes about their common edge, so that neither a
 * crease nor a jump of curvature costs accuracy.
 */
#ifndef SOLVER_PATH_PATH_H
#define SOLVER_PATH_PATH_H

#include "solver/curvature.h"
#include "solver/shell/surface_point.h"

enum path_kind { PATH_GEODESIC, PATH_SECTION, PATH_CURVE };

/* A point moving along a path. */
struct path {
    const struct surface *surface;
    enum path_kind kind;
    double uv[2];       /* continuous: a closed direction is not wrapped */
    double velocity[2]; /* (p, q): r_u p + r_v q is the unit tangent */
    int span[2];
    double turn[2];         /* what to take off uv to be in the domain of the span */
    double accuracy;        /* local error allowed, as a share of the step: 1e-12 unless set */
    double noise;           /* by which its velocity's change per length is off beyond the domain,
                               by rounding, as far as its steps have told */
    double pace;            /* the step that the last one suggests; 0: none */
    double error;           /* the sum of the steps' estimated local errors, a length */
    struct surface_jet jet; /* of where it is, as its span has it, if `has_jet` */
    bool has_jet;
    bool stays;      /* on the continuation of its face, over no joint */
    bool met;        /* a joint, which it may have passed */
    double reach;    /* beyond the boundary it is lost where the continuation is not trusted, which
                        it is up to so far from it; 0: anywhere */
    int astray;      /* steps that ended there */
    int tried;       /* steps, those that were too long among them */
    bool ended;      /* it has come to a fold of the surface back on itself */
    double ahead;    /* length already gone of the next advance: a pole is left with a leap */
    double gone;     /* the length of the way to (u, v) */
    bool carries;    /* its Jacobi field: */
    double field[2]; /* how far it moves to the left for each radian by which it sets off otherwise,
                        and how that changes along it; (0, 1) where it sets off */
    const struct drape_curvature *curvature; /* of a steered geodesic, along it by `sense`; NULL:
                                                straight */
    struct vec3 plane;                       /* PATH_SECTION: the normal, signed as the path goes */
    const double (
        *curve)[2]; /* PATH_CURVE: its points, the one ahead, and the sense it is walked */
    size_t curve_count, next;
    int sense;      /* 1 or -1 */
    double line[2]; /* towards the point ahead, in the caller's parameters as the points are */
};

/* Sets off from `from` along the projection of `direction`. False when there is no such direction:
 * it is normal to the surface, or leads out of it at a pole. */
bool path_geodesic(struct path *path, const struct surface *surface,
                   const struct surface_point *from, struct vec3 direction);

/* The same along the geodesic that is steered by `curvature`, which is borrowed: its positive arm
 * (sense 1) or the other (-1), along which s falls and the left is on the right. */
bool path_steered(struct path *path, const struct surface *surface,
                  const struct surface_point *from, struct vec3 direction,
                  const struct drape_curvature *curvature, int sense);

/* Sets off along the section by the plane through `from` with the normal `plane`, to that side to
 * which `direction` points. False when the plane is the tangent plane. */
bool path_section(struct path *path, const struct surface *surface,
                  const struct surface_point *from, struct vec3 plane, struct vec3 direction);

/* Sets off from `from`, a point on the polyline `curve` of `count` points, for its point `next` and
 * on from there by `sense`, 1 or -1. The points are borrowed. False when it has no direction. */
bool path_curve(struct path *path, const struct surface *surface, const struct surface_point *from,
                const double (*curve)[2], size_t count, size_t next, int sense);

/* From here on no more accurate than a net with the spacing d is itself, by a method of the order 2
 * or 4; to be said again at every node. */
void path_follow_net(struct path *path, double d, int order);

/* Moves on by `length` >= 0 to a relative accuracy of 1e-12 of `length`, or as set; on past open
 * boundaries over the continued surface. As a rule one step of order 8 a span, whose work is
 * bounded; of order 5 where little is asked: False
 * when the path cannot be followed with a few dozen; it is then unusable. */
bool path_advance(struct path *path, double length);

/* Moves both paths on, each by its length; the same bits, in less time. False when either cannot be
 * followed; both are then unusable. */
bool path_advance_both(struct path path[2], const double length[2]);

/* Whether it is lost where the continuation is not trusted: more than a few steps, as many as it
 * takes over a ridge, have ended there. */
bool path_is_astray(const struct path *path);

/* Moves on until it is the chord d away from where it was: one advance, then Newton on the length,
 * for which the chord grows at the cosine between chord and tangent, in steps next to nothing.
 * False as above, or when there is no such point. */
bool path_advance_chord(struct path *path, struct surface_cursor *cursor, double d);

/* The point where it is now, and which way it is going there (unit; may be NULL). False when the
 * surface has no tangent plane there. */
bool path_surface_point(const struct path *path, struct surface_cursor *cursor,
                        struct surface_point *point, struct vec3 *tangent);

#endif
