/* SPDX-License-Identifier: MIT */
#include "patterns.h"

#include "account.h"
#include "api/format/cut_sheet.h"
#include "api/format/dxf_writer.h"
#include "api/format/html.h"
#include "api/format/pattern.h"
#include "api/json/number.h"
#include "api/json/text.h"
#include "bundle.h"
#include "laser.h"
#include "ply_book.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { DIGITS = 9, ROLLS_MAX = 1000 };

/* The greatest coordinate of HP-GL/2, 2^23 - 1 units of 0.025 mm, in m. */
static const double longest_plot = 209.715;

struct patterns {
    const struct laminate *laminate;
    const struct api_reader *const *nets;
    struct arena *arena;
    int ply;
    size_t left_out;       /* plies, or pieces, that are asked for and have no net, .. */
    size_t first_left_out; /* .. and the first of them */
    struct flat_plies shapes;
    struct cut_roll *rolls;
    struct cut_sheet sheet;
};

/* ---- options ---- */

static bool fault_of_option(const char *name, const char *must_be, struct api_problem *problem) {
    return !api_problem_set(problem, API_INVALID_REQUEST, "the parameter '%s' must be %s", name,
                            must_be);
}

bool laminate_roll_option(struct laminate_roll *roll, const char *name, const char *value,
                          struct api_problem *problem) {
    char *end;
    double number = strtod(value, &end);
    bool given = end != value && !*end;
    if (strcmp(name, "width") == 0 || strcmp(name, "gap") == 0 || strcmp(name, "tolerance") == 0) {
        if (!(given && number > 0 && number <= 1e12))
            return fault_of_option(name, "a positive length", problem);
        *(*name == 'w' ? &roll->width : *name == 'g' ? &roll->gap : &roll->tolerance) = number;
    } else if (strcmp(name, "roll") == 0) {
        if (!(given && number >= 1 && number <= ROLLS_MAX && number == floor(number)))
            return fault_of_option(name, "the number of a roll, from 1", problem);
        roll->number = (int)number;
    } else if (strcmp(name, "turn") == 0) {
        if (strcmp(value, "0") != 0 && strcmp(value, "180") != 0)
            return fault_of_option(name, "0 or 180", problem);
        roll->straight = *value == '0';
    } else if (strcmp(name, "partial") == 0) {
        if (strcmp(value, "0") != 0 && strcmp(value, "1") != 0)
            return fault_of_option(name, "0 or 1", problem);
        roll->partial = *value == '1';
    } else {
        return false;
    }
    return true;
}

/* ---- rolls ---- */

/* Whether two plies are cut from one cloth: their spacings, which only nets have, do not matter. */
static bool same_cloth(const struct laminate_ply *a, const struct laminate_ply *b) {
    const struct api_fabric *x = &a->drape.fabric, *y = &b->drape.fabric;
    const char *name[2] = {x->material ? x->material : "", y->material ? y->material : ""};
    const double values[2][4] = {
        {x->thickness, x->fiber_volume_fraction, a->areal_weight, a->price},
        {y->thickness, y->fiber_volume_fraction, b->areal_weight, b->price}};
    return strcmp(name[0], name[1]) == 0 && memcmp(values[0], values[1], sizeof values[0]) == 0;
}

size_t laminate_cloths(const struct laminate *laminate) {
    size_t count = 0;
    for (size_t k = 0; k < laminate->count; k++) {
        size_t n = 0;
        while (n < k && !same_cloth(&laminate->plies[n], &laminate->plies[k]))
            n++;
        count += n == k;
    }
    return count;
}

