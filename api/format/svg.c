/* SPDX-License-Identifier: MIT */
/* The pattern in SVG: millimetres, weft up. The drawing is put upside down as a whole, so that its
 * numbers are those of the cloth; letters are turned back. */
#include "svg.h"

#include <stdio.h>

static void attribute(struct api_text *text, const char *name, double value) {
    api_text_raw(text, " ");
    api_text_raw(text, name);
    api_text_raw(text, "=\"");
    pattern_number(text, value);
    api_text_raw(text, "\"");
}

static void numbers(struct api_text *text, const char *before, double x, double y) {
    api_text_raw(text, before);
    pattern_number(text, x);
    api_text_raw(text, " ");
    pattern_number(text, y);
}

static void length(struct api_text *text, const char *name, double value) {
    api_text_raw(text, " ");
    api_text_raw(text, name);
    api_text_raw(text, "=\"");
    pattern_number(text, value);
    api_text_raw(text, "mm\"");
}

/* The page has a margin of three letters, and eight below for title and bar. */
static void paper(const struct pattern_sheet *sheet, double size[2]) {
    size[0] = sheet->high[0] - sheet->low[0] + 6 * sheet->letter;
    size[1] = sheet->high[1] - sheet->low[1] + 11 * sheet->letter;
}

static void view_box(struct api_text *text, const struct pattern_sheet *sheet) {
    double h = sheet->letter, size[2];
    paper(sheet, size);
    numbers(text, " viewBox=\"", sheet->low[0] - 3 * h, -sheet->high[1] - 3 * h);
    numbers(text, " ", size[0], size[1]);
    api_text_raw(text, "\">\n");
}

static void begin_drawing(struct api_text *text, double h) {
    api_text_raw(text, "<defs><pattern id=\"hatch\" patternUnits=\"userSpaceOnUse\"");
    attribute(text, "width", h / 2);
    attribute(text, "height", h / 2);
    api_text_raw(text, " patternTransform=\"rotate(45)\"><path");
    numbers(text, " d=\"M0 0L", 0, h / 2);
    api_text_raw(text, "\" fill=\"none\" stroke=\"#c00\"");
    attribute(text, "stroke-width", h / 8);
    api_text_raw(text, "/></pattern></defs>\n<g transform=\"scale(1 -1)\" fill=\"none\""
                       " stroke=\"#000\"");
    attribute(text, "stroke-width", h / 12);
    api_text_raw(text, ">\n");
}

static void head(struct api_text *text, const struct pattern_sheet *sheet,
                 const struct api_unit *unit) {
    double size[2];
    (void)unit;
    paper(sheet, size);
    api_text_raw(text, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
                       "<svg xmlns=\"http://www.w3.org/2000/svg\" version=\"1.1\"");
    length(text, "width", size[0]);
    length(text, "height", size[1]);
    view_box(text, sheet);
    api_text_raw(text, "<title>");
    api_text_raw(text, sheet->title);
    api_text_raw(text, "</title>\n<desc>");
    api_text_raw(text, sheet->subtitle);
    api_text_raw(text, "</desc>\n");
    begin_drawing(text, sheet->letter);
}

static void inset_head(struct api_text *text, const struct pattern_sheet *sheet,
                       const struct api_unit *unit) {
    (void)unit;
    api_text_raw(text, "<svg role=\"img\" aria-label=\"Flat pattern with its dimensions\"");
    view_box(text, sheet);
    begin_drawing(text, sheet->letter);
}

static void begin_shape(struct api_text *text, enum pattern_shape shape) {
    api_text_raw(text, shape == PATTERN_CUT
                           ? "<path id=\"cut\" fill=\"#eee\" fill-rule=\"evenodd\" d=\""
                           : "<path id=\"allowance\" stroke=\"#06c\" d=\"");
}

static void begin_polygon(struct api_text *text, enum pattern_shape shape) {
    (void)shape;
    api_text_raw(text, "M");
}

/* After the first corner of a path's part the letter L may be left out. */
static void corner(struct api_text *text, enum pattern_shape shape, double x, double y) {
    (void)shape;
    numbers(text, "", x, y);
    api_text_raw(text, " ");
}

static void end_polygon(struct api_text *text, enum pattern_shape shape) {
    (void)shape;
    api_text_raw(text, "Z\n");
}

static void end_shape(struct api_text *text, enum pattern_shape shape) {
    (void)shape;
    api_text_raw(text, "\"/>\n");
}

static void begin_locked(struct api_text *text) {
    api_text_raw(text, "<g id=\"locked\" fill=\"url(#hatch)\" stroke=\"none\">\n");
}

static void locked(struct api_text *text, const struct pattern_sheet *sheet, int i, int j,
                   int count) {
    api_text_raw(text, "<rect");
    attribute(text, "x", i * sheet->step[0]);
    attribute(text, "y", j * sheet->step[1]);
    attribute(text, "width", count * sheet->step[0]);
    attribute(text, "height", sheet->step[1]);
    api_text_raw(text, "/>\n");
}

static void letters(struct api_text *text, double x, double y, double height, const char *string) {
    api_text_raw(text, "<text");
    attribute(text, "x", x);
    attribute(text, "y", -y);
    attribute(text, "font-size", height);
    api_text_raw(text, ">");
    api_text_raw(text, string);
    api_text_raw(text, "</text>\n");
}

static void line(struct api_text *text, double x, double y, double to_x, double to_y) {
    numbers(text, "M", x, y);
    numbers(text, "L", to_x, to_y);
}

