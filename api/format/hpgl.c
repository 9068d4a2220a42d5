/* SPDX-License-Identifier: MIT */
/*
 * The roll for a plotter or a cutter that reads HP-GL, as HP's manuals of plotters describe it:
 * instructions of two letters, lengths in units of 0.025 mm, x along the roll. Pen 1 is the knife;
 * it goes round holes before it goes round what they are in. Pen 2 draws on the cloth: notches,
 * arrows of the warp, names, and the revision. Letters end with ETX, which is what labels end with
 * unless it is said otherwise.
 */
#include "cut_sheet.h"

#include <math.h>
#include <stdio.h>
#include <string.h>

enum { KNIFE = 1, MARKER = 2, LETTER_MM = 6, NOTCH_MM = 5 };

static const double units_per_mm = 40;

struct plot {
    struct api_text *text;
    const struct cut_roll *roll;
    double scale; /* units of the sheet's unit */
};

/* A point of a shape in the plotter's units. */
static void plot_point(const struct plot *plot, const struct nesting_place *place, double x,
                       double y, long at[2]) {
    double on_roll[2];
    nesting_point(&plot->roll->shapes[place->shape], place, x, y, on_roll);
    for (int k = 0; k < 2; k++)
        at[k] = lround(on_roll[k] * plot->scale);
}

static void plot_stroke(const struct plot *plot, const struct nesting_place *place, double x,
                        double y, double to_x, double to_y) {
    long from[2], to[2];
    plot_point(plot, place, x, y, from);
    plot_point(plot, place, to_x, to_y, to);
    api_text_format(plot->text, "PU%ld,%ld;PD%ld,%ld;\n", from[0], from[1], to[0], to[1]);
}

static void plot_label(const struct plot *plot, long x, long y, const char *label) {
    api_text_format(plot->text, "PU%ld,%ld;LB%s\003\n", x, y, label);
}

/* ---- what is drawn and what is cut ---- */

static void plot_marks(const struct plot *plot, const struct nesting_place *place,
                       const struct cut_sheet *sheet) {
    const struct cut_piece *piece = &plot->roll->pieces[place->shape];
    const struct nesting_shape *shape = &plot->roll->shapes[place->shape];
    const struct cut_chord grain = cut_chord_of(shape);
    double notch = NOTCH_MM * units_per_mm / plot->scale, head = notch / 2;
    double quarter = (grain.x[1] - grain.x[0]) / 4, tip = grain.x[1] - quarter, y = grain.y;
    char title[CUT_TEXT_SIZE];
    long at[2];
    for (size_t n = 0; n < piece->notch_count; n++) {
        const struct pattern_notch *own = &piece->notches[n];
        plot_stroke(plot, place, own->p, own->q, own->p + notch * own->in[0],
                    own->q + notch * own->in[1]);
    }
    plot_stroke(plot, place, grain.x[0] + quarter, y, tip, y);
    plot_stroke(plot, place, tip - head, y - head / 2, tip, y);
    plot_stroke(plot, place, tip - head, y + head / 2, tip, y);
    plot_point(plot, place, place->turned ? tip : grain.x[0] + quarter, y, at);
    cut_layer_title(plot->roll, place, title);
    plot_label(plot, at[0], at[1] + lround(1.5 * units_per_mm), title);
    (void)snprintf(title, sizeof title, "revision %s", sheet->revision);
    plot_label(plot, at[0], at[1] - lround(1.5 * LETTER_MM * units_per_mm), title);
}

/* Round all holes, or round all else. */
static void plot_cuts(const struct plot *plot, const struct nesting_place *place, bool holes) {
    const struct polygons *cut = plot->roll->shapes[place->shape].cut;
    for (size_t first = 0, end; first < cut->count; first = end) {
        bool hole = polygons_loop_area(cut, first, &end) < 0;
        size_t count = end - first;
        for (size_t k = 0; k <= count && holes == hole; k++) {
            const struct polygons_point *p = &cut->points[first + k % count];
            long at[2];
            plot_point(plot, place, p->x, p->y, at);
            api_text_format(plot->text, "%s%ld,%ld;\n", k ? "PD" : "PU", at[0], at[1]);
        }
    }
}

void cut_sheet_write_hpgl(const struct cut_sheet *sheet, struct api_text *text) {
    const struct cut_roll *roll = sheet->rolls;
    const struct plot plot = {text, roll, sheet->unit->metres * 1000 * units_per_mm};
    char summary[CUT_TEXT_SIZE];
    cut_sheet_summary(sheet, roll, summary);
    /* Letters are given in cm. */
    api_text_format(text, "IN;PA;SP%d;SI%.2f,%.2f;\n", MARKER, LETTER_MM / 15.0, LETTER_MM / 10.0);
    plot_label(&plot, lround(roll->length * plot.scale + LETTER_MM * units_per_mm), 0, summary);
    for (size_t n = 0; n < roll->place_count; n++)
        plot_marks(&plot, &roll->places[n], sheet);
    api_text_format(text, "PU;SP%d;\n", KNIFE);
    for (size_t n = 0; n < roll->place_count; n++)
        for (int holes = 1; holes >= 0; holes--)
            plot_cuts(&plot, &roll->places[n], holes);
    api_text_raw(text, "PU;SP0;\n");
}
