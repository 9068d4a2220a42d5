/* SPDX-License-Identifier: MIT */
#include "region.h"

#include <string.h>

enum { STRIPS_MAX = 4096 };

/* Steps along a loop, in spacings; and how far apart the places of neighbouring points may be: so
 * often their distance and that to the cloth, and so many spacings more. */
static const double step = 0.5, stretch = 4, slack = 2;

void region_coordinates(const struct facets *facets, const struct facets_point *place,
                        double pq[2]) {
    static const double corner[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    const int32_t *cell = facets->source.places[place->cell];
    for (int k = 0; k < 2; k++)
        pq[k] = cell[k] + place->weight[0] * 0.5 + place->weight[1] * corner[place->side & 3][k] +
                place->weight[2] * corner[(place->side + 1) & 3][k];
}

/* ---- following loops ---- */

struct walk {
    struct facets_search cloth;
    const double *spacing;
    double least; /* the smaller spacing */
    double (*points)[2];
    size_t count;
    double away; /* the largest distance of a point over the cloth */
    struct facets_point place;
};

static size_t steps_of(const struct walk *walk, struct vec3 a, struct vec3 b) {
    return 1 + (size_t)fmin(vec3_distance(a, b) / (step * walk->least), 1e6);
}

/* How far (p, q) has moved on the cloth. */
static double moved(const struct walk *walk, const double a[2], const double b[2]) {
    double dp = (b[0] - a[0]) * walk->spacing[0], dq = (b[1] - a[1]) * walk->spacing[1];
    return sqrt(dp * dp + dq * dq);
}

/* Adds the points of a loop; false where it cannot be followed, with the place. */
static bool follow(struct walk *walk, const struct laminate_loop *loop, struct vec3 *at) {
    size_t begin = walk->count;
    double away = 0, first_away = 0;
    double largest = fmax(walk->spacing[0], walk->spacing[1]);
    for (size_t k = 0; k < loop->count; k++) {
        struct vec3 a = loop->points[k], b = loop->points[(k + 1) % loop->count];
        size_t pieces = steps_of(walk, a, b);
        double length = vec3_distance(a, b) / (double)pieces;
        for (size_t n = 0; n < pieces; n++) {
            double share = (double)n / (double)pieces, *pq = walk->points[walk->count];
            *at = vec3_axpy(share, vec3_sub(b, a), a);
            facets_nearest(&walk->cloth, *at, &walk->place);
            region_coordinates(walk->cloth.facets, &walk->place, pq);
            double reach = length + away + walk->place.distance;
            away = walk->place.distance;
            walk->away = walk->place.outside ? walk->away : fmax(walk->away, away);
            first_away = walk->count == begin ? away : first_away;
            if (walk->count++ > begin &&
                moved(walk, pq - 2, pq) > stretch * reach + slack * largest)
                return false;
        }
    }
    double reach = step * largest + away + first_away;
    return moved(walk, walk->points[walk->count - 1], walk->points[begin]) <=
           stretch * reach + slack * largest;
}

/* ---- strips ---- */

static size_t strip_of(const struct region *region, double q) {
    double strip = (q - region->low[1]) / region->height;
    return strip > 0 ? strip < (double)region->strip_count ? (size_t)strip : region->strip_count - 1
                     : 0;
}

/* The strips that an edge is in. */
static void span_of(const struct region *region, size_t edge, size_t *low, size_t *high) {
    double a = region->points[edge][1], b = region->points[region->next[edge]][1];
    *low = strip_of(region, fmin(a, b));
    *high = strip_of(region, fmax(a, b));
}

static enum status make_strips(struct region *region, size_t count, struct arena *arena) {
    size_t *first, low, high;
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
        span_of(region, k, &low, &high);
        for (size_t s = low; s <= high; s++)
            first[s + 2]++;
    }
    for (size_t s = 0; s < region->strip_count; s++)
        first[s + 2] += first[s + 1];
    uint32_t *edges = arena_alloc(arena, first[region->strip_count + 1], sizeof *edges);
    if (!edges)
        return STATUS_OUT_OF_MEMORY;
    for (size_t k = 0; k < count; k++) {
        span_of(region, k, &low, &high);
        for (size_t s = low; s <= high; s++)
            edges[first[s + 1]++] = (uint32_t)k;
    }
    region->strip_first = first;
    region->strip_edges = edges;
    return STATUS_OK;
}

/* The region of `total` points in `loops` loops, from first[k] on each. */
static enum status finish(struct region *region, const double (*points)[2], const size_t *first,
                          size_t loops, struct arena *arena) {
    size_t total = first[loops];
    uint32_t *next = arena_take(arena, total, sizeof *next);
    if (!next)
        return STATUS_OUT_OF_MEMORY;
    *region = (struct region){.points = points,
                              .first = first,
                              .loop_count = loops,
                              .next = next,
                              .low = {HUGE_VAL, HUGE_VAL},
                              .high = {-HUGE_VAL, -HUGE_VAL}};
    for (size_t n = 0; n < loops; n++)
        for (size_t k = first[n]; k < first[n + 1]; k++)
            next[k] = (uint32_t)(k + 1 < first[n + 1] ? k + 1 : first[n]);
    for (size_t k = 0; k < total; k++)
        for (int x = 0; x < 2; x++) {
            region->low[x] = fmin(region->low[x], points[k][x]);
            region->high[x] = fmax(region->high[x], points[k][x]);
        }
    return make_strips(region, total, arena);
}

enum status region_make(const struct laminate_boundary *boundary, const struct facets *facets,
                        const double spacing[2], struct arena *arena, struct region *region,
                        struct vec3 *at) {
    struct walk walk = {.cloth = facets_search_begin(facets),
                        .spacing = spacing,
                        .least = fmin(spacing[0], spacing[1])};
    size_t total = 0, *first = arena_alloc(arena, boundary->count + 1, sizeof *first);
    for (size_t n = 0; n < boundary->count; n++)
        for (size_t k = 0; k < boundary->loops[n].count; k++)
            total += steps_of(&walk, boundary->loops[n].points[k],
                              boundary->loops[n].points[(k + 1) % boundary->loops[n].count]);
    walk.points = arena_take(arena, total, sizeof *walk.points);
    if (!first || !walk.points)
        return STATUS_OUT_OF_MEMORY;
    for (size_t n = 0; n < boundary->count; n++) {
        first[n] = walk.count;
        if (!follow(&walk, &boundary->loops[n], at))
            return STATUS_INVALID;
    }
    first[boundary->count] = walk.count;
    enum status status =
        finish(region, (const double(*)[2])walk.points, first, boundary->count, arena);
    region->away = walk.away;
    return status;
}

/* The parity of the edges to the left; the lower end of an edge belongs to it. */
bool region_contains(const struct region *region, const double pq[2]) {
    bool inside = false;
    for (int k = 0; k < 2; k++)
        if (!(pq[k] >= region->low[k] && pq[k] <= region->high[k]))
            return false;
    size_t strip = strip_of(region, pq[1]);
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
