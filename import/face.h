/* SPDX-License-Identifier: MIT */
/* One face of a shape as NURBS with trims. */
#ifndef CLI_IMPORT_FACE_H
#define CLI_IMPORT_FACE_H

#include "part.h"
#include <TopoDS_Face.hxx>

namespace drape {

/* Makes the face. Planes, cylinders, cones, spheres, tori and surfaces of revolution become
 * rational; their trim curves are carried along in closed form, to 1e-9 of the domain. `faults`
 * gets what is wrong with it; throws `unreadable` with the end of a sentence that begins with the
 * face when nothing can be made of it. */
face face_make(const TopoDS_Face &shape, std::vector<fault> &faults);

} // namespace drape

#endif
