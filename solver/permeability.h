/* SPDX-License-Identifier: MIT */
/*
 * From the shear angle gamma of a fabric to its permeability, the tensor K of Darcy's law, in m^2.
 *
 * Everything is expressed in the frame of the warp: e1 = warp, e2 = n x warp with the normal
 * n = warp x weft / |warp x weft|, so that in the tangent plane
 *
 *   warp = (1, 0),   weft = (sin gamma, cos gamma).
 *
 * The sign of gamma mirrors the tensor at the warp and does nothing else. A model whose formula has
 * no meaning beyond its densest packing (there is no room for a flow) gives 0 there; that a cell is
 * so dense the caller reports, see `permeability_packing_limit`.
 *
 * Angles in degrees; shear angles within -90..90. At 90 degrees the yarns are parallel and the
 * areal weight is infinite: the cosine is taken as at least PERMEABILITY_LEAST_COSINE, so that
 * every result is finite.
 *
 * Sources: B. R. Gebart, Permeability of unidirectional reinforcements for RTM, J. Composite
 * Materials 26 (1992) 1100-1133 (Gebart). F. N. Fritsch and J. Butland, A method for constructing
 * local monotone piecewise cubic interpolants, SIAM J. Sci. Stat. Comput. 5 (1984) 300-304
 * (Fritsch and Butland).
 */
#ifndef SOLVER_PERMEABILITY_H
#define SOLVER_PERMEABILITY_H

#include "vec.h"
#include <stdbool.h>
#include <stddef.h>

/* The cosine of the double nearest to 90 degrees in radians. */
#define PERMEABILITY_LEAST_COSINE 6.123233995736766e-17

/* k1 >= k2 >= 0 in the tangent plane, k3 through it; the direction of k1 is along * warp +
 * across * e2, a unit vector with along >= 0. Where k1 = k2 it is one of many. */
struct permeability {
    double k1, k2, k3;
    double along, across;
};

/*
 * Of a fabric whose weft slides along warp (`fishnet/slide.h`), `slide` = c in 0..1, only a part of
 * the shear deforms what there is between fibres: sliding along each other parallel fibres stay as
 * they are. Without the slide c tan gamma the weft is p ((1 - c) sin gamma, cos gamma), p = (cos
 * gamma)^-c, and the shear gamma' with tan gamma' = (1 - c) tan gamma is left: that of the models
 * below, in the frame of the warp. c = 0 is a weave.
 */

/* A / A0 = (cos gamma)^(c - 1): a sheared cell keeps its fibres on less area (mass conservation),
 * with c = 1 on the same. */
double permeability_areal_ratio(double shear_deg, double slide);

/* How parallel fibres lie in a cross-section. */
enum permeability_packing { PERMEABILITY_QUADRATIC, PERMEABILITY_HEXAGONAL };

/* The fibre volume fraction at which parallel round fibres touch: pi/4, or pi/(2 sqrt 3). */
double permeability_packing_limit(enum permeability_packing packing);

/* The tensor xx, xy; xy, yy of the tangent plane in the frame of the warp, positive semidefinite,
 * by its principal values and the direction of the first. */
struct permeability permeability_principal(double xx, double xy, double yy, double k3);

/* The direction of k1 in space, a unit vector: warp and weft are unit vectors; where they are
 * parallel e2 is any vector at right angles to warp. */
struct vec3 permeability_direction(const struct permeability *k, struct vec3 warp,
                                   struct vec3 weft);

/* e2 of the frame above. */
struct vec3 permeability_across(struct vec3 warp, struct vec3 weft);

/* ---- Kozeny-Carman, from measured values ---- */

/* g(Vf) = [(1 - Vf)^3 / Vf^2] / [(1 - Vref)^3 / Vref^2], 0 from Vf = 1 on: how the permeability
 * follows the fibre volume fraction (Kozeny and Carman). Vf > 0, 0 < Vref < 1. */
double permeability_kozeny_carman_factor(double vf, double vref);

