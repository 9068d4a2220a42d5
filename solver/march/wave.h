/* SPDX-License-Identifier: MIT */
/*
 * A wave: cells of several rows of a quadrant at once. Row k is one place behind row k - 1, so that
 * the cells of a step do not depend on each other,
 *
 *     row 2    B D . .          C of a row is D of the row below it a step before, A a step
 *     row 1    A C D .          before that, and B its own D a step before.
 *     row 0    . . C D
 *
 * Where weft slides a cell rests on the place beyond C too (march_slide.c), and each row is two
 * places behind: `lag`.
 *
 * Each row is a lane of vectors. The kernels do what `fishnet_chords`, `fishnet_solve` and
 * `rough_edge` do where all goes the usual way, with the same bits; a cell where it does not they
 * leave alone. On a shell rows may be on several faces: the cells of each are solved together, and
 * those that a joint crosses alone.
 */
#ifndef SOLVER_MARCH_WAVE_H
#define SOLVER_MARCH_WAVE_H

#include "solver/shell/surface_point.h"

enum {
    WAVE_LANES = 8,   /* at the most */
    WAVE_STRIDE = 16, /* of a number of all places: the row below the wave, then its rows */
    WAVE_STEPS = 5,   /* that are remembered */
    WAVE_ORDERS = 6   /* of differences */
};

/* A point but for its surface, number by number. */
struct wave_point {
    double uv[2];
    struct surface_jet jet;
    struct vec3 normal;
    double first[3], second[3];
};

enum { WAVE_NUMBERS = sizeof(struct wave_point) / sizeof(double) };

/* The points of a step: [0] of the row below the wave, [k + 1] of row k. */
struct wave_places {
    _Alignas(64) double of[WAVE_NUMBERS][WAVE_STRIDE];
    const struct surface *surface[WAVE_STRIDE];
    _Alignas(64) int64_t even[WAVE_STRIDE]; /* -1: nodes all of whose edges are smooth; else 0 */
};

/* What the net that a second march corrects says of those places (`correction.h`). */
struct wave_before {
    _Alignas(64) int64_t even[WAVE_STRIDE]; /* -1: all of it is known, of smooth edges; else 0 */
    int32_t face[WAVE_STRIDE];
    double uv[2][WAVE_STRIDE];
    double bend[2][3][WAVE_STRIDE]; /* D2 along warp and along weft */
};

struct wave {
    const struct surface *surface; /* that A, B and C of the cells at hand are on */
    struct surface_cursor *cursor;
    double length[2]; /* spacing along warp and weft */
    double slide;     /* of the fabric: drape_settings' */
    unsigned lag;     /* 1; where weft slides 2 */
    bool arcs;        /* chords are those of arcs of the surface's curvature; else the spacing */
    int orientation;  /* as fishnet_cell's */
    double lower[2], upper[2]; /* parameters between which a node is certainly inside */
    double pole_reach2; /* march_pole_reach2: cells whose C is nearer to a pole are left alone */
    unsigned step;
    int lane;                                /* one of those that have a cell */
    _Alignas(64) int64_t active[WAVE_LANES]; /* -1 for them, 0 for the others */
    struct wave_places places[WAVE_STEPS];   /* of step k at k % WAVE_STEPS */
    struct wave_places spare, *into;         /* where `solve` puts D: there, or of this step */
    /* By lane: the differences, of order 0, 1, .. in u and v, of the edge from the row below, to
     * the last place but one; NaN from the order on that is not known yet. */
    _Alignas(64) double difference[WAVE_ORDERS][2][WAVE_LANES];
    _Alignas(64) double expected[2][WAVE_LANES];                      /* parameters expected of D */
    _Alignas(64) double chord[2][WAVE_LANES];                         /* BD and CD */
    _Alignas(64) double curvature[2][WAVE_LANES];                     /* of them */
    _Alignas(64) double residual[WAVE_LANES], iterations[WAVE_LANES]; /* as fishnet_node's */
    /* Where weft slides: the sides of C's surfaces, for `lean`, and -1 where A, C and the place
     * beyond C are on `surface`, else 0; of CD what that finds, and by how much its chord is longer
     * than the law has it. */
    _Alignas(64) double side[WAVE_LANES], excess[WAVE_LANES];
    _Alignas(64) int64_t one[WAVE_LANES];
    _Alignas(64) double along[3][WAVE_LANES], across[3][WAVE_LANES], rate[WAVE_LANES];
    _Alignas(64) double tangent[WAVE_LANES], stretch[WAVE_LANES], weft[WAVE_LANES];
    unsigned plain; /* bits: lanes of which it does, the foot being next to C */
    bool corrected; /* by a net before: */
    struct wave_before before[WAVE_STEPS]; /* as places */
    unsigned settled;                      /* bits: lanes whose chords `prepare` has corrected */
    /* Of edges that are corrected as a whole: what has to agree with D. */
    _Alignas(64) int64_t whole[2][WAVE_LANES];  /* -1 for them, 0 for the others */
    _Alignas(64) double bend[2][3][WAVE_LANES]; /* D2 at D */
    _Alignas(64) double tried[2][WAVE_LANES];   /* parameters of D before bent edges moved it */
    unsigned found;                             /* bits: lanes that have a D; */
    unsigned smooth; /* whose edges to D are arcs, or bent and of the chords of bent ones; or
                        straight chords that lie over no fold */
    unsigned inside; /* whose D was expected, tried and found between the bounds above */
};

/* Compiled for one width. */
struct wave_kernel {
    int lanes;
    /* Where weft slides, before anything else: how it lies to the fibre at C. */
    void (*lean)(struct wave *wave);
    /* Of the cells of a step: takes in the last difference, sets what is expected of D, the chords
     * and their curvatures; corrects those that all places of the net before are even of. */
    void (*prepare)(struct wave *wave);
    /* Puts D of those that are active into the places `into`. */
    void (*solve)(struct wave *wave);
};

extern const struct wave_kernel wave_kernel_2, wave_kernel_4, wave_kernel_8;

/* The widest that this processor has, of at most so many lanes (0: any); NULL: none. */
const struct wave_kernel *wave_kernel_for(int lanes);

/* The places `back` steps before this one. */
static inline struct wave_places *wave_at(struct wave *wave, unsigned back) {
    return &wave->places[(wave->step - back) % WAVE_STEPS];
}

/* Those with the places of a step's cells: A and C of lane k in slot k, B in slot k + 1. */
static inline struct wave_places *wave_a(struct wave *wave) {
    return wave_at(wave, wave->lag + 1);
}

static inline struct wave_places *wave_b(struct wave *wave) {
    return wave_at(wave, 1);
}

static inline struct wave_places *wave_c(struct wave *wave) {
    return wave_at(wave, wave->lag);
}

static inline struct wave_before *wave_before_at(struct wave *wave, unsigned back) {
    return &wave->before[(wave->step - back) % WAVE_STEPS];
}

void wave_put(struct wave_places *places, int slot, const struct surface_point *point);
void wave_get(const struct wave_places *places, int slot, struct surface_point *point);

/* The same without its derivatives: uv, normal and both fundamental forms. */
void wave_get_forms(const struct wave_places *places, int slot, struct surface_point *point);

#endif
