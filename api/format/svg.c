/* SPDX-License-Identifier: MIT */
/* The pattern in SVG: millimetres, weft up. The drawing is put upside down as a whole, so that its
 * numbers are those of the cloth; letters are turned back. */
#include "svg.h"

#include <stdio.h>

static void write_attribute(struct api_text *text, const char *name, double value,
                            const char *unit) {
    api_text_format(text, " %s=\"", name);
    pattern_number(text, value);
    api_text_format(text, "%s\"", unit);
}

static void write_pair(struct api_text *text, const char *before, double x, double y) {
    api_text_raw(text, before);
    pattern_number(text, x);
    api_text_raw(text, " ");
    pattern_number(text, y);
}

/* The page has a margin of three letters, and eight below for title and bar. */
static void page_size(const struct pattern_sheet *sheet, double size[2]) {
    size[0] = sheet->high[0] - sheet->low[0] + 6 * sheet->letter;
    size[1] = sheet->high[1] - sheet->low[1] + 11 * sheet->letter;
}

/* The end of the tag, words if wanted, the hatch, and the begin of the drawing upside down. */
static void begin_drawing(struct api_text *text, const struct pattern_sheet *sheet, bool words) {
    double h = sheet->letter, size[2];
    page_size(sheet, size);
    write_pair(text, " viewBox=\"", sheet->low[0] - 3 * h, -sheet->high[1] - 3 * h);
    write_pair(text, " ", size[0], size[1]);
    api_text_raw(text, "\">\n");
    if (words)
        api_text_format(text, "<title>%s</title>\n<desc>%s</desc>\n", sheet->title,
                        sheet->subtitle);
    api_text_raw(text, "<defs><pattern id=\"hatch\" patternUnits=\"userSpaceOnUse\"");
    write_attribute(text, "width", h / 2, "");
    write_attribute(text, "height", h / 2, "");
    api_text_raw(text, " patternTransform=\"rotate(45)\"><path");
    write_pair(text, " d=\"M0 0L", 0, h / 2);
    api_text_raw(text, "\" fill=\"none\" stroke=\"#c00\"");
    write_attribute(text, "stroke-width", h / 8, "");
    api_text_raw(text, "/></pattern></defs>\n<g transform=\"scale(1 -1)\" fill=\"none\""
                       " stroke=\"#000\"");
    write_attribute(text, "stroke-width", h / 12, "");
    api_text_raw(text, ">\n");
}

static void draw_page_head(struct api_text *text, const struct pattern_sheet *sheet) {
    double size[2];
    page_size(sheet, size);
    api_text_raw(text, "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
                       "<svg xmlns=\"http://www.w3.org/2000/svg\" version=\"1.1\"");
    write_attribute(text, "width", size[0], "mm");
    write_attribute(text, "height", size[1], "mm");
    begin_drawing(text, sheet, true);
}

static void draw_inset_head(struct api_text *text, const struct pattern_sheet *sheet) {
    api_text_raw(text, "<svg role=\"img\" aria-label=\"Flat pattern with its dimensions\"");
    begin_drawing(text, sheet, false);
}

/* After the first corner of a path's part the letter L may be left out. */
static void draw_svg_corner(struct api_text *text, enum pattern_group shape, double x, double y,
                            bool first, bool last) {
    (void)shape;
    write_pair(text, first ? "M" : "", x, y);
    api_text_raw(text, last ? " Z\n" : " ");
}

static void draw_rectangles(struct api_text *text, const struct pattern_sheet *sheet, int i, int j,
                            int count) {
    api_text_raw(text, "<rect");
    write_attribute(text, "x", i * sheet->step[0], "");
    write_attribute(text, "y", j * sheet->step[1], "");
    write_attribute(text, "width", count * sheet->step[0], "");
    write_attribute(text, "height", sheet->step[1], "");
    api_text_raw(text, "/>\n");
}

static void draw_letters(struct api_text *text, double x, double y, double height,
                         const char *string) {
    api_text_raw(text, "<text");
    write_attribute(text, "x", x, "");
    write_attribute(text, "y", -y, "");
    write_attribute(text, "font-size", height, "");
    api_text_format(text, ">%s</text>\n", string);
}

static void draw_line(struct api_text *text, double x, double y, double to_x, double to_y) {
    write_pair(text, "M", x, y);
    write_pair(text, "L", to_x, to_y);
}

static void draw_group_line(struct api_text *text, enum pattern_group group, double x, double y,
                            double to_x, double to_y) {
    (void)group;
    draw_line(text, x, y, to_x, to_y);
}

/* Start, directions, bar and the names of the directions; within the path of the bar `dimensions`
 * of the cut if wanted: below it and to its right, with their ends. */
