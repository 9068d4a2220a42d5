/* SPDX-License-Identifier: MIT */
#include "trim.h"

#include "quadrature.h"
#include "spans.h"
#include <stdlib.h>
#include <string.h>

enum { ORDER_MAX = NURBS_DEGREE_MAX + 1, HALVINGS = 16, STRIPS_MAX = 4096, LINES = 512 };
enum { HALVINGS_OF_SPAN = 6 }; /* of the surface, for the lines of the area */

/* Flattened curves deviate from the curve by less than this share of the domain. */
static const double flatness = 1e-6;

/* Loops have a corner where the tangent of the angle by which they turn is more, by the domain; and
 * breaks nearer to each other than this share of the region's height are one. */
static const double corner_tangent = 0.1, same_break = 1e-12;

/* Along a line the integrand is resolved when no larger share of it is in the rule's last
 * polynomials, or no more than this share of the domain is left. */
static const double unresolved = 3e-4, shortest_line = 1e-3;

/* What keeps the work in proportion to what the caller wrote, however the loops run: edges that
 * curves may be flattened into, entries in the strips for each edge, and points where all the
 * lines of the area together cross edges. Beyond them curves are halved fewer times, strips are
 * higher and lines fewer. A part with a hundred rows of a hundred holes has 1e5 crossings. */
static const size_t edges_most = (size_t)1 << 18, edges_per_point = 2;
static const size_t entries_per_edge = 8, entries_least = 64;
static const size_t crossings_most = (size_t)1 << 18, crossings_per_edge = 4;

struct edge {
    double u[2], v[2]; /* v[0] <= v[1] */
    uint32_t loop;
};

struct trim {
    const struct surface *surface;
    struct trim_loop *loops;       /* a copy, whose curves are only there while it is made */
    size_t loop_count, kept_count; /* kept: loops that keep their inside */
    struct edge *edges;
    size_t edge_count;
    const double (*points)[2]; /* of all loops, one after the other, each closed */
    size_t *first_point;       /* of each loop, and one more */
    double low[2], high[2];    /* box around the edges; the domain if nothing keeps its inside */
    double strip_height;
    size_t strip_count, *strip_first; /* strip_count + 1 indices in strip_edges */
    uint32_t *strip_edges;            /* by strip, and there by loop */
    double area, middle[2];
    struct vec3 centroid;
    double gyration2;
    size_t steps;
};

/* Edges while they are collected. */
struct collector {
    struct arena *arena;
    struct edge *edges;
    size_t count, room;
    size_t most;  /* edges from curves that are allowed; beyond them `crowded` is set */
    int halvings; /* how often a knot span is halved at the most */
    bool crowded;
    double tolerance[2];
    uint32_t loop;
    double last[2];
    bool begun;
    double (*points)[2]; /* as they come, the edges' ends */
    size_t point_count, point_room;
};

static bool add_flat_edge(struct collector *c, const double to[2]) {
    if (c->point_count == c->point_room) {
        double(*points)[2] =
            arena_enlarge(c->arena, c->points, c->point_count, sizeof *points, &c->point_room);
        if (!points)
            return false;
        c->points = points;
    }
    memcpy(c->points[c->point_count++], to, sizeof *c->points);
    if (!c->begun) {
        memcpy(c->last, to, sizeof c->last);
        c->begun = true;
        return true;
    }
    if (c->count == c->room) {
        struct edge *edges = arena_enlarge(c->arena, c->edges, c->count, sizeof *edges, &c->room);
        if (!edges)
            return false;
        c->edges = edges;
    }
    bool up = c->last[1] <= to[1];
    const double *low = up ? c->last : to, *high = up ? to : c->last;
    if (low[1] < high[1])
        c->edges[c->count++] = (struct edge){{low[0], high[0]}, {low[1], high[1]}, c->loop};
    memcpy(c->last, to, sizeof c->last);
    return true;
}

/* By de Boor's algorithm in homogeneous coordinates; the derivative is p times the difference of
 * the last two points, by the span. */
