/* SPDX-License-Identifier: MIT */
/*
 * All that leaves the house of a laminate in one zip, under its revision: the request, the ply
 * book, patterns, what cutters and laser projectors read, of every drape its request and result,
 * and in `decks/` the stack on a mesh in every format there is. A manifest, the last entry, has the
 * SHA-256 of every file, and says which documents could not be written, and why. Same content, same
 * bytes.
 */
#ifndef API_LAMINATE_BUNDLE_H
#define API_LAMINATE_BUNDLE_H

#include "patterns.h"

/*
 * Writes it of a laminate that is resolved, one document after the other: each is in memory as long
 * as it is written. Decks are on triangles on the part, or on those that the part is of. API_OK;
 * API_INVALID_REQUEST where there is nothing to draw; API_INTERNAL, API_OUT_OF_MEMORY,
 * API_UNAVAILABLE (the sink refuses).
 */
enum api_problem_id laminate_bundle(const struct laminate *laminate,
                                    const struct api_reader *const *nets,
                                    const struct laminate_roll *ask, const struct api_sink *sink,
                                    struct arena *arena,
                                    struct api_problem *problem) STATUS_MUST_USE;

#endif
