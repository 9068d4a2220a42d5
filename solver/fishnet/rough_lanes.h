/* SPDX-License-Identifier: MIT */
/* The formulas of rough edges for lanes, for files that say LANES (solver/lanes.h). */
#ifndef SOLVER_FISHNET_ROUGH_LANES_H
#define SOLVER_FISHNET_ROUGH_LANES_H

#include "rough.h"
#define FORMULAS_OF_LANES
#include "solver/angle_sinc.h"
#include "solver/shell/tangent_plane.h"

#include "arc.h"
#include "rough_formulas.h"
#undef FORMULAS_OF_LANES

#endif
