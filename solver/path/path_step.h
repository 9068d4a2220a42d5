/* SPDX-License-Identifier: MIT */
/*
 * A step of a path within its span: the slope of its state (u, v, p, q), one step of order 8 with
 * an estimate of its error, and what has to be known to plan the next. For the files of this
 * folder.
 */
#ifndef SOLVER_PATH_PATH_STEP_H
#define SOLVER_PATH_PATH_STEP_H

#include "dormand.h"
#include "path.h"

enum { PATH_ROUNDS = 12 }; /* of Newton's method on the length to an edge or a joint */

/* A step that only corrects the end of another is this short against it at the most: then the
 * classical rule of fourth order is as exact. */
static const double path_nudge_share = 4e-3;

/* Where a step begins: the jet, the state and its slope. */
struct path_footing {
    struct surface_jet jet;
    vec4 state[2];
};

struct path_footing path_footing_of(const struct path *g);

/* The jet at uv, by the polynomials of the path's span. */
void path_jet(const struct path *g, const double uv[2], struct surface_jet *jet);

/* The parameters inside the domain that are nearest to those of the path; whether it is beyond an
 * open boundary. */
bool path_clamp(const struct path *g, double uv[2]);

/* The point where it is, and the unit tangent. */
struct vec3 path_point(const struct path *g, struct vec3 *tangent);

/* Puts the path at uv, in the span there, heading along the projection of `direction`. False when
 * that is normal to the surface. */
bool path_put(struct path *g, const double uv[2], struct vec3 direction);

/* The same at a place of any face of its shell. */
bool path_enter(struct path *g, const struct surface_place *place, struct vec3 direction);

/* Moves the path to the state y of its span. */
void path_accept(struct path *g, const vec4 *y);

/* The velocity whose tangent is the projection of `t`, scaled to unit speed. */
bool path_head_for(const struct surface_jet *jet, struct vec3 t, double velocity[2]);

/* The velocity of a path that is given by its direction at each point: a line of the chart, or the
 * section by a plane, along which plane . r stays what it is: (plane . r_v, -plane . r_u). */
void path_given_velocity(const struct path *g, const double uv[2], const struct surface_jet *jet,
                         double velocity[2]);

/* A path that is given by its direction has no other velocity at y than that. */
void path_redirect(const struct path *g, vec4 *y);

/* The slope of a state `s` further on, a dormand_slope whose context is the path: the equations at
 * the top of path.h. */
void path_slope(const void *context, double s, const vec4 *y, vec4 *slope);

/* Held to no more than this, steps are as long as the surface lets them be: of order 5 they are
 * nearly as long as of order 8, and take half the evaluations. */
static const double path_rough_accuracy = 5e-4;

static inline bool path_is_rough(const struct path *g) {
    return g->accuracy > path_rough_accuracy;
}

/* One step of h, however long, and its error as below. */
double path_try_step(const struct path *g, const struct path_footing *at, double h, vec4 *out);

/* The error of a step of h by what is allowed: the step will do when that is less than 1; NaN where
 * there is no telling. */
double path_error_of_step(const struct path *g, const struct path_footing *at, double h,
                          const struct dormand_error *error);

static inline bool path_followed(double error) {
    return error < 1;
}

/* What to multiply a step with this error by: the error goes with the eighth power. */
static inline double path_rescaling(double error) {
    double factor = error < 1e16 ? 0.92 / sqrt(sqrt(sqrt(fmax(error, 1e-8)))) : 0;
    return fmin(fmax(factor, 0.1), 4);
}

double path_allowed_error(const struct path *g, const struct path_footing *at, double h);

/* Carries the Jacobi field of a geodesic along its step of h > 0: exactly where the curvature does
 * not change, and over joints as over none. */
void path_carry_field(const struct path *from, double h, struct path *to);

/* The first step worth trying. */
double path_first_pace(const struct path *g, const struct path_footing *at);

/* The state after a step of h, of either sign, by a parabola in parameters. False where that will
 * not do: the step is not next to nothing by the accuracy of a geodesic's velocity. */
bool path_parabola(const struct path *g, const struct path_footing *at, double h, vec4 *y);

/* Moves the state y, which is `s` further on than the path, by a step so short, of either sign,
 * that the classical Runge-Kutta rule will do. */
void path_short_step(const struct path *g, double s, double h, vec4 *y);

#endif
