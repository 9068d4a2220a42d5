/* SPDX-License-Identifier: MIT */
#include "pattern.h"

#include "pattern_pen.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

enum {
    CORNERS = 1024, /* of one piece */
    CELLS = 512,
    DIGITS = 12
};

enum stage { HEAD, OUTLINE, LOCKED, FOOT };

struct state {
    struct outline outline;
    struct pattern_sheet sheet;
    enum stage stage;
    size_t corner;
    bool open; /* a polygon is begun */
};

void pattern_number(struct api_text *text, double value) {
    char number[API_NUMBER_SIZE];
    api_text_bytes(text, number, api_number_rounded(number, value + 0.0, DIGITS));
}

/* ---- the sheet ---- */

/* 1, 2 or 5 times a power of ten, at most `length`. */
static double round_length(double length) {
    double power = pow(10, floor(log10(length))), part = length / power;
    return (part >= 5 ? 5 : part >= 2 ? 2 : 1) * power;
}

static void write_titles(const struct api_encoder *encoder, struct pattern_sheet *sheet) {
    const struct api_columns *columns = &encoder->columns;
    const double *spacing = columns->grid.spacing;
    snprintf(sheet->title, sizeof sheet->title, "Flat pattern of drape %s", encoder->id);
    snprintf(sheet->subtitle, sizeof sheet->subtitle,
             "scale 1:1, drawn in %s; %zu cells of %g x %g %s, %zu beyond the locking angle",
             sheet->unit, columns->summary.cells, spacing[0], spacing[1], columns->unit->name,
             columns->summary.locked_cells);
    snprintf(sheet->bar_label, sizeof sheet->bar_label, "%g %s", sheet->bar, sheet->unit);
}

static void make_sheet(const struct api_encoder *encoder, const struct pattern_pen *pen,
                       struct state *state) {
    struct pattern_sheet *sheet = &state->sheet;
    const struct api_columns *columns = &encoder->columns;
    double scale = pen->metres > 0 ? columns->unit->metres / pen->metres : 1, size = 0;
    for (int k = 0; k < 2; k++) {
        sheet->step[k] = columns->grid.spacing[k] * scale;
        sheet->low[k] = fmin(state->outline.low[k], 0) * sheet->step[k];
        sheet->high[k] = fmax(state->outline.high[k], 0) * sheet->step[k];
        size = fmax(size, sheet->high[k] - sheet->low[k]);
    }
    size = fmax(size, sheet->step[0]);
    sheet->letter = size / 60;
    sheet->bar = round_length(size / 4);
    sheet->unit = pen->unit ? pen->unit : columns->unit->name;
    write_titles(encoder, sheet);
}

/* ---- stages ---- */

static void draw_outline(struct api_encoder *encoder, const struct pattern_pen *pen) {
    struct state *state = encoder->state;
    size_t left = state->outline.count - state->corner, count = left < CORNERS ? left : CORNERS;
    for (size_t k = 0; k < count; k++) {
        const struct outline_point *point = &state->outline.points[state->corner++];
        if (!state->open)
            pen->begin_polygon(&encoder->piece);
        pen->corner(&encoder->piece, point->i * state->sheet.step[0],
                    point->j * state->sheet.step[1]);
        state->open = !point->last;
        if (point->last)
            pen->end_polygon(&encoder->piece);
    }
    if (state->corner == state->outline.count) {
        pen->end_outline(&encoder->piece);
        state->stage = LOCKED;
    }
}

/* Side by side cells of a row are drawn as one. */
static void draw_runs(struct api_encoder *encoder, const struct pattern_pen *pen, size_t count) {
    const struct state *state = encoder->state;
    const double *i = encoder->values, *j = i + CELLS, *locked = j + CELLS;
    for (size_t k = 0, end; k < count; k = end) {
        end = k + 1;
        if (locked[k] == 0)
            continue;
        while (end < count && locked[end] != 0 && j[end] == j[k] && i[end] == i[end - 1] + 1)
            end++;
        pen->locked(&encoder->piece, &state->sheet, (int)i[k], (int)j[k], (int)(end - k));
    }
}

static void draw_locked(struct api_encoder *encoder, const struct pattern_pen *pen) {
    static const char *const names[] = {"i", "j", "locked"};
    struct state *state = encoder->state;
    const struct api_column *column = NULL;
    size_t count = 0, rows = 0;
    for (int k = 2; k >= 0; k--) {
        column = api_columns_find(&encoder->columns, API_TABLE_CELLS, names[k]);
        rows = column ? column->rows : 0;
        count = rows - encoder->row < CELLS ? rows - encoder->row : CELLS;
        if (!column)
            break;
        if (!api_columns_read(encoder->reader, column, encoder->row, count,
                              encoder->values + k * CELLS))
            encoder->failed = true;
    }
    if (column && !encoder->failed)
        draw_runs(encoder, pen, count);
    encoder->row += count;
    if (encoder->row >= rows)
        state->stage = FOOT;
}

static void draw(struct api_encoder *encoder, const struct pattern_pen *pen) {
    struct state *state = encoder->state;
    switch (state->stage) {
    case HEAD:
        pen->head(&encoder->piece, &state->sheet, encoder->columns.unit);
        state->stage = OUTLINE;
        break;
    case OUTLINE:
        draw_outline(encoder, pen);
        break;
    case LOCKED:
        draw_locked(encoder, pen);
        break;
    case FOOT:
        pen->foot(&encoder->piece, &state->sheet);
        encoder->ended = true;
        break;
    }
}

static bool begin(struct api_encoder *encoder, const struct pattern_pen *pen,
                  struct api_problem *problem) {
    struct state *state = encoder->state;
    if (outline_make(&state->outline, encoder->reader, &encoder->columns, problem) != API_OK)
        return false;
    make_sheet(encoder, pen, state);
    return true;
}

static void end(struct api_encoder *encoder) {
    struct state *state = encoder->state;
    outline_free(&state->outline);
}

/* ---- the formats ---- */

static bool begin_svg(struct api_encoder *encoder, struct api_problem *problem) {
    return begin(encoder, &pattern_svg_pen, problem);
}

static bool begin_dxf(struct api_encoder *encoder, struct api_problem *problem) {
    return begin(encoder, &pattern_dxf_pen, problem);
}

static void next_svg(struct api_encoder *encoder) {
    draw(encoder, &pattern_svg_pen);
}

static void next_dxf(struct api_encoder *encoder) {
    draw(encoder, &pattern_dxf_pen);
}

static const struct api_format formats[] = {
    {.name = "svg",
     .media_type = "image/svg+xml",
     .state_size = sizeof(struct state),
     .begin = begin_svg,
     .next = next_svg,
     .end = end},
    {.name = "dxf",
     .media_type = "image/vnd.dxf",
     .state_size = sizeof(struct state),
     .begin = begin_dxf,
     .next = next_dxf,
     .end = end},
};

const struct api_format *api_pattern_at(size_t index) {
    return index < sizeof formats / sizeof *formats ? &formats[index] : NULL;
}

const struct api_format *api_pattern_named(const char *name) {
    for (size_t k = 0; api_pattern_at(k); k++)
        if (strcmp(name, formats[k].name) == 0)
            return &formats[k];
    return NULL;
}
