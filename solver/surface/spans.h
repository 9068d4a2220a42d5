/* SPDX-License-Identifier: MIT */
/*
 * Inside of a surface: the Bezier spans. Only the files of the solver that make, evaluate or walk
 * on surfaces include it.
 *
 * Inside, each direction has a parameter of its own, so that neither knots far from 0 nor a
 * projective parametrisation costs digits or moves what is beyond the boundary: with x the caller's
 * parameter less the domain's lower end, L its length and c the projective factor,
 *
 *     s = c L x / (L + (c - 1) x),   0 <= s <= L,
 *
 * for which the weights at the four corners balance: w00 w01 = w10 w11 and w00 w10 = w01 w11.
 * Domains that hold 0 and are balanced keep the caller's. Only what `surface.h` declares is in the
 * caller's.
 */
#ifndef SOLVER_SURFACE_SPANS_H
#define SOLVER_SURFACE_SPANS_H

#include "solver/relocation.h"
#include "surface.h"
#include <stdint.h>

/* Borders closer than this share of the surface's size are one line, or one point; less area than
 * its square by that of the size is none. */
#define SURFACE_COINCIDENCE 1e-9

/* Homogeneous coordinates (w x, w y, w z, w). */
typedef double vec4 __attribute__((vector_size(32)));

/* Up to this degree powers lose less than a decimal digit. */
enum { SURFACE_POWERS_DEGREE = 3 };

/* X(p, q) for each pair of degrees up to it: as cases of their own their loops unroll. */
#define SURFACE_LOW_DEGREES(X)                                                                     \
    X(1, 1) X(1, 2) X(1, 3) X(2, 1) X(2, 2) X(2, 3) X(3, 1) X(3, 2) X(3, 3)

/* X(p) for each degree, likewise. */
#define SURFACE_DEGREES(X) X(1) X(2) X(3) X(4) X(5) X(6) X(7) X(8) X(9)
_Static_assert(NURBS_DEGREE_MAX == 9, "every degree has a case");

/* One parametric direction: the domain cut at its distinct knots. */
struct surface_axis {
    int degree;
    int span_count;
    double *breaks;  /* span_count + 1 increasing parameters */
    double *rates;   /* 1 / length of each span */
    double *middles; /* of each span */
    bool *joints;    /* of each of the breaks, whether curvature may jump there */
    bool *corners;   /* of each of the breaks, whether the tangent across it may */
    double origin;   /* the caller's parameter of inner parameter 0, and of both ends */
    double outer[2];
    double factor; /* c above; 1: none */
    bool closed;
    bool pole[2]; /* at the lower and upper end: the other direction's tangent vanishes there */
    struct vec3 pole_point[2]; /* that end's first point; with `pole`, all of it */
    bool pinched[2];           /* of a moved surface: that end of the surface before is a pole */
};

struct surface {
    struct surface_axis axis[2];
    size_t points_per_span; /* (p + 1) (q + 1) */
    vec4 *points;           /* [span_u][span_v][k][l]: Bezier control points */
    vec4 *powers;    /* alike: coefficients of (u - middle)^k (v - middle)^l; NULL where the degree
                        makes them inaccurate */
    bool *in_powers; /* of each span, with powers: whether its weights leave them accurate */
    struct vec3 lower, upper;
    double size;      /* diagonal of the box around the control points */
    double magnitude; /* the largest absolute coordinate of that box: what rounding scales with */
    double area;
    struct vec3 centroid;
    double gyration2;
    double least_tangent2[2]; /* tangents whose square is less have vanished */
    bool has_poles;
    bool has_folds;            /* a knot line over which the tangent plane may turn */
    const struct shell *shell; /* that it is a face of, and which; NULL: of none */
    int32_t face;
    double side;   /* 1; -1 where normals are against r_u x r_v */
    double height; /* by which it is moved along r_u x r_v (`offset.h`): points and powers are those
                      of the surface before, all else is its own; 0: it is not */
};

/* A walk of `solver/relocation.h` from the pointer to a surface on; and from one that is part of
 * another structure. */
void surface_relocate(struct relocation *relocation, void *field);
void surface_relocate_inside(struct relocation *relocation, struct surface *surface);

static inline double surface_axis_lower(const struct surface_axis *axis) {
    return axis->breaks[0];
}

static inline double surface_axis_upper(const struct surface_axis *axis) {
    return axis->breaks[axis->span_count];
}

/* The length of the domain in the inner parameter. */
static inline double surface_axis_length(const struct surface_axis *axis) {
    return surface_axis_upper(axis) - surface_axis_lower(axis);
}

