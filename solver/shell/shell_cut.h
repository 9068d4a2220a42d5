/* SPDX-License-Identifier: MIT */
/*
 * A cut: lines on a shell along which it is taken to be open, although its faces go on. Seen from
 * a place near it a line has a left and a right side, by the normals of the shell.
 */
#ifndef SOLVER_SHELL_SHELL_CUT_H
#define SOLVER_SHELL_SHELL_CUT_H

#include "shell.h"

/* A part of a line on one face; the next part begins where it ends. */
struct shell_cut_part {
    int32_t face;
    double (*uv)[2];   /* inner parameters, straight between them */
    size_t count;      /* of points, at least 2 */
    bool begins, ends; /* the line begins or ends with it, at the boundary of the shell */
};

struct shell_cut;

/* A cut of `count` parts, line after line, over the holes between straight ahead, and for a length
 * `beyond` straight on at both ends, for ways of a length of up to `reach`. `parts` is used as long
 * as the cut is. Errors: STATUS_OUT_OF_MEMORY. */
enum status shell_cut_make(const struct shell *shell, const struct shell_cut_part *parts,
                           size_t count, double beyond, double reach, struct arena *arena,
                           struct shell_cut **cut) STATUS_MUST_USE;

const struct shell_cut_part *shell_cut_parts(const struct shell_cut *cut, size_t *count);

/* A place on the shell or beside its boundary, and the unit normal of the shell there, by which the
 * two skins of a thin part are told apart; zero where it has none. */
struct shell_cut_place {
    struct vec3 r, normal;
};

/* How often the straight way between two places, which are as near to each other as neighbours in a
 * net, passes from the right side to the left: 1, 0, or -1 for the other way. */
int shell_cut_passes(const struct shell_cut *cut, const struct shell_cut_place *from,
                     const struct shell_cut_place *to);

#endif
