/* SPDX-License-Identifier: MIT */
#include "permeability.h"

#include "angle.h"
#include "power.h"

/* sin and cos of a shear angle. */
static void shear_sincos(double shear_deg, double *sine, double *cosine) {
    angle_sincos_deg(shear_deg, sine, cosine);
    *cosine = *cosine > PERMEABILITY_LEAST_COSINE ? *cosine : PERMEABILITY_LEAST_COSINE;
}

/* (cos gamma)^(1 - c): what a cell has of its unsheared area; all of it with c = 1. */
static double area_share(double cosine, double slide) {
    return slide == 1 ? 1 : slide > 0 ? power_exp((1 - slide) * power_log(cosine)) : cosine;
}

double permeability_areal_ratio(double shear_deg, double slide) {
    double sine, cosine;
    shear_sincos(shear_deg, &sine, &cosine);
    return 1 / area_share(cosine, slide);
}

double permeability_unslid_deg(double shear_deg, double slide) {
    double sine, cosine;
    shear_sincos(shear_deg, &sine, &cosine);
    return slide > 0 ? angle_atan2_deg((1 - slide) * sine, cosine) : shear_deg;
}

double permeability_packing_limit(enum permeability_packing packing) {
    return packing == PERMEABILITY_QUADRATIC ? ANGLE_PI / 4 : ANGLE_PI / (2 * sqrt(3));
}

/* ---- tensors in the tangent plane ---- */

/* k1,2 = m +- r with m = (xx + yy) / 2, r = |((xx - yy) / 2, xy)|; k2 as det / k1, because the
 * difference would lose it beside a large k1. The axis of k1 is at half the angle of ((xx - yy) /
 * 2, xy), on the side of warp. */
static struct permeability principal(double xx, double xy, double yy, double det, double k3) {
    double mean = (xx + yy) / 2, half = (xx - yy) / 2, radius = sqrt(half * half + xy * xy);
    struct permeability k = {.k1 = mean + radius, .k3 = k3, .along = 1};
    double k2 = k.k1 > 0 ? det / k.k1 : 0;
    k.k2 = k2 < k.k1 ? k2 : k.k1;
    double c = half / radius, s = xy / radius;
    if (radius > 0 && c >= 0) {
        k.along = sqrt((1 + c) / 2);
        k.across = s / (2 * k.along);
    } else if (radius > 0) {
        double sine = sqrt((1 - c) / 2);
        k.along = fabs(s) / (2 * sine);
        k.across = s < 0 ? -sine : sine;
    }
    return k;
}

struct permeability permeability_principal(double xx, double xy, double yy, double k3) {
    double det = xx * yy - xy * xy;
    return principal(xx, xy, yy, det > 0 ? det : 0, k3);
}

/* The principal values a and b, a in the direction at `degrees` from the bisector of the acute
 * angle, which is 90 - |gamma|: t = (90 - |gamma|) / 2 + degrees from warp, to the left of it where
 * gamma >= 0. */
static struct permeability from_bisector(double a, double b, double k3, double degrees,
                                         double shear_deg) {
    double along, across;
    angle_sincos_deg((90 - fabs(shear_deg)) / 2 + degrees, &across, &along);
    if (shear_deg < 0)
        across = -across;
    if (b > a) {
        double turned = along;
        along = -across;
        across = turned;
    }
    double sign = along < 0 ? -1 : 1;
    return (struct permeability){.k1 = a > b ? a : b,
                                 .k2 = a > b ? b : a,
                                 .k3 = k3,
                                 .along = sign * along,
                                 .across = sign * across};
}

struct vec3 permeability_across(struct vec3 warp, struct vec3 weft) {
    struct vec3 across = vec3_unit(vec3_axpy(-vec3_dot(weft, warp), warp, weft));
    if (vec3_norm2(across) > 0)
        return across;
    struct vec3 any = fabs(warp.x) < 0.6 ? vec3_make(1, 0, 0) : vec3_make(0, 1, 0);
    return vec3_unit(vec3_cross(warp, any));
}

