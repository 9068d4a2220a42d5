/* SPDX-License-Identifier: MIT */
#include "dxf_writer.h"

#include "pattern.h"
#include <string.h>

static void group(struct api_text *text, int code, const char *value) {
    api_text_integer(text, code);
    api_text_raw(text, "\n");
    api_text_raw(text, value);
    api_text_raw(text, "\n");
}

static void group_integer(struct api_text *text, int code, int value) {
    api_text_integer(text, code);
    api_text_raw(text, "\n");
    api_text_integer(text, value);
    api_text_raw(text, "\n");
}

static void group_number(struct api_text *text, int code, double value) {
    api_text_integer(text, code);
    api_text_raw(text, "\n");
    pattern_number(text, value);
    api_text_raw(text, "\n");
}

/* The point whose coordinates have the codes `code` and `code` + 10. */
static void group_point(struct api_text *text, int code, double x, double y) {
    group_number(text, code, x);
    group_number(text, code + 10, y);
}

static void entity(struct api_text *text, const char *kind, const char *layer) {
    group(text, 0, kind);
    group(text, 8, layer);
}

static void section(struct api_text *text, const char *name) {
    group(text, 0, "SECTION");
    group(text, 2, name);
}

static void table(struct api_text *text, const char *name, int entries) {
    group(text, 0, "TABLE");
    group(text, 2, name);
    group_integer(text, 70, entries);
}

static void layer_entry(struct api_text *text, const struct dxf_layer *layer) {
    group(text, 0, "LAYER");
    group(text, 2, layer->name);
    group_integer(text, 70, 0);
    group_integer(text, 62, layer->colour);
    group(text, 6, "CONTINUOUS");
}

static void tables(struct api_text *text, const struct dxf_layer *layers, int count) {
    section(text, "TABLES");
    table(text, "LTYPE", 1);
    group(text, 0, "LTYPE");
    group(text, 2, "CONTINUOUS");
    group_integer(text, 70, 0);
    group(text, 3, "Solid line");
    group_integer(text, 72, 65);
    group_integer(text, 73, 0);
    group_number(text, 40, 0);
    group(text, 0, "ENDTAB");
    table(text, "LAYER", count);
    for (int k = 0; k < count; k++)
        layer_entry(text, &layers[k]);
    group(text, 0, "ENDTAB");
    group(text, 0, "ENDSEC");
}

/* The number that $INSUNITS has for a unit. */
static int unit_number(const char *name) {
    static const struct {
        const char *name;
        int number;
    } units[] = {{"in", 1}, {"ft", 2}, {"mm", 4}, {"cm", 5}, {"m", 6}, {"um", 13}};
    for (size_t k = 0; k < sizeof units / sizeof *units; k++)
        if (strcmp(units[k].name, name) == 0)
            return units[k].number;
    return 0;
}

void dxf_head(struct api_text *text, const char *unit, const double low[2], const double high[2],
              const struct dxf_layer *layers, int count) {
    int number = unit_number(unit);
    section(text, "HEADER");
    group(text, 9, "$ACADVER");
    group(text, 1, "AC1009");
    group(text, 9, "$INSUNITS");
    group_integer(text, 70, number);
    group(text, 9, "$MEASUREMENT");
    group_integer(text, 70, number > 2); /* 0 for inch and foot */
    group(text, 9, "$EXTMIN");
    group_point(text, 10, low[0], low[1]);
    group_number(text, 30, 0);
    group(text, 9, "$EXTMAX");
    group_point(text, 10, high[0], high[1]);
    group_number(text, 30, 0);
    group(text, 0, "ENDSEC");
    tables(text, layers, count);
    section(text, "ENTITIES");
}

void dxf_foot(struct api_text *text) {
    group(text, 0, "ENDSEC");
    group(text, 0, "EOF");
}

void dxf_line(struct api_text *text, const char *layer, double x, double y, double to_x,
              double to_y) {
    entity(text, "LINE", layer);
    group_point(text, 10, x, y);
    group_point(text, 11, to_x, to_y);
}

void dxf_circle(struct api_text *text, const char *layer, double x, double y, double radius) {
    entity(text, "CIRCLE", layer);
    group_point(text, 10, x, y);
    group_number(text, 40, radius);
}

void dxf_letters(struct api_text *text, const char *layer, double x, double y, double height,
                 const char *string) {
    entity(text, "TEXT", layer);
    group_point(text, 10, x, y);
    group_number(text, 40, height);
    group(text, 1, string);
}

void dxf_begin_polygon(struct api_text *text, const char *layer) {
    entity(text, "POLYLINE", layer);
    group_integer(text, 66, 1); /* vertices follow */
    group_integer(text, 70, 1); /* closed */
    group_point(text, 10, 0, 0);
    group_number(text, 30, 0);
}

void dxf_corner(struct api_text *text, const char *layer, double x, double y) {
    entity(text, "VERTEX", layer);
    group_point(text, 10, x, y);
    group_number(text, 30, 0);
}

void dxf_end_polygon(struct api_text *text, const char *layer) {
    entity(text, "SEQEND", layer);
}