/* What to call the cloth of a ply. */
static void name_cloth(const struct laminate_ply *ply, const char *unit,
                       char name[CUT_TITLE_SIZE]) {
    const struct api_fabric *fabric = &ply->drape.fabric;
    int length = 0;
    name[0] = '\0';
    if (fabric->material && *fabric->material == '"')
        length = snprintf(name, CUT_TITLE_SIZE, "%.*s, ", (int)strlen(fabric->material) - 2,
                          fabric->material + 1);
    if (fabric->thickness > 0 && length < CUT_TITLE_SIZE)
        length += snprintf(name + length, (size_t)(CUT_TITLE_SIZE - length), "%g %s, ",
                           fabric->thickness, unit);
    if (ply->areal_weight > 0 && length < CUT_TITLE_SIZE)
        length += snprintf(name + length, (size_t)(CUT_TITLE_SIZE - length), "%g kg/m2, ",
                           ply->areal_weight);
    if (length == 0)
        (void)snprintf(name, CUT_TITLE_SIZE, "cloth without a thickness");
    else
        name[(length < CUT_TITLE_SIZE ? length : CUT_TITLE_SIZE) - 2] = '\0';
}

static void fill_piece(const struct patterns *p, const struct flat_ply *shape,
                       struct nesting_shape *outline, struct cut_piece *piece) {
    static struct api_columns columns;
    struct api_problem unread = {0};
    const struct laminate_ply *ply = &p->laminate->plies[shape->ply];
    char title[LAMINATE_TITLE_SIZE];
    laminate_title(ply, title);
    *outline = (struct nesting_shape){.cut = &shape->cut,
                                      .low = {shape->low[0], shape->low[1]},
                                      .high = {shape->high[0], shape->high[1]},
                                      .area = shape->area,
                                      .layers = laminate_layers(ply)};
    *piece = (struct cut_piece){.notches = shape->notches, .notch_count = shape->notch_count};
    if (api_columns_open(p->nets[ply->net], &columns, &unread) == API_OK)
        pattern_flat_zero(&columns.start, piece->zero);
    (void)snprintf(piece->title, sizeof piece->title, "%zu %s", ply->number + 1, title);
    if (ply->pieces)
        (void)snprintf(piece->name, sizeof piece->name, "%zu.%zu %.12s", ply->number + 1,
                       ply->piece + 1, ply->pieces->pieces[ply->piece].name);
    else
        (void)snprintf(piece->name, sizeof piece->name, "%zu %.15s", ply->number + 1, ply->name);
}

/* The pieces of one cloth, from the first shape that is of it: how many. False without memory. */
static bool fill_roll(struct patterns *p, size_t first, bool *taken, struct cut_roll *roll) {
    const struct flat_ply *shapes = p->shapes.shapes;
    const struct laminate_ply *plies = p->laminate->plies, *own = &plies[shapes[first].ply];
    for (size_t k = first; k < p->shapes.count; k++)
        roll->count += !taken[k] && same_cloth(&plies[shapes[k].ply], own);
    struct nesting_shape *outlines = arena_alloc(p->arena, roll->count, sizeof *outlines);
    struct cut_piece *pieces = arena_alloc(p->arena, roll->count, sizeof *pieces);
    name_cloth(own, p->laminate->length_unit->name, roll->cloth);
    roll->shapes = outlines;
    roll->pieces = pieces;
    for (size_t k = first, n = 0; outlines && pieces && k < p->shapes.count; k++) {
        if (taken[k] || !same_cloth(&plies[shapes[k].ply], own))
            continue;
        taken[k] = true;
        fill_piece(p, &shapes[k], &outlines[n], &pieces[n]);
        roll->place_count += (size_t)outlines[n].layers;
        roll->area += outlines[n].area * outlines[n].layers;
        n++;
    }
    return outlines && pieces;
}

/* All pieces on the rolls of their cloths, not nested yet. */
static bool fill_rolls(struct patterns *p) {
    size_t count = 0;
    bool *taken = arena_alloc(p->arena, p->shapes.count, sizeof *taken);
    p->rolls = arena_alloc(p->arena, p->shapes.count, sizeof *p->rolls);
    if (!taken || !p->rolls)
        return false;
    for (size_t k = 0; k < p->shapes.count; k++)
        if (!taken[k] && !fill_roll(p, k, taken, &p->rolls[count++]))
            return false;
    if (count == 1)
        p->rolls[0].cloth[0] = '\0';
    p->sheet.rolls = p->rolls;
    p->sheet.roll_count = count;
    return true;
}

