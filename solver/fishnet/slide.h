/* SPDX-License-Identifier: MIT */
/*
 * A fabric whose weft slides along its warp. The warp are fibres that do not stretch; of the weft
 * that crosses them at the shear g the length b of the flat cloth becomes b (cos g)^-c. With c = 0
 * it does not stretch: a weave, pinned at its crossings. With c = 1 the area of the cloth is kept:
 * neighbouring fibres stay b apart, as in a unidirectional tape, and each is a geodesic parallel of
 * the first.
 *
 * With arc length s along the fibres, weft r_t = p (sin g e + cos g n), p = (cos g)^-c, e the unit
 * vector of the fibre and n that across it, |r_s| = 1 and the connection of the surface give
 *
 *     fibres bend sideways by    k = g_s (1 + c tan^2 g),
 *     e turns along weft by      l k,     l = c p sin g / (cos^2 g + c sin^2 g):
 *
 * the direction of the fibre is carried unchanged from fibre to fibre along r_t - l r_s, which is
 * the other characteristic of the net. It is the weft with c = 0, and the normal of the fibre with
 * c = 1.
 */
#ifndef SOLVER_FISHNET_SLIDE_H
#define SOLVER_FISHNET_SLIDE_H

/* Cloth that is sheared by more than 85 degrees has collapsed: its sine and tangent. */
#define SLIDE_STEEPEST 0.99619
#define SLIDE_STEEPEST_TANGENT 11.43

/* The law is kept to this share of the edge. */
#define SLIDE_KEPT 2e-13

/* Of Newton's method for the tangent of the shear: no more rounds, which end when it changes by no
 * more: the next change would be by the square of that. */
#define SLIDE_ROUNDS 12
#define SLIDE_SETTLED 1e-8

#endif
