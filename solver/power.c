/* SPDX-License-Identifier: MIT */
#include "power.h"

#include "power_formulas.h"

#include <math.h>

double power_log(double x) {
    return power_log_normal(x);
}

double power_exp(double x) {
    if (!(x > -746))
        return x < 0 ? 0 : x;
    if (x > 710)
        return HUGE_VAL;
    return power_exp_normal(x);
}

double power_of(double a, double p) {
    return a > 0 ? power_exp(p * power_log(a)) : 0;
}

double power_mean(double a, double b, double t) {
    if (!(t > 0))
        return a;
    if (!(t < 1))
        return b;
    return a > 0 && b > 0 ? power_exp((1 - t) * power_log(a) + t * power_log(b)) : 0;
}
