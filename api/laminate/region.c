/* SPDX-License-Identifier: MIT */
#include "region.h"

#include "api/map/net.h"

#include <string.h>

enum { STRIPS_MAX = 4096 };

/* Steps along a loop, in spacings; and how far apart the places of neighbouring points may be: so
 * often their distance and that to the cloth, and so many spacings more. */
static const double step = 0.5, stretch = 4, slack = 2;

/* ---- following loops ---- */

struct loop_trace {
    struct facets_search cloth;
    const double *spacing;
    double least; /* the smaller spacing */
    double (*points)[2];
    size_t count;
    double away; /* the largest distance of a point over the cloth */
    struct facets_point point;
};

static size_t loop_steps(const struct loop_trace *trace, struct vec3 a, struct vec3 b) {
    return 1 + (size_t)fmin(vec3_distance(a, b) / (step * trace->least), 1e6);
}

/* How far (p, q) has moved on the cloth. */
static double moved(const struct loop_trace *trace, const double a[2], const double b[2]) {
    double dp = (b[0] - a[0]) * trace->spacing[0], dq = (b[1] - a[1]) * trace->spacing[1];
    return sqrt(dp * dp + dq * dq);
}

/* Adds the points of a loop; false where it cannot be followed, with the place. */
static bool trace_loop(struct loop_trace *trace, const struct laminate_loop *loop,
                       struct vec3 *at) {
    size_t begin = trace->count;
    double away = 0, first_away = 0;
    double largest = fmax(trace->spacing[0], trace->spacing[1]);
    for (size_t k = 0; k < loop->count; k++) {
        struct vec3 a = loop->points[k], b = loop->points[(k + 1) % loop->count];
        size_t pieces = loop_steps(trace, a, b);
        double length = vec3_distance(a, b) / (double)pieces;
        for (size_t n = 0; n < pieces; n++) {
            double share = (double)n / (double)pieces, *pq = trace->points[trace->count];
            *at = vec3_axpy(share, vec3_sub(b, a), a);
            facets_nearest(&trace->cloth, *at, &trace->point);
            map_net_coordinates(trace->cloth.facets, &trace->point, pq);
            double reach = length + away + trace->point.distance;
            away = trace->point.distance;
            trace->away = trace->point.outside ? trace->away : fmax(trace->away, away);
            first_away = trace->count == begin ? away : first_away;
            if (trace->count++ > begin &&
                moved(trace, pq - 2, pq) > stretch * reach + slack * largest)
                return false;
        }
    }
    double reach = step * largest + away + first_away;
    return moved(trace, trace->points[trace->count - 1], trace->points[begin]) <=
           stretch * reach + slack * largest;
}

/* ---- strips ---- */

static size_t boundary_strip(const struct region *region, double q) {
    double strip = (q - region->low[1]) / region->height;
    return strip > 0 ? strip < (double)region->strip_count ? (size_t)strip : region->strip_count - 1
                     : 0;
}

/* The strips that an edge is in. */
static void boundary_strips(const struct region *region, size_t edge, size_t *low, size_t *high) {
    double a = region->points[edge][1], b = region->points[region->next[edge]][1];
    *low = boundary_strip(region, fmin(a, b));
    *high = boundary_strip(region, fmax(a, b));
}

static enum status sort_boundary(struct region *region, size_t count, struct arena *arena) {
    size_t *first, low, high;
    for (int x = 0; x < 2; x++) {
        region->low[x] = HUGE_VAL;
        region->high[x] = -HUGE_VAL;
        for (size_t p = 0; p < count; p++) {
            region->low[x] = fmin(region->low[x], region->points[p][x]);
            region->high[x] = fmax(region->high[x], region->points[p][x]);
        }
    }
    region->strip_count = count / 4 + 1 < STRIPS_MAX ? count / 4 + 1 : STRIPS_MAX;
    region->height = (region->high[1] - region->low[1]) / (double)region->strip_count;
    if (!(region->height > 0))
        region->strip_count = 1;
    if (!(region->height > 0))
        region->height = 1;
    first = arena_alloc(arena, region->strip_count + 2, sizeof *first);
    if (!first)
        return STATUS_OUT_OF_MEMORY;
    for (size_t k = 0; k < count; k++) {
        boundary_strips(region, k, &low, &high);
        for (size_t s = low; s <= high; s++)
            first[s + 2]++;
    }
    for (size_t s = 0; s < region->strip_count; s++)
        first[s + 2] += first[s + 1];
    uint32_t *edges = arena_alloc(arena, first[region->strip_count + 1], sizeof *edges);
    if (!edges)
        return STATUS_OUT_OF_MEMORY;
    for (size_t k = 0; k < count; k++) {
        boundary_strips(region, k, &low, &high);
        for (size_t s = low; s <= high; s++)
            edges[first[s + 1]++] = (uint32_t)k;
    }
    region->strip_first = first;
    region->strip_edges = edges;
    return STATUS_OK;
}

