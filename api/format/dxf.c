/* SPDX-License-Identifier: MIT */
/* The pattern in DXF, R12 in ASCII: lines in pairs, a group code and its value. */
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

static void layer(struct api_text *text, const char *name, int colour) {
    group(text, 0, "LAYER");
    group(text, 2, name);
    group_integer(text, 70, 0);
    group_integer(text, 62, colour);
    group(text, 6, "CONTINUOUS");
}

static void tables(struct api_text *text) {
    enum { WHITE = 7, RED = 1, GREEN = 3, BLUE = 5, MAGENTA = 6 };
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
    table(text, "LAYER", 6);
    layer(text, "CUT", WHITE);
    layer(text, "ALLOWANCE", BLUE);
    layer(text, "NOTCH", MAGENTA);
    layer(text, "START", GREEN);
    layer(text, "LOCKED", RED);
    layer(text, "TITLE", WHITE);
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

static void head(struct api_text *text, const struct pattern_sheet *sheet,
                 const struct api_unit *unit) {
    int number = unit_number(unit->name);
    section(text, "HEADER");
    group(text, 9, "$ACADVER");
    group(text, 1, "AC1009");
    group(text, 9, "$INSUNITS");
    group_integer(text, 70, number);
    group(text, 9, "$MEASUREMENT");
    group_integer(text, 70, number > 2); /* 0 for inch and foot */
    group(text, 9, "$EXTMIN");
    group_point(text, 10, sheet->low[0], sheet->low[1] - 7 * sheet->letter);
    group_number(text, 30, 0);
    group(text, 9, "$EXTMAX");
    group_point(text, 10, sheet->high[0], sheet->high[1]);
    group_number(text, 30, 0);
    group(text, 0, "ENDSEC");
    tables(text);
    section(text, "ENTITIES");
}

static const char *const shape_layers[] = {
    [PATTERN_ALLOWANCE] = "ALLOWANCE", [PATTERN_CUT] = "CUT"};

static void begin_polygon(struct api_text *text, enum pattern_shape shape) {
    entity(text, "POLYLINE", shape_layers[shape]);
    group_integer(text, 66, 1); /* vertices follow */
    group_integer(text, 70, 1); /* closed */
    group_point(text, 10, 0, 0);
    group_number(text, 30, 0);
}

static void corner(struct api_text *text, enum pattern_shape shape, double x, double y) {
    entity(text, "VERTEX", shape_layers[shape]);
    group_point(text, 10, x, y);
    group_number(text, 30, 0);
}

static void end_polygon(struct api_text *text, enum pattern_shape shape) {
    entity(text, "SEQEND", shape_layers[shape]);
}

/* Layers need no brackets. */
static void no_shape(struct api_text *text, enum pattern_shape shape) {
    (void)text;
    (void)shape;
}

static void no_group(struct api_text *text) {
    (void)text;
}

static void line(struct api_text *text, const char *layer_name, double x, double y, double to_x,
                 double to_y) {
    entity(text, "LINE", layer_name);
    group_point(text, 10, x, y);
    group_point(text, 11, to_x, to_y);
}

/* R12 has no hatches: a diagonal in every cell. */
static void locked(struct api_text *text, const struct pattern_sheet *sheet, int i, int j,
                   int count) {
    for (int k = i; k < i + count; k++)
        line(text, "LOCKED", k * sheet->step[0], j * sheet->step[1], (k + 1) * sheet->step[0],
             (j + 1) * sheet->step[1]);
}

static void notch(struct api_text *text, double x, double y, double to_x, double to_y) {
    line(text, "NOTCH", x, y, to_x, to_y);
}

static void letters(struct api_text *text, const char *layer_name, double x, double y,
                    double height, const char *string) {
    entity(text, "TEXT", layer_name);
    group_point(text, 10, x, y);
    group_number(text, 40, height);
    group(text, 1, string);
}

static void foot(struct api_text *text, const struct pattern_sheet *sheet) {
    double h = sheet->letter, left = sheet->low[0], bottom = sheet->low[1];
    entity(text, "CIRCLE", "START");
    group_point(text, 10, 0, 0);
    group_number(text, 40, h / 2);
    line(text, "START", -h, 0, h, 0);
    line(text, "START", 0, -h, 0, h);
    line(text, "START", 0, 0, 8 * h, 0);
    line(text, "START", 7 * h, h / 2, 8 * h, 0);
    line(text, "START", 7 * h, -h / 2, 8 * h, 0);
    line(text, "START", 0, 0, 0, 8 * h);
    line(text, "START", h / 2, 7 * h, 0, 8 * h);
    line(text, "START", -h / 2, 7 * h, 0, 8 * h);
    letters(text, "START", 8.5 * h, 0, h, "warp");
    letters(text, "START", h, 8 * h, h, "weft");
    letters(text, "TITLE", left, bottom - 2.5 * h, 1.4 * h, sheet->title);
    letters(text, "TITLE", left, bottom - 4.5 * h, h, sheet->subtitle);
    line(text, "TITLE", left, bottom - 7 * h, left + sheet->bar, bottom - 7 * h);
    for (int k = 0; k <= 10; k++) {
        double x = left + k * sheet->bar / 10;
        line(text, "TITLE", x, bottom - 7 * h, x, bottom - (k % 5 ? 6.5 : 6) * h);
    }
    letters(text, "TITLE", left + sheet->bar + h, bottom - 7 * h, h, sheet->bar_label);
    group(text, 0, "ENDSEC");
    group(text, 0, "EOF");
}

static const struct pattern_pen pen = {.metres = 0,
                                       .unit = NULL,
                                       .head = head,
                                       .begin_polygon = begin_polygon,
                                       .corner = corner,
                                       .end_polygon = end_polygon,
                                       .begin_shape = no_shape,
                                       .end_shape = no_shape,
                                       .begin_locked = no_group,
                                       .locked = locked,
                                       .begin_notches = no_group,
                                       .notch = notch,
                                       .foot = foot};

const struct format format_dxf = {.name = "dxf",
                                  .media_type = "image/vnd.dxf",
                                  .about = "the pattern in DXF R12, in the drape's unit",
                                  .exact = "12 digits",
                                  PATTERN_FORMAT(pen)};
