/* SPDX-License-Identifier: MIT */
#include "patterns.h"

#include "api/json/number.h"
#include "api/json/text.h"
#include "api/map/net.h"
#include "api/result/cut.h"
#include "clip.h"
#include "region.h"
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { DIGITS = 9, TEXT_MAX = 160 };

/* As of the pattern of a drape: what points of the rim are left out for, in spacings. */
static const double tolerance = 5e-4;

/* One ply's shape, in the laminate's unit; its layers are alike. */
struct shape {
    struct polygons cut;
    double low[2], high[2], area;
    size_t ply;
};

/* A layer on the roll: its lower left corner. */
struct placed {
    const struct shape *shape;
    double x, y;
    int layer;
};

struct patterns {
    const struct laminate *laminate;
    struct arena *arena;
    struct api_problem *problem;
    struct shape *shapes;
    size_t shape_count;
    struct placed *placed;
    size_t placed_count;
    double width, length, area;
};

static bool no_memory(struct patterns *p) {
    api_problem_set(p->problem, API_OUT_OF_MEMORY, "the patterns need more memory than allowed");
    return false;
}

/* ---- shapes ---- */

static void measure(struct shape *shape) {
    double sum = 0;
    size_t first = 0;
    polygons_bounds(&shape->cut, shape->low, shape->high);
    for (size_t k = 0; k < shape->cut.count; k++) {
        const struct polygons_point *a = &shape->cut.points[k];
        const struct polygons_point *b = &shape->cut.points[a->last ? first : k + 1];
        sum += (a->x * b->y - b->x * a->y) / 2;
        first = a->last ? k + 1 : first;
    }
    shape->area = fabs(sum);
}

/* The loops of a boundary turned so that they enclose what is on their left, holes the other way
 * round, in (p, q). */
static bool loops_of(const struct region *region, struct polygons *loops) {
    for (size_t n = 0; n < region->loop_count; n++) {
        size_t low = region->first[n], count = region->first[n + 1] - low;
        double sum = 0;
        for (size_t k = 0; k < count; k++) {
            const double *a = region->points[low + k], *b = region->points[low + (k + 1) % count];
            sum += a[0] * b[1] - b[0] * a[1];
        }
        int depth = 0; /* of this loop within the others */
        for (size_t m = 0; m < region->loop_count; m++) {
            struct polygons one = {0};
            for (size_t k = region->first[m]; m != n && k < region->first[m + 1]; k++)
                if (!polygons_add(&one, region->points[k][0], region->points[k][1]))
                    return false;
            polygons_close(&one);
            depth += m != n && clip_contains(&one, region->points[low][0], region->points[low][1]);
            polygons_free(&one);
        }
        bool back = (sum > 0) == (depth % 2 == 1);
        for (size_t k = 0; k < count; k++) {
            const double *at = region->points[low + (back ? count - 1 - k : k)];
            if (!polygons_add(loops, at[0], at[1]))
                return false;
        }
        polygons_close(loops);
    }
    return true;
}

/* What of the cut lies within the ply's boundary. */
static bool clip(struct patterns *p, size_t k, const struct api_reader *reader,
                 struct map_net *cloth, struct polygons *cut) {
    static const enum column_id kept[] = {COLUMN_CELLS_warp, COLUMN_CELLS_weft};
    const struct laminate_ply *ply = &p->laminate->plies[k];
    struct polygons loops = {0}, both = {0};
    struct region region;
    struct vec3 at;
    map_net_keep(cloth, kept, sizeof kept / sizeof *kept);
    if (map_net_load(reader, NULL, p->arena, cloth, p->problem) != API_OK)
        return false;
    enum status status = region_make(&ply->boundary, cloth->facets, cloth->columns.grid.spacing,
                                     p->arena, &region, &at);
    if (status == STATUS_INVALID)
        api_problem_set(p->problem, API_INVALID_REQUEST,
                        "the boundary of ply %zu (\"%s\") cannot be followed on its cloth near "
                        "(%.6g, %.6g, %.6g)",
                        k + 1, ply->name, at.x, at.y, at.z);
    bool good = status == STATUS_OK && loops_of(&region, &loops) && clip_make(&loops, cut, &both);
    if (good) {
        polygons_free(cut);
        *cut = both;
    } else {
        polygons_free(&both);
        no_memory(p);
    }
    polygons_free(&loops);
    return good;
}

static bool make_shape(struct patterns *p, size_t k, const struct api_reader *reader) {
    struct arena_mark mark = arena_mark(p->arena);
    struct map_net *cloth = arena_alloc(p->arena, 1, sizeof *cloth);
    struct shape *shape = &p->shapes[p->shape_count++];
    struct outline outline = {0};
    struct cut cut = {0};
    *shape = (struct shape){.ply = k};
    if (!cloth)
        return no_memory(p);
    bool good = map_net_open(reader, cloth, p->problem) == API_OK &&
                outline_make(&outline, reader, &cloth->columns, p->problem) == API_OK &&
                cut_make(&cut, reader, &cloth->columns, &outline, tolerance, p->problem) == API_OK;
    if (good && p->laminate->plies[k].boundary.count)
        good = clip(p, k, reader, cloth, &cut.polygons);
    const double *spacing = cloth->columns.grid.spacing;
    for (size_t n = 0; good && n < cut.polygons.count; n++) {
        cut.polygons.points[n].x *= spacing[0];
        cut.polygons.points[n].y *= spacing[1];
    }
    shape->cut = cut.polygons;
    cut.polygons = (struct polygons){0};
    measure(shape);
    cut_free(&cut);
    outline_free(&outline);
    arena_rewind(p->arena, mark);
    return good;
}

