/* SPDX-License-Identifier: MIT */
/* The formulas of this folder for lanes, for files that say LANES (solver/lanes.h). */
#ifndef SOLVER_FISHNET_CELL_LANES_H
#define SOLVER_FISHNET_CELL_LANES_H

#include "correction.h"
#include "rough_lanes.h"
#include "solver/surface/evaluate_lanes.h"

#define FORMULAS_OF_LANES
#include "cell_formulas.h"
#include "correction_formulas.h"
#undef FORMULAS_OF_LANES

#endif
