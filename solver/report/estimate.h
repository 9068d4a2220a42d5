/* SPDX-License-Identifier: MIT */
/*
 * How far the nodes of a corrected net are from those of the exact one: the defects of its edges
 * (`defect.h`), and what they add up to. With e that of an edge, and c the unit vectors along the
 * edges, the error x of a node D is to first order the vector in the plane of BD and CD with
 *
 *     c_BD . x_D = c_BD . x_B + e_BD,   c_CD . x_D = c_CD . x_C + e_CD.
 *
 * So add up what is known of the defects, with its sign, and what is not, once with the same sign
 * in both families of yarns and once with opposite ones; the estimate is a multiple of the first
 * sum and the other two, by their size. Nodes that the growth placed follow in its order: the end
 * of a yarn that goes straight on along a free edge goes on as it went before, and aside by what
 * the yarn beside it turns over a spacing, for the free edge lies somewhere between the two. Where
 * weft slides the estimate is the distance between both nets.
 */
#ifndef SOLVER_REPORT_ESTIMATE_H
#define SOLVER_REPORT_ESTIMATE_H

#include "solver/march/march.h"

/* Estimates the errors of all nodes of a march that corrected the net march->first, whose nodes
 * keep them in place of theirs. Errors: STATUS_OUT_OF_MEMORY. */
enum status estimate_make(struct march *march) STATUS_MUST_USE;

/* The estimate of a node by that of the net before, in length. */
double estimate_of(const struct net_node *before);

/* What its error adds up from, each a vector in length: what is known of the edges, and what is
 * not, once with both families longer by it, once with warp longer and weft shorter. The estimate
 * is the sum of their sizes times their shares. */
enum estimate_mode { ESTIMATE_KNOWN, ESTIMATE_LONGER, ESTIMATE_APART, ESTIMATE_MODES };

void estimate_errors(const struct net_node *before, struct vec3 error[ESTIMATE_MODES]);
extern const double estimate_share_of_known; /* of others 1 */

#endif
