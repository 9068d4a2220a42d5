/* SPDX-License-Identifier: MIT */
/* Places of a part that are nearest to places in space. */
#ifndef API_LAMINATE_PART_FOOT_H
#define API_LAMINATE_PART_FOOT_H

#include "solver/part.h"
#include "solver/vec.h"
#include <stdbool.h>

/* The nearest place, exactly on the part, and its normal; false, and no normal, where it has none.
 * A trimmed surface is taken whole. */
bool part_foot(const struct drape_part *part, struct vec3 r, struct vec3 *foot,
               struct vec3 *normal);

#endif
