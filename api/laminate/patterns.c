/* SPDX-License-Identifier: MIT */
#include "patterns.h"

#include "api/format/dxf_writer.h"
#include "api/format/html.h"
#include "api/json/number.h"
#include "api/json/text.h"
#include "ply_book.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { DIGITS = 9, TEXT_MAX = 256 };

/* A layer on the roll: its lower left corner. */
struct placed {
    const struct flat_ply *shape;
    double x, y;
    int layer;
};

struct patterns {
    const struct laminate *laminate;
    struct arena *arena;
    struct flat_plies shapes;
    struct placed *placed;
    size_t placed_count;
    double width, length, area;
};

static int compare_heights(const void *a, const void *b) {
    const struct placed *x = a, *y = b;
    double hx = x->shape->high[0] - x->shape->low[0], hy = y->shape->high[0] - y->shape->low[0];
    if (hx > hy || hy > hx)
        return hx > hy ? -1 : 1;
    if (x->shape->ply != y->shape->ply)
        return x->shape->ply > y->shape->ply ? 1 : -1;
    return (x->layer > y->layer) - (x->layer < y->layer);
}

/* Lays the layers of the plies out on the roll. The warp runs along the roll: x along it, y across.
 * A shelf takes what fits across, the longest first; the next begins behind the longest of it. */
static enum api_problem_id lay_out_plies(struct patterns *p, const struct api_reader *const *nets,
                                         int ply, const struct laminate_roll *roll,
                                         struct api_problem *problem) {
    const struct flat_plies *shapes = &p->shapes;
    double across = 0, along = 0, longest = 0, widest = 0;
    size_t layers = 0;
    if (flat_plies_make(p->laminate, nets, ply, p->arena, &p->shapes, problem) != API_OK)
        return problem->id;
    for (size_t k = 0; k < shapes->count; k++) {
        layers += (size_t)laminate_layers(&p->laminate->plies[shapes->shapes[k].ply]);
        widest = fmax(widest, shapes->shapes[k].high[1] - shapes->shapes[k].low[1]);
    }
    p->placed = arena_alloc(p->arena, layers, sizeof *p->placed);
    if (!p->placed)
        return api_problem_no_memory(problem, "the patterns");
    for (size_t k = 0; k < shapes->count; k++)
        for (int n = 0; n < laminate_layers(&p->laminate->plies[shapes->shapes[k].ply]); n++)
            p->placed[p->placed_count++] = (struct placed){.shape = &shapes->shapes[k], .layer = n};
    p->width = roll->width > 0 ? roll->width : widest;
    if (p->placed_count == 0)
        return api_problem_set(problem, API_INVALID_REQUEST, "there is no ply to draw");
    if (widest > p->width)
        return api_problem_set(problem, API_INVALID_REQUEST,
                               "width: a roll of %g %s is narrower than the widest ply, %.6g",
                               p->width, p->laminate->length_unit->name, widest);
    qsort(p->placed, p->placed_count, sizeof *p->placed, compare_heights);
    for (size_t k = 0; k < p->placed_count; k++) {
        struct placed *own = &p->placed[k];
        double length = own->shape->high[0] - own->shape->low[0];
        double wide = own->shape->high[1] - own->shape->low[1];
        if (across > 0 && across + wide > p->width) {
            along += longest + roll->gap;
            across = longest = 0;
        }
        own->x = along;
        own->y = across;
        across += wide + roll->gap;
        longest = fmax(longest, length);
        p->area += own->shape->area;
    }
    p->length = along + longest;
    return API_OK;
}

/* ---- documents ---- */

static void write_svg_number(struct api_text *text, double value) {
    char digits[API_NUMBER_SIZE];
    api_text_bytes(text, digits, api_number_rounded(digits, value + 0.0, DIGITS));
}

/* "skin (2 of 3), warp along the roll" */
static void title_of(const struct patterns *p, const struct placed *own, char title[TEXT_MAX]) {
    const struct laminate_ply *ply = &p->laminate->plies[own->shape->ply];
    int layers = laminate_layers(ply);
    char name[LAMINATE_TITLE_SIZE];
    laminate_title(ply, name);
    if (layers > 1)
        (void)snprintf(title, TEXT_MAX, "%zu %s (%d of %d)", ply->number + 1, name, own->layer + 1,
                       layers);
    else
        (void)snprintf(title, TEXT_MAX, "%zu %s", ply->number + 1, name);
}

static void summary_of(const struct patterns *p, char title[TEXT_MAX]) {
    const char *unit = p->laminate->length_unit->name;
    double roll = p->width * p->length;
    (void)snprintf(title, TEXT_MAX,
                   "%zu patterns on %.6g x %.6g %s of roll, warp along it; cloth %.6g %s2, waste "
                   "%.1f %%",
                   p->placed_count, p->length, p->width, unit, p->area, unit,
                   roll > 0 ? 100 * (1 - p->area / roll) : 0);
}

