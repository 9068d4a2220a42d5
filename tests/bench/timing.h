/* SPDX-License-Identifier: MIT */
/* What the benches of the solver share: the methods that they time, and the clock. */
#ifndef BENCH_TIMING_H
#define BENCH_TIMING_H

#include "solver/drape.h"
#include "solver/shell/shell.h"
#include "solver/surface/surface.h"
#include "solver/surface/trim.h"
#include <time.h>

enum { METHODS = 4 };

static const struct {
    enum drape_method method;
    const char *name;
} methods[METHODS] = {
    {DRAPE_GIB, "gib"}, {DRAPE_BASIC, "basic"}, {DRAPE_GIB4, "gib4"}, {DRAPE_GEODESIC, "geodesic"}};

/* Of the processor, by this process. */
static inline double seconds(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

#endif
