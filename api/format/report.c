/* SPDX-License-Identifier: MIT */
/*
 * A report to print and to file: one HTML page without scripts, links or anything from elsewhere,
 * for one or two sheets of A4. The part with its shear, the summary, the warnings; the flat pattern
 * with its dimensions; what was asked for, and by which versions it was answered. The picture is a
 * PNG within it; the pattern is drawn as for `svg`.
 */
#include "api/result/stored_cuts.h"
#include "html.h"
#include "inputs.h"
#include "part_picture.h"
#include "png.h"
#include "svg.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum {
    CODED = 48 * 1024, /* bytes of the picture in one piece; a multiple of 3 */
    VALUE_SHOWN = 200, /* bytes of an input */
    LEGEND = 120,      /* pixels below the picture */
    SCALE_STEPS = 50,
    TICKS = 5
};

enum stage { AT_HEAD, AT_PICTURE, AT_SCALE, AT_PATTERN, AT_INPUTS };

/* The pattern's state comes first: its functions take it for theirs. */
struct state {
    struct pattern_state pattern;
    struct part_picture picture;
    uint8_t *png;
    size_t png_length, sent;
    struct inputs inputs;
    enum stage stage;
};

/* ---- tables ---- */

/* A row of a table of names and values; `end_row` closes it. */
static void begin_row(struct api_text *text, const char *name) {
    api_text_raw(text, "<tr><th scope=\"row\">");
    html_say(text, "%s", name);
    api_text_raw(text, "</th><td>");
}

static void end_row(struct api_text *text) {
    api_text_raw(text, "</td></tr>\n");
}

static void write_report_row(struct api_text *text, const char *name, const char *value) {
    if (!value || !*value)
        return;
    begin_row(text, name);
    html_say(text, "%s", value);
    end_row(text);
}

/* ---- the head ---- */

static const char style[] =
    "@page{size:A4;margin:14mm}"
    "body{font:10pt/1.4 'Liberation Sans',Arial,sans-serif;color:#1b2330;background:#fff;"
    "max-width:182mm;margin:0 auto;padding:1em}"
    "h1{font-size:17pt;margin:0}h2{font-size:11pt;margin:1.2em 0 .3em;break-after:avoid}"
    "p{margin:.2em 0}ul{margin:.2em 0;padding-left:1.3em}"
    "table{border-collapse:collapse;width:100%;font-size:9pt;font-variant-numeric:tabular-nums}"
    "th{text-align:left;font-weight:400;color:#566072;padding:1px 1em 1px 0;white-space:nowrap}"
    "td{padding:1px 0;overflow-wrap:anywhere;width:99%}"
    "tr,li,figure{break-inside:avoid}"
    ".columns{columns:2;column-gap:8mm}"
    "figure{margin:.6em 0;text-align:center}"
    "svg{max-width:100%;overflow:visible;font-family:'Liberation Sans',Arial,sans-serif}"
    ".part svg{width:100%;max-height:105mm}.pattern svg{width:100%;max-height:135mm}"
    ".pattern{break-before:page}figcaption{font-size:8.5pt;color:#566072;text-align:left}"
    ".partial{color:#b3172b;font-weight:700}"
    "@media print{body{padding:0}}";

/* Up to the picture's bytes. */
static void write_page_head(struct encoder *encoder) {
    const struct api_summary *summary = &encoder->columns.summary;
    const struct state *state = encoder->state;
    const struct raster *raster = &state->picture.raster;
    bool named = encoder->options.part[0] || encoder->options.ply[0];
    const char *title = named ? state->pattern.sheet.title : encoder->id;
    bool complete = summary->outcome == DRAPE_COMPLETE;
    struct api_text *text = &encoder->piece;
    api_text_raw(text, "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
                       "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src "
                       "'none'; style-src 'unsafe-inline'; img-src data:\">\n"
                       "<meta name=\"viewport\" content=\"width=device-width\">\n<title>");
    html_say(text, "%s%s", named ? "" : "Drape ", title);
    api_text_raw(text, "</title>\n<style>");
    api_text_raw(text, style);
    api_text_raw(text, "</style>\n</head>\n<body>\n<header>\n<h1>");
    html_say(text, "%s%s", named ? "" : "Drape ", title);
    api_text_raw(text, complete ? "</h1>\n<p>" : "</h1>\n<p class=\"partial\">");
    html_say(text, "%s: %.4g %% of the part is covered, the greatest shear is %.1f degrees.",
             complete ? "Complete" : "Partial", 100 * summary->cloth_coverage,
             summary->max_shear_deg);
    api_text_format(text,
                    "</p>\n</header>\n<figure class=\"part\">\n"
                    "<svg role=\"img\" aria-label=\"The draped part, coloured by its shear\" "
                    "viewBox=\"0 0 %d %d\">\n"
                    "<image width=\"%d\" height=\"%d\" href=\"data:image/png;base64,",
                    raster->width, raster->height + LEGEND, raster->width, raster->height);
}