static void begin_notches(struct api_text *text) {
    api_text_raw(text, "</g>\n<path id=\"notches\" d=\"");
}

static void notch(struct api_text *text, double x, double y, double to_x, double to_y) {
    line(text, x, y, to_x, to_y);
}

/* Ten parts. */
static void ruler(struct api_text *text, const struct pattern_sheet *sheet, double y) {
    double h = sheet->letter, left = sheet->low[0];
    line(text, left, y, left + sheet->bar, y);
    for (int k = 0; k <= 10; k++) {
        double x = left + k * sheet->bar / 10;
        line(text, x, y, x, y + (k % 5 ? h / 2 : h));
    }
}

/* An arrow from the start to (x, y), which lies on an axis. */
static void arrow(struct api_text *text, double x, double y, double h) {
    double along[2] = {x > 0 ? h : 0, x > 0 ? 0 : h}, across[2] = {along[1] / 2, along[0] / 2};
    line(text, 0, 0, x, y);
    line(text, x - along[0] + across[0], y - along[1] + across[1], x, y);
    numbers(text, "L", x - along[0] - across[0], y - along[1] - across[1]);
}

/* Start, directions, bar and their names. */
static void draw_marks(struct api_text *text, const struct pattern_sheet *sheet) {
    double h = sheet->letter, bottom = sheet->low[1];
    api_text_raw(text, "\"/>\n<circle id=\"start\" cx=\"0\" cy=\"0\"");
    attribute(text, "r", h / 2);
    api_text_raw(text, "/>\n<path id=\"grain\" d=\"");
    arrow(text, 8 * h, 0, h);
    arrow(text, 0, 8 * h, h);
    api_text_raw(text, "\"/>\n<path id=\"bar\" d=\"");
    ruler(text, sheet, bottom - 7 * h);
}

static void letter_marks(struct api_text *text, const struct pattern_sheet *sheet) {
    double h = sheet->letter;
    api_text_raw(text, "\"/>\n</g>\n<g font-family=\"sans-serif\">\n");
    letters(text, 8.5 * h, h / 4, h, "warp");
    letters(text, h / 2, 8 * h, h, "weft");
}

static void foot(struct api_text *text, const struct pattern_sheet *sheet) {
    double h = sheet->letter, left = sheet->low[0], bottom = sheet->low[1];
    draw_marks(text, sheet);
    letter_marks(text, sheet);
    letters(text, left, bottom - 2.5 * h, 1.4 * h, sheet->title);
    letters(text, left, bottom - 4.5 * h, h, sheet->subtitle);
    letters(text, left + sheet->bar + h, bottom - 7 * h, h, sheet->bar_label);
    api_text_raw(text, "</g>\n</svg>\n");
}

/* The lines of both dimensions of the cut: below it and to its right, with their ends. */
static void dimension_lines(struct api_text *text, const struct pattern_sheet *sheet) {
    const double *low = sheet->cut_low, *high = sheet->cut_high, h = sheet->letter;
    double y = sheet->low[1] - 1.5 * h, x = sheet->high[0] + 1.5 * h;
    line(text, low[0], y, high[0], y);
    line(text, x, low[1], x, high[1]);
    for (int k = 0; k < 2; k++) {
        double end_x = k ? high[0] : low[0], end_y = k ? high[1] : low[1];
        line(text, end_x, y - h / 2, end_x, y + h / 2);
        line(text, x - h / 2, end_y, x + h / 2, end_y);
    }
}

/* Turned by a quarter where `upright` is false. */
static void dimension(struct api_text *text, const struct pattern_sheet *sheet, bool upright,
                      double x, double y) {
    int axis = upright ? 0 : 1;
    char label[64];
    snprintf(label, sizeof label, "%.4g %s", sheet->cut_high[axis] - sheet->cut_low[axis],
             sheet->unit);
    numbers(text, "<g text-anchor=\"middle\" transform=\"translate(", x, -y);
    api_text_raw(text, upright ? ")\">" : ")rotate(-90)\">");
    letters(text, 0, 0, 1.2 * sheet->letter, label);
    api_text_raw(text, "</g>\n");
}

static void inset_foot(struct api_text *text, const struct pattern_sheet *sheet) {
    const double *low = sheet->cut_low, *high = sheet->cut_high, h = sheet->letter;
    draw_marks(text, sheet);
    dimension_lines(text, sheet);
    letter_marks(text, sheet);
    dimension(text, sheet, true, (low[0] + high[0]) / 2, sheet->low[1] - 3.4 * h);
    dimension(text, sheet, false, sheet->high[0] + 2.8 * h, (low[1] + high[1]) / 2);
    letters(text, sheet->low[0] + sheet->bar + h, sheet->low[1] - 7 * h, h, sheet->bar_label);
    api_text_raw(text, "</g>\n</svg>\n");
}

/* All but head and foot. */
#define PEN                                                                                        \
    .metres = 1e-3, .unit = "mm", .begin_polygon = begin_polygon, .corner = corner,                \
    .end_polygon = end_polygon, .begin_shape = begin_shape, .end_shape = end_shape,                \
    .begin_locked = begin_locked, .locked = locked, .begin_notches = begin_notches, .notch = notch

static const struct pattern_pen pen = {PEN, .head = head, .foot = foot};
const struct pattern_pen svg_inset = {PEN, .head = inset_head, .foot = inset_foot};

const struct format format_svg = {.name = "svg",
                                  .media_type = "image/svg+xml",
                                  .about = "the pattern in millimetres at true scale",
                                  .exact = "12 digits",
                                  PATTERN_FORMAT(pen)};