void trim_curve_in_span(const struct trim_curve *curve, size_t l, double t, double uv[2],
                        double rate[2]) {
    if (!curve->knots) {
        for (int x = 0; x < 2; x++) {
            double way = curve->points[l + 1][x] - curve->points[l][x];
            uv[x] = curve->points[l][x] + t * way;
            if (rate)
                rate[x] = way;
        }
        return;
    }
    int p = curve->degree;
    double d[ORDER_MAX][3], before[3] = {0, 0, 0};
    for (int k = 0; k <= p; k++) {
        size_t at = l - (size_t)p + (size_t)k;
        double w = curve->weights ? curve->weights[at] : 1;
        d[k][0] = w * curve->points[at][0];
        d[k][1] = w * curve->points[at][1];
        d[k][2] = w;
    }
    for (int r = 1; r <= p; r++)
        for (int k = p; k >= r; k--) {
            const double *knot = curve->knots + l - (size_t)p + (size_t)k;
            double a = (t - knot[0]) / (knot[p - r + 1] - knot[0]);
            if (r == p)
                for (int x = 0; x < 3; x++)
                    before[x] = p * (d[k][x] - d[k - 1][x]) / (knot[1] - knot[0]);
            for (int x = 0; x < 3; x++)
                d[k][x] = (1 - a) * d[k - 1][x] + a * d[k][x];
        }
    for (int x = 0; x < 2; x++) {
        uv[x] = d[p][x] / d[p][2];
        if (rate)
            rate[x] = (before[x] - before[2] * uv[x]) / d[p][2];
    }
}

void trim_curve_range(const struct trim_curve *curve, double range[2]) {
    range[0] = curve->knots ? curve->knots[curve->degree] : 0;
    range[1] = curve->knots ? curve->knots[curve->count] : (double)(curve->count - 1);
}

/* By the last knot span that begins at `from` or before it. */
void trim_curve_beyond(const struct trim_curve *curve, double from, double t, double uv[2],
                       double rate[2]) {
    if (!curve->knots) {
        size_t k = (size_t)fmin(floor(from), (double)curve->count - 2);
        trim_curve_in_span(curve, k, t - (double)k, uv, rate);
        return;
    }
    size_t low = (size_t)curve->degree, high = curve->count;
    while (high - low > 1) {
        size_t middle = low + (high - low) / 2;
        *(curve->knots[middle] <= from ? &low : &high) = middle;
    }
    while (low > (size_t)curve->degree && !(curve->knots[low + 1] > curve->knots[low]))
        low--;
    trim_curve_in_span(curve, low, t, uv, rate);
}

void trim_curve_at(const struct trim_curve *curve, double t, double uv[2], double rate[2]) {
    double range[2];
    trim_curve_range(curve, range);
    t = fmin(fmax(t, range[0]), range[1]);
    trim_curve_beyond(curve, t, t, uv, rate);
}

void trim_curve_end(const struct trim_curve *curve, int end, double uv[2]) {
    double range[2];
    trim_curve_range(curve, range);
    trim_curve_at(curve, range[end], uv, NULL);
}

/* A piece of a curve within one knot span. */
struct piece {
    double t[2], from[2], to[2];
};

/* Halves the span until its pieces are flat; a stack of the halves yet to come. */
static bool flatten_span(struct collector *c, const struct trim_curve *curve, size_t l) {
    struct piece stack[HALVINGS + 1];
    static const double shares[] = {0.5, 0.25, 0.75};
    int depth = 0;
    stack[0].t[0] = curve->knots[l];
    stack[0].t[1] = curve->knots[l + 1];
    trim_curve_in_span(curve, l, stack[0].t[0], stack[0].from, NULL);
    trim_curve_in_span(curve, l, stack[0].t[1], stack[0].to, NULL);
    if (!add_flat_edge(c, stack[0].from))
        return false;
    while (depth >= 0) {
        struct piece *top = &stack[depth];
        struct piece first = *top;
        first.t[1] = top->t[0] + (top->t[1] - top->t[0]) / 2;
        bool flat = true; /* near its chord at its quarters, the middle first */
        for (int n = 0; n < 3 && flat && depth < c->halvings; n++) {
            double own[2], *at = n == 0 ? first.to : own;
            trim_curve_in_span(curve, l, top->t[0] + shares[n] * (top->t[1] - top->t[0]), at, NULL);
            for (int k = 0; k < 2; k++) {
                double chord = top->from[k] + shares[n] * (top->to[k] - top->from[k]);
                flat = flat && !(fabs(at[k] - chord) > c->tolerance[k]);
            }
        }
        if (flat) {
            if (!add_flat_edge(c, top->to))
                return false;
            c->crowded = c->crowded || (c->count > c->most && c->halvings > 0);
            if (c->crowded)
                return true;
            depth--;
            continue;
        }
        top->t[0] = first.t[1];
        memcpy(top->from, first.to, sizeof first.to);
        stack[++depth] = first;
    }
    return true;
}

