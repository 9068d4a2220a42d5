/* SPDX-License-Identifier: MIT */
/*
 * The flat cut patterns of a stack: of every ply its layers, each as it lies on its cloth up to the
 * rim and within its boundary, the warp along the roll. They are laid on shelves across a roll of
 * a given width, the highest first, and never turned, so that the yarns run as they should; what is
 * wasted of the roll is said.
 */
#ifndef API_LAMINATE_PATTERNS_H
#define API_LAMINATE_PATTERNS_H

#include "api/result/columns.h"
#include "api/sink.h"
#include "flat_plies.h"
#include "laminate.h"

struct laminate_roll {
    double width; /* of the roll in the laminate's unit; 0: as wide as the widest pattern */
    double gap;   /* between patterns */
    bool partial; /* dxf of plies that leave some of what they are to cover bare, too */
};

/*
 * Writes the patterns of a laminate that is resolved, or of one ply (from 0) or LAMINATE_ALL, as
 * `format`: "dxf" (layers CUT and NAME, in the laminate's unit), "svg" (millimetres) or "html", the
 * ply book (`ply_book.h`). `nets` as for a map; plies without a net are left out. API_OK,
 * API_INVALID_REQUEST (a roll that is too narrow, no ply, a boundary that cannot be followed),
 * API_INTERNAL, API_OUT_OF_MEMORY or API_UNAVAILABLE (the sink refuses).
 */
enum api_problem_id laminate_patterns(const struct laminate *laminate,
                                      const struct api_reader *const *nets, int ply,
                                      const char *format, const struct laminate_roll *roll,
                                      const struct api_sink *sink, struct arena *arena,
                                      struct api_problem *problem) STATUS_MUST_USE;

#endif
