/* SPDX-License-Identifier: MIT */
/* The pattern as a drawing within another document: an <svg> element of the size that it is given
 * there, with the cut's length and width in place of the title. */
#ifndef API_FORMAT_SVG_H
#define API_FORMAT_SVG_H

#include "pattern.h"

extern const struct pattern_pen svg_inset;

#endif
