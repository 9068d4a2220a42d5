/* SPDX-License-Identifier: MIT */
/*
 * Where the rim leaves the cloth: the net ends at the side of a cell, and the last place that was
 * found on the cloth is near it, for no place is looked for more closely than by 1/64 spacings.
 */
#ifndef SOLVER_RIM_RIM_FRONT_H
#define SOLVER_RIM_RIM_FRONT_H

#include "rim.h"

/* Moves the first and the last point of each uncovered stretch of the rim, of two points or more,
 * to the side of a cell, where it goes straight on from the covered one beside it to a side so
 * near; they are covered then, and the others have the place where the cloth ends. */
void rim_reach_front(struct rim *rim);

#endif
