/* SPDX-License-Identifier: MIT */
#include "control.h"

void decode_control_find(const struct json_value *owner, struct decode_control *control) {
    static const char *const keys[] = {"points", "weights", NULL};
    control->net = value_member(owner, "control_points");
    if (value_type(&control->net) != VALUE_OBJECT) {
        control->points = control->net;
        control->weights = value_member(owner, "weights");
        return;
    }
    value_object(&control->net, keys);
    control->points = value_member(&control->net, "points");
    control->weights = value_member(&control->net, "weights");
    struct json_value beside = value_member(owner, "weights");
    if (value_given(&beside))
        value_fault(&beside, "must be a member of control_points, beside the points");
}
