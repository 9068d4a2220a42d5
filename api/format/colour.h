/* SPDX-License-Identifier: MIT */
/*
 * Viridis (Smith and van der Walt, 2015, CC0): a sequence of colours whose perceived
 * lightness grows evenly, also for colour-blind eyes and in print. Interpolated between ten of its
 * colours.
 */
#ifndef API_FORMAT_COLOUR_H
#define API_FORMAT_COLOUR_H

#include <stdint.h>

/* The colour at `t` of 0..1 (clamped): sRGB, each component in 0..1. */
void colour_viridis(double t, double srgb[3]);

/* A component of sRGB as linear light (IEC 61966-2-1). */
double colour_linear(double component);

#endif
