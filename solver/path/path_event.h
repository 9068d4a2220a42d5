/* SPDX-License-Identifier: MIT */
/*
 * What a step of a path may run into on its face: a knot line at the end of its span, or a corner
 * of the polyline that it follows. For the files of this folder.
 */
#ifndef SOLVER_PATH_PATH_EVENT_H
#define SOLVER_PATH_PATH_EVENT_H

#include "path_step.h"

/* The parameter of direction k reaches `at`, a knot line or, with `corner`, the next point
 * of a polyline; from below with sign 1, from above with -1. */
struct path_event {
    int k;
    double at, sign;
    bool corner;
};

/* The event that a step from here to y runs into first, by the share of the step that lies beyond
 * it; false when there is none. */
bool path_first_event(const struct path *g, const vec4 *y, struct path_event *event);

/* The length to the knot line that the path meets first, to second order, and that line; infinite
 * where it meets none. */
double path_length_to_knot(const struct path *g, const struct path_footing *at,
                           struct path_event *event);

/* Moves to the event before the end of a step of h, and past it; next to a corner of the span to
 * that line which comes first. Less far when the step to there is too long to be followed. */
bool path_advance_to(struct path *g, const struct path_event *first, double h, const vec4 *end,
                     double *length);

/* From the `end` of a step that was to reach the knot line to that line, where it is near enough,
 * and past it. False, with nothing done, where it is not. */
bool path_touch_knot(struct path *g, const struct path_event *event, const vec4 *end,
                     double *length);

#endif
