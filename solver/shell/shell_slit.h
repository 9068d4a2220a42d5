/* SPDX-License-Identifier: MIT */
/*
 * A slit: lines on a shell along which it is taken to be open, although its faces go on. Seen from
 * a point near it a line has a left and a right side, by the normals of the shell.
 */
#ifndef SOLVER_SHELL_SHELL_SLIT_H
#define SOLVER_SHELL_SHELL_SLIT_H

#include "shell.h"

/* A piece of a line on one face; the next piece begins where it ends. */
struct shell_slit_piece {
    int32_t face;
    double (*uv)[2];   /* inner parameters, straight between them */
    struct vec3 *r;    /* the same in space, as exactly as they are known */
    size_t count;      /* of points, at least 2 */
    bool begins, ends; /* the line begins or ends with it, at the boundary of the shell */
};

struct shell_slit;

/* What a slit is made of. */
struct shell_slit_lines {
    const struct shell_slit_piece *pieces; /* line after line; used as long as the slit is */
    size_t count;
    bool closed;   /* one line, which ends where it begins */
    double reach;  /* the length of the longest ways asked for */
    double beyond; /* it goes straight on for so long at both ends, or half way to the nearest */
    const struct vec3 *ahead; /* of the shell's points that lies there, of these */
    size_t ahead_count;
};

/* A slit of these lines, over the holes between them straight ahead. Errors: STATUS_OUT_OF_MEMORY.
 */
enum status shell_slit_make(const struct shell *shell, const struct shell_slit_lines *lines,
                            struct arena *arena, struct shell_slit **slit) STATUS_MUST_USE;

const struct shell_slit_piece *shell_slit_pieces(const struct shell_slit *slit, size_t *count);

/* A point on the shell or beside its boundary, and the unit normal of the shell there, by which the
 * two skins of a thin part are told apart; zero where it has none. */
struct shell_slit_point {
    struct vec3 r, normal;
};

/* How often the straight way between two points, which are as near to each other as neighbours in a
 * net, passes from the right side to the left: 1, 0, or -1 for the other way. */
int shell_slit_passes(const struct shell_slit *slit, const struct shell_slit_point *from,
                      const struct shell_slit_point *to);

/* Whether it passes one of two slits, each of which may be NULL. */
bool shell_slits_part(const struct shell_slit *const slit[2], const struct shell_slit_point *from,
                      const struct shell_slit_point *to);

#endif
