/* SPDX-License-Identifier: MIT */
#include "angle.h"

/* Up to pi sixteen terms leave less than 1e-16. */
double angle_sinc(double x) {
    double square = x * x, sum = 1;
    if (square < 0.0625)
        return angle_small_sinc(square);
    for (int k = 15; k > 0; k--)
        sum = 1 - square / (2 * k * (2 * k + 1)) * sum;
    return sum;
}

/* The nearest multiple of 90 degrees is taken off first; the rest is at most 45. */
void angle_sincos_deg(double degrees, double *sine, double *cosine) {
    double quarter = floor(degrees / 90 + 0.5);
    double x = (degrees - 90 * quarter) * (ANGLE_PI / 180);
    double s = x * angle_sinc(x), c = 1, square = x * x;
    for (int k = 10; k > 0; k--)
        c = 1 - square / (2 * k * (2 * k - 1)) * c;
    int turn = (int)(quarter - 4 * floor(quarter / 4));
    *sine = turn == 0 ? s : turn == 1 ? c : turn == 2 ? -s : -c;
    *cosine = turn == 0 ? c : turn == 1 ? -s : turn == 2 ? -c : s;
}

const double angle_arctangents[ANGLE_ARCTANGENTS] = {
    0.0,
    0.06241880999595735,
    0.12435499454676144,
    0.18534794999569476,
    0.24497866312686414,
    0.3028848683749714,
    0.35877067027057225,
    0.4124104415973873,
    0.4636476090008061,
    0.5123894603107377,
    0.5585993153435624,
    0.6022873461349642,
    0.6435011087932844,
    0.6823165548747481,
    0.7188299996216245,
    0.7531512809621944,
    0.7853981633974483,
};

double angle_atan_deg(double x) {
    double size = fabs(x);
    int k = angle_next_sixteenth(size);
    return copysign(angle_atan_from(k, angle_arctangents[k], size) * (180 / ANGLE_PI), x);
}

double angle_atan2_deg(double y, double x) {
    double ax = fabs(x), ay = fabs(y);
    if (!(ax + ay > 0))
        return 0;
    double angle = ay <= ax ? angle_atan_deg(ay / ax) : 90 - angle_atan_deg(ax / ay);
    if (x < 0)
        angle = 180 - angle;
    return y < 0 ? -angle : angle;
}