static size_t strip_at(const struct trim *trim, double v) {
    double strip = (v - trim->low[1]) / trim->strip_height;
    return strip < 0                            ? 0
           : strip >= (double)trim->strip_count ? trim->strip_count - 1
                                                : (size_t)strip;
}

/* Sorts the edges into strips of v by counting; edges are in the order of their loops already. */
static enum status sort_into_strips(struct trim *trim, struct arena *arena) {
    size_t wanted = trim->edge_count / 4 + 1, total = 0;
    size_t most = entries_least + entries_per_edge * trim->edge_count;
    wanted = wanted < STRIPS_MAX ? wanted : STRIPS_MAX;
    if (!(trim->high[1] > trim->low[1]))
        return STATUS_DEGENERATE_SURFACE;
    for (;; wanted = (wanted + 1) / 2) { /* so few strips that edges do not take too many entries */
        size_t entries = 0;
        trim->strip_count = wanted;
        trim->strip_height = (trim->high[1] - trim->low[1]) / (double)wanted;
        for (size_t k = 0; k < trim->edge_count; k++)
            entries +=
                strip_at(trim, trim->edges[k].v[1]) - strip_at(trim, trim->edges[k].v[0]) + 1;
        trim->steps += trim->edge_count;
        if (entries <= most)
            break;
    }
    trim->strip_first = arena_alloc(arena, trim->strip_count + 1, sizeof *trim->strip_first);
    if (!trim->strip_first)
        return STATUS_OUT_OF_MEMORY;
    for (size_t k = 0; k < trim->edge_count; k++)
        for (size_t s = strip_at(trim, trim->edges[k].v[0]);
             s <= strip_at(trim, trim->edges[k].v[1]); s++)
            trim->strip_first[s + 1]++;
    for (size_t s = 0; s < trim->strip_count; s++)
        total = trim->strip_first[s + 1] += trim->strip_first[s];
    trim->strip_edges = arena_alloc(arena, total, sizeof *trim->strip_edges);
    size_t *fill = arena_alloc(arena, trim->strip_count, sizeof *fill);
    if (!trim->strip_edges || !fill)
        return STATUS_OUT_OF_MEMORY;
    for (size_t k = 0; k < trim->edge_count; k++)
        for (size_t s = strip_at(trim, trim->edges[k].v[0]);
             s <= strip_at(trim, trim->edges[k].v[1]); s++)
            trim->strip_edges[trim->strip_first[s] + fill[s]++] = (uint32_t)k;
    trim->steps += 2 * total + trim->strip_count;
    return STATUS_OK;
}

/* Where the edge meets the line v = const; false when it does not. The lower end belongs to it. */
static bool crossing(const struct edge *edge, double v, double *u) {
    if (v < edge->v[0] || v >= edge->v[1])
        return false;
    double share = (v - edge->v[0]) / (edge->v[1] - edge->v[0]);
    *u = edge->u[0] + share * (edge->u[1] - edge->u[0]);
    return true;
}

bool trim_contains(const struct trim *trim, const double uv[2]) {
    size_t kept = 0, strip = strip_at(trim, uv[1]);
    const uint32_t *at = trim->strip_edges + trim->strip_first[strip];
    const uint32_t *end = trim->strip_edges + trim->strip_first[strip + 1];
    while (at < end) {
        uint32_t loop = trim->edges[*at].loop;
        bool inside = false;
        for (; at < end && trim->edges[*at].loop == loop; at++) {
            double u;
            if (crossing(&trim->edges[*at], uv[1], &u) && u <= uv[0])
                inside = !inside;
        }
        if (inside && !trim->loops[loop].reversed)
            return false;
        kept += inside;
    }
    return kept > 0 || trim->kept_count == 0;
}

bool trim_near(const struct trim *trim, const double uv[2]) {
    return uv[0] >= trim->low[0] && uv[0] <= trim->high[0] && uv[1] >= trim->low[1] &&
           uv[1] <= trim->high[1];
}

double trim_area(const struct trim *trim, struct vec3 *centroid) {
    *centroid = trim->centroid;
    return trim->area;
}

double trim_gyration2(const struct trim *trim) {
    return trim->gyration2;
}

void trim_middle(const struct trim *trim, double uv[2]) {
    uv[0] = trim->middle[0];
    uv[1] = trim->middle[1];
}

/* What the lines of v = const gather. */
struct gathered {
    struct surface_cursor cursor;
    const struct quadrature *rule;
    double area;
    struct vec3 moment;
    double square; /* of the distance from the middle of the surface's box */
};

