/* SPDX-License-Identifier: MIT */
/* The control points of surfaces and trim curves, in the forms that geomdl and its relatives write.
 */
#ifndef API_REQUEST_CONTROL_H
#define API_REQUEST_CONTROL_H

#include "api/json/value.h"

/* Where control points and weights are: together in an object, or the bare list of points with the
 * weights beside it. Points to its own members: not to be copied. */
struct decode_control {
    struct json_value net, points, weights;
};
void decode_control_find(const struct json_value *owner, struct decode_control *control);

#endif
