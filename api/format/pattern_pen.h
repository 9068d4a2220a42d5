/* SPDX-License-Identifier: MIT */
/* What draws a pattern in one format. Places are given in steps (i, j); a pen scales them. */
#ifndef API_FORMAT_PATTERN_PEN_H
#define API_FORMAT_PATTERN_PEN_H

#include "api/result/outline.h"
#include "format.h"

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

extern const struct pattern_pen pattern_svg_pen, pattern_dxf_pen;

/* A length, rounded so that products of steps stay short. */
void pattern_number(struct api_text *text, double value);

#endif
