/* SPDX-License-Identifier: MIT */
/*
 * What the variants of a study are judged by: numbers of the cloth up to its rim, none of which
 * jumps when the start moves a little. What each means is said where it is a column of `variants`,
 * in `column_list.h`, whose order is this one's.
 *
 * X(id, name, role, least, most): objectives are to be small and may have limits, bounds may have
 * limits alone; `least` and `most` are the values that the quantity can have.
 */
#ifndef API_RESULT_QUANTITY_H
#define API_RESULT_QUANTITY_H

/* clang-format off */
#define QUANTITY_LIST(X)                                                                           \
    X(MAX_SHEAR, "max_shear_deg", OBJECTIVE, 0, 90)                                                \
    X(P95_SHEAR, "p95_shear_deg", OBJECTIVE, 0, 90)                                                \
    X(LOCKED_AREA, "locked_area", OBJECTIVE, 0, 1e24)                                              \
    X(SEVERITY_AREA, "severity_area", OBJECTIVE, 0, 1e24)                                          \
    X(UNCOVERED_AREA, "uncovered_area", OBJECTIVE, 0, 1e24)                                        \
    X(WASTE_AREA, "waste_area", OBJECTIVE, 0, 1e24)                                                \
    X(ANGLE_DEVIATION, "angle_deviation_deg", OBJECTIVE, 0, 90)                                    \
    X(FRACTION_RANGE, "fiber_volume_fraction_range", OBJECTIVE, 0, 1e30)                           \
    X(K1_RATIO, "k1_ratio_p95", OBJECTIVE, 1, 1e30)                                                \
    X(CUT_LENGTH, "cut_length", OBJECTIVE, 0, 1e12)                                                \
    X(ANGLE_DEVIATION_MAX, "angle_deviation_max_deg", OBJECTIVE, 0, 90)                            \
    X(GAP_WIDTH, "gap_width", OBJECTIVE, 0, 1e12)                                                  \
    X(CLOTH_COVERAGE, "cloth_coverage", BOUND, 0, 1)                                               \
    X(MEAN_SHEAR, "mean_shear_deg", BOUND, 0, 90)                                                  \
    X(LAID_COVERAGE, "laid_coverage", BOUND, 0, 1)
/* clang-format on */

enum quantity_role { QUANTITY_OBJECTIVE, QUANTITY_BOUND };

enum quantity_id {
#define QUANTITY_ID(id, name, role, least, most) QUANTITY_##id,
    QUANTITY_LIST(QUANTITY_ID)
#undef QUANTITY_ID
        QUANTITY_COUNT
};

struct quantity {
    const char *name;
    enum quantity_role role;
    double least, most;
};

extern const struct quantity quantities[QUANTITY_COUNT];

/* Why a variant has no numbers. X(id, name) */
#define FAILURE_LIST(X)                                                                            \
    X(NONE, "none")                                                                                \
    X(START_OFF_SURFACE, "start-off-surface")                                                      \
    X(START_STUCK, "start-stuck")                                                                  \
    X(DEGENERATE_SURFACE, "degenerate-surface")                                                    \
    X(DIRECTION, "direction-normal")                                                               \
    X(GENERATOR, "generator")                                                                      \
    X(TOO_MANY_NODES, "too-many-nodes")                                                            \
    X(OUT_OF_MEMORY, "out-of-memory")                                                              \
    X(NO_CLOTH, "no-cloth")                                                                        \
    X(CUT, "cut")                                                                                  \
    X(CRASHED, "solver-crashed")

enum failure {
#define FAILURE_ID(id, name) FAILURE_##id,
    FAILURE_LIST(FAILURE_ID)
#undef FAILURE_ID
        FAILURE_COUNT
};

extern const char *const failure_names[FAILURE_COUNT];

#endif
