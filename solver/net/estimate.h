/* SPDX-License-Identifier: MIT */
/*
 * How far the nodes of a corrected net are from those of the exact one: the errors of its edges,
 * and how they add up along the yarns.
 *
 * An edge of length d along a yarn r(s) has the chord c, and with the differences D2, D3, D4 of the
 * net along the yarn, and those E2 of what the correction has moved, the square of the chord that
 * the correction gives it is wrong by about
 *
 *     D2 . E2 / 6 + (5/144 + 1/240) D2 . D4 + (3/960 - 1/576) |D3|^2:
 *
 * the first net's error in D2, and the terms of order d^6. With the error e of an edge, the error
 * of a node D is along BD that of B and e, along CD that of C and e; what it had along the other
 * yarn comes in as the yarns turn sideways. All are added up by their size.
 */
#ifndef SOLVER_NET_ESTIMATE_H
#define SOLVER_NET_ESTIMATE_H

#include "march.h"

/* Estimates the errors of all nodes of a march that corrected the net march->first, whose nodes
 * keep them in place of their parameters. Errors: STATUS_OUT_OF_MEMORY. */
enum status estimate_make(struct march *march) STATUS_MUST_USE;

/* The estimate of a node `now` by that `before`, in length. */
double estimate_of(const struct net_node *before, const struct net_node *now);

#endif
