/* SPDX-License-Identifier: MIT */
/*
 * What a cutter gets: flat pieces of cloth and where they lie on their rolls, the warp along x,
 * with the revision of what they were made from. Lengths are in the sheet's unit until they are
 * written.
 */
#ifndef API_FORMAT_CUT_SHEET_H
#define API_FORMAT_CUT_SHEET_H

#include "api/json/text.h"
#include "api/request/request.h"
#include "api/result/flat_pattern.h"
#include "api/result/nesting.h"

enum {
    CUT_NAME_SIZE = 21 /* as long as ASTM D6673 has names, and the 0 */,
    CUT_TITLE_SIZE = 192,
    CUT_TEXT_SIZE = 384
};

/* A piece; (0, 0) of its shape is the start of its drape. */
struct cut_piece {
    const struct pattern_notch *notches; /* places in lengths, directions of length 1 */
    size_t notch_count;
    const struct polygons
        *seam;                /* the line that an allowance lies outside of; NULL: there is none */
    double zero[2];           /* the unit direction of 0 degrees of the rosette; 0 without one */
    char name[CUT_NAME_SIZE]; /* unique in its sheet */
    char title[CUT_TITLE_SIZE];
};

/* A roll of one cloth; shapes and pieces are as many, and go together. */
struct cut_roll {
    const struct nesting_shape *shapes;
    const struct cut_piece *pieces;
    size_t count;
    const struct nesting_place *places; /* of all layers */
    size_t place_count;
    double length, area;        /* of the roll that is taken, and of the shapes on it */
    double from;                /* where it begins in a drawing of all rolls, along x */
    char cloth[CUT_TITLE_SIZE]; /* what it is called; "" where there is one cloth only */
};

struct cut_sheet {
    const struct api_unit *unit;
    const char *style;    /* what it all is of */
    const char *revision; /* the digest of what it was made from */
    double width;         /* of the rolls */
    const struct cut_roll *rolls;
    size_t roll_count;
    size_t left_out;            /* plies that have no pattern, since they could not be draped, .. */
    const char *left_out_first; /* .. and the title of the first; NULL: there is none */
};

/* A stretch along the warp within a shape: the longest of some lines across it. */
struct cut_chord {
    double x[2], y; /* x[0] < x[1] */
};
struct cut_chord cut_chord_of(const struct nesting_shape *shape);

/* "skin (2 of 3)" */
void cut_layer_title(const struct cut_roll *roll, const struct nesting_place *place,
                     char title[CUT_TEXT_SIZE]);

/* "5 patterns on 3.2 x 1.27 m of roll, warp along it; cloth 3.1 m2, utilisation 76.3 %, waste 23.7
 * %; revision ...": of one roll, or with NULL of all. Of all it also says what is left out. */
void cut_sheet_summary(const struct cut_sheet *sheet, const struct cut_roll *roll,
                       char summary[CUT_TEXT_SIZE]);

/* The pieces by the conventions of ASTM D6673 and AAMA: DXF R12 in millimetres. */
void cut_sheet_write_astm(const struct cut_sheet *sheet, struct api_text *text);

/* The nested roll in HP-GL, whose unit is 0.025 mm; of a sheet with one roll. */
void cut_sheet_write_hpgl(const struct cut_sheet *sheet, struct api_text *text);

#endif