enum api_problem_id region_make(const struct laminate *laminate, size_t k,
                                const struct facets *facets, const double spacing[2],
                                struct arena *arena, struct region *region,
                                struct api_problem *problem) {
    const struct laminate_boundary *boundary = &laminate->plies[k].boundary;
    struct loop_trace trace = {.cloth = facets_search_begin(facets),
                               .spacing = spacing,
                               .least = fmin(spacing[0], spacing[1])};
    size_t total = 0, *first = arena_alloc(arena, boundary->count + 1, sizeof *first);
    struct vec3 at;
    for (size_t n = 0; n < boundary->count; n++)
        for (size_t p = 0; p < boundary->loops[n].count; p++)
            total += loop_steps(&trace, boundary->loops[n].points[p],
                                boundary->loops[n].points[(p + 1) % boundary->loops[n].count]);
    trace.points = arena_take(arena, total, sizeof *trace.points);
    uint32_t *next = arena_take(arena, total, sizeof *next);
    if (!first || !trace.points || !next)
        return api_problem_no_memory(problem, "the laminate");
    *region = (struct region){.points = (const double(*)[2])trace.points,
                              .first = first,
                              .loop_count = boundary->count,
                              .next = next};
    for (size_t n = 0; n < boundary->count; n++) {
        first[n] = trace.count;
        if (!trace_loop(&trace, &boundary->loops[n], &at))
            return api_problem_set(
                problem, API_INVALID_REQUEST,
                "the boundary of ply %zu (\"%s\") cannot be followed on its cloth near (%.6g, "
                "%.6g, %.6g): the cloth ends there, or the boundary is too far from it; start the "
                "ply inside its boundary, or give more points of it",
                k + 1, laminate->plies[k].name, at.x, at.y, at.z);
        for (size_t p = first[n]; p < trace.count; p++)
            next[p] = (uint32_t)(p + 1 < trace.count ? p + 1 : first[n]);
    }
    first[boundary->count] = trace.count;
    region->away = trace.away;
    return sort_boundary(region, trace.count, arena) == STATUS_OK
               ? API_OK
               : api_problem_no_memory(problem, "the laminate");
}

bool region_of_polygons(const struct polygons *polygons, const double spacing[2],
                        struct arena *arena, struct region *region) {
    size_t count = polygons->count, begin = 0;
    double(*points)[2] = arena_take(arena, count, sizeof *points);
    size_t *first = arena_alloc(arena, count + 1, sizeof *first);
    uint32_t *next = arena_take(arena, count, sizeof *next);
    if (!points || !first || !next)
        return false;
    *region = (struct region){.points = (const double(*)[2])points, .first = first, .next = next};
    for (size_t k = 0; k < count; k++) {
        const struct polygons_point *own = &polygons->points[k];
        points[k][0] = own->x / spacing[0];
        points[k][1] = own->y / spacing[1];
        next[k] = (uint32_t)(own->last ? begin : k + 1);
        if (own->last)
            first[++region->loop_count] = begin = k + 1;
    }
    return sort_boundary(region, count, arena) == STATUS_OK;
}

/* The parity of the edges to the left; the lower end of an edge belongs to it. */
bool region_contains(const struct region *region, const double pq[2]) {
    bool inside = false;
    for (int k = 0; k < 2; k++)
        if (!(pq[k] >= region->low[k] && pq[k] <= region->high[k]))
            return false;
    size_t strip = boundary_strip(region, pq[1]);
    for (size_t k = region->strip_first[strip]; k < region->strip_first[strip + 1]; k++) {
        const double *a = region->points[region->strip_edges[k]];
        const double *b = region->points[region->next[region->strip_edges[k]]];
        if ((a[1] <= pq[1]) == (b[1] <= pq[1]))
            continue;
        double p = a[0] + (pq[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]);
        inside = inside != (p <= pq[0]);
    }
    return inside;
}
