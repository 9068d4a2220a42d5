/* SPDX-License-Identifier: MIT */
#include "clip.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* Ends of pieces this near, as a share of all, are one; edges are met within it. */
static const double same = 1e-9;

struct piece {
    double from[2], to[2];
    bool used;
};

struct pieces {
    struct piece *list;
    size_t count, capacity;
    double reach; /* `same` of the size */
};

/* Visits the edges of polygons one after the other: `*k` is the number of an edge's first point. */
static bool next_polygon_edge(const struct polygons *p, size_t *k, size_t *first, double a[2],
                              double b[2]) {
    if (*k == p->count)
        return false;
    const struct polygons_point *from = &p->points[*k];
    const struct polygons_point *to = &p->points[from->last ? *first : *k + 1];
    a[0] = from->x;
    a[1] = from->y;
    b[0] = to->x;
    b[1] = to->y;
    if (from->last)
        *first = *k + 1;
    ++*k;
    return true;
}

static int compare_shares(const void *a, const void *b) {
    const double *x = a, *y = b;
    return (*x > *y) - (*x < *y);
}

/* The pieces of the edges of `own` that lie inside `other`; of edges on each other those of the
 * first set alone, which takes its left side for inside. */
static bool add_pieces(struct pieces *pieces, const struct polygons *own,
                       const struct polygons *other, bool first_set) {
    size_t k = 0, first = 0;
    double a[2], b[2], c[2], d[2], *cuts = malloc((other->count + 2) * sizeof *cuts);
    bool good = cuts != NULL;
    while (good && next_polygon_edge(own, &k, &first, a, b)) {
        /* The shares of the edge at which others cross it, sorted, with 0 and 1. */
        size_t at = 0, begin = 0, count = 0;
        double way[2] = {b[0] - a[0], b[1] - a[1]};
        cuts[count++] = 0;
        while (next_polygon_edge(other, &at, &begin, c, d)) {
            double e[2] = {d[0] - c[0], d[1] - c[1]}, det = way[0] * e[1] - way[1] * e[0];
            double t = ((c[0] - a[0]) * e[1] - (c[1] - a[1]) * e[0]) / det;
            double s = ((c[0] - a[0]) * way[1] - (c[1] - a[1]) * way[0]) / det;
            if (t > 0 && t < 1 && s >= 0 && s <= 1)
                cuts[count++] = t;
        }
        cuts[count++] = 1;
        qsort(cuts, count, sizeof *cuts, compare_shares);
        double length = hypot(b[0] - a[0], b[1] - a[1]);
        for (size_t n = 0; good && n + 1 < count && length > 0; n++) {
            double from[2], to[2], nudge = (first_set ? 4 : -4) * pieces->reach / length;
            for (int x = 0; x < 2; x++) {
                from[x] = a[x] + cuts[n] * (b[x] - a[x]);
                to[x] = a[x] + cuts[n + 1] * (b[x] - a[x]);
            }
            double x = (from[0] + to[0]) / 2 - nudge * (b[1] - a[1]);
            double y = (from[1] + to[1]) / 2 + nudge * (b[0] - a[0]);
            if (!polygons_contain(other, x, y) ||
                hypot(to[0] - from[0], to[1] - from[1]) <= pieces->reach)
                continue;
            if (pieces->count == pieces->capacity) {
                size_t wanted = pieces->capacity ? 2 * pieces->capacity : 256;
                void *larger = realloc(pieces->list, wanted * sizeof *pieces->list);
                good = larger != NULL;
                pieces->list = good ? larger : pieces->list;
                pieces->capacity = good ? wanted : pieces->capacity;
            }
            if (good)
                pieces->list[pieces->count++] =
                    (struct piece){{from[0], from[1]}, {to[0], to[1]}, false};
        }
    }
    free(cuts);
    return good;
}

bool clip_make(const struct polygons *a, const struct polygons *b, struct polygons *both) {
    double low[2], high[2];
    polygons_bounds(a, low, high);
    struct pieces pieces = {.reach = same * hypot(high[0] - low[0], high[1] - low[1])};
    bool good = add_pieces(&pieces, a, b, true) && add_pieces(&pieces, b, a, false);
    /* From one piece to the unused one that begins nearest to where it ends, until that is where
     * the first began. */
    for (size_t k = 0; good && k < pieces.count; k++) {
        struct piece *piece = &pieces.list[k];
        const double *begin = piece->from;
        if (piece->used)
            continue;
        while (good && piece) {
            const double *end = piece->to;
            struct piece *next = NULL;
            double distance = HUGE_VAL;
            piece->used = true;
            good = polygons_add(both, piece->from[0], piece->from[1]);
            for (size_t n = 0; n < pieces.count; n++) {
                struct piece *other = &pieces.list[n];
                double own = hypot(other->from[0] - end[0], other->from[1] - end[1]);
                if (!other->used && own < distance) {
                    distance = own;
                    next = other;
                }
            }
            double back = hypot(end[0] - begin[0], end[1] - begin[1]);
            piece = back <= 100 * pieces.reach || distance >= back ? NULL : next;
        }
        polygons_close(both);
    }
    free(pieces.list);
    return good;
}
