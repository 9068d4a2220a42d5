/* SPDX-License-Identifier: MIT */
#include "laser.h"

#include "api/format/cut_sheet.h"
#include "api/format/format.h"
#include "api/map/net.h"
#include "api/request/prepared_part.h"
#include "part_foot.h"
#include "ply_samples.h"
#include "solver/permeability.h"
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { HALVINGS = 12, SKIPPED_MAX = 256 };

/* An edge is followed in steps of this share of a cell, and what lies below it is looked at so many
 * cells inside. */
static const double edge_step = 0.5, inside_edge = 0.02;

/* A point of an edge on the tool, and the place of its cloth at which the stack is looked at. */
struct traced_point {
    struct vec3 foot, normal, inner;
};

struct traced_line {
    enum laser_kind kind;
    size_t first, end; /* of the points */
};

struct cell_place {
    int32_t i, j, cell;
};

struct tracing {
    const struct laminate *laminate;
    struct prepared_part shape;
    struct arena *arena;
    double tolerance; /* of feet */
    struct traced_point *points;
    size_t count, capacity;
    struct traced_line *lines;
    size_t line_count, line_capacity;
    bool failed; /* no memory */
    /* The net that is being traced. */
    const struct facets_source *cloth;
    const struct cell_place *places;
};

/* ---- a place of the cloth ---- */

static int compare_cell_places(const void *a, const void *b) {
    const struct cell_place *x = a, *y = b;
    return x->i != y->i ? (x->i > y->i) - (x->i < y->i) : (x->j > y->j) - (x->j < y->j);
}

/* The cell that (p, q) is in, or the one that it is nearest to of those about it. */
static const struct cell_place *cell_about(const struct tracing *t, double p, double q) {
    const struct cell_place *best = NULL;
    double nearest = HUGE_VAL;
    for (int n = 0; n < 9 && nearest > 0; n++) {
        static const int8_t steps[9][2] = {{0, 0}, {1, 0},  {-1, 0}, {0, 1},  {0, -1},
                                           {1, 1}, {1, -1}, {-1, 1}, {-1, -1}};
        const struct cell_place key = {.i = (int32_t)floor(p) + steps[n][0],
                                       .j = (int32_t)floor(q) + steps[n][1]};
        const struct cell_place *found =
            bsearch(&key, t->places, t->cloth->cell_count, sizeof *t->places, compare_cell_places);
        double off =
            hypot(p - fmin(fmax(p, key.i), key.i + 1), q - fmin(fmax(q, key.j), key.j + 1));
        if (found && off < nearest) {
            nearest = off;
            best = found;
        }
    }
    return best;
}

/* The place (p, q) of a cell, and the normal of the cloth there, along warp x weft. */
static struct vec3 bilinear_place(const struct tracing *t, const struct cell_place *place, double p,
                                  double q, struct vec3 *normal) {
    const int32_t *corners = t->cloth->corners[place->cell];
    const struct vec3 *r = t->cloth->nodes;
    struct vec3 near = r[corners[0]], ahead = vec3_sub(r[corners[1]], near);
    struct vec3 far = r[corners[3]], beyond = vec3_sub(r[corners[2]], far);
    double s = p - place->i, u = q - place->j;
    struct vec3 lower = vec3_axpy(s, ahead, near), upper = vec3_axpy(s, beyond, far);
    struct vec3 along = vec3_axpy(u, beyond, vec3_scale(1 - u, ahead));
    *normal = vec3_cross(along, vec3_sub(upper, lower));
    return vec3_axpy(u, vec3_sub(upper, lower), lower);
}

/* (p, q) on the tool; `inward` is a direction of length 1 into the cloth, or 0. False where the
 * cloth has no cell there. */
