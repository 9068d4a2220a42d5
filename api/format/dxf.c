/* SPDX-License-Identifier: MIT */
/* The pattern in DXF. */
#include "dxf_writer.h"
#include "pattern.h"

static void head(struct api_text *text, const struct pattern_sheet *sheet,
                 const struct api_unit *unit) {
    static const struct dxf_layer layers[] = {{"CUT", DXF_WHITE},     {"ALLOWANCE", DXF_BLUE},
                                              {"NOTCH", DXF_MAGENTA}, {"START", DXF_GREEN},
                                              {"LOCKED", DXF_RED},    {"TITLE", DXF_WHITE}};
    const double low[2] = {sheet->low[0], sheet->low[1] - 7 * sheet->letter};
    dxf_head(text, unit->name, low, sheet->high, layers, sizeof layers / sizeof *layers);
}

static const char *const shape_layers[] = {
    [PATTERN_ALLOWANCE] = "ALLOWANCE", [PATTERN_CUT] = "CUT"};

static void begin_polygon(struct api_text *text, enum pattern_shape shape) {
    dxf_begin_polygon(text, shape_layers[shape]);
}

static void corner(struct api_text *text, enum pattern_shape shape, double x, double y) {
    dxf_corner(text, shape_layers[shape], x, y);
}

static void end_polygon(struct api_text *text, enum pattern_shape shape) {
    dxf_end_polygon(text, shape_layers[shape]);
}

/* Layers need no brackets. */
static void no_shape(struct api_text *text, enum pattern_shape shape) {
    (void)text;
    (void)shape;
}

static void no_group(struct api_text *text) {
    (void)text;
}

/* R12 has no hatches: a diagonal in every cell. */
static void locked(struct api_text *text, const struct pattern_sheet *sheet, int i, int j,
                   int count) {
    for (int k = i; k < i + count; k++)
        dxf_line(text, "LOCKED", k * sheet->step[0], j * sheet->step[1], (k + 1) * sheet->step[0],
                 (j + 1) * sheet->step[1]);
}

static void notch(struct api_text *text, double x, double y, double to_x, double to_y) {
    dxf_line(text, "NOTCH", x, y, to_x, to_y);
}

static void foot(struct api_text *text, const struct pattern_sheet *sheet) {
    double h = sheet->letter, left = sheet->low[0], bottom = sheet->low[1];
    dxf_circle(text, "START", 0, 0, h / 2);
    dxf_line(text, "START", -h, 0, h, 0);
    dxf_line(text, "START", 0, -h, 0, h);
    dxf_line(text, "START", 0, 0, 8 * h, 0);
    dxf_line(text, "START", 7 * h, h / 2, 8 * h, 0);
    dxf_line(text, "START", 7 * h, -h / 2, 8 * h, 0);
    dxf_line(text, "START", 0, 0, 0, 8 * h);
    dxf_line(text, "START", h / 2, 7 * h, 0, 8 * h);
    dxf_line(text, "START", -h / 2, 7 * h, 0, 8 * h);
    dxf_letters(text, "START", 8.5 * h, 0, h, "warp");
    dxf_letters(text, "START", h, 8 * h, h, "weft");
    dxf_letters(text, "TITLE", left, bottom - 2.5 * h, 1.4 * h, sheet->title);
    dxf_letters(text, "TITLE", left, bottom - 4.5 * h, h, sheet->subtitle);
    dxf_line(text, "TITLE", left, bottom - 7 * h, left + sheet->bar, bottom - 7 * h);
    for (int k = 0; k <= 10; k++) {
        double x = left + k * sheet->bar / 10;
        dxf_line(text, "TITLE", x, bottom - 7 * h, x, bottom - (k % 5 ? 6.5 : 6) * h);
    }
    dxf_letters(text, "TITLE", left + sheet->bar + h, bottom - 7 * h, h, sheet->bar_label);
    dxf_foot(text);
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