/* Leaves the wanted roll alone, and nests what is on the rolls. */
static enum api_problem_id nest_rolls(struct patterns *p, const struct laminate_roll *roll,
                                      struct api_problem *problem) {
    struct cut_sheet *sheet = &p->sheet;
    double widest = 0, from = 0;
    if ((size_t)roll->number > sheet->roll_count)
        return api_problem_set(problem, API_INVALID_REQUEST,
                               "roll: there are %zu, one for each cloth", sheet->roll_count);
    if (roll->number) {
        p->rolls += roll->number - 1;
        sheet->rolls = p->rolls;
        sheet->roll_count = 1;
    }
    for (size_t r = 0; r < sheet->roll_count; r++)
        for (size_t k = 0; k < p->rolls[r].count; k++)
            widest = fmax(widest, p->rolls[r].shapes[k].high[1] - p->rolls[r].shapes[k].low[1]);
    sheet->width = roll->width > 0 ? roll->width : widest;
    if (widest > sheet->width)
        return api_problem_set(problem, API_INVALID_REQUEST,
                               "width: a roll of %g %s is narrower than the widest ply, %.6g",
                               sheet->width, sheet->unit->name, widest);
    const struct nesting_roll on = {sheet->width, roll->gap, !roll->straight};
    for (size_t r = 0; r < sheet->roll_count; r++) {
        struct nesting_place *places;
        struct cut_roll *own = &p->rolls[r];
        if (!nesting_make(own->shapes, own->count, &on, p->arena, &places, &own->length))
            return api_problem_no_memory(problem, "the patterns");
        own->places = places;
        own->from = from;
        from += own->length + sheet->width / 10;
    }
    return API_OK;
}

static enum api_problem_id lay_out_plies(struct patterns *p, const struct laminate_roll *roll,
                                         struct api_problem *problem) {
    char *title = arena_alloc(p->arena, LAMINATE_TITLE_SIZE, 1);
    if (!title)
        return api_problem_no_memory(problem, "the patterns");
    if (p->left_out)
        laminate_title(&p->laminate->plies[p->first_left_out], title);
    p->sheet = (struct cut_sheet){.unit = p->laminate->length_unit,
                                  .style = p->laminate->revision,
                                  .revision = p->laminate->revision,
                                  .left_out = p->left_out,
                                  .left_out_first = p->left_out ? title : NULL};
    return fill_rolls(p) ? nest_rolls(p, roll, problem)
                         : api_problem_no_memory(problem, "the patterns");
}

/* ---- drawings ---- */

static void write_svg_number(struct api_text *text, double value) {
    char digits[API_NUMBER_SIZE];
    api_text_bytes(text, digits, api_number_rounded(digits, value + 0.0, DIGITS));
}

/* The height of letters in drawings. */
static double letter_of(const struct cut_sheet *sheet) {
    return sheet->width / 50;
}

/* Where the name of a pattern stands: within it, on a line along the warp. */
static void title_place(const struct cut_roll *roll, const struct nesting_place *place,
                        double at[2]) {
    const struct nesting_shape *shape = &roll->shapes[place->shape];
    const struct cut_chord chord = cut_chord_of(shape);
    double eighth = (chord.x[1] - chord.x[0]) / 8;
    nesting_point(shape, place, place->turned ? chord.x[1] - eighth : chord.x[0] + eighth, chord.y,
                  at);
    at[0] += roll->from;
}

