/* SPDX-License-Identifier: MIT */
/*
 * The pattern of one drape for cutters, as a sheet of one piece: the cut, or with an allowance the
 * line of that, which then has the cut within it as a seam. The document is written at once, and
 * handed out piece by piece.
 */
#include "cut_sheet.h"
#include "pattern.h"
#include <math.h>
#include <stdio.h>
#include <string.h>

/* The pattern's state comes first: its functions take it for theirs. */
struct cutter_state {
    struct pattern_state pattern;
    struct arena *arena;
    struct api_text text;
    size_t sent;
};

/* `own` of the formats: their pen comes first, for the same reason. */
struct cutter {
    struct pattern_pen pen;
    void (*write)(const struct cut_sheet *sheet, struct api_text *text);
};

static const struct api_unit millimetre = {"mm", 1e-3};

/* The notches in lengths. */
static struct pattern_notch *notches_of(const struct pattern_state *pattern, struct arena *arena) {
    const double *d = pattern->sheet.step;
    size_t count = pattern->cut.notch_count;
    struct pattern_notch *notches = arena_alloc(arena, count + 1, sizeof *notches);
    for (size_t k = 0; notches && k < count; k++) {
        const struct pattern_notch *own = &pattern->cut.notches[k];
        double in[2] = {own->in[0] * d[1], own->in[1] * d[0]}, size = hypot(in[0], in[1]);
        notches[k] =
            (struct pattern_notch){own->p * d[0], own->q * d[1], {in[0] / size, in[1] / size}};
    }
    return notches;
}

static bool begin_cutter(struct encoder *encoder, struct api_problem *problem) {
    struct cutter_state *state = encoder->state;
    const struct cutter *cutter = encoder->format->own;
    struct pattern_state *pattern = &state->pattern;
    const char *name = *encoder->options.ply ? encoder->options.ply : encoder->options.part;
    if (!pattern_begin(encoder, problem))
        return false;
    state->arena = arena_new(SIZE_MAX);
    state->text = api_text_growing(state->arena);
    bool allowed = pattern->allowed.count > 0;
    struct cut_piece piece = {.notch_count = pattern->cut.notch_count,
                              .seam = allowed ? &pattern->cut.polygons : NULL,
                              .zero = {pattern->sheet.zero[0], pattern->sheet.zero[1]}};
    struct nesting_shape shape = {.cut = allowed ? &pattern->allowed : &pattern->cut.polygons,
                                  .layers = 1};
    struct nesting_place place = {0};
    polygons_bounds(shape.cut, shape.low, shape.high);
    shape.area = polygons_area(shape.cut);
    piece.notches = state->arena ? notches_of(pattern, state->arena) : NULL;
    if (!piece.notches)
        return !api_problem_no_memory(problem, "the pattern");
    (void)snprintf(piece.name, sizeof piece.name, "%.20s", *name ? name : "piece");
    (void)snprintf(piece.title, sizeof piece.title, "%.*s", CUT_TITLE_SIZE - 1,
                   pattern->sheet.title);
    const struct cut_roll roll = {.shapes = &shape,
                                  .pieces = &piece,
                                  .count = 1,
                                  .places = &place,
                                  .place_count = 1,
                                  .length = shape.high[0] - shape.low[0],
                                  .area = shape.area};
    const struct cut_sheet sheet = {.unit = &millimetre,
                                    .style = *encoder->options.part ? encoder->options.part
                                                                    : encoder->id,
                                    .revision = encoder->id,
                                    .width = shape.high[1] - shape.low[1],
                                    .rolls = &roll,
                                    .roll_count = 1};
    cutter->write(&sheet, &state->text);
    return !state->text.failed || !api_problem_no_memory(problem, "the pattern");
}

static void next_cutter(struct encoder *encoder) {
    struct cutter_state *state = encoder->state;
    size_t left = state->text.length - state->sent;
    size_t taken = left < ENCODER_PIECE ? left : ENCODER_PIECE;
    api_text_bytes(&encoder->piece, state->text.bytes + state->sent, taken);
    state->sent += taken;
    encoder->ended = taken == left;
}

static void end_cutter(struct encoder *encoder) {
    struct cutter_state *state = encoder->state;
    arena_free(state->arena);
    pattern_end(encoder);
}

static const struct cutter astm = {{.metres = 1e-3, .unit = "mm", .to_cut = true},
                                   cut_sheet_write_astm};
static const struct cutter hpgl = {{.metres = 1e-3, .unit = "mm", .to_cut = true},
                                   cut_sheet_write_hpgl};

#define CUTTER_FORMAT(cutter)                                                                      \
    .uses = FORMAT_PATTERN, .own = &(cutter), .state_size = sizeof(struct cutter_state),           \
    .begin = begin_cutter, .next = next_cutter, .end = end_cutter

const struct format format_astm = {.name = "astm",
                                   .media_type = "image/x-dxf",
                                   .about = "the pattern in DXF by the conventions of ASTM D6673 "
                                            "and AAMA, in millimetres",
                                   .exact = "12 digits",
                                   CUTTER_FORMAT(astm)};

const struct format format_hpgl = {.name = "hpgl",
                                   .media_type = "application/vnd.hp-hpgl",
                                   .about = "the pattern in HP-GL, for plotters and cutters",
                                   .exact = "0.025 mm",
                                   CUTTER_FORMAT(hpgl)};
