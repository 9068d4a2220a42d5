/* SPDX-License-Identifier: MIT */
/*
 * A row of tiles of the net at the same height: a strip of the result that is made by itself, after
 * all have been counted, so that strips can be made at the same time.
 */
#ifndef SOLVER_REPORT_REPORT_STRIP_H
#define SOLVER_REPORT_REPORT_STRIP_H

#include "solver/fishnet/yarn.h"
#include "solver/march/march.h"
#include "solver/result.h"

/* Nodes that are kept of each of two rows. */
enum { REPORT_SPOTS = 64 };

struct report_tally {
    size_t nodes, cells, front;
};

struct report_strip {
    const struct march *march;
    struct drape_result *result;
    const struct net_window *windows; /* on its tiles, in order */
    size_t count;
    struct report_tally holds;            /* how much it has for the columns */
    struct report_tally next;             /* where in them its next one goes */
    double covered;                       /* area of its cells */
    double estimate_max, shear_error_max; /* of its nodes; -1 without any */
    size_t reasons[DRAPE_REASON_COUNT];
    struct surface_cursor cursor;
    struct net_view before;
    struct yarn_spot *spots; /* of a net with rough edges: the nodes of two rows that have been
                                measured last, that of (i, j) at i % REPORT_SPOTS of row j % 2 */
};

/* Counts what one of an array of strips holds, as a task of a team. */
void report_strip_count(void *strips, int number);

/* Writes its nodes, cells and ends, sorted by j, then i, to the columns from `next` on. */
void report_strip_add(struct report_strip *strip);

/* Writes the error estimates of the places and the shear of the nodes of one of an array of strips,
 * as a task of a team, from the net before it was corrected. Where that had no node they are -1. */
void report_strip_add_estimates(void *strips, int number);

#endif
