/* SPDX-License-Identifier: MIT */
/*
 * Surfaces whose nets are known, as exact NURBS, and a plain evaluator for them.
 *
 * A `struct shape` holds its own arrays, in homogeneous coordinates (w x, w y, w z, w); it can be
 * moved, split by knot insertion, transposed, and handed to the solver as a `struct nurbs`.
 * `shape_evaluate` is the textbook sum over Cox-de Boor basis functions with the quotient rule:
 * slow, short, and independent of the solver's evaluator.
 */
#ifndef DRAPE_TESTS_SHAPES_H
#define DRAPE_TESTS_SHAPES_H

#include "solver/surface/nurbs.h"
#include "solver/surface/surface.h"
#include <stdint.h>

enum {
    SHAPE_SIZE_MAX = 48, /* control points along one direction */
    SHAPE_KNOTS_MAX = SHAPE_SIZE_MAX + NURBS_DEGREE_MAX + 1
};

struct shape {
    int degree[2], size[2];
    double knots[2][SHAPE_KNOTS_MAX];
    double h[SHAPE_SIZE_MAX * SHAPE_SIZE_MAX][4]; /* v runs fastest */
    struct vec3 points[SHAPE_SIZE_MAX * SHAPE_SIZE_MAX];
    double weights[SHAPE_SIZE_MAX * SHAPE_SIZE_MAX];
};

/* x -> m x + shift */
struct motion {
    double m[3][3];
    struct vec3 shift;
};

struct motion motion_identity(void);
/* Scale, then turn by `angle` radians about `axis`, then shift. */
struct motion motion_similar(double scale, struct vec3 axis, double angle, struct vec3 shift);
struct motion motion_stretch(double x, double y, double z);
struct vec3 motion_vector(const struct motion *motion, struct vec3 a);
struct vec3 motion_point(const struct motion *motion, struct vec3 a);

/* The rectangle [x0,x1] x [y0,y1] of the plane z = 0; (u, v) = (x, y), degree 1. */
void shape_plane(struct shape *shape, const double x[2], const double y[2]);

/* z = (a x^2 + b y^2) / 2 over the rectangle, biquadratic, (u, v) = (x, y). */
void shape_quadric(struct shape *shape, double a, double b, const double x[2], const double y[2]);

/* A patch of the sphere about 0, free of poles, by stereographic projection from (0, 0, -radius):
 *   r = radius (2 u, 2 v, 1 - u^2 - v^2) / (1 + u^2 + v^2),
 * rational biquadratic. Weights are positive while no corner has |u|, |v| > 0.7. */
void shape_stereographic(struct shape *shape, double radius, const double u[2], const double v[2]);

/* Surfaces of revolution about the z axis: u turns from longitude `turn[0]` to `turn[1]` (radians),
 * v follows the profile, both over [0, 1]. Arcs are cut into equal spans of at most `widest`
 * radians; usual is pi / 2. Where spans meet, the surface is smooth but its parameters are not:
 * r_uu jumps. One span of more than pi has a negative weight, which is no business of the solver's,
 * but gives the references an analytic chart. */
void shape_sphere(struct shape *shape, double radius, const double turn[2],
                  const double latitude[2], double widest);
void shape_torus(struct shape *shape, double major, double minor, const double turn[2],
                 const double tube[2], double widest);
/* The straight profile from (rho, z) = a to b: cylinder, cone, annulus. */
void shape_frustum(struct shape *shape, const double turn[2], const double a[2], const double b[2],
                   double widest);

/* Two planes that meet at x = 0 and rise by `rise` radians on the right side: degree 2 in u with an
 * interior knot of multiplicity 2 at u = 1/2; x and y run over [-1, 1] times `half`. */
void shape_crease(struct shape *shape, double half, double rise);

/* A disk about 0 in the plane z = 0 as one biquadratic patch, whose edges are its quarters: at its
 * four corners r_u and r_v are parallel. */
void shape_disk(struct shape *shape, double radius);

/* A wavy rational bicubic surface about [-1, 1]^2 with uneven interior knots (C2), in the manner
 * of figure 12 of the paper (docs/mathematics.md, sources). */
void shape_freeform(struct shape *shape);
/* One rational bicubic Bezier patch about [-1, 1]^2, split at uneven knots: analytic. */
void shape_bezier(struct shape *shape);

/* Random regular surface about [-1, 1]^2: degree 2..9, weights 0.2..5, uneven simple knots. */
void shape_random(struct shape *shape, uint64_t *seed);
/* Uniform in [0, 1) (splitmix64), and between `low` and `high`. */
double random_unit(uint64_t *seed);
double random_between(uint64_t *seed, double low, double high);

void shape_move(struct shape *shape, const struct motion *motion);
/* Inserts `knot` once in direction k (Boehm). The surface stays as it is. */
void shape_insert_knot(struct shape *shape, int k, double knot);
/* Cuts down to [u[0], u[1]] x [v[0], v[1]] of the domain; parameters stay as they are. */
void shape_cut(struct shape *shape, const double u[2], const double v[2]);
/* r(u, v) becomes r(v, u). */
void shape_transpose(struct shape *shape);

void shape_domain(const struct shape *shape, double lower[2], double upper[2]);
void shape_evaluate(const struct shape *shape, double u, double v, struct surface_jet *jet);
/* The last knot interval of direction k that starts at or before x, inside the domain. */
int shape_span(const struct shape *shape, int k, double x);
/* The same by the polynomials of the given intervals, wherever (u, v) is. */
void shape_evaluate_in(const struct shape *shape, const int span[2], double u, double v,
                       struct surface_jet *jet);
struct vec3 shape_point(const struct shape *shape, const double uv[2]);
/* Area, and length of the four edges of the domain, by sums over a grid: to about 1e-3. */
double shape_area(const struct shape *shape);
double shape_perimeter(const struct shape *shape);
/* A view of the shape, good while it lives and is not changed. */
struct nurbs shape_nurbs(struct shape *shape);

/* Unit warp and weft at uv: the u-tangent turned by `angle_deg` about r_u x r_v, and 90 degrees
 * less `pre_shear_deg` further. */
void shape_frame(const struct shape *shape, const double uv[2], double angle_deg,
                 double pre_shear_deg, struct vec3 *warp, struct vec3 *weft);

/* Curvature of the surface at a jet: second fundamental form for tangent vectors a and b of space,
 * with respect to the unit normal along r_u x r_v, and the Gaussian curvature. */
double jet_second_form(const struct surface_jet *jet, struct vec3 a, struct vec3 b);
double jet_gauss(const struct surface_jet *jet);
struct vec3 jet_normal(const struct surface_jet *jet);
/* (du, dv) of the tangent part of `a`. */
void jet_pull_back(const struct surface_jet *jet, struct vec3 a, double duv[2]);

#endif
