/* SPDX-License-Identifier: MIT */
/* The courses of a ply as a document has them, and what became of them. */
#ifndef API_LAMINATE_COURSES_H
#define API_LAMINATE_COURSES_H

#include "api/json/text.h"
#include "api/json/value.h"
#include "laminate.h"

/* `courses` of a ply (`docs/laminates.md`), `json`, whose cloth is decoded, in the arena; NULL
 * without memory. Faults: also of what the ply must not have beside them. */
struct laminate_courses *courses_decode(const struct json_value *json, const struct json_value *ply,
                                        const struct api_request *cloth);

/* The member as it was understood. */
void courses_normalise(struct api_text *text, const struct laminate_courses *courses);

/* A laminate of one ply of the cloth of a drape, laid so, as JSON; NULL without memory. */
const char *courses_document(const struct api_request *drape, const struct courses_settings *lay,
                             struct arena *arena);

/* `course` of a piece: its figures by name, those that are NaN left out; and back. */
void courses_write_figures(struct api_text *text, const double figures[COURSE_FIGURES]);
void courses_decode_figures(const struct json_value *json, double figures[COURSE_FIGURES]);

/* Of all courses of a ply: areas and coverage summed, of angles the greatest, of the stagger the
 * least; the rest NaN. */
void courses_sum_up(const struct laminate_pieces *pieces, double sums[COURSE_FIGURES]);

#endif
