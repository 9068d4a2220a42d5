/* SPDX-License-Identifier: MIT */
/* The cloth of a drape between rigid faces: its thickness, fibres and permeability follow from the
 * shear at the point and the height there (`api/result/fields.h`). */
#ifndef API_MAP_PRESS_H
#define API_MAP_PRESS_H

#include "net.h"

/* Of the cloth by itself: n t0 / cos gamma. */
double press_thickness(const struct api_request *cloth, double shear_deg);

/* Writes what a cavity of this height (> 0) makes of cloth of this shear into the row of a point,
 * in which all else stays. Returns whether it has more fibres than can be
 * packed. */
bool press_row(const struct map_net *net, const struct api_request *cloth, double height,
               double shear_deg, double *row);

#endif
