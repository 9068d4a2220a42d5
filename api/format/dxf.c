/* SPDX-License-Identifier: MIT */
/* The pattern in DXF. */
#include "dxf_writer.h"
#include "pattern.h"

static void draw_dxf_head(struct api_text *text, const struct pattern_sheet *sheet) {
    static const struct dxf_layer layers[] = {
        {"CUT", DXF_WHITE},      {"ALLOWANCE", DXF_BLUE}, {"NOTCH", DXF_MAGENTA},
        {"START", DXF_GREEN},    {"LOCKED", DXF_RED},     {"BARE", DXF_YELLOW},
        {"COLLAPSED", DXF_CYAN}, {"ROSETTE", DXF_BLUE},   {"TITLE", DXF_WHITE}};
    const double low[2] = {sheet->low[0], sheet->low[1] - 7 * sheet->letter};
    dxf_head(text, sheet->unit, low, sheet->high, layers, sizeof layers / sizeof *layers);
    dxf_section(text, "ENTITIES");
}

static void draw_dxf_corner(struct api_text *text, enum pattern_group shape, double x, double y,
                            bool first, bool last) {
    dxf_corner(text, shape == PATTERN_CUT ? "CUT" : "ALLOWANCE", x, y, first, last);
}

/* R12 has no hatches: a diagonal in every cell. */
static void draw_diagonals(struct api_text *text, const struct pattern_sheet *sheet, int i, int j,
                           int count) {
    for (int k = i; k < i + count; k++)
        dxf_line(text, "LOCKED", k * sheet->step[0], j * sheet->step[1], (k + 1) * sheet->step[0],
                 (j + 1) * sheet->step[1]);
}

static void draw_dxf_line(struct api_text *text, enum pattern_group group, double x, double y,
                          double to_x, double to_y) {
    static const char *const layers[PATTERN_GROUPS] = {
        [PATTERN_BARE] = "BARE", [PATTERN_COLLAPSED] = "COLLAPSED", [PATTERN_NOTCHES] = "NOTCH"};
    dxf_line(text, layers[group], x, y, to_x, to_y);
}

/* The start with a cross and the arrows of warp and weft, the title and the ruler. */
static void draw_dxf_foot(struct api_text *text, const struct pattern_sheet *sheet) {
    static const double lines[][4] = {{-1, 0, 1, 0},  {0, -1, 0, 1}, {0, 0, 8, 0},  {7, .5, 8, 0},
                                      {7, -.5, 8, 0}, {0, 0, 0, 8},  {.5, 7, 0, 8}, {-.5, 7, 0, 8}};
    double h = sheet->letter, left = sheet->low[0], bottom = sheet->low[1];
    dxf_circle(text, "START", 0, 0, h / 2);
    for (size_t k = 0; k < sizeof lines / sizeof *lines; k++)
        dxf_line(text, "START", lines[k][0] * h, lines[k][1] * h, lines[k][2] * h, lines[k][3] * h);
    dxf_letters(text, "START", 8.5 * h, 0, h, "warp");
    dxf_letters(text, "START", h, 8 * h, h, "weft");
    double zero[2] = {6 * h * sheet->zero[0], 6 * h * sheet->zero[1]};
    if (zero[0] != 0 || zero[1] != 0) {
        dxf_line(text, "ROSETTE", 0, 0, zero[0], zero[1]);
        dxf_letters(text, "ROSETTE", zero[0] + h / 2, zero[1], h, "0 deg");
    }
    dxf_letters(text, "TITLE", left, bottom - 2.5 * h, 1.4 * h, sheet->title);
    dxf_letters(text, "TITLE", left, bottom - 4.5 * h, h, sheet->subtitle);
    dxf_line(text, "TITLE", left, bottom - 7 * h, left + sheet->bar, bottom - 7 * h);
    for (int k = 0; k <= 10; k++) {
        double x = left + k * sheet->bar / 10;
        dxf_line(text, "TITLE", x, bottom - 7 * h, x, bottom - (k % 5 ? 6.5 : 6) * h);
    }
    dxf_letters(text, "TITLE", left + sheet->bar + h, bottom - 7 * h, h, sheet->bar_label);
    dxf_section_end(text);
    dxf_foot(text);
}

/* Layers need no brackets. */
static const struct pattern_pen pen = {.metres = 0,
                                       .unit = NULL,
                                       .to_cut = true,
                                       .before = {"", "", "", "", "", ""},
                                       .after_shape = "",
                                       .head = draw_dxf_head,
                                       .corner = draw_dxf_corner,
                                       .locked = draw_diagonals,
                                       .line = draw_dxf_line,
                                       .foot = draw_dxf_foot};

const struct format format_dxf = {.name = "dxf",
                                  .media_type = "image/vnd.dxf",
                                  .about = "the pattern in DXF R12, in the drape's unit",
                                  .exact = "12 digits",
                                  PATTERN_FORMAT(pen)};
