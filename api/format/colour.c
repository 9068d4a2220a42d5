/* SPDX-License-Identifier: MIT */
#include "colour.h"

#include <math.h>

static const uint8_t viridis[][3] = {
    {0x44, 0x01, 0x54}, {0x48, 0x28, 0x78}, {0x3e, 0x4a, 0x89}, {0x31, 0x68, 0x8e},
    {0x26, 0x82, 0x8e}, {0x1f, 0x9e, 0x89}, {0x35, 0xb7, 0x79}, {0x6d, 0xcd, 0x59},
    {0xb4, 0xde, 0x2c}, {0xfd, 0xe7, 0x25},
};

enum { STEPS = sizeof viridis / sizeof *viridis - 1 };

void colour_viridis(double t, double srgb[3]) {
    double place = fmin(fmax(t, 0), 1) * STEPS;
    int step = place < STEPS ? (int)place : STEPS - 1;
    double part = place - step;
    for (int k = 0; k < 3; k++)
        srgb[k] = ((1 - part) * viridis[step][k] + part * viridis[step + 1][k]) / 255;
}

double colour_linear(double component) {
    return component <= 0.04045 ? component / 12.92 : pow((component + 0.055) / 1.055, 2.4);
}
