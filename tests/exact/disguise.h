/* SPDX-License-Identifier: MIT */
/* Other parametrisations of the same surface. */
#ifndef DRAPE_TESTS_DISGUISE_H
#define DRAPE_TESTS_DISGUISE_H

#include "shapes.h"

/* Between 1 / largest and largest, evenly on a logarithmic scale. */
double disguise_spread(uint64_t *seed, double largest);

/* Changes the parameter of direction k at random: degree raised, a knot inserted, projective,
 * reversed, knots moved and scaled. Returns how often that turned the normal round. */
int disguise_direction(struct shape *shape, int k, uint64_t *seed);

/* Both directions so, and the normal where it was. */
void disguise_keeping_normal(struct shape *shape, uint64_t *seed);

/* One direction, but for projective changes: what was x becomes map[0] + map[1] x. */
void disguise_affine(struct shape *shape, int k, uint64_t *seed, double map[2]);

#endif
