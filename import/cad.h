/* SPDX-License-Identifier: MIT */
/* Reads STEP (AP203, AP214, AP242) and IGES with Open CASCADE. */
#ifndef CLI_IMPORT_CAD_H
#define CLI_IMPORT_CAD_H

#include "part.h"
#include <cstddef>

namespace drape {

/* What is wanted of a file. */
struct selection {
    std::string unit;               /* "" or the unit of a file that states none */
    std::vector<int> faces;         /* their numbers, rising; none: all */
    bool measured;                  /* areas, boxes, centres and normals are asked for */
    std::vector<std::string> notes; /* that come before those of the file */
};

/* Faces beyond this many are refused unless they are selected. */
enum { FACES_MAX = 20000 };

enum class cad_format { step, iges };

/* The faces of the bytes of a file, numbered from 0 in the order of the file, with every instance
 * of an assembly in its place, as they are in the file: none is moved to meet another.
 * Throws `unreadable`. Reads no other file. */
part cad_read(cad_format format, const char *bytes, size_t length, const selection &wanted);

} // namespace drape

#endif
