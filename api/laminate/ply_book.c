/* SPDX-License-Identifier: MIT */
#include "ply_book.h"

#include "account.h"
#include "api/format/html.h"
#include "api/format/pattern.h"
#include "api/result/stored_cuts.h"
#include "laying.h"
#include <math.h>

enum { FIGURE = 600 /* pixels of the longer side of a pattern */ };

struct ply_book {
    const struct laminate *laminate;
    const struct api_reader *const *nets;
    const struct flat_plies *shapes;
    const struct cut_sheet *sheet;
    struct api_text *text;
    struct api_columns columns; /* of the ply that is written */
    bool read;                  /* they could be */
};

static const char style[] =
    "@page{size:A4 landscape;margin:12mm}"
    "body{font:10pt/1.4 'Liberation Sans',Arial,sans-serif;color:#1b2330;background:#fff;"
    "max-width:270mm;margin:0 auto;padding:1em}"
    "h1{font-size:17pt;margin:0}h2{font-size:12pt;margin:0 0 .3em}"
    "table{border-collapse:collapse;width:100%;font-size:9pt;font-variant-numeric:tabular-nums}"
    "th{text-align:left;font-weight:400;color:#566072;border-bottom:1px solid #1b2330}"
    "th,td{padding:2px .8em 2px 0}td{border-bottom:1px solid #d5dae3}"
    "section{break-inside:avoid;margin-top:1.5em}ul{margin:.2em 0;padding-left:1.3em}"
    "svg{max-width:100%;max-height:85mm;font-family:'Liberation Sans',Arial,sans-serif}"
    ".failed{color:#b3172b;font-weight:700}"
    "@media print{body{padding:0}section{break-before:page}}";

/* ---- one ply ---- */

static const struct flat_ply *shape_of(const struct ply_book *book, size_t k) {
    for (size_t n = 0; n < book->shapes->count; n++)
        if (book->shapes->shapes[n].ply == k)
            return &book->shapes->shapes[n];
    return NULL;
}

static void open_ply(struct ply_book *book, size_t k) {
    const struct api_reader *net = book->nets[book->laminate->plies[k].net];
    struct api_problem problem = {0};
    book->read = net && api_columns_open(net, &book->columns, &problem) == API_OK;
}

/* In square metres, without allowance. */
static double ply_area(const struct ply_book *book, size_t k) {
    const struct flat_ply *shape = shape_of(book, k);
    double metres = book->laminate->length_unit->metres;
    return shape ? shape->area * metres * metres : 0;
}

/* Of all its layers, in kg; 0 where it is not known. */
static double ply_mass(const struct ply_book *book, size_t k) {
    const struct laminate_ply *ply = &book->laminate->plies[k];
    return laminate_layers(ply) * ply->areal_weight * ply_area(book, k);
}

/* The roll that a ply is cut from; NULL: it is not. */
static const struct cut_roll *roll_of(const struct ply_book *book, size_t k) {
    const struct flat_ply *shape = shape_of(book, k);
    for (size_t r = 0; shape && r < book->sheet->roll_count; r++)
        for (size_t n = 0; n < book->sheet->rolls[r].count; n++)
            if (book->sheet->rolls[r].shapes[n].cut == &shape->cut)
                return &book->sheet->rolls[r];
    return NULL;
}

/* Of all its layers with their share of what is wasted of the roll; 0 where no price is known. */
static double ply_cost(const struct ply_book *book, size_t k) {
    const struct laminate_ply *ply = &book->laminate->plies[k];
    const struct cut_roll *roll = roll_of(book, k);
    double waste = roll ? roll->length * book->sheet->width / roll->area : 0;
    return ply->price * laminate_layers(ply) * ply_area(book, k) * waste;
}

static void write_warp(struct api_text *text, const struct drape_settings *settings) {
    const struct vec3 *v = &settings->direction_vector;
    if (settings->direction_kind == DRAPE_DIRECTION_VECTOR)
        html_say(text, "along (%g, %g, %g)", v->x, v->y, v->z);
    else
        html_say(text, "%g°", settings->direction_deg);
}

static void write_start_point(const struct ply_book *book) {
    const struct vec3 *at = &book->columns.start.point;
    if (book->read)
        html_say(book->text, "%.5g, %.5g, %.5g", at->x, at->y, at->z);
}

static void next_table_cell(struct api_text *text) {
    api_text_raw(text, "</td><td>");
}

