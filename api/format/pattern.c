/* SPDX-License-Identifier: MIT */
#include "pattern.h"

#include "api/result/stored_cuts.h"
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

bool pattern_may_be_cut(const struct api_columns *columns, bool to_cut, bool partial,
                        struct api_problem *problem) {
    const struct api_summary *summary = &columns->summary;
    if (!to_cut || partial || summary->outcome == DRAPE_COMPLETE)
        return true;
    return !api_problem_set(problem, API_INVALID_REQUEST,
                            "the cloth leaves %.2g %% of the part bare, and would be cut along "
                            "its own front there: drape all of it, or ask for partial=1",
                            100 * (1 - summary->cloth_coverage));
}

/* ---- the sheet ---- */

double pattern_round_length(double length) {
    double power = pow(10, floor(log10(length))), part = length / power;
    return (part >= 5 ? 5 : part >= 2 ? 2 : 1) * power;
}

/* What zero = a warp + b weft, in the tangent plane, is on the cloth before it was sheared. */
void pattern_flat_zero(const struct api_start *start, double flat[2]) {
    struct vec3 normal = vec3_cross(start->warp, start->weft);
    double size = vec3_dot(normal, normal);
    double a = vec3_dot(vec3_cross(start->zero, start->weft), normal) / size;
    double b = vec3_dot(vec3_cross(start->warp, start->zero), normal) / size;
    double length = sqrt(a * a + b * b);
    flat[0] = length > 0 ? a / length : 0;
    flat[1] = length > 0 ? b / length : 0;
}

static bool warns_of(const struct api_summary *summary, const char *code) {
    bool found = false;
    for (size_t k = 0; k < summary->warnings.count; k++)
        found = found || strcmp(summary->warnings.list[k].code, code) == 0;
    return found;
}

/* Places, sizes and words of the sheet, once the cut and the allowance are known. */
static void make_sheet(const struct encoder *encoder, struct pattern_state *state) {
    const struct api_columns *columns = &encoder->columns;
    const struct format_options *options = &encoder->options;
    struct pattern_sheet *sheet = &state->sheet;
    double size = 0;
    polygons_bounds(&state->cut.polygons, sheet->cut_low, sheet->cut_high);
    /* An outline that crosses itself may reach beyond its allowance. */
    polygons_bounds(&state->allowed, sheet->low, sheet->high);
    for (int k = 0; k < 2; k++) {
        sheet->low[k] = fmin(fmin(sheet->low[k], sheet->cut_low[k]), 0);
        sheet->high[k] = fmax(fmax(sheet->high[k], sheet->cut_high[k]), 0);
        size = fmax(size, sheet->high[k] - sheet->low[k]);
    }
    size = fmax(size, sheet->step[0]);
    sheet->letter = size / 60;
    sheet->bar = pattern_round_length(size / 2);
    int titled = 0; /* what is bare comes first: the sheet may be too narrow for all of it */
    if (columns->summary.outcome == DRAPE_PARTIAL)
        titled = snprintf(sheet->title, sizeof sheet->title, "%.2g %% of the part is bare. ",
                          100 * (1 - columns->summary.cloth_coverage));
    if (warns_of(&columns->summary, "overlap") || warns_of(&columns->summary, "cut_opens"))
        titled += snprintf(sheet->title + titled, sizeof sheet->title - (size_t)titled,
                           "The outline crosses itself. ");
    if (state->slim_cuts > 0)
        titled += snprintf(sheet->title + titled, sizeof sheet->title - (size_t)titled,
                           "%d of the cuts too narrow for an allowance. ", state->slim_cuts);
    char *title = sheet->title + titled;
    size_t room = sizeof sheet->title - (size_t)titled;
    if (options->part[0] || options->ply[0])
        snprintf(title, room, "%s%s%s", options->part,
                 options->part[0] && options->ply[0] ? ", ply " : "", options->ply);
    else
        snprintf(title, room, "Flat pattern of drape %s", encoder->id);
    int length = snprintf(
        sheet->subtitle, sizeof sheet->subtitle,
        "scale 1:1, drawn in %s; area %.6g %s2, %zu cells of %g x %g %s, %.0f beyond the locking "
        "angle",
        sheet->unit, columns->summary.flat_area, columns->unit->name, columns->summary.cells,
        columns->grid.spacing[0], columns->grid.spacing[1], columns->unit->name,
        fmax(columns->summary.locked_cells, 0));
    if (options->allowance > 0)
        snprintf(sheet->subtitle + length, sizeof sheet->subtitle - (size_t)length,
                 "; allowance %g %s", options->allowance, columns->unit->name);
    pattern_flat_zero(&columns->start, sheet->zero);
    snprintf(sheet->bar_label, sizeof sheet->bar_label, "%g %s", sheet->bar, sheet->unit);
}