static void write_dxf_roll(const struct cut_sheet *sheet, const struct cut_roll *roll,
                           struct api_text *text) {
    const double letter = letter_of(sheet);
    char title[CUT_TEXT_SIZE];
    double at[2];
    for (size_t k = 0; k < roll->place_count; k++) {
        const struct nesting_place *place = &roll->places[k];
        const struct polygons *cut = roll->shapes[place->shape].cut;
        for (size_t n = 0; n < cut->count; n++) {
            nesting_point(&roll->shapes[place->shape], place, cut->points[n].x, cut->points[n].y,
                          at);
            dxf_corner(text, "CUT", roll->from + at[0], at[1], n == 0 || cut->points[n - 1].last,
                       cut->points[n].last);
        }
        cut_layer_title(roll, place, title);
        title_place(roll, place, at);
        dxf_letters(text, "NAME", at[0], at[1], letter, title);
    }
    if (*roll->cloth)
        dxf_letters(text, "NAME", roll->from, -2 * letter, letter, roll->cloth);
}

static void write_dxf(const struct cut_sheet *sheet, struct api_text *text) {
    static const struct dxf_layer layers[] = {{"CUT", DXF_WHITE}, {"NAME", DXF_GREEN}};
    const struct cut_roll *end = &sheet->rolls[sheet->roll_count - 1];
    const double letter = letter_of(sheet);
    const double low[2] = {0, -4 * letter}, high[2] = {end->from + end->length, sheet->width};
    char summary[CUT_TEXT_SIZE];
    dxf_head(text, sheet->unit->name, low, high, layers, sizeof layers / sizeof *layers);
    dxf_section(text, "ENTITIES");
    for (size_t r = 0; r < sheet->roll_count; r++)
        write_dxf_roll(sheet, &sheet->rolls[r], text);
    cut_sheet_summary(sheet, NULL, summary);
    dxf_letters(text, "NAME", 0, -4 * letter, letter, summary);
    dxf_section_end(text);
    dxf_foot(text);
}

static void svg_text(struct api_text *text, double x, double y, double size, const char *title) {
    api_text_raw(text, "<text x=\"");
    write_svg_number(text, x);
    api_text_raw(text, "\" y=\"");
    write_svg_number(text, y);
    api_text_raw(text, "\" font-size=\"");
    write_svg_number(text, size);
    api_text_raw(text, "\">");
    html_say(text, "%s", title);
    api_text_raw(text, "</text>\n");
}

static void write_svg_paths(const struct cut_sheet *sheet, const struct cut_roll *roll, double mm,
                            struct api_text *text) {
    for (size_t k = 0; k < roll->place_count; k++) {
        const struct nesting_place *place = &roll->places[k];
        const struct polygons *cut = roll->shapes[place->shape].cut;
        api_text_raw(text, "<path d=\"");
        for (size_t n = 0; n < cut->count; n++) {
            double at[2];
            nesting_point(&roll->shapes[place->shape], place, cut->points[n].x, cut->points[n].y,
                          at);
            api_text_raw(text, n == 0 || cut->points[n - 1].last ? "M" : "L");
            write_svg_number(text, (roll->from + at[0]) * mm);
            api_text_raw(text, " ");
            write_svg_number(text, (sheet->width - at[1]) * mm);
            api_text_raw(text, cut->points[n].last ? "Z" : "");
        }
        api_text_raw(text, "\"/>\n");
    }
}