static bool trace_point(const struct tracing *t, const double pq[2], const double inward[2],
                        struct traced_point *at) {
    double p = pq[0] + inside_edge * inward[0], q = pq[1] + inside_edge * inward[1];
    const struct cell_place *place = cell_about(t, p, q);
    struct vec3 up, tool;
    if (!place)
        return false;
    at->inner = bilinear_place(t, place, p, q, &up);
    at->foot = bilinear_place(t, place, pq[0], pq[1], &up);
    tool = up = vec3_scale(t->laminate->side, vec3_unit(up));
    (void)part_foot(&t->shape.part, at->foot, &at->foot, &tool);
    at->normal = vec3_dot(tool, up) < 0 ? vec3_scale(-1, tool) : tool;
    return true;
}

/* ---- lines ---- */

static void add_traced(struct tracing *t, const struct traced_point *at) {
    if (t->count == t->capacity) {
        size_t capacity = t->capacity ? 2 * t->capacity : 1024;
        struct traced_point *points = realloc(t->points, capacity * sizeof *points);
        t->failed = t->failed || !points;
        if (!points)
            return;
        t->points = points;
        t->capacity = capacity;
    }
    t->points[t->count++] = *at;
}

static bool begin_line(struct tracing *t, enum laser_kind kind) {
    if (t->line_count == t->line_capacity) {
        size_t capacity = t->line_capacity ? 2 * t->line_capacity : 64;
        struct traced_line *lines = realloc(t->lines, capacity * sizeof *lines);
        t->failed = t->failed || !lines;
        if (!lines)
            return false;
        t->lines = lines;
        t->line_capacity = capacity;
    }
    t->lines[t->line_count++] = (struct traced_line){kind, t->count, t->count};
    return true;
}

/* What lies between two points of a straight edge, halved until the chords are near enough. */
static void trace_between(struct tracing *t, const double a[2], const struct traced_point *from,
                          const double b[2], const struct traced_point *to, const double inward[2],
                          int halvings) {
    const double middle[2] = {(a[0] + b[0]) / 2, (a[1] + b[1]) / 2};
    struct vec3 chord = vec3_scale(0.5, vec3_add(from->foot, to->foot));
    struct traced_point at;
    if (halvings == 0 || !trace_point(t, middle, inward, &at) ||
        vec3_distance(chord, at.foot) <= t->tolerance)
        return;
    trace_between(t, a, from, middle, &at, inward, halvings - 1);
    add_traced(t, &at);
    trace_between(t, middle, &at, b, to, inward, halvings - 1);
}

/* From point a of an edge, whose own direction inwards is `corner`, towards b, without that. */
static void trace_edge(struct tracing *t, const double a[2], const double b[2],
                       const double corner[2], const double inward[2]) {
    double way[2] = {b[0] - a[0], b[1] - a[1]};
    int steps = 1 + (int)fmin(fmax(fabs(way[0]), fabs(way[1])) / edge_step, 1e6);
    struct traced_point last, next;
    double from[2] = {a[0], a[1]};
    bool known = trace_point(t, a, corner, &last);
    if (known)
        add_traced(t, &last);
    for (int n = 1; n <= steps && !t->failed; n++) {
        double to[2] = {a[0] + way[0] * n / steps, a[1] + way[1] * n / steps};
        bool found = trace_point(t, to, inward, &next);
        if (known && found)
            trace_between(t, from, &last, to, &next, inward, HALVINGS);
        if (found && n < steps)
            add_traced(t, &next);
        known = found;
        last = next;
        memcpy(from, to, sizeof from);
    }
}

/* The direction to the left of a way, of length 1; 0 of none. */
static void unit_left_of(const double a[2], const double b[2], double left[2]) {
    double x = a[1] - b[1], y = b[0] - a[0], size = hypot(x, y);
    left[0] = size > 0 ? x / size : 0;
    left[1] = size > 0 ? y / size : 0;
}