/* |r_u x r_v| and r at points of a line of v, in the caller's parameters: as a grid, to the same
 * bits, where the points lie in one span. */
static void evaluate_line(const struct surface *surface, struct surface_cursor *cursor,
                          const double *u, double v, int count, double *density, struct vec3 *r) {
    const struct surface_axis *axis = surface->axis;
    struct surface_element elements[QUADRATURE_MAX];
    double own[2][QUADRATURE_MAX] = {{0}}, across = surface_axis_inner(&axis[1], v);
    struct surface_grid grid = {.count = {count, 1}, .at = {own[0], own[1]}};
    double rate = surface_axis_rate(&axis[1], across, NULL);
    for (int k = 0; k < count; k++)
        own[0][k] = surface_axis_wrap(&axis[0], surface_axis_inner(&axis[0], u[k]));
    own[1][0] = surface_axis_wrap(&axis[1], across);
    for (int n = 0; n < 2; n++)
        grid.span[n] = surface_axis_span(&axis[n], 0, own[n][0]);
    bool together = surface->height == 0 &&
                    surface_axis_span(&axis[0], grid.span[0], own[0][count - 1]) == grid.span[0];
    if (together)
        surface_evaluate_grid(surface, &grid, elements);
    for (int k = 0; k < count; k++) {
        struct surface_jet jet;
        if (together) {
            double along = surface_axis_rate(&axis[0], own[0][k], NULL);
            jet.r = elements[k].r;
            jet.u = vec3_scale(along, elements[k].u);
            jet.v = vec3_scale(rate, elements[k].v);
        } else {
            surface_evaluate(surface, cursor, u[k], v, &jet);
        }
        density[k] = vec3_norm(vec3_cross(jet.u, jet.v));
        r[k] = jet.r;
    }
}

/* Adds int |r_u x r_v| du, and r times it, from a to b on the line v, times `weight`; between
 * breaks of u, because the surface is smooth only there, and by halves where the rule does not
 * resolve it. */
static void integrate_line(const struct surface *surface, struct gathered *sum, double a, double b,
                           double v, double weight) {
    const struct surface_axis *axis = &surface->axis[0];
    const struct quadrature *rule = sum->rule;
    struct vec3 r[QUADRATURE_MAX];
    double u[QUADRATURE_MAX] = {0}, density[QUADRATURE_MAX] = {0};
    double least = shortest_line * (axis->outer[1] - axis->outer[0]), end = a;
    for (double from = a, to; from < b; from = to) {
        if (from >= end) { /* the next break, of which rounding may have left a little */
            int span = surface_axis_span(axis, 0, surface_axis_inner(axis, from));
            do
                end = surface_axis_outer(axis, axis->breaks[++span]);
            while (end <= from + least * least && span < axis->span_count);
            end = end > from && end < b ? end : b;
        }
        double mean = 0;
        for (to = end;; to = from + (to - from) / 2) {
            for (int k = 0; k < rule->count; k++)
                u[k] = (from + to + (to - from) * rule->node[k]) / 2;
            evaluate_line(surface, &sum->cursor, u, v, rule->count, density, r);
            mean = 0;
            for (int k = 0; k < rule->count; k++)
                mean += rule->weight[k] * density[k] / 2;
            if (quadrature_tail(rule, density, 1) <= unresolved * mean || !(to - from > least))
                break;
        }
        for (int k = 0; k < rule->count; k++) {
            double element = weight * rule->weight[k] * (to - from) / 2 * density[k];
            sum->area += element;
            sum->moment = vec3_axpy(element, r[k], sum->moment);
            sum->square += element * vec3_norm2(vec3_sub(r[k], surface_box_middle(surface)));
        }
    }
}

/* Where a line meets an edge of a loop. */
struct line_crossing {
    double u;
    uint32_t loop;
};

/* Lines of v = const with their weights, and where they meet edges: line k those from first[k] to
 * first[k + 1]. */
struct lines {
    double *height, *weight;
    size_t count, *first;
    struct line_crossing *crossings;
};

static int compare_doubles(const void *a, const void *b) {
    const double *x = a, *y = b;
    return (*x > *y) - (*x < *y);
}

/* Adds the values of v between which the surface's element of area is resolved along v at some u,
 * by halving from a to b. */
