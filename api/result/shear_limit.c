/* SPDX-License-Identifier: MIT */
#include "shear_limit.h"

#include <math.h>

bool shear_limit_given(const struct api_fabric *fabric) {
    return fabric->locking_angle_deg[0] >= 0;
}

bool shear_limit_is_even(const struct api_fabric *fabric) {
    return fabric->locking_angle_deg[0] == fabric->locking_angle_deg[1];
}

bool shear_limit_locks(const struct api_fabric *fabric, double shear_deg) {
    return shear_limit_given(fabric) && fabs(shear_deg) > fabric->locking_angle_deg[shear_deg < 0];
}

double shear_limit_severity(const struct api_fabric *fabric, double shear_deg) {
    const struct api_limit_curve *curve = &fabric->limit;
    const double *at = curve->shear_deg, *severity = curve->severity;
    double shear = at[0] < 0 ? shear_deg : fabs(shear_deg);
    size_t k = 0;
    while (k < curve->rows && at[k] < shear)
        k++;
    if (k == 0 || k == curve->rows)
        return severity[k == 0 ? 0 : k - 1];
    double share = (shear - at[k - 1]) / (at[k] - at[k - 1]);
    return severity[k - 1] + share * (severity[k] - severity[k - 1]);
}
