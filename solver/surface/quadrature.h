/* SPDX-License-Identifier: MIT */
/* Gauss-Legendre quadrature on [-1, 1]: exact for polynomials up to degree 2 count - 1. */
#ifndef SOLVER_SURFACE_QUADRATURE_H
#define SOLVER_SURFACE_QUADRATURE_H

enum { QUADRATURE_MAX = 16 };

struct quadrature {
    int count;
    double node[QUADRATURE_MAX];   /* roots of the Legendre polynomial P_count, decreasing */
    double weight[QUADRATURE_MAX]; /* they sum to 2 */
    double last[QUADRATURE_MAX];   /* P_(count - 1) at the nodes */
};

/* `count`: 1..QUADRATURE_MAX. */
struct quadrature quadrature_make(int count);

/* How much of `count` values, `stride` apart, is in the last Legendre polynomials, P_(count - 1)
 * and P_(count - 2): the square of its share of their mean is about what is wrong of that. */
double quadrature_tail(const struct quadrature *rule, const double *value, int stride);

#endif
