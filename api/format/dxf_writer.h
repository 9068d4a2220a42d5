/* SPDX-License-Identifier: MIT */
/* DXF of release 12 in ASCII: lines in pairs, a group code and its value. A document is the head,
 * entities on its layers, and the foot. */
#ifndef API_FORMAT_DXF_WRITER_H
#define API_FORMAT_DXF_WRITER_H

#include "api/json/text.h"

enum {
    DXF_RED = 1,
    DXF_YELLOW = 2,
    DXF_GREEN = 3,
    DXF_CYAN = 4,
    DXF_BLUE = 5,
    DXF_MAGENTA = 6,
    DXF_WHITE = 7
};

struct dxf_layer {
    const char *name;
    int colour;
};

/* In that unit, a name of `length_unit`; the drawing lies between `low` and `high`. Sections come
 * next, "BLOCKS" if there are any and "ENTITIES", each with its end. */
void dxf_head(struct api_text *text, const char *unit, const double low[2], const double high[2],
              const struct dxf_layer *layers, int count);
void dxf_section(struct api_text *text, const char *name);
void dxf_section_end(struct api_text *text);
void dxf_foot(struct api_text *text);

/* A block, whose entities come next up to its end, and one of its places: turned by so many
 * degrees. */
void dxf_block(struct api_text *text, const char *layer, const char *name);
void dxf_block_end(struct api_text *text, const char *layer);
void dxf_insert(struct api_text *text, const char *layer, const char *name, double x, double y,
                double degrees);

void dxf_line(struct api_text *text, const char *layer, double x, double y, double to_x,
              double to_y);
/* A point with a z and the angle of its mark in degrees. */
void dxf_point(struct api_text *text, const char *layer, double x, double y, double z,
               double degrees);
void dxf_circle(struct api_text *text, const char *layer, double x, double y, double radius);
void dxf_letters(struct api_text *text, const char *layer, double x, double y, double height,
                 const char *string);

/* A corner of a closed polygon, whose corners follow each other. */
void dxf_corner(struct api_text *text, const char *layer, double x, double y, bool first,
                bool last);

#endif