/* In millimetres; y downwards. */
static void write_svg(const struct cut_sheet *sheet, struct api_text *text) {
    const struct cut_roll *end = &sheet->rolls[sheet->roll_count - 1];
    double mm = sheet->unit->metres * 1000, letter = letter_of(sheet) * mm;
    double width = (end->from + end->length) * mm, height = sheet->width * mm + 5 * letter;
    char title[CUT_TEXT_SIZE];
    api_text_format(text,
                    "<svg xmlns=\"http://www.w3.org/2000/svg\" "
                    "width=\"%.9gmm\" height=\"%.9gmm\" viewBox=\"0 0 %.9g %.9g\">\n",
                    width, height, width, height);
    api_text_raw(text, "<g fill=\"none\" stroke=\"black\" "
                       "vector-effect=\"non-scaling-stroke\" class=\"cut\">\n");
    for (size_t r = 0; r < sheet->roll_count; r++)
        write_svg_paths(sheet, &sheet->rolls[r], mm, text);
    api_text_raw(text, "</g>\n<g fill=\"black\" font-family=\"sans-serif\">\n");
    for (size_t r = 0; r < sheet->roll_count; r++) {
        const struct cut_roll *roll = &sheet->rolls[r];
        for (size_t k = 0; k < roll->place_count; k++) {
            double at[2];
            cut_layer_title(roll, &roll->places[k], title);
            title_place(roll, &roll->places[k], at);
            svg_text(text, at[0] * mm, (sheet->width - at[1]) * mm, letter, title);
        }
        if (*roll->cloth)
            svg_text(text, roll->from * mm, sheet->width * mm + 2 * letter, letter, roll->cloth);
    }
    cut_sheet_summary(sheet, NULL, title);
    svg_text(text, 0, sheet->width * mm + 4 * letter, letter, title);
    api_text_raw(text, "</g>\n</svg>\n");
}

/* ---- the whole ---- */

/* Plies that are asked for and could not be draped. */
static void find_left_out(struct patterns *p) {
    const struct laminate *laminate = p->laminate;
    for (size_t k = laminate->count; k-- > 0;) {
        const struct laminate_ply *ply = &laminate->plies[k];
        if (p->nets[ply->net] || (p->ply != LAMINATE_ALL && ply->number != (size_t)p->ply))
            continue;
        p->left_out++;
        p->first_left_out = k;
    }
}

/* Whether machines may get the patterns: none that lack a ply, and none of a ply that leaves some
 * bare, unless asked for. */
static bool may_be_cut(const struct patterns *p, const struct laminate_roll *roll,
                       struct api_problem *problem) {
    if (p->left_out && !roll->partial) {
        const struct laminate_ply *ply = &p->laminate->plies[p->first_left_out];
        char title[LAMINATE_TITLE_SIZE];
        laminate_title(ply, title);
        return !api_problem_set(problem, API_INVALID_REQUEST,
                                "ply %zu (\"%s\") could not be draped and would be lacking: "
                                "correct it, or ask for partial=1, without it",
                                ply->number + 1, title);
    }
    for (size_t k = 0; k < p->shapes.count && !roll->partial; k++) {
        const struct flat_ply *shape = &p->shapes.shapes[k];
        char name[LAMINATE_TITLE_SIZE];
        laminate_title(&p->laminate->plies[shape->ply], name);
        if (shape->partial)
            return !api_problem_set(
                problem, API_INVALID_REQUEST,
                "the cloth of ply %zu (\"%s\") leaves %.2g %% bare of what it is "
                "to cover, and would be cut along its own front there: drape all "
                "of it, or ask for partial=1",
                p->laminate->plies[shape->ply].number + 1, name, 100 * (1 - shape->covered));
    }
    return true;
}

/* What HP-GL cannot hold. */
static bool may_be_plotted(const struct cut_sheet *sheet, struct api_problem *problem) {
    double metres = sheet->rolls[0].length * sheet->unit->metres;
    if (sheet->roll_count > 1)
        return !api_problem_set(problem, API_INVALID_REQUEST,
                                "hpgl is of one roll, and the plies are of %zu cloths: ask for "
                                "roll=1 to roll=%zu one after the other, or for astm or dxf",
                                sheet->roll_count, sheet->roll_count);
    if (metres > longest_plot)
        return !api_problem_set(problem, API_INVALID_REQUEST,
                                "hpgl holds %g m of roll, and the patterns take %.6g: write plies "
                                "one by one, or ask for astm or dxf",
                                longest_plot, metres);
    return true;
}

/* ---- documents ---- */

/* How the layers that lie on rolls are written. */
static const struct roll_document {
    const char *name;
    bool machine; /* cuts by it */
    void (*write)(const struct cut_sheet *, struct api_text *);
} roll_documents[] = {{"svg", false, write_svg},
                      {"dxf", true, write_dxf},
                      {"astm", true, cut_sheet_write_astm},
                      {"hpgl", true, cut_sheet_write_hpgl}};