struct vec3 permeability_direction(const struct permeability *k, struct vec3 warp,
                                   struct vec3 weft) {
    struct vec3 across = permeability_across(warp, weft);
    return vec3_unit(vec3_axpy(k->across, across, vec3_scale(k->along, warp)));
}

/* ---- Kozeny-Carman ---- */

/* (1 - Vf)^3 / Vf^2 */
static double kozeny_carman(double vf) {
    double pores = 1 - vf;
    return pores > 0 ? pores * pores * pores / (vf * vf) : 0;
}

double permeability_kozeny_carman_factor(double vf, double vref) {
    return kozeny_carman(vf) / kozeny_carman(vref);
}

/* F = [1 x; 0 y] gives K = g / y [k1 + k2 x^2, k2 x y; k2 x y, k2 y^2], det K = g^2 k1 k2. */
struct permeability permeability_kozeny_carman(const double k[3], double vref, double vf,
                                               double shear_deg, double slide) {
    double s, c, g = permeability_kozeny_carman_factor(vf, vref);
    shear_sincos(shear_deg, &s, &c);
    double y = area_share(c, slide), x = slide > 0 ? (1 - slide) * s * (y / c) : s;
    double xx = g * (k[0] + k[1] * x * x) / y, xy = g * k[1] * x, yy = g * k[1] * y;
    return principal(xx, xy, yy, g * k[0] * (g * k[1]), g * k[2]);
}

/* ---- Gebart ---- */

double permeability_gebart_along(double radius, enum permeability_packing packing, double vf) {
    double c = packing == PERMEABILITY_QUADRATIC ? 57 : 53;
    return 8 * radius * radius / c * kozeny_carman(vf);
}

double permeability_gebart_across(double radius, enum permeability_packing packing, double vf) {
    double root = packing == PERMEABILITY_QUADRATIC ? sqrt(2) : sqrt(6);
    double c1 = 16 / (9 * ANGLE_PI * root);
    double gap = sqrt(permeability_packing_limit(packing) / vf) - 1;
    return gap > 0 ? c1 * radius * radius * (gap * gap * sqrt(gap)) : 0;
}

/* With a = (K_par - K_perp) / 2 the sum is K_perp I + a (w w^T + f f^T), whose values along the
 * bisectors are K_perp + a (1 +- |sin gamma|). */
struct permeability permeability_gebart(double radius, enum permeability_packing packing, double vf,
                                        double shear_deg, double slide) {
    double s, c, along = permeability_gebart_along(radius, packing, vf);
    double across = permeability_gebart_across(radius, packing, vf);
    shear_sincos(permeability_unslid_deg(shear_deg, slide), &s, &c);
    double a = (along - across) / 2;
    if (slide > 0) {
        double warp = a * (1 + slide), weft = a * (1 - slide);
        return permeability_principal(across + warp + weft * s * s, weft * s * c,
                                      across + weft * c * c, across);
    }
    return from_bisector(across + a * (1 + fabs(s)), across + a * (1 - fabs(s)), across, 0,
                         shear_deg);
}

/* ---- a table ---- */

/* The interpolant's slope at an inner point between data of slopes d0, d1 over h0, h1: their
 * weighted harmonic mean, 0 at an extremum. At an end, the next interval having h1 and d1: the
 * parabola's slope, unless it has the wrong sign or is so steep that the interpolant would
 * overshoot. */
static double slope_at(const double *x, const double *y, size_t count, size_t k) {
    size_t left = k == 0 ? 0 : k - 1;
    double h0 = x[left + 1] - x[left], d0 = (y[left + 1] - y[left]) / h0;
    if (count == 2)
        return d0;
    bool end = k == 0 || k == count - 1;
    size_t right = k == 0 ? 1 : end ? k - 2 : k;
    double h1 = x[right + 1] - x[right], d1 = (y[right + 1] - y[right]) / h1;
    double w0 = 2 * h1 + h0, w1 = h1 + 2 * h0;
    if (!end)
        return d0 * d1 > 0 ? (w0 + w1) / (w0 / d0 + w1 / d1) : 0;
    double slope = (w1 * d0 - h0 * d1) / (h0 + h1);
    if (!(slope * d0 > 0))
        return 0;
    return !(d0 * d1 > 0) && fabs(slope) > 3 * fabs(d0) ? 3 * d0 : slope;
}

