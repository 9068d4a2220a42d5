/* SPDX-License-Identifier: MIT */
/* DXF of release 12 in ASCII: lines in pairs, a group code and its value. A document is the head,
 * entities on its layers, and the foot. */
#ifndef API_FORMAT_R12_H
#define API_FORMAT_R12_H

#include "api/json/text.h"

enum { R12_RED = 1, R12_GREEN = 3, R12_BLUE = 5, R12_MAGENTA = 6, R12_WHITE = 7 };

struct r12_layer {
    const char *name;
    int colour;
};

/* In that unit, a name of `length_unit`; the drawing lies between `low` and `high`. The entities
 * come next. */
void r12_head(struct api_text *text, const char *unit, const double low[2], const double high[2],
              const struct r12_layer *layers, int count);
void r12_foot(struct api_text *text);

void r12_line(struct api_text *text, const char *layer, double x, double y, double to_x,
              double to_y);
void r12_circle(struct api_text *text, const char *layer, double x, double y, double radius);
void r12_letters(struct api_text *text, const char *layer, double x, double y, double height,
                 const char *string);

/* A closed polygon: its begin, corners and end. */
void r12_begin_polygon(struct api_text *text, const char *layer);
void r12_corner(struct api_text *text, const char *layer, double x, double y);
void r12_end_polygon(struct api_text *text, const char *layer);

#endif
