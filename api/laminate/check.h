/* SPDX-License-Identifier: MIT */
/*
 * What can be said of a laminate before anything is draped, and what a service keeps of it. Its
 * record is text: of each ply a line with the number of its drape and its name, an empty line, and
 * the laminate as it was understood. Of a ply of several pieces there is a line for each, with a
 * tab and the name of the piece behind that of the ply, which only the first has.
 */
#ifndef API_LAMINATE_CHECK_H
#define API_LAMINATE_CHECK_H

#include "api/check.h"
#include "api/map/map.h"

/*
 * Checks a laminate as `api_check_drape` does a drape, every one of its drapes included. Writes a
 * line with the number of drapes and the length of the record, of each drape a line with its
 * digest and the length of its request, an empty line, the requests and the record.
 */
enum api_problem_id laminate_check(const struct api_input *input, const struct api_limits *limits,
                                   const struct api_sink *sink, struct api_check *check,
                                   struct api_problem *problem) STATUS_MUST_USE;

/*
 * Maps a stored laminate. `columns` has the results of its drapes: their number as a uint64_t, of
 * each its length (0: there is none), and one after the other.
 */
enum api_problem_id laminate_map_record(const char *record, size_t length, const char *columns,
                                        size_t columns_length, const struct api_limits *limits,
                                        const struct map_target *target,
                                        const struct drape_monitor *monitor, struct arena *arena,
                                        struct api_map *map,
                                        struct api_problem *problem) STATUS_MUST_USE;

/* Writes the patterns of a stored laminate (`patterns.h`); `options` are pairs of a name and a
 * value, zero-terminated: width, gap. */
enum api_problem_id laminate_pattern_record(const char *record, size_t length, const char *columns,
                                            size_t columns_length, const struct api_limits *limits,
                                            int ply, const char *format, const char *options,
                                            size_t options_length, const struct api_sink *sink,
                                            struct arena *arena,
                                            struct api_problem *problem) STATUS_MUST_USE;

#endif