static void add_resolved(const struct trim *trim, const struct quadrature *rule, double a, double b,
                         int depth, double *breaks, size_t *count) {
    struct surface_cursor cursor = {0};
    bool resolved = depth == 0;
    for (int n = 0; n < 3 && !resolved; n++) {
        double density[QUADRATURE_MAX] = {0}, mean = 0;
        double u = trim->low[0] + (n + 0.5) / 3 * (trim->high[0] - trim->low[0]);
        for (int k = 0; k < rule->count; k++) {
            struct surface_jet jet;
            surface_evaluate(trim->surface, &cursor, u, (a + b + (b - a) * rule->node[k]) / 2,
                             &jet);
            density[k] = vec3_norm(vec3_cross(jet.u, jet.v));
            mean += rule->weight[k] * density[k] / 2;
        }
        if (!(quadrature_tail(rule, density, 1) <= unresolved * mean))
            break;
        resolved = n == 2;
    }
    double middle = (a + b) / 2;
    if (resolved)
        return;
    add_resolved(trim, rule, a, middle, depth - 1, breaks, count);
    breaks[(*count)++] = middle;
    add_resolved(trim, rule, middle, b, depth - 1, breaks, count);
}

/* The values of v at which what lines cut out of the region is not smooth: corners of loops, and
 * where they turn back; and knots of the surface. In order, each once. */
static size_t find_breaks(const struct trim *trim, double *breaks) {
    const struct surface_axis *axis = trim->surface->axis;
    double by[2], height = trim->high[1] - trim->low[1];
    size_t count = 0, kept = 1;
    for (int k = 0; k < 2; k++)
        by[k] = 1 / (axis[k].outer[1] - axis[k].outer[0]);
    breaks[count++] = trim->low[1];
    breaks[count++] = trim->high[1];
    struct quadrature rule = quadrature_make(QUADRATURE_MAX / 2);
    double from = trim->low[1];
    for (int span = 1; span <= axis[1].span_count && from < trim->high[1]; span++) {
        double to = surface_axis_outer(&axis[1], axis[1].breaks[span]);
        if (to <= from)
            continue;
        to = fmin(to, trim->high[1]);
        add_resolved(trim, &rule, from, to, HALVINGS_OF_SPAN, breaks, &count);
        breaks[count++] = from = to;
    }
    for (size_t loop = 0; loop < trim->loop_count; loop++) {
        const double(*points)[2];
        size_t last = trim_loop_points(trim, loop, &points);
        for (size_t k = 1; k < last; k++) { /* the last point is the first */
            const double *at = points[k], *before = points[k - 1];
            const double *after = points[k + 1 < last ? k + 1 : 1];
            double a[2], b[2];
            for (int x = 0; x < 2; x++) {
                a[x] = by[x] * (at[x] - before[x]);
                b[x] = by[x] * (after[x] - at[x]);
            }
            double cross = a[0] * b[1] - a[1] * b[0], along = a[0] * b[0] + a[1] * b[1];
            if (!(a[1] * b[1] > 0) || !(fabs(cross) < corner_tangent * along))
                breaks[count++] = at[1];
        }
    }
    qsort(breaks, count, sizeof *breaks, compare_doubles);
    size_t first = 0;
    while (breaks[first] < trim->low[1])
        first++;
    breaks[0] = breaks[first];
    for (size_t k = first + 1; k < count && breaks[k] <= trim->high[1]; k++)
        if (breaks[k] > breaks[kept - 1] + same_break * height)
            breaks[kept++] = breaks[k];
    return kept;
}

/* Gauss's rule of `order` between breaks, in x from -1 to 1 with v = m + h (3 x - x^3) / 2: so that
 * where a loop turns back, and the lines' lengths go with the root of v, they are smooth in x. */
static void place_lines(const double *breaks, size_t count, int order, struct lines *lines) {
    struct quadrature rule = quadrature_make(order);
    lines->count = 0;
    for (size_t k = 0; k + 1 < count; k++) {
        double middle = (breaks[k] + breaks[k + 1]) / 2, half = (breaks[k + 1] - breaks[k]) / 2;
        for (int n = order - 1; n >= 0; n--) {
            double x = rule.node[n];
            lines->height[lines->count] = middle + half * x * (3 - x * x) / 2;
            lines->weight[lines->count++] =
                order == 1 ? 2 * half : half * rule.weight[n] * 3 * (1 - x * x) / 2;
        }
    }
}

/* The first line at v or above. */
static size_t first_line_from(const struct lines *lines, double v) {
    size_t low = 0, high = lines->count;
    while (low < high) {
        size_t middle = (low + high) / 2;
        if (lines->height[middle] < v)
            low = middle + 1;
        else
            high = middle;
    }
    return low;
}