static void write_ply_row(struct ply_book *book, size_t k) {
    const struct laminate_ply *ply = &book->laminate->plies[k];
    struct api_text *text = book->text;
    open_ply(book, k);
    api_text_raw(text, "<tr><td>");
    char title[LAMINATE_TITLE_SIZE];
    laminate_title(ply, title);
    html_say(text, "%zu", ply->number + 1);
    next_table_cell(text);
    html_say(text, "%s", title);
    next_table_cell(text);
    html_say(text, "%d", laminate_layers(ply));
    next_table_cell(text);
    write_warp(text, &ply->drape.settings);
    next_table_cell(text);
    write_start_point(book);
    next_table_cell(text);
    api_text_raw(text, ply->boundary.count      ? "its own"
                       : laminate_is_split(ply) ? "its splits"
                       : ply->pieces            ? "its roll"
                                                : "the part");
    next_table_cell(text);
    if (shape_of(book, k))
        html_say(text, "%.5g", ply_area(book, k));
    next_table_cell(text);
    if (ply->areal_weight > 0)
        html_say(text, "%g", ply->areal_weight);
    next_table_cell(text);
    if (ply_mass(book, k) > 0)
        html_say(text, "%.5g", ply_mass(book, k));
    next_table_cell(text);
    if (ply_cost(book, k) > 0)
        html_say(text, "%.5g", ply_cost(book, k));
    next_table_cell(text);
    if (shape_of(book, k))
        html_say(text, "%.1f°", shape_of(book, k)->max_shear_deg);
    else
        api_text_raw(text, "<span class=\"failed\">not draped</span>");
    api_text_raw(text, "</td></tr>\n");
}

/* ---- its pattern ---- */

/* The yarns that are smoothed first, from where they are begun, and the places of the greatest
 * shear of each sector by its number. */
static void draw_laying(struct api_text *text, const struct flat_ply *shape, double scale,
                        const struct laying *laying) {
    double x = (laying->begin[0] - shape->low[0]) * scale;
    double y = (shape->high[1] - laying->begin[1]) * scale;
    const double(*reach)[2] = laying->reach;
    api_text_format(text,
                    "<path d=\"M%.2f %.2fH%.2fM%.2f %.2fV%.2f\" fill=\"none\" stroke=\"#566072\" "
                    "stroke-dasharray=\"6 4\"/>\n<circle cx=\"%.2f\" cy=\"%.2f\" r=\"4\"/>\n",
                    x - reach[0][0] * scale, y, x + reach[0][1] * scale, x, y + reach[1][0] * scale,
                    y - reach[1][1] * scale, x, y);
    for (int k = 0; k < LAYING_SECTORS && laying->sectors[k].cells; k++)
        api_text_format(text,
                        "<text x=\"%.2f\" y=\"%.2f\" font-size=\"16\" font-weight=\"700\" "
                        "text-anchor=\"middle\">%d</text>\n",
                        (laying->sectors[k].flat[0] - shape->low[0]) * scale,
                        (shape->high[1] - laying->sectors[k].flat[1]) * scale + 5, k + 1);
}

