/* SPDX-License-Identifier: MIT */
/*
 * A NURBS surface as its owner wrote it down:
 *
 *              sum_i sum_j N_i^p(u) N_j^q(v) w_ij P_ij
 *   r(u, v) = ----------------------------------------- ,   u in [U_p, U_m], v in [V_q, V_n],
 *                sum_i sum_j N_i^p(u) N_j^q(v) w_ij
 *
 * (paper, equation 19). This is a view of the caller's arrays and the check that they make a
 * surface; `surface.h` turns it into something that can be evaluated.
 */
#ifndef SOLVER_SURFACE_NURBS_H
#define SOLVER_SURFACE_NURBS_H

#include "solver/status.h"
#include "solver/vec.h"
#include <stddef.h>

enum {
    NURBS_DEGREE_MAX = 9,
    NURBS_SIZE_MAX = 512 /* control points along one direction */
};

/* One parametric direction: degree p, `size` control points, size + p + 1 knots. */
struct nurbs_axis {
    int degree;          /* 1..NURBS_DEGREE_MAX */
    int size;            /* degree + 1 .. NURBS_SIZE_MAX */
    const double *knots; /* non-decreasing, clamped or not, interior multiplicity <= degree */
    size_t knot_count;
};

struct nurbs {
    struct nurbs_axis u, v;
    const struct vec3 *points; /* size_u * size_v, v runs fastest, not multiplied by the weights */
    size_t point_count;
    const double *weights; /* as many, positive; NULL: all 1 */
    size_t weight_count;   /* 0 when weights is NULL */
};

/* The member of a definition that a fault lies in. */
enum nurbs_member {
    NURBS_DEGREE_U,
    NURBS_DEGREE_V,
    NURBS_SIZE_U,
    NURBS_SIZE_V,
    NURBS_KNOTS_U,
    NURBS_KNOTS_V,
    NURBS_POINTS,
    NURBS_WEIGHTS
};

struct nurbs_fault {
    enum nurbs_member member;
    int has_index;      /* whether one element is to blame */
    size_t index;       /* which */
    const char *reason; /* a sentence in static storage */
};

/* STATUS_OK, or STATUS_INVALID with the first fault (may be NULL) in the order of `nurbs_member`.
 * Checks all that the ranges above say, finite numbers, and a domain of positive length. */
enum status nurbs_validate(const struct nurbs *nurbs, struct nurbs_fault *fault) STATUS_MUST_USE;

#endif
