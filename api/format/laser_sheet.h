/* SPDX-License-Identifier: MIT */
/*
 * What a laser projector draws on the tool, one layer of cloth after the other as they are laid:
 * lines at the height of the stack below, as points with the normal of the tool there, by which a
 * projector knows whether it sees them. Lengths are in the sheet's unit.
 */
#ifndef API_FORMAT_LASER_SHEET_H
#define API_FORMAT_LASER_SHEET_H

#include "api/json/text.h"
#include "api/request/request.h"
#include "solver/vec.h"

struct laser_point {
    struct vec3 r;
    struct vec3 normal; /* unit, away from the tool */
    double height;      /* of r above the tool, along the normal */
};

enum laser_kind { LASER_EDGE, LASER_HOLE, LASER_WARP, LASER_KINDS };

struct laser_line {
    enum laser_kind kind;
    const struct laser_point *points; /* of an edge or a hole the last is the first */
    size_t count;
};

/* A layer of a ply, or of a piece of one. */
struct laser_layer {
    int ply, piece;    /* from 1; piece 0: the ply is of one */
    int layer, layers; /* of the ply, from 1 */
    const char *title;
    const struct laser_line *lines;
    size_t line_count;
};

struct laser_sheet {
    const struct api_unit *unit;
    const char *revision;             /* the digest of what it was made from */
    double tolerance;                 /* how far the lines are from curves, at the most */
    const struct laser_layer *layers; /* as they are laid */
    size_t layer_count;
};

/* One JSON object, every bit: of each point x, y, z, those of its normal, and its height. */
void laser_sheet_write_json(const struct laser_sheet *sheet, struct api_text *text);

/* A row for each point, likewise. */
void laser_sheet_write_csv(const struct laser_sheet *sheet, struct api_text *text);

/* A PLY file for Virtek's Iris, by the example in its specification of 2011: of each layer a
 * LAYER, of each line its points with normals between START and END, lines ended by CR LF. In
 * millimetres, with 4 digits behind the point; normals with 6. */
void laser_sheet_write_virtek(const struct laser_sheet *sheet, struct api_text *text);

#endif