/* A loop of a shape, `count` points in lengths, closed to its first point. */
static void trace_polygon(struct tracing *t, const struct polygons_point *loop, size_t count,
                          const double d[2], enum laser_kind kind) {
    static const double origin[2] = {0, 0};
    if (!begin_line(t, kind))
        return;
    size_t first = t->count;
    for (size_t k = 0; k < count && !t->failed; k++) {
        const struct polygons_point *before = &loop[(k + count - 1) % count];
        const struct polygons_point *next = &loop[(k + 1) % count];
        const double z[2] = {before->x / d[0], before->y / d[1]};
        const double a[2] = {loop[k].x / d[0], loop[k].y / d[1]};
        const double b[2] = {next->x / d[0], next->y / d[1]};
        double last[2], inward[2], corner[2];
        unit_left_of(z, a, last);
        unit_left_of(a, b, inward);
        const double sum[2] = {last[1] + inward[1], -last[0] - inward[0]};
        unit_left_of(origin, sum, corner);
        trace_edge(t, a, b, corner, inward);
    }
    if (t->count > first) {
        const struct traced_point begin = t->points[first];
        add_traced(t, &begin);
    }
    t->lines[t->line_count - 1].end = t->count;
}

/* The edges of a shape and a line along its warp, in the middle half of the longest there is. */
static void trace_shape(struct tracing *t, const struct flat_ply *shape, const double d[2]) {
    static const double nowhere[2] = {0, 0};
    const struct polygons *cut = &shape->cut;
    for (size_t first = 0, end; first < cut->count; first = end) {
        bool hole = polygons_loop_area(cut, first, &end) < 0;
        trace_polygon(t, &cut->points[first], end - first, d, hole ? LASER_HOLE : LASER_EDGE);
    }
    const struct nesting_shape outline = {.cut = cut,
                                          .low = {shape->low[0], shape->low[1]},
                                          .high = {shape->high[0], shape->high[1]}};
    const struct cut_chord chord = cut_chord_of(&outline);
    double quarter = (chord.x[1] - chord.x[0]) / 4;
    const double from[2] = {(chord.x[0] + quarter) / d[0], chord.y / d[1]};
    const double to[2] = {(chord.x[1] - quarter) / d[0], chord.y / d[1]};
    struct traced_point end;
    if (!(quarter > 0) || !begin_line(t, LASER_WARP))
        return;
    trace_edge(t, from, to, nowhere, nowhere);
    if (trace_point(t, to, nowhere, &end))
        add_traced(t, &end);
    t->lines[t->line_count - 1].end = t->count;
}

/* The same, with the net at hand. */
static enum api_problem_id trace_ply(struct tracing *t, const struct api_reader *net,
                                     const struct flat_ply *shape, struct api_problem *problem) {
    static const enum column_id kept[] = {COLUMN_CELLS_warp, COLUMN_CELLS_weft};
    struct arena_mark mark = arena_mark(t->arena);
    struct map_net *cloth = arena_alloc(t->arena, 1, sizeof *cloth);
    if (!cloth)
        return api_problem_no_memory(problem, "the lines");
    if (map_net_open(net, cloth, problem) != API_OK)
        return problem->id;
    map_net_keep(cloth, kept, sizeof kept / sizeof *kept);
    if (map_net_load(net, NULL, t->arena, cloth, problem) != API_OK)
        return problem->id;
    t->cloth = &cloth->facets->source;
    struct cell_place *places = arena_alloc(t->arena, t->cloth->cell_count, sizeof *places);
    if (!places)
        return api_problem_no_memory(problem, "the lines");
    for (size_t k = 0; k < t->cloth->cell_count; k++)
        places[k] = (struct cell_place){t->cloth->places[k][0], t->cloth->places[k][1], (int32_t)k};
    qsort(places, t->cloth->cell_count, sizeof *places, compare_cell_places);
    t->places = places;
    trace_shape(t, shape, cloth->columns.grid.spacing);
    arena_rewind(t->arena, mark);
    return t->failed ? api_problem_no_memory(problem, "the lines") : API_OK;
}

/* ---- heights ---- */

/* At a point what lies below the first layer of its ply, and how much every layer adds: that of its
 * own piece, and those of the pieces of its ply that lie below it. */
struct heights {
    double below, beside, own;
};

