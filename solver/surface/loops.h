/* SPDX-License-Identifier: MIT */
/*
 * Whether the loops of a trimmed surface bound a region as they are meant to: each is closed, and
 * goes round its inside once. `trim_make` makes something of any loops; whether that is what their
 * owner drew is asked here.
 */
#ifndef SOLVER_SURFACE_LOOPS_H
#define SOLVER_SURFACE_LOOPS_H

#include "trim.h"

enum loop_fault_kind {
    LOOP_SOUND,
    LOOP_OPEN, /* curves do not meet, by more than 1e-4 of the domain and, in space, the tolerance;
                  a polyline alone is closed by its last point's joining the first */
    LOOP_CROSSES /* the loop crosses itself, or goes round twice, over more than 1e-3 of its extent
                    in u or in v */
};

struct loop_fault {
    enum loop_fault_kind kind;
    size_t loop;
    double uv[2];  /* the end of a curve; a point that the loop goes round wrongly */
    double gap[2]; /* LOOP_OPEN: how far away the next curve begins */
};

/* The first fault of the loops that `trim` was made of. O(n log n) for n flattened edges. Scratch
 * comes from `arena`. Errors: STATUS_OUT_OF_MEMORY. */
enum status loops_check(const struct trim_loop *loops, const struct trim *trim,
                        const struct surface *surface, double tolerance, struct arena *arena,
                        struct loop_fault *fault) STATUS_MUST_USE;

#endif