/* Parameter x of `axis` brought into the domain when the direction is closed. */
double surface_axis_wrap(const struct surface_axis *axis, double x);

/* Between the caller's parameter x and the inner one; beyond the domain too, as far as that goes.
 */
double surface_axis_inner(const struct surface_axis *axis, double x);
double surface_axis_outer(const struct surface_axis *axis, double inner);

/* The latter strictly between the ends: never beyond the upper one by rounding. */
static inline double surface_axis_outer_between(const struct surface_axis *axis, double inner) {
    double length = surface_axis_length(axis), c = axis->factor;
    double outer = c == 1 ? inner + axis->origin
                          : axis->outer[0] + length * inner / (c * length - (c - 1) * inner);
    return outer < axis->outer[1] ? outer : axis->outer[1];
}

/* The derivative of the inner parameter by the caller's, at the inner one; and, where `second` is
 * not NULL, the second. */
double surface_axis_rate(const struct surface_axis *axis, double inner, double *second);

/* Both directions' parameters. */
void surface_inner(const struct surface *surface, const double outer[2], double inner[2]);
static inline void surface_outer(const struct surface *surface, const double inner[2],
                                 double outer[2]) {
    for (int k = 0; k < 2; k++) {
        const struct surface_axis *axis = &surface->axis[k];
        bool same = axis->factor == 1 && axis->origin == 0;
        outer[k] = same ? inner[k] : surface_axis_outer(axis, inner[k]);
    }
}

/* The span that x lies in; the first or last beyond the ends. `hint` is tried first; it may be one
 * of another surface. */
int surface_axis_span(const struct surface_axis *axis, int hint, double x);

/* The breaks between the ends of a way along an axis, in order: walk with `surface_walk_next`,
 * which is false when there are no more. A way of a period or more has none. */
struct surface_walk {
    const struct surface_axis *axis;
    double from, way, turn; /* what to take off parameters to be in the domain */
    int next;
    int number; /* of the break at hand, its parameter, and the share of the way to it */
    double at, share;
};
struct surface_walk surface_walk_begin(const struct surface_axis *axis, double from, double to);
bool surface_walk_next(struct surface_walk *walk);

/* `surface_evaluate` in inner parameters. */
void surface_jet_at(const struct surface *surface, struct surface_cursor *cursor, double u,
                    double v, struct surface_jet *jet);

/* `surface_nearest` in inner parameters. */
void surface_nearest_at(const struct surface *surface, struct vec3 point, double uv[2],
                        double *distance);

/* The point inside the domain to which a descent of the distance to `point` leads from `uv`, which
 * becomes that point, in inner parameters; and that distance. */
double surface_nearest_from(const struct surface *surface, struct vec3 point, double uv[2]);

/* Of surfaces being made: sets the box and what follows from it; then, with the edges known, what
 * has vanished, area and centroid. STATUS_DEGENERATE_SURFACE when there is no area. */
void surface_set_bounds(struct surface *surface, struct vec3 lower, struct vec3 upper);
enum status surface_finish(struct surface *surface) STATUS_MUST_USE;

/* Sets area, centroid and radius of gyration, to some 1e-6. STATUS_DEGENERATE_SURFACE when there is
 * no area. */
enum status surface_integrate(struct surface *surface) STATUS_MUST_USE;

static inline struct vec3 surface_box_middle(const struct surface *surface) {
    return vec3_scale(0.5, vec3_add(surface->lower, surface->upper));
}

/* `surface_evaluate_span` of a surface that is moved; up to this share of a span from what was a
 * pole, in a way that loses no digits there. */
#define SURFACE_PINCH (1.0 / 64)
void surface_evaluate_moved(const struct surface *surface, int span_u, int span_v, double u,
                            double v, struct surface_jet *jet);

/* Evaluates the polynomials of one span, anywhere, in inner parameters. */
void surface_evaluate_span(const struct surface *surface, int span_u, int span_v, double u,
                           double v, struct surface_jet *jet);

/* A point and its first derivatives. */
struct surface_element {
    struct vec3 r, u, v;
};

/* The elements at the points (at[0][a], at[1][b]) of a span, at [a * count[1] + b], with the bits
 * of `surface_evaluate_span`; at most QUADRATURE_MAX either way. Not of a surface that is moved. */
struct surface_grid {
    int span[2], count[2];
    const double *at[2];
};
void surface_evaluate_grid(const struct surface *surface, const struct surface_grid *grid,
                           struct surface_element *elements);

#endif
