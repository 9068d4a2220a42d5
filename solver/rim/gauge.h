/* SPDX-License-Identifier: MIT */
/* The divisions of a gauge (`solver/drape.h`): the largest shear of each, while it is gathered. */
#ifndef SOLVER_RIM_GAUGE_H
#define SOLVER_RIM_GAUGE_H

#include "solver/drape.h"

/* Whether a gauge, which may be NULL, has divisions. */
static inline bool gauge_divides(const struct drape_gauge *gauge) {
    return gauge && gauge->divisions > 0;
}

static inline void gauge_begin(struct drape_gauge *gauge) {
    for (size_t k = 0; k < gauge->divisions; k++)
        gauge->most[k] = 0;
}

/* Takes in the shear at a point of the cloth, in degrees; of a gauge without divisions nothing. */
static inline void gauge_note(struct drape_gauge *gauge, double shear_deg, struct vec3 point) {
    if (!gauge_divides(gauge))
        return;
    size_t nearest = 0;
    double least = HUGE_VAL;
    for (size_t k = 0; k < gauge->divisions; k++) {
        double own = vec3_norm2(vec3_sub(gauge->middle[k], point));
        nearest = own < least ? k : nearest;
        least = own < least ? own : least;
    }
    if (fabs(shear_deg) > gauge->most[nearest])
        gauge->most[nearest] = fabs(shear_deg);
}

#endif
