/* SPDX-License-Identifier: MIT */
/* The divisions of the statistics (`solver/result.h`): the largest shear of each, while it is
 * gathered. */
#ifndef SOLVER_RIM_STATISTICS_H
#define SOLVER_RIM_STATISTICS_H

#include "solver/result.h"

/* Whether the statistics, which may be NULL, have divisions. */
static inline bool statistics_divides(const struct drape_statistics *statistics) {
    return statistics && statistics->divisions > 0;
}

/* Takes in the shear at a point of the cloth, in degrees; of statistics without divisions nothing.
 */
static inline void statistics_note_shear(struct drape_statistics *statistics, double shear_deg,
                                         struct vec3 point) {
    if (!statistics_divides(statistics))
        return;
    size_t nearest = 0;
    double least = HUGE_VAL;
    for (size_t k = 0; k < statistics->divisions; k++) {
        double own = vec3_norm2(vec3_sub(statistics->middle[k], point));
        nearest = own < least ? k : nearest;
        least = own < least ? own : least;
    }
    if (fabs(shear_deg) > statistics->most[nearest])
        statistics->most[nearest] = fabs(shear_deg);
}

#endif
