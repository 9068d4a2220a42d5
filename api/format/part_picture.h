/* SPDX-License-Identifier: MIT */
/*
 * The draped part as a picture: the cells coloured by their shear up to the rim, those beyond the
 * locking angle hatched, some yarns, the generators and the rim. It is a parallel projection, seen
 * from the side that warp x weft points to, the warp to the right and the weft away from the eye;
 * of a part that closes on itself the side of its start.
 */
#ifndef API_FORMAT_PART_PICTURE_H
#define API_FORMAT_PART_PICTURE_H

#include "api/result/columns.h"
#include "raster.h"

enum { PICTURE_SHADES = 100 };

struct part_picture {
    struct raster raster;
    double range_deg; /* the shear that has the last colour */
    double scale;     /* pixels of a length unit, at right angles to the view */
    double start[2];  /* its pixel, and those of the ends of the generators */
    double end[2][2];
    int yarns; /* every how many are drawn */
};

/* Draws what `picture` (zero-initialised) is to hold. API_OUT_OF_MEMORY, or API_INTERNAL for a
 * damaged result. raster_free of its raster in any case. */
enum api_problem_id part_picture_draw(struct part_picture *picture, const struct api_reader *reader,
                                      const struct api_columns *columns,
                                      struct api_problem *problem) STATUS_MUST_USE;

/* The colour of a shear of 0..1 of the range, as in a palette. */
void part_picture_colour(double share, uint8_t rgb[3]);

#endif