static void draw_pattern(const struct ply_book *book, const struct flat_ply *shape,
                         const struct laying *laying) {
    struct api_text *text = book->text;
    double length = shape->high[0] - shape->low[0], width = shape->high[1] - shape->low[1];
    const struct polygons *cut = &shape->cut;
    double longest = fmax(length, width), scale = longest > 0 ? FIGURE / longest : 1;
    double arrow = length * scale / 4, x = length * scale * 3 / 8, y = width * scale / 2;
    api_text_format(text,
                    "<svg role=\"img\" aria-label=\"Flat pattern\" viewBox=\"-4 -4 %.2f %.2f\" ",
                    length * scale + 8, width * scale + 8);
    api_text_format(text, "width=\"%.0f\">\n", length * scale + 8);
    api_text_raw(text, "<path fill=\"#eef2f8\" stroke=\"#1b2330\" "
                       "stroke-width=\"1.5\" d=\"");
    for (size_t n = 0; n < cut->count; n++) /* y upwards, at a scale that fits the figure */
        api_text_format(text, "%s%.2f %.2f%s", n == 0 || cut->points[n - 1].last ? "M" : "L",
                        (cut->points[n].x - shape->low[0]) * scale,
                        (shape->high[1] - cut->points[n].y) * scale,
                        cut->points[n].last ? "Z" : "");
    api_text_raw(text, "\"/>\n");
    api_text_format(text,
                    "<path d=\"M%.2f %.2fh%.2fm-10-5l10 5-10 5\" fill=\"none\" stroke=\"#b45f06\" "
                    "stroke-width=\"2\"/>\n",
                    x, y, arrow);
    api_text_format(text,
                    "<text x=\"%.2f\" y=\"%.2f\" font-size=\"14\" fill=\"#b45f06\">warp</text>\n",
                    x, y - 8);
    double zero[2];
    pattern_flat_zero(&book->columns.start, zero);
    if (zero[0] != 0 || zero[1] != 0)
        api_text_format(text,
                        "<path d=\"M%.2f %.2fl%.2f %.2f\" fill=\"none\" stroke=\"#0b6aa2\" "
                        "stroke-width=\"2\"/>\n<text x=\"%.2f\" y=\"%.2f\" font-size=\"14\" "
                        "fill=\"#0b6aa2\">0°</text>\n",
                        x, y, arrow * zero[0], -arrow * zero[1], x + 1.1 * arrow * zero[0],
                        y - 1.1 * arrow * zero[1]);
    if (laying)
        draw_laying(text, shape, scale, laying);
    api_text_raw(text, "</svg>\n<p>");
    html_say(text, "%.5g along the warp, %.5g across, in %s; %d of it.", length, width,
             book->laminate->length_unit->name,
             laminate_layers(&book->laminate->plies[shape->ply]));
    api_text_raw(text, "</p>\n");
}

/* Where to begin, in which order to go on, and what shear is to be worked in where. */
static void write_laying(const struct ply_book *book, const struct laying *laying) {
    static const double no_shear = 0.05; /* degrees: it is written as 0.0 */
    struct api_text *text = book->text;
    const double(*reach)[2] = laying->reach;
    const struct vec3 *at = &laying->place;
    api_text_raw(text, "<ol>\n<li>");
    html_say(text, "Fix it at %s, %.5g, %.5g, %.5g.",
             laying->at_start ? "the start" : "the middle of its longest line along the warp",
             at->x, at->y, at->z);
    api_text_raw(text, "</li>\n<li>");
    html_say(
        text,
        "Smooth it along the warp, %.4g back and %.4g ahead, then along the weft, %.4g back and "
        "%.4g ahead (dashed).",
        reach[0][0], reach[0][1], reach[1][0], reach[1][1]);
    api_text_raw(text, "</li>\n<li>");
    if (fabs(laying->sectors[0].greatest_deg) < no_shear &&
        book->columns.summary.max_shear_deg < no_shear) {
        api_text_raw(text,
                     "Smooth it outwards from these: nothing is to be sheared.</li>\n</ol>\n");
        return;
    }
    api_text_raw(text,
                 "Work outwards from these to the edge, sector after sector; where the shear is "
                 "greatest is numbered in the drawing.</li>\n</ol>\n<table>\n<tr><th>Sector</th>"
                 "<th>Between</th><th>Shear, mean</th><th>greatest</th><th>at</th>"
                 "<th>Draw out along</th><th>Cells that lock</th></tr>\n");
    for (int k = 0; k < LAYING_SECTORS && laying->sectors[k].cells; k++) {
        const struct laying_sector *sector = &laying->sectors[k];
        bool sheared = fabs(sector->greatest_deg) >= no_shear;
        api_text_raw(text, "<tr><td>");
        html_say(text, "%d", k + 1);
        next_table_cell(text);
        html_say(text, "%cwarp, %cweft", sector->warp > 0 ? '+' : '-',
                 sector->weft > 0 ? '+' : '-');
        next_table_cell(text);
        html_say(text, "%.1f°", sector->mean_deg);
        next_table_cell(text);
        html_say(text, "%.1f°", fabs(sector->greatest_deg));
        next_table_cell(text);
        html_say(text, "%.5g, %.5g, %.5g", sector->place.x, sector->place.y, sector->place.z);
        next_table_cell(text);
        /* Where the quadrant between +warp and +weft closes the cloth is longer between them. */
        api_text_raw(text, !sheared                   ? ""
                           : sector->greatest_deg > 0 ? "+warp +weft"
                                                      : "+warp -weft");
        next_table_cell(text);
        html_say(text, "%zu", sector->locked);
        api_text_raw(text, "</td></tr>\n");
    }
    api_text_raw(text, "</table>\n");
}