static const struct laser_document {
    const char *name;
    void (*write)(const struct laser_sheet *, struct api_text *);
} laser_documents[] = {{"laser", laser_sheet_write_json},
                       {"laser-csv", laser_sheet_write_csv},
                       {"virtek", laser_sheet_write_virtek}};

static void write_on_rolls(struct patterns *p, const struct roll_document *document,
                           const struct laminate_roll *roll, struct api_text *text,
                           struct api_problem *problem) {
    bool hpgl = document && document->write == cut_sheet_write_hpgl;
    if ((document && document->machine && !may_be_cut(p, roll, problem)) ||
        lay_out_plies(p, roll, problem) != API_OK || (hpgl && !may_be_plotted(&p->sheet, problem)))
        return;
    if (document)
        document->write(&p->sheet, text);
    else
        ply_book_write(p->laminate, p->nets, &p->shapes, &p->sheet, text);
}

static void write_laser(const struct patterns *p, const struct laser_document *document,
                        const struct laminate_roll *roll, struct api_text *text,
                        struct api_problem *problem) {
    struct laser_sheet sheet;
    double tolerance =
        roll->tolerance > 0 ? roll->tolerance : LASER_TOLERANCE / p->laminate->length_unit->metres;
    if (may_be_cut(p, roll, problem) && laser_make(p->laminate, p->nets, &p->shapes, tolerance,
                                                   p->arena, &sheet, problem) == API_OK)
        document->write(&sheet, text);
}

/* Hands the document over, unless something was wrong with it. */
static enum api_problem_id send_document(struct api_text *text, const struct api_sink *sink,
                                         struct api_problem *problem) {
    const char *document = problem->id == API_OK ? api_text_finish(text) : NULL;
    if (document && !sink->write(sink->context, document, strlen(document)))
        api_problem_set(problem, API_UNAVAILABLE, "there is no disk space for the patterns now");
    else if (!document && problem->id == API_OK)
        api_problem_no_memory(problem, "the patterns");
    return problem->id;
}

enum api_problem_id laminate_patterns(const struct laminate *laminate,
                                      const struct api_reader *const *nets, int ply,
                                      const char *format, const struct laminate_roll *roll,
                                      const struct api_sink *sink, struct arena *arena,
                                      struct api_problem *problem) {
    struct patterns p = {.laminate = laminate, .nets = nets, .arena = arena, .ply = ply};
    const struct roll_document *on_roll = NULL;
    const struct laser_document *laser = NULL;
    struct api_text text = api_text_growing(arena);
    if (strcmp(format, "bundle") == 0)
        return laminate_bundle(laminate, nets, roll, sink, arena, problem);
    if (strcmp(format, "json") == 0) {
        (void)!laminate_account_write(laminate, nets, NULL, &text, problem);
        return send_document(&text, sink, problem);
    }
    for (size_t k = 0; k < sizeof roll_documents / sizeof *roll_documents; k++)
        on_roll = strcmp(format, roll_documents[k].name) == 0 ? &roll_documents[k] : on_roll;
    for (size_t k = 0; k < sizeof laser_documents / sizeof *laser_documents; k++)
        laser = strcmp(format, laser_documents[k].name) == 0 ? &laser_documents[k] : laser;
    find_left_out(&p);
    if (flat_plies_make(laminate, nets, ply, arena, &p.shapes, problem) == API_OK) {
        if (p.shapes.count == 0)
            api_problem_set(problem, API_INVALID_REQUEST,
                            "there is no ply to draw: what is asked for could not be draped, and "
                            "the status of the laminate says why");
        else if (laser)
            write_laser(&p, laser, roll, &text, problem);
        else
            write_on_rolls(&p, on_roll, roll, &text, problem);
    }
    flat_plies_free(&p.shapes);
    return send_document(&text, sink, problem);
}
