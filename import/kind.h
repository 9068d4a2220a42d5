/* SPDX-License-Identifier: MIT */
/* What some bytes are, where they are not the file that they were called. */
#ifndef CLI_IMPORT_KIND_H
#define CLI_IMPORT_KIND_H

#include <cstddef>
#include <string>

namespace drape {

/* The words of an ISO 10303-21 file, somewhere in its beginning. */
bool kind_is_step(const char *bytes, size_t length);

/* The 73rd column of each line has the letter of its section: S in the first. */
bool kind_is_iges(const char *bytes, size_t length);

/* Why bytes are not a file of the format `wanted` ("STEP", "IGES"), with what they are and what to
 * do where their beginning tells. */
std::string kind_refusal(const char *wanted, const char *bytes, size_t length);

/* What a STEP file without faces holds that is draped in another way, as the end of a sentence; ""
 * where nothing is known. */
const char *kind_of_faceless(const char *bytes, size_t length);

/* Whether the beginning is that of something else for certain, whatever follows. */
bool kind_is_foreign(const char *bytes, size_t length);

} // namespace drape

#endif
