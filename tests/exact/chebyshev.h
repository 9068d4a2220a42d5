/* SPDX-License-Identifier: MIT */
/*
 * Polynomials on [0, 1] by their values at Chebyshev points x_k = (1 - cos(pi k / (n-1))) / 2: the
 * integral from 0 and the value anywhere. What the integrators of `goursat.h` are made of.
 */
#ifndef DRAPE_TESTS_CHEBYSHEV_H
#define DRAPE_TESTS_CHEBYSHEV_H

enum { CHEBYSHEV_MAX = 32 };

struct chebyshev {
    int n;
    double x[CHEBYSHEV_MAX];
    /* integral[i][j]: the integral from 0 to x_i of the polynomial that is 1 at x_j, 0 elsewhere */
    double integral[CHEBYSHEV_MAX][CHEBYSHEV_MAX];
};

void chebyshev_make(struct chebyshev *rule, int n);

/* weight[j]: the value at x of the polynomial that is 1 at x_j (barycentric formula). */
void chebyshev_weights(const struct chebyshev *rule, double x, double weight[CHEBYSHEV_MAX]);

#endif
