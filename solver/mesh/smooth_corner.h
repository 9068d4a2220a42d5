/* SPDX-License-Identifier: MIT */
/*
 * The fourth corner of a cell on the smooth surface of a mesh: F(D) = 0, |D - B| = bd, |D - C| = cd
 * by Newton's method in space (`smooth.h`), from where the cell expects it; should that fail, from
 * the corner on the flat triangles (`corner.h`), which looks everywhere.
 */
#ifndef SOLVER_MESH_SMOOTH_CORNER_H
#define SOLVER_MESH_SMOOTH_CORNER_H

#include "corner.h"
#include "smooth.h"

/* As mesh_corner_solve; A, B and C lie on the smooth surface, and so does D. */
enum mesh_corner_end mesh_smooth_corner(const struct mesh_smooth *smooth,
                                        const struct mesh_cell *cell, struct mesh_corner *corner);

#endif