/* Whether ply i, another piece of the ply of k, lies below that where both are. */
static bool is_beside(const struct laminate *laminate, size_t i, size_t k) {
    const struct laminate_pieces *pieces = laminate->plies[k].pieces;
    bool first_above = pieces && pieces->seam.over == LAMINATE_OVER_FIRST;
    return laminate->plies[i].number == laminate->plies[k].number && (first_above ? i > k : i < k);
}

static struct heights heights_at(const struct ply_samples *samples, size_t k, size_t point) {
    const struct laminate *laminate = samples->laminate;
    struct heights heights = {0, 0, 0};
    for (size_t i = 0; i < laminate->count; i++) {
        const struct laminate_ply *ply = &laminate->plies[i];
        bool below = ply->number < laminate->plies[k].number;
        bool beside = is_beside(laminate, i, k);
        if ((!below && !beside && i != k) || !ply_samples_has(samples, i, point))
            continue;
        double shear = samples->samples[ply->net * samples->count + point].shear_deg;
        double thickness = ply->drape.fabric.thickness *
                           permeability_areal_ratio(shear, ply->drape.settings.slide);
        *(below    ? &heights.below
          : beside ? &heights.beside
                   : &heights.own) += below ? laminate_layers(ply) * thickness : thickness;
    }
    return heights;
}

/* Looks at the stack at all points. */
static bool sample_stack(const struct tracing *t, const struct api_reader *const *nets,
                         struct ply_samples *samples) {
    struct vec3 *inner = arena_alloc(t->arena, t->count, sizeof *inner);
    struct map_target *target = arena_alloc(t->arena, 1, sizeof *target);
    struct api_map *map = arena_alloc(t->arena, 1, sizeof *map);
    if (!inner || !target || !map)
        return ply_samples_no_memory(samples);
    for (size_t k = 0; k < t->count; k++)
        inner[k] = t->points[k].inner;
    *target =
        (struct map_target){.vertices = inner, .vertex_count = t->count, .element_count = t->count};
    samples->target = target;
    samples->map = map;
    samples->count = t->count;
    return ply_samples_read(samples, nets);
}

/* Keeps of a line what its chords need to stay near enough to all of it: the number of points. */
static size_t thin_line(struct laser_point *points, size_t count, double tolerance) {
    size_t kept = 0, anchor = 0;
    for (size_t k = 0; k < count; k++) {
        bool needed = k == 0 || k + 1 == count || k - anchor >= SKIPPED_MAX;
        struct vec3 way =
            needed ? vec3_make(0, 0, 0) : vec3_sub(points[k + 1].r, points[kept - 1].r);
        double length2 = vec3_norm2(way);
        for (size_t n = anchor + 1; n <= k && !needed; n++) {
            struct vec3 at = vec3_sub(points[n].r, points[kept - 1].r);
            double share = length2 > 0 ? fmin(fmax(vec3_dot(at, way) / length2, 0), 1) : 0;
            needed = vec3_norm(vec3_axpy(-share, way, at)) > tolerance;
        }
        if (needed) {
            points[kept++] = points[k];
            anchor = k;
        }
    }
    return kept;
}

/* Lines first to end of ply k for one of its layers, from 0. */
static bool lift_lines(const struct tracing *t, const struct heights *heights, int number,
                       size_t first, size_t end, struct laser_layer *layer) {
    struct laser_line *lines = arena_alloc(t->arena, end - first, sizeof *lines);
    layer->lines = lines;
    layer->line_count = end - first;
    for (size_t k = first; k < end && lines; k++) {
        const struct traced_line *line = &t->lines[k];
        size_t count = line->end - line->first;
        struct laser_point *points = arena_alloc(t->arena, count, sizeof *points);
        if (!points)
            return false;
        for (size_t n = 0; n < count; n++) {
            const struct traced_point *at = &t->points[line->first + n];
            const struct heights *own = &heights[line->first + n];
            double height = own->below + number * own->own + (number + 1) * own->beside;
            points[n] =
                (struct laser_point){vec3_axpy(height, at->normal, at->foot), at->normal, height};
        }
        lines[k - first] =
            (struct laser_line){line->kind, points, thin_line(points, count, t->tolerance)};
    }
    return lines;
}