static void draw_marks(struct api_text *text, const struct pattern_sheet *sheet, bool dimensions) {
    const double *low = sheet->cut_low, *high = sheet->cut_high;
    double h = sheet->letter, left = sheet->low[0], ruler = sheet->low[1] - 7 * h;
    double below = sheet->low[1] - 1.5 * h, right = sheet->high[0] + 1.5 * h;
    api_text_raw(text, "\"/>\n<circle id=\"start\" cx=\"0\" cy=\"0\"");
    write_attribute(text, "r", h / 2, "");
    api_text_raw(text, "/>\n<path id=\"grain\" d=\"");
    for (int k = 0; k < 2; k++) { /* an arrow from the start along each axis */
        double x = k ? 0 : 8 * h, y = k ? 8 * h : 0;
        double along[2] = {k ? 0 : h, k ? h : 0}, across[2] = {along[1] / 2, along[0] / 2};
        draw_line(text, 0, 0, x, y);
        draw_line(text, x - along[0] + across[0], y - along[1] + across[1], x, y);
        write_pair(text, "L", x - along[0] - across[0], y - along[1] - across[1]);
    }
    bool zero = sheet->zero[0] != 0 || sheet->zero[1] != 0;
    double tip[2] = {6 * h * sheet->zero[0], 6 * h * sheet->zero[1]};
    if (zero) { /* 0 degrees of the rosette, a line that ends in a ring */
        api_text_raw(text, "\"/>\n<path id=\"rosette\" stroke=\"#06c\" d=\"");
        draw_line(text, 0, 0, tip[0], tip[1]);
        api_text_raw(text, "\"/>\n<circle stroke=\"#06c\"");
        write_attribute(text, "cx", tip[0] + h / 4 * sheet->zero[0], "");
        write_attribute(text, "cy", tip[1] + h / 4 * sheet->zero[1], "");
        write_attribute(text, "r", h / 4, "");
        api_text_raw(text, "/>\n<path id=\"bar\" d=\"");
    } else {
        api_text_raw(text, "\"/>\n<path id=\"bar\" d=\"");
    }
    draw_line(text, left, ruler, left + sheet->bar, ruler);
    for (int k = 0; k <= 10; k++) {
        double x = left + k * sheet->bar / 10;
        draw_line(text, x, ruler, x, ruler + (k % 5 ? h / 2 : h));
    }
    if (dimensions) {
        draw_line(text, low[0], below, high[0], below);
        draw_line(text, right, low[1], right, high[1]);
    }
    for (int k = 0; k < 2 && dimensions; k++) {
        double x = k ? high[0] : low[0], y = k ? high[1] : low[1];
        draw_line(text, x, below - h / 2, x, below + h / 2);
        draw_line(text, right - h / 2, y, right + h / 2, y);
    }
    api_text_raw(text, "\"/>\n</g>\n<g font-family=\"sans-serif\">\n");
    draw_letters(text, 8.5 * h, h / 4, h, "warp");
    draw_letters(text, h / 2, 8 * h, h, "weft");
    if (zero)
        draw_letters(text, tip[0] + h, tip[1] + h / 2, h, "0°");
}

static void draw_page_foot(struct api_text *text, const struct pattern_sheet *sheet) {
    double h = sheet->letter, left = sheet->low[0], bottom = sheet->low[1];
    draw_marks(text, sheet, false);
    draw_letters(text, left, bottom - 2.5 * h, 1.4 * h, sheet->title);
    draw_letters(text, left, bottom - 4.5 * h, h, sheet->subtitle);
    draw_letters(text, left + sheet->bar + h, bottom - 7 * h, h, sheet->bar_label);
    api_text_raw(text, "</g>\n</svg>\n");
}

/* The cut's length, and its width turned by a quarter, in place of the title. */
static void draw_inset_foot(struct api_text *text, const struct pattern_sheet *sheet) {
    const double *low = sheet->cut_low, *high = sheet->cut_high, h = sheet->letter;
    draw_marks(text, sheet, true);
    for (int k = 0; k < 2; k++) {
        char label[64];
        double x = k ? sheet->high[0] + 2.8 * h : (low[0] + high[0]) / 2;
        double y = k ? (low[1] + high[1]) / 2 : sheet->low[1] - 3.4 * h;
        snprintf(label, sizeof label, "%.4g %s", high[k] - low[k], sheet->unit);
        write_pair(text, "<g text-anchor=\"middle\" transform=\"translate(", x, -y);
        api_text_raw(text, k ? ")rotate(-90)\">" : ")\">");
        draw_letters(text, 0, 0, 1.2 * h, label);
        api_text_raw(text, "</g>\n");
    }
    draw_letters(text, sheet->low[0] + sheet->bar + h, sheet->low[1] - 7 * h, h, sheet->bar_label);
    api_text_raw(text, "</g>\n</svg>\n");
}

/* All but head and foot. */
#define PEN                                                                                        \
    .metres = 1e-3, .unit = "mm", .corner = draw_svg_corner, .locked = draw_rectangles,            \
    .line = draw_group_line, .after_shape = "\"/>\n",                                              \
    .before = {                                                                                    \
        "<path id=\"allowance\" stroke=\"#06c\" d=\"",                                             \
        "<path id=\"cut\" fill=\"#eee\" d=\"",                                                     \
        "<g id=\"locked\" fill=\"url(#hatch)\" stroke=\"none\">\n",                                \
        "</g>\n<path id=\"bare\" stroke=\"#e08a00\" stroke-width=\"0.4%\" d=\"",                   \
        "\"/>\n<path id=\"collapsed\" stroke=\"#c0008a\" stroke-width=\"0.4%\" d=\"",              \
        "\"/>\n<path id=\"notches\" d=\"",                                                         \
    }

static const struct pattern_pen pen = {PEN, .head = draw_page_head, .foot = draw_page_foot};
const struct pattern_pen svg_inset = {PEN, .head = draw_inset_head, .foot = draw_inset_foot};

const struct format format_svg = {.name = "svg",
                                  .media_type = "image/svg+xml",
                                  .about = "the pattern in millimetres at true scale",
                                  .exact = "12 digits",
                                  PATTERN_FORMAT(pen)};
