/* SPDX-License-Identifier: MIT */
/*
 * Why a computation could not run. Every fallible function of the library returns one of these
 * and marks it must-use. How a drape that did run ended is no status: see `drape_outcome`.
 */
#ifndef SOLVER_STATUS_H
#define SOLVER_STATUS_H

enum status {
    STATUS_OK = 0,
    STATUS_OUT_OF_MEMORY,       /* the arena's budget or the machine's memory is used up */
    STATUS_CANCELLED,           /* the monitor said stop */
    STATUS_INVALID,             /* an argument breaks its documented range */
    STATUS_TOO_MANY_NODES,      /* the net would pass `max_nodes` */
    STATUS_START_OFF_SURFACE,   /* the start lies outside the surface or too far from it */
    STATUS_START_STUCK,         /* every yarn leaves the surface, larger than a cell, at once */
    STATUS_DEGENERATE_SURFACE,  /* no tangent plane where one is needed */
    STATUS_GENERATOR_OFF_START, /* a generator's curve does not pass the start */
    STATUS_GENERATOR_PARALLEL,  /* a generator's plane is the tangent plane, or both are parallel */
    STATUS_CUT,                 /* a cut cannot be made: `drape_cut_fault` says why */
    STATUS_NO_CONVERGENCE       /* an iteration did not reach its tolerance */
};

#define STATUS_MUST_USE __attribute__((warn_unused_result))

#endif
