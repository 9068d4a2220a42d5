/* SPDX-License-Identifier: MIT */
/* The seams between the pieces of a ply: how the yarns of both sides meet, and where cloth lies
 * twice or is lacking. */
#ifndef API_LAMINATE_SEAMS_H
#define API_LAMINATE_SEAMS_H

#include "api/json/text.h"
#include "flat_plies.h"

struct seam {
    size_t piece[2]; /* of the ply, from 0 */
    double length;   /* of the splits between them, along the part */
    double mean_deg; /* angle between the warps of both sides, 0..90, by length */
    double greatest_deg;
    double overlap_area;             /* of cloth beyond the split, before shear */
    double gap_area;                 /* of cloth that is cut off before it, alike */
    double overlap_width, gap_width; /* their mean widths on the part */
};

/* The seams of the ply that the shape `first` is the first piece of, pieces by their numbers, in
 * the arena. */
enum api_problem_id seams_make(const struct laminate *laminate, const struct flat_plies *shapes,
                               size_t first, struct arena *arena, const struct seam **seams,
                               size_t *count, struct api_problem *problem) STATUS_MUST_USE;

/* A seam as an object of JSON: pieces by name, length, mean_angle_deg, greatest_angle_deg,
 * overlap_area, gap_area, overlap_width, gap_width. */
void seams_write(const struct laminate_pieces *pieces, const struct seam *seam,
                 struct api_text *text);

#endif
