/* SPDX-License-Identifier: MIT */
/*
 * What it costs to shear cloth: with g the shear angle and W(g) the work of shearing a unit of
 * area, which is g^2 or, of a fabric whose shear curve is known, the integral of its force from 0
 * to |g|, the energy of a drape is the integral of W^(p/2) over the cloth. Norm p = 2 is the work
 * itself; the greater p, the more the greatest shear counts. What should lie under cloth and
 * does not costs as if it were sheared by 90 degrees.
 */
#ifndef SOLVER_STEER_ENERGY_H
#define SOLVER_STEER_ENERGY_H

#include "solver/result.h"
#include "solver/settings.h"

/* The density at a shear angle of either sign, its derivative, and how stiff it is there: the
 * second derivative, or the secant where that is more, so that it is never 0. */
struct steer_density {
    double value, slope, stiffness;
};

struct steer_density steer_density_at(const struct drape_energy *energy, double shear_rad);

/* That of the middle of each of the bins of `drape_statistics`. */
void steer_densities(const struct drape_energy *energy, double density[DRAPE_SHEAR_BINS]);

/* The energy of a drape by its statistics, and by the area that is bare and should not be. */
double steer_energy_of(const double density[DRAPE_SHEAR_BINS],
                       const struct drape_statistics *statistics, double bare);

/* What bending costs by the square of a yarn's curvature and the area: the fabric's own, or so
 * little that yarns are smooth, a millionth of the area by the density's stiffness at small shear.
 */
double steer_bending(const struct drape_energy *energy, double part_area);

#endif