/* k1, k2, k3 measured along warp, weft and through the unsheared fabric at Vref; sheared by
 * gamma and at Vf: K = g F diag(k1, k2) F^T / det F with F = [warp weft], without the slide, the
 * affine push-forward of a flow that keeps its mass; k3 becomes g k3. */
struct permeability permeability_kozeny_carman(const double k[3], double vref, double vf,
                                               double shear_deg, double slide);

/* ---- Gebart, from the radius of the fibres ---- */

/* K_par = (8 r^2 / c) (1 - Vf)^3 / Vf^2, c = 57 quadratic, 53 hexagonal: along parallel fibres
 * (Gebart). `radius` in m. */
double permeability_gebart_along(double radius, enum permeability_packing packing, double vf);

/* K_perp = C1 r^2 (sqrt(Vmax / Vf) - 1)^(5/2), C1 = 16 / (9 pi sqrt 2) quadratic,
 * 16 / (9 pi sqrt 6) hexagonal; 0 from Vmax on: across them (Gebart). */
double permeability_gebart_across(double radius, enum permeability_packing packing, double vf);

/* Both families of yarns superposed, K = sum over t = warp, weft of [K_par t t^T + K_perp (I -
 * t t^T)] by the share of their fibres, (1 + c) / 2 and (1 - c) / 2; k3 = K_perp. That of a weave
 * has its axes along the bisectors of the yarns, that of parallel fibres along the fibre. */
struct permeability permeability_gebart(double radius, enum permeability_packing packing, double vf,
                                        double shear_deg, double slide);

/* ---- a table, from measured values at several shear angles ---- */

/* Columns of `rows` >= 1 values over |gamma|, which increases. `angle_deg` is that of k1 from the
 * bisector of the acute angle between warp and weft yarns, positive away from warp; NULL: all 0. */
struct permeability_table {
    size_t rows;
    const double *shear_deg, *k1, *k2, *k3, *angle_deg;
};

/* Piecewise cubic interpolation that keeps the data's monotony, so that it does not overshoot
 * (Fritsch and Butland; at the ends the three-point formula, limited). Outside the data: the value
 * at the end. */
double permeability_interpolate(const double *x, const double *y, size_t count, double at);

/* The shear gamma' in degrees that a slide leaves of gamma: a table is of that. */
double permeability_unslid_deg(double shear_deg, double slide);

/* `outside` (may be NULL): whether |gamma| lies outside the table. Where the interpolated k2 is the
 * larger one the two change places. Without shear the yarns have two bisectors: that of warp and
 * weft counts. */
struct permeability permeability_of_table(const struct permeability_table *table, double shear_deg,
                                          bool *outside);

/* ---- a table over shear and fibre volume fraction ---- */

/* Rows over |gamma|, which increases, each of `columns` >= 2 values over Vf, which increases within
 * 0..1: the value of row i and column j is [i * columns + j]. `angle_deg` as above; NULL: all 0. */
struct permeability_grid {
    size_t rows, columns;
    const double *shear_deg, *fiber_volume_fraction, *k1, *k2, *k3, *angle_deg;
};

/*
 * log k is linear in Vf within a row, and between rows linear in |gamma|: such a mean keeps an
 * order that all rows have, which a cubic does not. Beyond the fractions of the table the value at
 * its end is scaled by Kozeny and Carman, beyond its shear angles it is that at the end; both are
 * `outside` (may be NULL). Angles are linear likewise and kept beyond the table.
 *
 * Where every row passes `permeability_falls`, k / (1 - Vf) falls with Vf everywhere, so that a
 * denser cloth fills more slowly.
 */
struct permeability permeability_of_grid(const struct permeability_grid *grid, double vf,
                                         double shear_deg, bool *outside);

/* Whether k falls from one fraction to the next by enough: log k linear between them falls faster
 * than log(1 - Vf), d log(1 - Vf) / d Vf = -1 / (1 - Vf), which is steepest at the denser end. */
bool permeability_falls(double k, double vf, double next_k, double next_vf);

#endif
