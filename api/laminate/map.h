/* SPDX-License-Identifier: MIT */
/*
 * The stack on the caller's mesh, or at points: what plies lie at the middle of each element, how
 * thick they are pressed together (`solver/stack.h`), and what they let flow. A ply lies where its
 * cloth does and, if it has a boundary, inside that.
 *
 * The nets are read one after the other; of each, three numbers an element stay: the shear and the
 * direction of the warp in the tangent plane of the first net that reaches the element. Plies with
 * the same net have the same.
 */
#ifndef API_LAMINATE_MAP_H
#define API_LAMINATE_MAP_H

#include "api/map/map.h"
#include "laminate.h"

/*
 * Maps a laminate that is resolved. `nets[n]` reads the result of its drape n; NULL where that
 * failed: its plies are left out, with a warning. Columns: id, pid, ply_count, the largest absolute
 * shear_deg, and where all plies of the laminate know what they take: thickness,
 * fiber_volume_fraction, porosity, pressure, k1, k2, k3 and the direction of k1, locked,
 * packing_exceeded, out_of_table (1 where any ply there is), the tensor, distance (the least),
 * extrapolated (no ply); zeros where there is no ply. On a mesh also the rows of the plies.
 * API_OK, API_INVALID_REQUEST (no net, a boundary that cannot be followed on its cloth, a
 * direction normal to an element), API_INTERNAL, API_CANCELLED or API_OUT_OF_MEMORY.
 */
enum api_problem_id laminate_map(const struct laminate *laminate,
                                 const struct api_reader *const *nets,
                                 const struct map_target *target,
                                 const struct drape_monitor *monitor, struct arena *arena,
                                 struct api_map *map, struct api_problem *problem) STATUS_MUST_USE;

#endif
