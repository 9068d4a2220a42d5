/* SPDX-License-Identifier: MIT */
/*
 * The fields of a drape at points of the caller's choosing: each point goes to the nearest point of
 * the draped cloth (`facets.h`), where the fields of the cells are interpolated between their
 * middles, so that they are continuous over the net.
 *
 * - Plain fields (shear, thickness, ...) are interpolated as they are, directions as vectors that
 *   are made unit again.
 * - The permeability is interpolated by its components in the frame of the warp (`net.h`),
 * which turns with the cloth: so a curved cloth loses nothing, and what is positive stays so. k1,
 * k2 and their direction follow from the interpolated tensor.
 * - What is counted or flagged (i, j, locked, ...) is that of the cell in which the point lies.
 * - In a rigid cavity, the drape's own or one that the target has, thickness, fibres and
 *   permeability follow from the interpolated shear and the height (`cavity.h`).
 *
 * Between the middle of a cell at the rim and the rim itself there are fewer neighbours, and the
 * fields level off. Beyond the rim they are those of the rim.
 */
#ifndef API_MAP_MAP_H
#define API_MAP_MAP_H

#include "api/format/format.h"
#include "api/problem.h"
#include "api/result/columns.h"
#include "plies.h"
#include "solver/drape.h"
#include "target.h"

enum { API_MAP_WARNING_SIZE = 256 };

/* Its columns lie in the arena of the call. Not to be moved. */
struct api_map {
    struct map_fields
        fields; /* its columns: id, pid, role, those of the cells, kxx kyy kzz kxy kyz kxz
                        where there is a permeability, distance, extrapolated;
                        on a mesh those of the plies */
    struct map_stack stack; /* on a mesh: the drape as a stack of one ply */
    struct api_column_source columns[API_COLUMNS_MAX];
    char warning[MAP_WARNINGS_MAX][API_MAP_WARNING_SIZE]; /* texts of warnings */
};

/* Fields on a target, none yet, that are to have these columns. */
struct map_fields map_target_fields(const struct map_target *target,
                                    const struct api_column_source *columns);

/*
 * Maps the result that `reader` holds onto `mesh`, which must outlive `map`. What presses the cloth
 * the mesh has to know (`cavity_take_cloth`); under heights of its own, or a punch, the cloth has
 * to have a thickness. More than the columns (8 bytes a point and column) is taken from the arena
 * only for the time of the call. There is a warning when more than half of the points lie further
 * from the cloth than both its larger spacing and its thickness there, else one of elements without
 * a ply: those whose middle lies beyond the cloth, and those that have no area. `monitor` (may be
 * NULL) is asked now and then whether to go on. Returns API_OK, API_INVALID_REQUEST when the net
 * has no cells, the caller's direction is normal to an element or the cloth of a cavity's heights
 * has no thickness, API_INTERNAL for a damaged container, API_CANCELLED or API_OUT_OF_MEMORY.
 */
enum api_problem_id api_map_make(const struct api_reader *reader, const struct map_target *target,
                                 const struct drape_monitor *monitor, struct arena *arena,
                                 struct api_map *map, struct api_problem *problem) STATUS_MUST_USE;

#endif