static void write_ply_cuts(const struct ply_book *book, const struct api_reader *net) {
    struct stored_cut cuts[API_CUTS_MAX];
    bool read = stored_cuts_read(net, &book->columns, cuts);
    for (size_t k = 0; k < book->columns.cut_count && read; k++) {
        char line[STORED_CUT_TEXT];
        stored_cut_describe(&cuts[k], book->columns.unit->name, line);
        api_text_raw(book->text, "<li>");
        html_say(book->text, "Cut %s", line);
        api_text_raw(book->text, "</li>\n");
    }
}

static void write_ply_section(struct ply_book *book, size_t k) {
    const struct laminate_ply *ply = &book->laminate->plies[k];
    const struct flat_ply *shape = shape_of(book, k);
    const struct api_summary *summary = &book->columns.summary;
    const struct api_warnings *warnings = &summary->warnings;
    struct api_text *text = book->text;
    open_ply(book, k);
    api_text_raw(text, "<section>\n<h2>");
    char title[LAMINATE_TITLE_SIZE];
    laminate_title(ply, title);
    html_say(text, "%zu  %s", ply->number + 1, title);
    api_text_raw(text, "</h2>\n");
    if (!book->read) {
        api_text_raw(text, "<p class=\"failed\">This ply could not be draped.</p>\n</section>\n");
        return;
    }
    api_text_raw(text, "<p>Warp ");
    write_warp(text, &ply->drape.settings);
    html_say(text, " at the start, ");
    write_start_point(book);
    if (shape)
        html_say(text, ". %.4g %% of %s is covered, the greatest shear is %.1f°",
                 100 * shape->covered, ply->boundary.count ? "its boundary" : "the part",
                 shape->max_shear_deg);
    if (shape && shape->locked_cells > 0)
        html_say(text, ", and %.0f cells shear beyond the locking angle", shape->locked_cells);
    html_say(text, ". Revision %s.", book->laminate->revision);
    api_text_raw(text, "</p>\n");
    struct laying laying;
    bool laid = shape && laying_find(book->nets[ply->net], &book->columns, &ply->drape.fabric,
                                     shape, &laying);
    if (shape)
        draw_pattern(book, shape, laid ? &laying : NULL);
    if (laid)
        write_laying(book, &laying);
    api_text_raw(text, "<ul>\n");
    write_ply_cuts(book, book->nets[ply->net]);
    for (size_t n = 0; n < warnings->count; n++) {
        if (!flat_plies_concerns(book->laminate, k, &warnings->list[n]))
            continue;
        api_text_raw(text, "<li>");
        html_say(text, "%s: %s", warnings->list[n].code, warnings->list[n].detail);
        api_text_raw(text, "</li>\n");
    }
    api_text_raw(text, "</ul>\n");
    api_text_raw(text, "</section>\n");
}

/* ---- the whole ---- */

/* What all patterns take together. */
static void write_sums(const struct ply_book *book, const struct cut_sheet *sheet) {
    const struct laminate *laminate = book->laminate;
    char summary[CUT_TEXT_SIZE];
    struct api_text *text = book->text;
    double area = 0, mass = 0;
    size_t weighed = 0;
    for (size_t k = 0; k < laminate->count; k++) {
        area += laminate_layers(&laminate->plies[k]) * ply_area(book, k);
        mass += ply_mass(book, k);
        weighed += ply_mass(book, k) > 0;
    }
    api_text_raw(text, "<p>");
    html_say(text, "Cloth %.5g m²", area);
    if (weighed)
        html_say(text, ", mass %.5g kg%s", mass,
                 weighed < laminate->count ? " of those plies whose "
                                             "areal weight is known"
                                           : "");
    html_say(text, "; areas are those of one layer.");
    for (size_t r = 0; r < sheet->roll_count; r++) {
        const struct cut_roll *roll = &sheet->rolls[r];
        cut_sheet_summary(sheet, roll, summary);
        api_text_raw(text, "<br>");
        html_say(text, "%s%s%s.", roll->cloth, *roll->cloth ? ": " : "", summary);
        double cost = 0;
        for (size_t k = 0; k < laminate->count; k++)
            cost += roll_of(book, k) == roll ? ply_cost(book, k) : 0;
        if (cost > 0)
            html_say(text, " It costs %.5g.", cost);
    }
    api_text_raw(text, "</p>\n");
}

