/* SPDX-License-Identifier: MIT */
/* Why a net ends where it does. */
#ifndef SOLVER_REASON_H
#define SOLVER_REASON_H

/* Why the net has no node at a place of its front. X(id, name) */
#define DRAPE_REASON_LIST(X)                                                                       \
    X(BOUNDARY, "boundary")   /* the surface, or its trimmed region, ends */                       \
    X(COLLAPSED, "collapsed") /* the spheres no longer meet on the surface */                      \
    X(NO_CONVERGENCE, "no_convergence")                                                            \
    X(DEGENERATE, "degenerate") /* no tangent plane there, or on the way */                        \
    X(EXTENT, "extent")                                                                            \
    X(FOLD, "fold") /* the net would overlap itself, or meet itself out of step */

enum drape_reason {
#define X(id, name) DRAPE_REASON_##id,
    DRAPE_REASON_LIST(X)
#undef X
        DRAPE_REASON_COUNT
};

/* The reason's name as in the contract, in static storage. */
const char *drape_reason_name(enum drape_reason reason);

#endif