/* ---- the whole ---- */

/* What is known of every ply that something lies on. */
static bool may_be_lit(const struct laminate *laminate, struct api_problem *problem) {
    for (size_t k = 0; k < laminate->count; k++) {
        const struct laminate_ply *ply = &laminate->plies[k];
        bool covered = k + 1 < laminate->count || laminate_layers(ply) > 1;
        char title[LAMINATE_TITLE_SIZE];
        laminate_title(ply, title);
        if (covered && !(ply->drape.fabric.thickness > 0))
            return !api_problem_set(problem, API_INVALID_REQUEST,
                                    "the height at which a laser draws is that of the stack below, "
                                    "and the thickness of ply %zu (\"%s\") is not known: state its "
                                    "fabric.thickness, or ask for patterns",
                                    ply->number + 1, title);
    }
    return true;
}

/* Of every shape its layers, in the order of laying: plies, layers, pieces. */
static bool lift_all(const struct tracing *t, const struct flat_plies *shapes, const size_t *first,
                     const struct heights *heights, struct laser_layer *layers) {
    for (size_t begin = 0, end; begin < shapes->count; begin = end) {
        const struct laminate_ply *plies = t->laminate->plies;
        size_t number = plies[shapes->shapes[begin].ply].number;
        int most = laminate_layers(&plies[shapes->shapes[begin].ply]);
        for (end = begin; end < shapes->count && plies[shapes->shapes[end].ply].number == number;)
            most = (int)fmax(most, laminate_layers(&plies[shapes->shapes[end++].ply]));
        bool backwards =
            is_beside(t->laminate, shapes->shapes[end - 1].ply, shapes->shapes[begin].ply);
        for (int n = 0; n < most; n++)
            for (size_t step = begin; step < end; step++) {
                size_t s = backwards ? begin + end - 1 - step : step;
                const struct laminate_ply *ply = &plies[shapes->shapes[s].ply];
                char *title = arena_alloc(t->arena, LAMINATE_TITLE_SIZE, 1);
                if (n >= laminate_layers(ply))
                    continue;
                *layers = (struct laser_layer){.ply = (int)number + 1,
                                               .piece = ply->pieces ? (int)ply->piece + 1 : 0,
                                               .layer = n + 1,
                                               .layers = laminate_layers(ply),
                                               .title = title};
                if (!title || !lift_lines(t, heights, n, first[s], first[s + 1], layers++))
                    return false;
                laminate_title(ply, title);
            }
    }
    return true;
}

/* All lines: of shape s those from first[s] to first[s + 1] - 1. */
static enum api_problem_id trace_all(struct tracing *t, const struct api_reader *const *nets,
                                     const struct flat_plies *shapes, size_t *first,
                                     struct api_problem *problem) {
    if (laminate_part(t->laminate, &api_limits_default, t->arena, &t->shape, problem) != API_OK)
        return problem->id;
    for (size_t s = 0; s < shapes->count; s++) {
        const struct flat_ply *shape = &shapes->shapes[s];
        const struct api_reader *net = nets[t->laminate->plies[shape->ply].net];
        if (trace_ply(t, net, shape, problem) != API_OK)
            return problem->id;
        first[s + 1] = t->line_count;
    }
    return API_OK;
}