static int compare_line_crossings(const void *a, const void *b) {
    const struct line_crossing *x = a, *y = b;
    return (x->u > y->u) - (x->u < y->u);
}

/* Chooses the lines and finds all points where they meet edges, in order. Where breaks are too many
 * lines are at even distances. */
static bool cross_lines(struct trim *trim, struct lines *lines, struct arena *arena) {
    size_t most = crossings_most + crossings_per_edge * trim->edge_count, total, points = 0;
    const double(*loop_points)[2];
    for (size_t k = 0; k < trim->loop_count; k++)
        points += trim_loop_points(trim, k, &loop_points);
    size_t room = points + ((size_t)trim->surface->axis[1].span_count << HALVINGS_OF_SPAN) + 2;
    double *breaks = arena_alloc(arena, room > LINES ? room : LINES + 1, sizeof *breaks);
    lines->height = arena_alloc(arena, LINES, sizeof *lines->height);
    lines->weight = arena_alloc(arena, LINES, sizeof *lines->weight);
    if (!breaks || !lines->height || !lines->weight)
        return false;
    size_t count = find_breaks(trim, breaks), even = LINES;
    for (int order = QUADRATURE_MAX;; order /= 2) {
        while (order > 1 && (count - 1) * (size_t)order > LINES)
            order /= 2;
        for (size_t k = 0; order < 2 && k <= even; k++)
            breaks[k] = trim->low[1] + (double)k / (double)even * (trim->high[1] - trim->low[1]);
        place_lines(breaks, order < 2 ? even + 1 : count, order < 2 ? 1 : order, lines);
        total = 0;
        for (size_t k = 0; k < trim->edge_count; k++)
            total += first_line_from(lines, trim->edges[k].v[1]) -
                     first_line_from(lines, trim->edges[k].v[0]);
        trim->steps += trim->edge_count;
        if (total <= most || even == 1)
            break;
        even /= order < 2 ? 2 : 1;
    }
    lines->first = arena_alloc(arena, lines->count + 2, sizeof *lines->first);
    lines->crossings = arena_alloc(arena, total, sizeof *lines->crossings);
    if (!lines->first || !lines->crossings)
        return false;
    size_t *fill =
        lines->first + 1; /* where the next crossing of a line goes: in the end its end */
    for (size_t k = 0; k < trim->edge_count; k++) {
        const struct edge *edge = &trim->edges[k];
        for (size_t at = first_line_from(lines, edge->v[0]);
             at < first_line_from(lines, edge->v[1]); at++)
            fill[at + 1]++;
    }
    for (size_t at = 0; at < lines->count; at++)
        fill[at + 1] += fill[at];
    for (size_t k = 0; k < trim->edge_count; k++) {
        const struct edge *edge = &trim->edges[k];
        for (size_t at = first_line_from(lines, edge->v[0]);
             at < first_line_from(lines, edge->v[1]); at++) {
            struct line_crossing *at_edge = &lines->crossings[fill[at]++];
            at_edge->loop = edge->loop;
            crossing(edge, lines->height[at], &at_edge->u);
        }
    }
    for (size_t at = 0; at < lines->count; at++)
        qsort(lines->crossings + lines->first[at], lines->first[at + 1] - lines->first[at],
              sizeof *lines->crossings, compare_line_crossings);
    trim->steps += 3 * total;
    return true;
}

/* Goes through the intervals of the region on a line: from crossing to crossing, keeping count of
 * the loops that it is inside. Every loop is left as often as it is entered, so `inside` ends as it
 * began. Adds the intervals to `sum`; or without one keeps the middle that is the nearest to the
 * centroid yet. */
static void visit_line(struct trim *trim, const struct lines *lines, size_t at, bool *inside,
                       struct gathered *sum, double *nearest) {
    const struct surface_axis *axis = &trim->surface->axis[0];
    double lower = axis->outer[0], upper = axis->outer[1], from = lower, v = lines->height[at];
    size_t kept = 0, cut_away = 0;
    for (size_t k = lines->first[at]; k <= lines->first[at + 1]; k++) {
        const struct line_crossing *at_edge =
            k < lines->first[at + 1] ? &lines->crossings[k] : NULL;
        double to = at_edge ? fmin(fmax(at_edge->u, lower), upper) : upper;
        bool own = from < to && cut_away == 0 && (kept > 0 || trim->kept_count == 0);
        if (own && sum) {
            integrate_line(trim->surface, sum, from, to, v, lines->weight[at]);
        } else if (own) {
            struct surface_cursor cursor = {0};
            struct surface_jet jet;
            surface_evaluate(trim->surface, &cursor, (from + to) / 2, v, &jet);
            double distance = vec3_distance(jet.r, trim->centroid);
            if (distance < *nearest) {
                *nearest = distance;
                trim->middle[0] = (from + to) / 2;
                trim->middle[1] = v;
            }
        }
        from = to;
        if (!at_edge)
            break;
        size_t *count = trim->loops[at_edge->loop].reversed ? &kept : &cut_away;
        inside[at_edge->loop] = !inside[at_edge->loop];
        *count += inside[at_edge->loop] ? (size_t)1 : (size_t)-1;
    }
    trim->steps += lines->first[at + 1] - lines->first[at] + 1;
}

