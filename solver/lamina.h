/* SPDX-License-Identifier: MIT */
/*
 * Classical lamination theory: layers under plane stress, and what they are together. Forces and
 * moments per length follow from the strain e of the middle plane and its curvature k,
 *
 *     N = A e + B k,  M = B e + D k,  (A, B, D) = sum of Q times ((z), (z^2 / 2), (z^3 / 3)),
 *
 * each over the height from z0 to z1 of a layer. Strains are (xx, yy, 2 xy).
 *
 * A ply of two families of yarns that share its whole thickness, a of it along warp, has
 * Q = a Q1(warp) + (1 - a) Q1(weft), where Q1 is that of a unidirectional layer.
 * Source: R. M. Jones, Mechanics of Composite Materials, chapters 2 and 4.
 */
#ifndef SOLVER_LAMINA_H
#define SOLVER_LAMINA_H

/* An orthotropic layer under plane stress: Young's moduli along and across, the transverse strain
 * that a stress along makes, the shear modulus. All in one unit of stress; e1 is 0 where it is not
 * known. */
struct lamina {
    double e1, e2, nu12, g12;
};

/* The entries of a symmetric matrix: 11, 12, 16, 22, 26, 66. */
enum { LAMINA_ENTRIES = 6 };

/* Whether there is such a material: moduli above 0, and nu12^2 < e1 / e2. */
int lamina_is_sound(const struct lamina *lamina);

/* Adds `share` times the reduced stiffness of a layer whose axis 1 is `angle_deg` from x. */
void lamina_add(const struct lamina *lamina, double angle_deg, double share,
                double q[LAMINA_ENTRIES]);

/* The layer that has the stiffness q, of which 16 and 26 are rounding: its axes are x and y. */
struct lamina lamina_of(const double q[LAMINA_ENTRIES]);

struct lamina_abd {
    double a[LAMINA_ENTRIES], b[LAMINA_ENTRIES], d[LAMINA_ENTRIES];
};

/* Adds a layer of the stiffness q between the heights z0 < z1. */
void lamina_stack(struct lamina_abd *abd, const double q[LAMINA_ENTRIES], double z0, double z1);

#endif
