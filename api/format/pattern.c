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

/* Points of the rim are left out as long as the cut stays within this share of a spacing; the rim
 * itself is right to 1e-3. */
static const double tolerance = 5e-4;

/* An allowance is a margin: more than this share of the pattern is taken for a mistake. */
static const double largest_allowance = 0.25;

void pattern_number(struct api_text *text, double value) {
    char number[API_NUMBER_SIZE];
    api_text_bytes(text, number, api_number_rounded(number, value + 0.0, DIGITS));
}

/* ---- the sheet ---- */

double pattern_round_length(double length) {
    double power = pow(10, floor(log10(length))), part = length / power;
    return (part >= 5 ? 5 : part >= 2 ? 2 : 1) * power;
}

static double unit_scale(const struct encoder *encoder, const struct pattern_pen *pen) {
    return pen->metres > 0 ? encoder->columns.unit->metres / pen->metres : 1;
}

static void write_titles(const struct encoder *encoder, struct pattern_sheet *sheet) {
    const struct api_columns *columns = &encoder->columns;
    const struct format_options *options = &encoder->options;
    const double *spacing = columns->grid.spacing;
    const char *between = options->part[0] && options->ply[0] ? ", ply " : "";
    if (options->part[0] || options->ply[0])
        snprintf(sheet->title, sizeof sheet->title, "%s%s%s", options->part, between, options->ply);
    else
        snprintf(sheet->title, sizeof sheet->title, "Flat pattern of drape %s", encoder->id);
    int length =
        snprintf(sheet->subtitle, sizeof sheet->subtitle,
                 "scale 1:1, drawn in %s; %zu cells of %g x %g %s, %.0f beyond the locking angle",
                 sheet->unit, columns->summary.cells, spacing[0], spacing[1], columns->unit->name,
                 fmax(columns->summary.locked_cells, 0));
    if (options->allowance > 0)
        snprintf(sheet->subtitle + length, sizeof sheet->subtitle - (size_t)length,
                 "; allowance %g %s", options->allowance, columns->unit->name);
    snprintf(sheet->bar_label, sizeof sheet->bar_label, "%g %s", sheet->bar, sheet->unit);
}

static void make_sheet(const struct encoder *encoder, struct pattern_state *state) {
    struct pattern_sheet *sheet = &state->sheet;
    double size = 0;
    polygons_bounds(&state->cut.polygons, sheet->cut_low, sheet->cut_high);
    polygons_bounds(state->allowed.count ? &state->allowed : &state->cut.polygons, sheet->low,
                    sheet->high);
    for (int k = 0; k < 2; k++) {
        sheet->low[k] = fmin(sheet->low[k], 0);
        sheet->high[k] = fmax(sheet->high[k], 0);
        size = fmax(size, sheet->high[k] - sheet->low[k]);
    }
    size = fmax(size, sheet->step[0]);
    sheet->letter = size / 60;
    sheet->bar = pattern_round_length(size / 2);
    write_titles(encoder, sheet);
}

/* ---- stages ---- */

static void draw_shape(struct encoder *encoder, const struct pattern_pen *pen) {
    struct pattern_state *state = encoder->state;
    struct api_text *text = &encoder->piece;
    enum pattern_shape shape = state->shape;
    const struct polygons *polygons = shape == PATTERN_CUT ? &state->cut.polygons : &state->allowed;
    if (!state->begun)
        pen->begin_shape(text, shape);
    state->begun = true;
    for (int k = 0; k < CORNERS && state->corner < polygons->count; k++) {
        const struct polygons_point *point = &polygons->points[state->corner++];
        if (!state->open)
            pen->begin_polygon(text, shape);
        pen->corner(text, shape, point->x, point->y);
        state->open = !point->last;
        if (point->last)
            pen->end_polygon(text, shape);
    }
    if (state->corner < polygons->count)
        return;
    pen->end_shape(text, shape);
    state->begun = false;
    state->corner = 0;
    if (shape == PATTERN_CUT) {
        state->stage = PATTERN_AT_LOCKED;
        pen->begin_locked(text);
    }
    state->shape = PATTERN_CUT;
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
    if (encoder->row < rows)
        return;
    state->stage = PATTERN_AT_NOTCHES;
    pen->begin_notches(&encoder->piece);
}