/* ---- shelves ---- */

static int by_height(const void *a, const void *b) {
    const struct placed *x = a, *y = b;
    double hx = x->shape->high[0] - x->shape->low[0], hy = y->shape->high[0] - y->shape->low[0];
    if (hx > hy || hy > hx)
        return hx > hy ? -1 : 1;
    if (x->shape->ply != y->shape->ply)
        return x->shape->ply > y->shape->ply ? 1 : -1;
    return (x->layer > y->layer) - (x->layer < y->layer);
}

/* The warp runs along the roll: x along it, y across. A shelf takes what fits across, the longest
 * first; the next begins behind the longest of it. */
static bool lay(struct patterns *p, const struct laminate_roll *roll) {
    double across = 0, along = 0, longest = 0, widest = 0;
    for (size_t k = 0; k < p->placed_count; k++)
        widest = fmax(widest, p->placed[k].shape->high[1] - p->placed[k].shape->low[1]);
    p->width = roll->width > 0 ? roll->width : widest;
    if (widest > p->width) {
        api_problem_set(p->problem, API_INVALID_REQUEST,
                        "width: a roll of %g %s is narrower than the widest ply, %.6g", p->width,
                        p->laminate->length_unit->name, widest);
        return false;
    }
    qsort(p->placed, p->placed_count, sizeof *p->placed, by_height);
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
    return true;
}

/* ---- documents ---- */

static void number(struct api_text *text, double value) {
    char digits[API_NUMBER_SIZE];
    api_text_bytes(text, digits, api_number_rounded(digits, value + 0.0, DIGITS));
}

