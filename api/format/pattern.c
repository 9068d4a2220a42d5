/* SPDX-License-Identifier: MIT */
#include "pattern.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum {
    CORNERS = 1024, /* of one piece */
    CELLS = 512,
    DIGITS = 12
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

static void write_titles(const struct encoder *encoder, struct pattern_sheet *sheet) {
    const struct api_columns *columns = &encoder->columns;
    const double *spacing = columns->grid.spacing;
    snprintf(sheet->title, sizeof sheet->title, "Flat pattern of drape %s", encoder->id);
    snprintf(sheet->subtitle, sizeof sheet->subtitle,
             "scale 1:1, drawn in %s; %zu cells of %g x %g %s, %.0f beyond the locking angle",
             sheet->unit, columns->summary.cells, spacing[0], spacing[1], columns->unit->name,
             fmax(columns->summary.locked_cells, 0));
    snprintf(sheet->bar_label, sizeof sheet->bar_label, "%g %s", sheet->bar, sheet->unit);
}

static void make_sheet(const struct encoder *encoder, const struct pattern_pen *pen,
                       struct pattern_state *state) {
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

static void draw_outline(struct encoder *encoder, const struct pattern_pen *pen) {
    struct pattern_state *state = encoder->state;
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
        state->stage = PATTERN_LOCKED;
    }
}

/* Side by side cells of a row are drawn as one. */
static void draw_runs(struct encoder *encoder, const struct pattern_pen *pen, size_t count) {
    const struct pattern_state *state = encoder->state;
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

static void draw_locked(struct encoder *encoder, const struct pattern_pen *pen) {
    static const char *const names[] = {"i", "j", "locked"};
    struct pattern_state *state = encoder->state;
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
        state->stage = PATTERN_FOOT;
}

void pattern_next(struct encoder *encoder) {
    struct pattern_state *state = encoder->state;
    const struct pattern_pen *pen = encoder->format->own;
    switch (state->stage) {
    case PATTERN_HEAD:
        pen->head(&encoder->piece, &state->sheet, encoder->columns.unit);
        state->stage = PATTERN_OUTLINE;
        break;
    case PATTERN_OUTLINE:
        draw_outline(encoder, pen);
        break;
    case PATTERN_LOCKED:
        draw_locked(encoder, pen);
        break;
    case PATTERN_FOOT:
        pen->foot(&encoder->piece, &state->sheet);
        encoder->ended = true;
        break;
    }
}

bool pattern_begin(struct encoder *encoder, struct api_problem *problem) {
    struct pattern_state *state = encoder->state;
    if (outline_make(&state->outline, encoder->reader, &encoder->columns, problem) != API_OK)
        return false;
    make_sheet(encoder, encoder->format->own, state);
    return true;
}

void pattern_end(struct encoder *encoder) {
    struct pattern_state *state = encoder->state;
    outline_free(&state->outline);
}