static void write_dxf(const struct patterns *p, struct api_text *text) {
    static const struct dxf_layer layers[] = {{"CUT", DXF_WHITE}, {"NAME", DXF_GREEN}};
    const double letter = p->width / 50;
    const double low[2] = {0, -2 * letter}, high[2] = {p->length, p->width};
    char title[TEXT_MAX];
    dxf_head(text, p->laminate->length_unit->name, low, high, layers,
             sizeof layers / sizeof *layers);
    for (size_t k = 0; k < p->placed_count; k++) {
        const struct placed *own = &p->placed[k];
        const struct flat_ply *shape = own->shape;
        const struct polygons *cut = &shape->cut;
        for (size_t n = 0; n < cut->count; n++)
            dxf_corner(text, "CUT", own->x + cut->points[n].x - shape->low[0],
                       own->y + cut->points[n].y - shape->low[1], n == 0 || cut->points[n - 1].last,
                       cut->points[n].last);
        title_of(p, own, title);
        dxf_letters(text, "NAME", own->x + (shape->high[0] - shape->low[0]) / 3,
                    own->y + (shape->high[1] - shape->low[1]) / 2, letter, title);
    }
    summary_of(p, title);
    dxf_letters(text, "NAME", 0, -2 * letter, letter, title);
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

/* In millimetres; y downwards. */
static void write_svg(const struct patterns *p, struct api_text *text) {
    double mm = p->laminate->length_unit->metres * 1000, letter = p->width * mm / 50;
    double width = p->length * mm, height = p->width * mm + 3 * letter;
    char title[TEXT_MAX];
    api_text_format(text,
                    "<svg xmlns=\"http://www.w3.org/2000/svg\" "
                    "width=\"%.9gmm\" height=\"%.9gmm\" viewBox=\"0 0 %.9g %.9g\">\n",
                    width, height, width, height);
    api_text_raw(text, "<g fill=\"none\" stroke=\"black\" fill-rule=\"evenodd\" "
                       "vector-effect=\"non-scaling-stroke\" class=\"cut\">\n");
    for (size_t k = 0; k < p->placed_count; k++) {
        const struct placed *own = &p->placed[k];
        const struct polygons *cut = &own->shape->cut;
        api_text_raw(text, "<path d=\"");
        for (size_t n = 0; n < cut->count; n++) {
            api_text_raw(text, n == 0 || cut->points[n - 1].last ? "M" : "L");
            write_svg_number(text, (own->x + cut->points[n].x - own->shape->low[0]) * mm);
            api_text_raw(text, " ");
            write_svg_number(text,
                             (p->width - own->y - cut->points[n].y + own->shape->low[1]) * mm);
            api_text_raw(text, cut->points[n].last ? "Z" : "");
        }
        api_text_raw(text, "\"/>\n");
    }
    api_text_raw(text, "</g>\n<g fill=\"black\" font-family=\"sans-serif\">\n");
    for (size_t k = 0; k < p->placed_count; k++) {
        const struct placed *own = &p->placed[k];
        const struct flat_ply *shape = own->shape;
        title_of(p, own, title);
        svg_text(text, (own->x + (shape->high[0] - shape->low[0]) / 3) * mm,
                 (p->width - own->y - (shape->high[1] - shape->low[1]) / 2) * mm, letter, title);
    }
    summary_of(p, title);
    svg_text(text, 0, p->width * mm + 2 * letter, letter, title);
    api_text_raw(text, "</g>\n</svg>\n");
}

/* ---- the whole ---- */

/* Whether machines may get the patterns: none of a ply that leaves some bare, unless asked for. */
static bool may_be_cut(const struct patterns *p, const struct laminate_roll *roll,
                       struct api_problem *problem) {
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

enum api_problem_id laminate_patterns(const struct laminate *laminate,
                                      const struct api_reader *const *nets, int ply,
                                      const char *format, const struct laminate_roll *roll,
                                      const struct api_sink *sink, struct arena *arena,
                                      struct api_problem *problem) {
    struct patterns p = {.laminate = laminate, .arena = arena};
    bool to_cut = strcmp(format, "dxf") == 0;
    if (lay_out_plies(&p, nets, ply, roll, problem) == API_OK &&
        (!to_cut || may_be_cut(&p, roll, problem))) {
        struct api_text text = api_text_growing(arena);
        if (strcmp(format, "html") == 0)
            ply_book_write(laminate, nets, &p.shapes, p.width, p.length, &text);
        else if (to_cut)
            write_dxf(&p, &text);
        else
            write_svg(&p, &text);
        const char *document = api_text_finish(&text);
        if (!document)
            api_problem_no_memory(problem, "the patterns");
        else if (!sink->write(sink->context, document, strlen(document)))
            api_problem_set(problem, API_UNAVAILABLE,
                            "there is no disk space for the patterns now");
    }
    flat_plies_free(&p.shapes);
    return problem->id;
}
