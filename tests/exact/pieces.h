/* SPDX-License-Identifier: MIT */
/*
 * A surface cut into faces, each parametrised anew at random, turned round and in any order; and
 * what is wrong with faces in real files.
 */
#ifndef DRAPE_TESTS_PIECES_H
#define DRAPE_TESTS_PIECES_H

#include "shapes.h"
#include "solver/shell/shell.h"

enum { PIECES_MAX = 64, CURVES_MAX = 12 };

/* A loop of lines and cubics in shares of the whole's domain; later in those of the piece. */
struct outline {
    int count; /* of curves; 0: none */
    struct trim_curve curve[CURVES_MAX];
    double point[CURVES_MAX][4][2];
    bool hole;
};

/* Large: to be static. */
struct pieces {
    int count;
    struct shape shape[PIECES_MAX];
    struct outline outline[PIECES_MAX][2];
    double corners[PIECES_MAX][4][2]; /* of those by pieces_cut_grid, in shares of the domain */
};

/* Lines u = const and v = const; cubics across; quadrilaterals; an island in the rest; and rows of
 * quadrilaterals that do not meet those of the next row corner to corner, with slivers among them,
 * short sides and sides without length. */
enum cutting { CUT_ISOLINES, CUT_STRIPS, CUT_QUADS, CUT_ISLAND, CUTTINGS, CUT_BRICKS = CUTTINGS };
const char *cutting_name(enum cutting cutting);

void pieces_cut(struct pieces *pieces, enum cutting cutting, const struct shape *whole,
                uint64_t *seed);
void pieces_cut_grid(struct pieces *pieces, const struct shape *whole, int nu, int nv,
                     uint64_t *seed);

/* Moves each face by up to `gap` along each axis, and half of the time has one of them twice. */
void pieces_disturb(struct pieces *pieces, double gap, uint64_t *seed);

/* Makes each trimmed region larger about its middle by up to `share` of itself, or smaller, within
 * its domain: faces overlap, or leave gaps. */
void pieces_stretch(struct pieces *pieces, double share, uint64_t *seed);

/* The faces as parts of a shell, in `arena`, with views of `pieces`. */
struct shell_patch *pieces_parts(struct pieces *pieces, struct arena *arena);

/* The shell of them; fails the test where there is none. */
struct shell *pieces_shell(struct pieces *pieces, struct arena *arena);

#endif