static enum status measure_region(struct trim *trim, struct arena *arena) {
    struct quadrature rule = quadrature_make(8);
    struct gathered sum = {.rule = &rule};
    struct lines lines;
    double nearest = HUGE_VAL;
    struct arena_mark mark = arena_mark(arena);
    bool *inside = arena_alloc(arena, trim->loop_count, sizeof *inside);
    if (!inside || !cross_lines(trim, &lines, arena))
        return STATUS_OUT_OF_MEMORY;
    for (size_t at = 0; at < lines.count; at++)
        visit_line(trim, &lines, at, inside, &sum, NULL);
    if (!(sum.area > 0))
        return STATUS_DEGENERATE_SURFACE;
    trim->area = sum.area;
    trim->centroid = vec3_scale(1 / sum.area, sum.moment);
    trim->gyration2 = sum.square / sum.area -
                      vec3_norm2(vec3_sub(trim->centroid, surface_box_middle(trim->surface)));
    for (size_t at = 0; at < lines.count; at++)
        visit_line(trim, &lines, at, inside, NULL, &nearest);
    arena_rewind(arena, mark);
    return STATUS_OK;
}

static void find_region_box(struct trim *trim) {
    surface_domain(trim->surface, trim->low, trim->high);
    if (trim->kept_count == 0)
        return;
    double low[2] = {HUGE_VAL, HUGE_VAL}, high[2] = {-HUGE_VAL, -HUGE_VAL};
    for (size_t e = 0; e < trim->edge_count; e++)
        for (int end = 0; end < 2; end++) {
            const struct edge *edge = &trim->edges[e];
            if (!trim->loops[edge->loop].reversed)
                continue;
            low[0] = fmin(low[0], edge->u[end]);
            high[0] = fmax(high[0], edge->u[end]);
            low[1] = fmin(low[1], edge->v[end]);
            high[1] = fmax(high[1], edge->v[end]);
        }
    for (int k = 0; k < 2; k++) {
        trim->low[k] = fmax(trim->low[k], low[k]);
        trim->high[k] = fmin(trim->high[k], high[k]);
    }
}

size_t trim_loop_count(const struct trim *trim) {
    return trim->loop_count;
}

size_t trim_loop_points(const struct trim *trim, size_t loop, const double (**points)[2]) {
    *points = trim->points + trim->first_point[loop];
    return trim->first_point[loop + 1] - trim->first_point[loop];
}

size_t trim_steps(const struct trim *trim) {
    return trim->steps;
}

/* All loops as edges; curves halved fewer times as long as there are too many. */
static bool flatten_all(struct trim *trim, struct collector *c) {
    size_t points = 0;
    for (size_t k = 0; k < trim->loop_count; k++)
        for (size_t m = 0; m < trim->loops[k].count; m++)
            points += trim->loops[k].curves[m].count;
    c->most = edges_most + edges_per_point * points;
    for (c->halvings = HALVINGS; c->halvings >= 0; c->halvings -= HALVINGS / 4) {
        c->count = c->point_count = 0;
        c->crowded = false;
        for (size_t k = 0; !c->crowded && k < trim->loop_count; k++) {
            const struct trim_loop *loop = &trim->loops[k];
            double first[2] = {0, 0};
            bool good = true;
            c->loop = (uint32_t)k;
            c->begun = false;
            trim->first_point[k] = c->point_count;
            if (loop->count > 0 && loop->curves[0].knots)
                trim_curve_end(&loop->curves[0], 0, first);
            else if (loop->count > 0)
                memcpy(first, loop->curves[0].points[0], sizeof first);
            for (size_t m = 0; good && m < loop->count; m++) {
                const struct trim_curve *curve = &loop->curves[m];
                for (size_t n = 0; !curve->knots && good && n < curve->count; n++)
                    good = add_flat_edge(c, curve->points[n]);
                for (size_t l = (size_t)curve->degree;
                     curve->knots && good && !c->crowded && l < curve->count; l++)
                    good = !(curve->knots[l + 1] > curve->knots[l]) || flatten_span(c, curve, l);
            }
            if (!good || (c->begun && !add_flat_edge(c, first)))
                return false;
        }
        trim->steps += c->count + points;
        if (!c->crowded)
            break;
    }
    return true;
}

