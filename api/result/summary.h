/* SPDX-License-Identifier: MIT */
/*
 * The summary of a result. From this one list come its members, how they are stored, read back and
 * written in documents, and the table in docs/fields.md. A new member is one line here and where it
 * is computed.
 *
 * X(KIND, name, key, meaning): `key` is its name in JSON.
 */
#ifndef API_RESULT_SUMMARY_H
#define API_RESULT_SUMMARY_H

#include "solver/drape.h"
#include "verdict.h"
#include <stdbool.h>
#include <stddef.h>

/* clang-format off */
#define SUMMARY_LIST(X)                                                                            \
    X(OUTCOME, outcome, "outcome", "`complete`: `cloth_coverage` is at least 0.999; or `partial`")   \
    X(VERDICT, verdict, "verdict", "whether the part can be draped so: `drapable`, `obstacle`, `at`, `detail`") \
    X(COUNT, nodes, "nodes", "nodes of the net")                                                   \
    X(COUNT, cells, "cells", "cells of the net")                                                   \
    X(NUMBER, coverage, "coverage", "share of the surface's area that lies in cells, 0 to 1")      \
    X(NUMBER, cloth_coverage, "cloth_coverage", "the same with the cells that the rim cuts")       \
    X(NUMBER, part_area, "part_area", "area to be covered, in the square of the length unit")      \
    X(NUMBER, cloth_area, "cloth_area", "area of the cloth up to its rim")                         \
    X(NUMBER, flat_area, "flat_area", "the same before it was sheared: that of the pattern")       \
    X(NUMBER, max_shear_deg, "max_shear_deg", "greatest \\|γ\\| of the cloth up to its rim")       \
    X(POSITIVE, max_shear_error_deg, "max_shear_error_deg",                                        \
      "how far that may be from the greatest of the exact net; null where the method estimates none, or no yarn has six nodes") \
    X(PLACE, max_shear_at, "max_shear_at", "where it is: `p`, `q`, `x`, `y`, `z`")                 \
    X(AXES, start_axes, "start_axes", "unit vectors at the start: `zero`, the direction that angles are counted from, and `side`, the normal on `side` 1")                \
    X(POSITIVE, max_shear_pinned_deg, "max_shear_pinned_deg",                                      \
      "the same where no node of the cell is `grown`: it converges as the spacing gets smaller")   \
    X(POSITIVE, max_shear_grown_deg, "max_shear_grown_deg",                                        \
      "and where one is, which need not converge; null where there is no such cloth")              \
    X(POSITIVE, grown_area, "grown_area", "area of the cloth in cells with a `grown` node")        \
    X(NUMBER, mean_shear_deg, "mean_shear_deg", "mean \\|γ\\| of the cloth up to its rim, by area")\
    X(NUMBER, p95_shear_deg, "p95_shear_deg", "\\|γ\\| that 95 % of that area has less than")      \
    X(POSITIVE, locked_cells, "locked_cells", "cells beyond the locking angle; null without one")  \
    X(POSITIVE, severity_max, "severity_max", "greatest severity of the cells; null without a limit curve") \
    X(POSITIVE, packing_exceeded_cells, "packing_exceeded_cells",                                  \
      "cells with more fibres than can be packed; null without a fibre volume fraction")           \
    X(NUMBER, residual_max, "residual_max", "greatest \\|edge / promised length - 1\\|")           \
    X(NUMBER, newton_iterations_mean, "newton_iterations_mean", "steps for a node found by Newton")\
    X(POSITIVE, error_estimate_max, "error_estimate_max",                                          \
      "greatest `error_estimate`; null without one")                                               \
    X(POSITIVE, thickness_error_max, "thickness_error_max",                                        \
      "greatest error of the thickness by `shear_error_deg` of the nodes; null without these or a thickness") \
    X(POSITIVE, fiber_volume, "fiber_volume",                                                      \
      "of the fibres in the cloth; null without thickness and fibre volume fraction")              \
    X(POSITIVE, pore_volume, "pore_volume", "left for the resin; null without thickness and fibre volume fraction")              \
    X(STEERING, steering, "steering", "of generators of least energy; left out without them: `energy_before` with geodesics, `energy_after`, `fell`, `iterations`, and `generators` that give this drape") \
    X(REASONS, front_reasons, "front_reasons", "rows of the table front, counted by reason")                    \
    X(WARNINGS, warnings, "warnings", "warnings about the drape: `code`, `detail`, `pointer`")\
    X(TIMING, solve_ms, "timing_ms", "`solve`: time of the solver; `queue`: this job's wait")      \
    X(VERSION, solver_version, "solver_version", "version that solved it")
