/* SPDX-License-Identifier: MIT */
/*
 * A surface moved along its own normal, r_h = r + h n with n along r_u x r_v: the middle of a ply
 * that lies h above a tool. It has the parameters of the surface it comes from and, where that
 * is regular, first and second derivatives from the surface's own up to the third, exact to
 * rounding (`offset_jet.h`). Everything that works on a surface works on it.
 *
 * With principal curvatures k1, k2, positive where the surface bends towards n, lengths on the
 * moved surface are 1 - h k1 and 1 - h k2 times those below: it is a surface while both are
 * positive. Where the surface has a crease the moved one has a gap or crosses itself.
 */
#ifndef SOLVER_SHELL_OFFSET_H
#define SOLVER_SHELL_OFFSET_H

#include "solver/surface/surface.h"
#include "solver/surface/trim.h"

/* Where a surface cannot be moved so far, and why. */
struct surface_offset_fault {
    struct vec3 at;  /* on the surface itself */
    double uv[2];    /* the caller's */
    double radius;   /* of curvature there, less than |h|, towards the side moved to; 0: none */
    double fold_deg; /* by which the surface is creased there; 0: it is not */
};

/* `from` moved by `height`, any finite number; `from` has not been moved itself, and is needed as
 * long as the new one. Errors: STATUS_OUT_OF_MEMORY, STATUS_DEGENERATE_SURFACE (no area is left).
 */
enum status surface_offset(const struct surface *from, double height, struct arena *arena,
                           struct surface **moved) STATUS_MUST_USE;

/* By how much a surface is moved; 0 for most. */
double surface_offset_height(const struct surface *surface);

/* Whether a moved surface is one, within the region (NULL: all of it): true, or false with the
 * place where it fails most. Curvature is looked for at samples of every span and followed to its
 * greatest, creases along the knots where they may be. A crease whose gap is no wider than `gap`
 * is passed over. */
bool surface_offset_holds(const struct surface *moved, const struct trim *trim, double gap,
                          struct surface_offset_fault *fault) STATUS_MUST_USE;

#endif
