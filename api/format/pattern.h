/* SPDX-License-Identifier: MIT */
/*
 * The flat cut pattern: the net before it was sheared, node (i, j) at (i a, j b) for the spacings a
 * and b. It shows where to cut, along the part's edge or, where the net ended before that, along
 * the cloth's own, which is marked as bare or collapsed; if asked for a second line an allowance
 * outside it, along the lips of a cut its own; notches where the generators cross the edge and at
 * quarters of cuts, where these meet when they are closed, the start with the directions of warp
 * and weft, the cells beyond the locking angle hatched, a ruler to check prints by, and a title.
 * Columns and precision do not apply.
 *
 * What draws it in one format is a pen.
 */
#ifndef API_FORMAT_PATTERN_H
#define API_FORMAT_PATTERN_H

#include "api/result/flat_pattern.h"
#include "encoder.h"

struct pattern_sheet {
    double step[2];                 /* of i and j in the pen's unit */
    double low[2], high[2];         /* of the drawing in that unit, the start within; high >= low */
    double cut_low[2], cut_high[2]; /* of the cut alone; all 0 without one */
    double letter;    /* height of the letters in that unit, a measure for all marks */
    double bar;       /* length of the ruler, of ten parts */
    const char *unit; /* the pen's */
    double zero[2]; /* the unit direction of 0 degrees of the rosette at the start; 0 without one */
    char title[240], subtitle[240], bar_label[60];
};

/* What is drawn, in this order: both shapes are of corners, the others of marks. */
enum pattern_group {
    PATTERN_ALLOWANCE,
    PATTERN_CUT,
    PATTERN_LOCKED,
    PATTERN_BARE,      /* the edge beyond which the part is bare, */
    PATTERN_COLLAPSED, /* where the net ended there because yarns became parallel */
    PATTERN_NOTCHES,
    PATTERN_GROUPS
};

struct pattern_pen {
    /* Metres of the pen's unit; 0 for the drape's own. */
    double metres;
    const char *unit; /* NULL for the drape's own */
    bool to_cut; /* machines cut by it unseen: cloth that leaves some of the part bare is refused,
                    unless it is asked for */
    const char *before[PATTERN_GROUPS]; /* text before each group */
    const char *after_shape;
    void (*head)(struct api_text *text, const struct pattern_sheet *sheet);
    /* Of a closed polygon of a shape, its first or last, or both. */
    void (*corner)(struct api_text *text, enum pattern_group shape, double x, double y, bool first,
                   bool last);
    /* `count` cells of a row from (i, j) on. */
    void (*locked)(struct api_text *text, const struct pattern_sheet *sheet, int i, int j,
                   int count);
    /* A straight line of PATTERN_BARE or PATTERN_COLLAPSED, or a notch, inwards. */
    void (*line)(struct api_text *text, enum pattern_group group, double x, double y, double to_x,
                 double to_y);
    void (*foot)(struct api_text *text, const struct pattern_sheet *sheet);
};

struct pattern_state {
    struct flat_pattern cut; /* its polygons in the pen's unit */
    struct polygons allowed; /* the same with the allowances; empty without one */
    int slim_cuts;           /* narrower than their own would need */
    struct pattern_sheet sheet;
    enum pattern_group group; /* that is being drawn; PATTERN_GROUPS: the foot is next */
    size_t at;                /* the next corner, cell or notch of it */
    bool begun, open;         /* the head is drawn; a polygon is begun */
};

/* What a format of patterns consists of beside its pen, which is its `own`. */
#define PATTERN_FORMAT(pen)                                                                        \
    .uses = FORMAT_PATTERN, .own = &(pen), .state_size = sizeof(struct pattern_state),             \
    .begin = pattern_begin, .next = pattern_next, .end = pattern_end

bool pattern_begin(struct encoder *encoder, struct api_problem *problem);
void pattern_next(struct encoder *encoder);
void pattern_end(struct encoder *encoder);

/* Whether a machine may get what a drape covers of its part: all of it, or `partial` was asked for.
 */
bool pattern_may_be_cut(const struct api_columns *columns, bool to_cut, bool partial,
                        struct api_problem *problem);

/* The direction of 0 degrees of the rosette at the start, of unit length along warp and weft of the
 * flat cloth; 0 without one. */
void pattern_flat_zero(const struct api_start *start, double flat[2]);

/* 1, 2 or 5 times a power of ten, at most `length` > 0. */
double pattern_round_length(double length);

/* A length, rounded so that products of steps stay short. */
void pattern_number(struct api_text *text, double value);

#endif
