/* SPDX-License-Identifier: MIT */
#include "control.h"

void decode_control_find(const struct json_place *owner, struct decode_control *control) {
    static const char *const keys[] = {"points", "weights", NULL};
    control->net = place_member(owner, "control_points");
    if (place_type(&control->net) != PLACE_OBJECT) {
        control->points = control->net;
        control->weights = place_member(owner, "weights");
        return;
    }
    place_object(&control->net, keys);
    control->points = place_member(&control->net, "points");
    control->weights = place_member(&control->net, "weights");
    struct json_place beside = place_member(owner, "weights");
    if (place_given(&beside))
        place_fault(&beside, "must be in control_points, where the points are");
}