/* Writes the head of a table in front of its first row, with the columns that are named. */
static void begin_table(struct ply_book *book, const char *title, const char *const *heads,
                        size_t count) {
    struct api_text *text = book->text;
    api_text_raw(text, "<h2>");
    html_say(text, "%s", title);
    api_text_raw(text, "</h2>\n<table>\n<tr>");
    for (size_t n = 0; n < count; n++) {
        api_text_raw(text, "<th>");
        html_say(text, "%s", heads[n]);
        api_text_raw(text, "</th>");
    }
    api_text_raw(text, "</tr>\n");
}

/* The first cell of a row: what ply it is of. */
static void begin_ply_row(struct ply_book *book, const struct laminate_ply *ply) {
    api_text_raw(book->text, "<tr><td>");
    html_say(book->text, "%zu %s", ply->number + 1, ply->name);
    next_table_cell(book->text);
}

/* The seams of a ply of several pieces, below those of the plies before it. */
static bool write_seams(struct ply_book *book, const struct ply_account *account, bool begun) {
    static const char *const heads[] = {
        "Ply",       "Pieces",        "Length",     "Angle between the warps, mean",
        "greatest",  "Overlap, area", "mean width", "Gap, area",
        "mean width"};
    const struct laminate_ply *ply = &book->laminate->plies[account->first];
    struct api_text *text = book->text;
    if (account->seam_count && !begun)
        begin_table(book, "Seams", heads, sizeof heads / sizeof *heads);
    for (size_t k = 0; k < account->seam_count; k++) {
        const struct laminate_piece *pieces = ply->pieces->pieces;
        const struct seam *seam = &account->seams[k];
        begin_ply_row(book, ply);
        html_say(text, "%s, %s", pieces[seam->piece[0]].name, pieces[seam->piece[1]].name);
        next_table_cell(text);
        html_say(text, "%.5g", seam->length);
        next_table_cell(text);
        html_say(text, "%.1f°", seam->mean_deg);
        next_table_cell(text);
        html_say(text, "%.1f°", seam->greatest_deg);
        next_table_cell(text);
        html_say(text, "%.5g", seam->overlap_area);
        next_table_cell(text);
        html_say(text, "%.4g", seam->overlap_width);
        next_table_cell(text);
        html_say(text, "%.5g", seam->gap_area);
        next_table_cell(text);
        html_say(text, "%.4g", seam->gap_width);
        api_text_raw(text, "</td></tr>\n");
    }
    return account->seam_count > 0 || begun;
}

/* The courses of a ply that is laid in them, of each and of all, likewise. */
static bool write_courses(struct ply_book *book, const struct ply_account *account, bool begun) {
    static const char *const heads[2 + COURSE_FIGURES] = {"Ply",
                                                          "Course",
                                                          "Width",
                                                          "Cut length",
                                                          "From the roll, area",
                                                          "On the part, area",
                                                          "Trimmed, area",
                                                          "Share of the part",
                                                          "Shear, mean",
                                                          "greatest",
                                                          "Deviation, mean",
                                                          "greatest",
                                                          "Gap, least",
                                                          "greatest",
                                                          "Gap, area",
                                                          "Overlap, area",
                                                          "Stagger"};
    const struct laminate_ply *ply = &book->laminate->plies[account->first];
    const struct laminate_pieces *pieces = ply->pieces;
    struct api_text *text = book->text;
    if (!pieces || !pieces->courses)
        return begun;
    if (!begun)
        begin_table(book, "Courses", heads, sizeof heads / sizeof *heads);
    for (size_t k = 0; k <= pieces->count; k++) {
        bool all = k == pieces->count;
        const double *figures = all ? account->courses : pieces->pieces[k].figures;
        begin_ply_row(book, ply);
        html_say(text, "%s", all ? "all" : pieces->pieces[k].name);
        for (int n = 0; n < COURSE_FIGURES; n++) {
            next_table_cell(text);
            if (!isnan(figures[n]))
                html_say(text, "%.4g", figures[n]);
        }
        api_text_raw(text, "</td></tr>\n");
    }
    return true;
}

