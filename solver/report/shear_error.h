/* SPDX-License-Identifier: MIT */
/*
 * How far the shear at the nodes of a corrected net is from that of the exact one. With g and e the
 * unit tangents of warp and weft, sin gamma = g . e, so that to first order
 *
 *     cos gamma dgamma = dg . (e - sin gamma g) + de . (g - sin gamma e).
 *
 * A tangent is wrong by what its difference stencil leaves, a share of the fifth difference D5 of
 * the yarn, and by the difference of its nodes' errors along the yarn over the spacing
 * (`estimate.h`), which is far less than these errors: they go on alike from node to node. Near
 * rough edges, where the tangent is the mean of the two edges', it is wrong by the angle by which
 * they turn sideways.
 */
#ifndef SOLVER_REPORT_SHEAR_ERROR_H
#define SOLVER_REPORT_SHEAR_ERROR_H

#include "defect.h"

/* Of the nodes of a tile, for which the net's view and that of the net before it was corrected have
 * been moved to it; after `estimate_make`. In degrees; < 0 where the net says nothing, on yarns of
 * less than six nodes. */
void shear_error_of_tile(struct defect_net *net, const struct net_view *before,
                         double error_deg[NET_TILE][NET_TILE]);

#endif
