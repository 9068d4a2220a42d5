/* SPDX-License-Identifier: MIT */
/* How well a table of permeabilities foretells what it is not told. */
#ifndef CLI_HOLD_OUT_H
#define CLI_HOLD_OUT_H

#include "api/limits.h"
#include "api/problem.h"
#include <stdio.h>

/*
 * Reads a permeability of the model `table`, alone or in a drape request. Each inner row (a shear
 * angle), and with a second axis each inner column (a fraction), is left out in turn, and what the
 * rest says there is compared: a line for each value, `k1`, `k2`, `k3` in percent of what was
 * measured, and the largest and the root of the mean square of each kind. Ends are not left out,
 * for beyond them a table says nothing of its own. False with the problem set.
 */
bool hold_out_print(const char *bytes, size_t length, const struct api_limits *limits, FILE *out,
                    struct api_problem *problem);

#endif