/* ---- drawing ---- */

/* The functions that draw some of a group return how many it has. */
static size_t draw_corners(struct encoder *encoder, const struct pattern_pen *pen) {
    struct pattern_state *state = encoder->state;
    const struct polygons *polygons =
        state->group == PATTERN_CUT ? &state->cut.polygons : &state->allowed;
    for (int k = 0; k < CORNERS && state->at < polygons->count; k++) {
        const struct polygons_point *point = &polygons->points[state->at++];
        pen->corner(&encoder->piece, state->group, point->x, point->y, !state->open, point->last);
        state->open = !point->last;
    }
    return polygons->count;
}

/* Side by side cells of a row are drawn as one. A result without a locking angle has none. */
static size_t draw_locked_cells(struct encoder *encoder, const struct pattern_pen *pen) {
    static const char *const names[] = {"locked", "i", "j"};
    struct pattern_state *state = encoder->state;
    const double *locked = encoder->values, *i = locked + CELLS, *j = i + CELLS;
    size_t count = 0, rows = 0;
    for (int k = 0; k < 3; k++) {
        const struct api_column *column =
            api_columns_find(&encoder->columns, API_TABLE_CELLS, names[k]);
        rows = column ? column->rows : 0;
        count = rows - state->at < CELLS ? rows - state->at : CELLS;
        if (!column)
            break;
        if (!api_columns_read(encoder->reader, column, state->at, count,
                              encoder->values + k * CELLS))
            encoder->failed = true;
    }
    for (size_t k = 0, end; k < count && !encoder->failed; k = end) {
        end = k + 1;
        if (locked[k] == 0)
            continue;
        while (end < count && locked[end] != 0 && j[end] == j[k] && i[end] == i[end - 1] + 1)
            end++;
        pen->locked(&encoder->piece, &state->sheet, (int)i[k], (int)j[k], (int)(end - k));
    }
    state->at += count;
    return rows;
}

/* A letter long, inwards. */
static size_t draw_notches(struct encoder *encoder, const struct pattern_pen *pen) {
    struct pattern_state *state = encoder->state;
    const struct pattern_sheet *sheet = &state->sheet;
    for (int k = 0; k < CELLS && state->at < state->cut.notch_count; k++) {
        const struct pattern_notch *notch = &state->cut.notches[state->at++];
        double x = notch->p * sheet->step[0], y = notch->q * sheet->step[1];
        /* at right angles to a lip, and so by the other spacing each */
        double in[2] = {notch->in[0] * sheet->step[1], notch->in[1] * sheet->step[0]};
        double size = sheet->letter / hypot(in[0], in[1]);
        pen->line(&encoder->piece, state->group, x, y, x + size * in[0], y + size * in[1]);
    }
    return state->cut.notch_count;
}

/* Those of the group. */
static size_t draw_fronts(struct encoder *encoder, const struct pattern_pen *pen) {
    struct pattern_state *state = encoder->state;
    const double *step = state->sheet.step;
    bool collapsed = state->group == PATTERN_COLLAPSED;
    for (int k = 0; k < CELLS && state->at < state->cut.front_count; k++) {
        const struct pattern_front *front = &state->cut.fronts[state->at++];
        if ((front->end == PATTERN_END_COLLAPSED) == collapsed)
            pen->line(&encoder->piece, state->group, front->from[0] * step[0],
                      front->from[1] * step[1], front->to[0] * step[0], front->to[1] * step[1]);
    }
    return state->cut.front_count;
}

