/* SPDX-License-Identifier: MIT */
#include "energy.h"

#include "solver/angle.h"
#include "solver/power.h"

static const double radian = ANGLE_PI / 180;

/* Shear, rad, below which cloth counts as hardly sheared: secants there are those of this angle. */
static const double hardly_sheared = 1e-3;

/* Smoothness that is asked of yarns without a bending stiffness, by the area. */
static const double smoothness = 1e-6;

/* W, its derivative, the force, and the slope of that, at g >= 0: by pieces of the curve, in which
 * the force is straight; from (0, 0), and on past the last as in that. */
static struct steer_density work_at(const struct drape_energy *energy, double g) {
    struct steer_density w = {g * g, 2 * g, 2};
    double from = 0, force = 0, work = 0;
    for (size_t k = 0; k < energy->shear_count; k++) {
        double to = radian * energy->shear_curve[k][0], end = energy->shear_curve[k][1];
        if (to > from) {
            double slope = (end - force) / (to - from), way = g - from;
            w = (struct steer_density){work + way * (force + slope * way / 2), force + slope * way,
                                       slope};
            if (g <= to)
                return w;
        }
        work += (to - from) * (force + end) / 2;
        from = to;
        force = end;
    }
    return w;
}

struct steer_density steer_density_at(const struct drape_energy *energy, double shear_rad) {
    double g = fabs(shear_rad), half = energy->norm > 0 ? energy->norm / 2 : 1;
    struct steer_density w = work_at(energy, g);
    if (half != 1) { /* (W^q)' = q W^(q-1) W', (W^q)'' = q W^(q-1) (W'' + (q - 1) W'^2 / W) */
        double work = fmax(w.value, 1e-300), power = half * power_exp((half - 1) * power_log(work));
        double bend = power * (w.stiffness + (half - 1) * w.slope * w.slope / work);
        w = (struct steer_density){power / half * work, power * w.slope, bend};
    }
    w.stiffness = fmax(w.stiffness, w.slope / fmax(g, hardly_sheared));
    w.slope = shear_rad < 0 ? -w.slope : w.slope;
    return w;
}

void steer_densities(const struct drape_energy *energy, double density[DRAPE_SHEAR_BINS]) {
    for (int b = 0; b < DRAPE_SHEAR_BINS; b++)
        density[b] = steer_density_at(energy, radian * DRAPE_SHEAR_BIN * (b + 0.5)).value;
}

double steer_energy_of(const double density[DRAPE_SHEAR_BINS],
                       const struct drape_statistics *statistics, double bare) {
    double sum = fmax(bare, 0) * density[DRAPE_SHEAR_BINS - 1];
    for (int b = 0; b < DRAPE_SHEAR_BINS; b++)
        sum += density[b] * statistics->area[b];
    return sum;
}

double steer_bending(const struct drape_energy *energy, double part_area) {
    if (energy->bending > 0)
        return energy->bending;
    return smoothness * part_area * steer_density_at(energy, 0.1).stiffness / 2;
}
