/* SPDX-License-Identifier: MIT */
#include "score.h"

#include <math.h>

double study_range(const struct api_study *study, enum quantity_id id, double value) {
    switch (id) {
    case QUANTITY_LOCKED_AREA:
    case QUANTITY_SEVERITY_AREA:
    case QUANTITY_UNCOVERED_AREA:
    case QUANTITY_WASTE_AREA:
        return study->part.area;
    case QUANTITY_CUT_LENGTH:
    case QUANTITY_GAP_WIDTH:
        return sqrt(study->part.area);
    case QUANTITY_FRACTION_RANGE:
    case QUANTITY_K1_RATIO:
        return fmax(fabs(value), 1);
    default: /* these begin at 0 */
        return quantities[id].most;
    }
}

double study_limit_violation(const struct api_study *study, const struct study_row *row,
                             enum quantity_id id) {
    const struct study_limit *limit = &study->request.limit[id];
    double value = row->quantity[id], most = 0;
    if (limit->has_min)
        most = fmax(most, (limit->min - value) / study_range(study, id, limit->min));
    if (limit->has_max)
        most = fmax(most, (value - limit->max) / study_range(study, id, limit->max));
    return most;
}

double study_violation(const struct api_study *study, const struct study_row *row) {
    double most = 0;
    if (row->failure != FAILURE_NONE)
        return HUGE_VAL;
    for (int k = 0; k < QUANTITY_COUNT; k++)
        most = fmax(most, study_limit_violation(study, row, (enum quantity_id)k));
    return most;
}
