/* SPDX-License-Identifier: MIT */
/* The cuts of a stored result, as documents say them. */
#ifndef API_RESULT_STORED_CUTS_H
#define API_RESULT_STORED_CUTS_H

#include "columns.h"

/* A row of the table `cuts`; lengths in the result's unit, the name in its header. */
struct stored_cut {
    const char *name;
    double length, tip_angle_deg, mouth_width, area, covered, allowance;
};

/* Reads all `cut_count` of them; false when the stored result is damaged. */
bool stored_cuts_read(const struct api_reader *reader, const struct api_columns *columns,
                      struct stored_cut cuts[API_CUTS_MAX]) STATUS_MUST_USE;

/* "corner: 60 mm long, a dart of 90 degrees at its tip, 84.85 mm wide at its mouth, 1800 mm2 cut
 * out"; "slit: 30 mm long, a slit", "slit: 30 mm long, not covered"; what is below 0 is said to
 * overlap. */
enum { STORED_CUT_TEXT = 240 };
void stored_cut_describe(const struct stored_cut *cut, const char *unit,
                         char text[STORED_CUT_TEXT]);

#endif