/* ---- the part ---- */

/* What follows the picture's bytes: names of the directions, the start, and the legend below: on
 * its left the colours from 0 to the range, on its right a bar of 1, 2 or 5 times a power of ten.
 */
static void end_picture(struct encoder *encoder) {
    static const char *const names[] = {"warp", "weft"}, *const colours[] = {"#b45f06", "#0b6aa2"};
    enum { LEFT = 30, LENGTH = 700, THICK = 24, RIGHT = 1470, BAR_MOST = 500 };
    const struct part_picture *picture = &((struct state *)encoder->state)->picture;
    struct api_text *text = &encoder->piece;
    api_text_raw(text, "\"/>\n<g font-size=\"26\" fill=\"#1b2330\">\n");
    for (int k = 0; k < 2; k++)
        api_text_format(
            text,
            "<text x=\"%.1f\" y=\"%.1f\" fill=\"%s\" stroke=\"#fff\" stroke-width=\"6\" "
            "paint-order=\"stroke\" font-weight=\"700\">%s</text>\n",
            picture->end[k][0] + 8, picture->end[k][1] - 8, colours[k], names[k]);
    api_text_format(text,
                    "<circle cx=\"%.1f\" cy=\"%.1f\" r=\"9\" fill=\"#fff\" stroke=\"#1b2330\" "
                    "stroke-width=\"4\"/>\n",
                    picture->start[0], picture->start[1]);
    int top = picture->raster.height + 20, y = picture->raster.height + 32;
    for (int k = 0; k < SCALE_STEPS; k++) {
        uint8_t rgb[3];
        part_picture_colour((k + 0.5) / SCALE_STEPS, rgb);
        api_text_format(
            text, "<rect x=\"%d\" y=\"%d\" width=\"%d\" height=\"%d\" fill=\"#%02x%02x%02x\"/>\n",
            LEFT + k * LENGTH / SCALE_STEPS, top, LENGTH / SCALE_STEPS + 1, THICK, rgb[0], rgb[1],
            rgb[2]);
    }
    for (int k = 0; k <= TICKS; k++)
        api_text_format(text, "<text x=\"%d\" y=\"%d\" text-anchor=\"middle\">%.3g</text>\n",
                        LEFT + k * LENGTH / TICKS, top + THICK + 30,
                        k * picture->range_deg / TICKS);
    api_text_format(text, "<text x=\"%d\" y=\"%d\">Absolute shear of the cells, degrees</text>\n",
                    LEFT, top + THICK + 64);
    double length = pattern_round_length(BAR_MOST / picture->scale);
    api_text_format(
        text,
        "<path d=\"M%.1f %dv-12v24v-12H%dv-12v24\" fill=\"none\" stroke=\"#1b2330\" "
        "stroke-width=\"3\"/>\n"
        "<text x=\"%d\" y=\"%d\" text-anchor=\"end\">%g %s at right angles to the view</text>\n",
        RIGHT - length * picture->scale, y, RIGHT, RIGHT, y + 42, length,
        encoder->columns.unit->name);
    api_text_raw(text, "</g>\n</svg>\n<figcaption>");
    html_say(text, "Parallel projection, seen from the side that warp x weft points to. The circle "
                   "is the start, the dark line the edge of the part; the cloth is coloured by its "
                   "cells up to this line. ");
    if (picture->yarns == 1)
        html_say(text, "Every yarn is drawn.");
    else
        html_say(text, "One yarn in %d is drawn.", picture->yarns);
    if (encoder->columns.summary.locked_cells > 0)
        html_say(text, " Cells beyond the locking angle are hatched.");
    api_text_raw(text, "</figcaption>\n</figure>\n");
}

/* ---- the numbers ---- */

/* What the report says of the summary; with a factor, a format and, of lengths, their power. */
static const struct {
    const char *name;
    size_t offset;
    double factor;
    const char *unit;
    int power;     /* of the length unit */
    bool optional; /* there is none when it is negative */
} figures[] = {
#define MEMBER(name) offsetof(struct api_summary, name)
    {"Covered area", MEMBER(cloth_coverage), 100, " %", 0, false},
    {"In whole cells", MEMBER(coverage), 100, " %", 0, false},
    {"Greatest shear", MEMBER(max_shear_deg), 1, " degrees", 0, false},
    {"Error of the greatest shear, at most", MEMBER(max_shear_error_deg), 1, " degrees", 0, true},
    {"95 % of the area below", MEMBER(p95_shear_deg), 1, " degrees", 0, false},
    {"Mean shear", MEMBER(mean_shear_deg), 1, " degrees", 0, false},
    {"Locked cells", MEMBER(locked_cells), 1, "", 0, true},
    {"Greatest severity of shear", MEMBER(severity_max), 1, "", 0, true},
    {"Cells beyond the packing limit", MEMBER(packing_exceeded_cells), 1, "", 0, true},
    {"Area of the part", MEMBER(part_area), 1, "", 2, false},
    {"Area of the cloth", MEMBER(cloth_area), 1, "", 2, false},
    {"Area of the pattern", MEMBER(flat_area), 1, "", 2, false},
    {"Volume of the fibres", MEMBER(fiber_volume), 1, "", 3, true},
    {"Volume left for resin", MEMBER(pore_volume), 1, "", 3, true},
    {"Error of the thickness, at most", MEMBER(thickness_error_max), 1, "", 1, true},
    {"Error of a node's position, at most", MEMBER(error_estimate_max), 1, "", 1, true},
    {"Greatest edge error, relative", MEMBER(residual_max), 1, "", 0, false},
#undef MEMBER
};

