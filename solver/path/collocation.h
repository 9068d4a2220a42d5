/* SPDX-License-Identifier: MIT */
/*
 * Geodesics by collocation in space. At unit speed a geodesic bends by the surface alone,
 *
 *     r'' = II(r', r') N,
 *
 * so that it is found in rounds: the bend at some points of it says where it goes, and the surface
 * there how it bends. Each round leaves of an error a share of about (k d)^2, k being the curvature
 * and d the length, whatever the parametrisation is like; parameters only say where on the surface
 * a point is. The points are Gauss's of a piece between two knot lines, where the end is right to
 * order 16 (Hairer, Norsett, Wanner: Solving Ordinary Differential Equations I, section II.7); all
 * of a piece are evaluated at once, with the same bits at any width of registers.
 */
#ifndef SOLVER_PATH_COLLOCATION_H
#define SOLVER_PATH_COLLOCATION_H

#include "solver/shell/surface_point.h"

enum {
    COLLOCATION_POINTS = 8,
    COLLOCATION_PIECES = 16,
    COLLOCATION_JET = 18,
    COLLOCATION_ALONG = -1
};

/* Gauss's points, as shares of a piece. */
extern const double collocation_point[COLLOCATION_POINTS];

/* One piece, within a span; numbers by point. */
struct collocation_piece {
    int span[2];
    double turn[2];       /* what to take off uv to be in the domain of the span */
    double begin, length; /* along the path */
    _Alignas(64) double uv[2][COLLOCATION_POINTS];
    _Alignas(64) double tangent[3][COLLOCATION_POINTS]; /* r' */
    _Alignas(64) double bend[3][COLLOCATION_POINTS];    /* r'' */
    _Alignas(64) double r[3][COLLOCATION_POINTS];       /* as the bends have it */
    _Alignas(
        64) double jet[COLLOCATION_JET][COLLOCATION_POINTS]; /* r, r_u, r_v, r_uu, r_uv, r_vv */
    _Alignas(64) double moved2[COLLOCATION_POINTS];          /* by the last move, squared */
    struct vec3 from, leave, to, arrive;                     /* its ends, as the bends have them */
};

/* Compiled for one width. */
struct collocation_kernel {
    /* Evaluates the surface at uv and, from there and `tangent`, the bends; from these, from `from`
     * and `leave`, all else but uv. */
    void (*evaluate)(const struct surface *surface, struct collocation_piece *piece);
    /* Moves uv to where the path is when it leaves its start by `turn` more to the side, and the
     * ends of this piece lie further along it by `shift`. */
    void (*move)(struct collocation_piece *piece, struct vec3 turn, const double shift[2]);
};

extern const struct collocation_kernel collocation_kernel_2, collocation_kernel_4,
    collocation_kernel_8;

/* Where a path begins: the cubic from one (u, v) to another with these velocities there; and its
 * tangent as that of the cubic in space, on arcs right to fourth order in their turn, by the unit
 * tangents at both ends and the chord by the length of the way. */
struct collocation_guess {
    double from[2], to[2], leave[2], arrive[2];
    struct vec3 tangent[2], mean;
};

/* A geodesic of given length from a point. */
struct collocation {
    const struct collocation_kernel *kernel;
    const struct surface_point *from;
    struct vec3 leave; /* unit tangents at both ends, and the end */
    struct vec3 to, arrive;
    double length;
    struct collocation_guess guess;
    int pieces;
    struct collocation_piece piece[COLLOCATION_PIECES];
    double share[COLLOCATION_PIECES]; /* of the way at which each piece ends, as guessed */
    int axis[COLLOCATION_PIECES]; /* of the knot line at the end of each piece; COLLOCATION_ALONG:
                                     none, */
    double knot[COLLOCATION_PIECES];  /* its parameter, */
    double uv[COLLOCATION_PIECES][2]; /* and where the path meets it */
};

/* Begins near the cubic in (u, v) from `from` to the point `to` with these unit tangents there,
 * in so many pieces `each` between two knot lines, of at most `lanes` points at once (0: any).
 * False where there may be folds, poles or joints of a shell on the way, or it has too many pieces.
 */
bool collocation_begin(struct collocation *path, const struct surface_point *from,
                       const struct surface_point *to, const struct vec3 tangent[2], double length,
                       int each, int lanes);

/* Half a round: sets `to` and `arrive` by the surface where the path is. False where it has none.
 */
bool collocation_evaluate(struct collocation *path);

/* After the first of these: splits pieces of whose bend the last terms in Legendre's polynomials
 * that eight points show turn the path by more than `most`, in radians, into two, four or eight,
 * and begins anew; `split` says whether there are any. False when that makes too many pieces. */
bool collocation_refine(struct collocation *path, double most, bool *split);

/* The other half, with the direction at the start turned by `angle` about the normal: moves the
 * path to where that leads. The farthest that a point has moved; infinite where it gets lost. */
double collocation_move(struct collocation *path, double angle);

/* By how much the bend differs along the path at the most, times its length: twice what a
 * round leaves of an error. */
double collocation_change(const struct collocation *path);

/* Whether every point lies in the span of its piece, and the surface at `end`, where the path ends,
 * and at its start is not folded between the points and the path. */
bool collocation_is_whole(const struct collocation *path, const struct surface_point *end);

#endif
