/* SPDX-License-Identifier: MIT */
#include "dxf_writer.h"

#include "pattern.h"
#include <string.h>

static void write_number(struct api_text *text, int code, double value) {
    api_text_format(text, "%d\n", code);
    pattern_number(text, value);
    api_text_raw(text, "\n");
}

/* The point whose coordinates have the codes `code` and `code` + 10. */
static void write_xy(struct api_text *text, int code, double x, double y) {
    write_number(text, code, x);
    write_number(text, code + 10, y);
}

void dxf_head(struct api_text *text, const char *unit, const double low[2], const double high[2],
              const struct dxf_layer *layers, int count) {
    static const struct {
        const char *name;
        int number; /* of $INSUNITS */
    } units[] = {{"in", 1}, {"ft", 2}, {"mm", 4}, {"cm", 5}, {"m", 6}, {"um", 13}};
    int number = 0;
    for (size_t k = 0; k < sizeof units / sizeof *units; k++)
        if (strcmp(units[k].name, unit) == 0)
            number = units[k].number;
    api_text_format(text,
                    "0\nSECTION\n2\nHEADER\n9\n$ACADVER\n1\nAC1009\n9\n$INSUNITS\n70\n%d\n"
                    "9\n$MEASUREMENT\n70\n%d\n9\n$EXTMIN\n",
                    number, number > 2); /* 0 for inch and foot */
    write_xy(text, 10, low[0], low[1]);
    api_text_raw(text, "30\n0\n9\n$EXTMAX\n");
    write_xy(text, 10, high[0], high[1]);
    api_text_format(text,
                    "30\n0\n0\nENDSEC\n0\nSECTION\n2\nTABLES\n0\nTABLE\n2\nLTYPE\n70\n1\n"
                    "0\nLTYPE\n2\nCONTINUOUS\n70\n0\n3\nSolid line\n72\n65\n73\n0\n40\n0\n"
                    "0\nENDTAB\n0\nTABLE\n2\nLAYER\n70\n%d\n",
                    count);
    for (int k = 0; k < count; k++)
        api_text_format(text, "0\nLAYER\n2\n%s\n70\n0\n62\n%d\n6\nCONTINUOUS\n", layers[k].name,
                        layers[k].colour);
    api_text_raw(text, "0\nENDTAB\n0\nENDSEC\n");
}

void dxf_section(struct api_text *text, const char *name) {
    api_text_format(text, "0\nSECTION\n2\n%s\n", name);
}

void dxf_section_end(struct api_text *text) {
    api_text_raw(text, "0\nENDSEC\n");
}

void dxf_foot(struct api_text *text) {
    api_text_raw(text, "0\nEOF\n");
}

void dxf_block(struct api_text *text, const char *layer, const char *name) {
    api_text_format(text, "0\nBLOCK\n8\n%s\n2\n%s\n70\n0\n10\n0\n20\n0\n30\n0\n3\n%s\n", layer,
                    name, name);
}

void dxf_block_end(struct api_text *text, const char *layer) {
    api_text_format(text, "0\nENDBLK\n8\n%s\n", layer);
}

void dxf_insert(struct api_text *text, const char *layer, const char *name, double x, double y,
                double degrees) {
    api_text_format(text, "0\nINSERT\n8\n%s\n2\n%s\n", layer, name);
    write_xy(text, 10, x, y);
    write_number(text, 50, degrees);
}

void dxf_line(struct api_text *text, const char *layer, double x, double y, double to_x,
              double to_y) {
    api_text_format(text, "0\nLINE\n8\n%s\n", layer);
    write_xy(text, 10, x, y);
    write_xy(text, 11, to_x, to_y);
}

void dxf_point(struct api_text *text, const char *layer, double x, double y, double z,
               double degrees) {
    api_text_format(text, "0\nPOINT\n8\n%s\n", layer);
    write_xy(text, 10, x, y);
    write_number(text, 30, z);
    write_number(text, 50, degrees);
}

void dxf_circle(struct api_text *text, const char *layer, double x, double y, double radius) {
    api_text_format(text, "0\nCIRCLE\n8\n%s\n", layer);
    write_xy(text, 10, x, y);
    write_number(text, 40, radius);
}

void dxf_letters(struct api_text *text, const char *layer, double x, double y, double height,
                 const char *string) {
    api_text_format(text, "0\nTEXT\n8\n%s\n", layer);
    write_xy(text, 10, x, y);
    write_number(text, 40, height);
    api_text_format(text, "1\n%s\n", string);
}

/* A polyline is closed by bit 1 of group 70; that its vertices follow is group 66. */
void dxf_corner(struct api_text *text, const char *layer, double x, double y, bool first,
                bool last) {
    if (first)
        api_text_format(text, "0\nPOLYLINE\n8\n%s\n66\n1\n70\n1\n10\n0\n20\n0\n30\n0\n", layer);
    api_text_format(text, "0\nVERTEX\n8\n%s\n", layer);
    write_xy(text, 10, x, y);
    api_text_raw(text, "30\n0\n");
    if (last)
        api_text_format(text, "0\nSEQEND\n8\n%s\n", layer);
}
