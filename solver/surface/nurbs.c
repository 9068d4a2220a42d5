/* SPDX-License-Identifier: MIT */
#include "nurbs.h"

#include <stdbool.h>

static enum status nurbs_fault_at(struct nurbs_fault *fault, enum nurbs_member member,
                                  int has_index, size_t index, const char *reason) {
    if (fault)
        *fault = (struct nurbs_fault){member, has_index, index, reason};
    return STATUS_INVALID;
}

/* Knots are finite and do not decrease; inside the domain none is repeated more than `degree`
 * times, where the surface would tear; and the domain [t_p, t_n] has a length. */
static enum status check_axis_knots(const struct nurbs_axis *axis, enum nurbs_member member,
                                    struct nurbs_fault *fault) {
    const double *t = axis->knots;
    size_t p = (size_t)axis->degree, n = (size_t)axis->size;
    if (axis->knot_count != n + p + 1)
        return nurbs_fault_at(fault, member, 0, 0, "the number of knots must be size + degree + 1");
    for (size_t i = 0; i < axis->knot_count; i++) {
        if (!isfinite(t[i]))
            return nurbs_fault_at(fault, member, 1, i, "a knot must be a finite number");
        if (i > 0 && t[i] < t[i - 1])
            return nurbs_fault_at(fault, member, 1, i,
                                  "a knot must not be less than the one before it");
    }
    if (!(t[n] > t[p]) || !isfinite(t[n] - t[p]))
        return nurbs_fault_at(fault, member, 0, 0,
                              "the domain between knot[degree] and knot[size] is empty");
    for (size_t i = p + 1; i + p < axis->knot_count; i++) {
        bool inside = t[i] > t[p] && t[i] < t[n];
        if (inside && t[i + p] == t[i])
            return nurbs_fault_at(
                fault, member, 1, i + p,
                "an interior knot must not be repeated more often than the degree");
    }
    return STATUS_OK;
}

enum status nurbs_validate(const struct nurbs *nurbs, struct nurbs_fault *fault) {
    const struct nurbs_axis *axis[2] = {&nurbs->u, &nurbs->v};
    for (int k = 0; k < 2; k++) {
        if (axis[k]->degree < 1 || axis[k]->degree > NURBS_DEGREE_MAX)
            return nurbs_fault_at(fault, k ? NURBS_DEGREE_V : NURBS_DEGREE_U, 0, 0,
                                  "the degree must be 1 to 9");
    }
    for (int k = 0; k < 2; k++) {
        enum nurbs_member member = k ? NURBS_SIZE_V : NURBS_SIZE_U;
        if (axis[k]->size <= axis[k]->degree)
            return nurbs_fault_at(fault, member, 0, 0,
                                  "the size must be at least the degree plus 1");
        if (axis[k]->size > NURBS_SIZE_MAX)
            return nurbs_fault_at(fault, member, 0, 0, "the size must be at most 512");
    }
    enum status status = check_axis_knots(&nurbs->u, NURBS_KNOTS_U, fault);
    if (status == STATUS_OK)
        status = check_axis_knots(&nurbs->v, NURBS_KNOTS_V, fault);
    if (status != STATUS_OK)
        return status;
    size_t count = (size_t)nurbs->u.size * (size_t)nurbs->v.size;
    if (nurbs->point_count != count)
        return nurbs_fault_at(fault, NURBS_POINTS, 0, 0,
                              "the number of control points must be size_u * size_v");
    for (size_t i = 0; i < count; i++) {
        struct vec3 p = nurbs->points[i];
        if (!isfinite(p.x) || !isfinite(p.y) || !isfinite(p.z))
            return nurbs_fault_at(fault, NURBS_POINTS, 1, i,
                                  "a control point must have finite numbers");
    }
    if (!nurbs->weights)
        return STATUS_OK;
    if (nurbs->weight_count != count)
        return nurbs_fault_at(fault, NURBS_WEIGHTS, 0, 0,
                              "the number of weights must be size_u * size_v");
    for (size_t i = 0; i < count; i++)
        if (!(nurbs->weights[i] > 0) || !isfinite(nurbs->weights[i]))
            return nurbs_fault_at(fault, NURBS_WEIGHTS, 1, i, "a weight must be greater than 0");
    return STATUS_OK;
}
