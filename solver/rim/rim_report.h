/* SPDX-License-Identifier: MIT */
/*
 * What the rim tells of a drape: its columns, how much of the part the cloth covers, and the shear
 * of the cloth up to its rim, by area. A cell that the rim cuts counts by the share of it that lies
 * within; the shear of a whole cell is spread evenly between the least and the greatest of its
 * nodes. So nothing jumps when the start moves a little and cells come or go at the rim.
 */
#ifndef SOLVER_RIM_RIM_REPORT_H
#define SOLVER_RIM_RIM_REPORT_H

#include "rim_cells.h"
#include "solver/result.h"

/* The rim and the cells that it cuts, found apart from all else: with a march and a net of its own
 * that share the places. */
struct rim_found {
    struct march march;
    struct net net;
    struct rim rim;
    struct rim_cells cells;
    enum status status;
};

/* What it takes to find the rim of a net that is complete, by another thread where the march has a
 * team. NULL without memory; it lives in the march's arena. */
struct rim_found *rim_report_begin(struct march *march);

/* Finds it; found->status says whether. Errors: STATUS_OUT_OF_MEMORY. */
void rim_report_find(struct rim_found *found);

/* Adds to a result that has its nodes, cells and front, and the counts and the coverage of its
 * summary: the rim, and in the summary all that speaks of the cloth, and the outcome. Errors:
 * STATUS_OUT_OF_MEMORY. */
enum status rim_report(struct march *march, struct rim_found *found,
                       struct drape_result *result) STATUS_MUST_USE;

#endif
