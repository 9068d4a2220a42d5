/* SPDX-License-Identifier: MIT */
/* Surfaces of a degree that no surface of a request may have, with a lower one. */
#ifndef CLI_IMPORT_DEGREE_H
#define CLI_IMPORT_DEGREE_H

#include <Geom_BSplineSurface.hxx>

namespace drape {

/* The surface with no degree above `most`, 6 to 24, over the same parameters, in spans short enough
 * to leave it by less than 1e-9 of its size; periodic ones are cut open at their seam. `by` gets
 * how far, at most, they are apart: 0 where nothing had to be done. NULL where spans would have to
 * be very short, as with weights next to nothing. */
Handle(Geom_BSplineSurface)
    limit_degree(const Handle(Geom_BSplineSurface) & surface, int most, double &by);

} // namespace drape

#endif