double permeability_interpolate(const double *x, const double *y, size_t count, double at) {
    size_t k = 0, last = count - 1;
    if (!(at > x[0]))
        return y[0];
    if (at >= x[last])
        return y[last];
    while (at >= x[k + 1])
        k++;
    double h = x[k + 1] - x[k], t = (at - x[k]) / h, r = 1 - t;
    double m0 = slope_at(x, y, count, k) * h, m1 = slope_at(x, y, count, k + 1) * h;
    /* Hermite's cubic about the straight line, which it leaves by the slopes' differences. */
    double rise = y[k + 1] - y[k];
    return y[k] + t * rise + t * r * (r * (m0 - rise) - t * (m1 - rise));
}

struct permeability permeability_of_table(const struct permeability_table *table, double shear_deg,
                                          bool *outside) {
    const double *x = table->shear_deg;
    double shear = fabs(shear_deg), degrees = 0;
    if (outside)
        *outside = shear < x[0] || shear > x[table->rows - 1];
    if (table->angle_deg)
        degrees = permeability_interpolate(x, table->angle_deg, table->rows, shear);
    return from_bisector(permeability_interpolate(x, table->k1, table->rows, shear),
                         permeability_interpolate(x, table->k2, table->rows, shear),
                         permeability_interpolate(x, table->k3, table->rows, shear), degrees,
                         shear_deg);
}

/* ---- a table over shear and fibre volume fraction ---- */

bool permeability_falls(double k, double vf, double next_k, double next_vf) {
    return power_log(k / next_k) >= (next_vf - vf) / (1 - next_vf);
}

/* The interval of increasing values that `at` lies in, the first or the last beyond them, and how
 * far it lies in it: 0..1, beyond the values 0 or 1. */
static size_t interval(const double *values, size_t count, double at, double *share) {
    size_t k = 0;
    while (k + 2 < count && at >= values[k + 1])
        k++;
    *share = 0;
    if (count == 1)
        return 0;
    double t = (at - values[k]) / (values[k + 1] - values[k]);
    *share = t > 0 ? (t < 1 ? t : 1) : 0;
    return k;
}

/* Where a place lies in a grid. */
struct grid_place {
    size_t row, next_row, column;
    double row_share, share;
    double factor; /* by which k beyond the fractions follows from its end */
};

static double k_at(const struct permeability_grid *grid, const double *k,
                   const struct grid_place *place) {
    const double *row = k + place->row * grid->columns + place->column;
    const double *next = k + place->next_row * grid->columns + place->column;
    return place->factor * power_mean(power_mean(row[0], row[1], place->share),
                                      power_mean(next[0], next[1], place->share), place->row_share);
}

struct permeability permeability_of_grid(const struct permeability_grid *grid, double vf,
                                         double shear_deg, bool *outside) {
    double shear = fabs(shear_deg);
    const double *fraction = grid->fiber_volume_fraction;
    double first = fraction[0], last = fraction[grid->columns - 1];
    bool beyond = vf < first || vf > last;
    struct grid_place place = {.factor = 1};
    place.row = interval(grid->shear_deg, grid->rows, shear, &place.row_share);
    place.next_row = place.row + (grid->rows > 1);
    place.column = interval(fraction, grid->columns, vf, &place.share);
    if (beyond)
        place.factor = permeability_kozeny_carman_factor(vf, vf < first ? first : last);
    double degrees = 0;
    if (grid->angle_deg) {
        const double *row = grid->angle_deg + place.row * grid->columns + place.column;
        const double *next = grid->angle_deg + place.next_row * grid->columns + place.column;
        double t = place.share, s = place.row_share;
        degrees = (1 - s) * ((1 - t) * row[0] + t * row[1]) + s * ((1 - t) * next[0] + t * next[1]);
    }
    if (outside)
        *outside = shear < grid->shear_deg[0] || shear > grid->shear_deg[grid->rows - 1] || beyond;
    return from_bisector(k_at(grid, grid->k1, &place), k_at(grid, grid->k2, &place),
                         k_at(grid, grid->k3, &place), degrees, shear_deg);
}