/* clang-format on */

enum { API_VERSION_SIZE = 32, SUMMARY_PLACE_SIZE = 5, SUMMARY_AXES_SIZE = 6 };

enum { API_WARNINGS_MAX = 12 };

struct api_warnings {
    size_t count;
    struct api_warning {
        char code[24], pointer[40]; /* the pointer may be "" */
        char detail[240];
    } list[API_WARNINGS_MAX];
};

enum summary_kind {
    SUMMARY_OUTCOME,
    SUMMARY_VERDICT,
    SUMMARY_COUNT,
    SUMMARY_NUMBER,
    SUMMARY_POSITIVE, /* null when negative: there is none */
    SUMMARY_PLACE,    /* p, q, x, y, z */
    SUMMARY_AXES,     /* two vectors */
    SUMMARY_STEERING, /* nothing where no generator was sought */
    SUMMARY_REASONS,
    SUMMARY_WARNINGS,
    SUMMARY_TIMING,
    SUMMARY_VERSION
};

#define SUMMARY_MEMBER_OUTCOME(name) enum drape_outcome name;
#define SUMMARY_MEMBER_VERDICT(name) struct api_verdict name;
#define SUMMARY_MEMBER_COUNT(name) size_t name;
#define SUMMARY_MEMBER_NUMBER(name) double name;
#define SUMMARY_MEMBER_POSITIVE(name) double name;
#define SUMMARY_MEMBER_PLACE(name) double name[SUMMARY_PLACE_SIZE];
#define SUMMARY_MEMBER_AXES(name) double name[SUMMARY_AXES_SIZE];
#define SUMMARY_MEMBER_STEERING(name) struct drape_steering name;
#define SUMMARY_MEMBER_REASONS(name) size_t name[DRAPE_REASON_COUNT];
#define SUMMARY_MEMBER_WARNINGS(name) struct api_warnings name;
#define SUMMARY_MEMBER_TIMING(name) double name;
#define SUMMARY_MEMBER_VERSION(name) char name[API_VERSION_SIZE];

struct api_summary {
#define SUMMARY_MEMBER(KIND, name, key, meaning) SUMMARY_MEMBER_##KIND(name)
    SUMMARY_LIST(SUMMARY_MEMBER)
#undef SUMMARY_MEMBER
};

struct api_text;
struct json_value;

/* As the contract names how a drape ended, by `enum drape_outcome`. */
extern const char *const outcome_names[2];

/* The list as data. */
struct summary_member {
    enum summary_kind kind;
    const char *key, *meaning;
    size_t offset; /* in struct api_summary */
};

extern const struct summary_member summary_members[];
extern const size_t summary_member_count;

/* Whether all that was computed is a finite number. */
bool summary_finite(const struct api_summary *summary);

/* The contract's object, with `queue_ms` of waiting, or without it when that is negative. */
void summary_write(struct api_text *text, const struct api_summary *summary, double queue_ms);

/* Reads it; what is wrong is reported to the place's problem. */
void summary_read(const struct json_value *json, struct api_summary *summary);

/* Members that other summaries share. */
void summary_write_warnings(struct api_text *text, const struct api_warnings *warnings);
void summary_read_warnings(const struct json_value *json, struct api_warnings *warnings);
void summary_write_timing(struct api_text *text, double solve_ms, double queue_ms);

/* Writes the text that `api_columns_summary_json` made of a result which several jobs may share,
 * with the `queue_ms` of one of them. Members that this version does not know stay. */
void api_summary_write_stored(struct api_text *text, const char *stored, double queue_ms);

#endif