static void write_report_cuts(struct encoder *encoder) {
    const struct api_columns *columns = &encoder->columns;
    struct stored_cut cuts[API_CUTS_MAX];
    if (!stored_cuts_read(encoder->reader, columns, cuts)) {
        encoder->failed = true;
        return;
    }
    api_text_raw(&encoder->piece, columns->cut_count ? "<h2>Cuts</h2>\n<ul>\n" : "");
    for (size_t k = 0; k < columns->cut_count; k++) {
        char line[STORED_CUT_TEXT];
        stored_cut_describe(&cuts[k], columns->unit->name, line);
        api_text_raw(&encoder->piece, "<li>");
        html_say(&encoder->piece, "%s", line);
        api_text_raw(&encoder->piece, "</li>\n");
    }
    api_text_raw(&encoder->piece, columns->cut_count ? "</ul>\n" : "");
}

/* The summary, the cuts and the warnings, up to the pattern. */
static void write_report_results(struct encoder *encoder) {
    static const char *const powers[] = {"", "", "²", "³"};
    const struct api_columns *columns = &encoder->columns;
    const struct api_summary *summary = &columns->summary;
    const struct api_warnings *warnings = &summary->warnings;
    const double *at = summary->max_shear_at + 2;
    double size = fmax(fmax(fabs(at[0]), fabs(at[1])), fabs(at[2]));
    struct api_text *text = &encoder->piece;
    api_text_raw(text, "<h2>Summary</h2>\n<div class=\"columns\"><table>\n");
    begin_row(text, "Verdict");
    html_say(text, "%s", summary->verdict.detail);
    end_row(text);
    begin_row(text, "Net");
    html_say(text, "%zu nodes, %zu cells of %g x %g %s", summary->nodes, summary->cells,
             columns->grid.spacing[0], columns->grid.spacing[1], columns->unit->name);
    end_row(text);
    for (size_t k = 0; k < sizeof figures / sizeof *figures; k++) {
        double value;
        memcpy(&value, (const char *)summary + figures[k].offset, sizeof value);
        if (figures[k].optional && value < 0)
            continue;
        begin_row(text, figures[k].name);
        html_say(text, "%.*g%s", figures[k].power ? 6 : 4, figures[k].factor * value,
                 figures[k].unit);
        if (figures[k].power)
            html_say(text, " %s%s", columns->unit->name, powers[figures[k].power]);
        end_row(text);
    }
    if (summary->error_estimate_max < 0) {
        begin_row(text, "Numerical errors");
        html_say(text, "this method estimates none; gib4 does");
        end_row(text);
    }
    begin_row(text, "Greatest shear at");
    for (int k = 0; k < 3; k++) /* a coordinate that is nothing beside the others is 0 */
        html_say(text, "%s%.5g", k ? ", " : "", fabs(at[k]) < 1e-9 * size ? 0 : at[k]);
    html_say(text, " %s", columns->unit->name);
    end_row(text);
    if (summary->max_shear_grown_deg >= 0) {
        begin_row(text, "Grown cloth");
        html_say(text, "%.3g %% of the cloth, sheared up to %.4g degrees; the other up to %.4g",
                 100 * summary->grown_area / summary->cloth_area, summary->max_shear_grown_deg,
                 summary->max_shear_pinned_deg);
        end_row(text);
    }
    api_text_raw(text, "</table></div>\n");
    write_report_cuts(encoder);
    api_text_raw(text, "<h2>Warnings</h2>\n");
    api_text_raw(text, warnings->count ? "<ul>\n" : "<p>None.</p>\n");
    for (size_t k = 0; k < warnings->count; k++) {
        api_text_raw(text, "<li><b>");
        html_say(text, "%s", warnings->list[k].code);
        api_text_raw(text, "</b>: ");
        html_say(text, "%s", warnings->list[k].detail);
        api_text_raw(text, "</li>\n");
    }
    if (warnings->count)
        api_text_raw(text, "</ul>\n");
    api_text_raw(text, "<figure class=\"pattern\">\n<figcaption>Flat pattern: where to cut, with "
                       "the directions of warp and weft from the start");
    if (encoder->options.allowance > 0)
        html_say(text, ", and %g %s outside", encoder->options.allowance, columns->unit->name);
    api_text_raw(text, ". Not to scale: to cut by it, take the SVG or DXF.</figcaption>\n");
}

