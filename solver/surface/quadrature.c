/* SPDX-License-Identifier: MIT */
#include "quadrature.h"

#include <math.h>

#include "solver/angle.h"

/* P_n(x) and P_n'(x) by the three-term recurrence. */
static double legendre(int n, double x, double *derivative) {
    double before = 1, value = x;
    for (int k = 2; k <= n; k++) {
        double next = ((2 * k - 1) * x * value - (k - 1) * before) / k;
        before = value;
        value = next;
    }
    *derivative = n * (x * value - before) / (x * x - 1);
    return value;
}

/* Newton from the asymptotic roots cos(pi (k + 3/4) / (n + 1/2)); weight 2 / ((1 - x^2) P'^2). */
struct quadrature quadrature_make(int count) {
    struct quadrature rule = {.count = count};
    for (int k = 0; k < count; k++) {
        double x, sine, derivative;
        angle_sincos_deg(180 * (k + 0.75) / (count + 0.5), &sine, &x);
        for (int round = 0; round < 6; round++)
            x -= legendre(count, x, &derivative) / derivative;
        (void)legendre(count, x, &derivative);
        rule.node[k] = x;
        rule.weight[k] = 2 / ((1 - x * x) * derivative * derivative);
        rule.last[k] = (1 - x * x) * derivative / count;
    }
    return rule;
}

/* With P_(n-2) = (2n - 1) / (n - 1) x P_(n-1) in the nodes. */
double quadrature_tail(const struct quadrature *rule, const double *value, int stride) {
    int n = rule->count;
    double last = 0, before = 0;
    for (int k = 0; k < n; k++) {
        double own = rule->weight[k] * value[k * stride] * rule->last[k];
        last += own;
        before += own * rule->node[k];
    }
    return fabs(last) * (2 * n - 1) +
           fabs(before) * (2 * n - 3) * (2 * n - 1) / (n > 1 ? n - 1 : 1);
}