/* A letter long, inwards along the generator. */
static void draw_notches(struct encoder *encoder, const struct pattern_pen *pen) {
    struct pattern_state *state = encoder->state;
    const struct pattern_sheet *sheet = &state->sheet;
    for (int k = 0; k < CELLS && state->notch < state->cut.notch_count; k++) {
        const struct cut_notch *notch = &state->cut.notches[state->notch++];
        double x = notch->p * sheet->step[0], y = notch->q * sheet->step[1];
        double in = -notch->way * sheet->letter;
        pen->notch(&encoder->piece, x, y, notch->family ? x : x + in, notch->family ? y + in : y);
    }
    if (state->notch == state->cut.notch_count)
        state->stage = PATTERN_AT_FOOT;
}

void pattern_next(struct encoder *encoder) {
    struct pattern_state *state = encoder->state;
    const struct pattern_pen *pen = encoder->format->own;
    switch (state->stage) {
    case PATTERN_AT_HEAD:
        pen->head(&encoder->piece, &state->sheet, encoder->columns.unit);
        state->stage = PATTERN_AT_SHAPES;
        state->shape = state->allowed.count ? PATTERN_ALLOWANCE : PATTERN_CUT;
        break;
    case PATTERN_AT_SHAPES:
        draw_shape(encoder, pen);
        break;
    case PATTERN_AT_LOCKED:
        draw_locked(encoder, pen);
        break;
    case PATTERN_AT_NOTCHES:
        draw_notches(encoder, pen);
        break;
    case PATTERN_AT_FOOT:
        pen->foot(&encoder->piece, &state->sheet);
        encoder->ended = true;
        break;
    }
}

/* The line an allowance outside the cut. */
static bool add_allowance(struct encoder *encoder, struct pattern_state *state, double scale,
                          struct api_problem *problem) {
    double allowance = encoder->options.allowance, low[2], high[2];
    const char *unit = encoder->columns.unit->name;
    if (!(allowance > 0) || state->cut.polygons.count == 0)
        return true;
    polygons_bounds(&state->cut.polygons, low, high);
    double most = largest_allowance * fmax(high[0] - low[0], high[1] - low[1]) / scale;
    if (allowance > most) {
        api_problem_set(problem, API_INVALID_REQUEST,
                        "allowance must be between 0 and %.3g %s, a quarter of the pattern", most,
                        unit);
        return false;
    }
    if (!polygons_widen(&state->cut.polygons, allowance * scale, &state->allowed)) {
        api_problem_set(problem, API_OUT_OF_MEMORY, "no memory for the allowance");
        return false;
    }
    return true;
}

bool pattern_begin(struct encoder *encoder, struct api_problem *problem) {
    struct pattern_state *state = encoder->state;
    const struct pattern_pen *pen = encoder->format->own;
    struct pattern_sheet *sheet = &state->sheet;
    struct outline outline = {0};
    double scale = unit_scale(encoder, pen);
    if (outline_make(&outline, encoder->reader, &encoder->columns, problem) == API_OK)
        (void)!cut_make(&state->cut, encoder->reader, &encoder->columns, &outline, tolerance,
                        problem);
    outline_free(&outline);
    for (int k = 0; k < 2; k++)
        sheet->step[k] = encoder->columns.grid.spacing[k] * scale;
    for (size_t k = 0; k < state->cut.polygons.count; k++) {
        state->cut.polygons.points[k].x *= sheet->step[0];
        state->cut.polygons.points[k].y *= sheet->step[1];
    }
    sheet->unit = pen->unit ? pen->unit : encoder->columns.unit->name;
    if (problem->id != API_OK || !add_allowance(encoder, state, scale, problem))
        return false;
    make_sheet(encoder, state);
    return true;
}

void pattern_end(struct encoder *encoder) {
    struct pattern_state *state = encoder->state;
    cut_free(&state->cut);
    polygons_free(&state->allowed);
}
