/* SPDX-License-Identifier: MIT */
/*
 * One step of the fishnet: from three corners A, B, C of a cell the fourth, D.
 *
 *       B ---- D        AB and CD run along one yarn family, AC and BD along the other.
 *       |      |        D lies on the surface at the distances |BD| and |CD| from B and C,
 *       A ---- C        on the side of BC away from A.
 *
 * The methods differ only in these distances (`fishnet_chords`).
 */
#ifndef SOLVER_FISHNET_FISHNET_H
#define SOLVER_FISHNET_FISHNET_H

#include "solver/method.h"
#include "solver/shell/crossing.h"

struct slide; /* slide_formulas.h */

struct fishnet_cell {
    const struct surface_point *a, *b, *c;
    double bd, cd;          /* chord lengths wanted, > 0 */
    double curvature[2];    /* of BD and CD, where the chords come from it; else 0 */
    struct vec3 guess;      /* where D is expected, in space */
    const double *guess_uv; /* in parameters, those of the surface of C; then preferred; or NULL */
    struct slide *slide;    /* of a cell whose weft slides: by it `cd` follows from D; else NULL */
    bool corrects;          /* the net before, as `gib4`: chords are hardly those of curvatures */
    int orientation; /* 1 when A, C, D, B turn counter-clockwise about the normal, -1 when not */
};

enum fishnet_end {
    FISHNET_FOUND,
    FISHNET_COLLAPSED, /* the spheres no longer meet on the surface: the yarns are parallel */
    FISHNET_NO_CONVERGENCE,
    FISHNET_DEGENERATE /* no tangent plane */
};

struct fishnet_node {
    struct surface_point point;
    int iterations;  /* Newton steps */
    int tried;       /* steps of geodesics, where there are any */
    double residual; /* the larger | |D - B| / bd - 1 |, | |D - C| / cd - 1 | */
    bool looked;     /* by fishnet_solve, on a shell: over the edge of D's face, and found this */
    struct crossing crossing;
};

/* The chords of a cell whose edges are `ac` (and so BD) and `ab` (and so CD) long along the yarns.
 * DRAPE_YARN_CHORD: chords equal lengths. Others: as of arcs with the surface's normal curvature
 * (paper, equations 11 to 16). The tangents at A are the projected chords, or by `path` those of
 * the geodesics found by relaxation, where that converges. Sets cell->bd, cd and curvature. */
void fishnet_chords(struct surface_cursor *cursor, enum drape_yarn yarn, enum drape_yarn_path path,
                    const double length[2], struct fishnet_cell *cell);

/* Whether D is the root away from A, and the cell A, C, D, B convex. */
bool fishnet_right_root(const struct fishnet_cell *cell, const struct surface_point *d);

/* Whether a cell without a D has none because it collapsed: its yarns at A are nearly parallel, or
 * B and C are as far apart as the two chords together reach. */
bool fishnet_has_collapsed(const struct fishnet_cell *cell);

/* Solves |D - B| = bd, |D - C| = cd, the chord of `slide` if there is one, on the surface (paper,
 * equations 20 to 27) to a residual of 1e-12, from the guess and, should that fail, from other
 * predictors. */
enum fishnet_end fishnet_solve(const struct surface *surface, struct surface_cursor *cursor,
                               const struct fishnet_cell *cell, struct fishnet_node *node);

#endif
