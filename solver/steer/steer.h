/* SPDX-License-Identifier: MIT */
/*
 * Generators that cost the least (docs/mathematics.md, `Generators that cost the least`): of the
 * curvature values of the generators that are to be sought those whose drape has the least energy,
 * by Levenberg and Marquardt's method from the values given, which are 0 for
 * geodesics. Each step takes the slope of the net
 * (`slope.h`) and goes where the energy of a drape, up to its rim, is less.
 */
#ifndef SOLVER_STEER_STEER_H
#define SOLVER_STEER_STEER_H

#include "solver/arena.h"
#include "solver/result.h"
#include "solver/settings.h"
#include "solver/status.h"
#include <stdbool.h>

/* Lays a drape of the same part with these settings, whose generators are known. */
struct steer_lay {
    enum status (*lay)(const void *context, const struct drape_settings *settings,
                       const struct drape_monitor *monitor, struct arena *arena,
                       struct drape_result *result);
    const void *context;
};

/* Whether a generator is to be sought, or its values stand on sides that are to be measured. */
bool steer_seeks(const struct drape_settings *settings);

/* Seeks them and lays the drape, or that with geodesics in their place, which then costs less: the
 * result says so. A net of more than a few thousand nodes is sought on a coarser one. Errors: those
 * of `lay`. */
enum status steer_solve(const struct steer_lay *lay, const struct drape_settings *settings,
                        const struct drape_monitor *monitor, struct arena *arena,
                        struct drape_result *result) STATUS_MUST_USE;

#endif
