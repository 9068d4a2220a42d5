/* SPDX-License-Identifier: MIT */
#include "angle.h"

/* sum_k (-1)^k x^(2k) / (2k+1)!, Horner from the term that no longer counts: 5 terms leave less
 * than 1e-16 up to 1/4, 15 up to pi. */
double angle_sinc(double x) {
    double square = x * x, sum = 1;
    for (int k = square < 0.0625 ? 5 : 15; k > 0; k--)
        sum = 1 - square / (2 * k * (2 * k + 1)) * sum;
    return sum;
}

/* cos(x) for |x| <= pi/4. */
static double cosine_series(double x) {
    double square = x * x, sum = 1;
    for (int k = 10; k > 0; k--)
        sum = 1 - square / (2 * k * (2 * k - 1)) * sum;
    return sum;
}

/* The nearest multiple of 90 degrees is taken off first; the rest is at most 45. */
void angle_sincos_deg(double degrees, double *sine, double *cosine) {
    double quarter = floor(degrees / 90 + 0.5);
    double x = (degrees - 90 * quarter) * (ANGLE_PI / 180);
    double s = x * angle_sinc(x), c = cosine_series(x);
    int turn = (int)(quarter - 4 * floor(quarter / 4));
    *sine = turn == 0 ? s : turn == 1 ? c : turn == 2 ? -s : -c;
    *cosine = turn == 0 ? c : turn == 1 ? -s : turn == 2 ? -c : s;
}

/* atan(x) for 0 <= x <= 1: the argument is halved twice, atan x = 2 atan(x / (1 + sqrt(1 + x^2))),
 * to at most tan(pi/16) = 0.199, where 11 terms of the series are enough. */
static double arctangent(double x) {
    x = x / (1 + sqrt(1 + x * x));
    x = x / (1 + sqrt(1 + x * x));
    double square = x * x, sum = 0;
    for (int k = 11; k >= 0; k--)
        sum = 1.0 / (2 * k + 1) - square * sum;
    return 4 * x * sum;
}

double angle_atan2_deg(double y, double x) {
    double ax = fabs(x), ay = fabs(y);
    if (!(ax + ay > 0))
        return 0;
    double angle = ay <= ax ? arctangent(ay / ax) * (180 / ANGLE_PI)
                            : 90 - arctangent(ax / ay) * (180 / ANGLE_PI);
    if (x < 0)
        angle = 180 - angle;
    return y < 0 ? -angle : angle;
}

double angle_between_deg(struct vec3 a, struct vec3 b) {
    return angle_atan2_deg(vec3_norm(vec3_cross(a, b)), vec3_dot(a, b));
}