/* ---- inputs and versions ---- */

/* As many rows as surely fit into a piece. */
static void write_inputs(struct encoder *encoder) {
    enum { ROWS = 32 };
    struct state *state = encoder->state;
    struct api_text *text = &encoder->piece;
    struct inputs_row input;
    for (int k = 0; k < ROWS; k++) {
        if (inputs_next(&state->inputs, &input)) {
            size_t length = input.length < VALUE_SHOWN ? input.length : VALUE_SHOWN;
            while (length > 0 && length < input.length && (input.value[length] & 0xc0) == 0x80)
                length--; /* characters are not cut in two */
            begin_row(text, input.name);
            if (input.count)
                html_say(text, "%zu entries", input.count);
            else
                html_escape(text, input.value, length);
            if (!input.count && length < input.length)
                api_text_raw(text, " …");
            end_row(text);
            continue;
        }
        api_text_raw(text, "</table></div>\n<h2>Versions</h2>\n"
                           "<div class=\"columns\"><table>\n");
        write_report_row(text, "Drape", encoder->id);
        write_report_row(text, "Digest of the request", encoder->record.digest);
        write_report_row(text, "Finished", encoder->record.finished);
        write_report_row(text, "Solver", encoder->columns.summary.solver_version);
        write_report_row(text, "Report by", encoder->record.program);
        api_text_raw(text, "</table></div>\n</body>\n</html>\n");
        encoder->ended = true;
        return;
    }
}

/* ---- the whole ---- */

static void next_html(struct encoder *encoder) {
    static const char digits[] = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    struct state *state = encoder->state;
    size_t end = state->png_length - state->sent > CODED ? state->sent + CODED : state->png_length;
    switch (state->stage) {
    case AT_HEAD:
        write_page_head(encoder);
        state->stage = AT_PICTURE;
        break;
    case AT_PICTURE: /* its next bytes in Base64 (RFC 4648) */
        for (; state->sent < end; state->sent += 3) {
            char four[4] = "====";
            size_t left = end - state->sent;
            const uint8_t *bytes = state->png + state->sent;
            uint32_t bits = (uint32_t)bytes[0] << 16 | (left > 1 ? (uint32_t)bytes[1] << 8 : 0) |
                            (left > 2 ? bytes[2] : 0);
            for (size_t k = 0; k < 4 && k <= left; k++)
                four[k] = digits[bits >> (18 - 6 * k) & 63];
            api_text_bytes(&encoder->piece, four, 4);
        }
        state->stage = end == state->png_length ? AT_SCALE : AT_PICTURE;
        break;
    case AT_SCALE:
        end_picture(encoder);
        write_report_results(encoder);
        state->stage = AT_PATTERN;
        break;
    case AT_PATTERN:
        pattern_next(encoder);
        if (!encoder->ended)
            break;
        encoder->ended = false;
        state->stage = AT_INPUTS;
        api_text_raw(&encoder->piece, "</figure>\n<h2>Inputs</h2>\n"
                                      "<div class=\"columns\"><table>\n");
        break;
    case AT_INPUTS:
        write_inputs(encoder);
        break;
    }
}

static bool begin_html(struct encoder *encoder, struct api_problem *problem) {
    struct state *state = encoder->state;
    struct part_picture *picture = &state->picture;
    state->inputs = inputs_of(encoder->record.inputs ? encoder->record.inputs : "");
    if (part_picture_draw(picture, encoder->reader, &encoder->columns, problem) != API_OK ||
        !pattern_begin(encoder, problem))
        return false;
    state->png = png_encode(&picture->raster, &state->png_length);
    if (!state->png)
        api_problem_set(problem, API_OUT_OF_MEMORY, "no memory for the picture");
    return state->png != NULL;
}

static void end_html(struct encoder *encoder) {
    struct state *state = encoder->state;
    pattern_end(encoder);
    raster_free(&state->picture.raster);
    free(state->png);
}

const struct format format_html = {.name = "html",
                                   .uses = FORMAT_REPORT | FORMAT_BOOK,
                                   .media_type = "text/html",
                                   .about = "a page to print and file: part, pattern, summary, "
                                            "warnings, inputs, versions",
                                   .exact = "four to six digits",
                                   .own = &svg_inset,
                                   .state_size = sizeof(struct state),
                                   .begin = begin_html,
                                   .next = next_html,
                                   .end = end_html};
