/* SPDX-License-Identifier: MIT */
/*
 * Plies on each other at one place: how thick they are together, and what they let flow.
 *
 * A ply by itself has the thickness t = n t0 / cos gamma of its n layers and the fibre fraction Vf;
 * V = t Vf, the volume of its fibres per area, is not changed by pressing it. A compaction law
 * Vf(p) = a p^b says how dense it is under a pressure p in Pa, and t(p) = V / Vf(p) how thick.
 *
 * In the plane the plies are flowed through side by side, so the tensor is their mean by
 * thickness; through it one after the other, so that resistances add:
 *
 *     K = sum_k t_k K_k / T,    k3 = T / sum_k (t_k / k3_k),    T = sum_k t_k.
 */
#ifndef SOLVER_STACK_H
#define SOLVER_STACK_H

#include "permeability.h"
#include <stdbool.h>
#include <stddef.h>

enum stack_kind {
    STACK_FLEXIBLE, /* every ply as it is by itself */
    STACK_PRESSURE, /* those with a law under this pressure, the others by themselves */
    STACK_HEIGHT    /* T is this height: without a law every ply takes its share, t H / T; those
                       with a law are under one pressure in what their shares are together */
};

struct stack_cavity {
    enum stack_kind kind;
    double pressure; /* > 0 */
    double height;   /* > 0 */
};

/* One ply at a place. */
struct stack_ply {
    double thickness; /* by itself, > 0; then as it is pressed */
    double fraction;  /* the same; 0: not known, and then it has no law */
    double a, b;      /* of its law, > 0; a is 0 without one */
};

/* Presses the plies. Returns the pressure that those with a law are under; 0 where there is none.
 * With a height it is found to rounding, by Newton's method from below: the thickness falls with
 * ln p and is convex in it. */
double stack_press(const struct stack_cavity *cavity, size_t count, struct stack_ply *plies);

/* The sums above, in one frame of the plane. */
struct stack_sum {
    double thickness, xx, xy, yy, resistance;
};

/* Adds a ply of this (pressed) thickness with the permeability k, whose frame has its first axis at
 * (along[0], along[1]) and its second at (across[0], across[1]) of that of the sum. */
void stack_add(struct stack_sum *sum, double thickness, const struct permeability *k,
               const double along[2], const double across[2]);

/* The stack's principal values and direction, in the frame of the sum. */
struct permeability stack_permeability(const struct stack_sum *sum);

#endif
