/* SPDX-License-Identifier: MIT */
/*
 * The way of a path from face to face of a shell: what the tangent has along the common edge and
 * across it stays. For the files of this folder.
 */
#ifndef SOLVER_PATH_PATH_JOINT_H
#define SOLVER_PATH_PATH_JOINT_H

#include "path.h"
#include "solver/shell/crossing.h"

/* The first joint that a step of h from `from` to `to` crosses, and about how far on that is. */
bool path_find_joint(const struct path *from, const struct path *to, double h,
                     struct crossing *joint, double *length);

/* Moves `g` to the joint, about `*length` on, and over it; the length it went. False when it does
 * not get there. */
bool path_pass_joint(struct path *g, struct crossing *joint, double *length);

/* A path that begins in the gap of a joint, outside the region of its face, and leads away from it
 * goes on the next face. False where that is not to be had. */
bool path_set_off(struct path *g);

/* Where a path ends beyond a joint that it has not met, it goes on from what is next to there. */
bool path_settle(struct path *g);

#endif