void pattern_next(struct encoder *encoder) {
    static size_t (*const draw[PATTERN_GROUPS])(struct encoder *, const struct pattern_pen *) = {
        draw_corners, draw_corners, draw_locked_cells, draw_fronts, draw_fronts, draw_notches};
    struct pattern_state *state = encoder->state;
    const struct pattern_pen *pen = encoder->format->own;
    if (!state->begun) {
        pen->head(&encoder->piece, &state->sheet);
        state->begun = true;
        state->group = state->allowed.count ? PATTERN_ALLOWANCE : PATTERN_CUT;
        api_text_raw(&encoder->piece, pen->before[state->group]);
    } else if (state->group < PATTERN_GROUPS) {
        size_t count = draw[state->group](encoder, pen);
        if (state->at < count)
            return;
        api_text_raw(&encoder->piece, state->group <= PATTERN_CUT ? pen->after_shape : "");
        state->at = 0;
        state->group++;
        api_text_raw(&encoder->piece,
                     state->group < PATTERN_GROUPS ? pen->before[state->group] : "");
    } else {
        pen->foot(&encoder->piece, &state->sheet);
        encoder->ended = true;
    }
}

/* The allowances of the edge, then of the cuts, in the pen's unit. Where a cut is narrower than
 * both of its lips' together these would meet, and one cloth cannot have them: it is noted as slim.
 */
static bool read_allowances(struct encoder *encoder, double scale,
                            double allowance[API_CUTS_MAX + 1]) {
    struct pattern_state *state = encoder->state;
    struct stored_cut cuts[API_CUTS_MAX];
    if (!stored_cuts_read(encoder->reader, &encoder->columns, cuts))
        return false;
    allowance[0] = encoder->options.allowance * scale;
    for (size_t k = 0; k < encoder->columns.cut_count; k++) {
        double own = cuts[k].allowance;
        bool slim = own > 0 && cuts[k].mouth_width < 2 * own;
        allowance[k + 1] = slim ? 0 : own * scale;
        state->slim_cuts += slim;
    }
    return true;
}

/* The line outside the cut. */
static bool make_allowed(struct encoder *encoder, double scale, struct api_problem *problem) {
    struct pattern_state *state = encoder->state;
    const struct polygons *cut = &state->cut.polygons;
    double allowance[API_CUTS_MAX + 1] = {0}, low[2], high[2], widest = 0;
    if (!read_allowances(encoder, scale, allowance))
        return encoder_damaged(problem);
    for (size_t k = 0; k <= encoder->columns.cut_count; k++)
        widest = fmax(widest, allowance[k]);
    if (!(widest > 0) || cut->count == 0)
        return true;
    polygons_bounds(cut, low, high);
    double most = largest_allowance * fmax(high[0] - low[0], high[1] - low[1]) / scale;
    if (encoder->options.allowance > most)
        return !api_problem_set(problem, API_INVALID_REQUEST,
                                "allowance must be between 0 and %.3g %s, a quarter of the pattern",
                                most, encoder->columns.unit->name);
    return polygons_widen(cut, allowance, &state->allowed) ||
           !api_problem_no_memory(problem, "the allowance");
}

bool pattern_begin(struct encoder *encoder, struct api_problem *problem) {
    struct pattern_state *state = encoder->state;
    const struct pattern_pen *pen = encoder->format->own;
    struct pattern_sheet *sheet = &state->sheet;
    struct polygons *cut = &state->cut.polygons;
    const struct api_unit *unit = encoder->columns.unit;
    double scale = pen->metres > 0 ? unit->metres / pen->metres : 1;
    if (!pattern_may_be_cut(&encoder->columns, pen->to_cut, encoder->options.partial, problem))
        return false;
    if (flat_pattern_make(&state->cut, encoder->reader, &encoder->columns, tolerance, problem) !=
        API_OK)
        return false;
    for (int k = 0; k < 2; k++)
        sheet->step[k] = encoder->columns.grid.spacing[k] * scale;
    for (size_t k = 0; k < cut->count; k++) {
        cut->points[k].x *= sheet->step[0];
        cut->points[k].y *= sheet->step[1];
    }
    sheet->unit = pen->unit ? pen->unit : unit->name;
    if (!make_allowed(encoder, scale, problem))
        return false;
    make_sheet(encoder, state);
    return true;
}

void pattern_end(struct encoder *encoder) {
    struct pattern_state *state = encoder->state;
    flat_pattern_free(&state->cut);
    polygons_free(&state->allowed);
}