/* How the plies that are divided became so, in tables. */
static void write_divisions(struct ply_book *book) {
    const struct laminate *laminate = book->laminate;
    struct ply_account *accounts =
        arena_alloc(book->text->arena, laminate->ply_count, sizeof *accounts);
    bool begun = false;
    book->text->failed = book->text->failed || !accounts;
    if (!accounts)
        return;
    for (size_t n = 0, k = 0; n < laminate->ply_count; k += accounts[n++].count) {
        struct api_problem problem = {0};
        if (ply_account_make(laminate, book->shapes, k, book->text->arena, &accounts[n],
                             &problem) == API_OK)
            continue;
        api_text_raw(book->text, "<p class=\"failed\">");
        html_say(book->text, "The seams of ply %zu are not known: %s", n + 1,
                 problem.error[0].detail);
        api_text_raw(book->text, "</p>\n");
    }
    for (size_t n = 0; n < laminate->ply_count; n++)
        begun = write_seams(book, &accounts[n], begun);
    api_text_raw(book->text, begun ? "</table>\n" : "");
    begun = false;
    for (size_t n = 0; n < laminate->ply_count; n++)
        begun = write_courses(book, &accounts[n], begun);
    api_text_raw(book->text, begun ? "</table>\n" : "");
}

void ply_book_write(const struct laminate *laminate, const struct api_reader *const *nets,
                    const struct flat_plies *shapes, const struct cut_sheet *sheet,
                    struct api_text *text) {
    struct ply_book *book = arena_alloc(text->arena, 1, sizeof *book);
    int layers = 0;
    if (!book) {
        text->failed = true;
        return;
    }
    *book = (struct ply_book){
        .laminate = laminate, .nets = nets, .shapes = shapes, .sheet = sheet, .text = text};
    api_text_raw(text, "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
                       "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src "
                       "'none'; style-src 'unsafe-inline'\">\n"
                       "<meta name=\"viewport\" content=\"width=device-width\">\n"
                       "<title>Ply book</title>\n<style>");
    api_text_raw(text, style);
    api_text_raw(text, "</style>\n</head>\n<body>\n<h1>Ply book</h1>\n<p>");
    for (size_t k = 0; k < laminate->count; k++)
        layers += laminate->plies[k].piece == 0 ? laminate_layers(&laminate->plies[k]) : 0;
    html_say(text, "%zu plies, %d layers, the first on the tool, ", laminate->ply_count, layers);
    html_say(text,
             laminate->nominal ? "each on those below it by their nominal thickness, on side %d."
                               : "all draped on the surface itself, side %d.",
             laminate->side);
    if (laminate->cavity.kind == STACK_HEIGHT)
        html_say(text, " The cavity is %g %s high.", laminate->cavity.height,
                 laminate->length_unit->name);
    else if (laminate->cavity.kind == STACK_PRESSURE)
        html_say(text, " Pressed with %g Pa.", laminate->cavity.pressure);
    const struct api_request *first = &laminate->plies[0].drape;
    const struct drape_zero *rosette = &first->settings.zero;
    const struct vec3 *o = &first->rosette_origin, *ax = &rosette->x, *az = &rosette->z;
    if (rosette->kind == DRAPE_ZERO_ROSETTE)
        html_say(
            text,
            " Angles are counted from the rosette at (%g, %g, %g), x along (%g, %g, %g), projected "
            "on the part where a ply starts",
            o->x, o->y, o->z, ax->x, ax->y, ax->z);
    if (rosette->kind == DRAPE_ZERO_ROSETTE && vec3_norm2(*az) > 0)
        html_say(text, ", about the normal on the side of (%g, %g, %g).", az->x, az->y, az->z);
    else if (rosette->kind == DRAPE_ZERO_ROSETTE)
        html_say(text, ", about the normal on the plies' side.");
    api_text_raw(text, "</p>\n<table>\n<tr><th>No.</th><th>Ply</th><th>Layers</th><th>Warp</th>"
                       "<th>Start</th><th>Boundary</th><th>Area, m²</th><th>kg/m²</th>"
                       "<th>Mass, kg</th><th>Cost</th><th>Shear up to</th></tr>\n");
    for (size_t k = 0; k < laminate->count; k++)
        write_ply_row(book, k);
    api_text_raw(text, "</table>\n");
    write_sums(book, sheet);
    write_divisions(book);
    for (size_t k = 0; k < laminate->count; k++)
        write_ply_section(book, k);
    api_text_raw(text, "</body>\n</html>\n");
}
