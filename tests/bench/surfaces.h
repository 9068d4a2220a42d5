/* SPDX-License-Identifier: MIT */
/*
 * Twenty surfaces as they come from design: degrees 2 to 7, one span and many, uneven and double
 * knots, weights of 0.3 to 3, trims, closed directions, poles, singular corners. What a node costs
 * on the worst of them counts; a gently waved square flatters.
 */
#ifndef DRAPE_TESTS_BENCH_SURFACES_H
#define DRAPE_TESTS_BENCH_SURFACES_H

#include "solver/surface/trim.h"
#include "tests/exact/shapes.h"

enum { BENCH_SURFACES = 20, BENCH_LOOPS_MAX = 2, BENCH_CORNERS_MAX = 32 };

struct bench_surface {
    const char *name;
    struct shape shape;
    double angle_deg; /* of the warp */
    double start[2];  /* as shares of the domain */
    size_t loop_count;
    struct trim_loop loops[BENCH_LOOPS_MAX];
    struct trim_curve curves[BENCH_LOOPS_MAX];
    double corners[BENCH_LOOPS_MAX][BENCH_CORNERS_MAX][2];
};

/* Surface `number`, 0 .. BENCH_SURFACES - 1; it refers to itself and must not be moved. */
void bench_surface_make(struct bench_surface *surface, int number);

#endif
