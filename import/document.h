/* SPDX-License-Identifier: MIT */
/* A part as the documents that the importer writes. */
#ifndef CLI_IMPORT_DOCUMENT_H
#define CLI_IMPORT_DOCUMENT_H

#include "part.h"

namespace drape {

/* The surface that the service takes: faces, tolerance, length_unit, notes. */
std::string document_surface(const part &part);

/* What the file holds, without geometry: unit, area, box, and of each face number, area, box,
 * centre, normal, kind, name and colour; the edges; the notes. */
std::string document_list(const part &part);

} // namespace drape

#endif
