/* SPDX-License-Identifier: MIT */
/*
 * How much shear a fabric bears: its locking angles, and the curve by which it gets worse on the
 * way there. Both know the sign of the shear gamma, which is positive where warp and weft have come
 * closer to each other: the stitches of a non-crimp fabric lock one way first.
 */
#ifndef API_RESULT_SHEAR_LIMIT_H
#define API_RESULT_SHEAR_LIMIT_H

#include "api/request/request.h"

/* Whether the fabric has locking angles. */
bool shear_limit_given(const struct api_fabric *fabric);

/* Whether both are the same; without any, too. */
bool shear_limit_is_even(const struct api_fabric *fabric);

/* Whether it is sheared beyond the one for this sign, degrees; false where it has none. */
bool shear_limit_locks(const struct api_fabric *fabric, double shear_deg);

/* The severity, 0..1, by its curve, straight between the rows, constant beyond the last; before a
 * first row above 0 it is that row's. A curve without negative angles holds for the absolute shear.
 * The fabric must have one (`limit.rows` > 0). */
double shear_limit_severity(const struct api_fabric *fabric, double shear_deg);

#endif
