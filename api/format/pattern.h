/* SPDX-License-Identifier: MIT */
/*
 * The flat cut pattern: the net before it was sheared, node (i, j) at (i a, j b) for the spacings a
 * and b. It shows the outline of the cells, the start with the directions of warp and weft, the
 * cells beyond the locking angle hatched, a bar of a round length and a title. Columns and
 * precision do not apply.
 *
 * What draws it in one format is a pen. Places are given in steps (i, j); a pen scales them.
 */
#ifndef API_FORMAT_PATTERN_H
#define API_FORMAT_PATTERN_H

#include "api/result/outline.h"
#include "encoder.h"

struct pattern_sheet {
    double step[2];         /* of i and j in the pen's unit */
    double low[2], high[2]; /* of the drawing in that unit, the start within; high >= low */
    double letter;          /* height of the letters in that unit, a measure for all marks */
    double bar;             /* length of the bar */
    const char *unit;       /* the pen's */
    char title[160], subtitle[160], bar_label[40];
};

struct pattern_pen {
    /* Metres of the pen's unit; 0 for the drape's own. */
    double metres;
    const char *unit; /* NULL for the drape's own */
    void (*head)(struct api_text *text, const struct pattern_sheet *sheet,
                 const struct api_unit *unit);
    void (*begin_polygon)(struct api_text *text);
    void (*corner)(struct api_text *text, double x, double y);
    void (*end_polygon)(struct api_text *text);
    void (*end_outline)(struct api_text *text);
    /* `count` cells of a row from (i, j) on. */
    void (*locked)(struct api_text *text, const struct pattern_sheet *sheet, int i, int j,
                   int count);
    void (*foot)(struct api_text *text, const struct pattern_sheet *sheet);
};

enum pattern_stage { PATTERN_HEAD, PATTERN_OUTLINE, PATTERN_LOCKED, PATTERN_FOOT };

struct pattern_state {
    struct outline outline;
    struct pattern_sheet sheet;
    enum pattern_stage stage;
    size_t corner;
    bool open; /* a polygon is begun */
};

/* What a format of patterns consists of beside its pen, which is its `own`. */
#define PATTERN_FORMAT(pen)                                                                        \
    .uses = FORMAT_PATTERN, .own = &(pen), .state_size = sizeof(struct pattern_state),             \
    .begin = pattern_begin, .next = pattern_next, .end = pattern_end

bool pattern_begin(struct encoder *encoder, struct api_problem *problem);
void pattern_next(struct encoder *encoder);
void pattern_end(struct encoder *encoder);

/* A length, rounded so that products of steps stay short. */
void pattern_number(struct api_text *text, double value);

#endif
