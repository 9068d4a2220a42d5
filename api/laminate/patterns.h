/* SPDX-License-Identifier: MIT */
/*
 * What is cut and laid: of every ply its layers, each as it lies on its cloth up to the rim and
 * within its boundary, the warp along the roll. Plies of different cloths are on different rolls of
 * one width; on each the patterns are nested (`nesting.h`), and what is used of it is said. All
 * documents bear the revision of the laminate.
 */
#ifndef API_LAMINATE_PATTERNS_H
#define API_LAMINATE_PATTERNS_H

#include "api/result/columns.h"
#include "api/sink.h"
#include "flat_plies.h"
#include "laminate.h"

struct laminate_roll {
    double width;     /* of the roll in the laminate's unit; 0: as wide as the widest pattern */
    double gap;       /* between patterns */
    bool straight;    /* no pattern is turned by half a turn */
    int number;       /* of the roll that is wanted, from 1; 0: all */
    bool partial;     /* for machines, too, plies that leave some of what they are to cover bare */
    double tolerance; /* of lines for lasers, in the laminate's unit; 0: LASER_TOLERANCE */
};

/* Sets the option that a query parameter or a flag `name` (width, gap, turn, roll, partial,
 * tolerance) stands for. False with `problem` set, which names the option, when `value` is not in
 * its range; false with `problem` unset when there is no option of that name. */
bool laminate_roll_option(struct laminate_roll *roll, const char *name, const char *value,
                          struct api_problem *problem);

/* How many cloths its plies are of. */
size_t laminate_cloths(const struct laminate *laminate);

/*
 * Writes the patterns of a laminate that is resolved, or of one ply (from 0) or LAMINATE_ALL, as
 * `format`: "dxf" (layers CUT and NAME, in the laminate's unit), "svg" (millimetres), "astm" and
 * "hpgl" (`cut_sheet.h`), "html", the ply book (`ply_book.h`), "json", its account (`account.h`),
 * or what a laser projector draws, "laser", "laser-csv" and "virtek" (`laser.h`), or "bundle", all
 * of it (`bundle.h`). `nets` as for a map; plies without a net are left out. API_OK,
 * API_INVALID_REQUEST (a roll that is too narrow, no ply, a boundary that cannot be followed, a ply
 * with bare places for a machine, several rolls in a format that has one), API_INTERNAL,
 * API_OUT_OF_MEMORY or API_UNAVAILABLE (the sink refuses).
 */
enum api_problem_id laminate_patterns(const struct laminate *laminate,
                                      const struct api_reader *const *nets, int ply,
                                      const char *format, const struct laminate_roll *roll,
                                      const struct api_sink *sink, struct arena *arena,
                                      struct api_problem *problem) STATUS_MUST_USE;

#endif