static enum api_problem_id lift_traced(const struct tracing *t,
                                       const struct api_reader *const *nets,
                                       const struct flat_plies *shapes, const size_t *first,
                                       struct laser_sheet *sheet, struct api_problem *problem) {
    struct ply_samples samples = {.laminate = t->laminate, .arena = t->arena, .problem = problem};
    struct heights *heights = arena_alloc(t->arena, t->count, sizeof *heights);
    if (!heights)
        return api_problem_no_memory(problem, "the lines");
    if (!sample_stack(t, nets, &samples))
        return problem->id;
    for (size_t s = 0; s < shapes->count; s++) {
        const struct flat_ply *shape = &shapes->shapes[s];
        sheet->layer_count += (size_t)laminate_layers(&t->laminate->plies[shape->ply]);
        for (size_t k = first[s]; k < first[s + 1]; k++)
            for (size_t n = t->lines[k].first; n < t->lines[k].end; n++)
                heights[n] = heights_at(&samples, shape->ply, n);
    }
    struct laser_layer *layers = arena_alloc(t->arena, sheet->layer_count, sizeof *layers);
    sheet->layers = layers;
    return layers && lift_all(t, shapes, first, heights, layers)
               ? API_OK
               : api_problem_no_memory(problem, "the lines");
}

enum api_problem_id laser_make(const struct laminate *laminate,
                               const struct api_reader *const *nets,
                               const struct flat_plies *shapes, double tolerance,
                               struct arena *arena, struct laser_sheet *sheet,
                               struct api_problem *problem) {
    struct tracing t = {.laminate = laminate, .arena = arena, .tolerance = tolerance / 2};
    size_t *first = arena_alloc(arena, shapes->count + 1, sizeof *first);
    *sheet = (struct laser_sheet){
        .unit = laminate->length_unit, .revision = laminate->revision, .tolerance = tolerance};
    if (!first)
        return api_problem_no_memory(problem, "the lines");
    if (may_be_lit(laminate, problem) && trace_all(&t, nets, shapes, first, problem) == API_OK)
        (void)!lift_traced(&t, nets, shapes, first, sheet, problem);
    free(t.points);
    free(t.lines);
    return problem->id;
}

/* ---- edges alone ---- */

/* That of a shape whose lines are first to end: its only one, or none. */
static bool keep_outline(const struct tracing *t, size_t first, size_t end,
                         struct map_outline *outline) {
    const struct traced_line *edge = NULL;
    size_t loops = 0;
    for (size_t k = first; k < end; k++) {
        loops += t->lines[k].kind != LASER_WARP;
        edge = t->lines[k].kind == LASER_EDGE ? &t->lines[k] : edge;
    }
    size_t count = loops == 1 && edge ? edge->end - edge->first : 0;
    struct laser_point *points = arena_alloc(t->arena, count, sizeof *points);
    struct vec3 *places = arena_alloc(t->arena, count, sizeof *places);
    if (!points || !places)
        return false;
    for (size_t n = 0; n < count; n++)
        points[n].r = t->points[edge->first + n].foot;
    *outline = (struct map_outline){places, thin_line(points, count, t->tolerance)};
    for (size_t n = 0; n < outline->count; n++)
        places[n] = points[n].r;
    return true;
}

enum api_problem_id laser_outlines(const struct laminate *laminate,
                                   const struct api_reader *const *nets, struct arena *arena,
                                   const struct map_outline **outlines,
                                   struct api_problem *problem) {
    struct tracing t = {.laminate = laminate,
                        .arena = arena,
                        .tolerance = LASER_TOLERANCE / laminate->length_unit->metres / 2};
    struct flat_plies shapes = {.count = 0};
    struct map_outline *all = arena_alloc(arena, laminate->count, sizeof *all);
    size_t *first = arena_alloc(arena, laminate->count + 1, sizeof *first);
    *outlines = all;
    if (!all || !first)
        return api_problem_no_memory(problem, "the edges");
    if (flat_plies_make(laminate, nets, LAMINATE_ALL, arena, &shapes, problem) == API_OK &&
        trace_all(&t, nets, &shapes, first, problem) == API_OK)
        for (size_t s = 0; s < shapes.count; s++)
            if (!keep_outline(&t, first[s], first[s + 1], &all[shapes.shapes[s].ply]))
                api_problem_no_memory(problem, "the edges");
    flat_plies_free(&shapes);
    free(t.points);
    free(t.lines);
    return problem->id;
}