enum status trim_make(const struct surface *surface, const struct trim_loop *loops, size_t count,
                      struct arena *arena, struct trim **trim) {
    struct trim *made = arena_alloc(arena, 1, sizeof *made);
    struct trim_loop *copy = arena_alloc(arena, count, sizeof *copy);
    struct collector collector = {0};
    size_t *first_point = arena_alloc(arena, count + 1, sizeof *first_point);
    if (!made || !copy || !first_point)
        return STATUS_OUT_OF_MEMORY;
    memcpy(copy, loops, count * sizeof *copy);
    *made = (struct trim){
        .surface = surface, .loops = copy, .loop_count = count, .first_point = first_point};
    for (int k = 0; k < 2; k++)
        collector.tolerance[k] = flatness * (surface->axis[k].outer[1] - surface->axis[k].outer[0]);
    for (size_t k = 0; k < count; k++)
        made->kept_count += loops[k].reversed;
    /* apart from what is kept: growing arrays leave as much behind them as they hold */
    struct collector *c = &collector;
    c->arena = arena_child(arena);
    if (!c->arena)
        return STATUS_OUT_OF_MEMORY;
    struct arena_mark begin = arena_mark(c->arena);
    if (flatten_all(made, c)) {
        made->edge_count = c->count;
        made->edges = arena_copy(arena, c->edges, c->count, c->count, sizeof *c->edges);
        made->points =
            arena_copy(arena, c->points, c->point_count, c->point_count, sizeof *c->points);
        first_point[count] = c->point_count;
    }
    arena_rewind(c->arena, begin);
    if (!made->edges || !made->points)
        return STATUS_OUT_OF_MEMORY;
    for (size_t k = 0; k < count; k++)
        copy[k].curves = NULL;
    find_region_box(made);
    *trim = made;
    if (!(made->low[0] < made->high[0] && made->low[1] < made->high[1]))
        return STATUS_DEGENERATE_SURFACE;
    enum status status = sort_into_strips(made, arena);
    return status == STATUS_OK ? measure_region(made, arena) : status;
}

void trim_relocate(struct relocation *relocation, void *field) {
    struct trim *trim = relocate_once(relocation, field, 1, sizeof *trim);
    if (!trim)
        return;
    surface_relocate(relocation, &trim->surface);
    relocate(relocation, &trim->loops, trim->loop_count, sizeof *trim->loops);
    relocate(relocation, &trim->edges, trim->edge_count, sizeof *trim->edges);
    const size_t *points =
        relocate(relocation, &trim->first_point, trim->loop_count + 1, sizeof *points);
    relocate(relocation, &trim->points, points ? points[trim->loop_count] : 0,
             sizeof *trim->points);
    const size_t *entries =
        relocate(relocation, &trim->strip_first, trim->strip_count + 1, sizeof *entries);
    relocate(relocation, &trim->strip_edges, entries ? entries[trim->strip_count] : 0,
             sizeof *trim->strip_edges);
}

static void relocate_curve(struct relocation *relocation, struct trim_curve *curve) {
    if (!relocation_first(relocation, curve))
        return;
    relocate(relocation, &curve->points, curve->count, sizeof *curve->points);
    relocate(relocation, &curve->knots, curve->count + (size_t)curve->degree + 1,
             sizeof *curve->knots);
    relocate(relocation, &curve->weights, curve->count, sizeof *curve->weights);
}

void trim_curve_relocate(struct relocation *relocation, void *field) {
    struct trim_curve *curve = relocate(relocation, field, 1, sizeof *curve);
    relocate_curve(relocation, curve);
}

void trim_loops_relocate(struct relocation *relocation, void *field, size_t count) {
    struct trim_loop *loops = relocate_once(relocation, field, count, sizeof *loops);
    for (size_t k = 0; loops && k < count; k++) {
        struct trim_curve *curve =
            relocate(relocation, &loops[k].curves, loops[k].count, sizeof *curve);
        for (size_t c = 0; curve && c < loops[k].count; c++)
            relocate_curve(relocation, &curve[c]);
    }
}
