/* SPDX-License-Identifier: MIT */
/*
 * A line that is given by points of a part, straight between them in space, as a line along the
 * part. Where a straight piece runs further from the part than wanted its middle is moved to the
 * nearest place of the part, and so are those of both halves.
 *
 * On a sphere the line becomes the great circle between its points; over an edge of a box it goes
 * up one side and down the other.
 */
#ifndef SOLVER_LAID_LINE_H
#define SOLVER_LAID_LINE_H

#include "arena.h"
#include "settings.h"
#include "status.h"
#include <stdbool.h>

/* A part to lay lines on: `nearest` gives the place of it nearest to `r` and the unit normal there,
 * or false where there is none. */
struct laid_line_part {
    bool (*nearest)(const void *context, struct vec3 r, struct vec3 *place, struct vec3 *normal);
    const void *context;
};

/* The line, whose pieces are within `reach` of the part (a length above 0); its points are of the
 * arena. A piece that cannot be laid, for it is no chord of the part but leads off it or over a
 * hole, stays as it was. Errors: STATUS_OUT_OF_MEMORY. */
enum status laid_line_make(const struct laid_line_part *part, const struct drape_cut_line *asked,
                           double reach, struct arena *arena,
                           struct drape_cut_line *line) STATUS_MUST_USE;

/* Whether a line crosses itself, or comes back to within `within` of itself, and where then. A
 * corner of more than some 6 degrees is no return, nor is the end of a line that is its first
 * point. Points that follow each other are different ones. */
bool laid_line_meets_itself(const struct drape_cut_line *line, double within, struct vec3 *at);

#endif