/* "skin (2 of 3), warp along the roll" */
static void title_of(const struct patterns *p, const struct placed *own, char title[TEXT_MAX]) {
    const struct laminate_ply *ply = &p->laminate->plies[own->shape->ply];
    int layers = laminate_layers(ply);
    if (layers > 1)
        (void)snprintf(title, TEXT_MAX, "%zu %s (%d of %d)", own->shape->ply + 1, ply->name,
                       own->layer + 1, layers);
    else
        (void)snprintf(title, TEXT_MAX, "%zu %s", own->shape->ply + 1, ply->name);
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

static void group(struct api_text *text, int code, const char *value) {
    api_text_integer(text, code);
    api_text_raw(text, "\n");
    api_text_raw(text, value);
    api_text_raw(text, "\n");
}

static void group_number(struct api_text *text, int code, double value) {
    api_text_integer(text, code);
    api_text_raw(text, "\n");
    number(text, value);
    api_text_raw(text, "\n");
}

static void dxf_text(struct api_text *text, double x, double y, double height, const char *title) {
    group(text, 0, "TEXT");
    group(text, 8, "NAME");
    group_number(text, 10, x);
    group_number(text, 20, y);
    group_number(text, 40, height);
    group(text, 1, title);
}

static void dxf_shape(struct api_text *text, const struct placed *own) {
    const struct polygons *cut = &own->shape->cut;
    for (size_t k = 0; k < cut->count; k++) {
        if (k == 0 || cut->points[k - 1].last) {
            group(text, 0, "POLYLINE");
            group(text, 8, "CUT");
            group(text, 66, "1");
            group(text, 70, "1");
        }
        group(text, 0, "VERTEX");
        group(text, 8, "CUT");
        group_number(text, 10, own->x + cut->points[k].x - own->shape->low[0]);
        group_number(text, 20, own->y + cut->points[k].y - own->shape->low[1]);
        if (cut->points[k].last)
            group(text, 0, "SEQEND");
    }
}

static void write_dxf(const struct patterns *p, struct api_text *text) {
    char title[TEXT_MAX];
    double letter = p->width / 50;
    group(text, 0, "SECTION");
    group(text, 2, "ENTITIES");
    for (size_t k = 0; k < p->placed_count; k++) {
        const struct placed *own = &p->placed[k];
        const struct shape *shape = own->shape;
        dxf_shape(text, own);
        title_of(p, own, title);
        dxf_text(text, own->x + (shape->high[0] - shape->low[0]) / 3,
                 own->y + (shape->high[1] - shape->low[1]) / 2, letter, title);
    }
    summary_of(p, title);
    dxf_text(text, 0, -2 * letter, letter, title);
    group(text, 0, "ENDSEC");
    group(text, 0, "EOF");
}

static void svg_attribute(struct api_text *text, const char *name, double value) {
    api_text_raw(text, " ");
    api_text_raw(text, name);
    api_text_raw(text, "=\"");
    number(text, value);
    api_text_raw(text, "\"");
}

/* Text of ASCII in XML. */
static void svg_escaped(struct api_text *text, const char *title) {
    for (const char *c = title; *c; c++) {
        if (*c == '<' || *c == '&')
            api_text_raw(text, *c == '<' ? "&lt;" : "&amp;");
        else
            api_text_bytes(text, c, 1);
    }
}

static void svg_text(struct api_text *text, double x, double y, double size, const char *title) {
    api_text_raw(text, "<text");
    svg_attribute(text, "x", x);
    svg_attribute(text, "y", y);
    svg_attribute(text, "font-size", size);
    api_text_raw(text, ">");
    svg_escaped(text, title);
    api_text_raw(text, "</text>\n");
}

/* In millimetres; y downwards. */
static void write_svg(const struct patterns *p, struct api_text *text) {
    double mm = p->laminate->length_unit->metres * 1000, letter = p->width * mm / 50;
    double width = p->length * mm, height = p->width * mm + 3 * letter;
    char title[TEXT_MAX], size[TEXT_MAX];
    (void)snprintf(size, sizeof size,
                   "width=\"%.9gmm\" height=\"%.9gmm\" viewBox=\"0 0 %.9g %.9g\"", width, height,
                   width, height);
    api_text_raw(text, "<svg xmlns=\"http://www.w3.org/2000/svg\" ");
    api_text_raw(text, size);
    api_text_raw(text, ">\n<g fill=\"none\" stroke=\"black\" fill-rule=\"evenodd\" "
                       "vector-effect=\"non-scaling-stroke\" class=\"cut\">\n");
    for (size_t k = 0; k < p->placed_count; k++) {
        const struct placed *own = &p->placed[k];
        const struct polygons *cut = &own->shape->cut;
        api_text_raw(text, "<path d=\"");
        for (size_t n = 0; n < cut->count; n++) {
            api_text_raw(text, n == 0 || cut->points[n - 1].last ? "M" : "L");
            number(text, (own->x + cut->points[n].x - own->shape->low[0]) * mm);
            api_text_raw(text, " ");
            number(text, (p->width - own->y - cut->points[n].y + own->shape->low[1]) * mm);
            api_text_raw(text, cut->points[n].last ? "Z" : "");
        }
        api_text_raw(text, "\"/>\n");
    }
    api_text_raw(text, "</g>\n<g fill=\"black\" font-family=\"sans-serif\">\n");
    for (size_t k = 0; k < p->placed_count; k++) {
        const struct placed *own = &p->placed[k];
        const struct shape *shape = own->shape;
        title_of(p, own, title);
        svg_text(text, (own->x + (shape->high[0] - shape->low[0]) / 3) * mm,
                 (p->width - own->y - (shape->high[1] - shape->low[1]) / 2) * mm, letter, title);
    }
    summary_of(p, title);
    svg_text(text, 0, p->width * mm + 2 * letter, letter, title);
    api_text_raw(text, "</g>\n</svg>\n");
}

/* ---- the whole ---- */

static bool gather(struct patterns *p, const struct api_reader *const *nets, int ply) {
    size_t count = p->laminate->count, layers = 0;
    p->shapes = arena_alloc(p->arena, count, sizeof *p->shapes);
    if (!p->shapes)
        return no_memory(p);
    for (size_t k = 0; k < count; k++) {
        const struct laminate_ply *own = &p->laminate->plies[k];
        if (!nets[own->net] || (ply != LAMINATE_ALL && k != (size_t)ply))
            continue;
        if (!make_shape(p, k, nets[own->net]))
            return false;
        layers += (size_t)laminate_layers(own);
    }
    p->placed = arena_alloc(p->arena, layers, sizeof *p->placed);
    if (!p->placed)
        return no_memory(p);
    for (size_t k = 0; k < p->shape_count; k++)
        for (int n = 0; n < laminate_layers(&p->laminate->plies[p->shapes[k].ply]); n++)
            p->placed[p->placed_count++] = (struct placed){.shape = &p->shapes[k], .layer = n};
    if (p->placed_count == 0)
        api_problem_set(p->problem, API_INVALID_REQUEST, "there is no ply to draw");
    return p->placed_count > 0;
}

enum api_problem_id laminate_patterns(const struct laminate *laminate,
                                      const struct api_reader *const *nets, int ply, bool dxf,
                                      const struct laminate_roll *roll, const struct api_sink *sink,
                                      struct arena *arena, struct api_problem *problem) {
    struct patterns p = {.laminate = laminate, .arena = arena, .problem = problem};
    if (gather(&p, nets, ply) && lay(&p, roll)) {
        struct api_text text = api_text_growing(arena);
        if (dxf)
            write_dxf(&p, &text);
        else
            write_svg(&p, &text);
        const char *document = api_text_finish(&text);
        if (!document)
            no_memory(&p);
        else if (!sink->write(sink->context, document, strlen(document)))
            api_problem_set(problem, API_UNAVAILABLE, "there is no room to write the patterns now");
    }
    for (size_t k = 0; k < p.shape_count; k++)
        polygons_free(&p.shapes[k].cut);
    return problem->id;
}
