/* SPDX-License-Identifier: MIT */
#include "chebyshev.h"
#include <assert.h>
#include <math.h>

/* The integral of T_k from -1 to c: (T_(k+1)/(k+1) - T_(k-1)/(k-1)) / 2 between the limits. */
static double integral_of(int k, double c) {
    double angle = acos(c);
    if (k == 0) {
        return c + 1;
    }
    if (k == 1) {
        return (c * c - 1) / 2;
    }
    double sign = k % 2 ? 1 : -1; /* (-1)^(k+1) */
    double top = cos((k + 1) * angle) / (k + 1) - cos((k - 1) * angle) / (k - 1);
    double bottom = sign / (k + 1) - sign / (k - 1);
    return (top - bottom) / 2;
}

/* The cardinal polynomial of point j is sum_k (2 / m) e_k e_j T_k(c_j) T_k, with m = n - 1 and e
 * one half at both ends, else 1. */
static void make(struct chebyshev *rule, int n) {
    int m = n - 1;
    rule->n = n;
    for (int i = 0; i < n; i++) {
        double c = -cos(M_PI * i / m);
        rule->x[i] = (1 + c) / 2;
        for (int j = 0; j < n; j++) {
            double sum = 0, angle = M_PI * (m - j) / m;
            for (int k = 0; k < n; k++) {
                double e = (k == 0 || k == m ? 0.5 : 1) * (j == 0 || j == m ? 0.5 : 1);
                sum += 2 * e / m * cos(k * angle) * integral_of(k, i == 0 ? -1 : c);
            }
            rule->integral[i][j] = sum / 2;
        }
    }
}

void chebyshev_make(struct chebyshev *rule, int n) {
    static struct chebyshev made[CHEBYSHEV_MAX + 1]; /* most tests want the same few */
    assert(n >= 2 && n <= CHEBYSHEV_MAX);
    if (made[n].n == 0) {
        make(&made[n], n);
    }
    *rule = made[n];
}

void chebyshev_weights(const struct chebyshev *rule, double x, double weight[CHEBYSHEV_MAX]) {
    double sum = 0;
    for (int j = 0; j < rule->n; j++) {
        if (fabs(x - rule->x[j]) < 1e-15) {
            for (int k = 0; k < rule->n; k++) {
                weight[k] = k == j;
            }
            return;
        }
        double e = (j == 0 || j == rule->n - 1 ? 0.5 : 1) * (j % 2 ? -1 : 1);
        weight[j] = e / (x - rule->x[j]);
        sum += weight[j];
    }
    for (int j = 0; j < rule->n; j++) {
        weight[j] /= sum;
    }
}
