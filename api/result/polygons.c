/* SPDX-License-Identifier: MIT */
#include "polygons.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* The elements with room for one more of `size` bytes; NULL without memory, and they stay. */
static void *room_for_next(void *elements, size_t count, size_t *capacity, size_t size) {
    if (count < *capacity)
        return elements;
    size_t wanted = *capacity ? 2 * *capacity : 256;
    void *larger = realloc(elements, wanted * size);
    *capacity = larger ? wanted : *capacity;
    return larger;
}

bool polygons_add(struct polygons *polygons, double x, double y) {
    struct polygons_point *points = room_for_next(polygons->points, polygons->count,
                                                  &polygons->capacity, sizeof *polygons->points);
    if (!points)
        return false;
    polygons->points = points;
    points[polygons->count++] = (struct polygons_point){.x = x, .y = y};
    return true;
}

void polygons_close(struct polygons *polygons) {
    size_t first = polygons->count; /* of the points of this polygon */
    while (first > 0 && !polygons->points[first - 1].last)
        first--;
    if (polygons->count - first < 3)
        polygons->count = first;
    else
        polygons->points[polygons->count - 1].last = true;
}

void polygons_free(struct polygons *polygons) {
    free(polygons->points);
    *polygons = (struct polygons){0};
}

double polygons_loop_area(const struct polygons *polygons, size_t first, size_t *end) {
    double sum = 0;
    for (size_t k = first, last = 0; !last; k++) {
        const struct polygons_point *a = &polygons->points[k];
        const struct polygons_point *b = &polygons->points[a->last ? first : k + 1];
        sum += (a->x * b->y - b->x * a->y) / 2;
        last = a->last;
        *end = k + 1;
    }
    return sum;
}

double polygons_area(const struct polygons *polygons) {
    double sum = 0;
    for (size_t first = 0; first < polygons->count;)
        sum += polygons_loop_area(polygons, first, &first);
    return fabs(sum);
}

bool polygons_contain(const struct polygons *polygons, double x, double y) {
    bool inside = false;
    for (size_t k = 0, first = 0; k < polygons->count; k++) {
        const struct polygons_point *a = &polygons->points[k];
        const struct polygons_point *b = &polygons->points[a->last ? first : k + 1];
        if ((a->y <= y) != (b->y <= y) && a->x + (y - a->y) / (b->y - a->y) * (b->x - a->x) <= x)
            inside = !inside;
        first = a->last ? k + 1 : first;
    }
    return inside;
}

void polygons_bounds(const struct polygons *polygons, double low[2], double high[2]) {
    for (int k = 0; k < 2; k++)
        low[k] = high[k] = 0;
    for (size_t k = 0; k < polygons->count; k++) {
        const double at[2] = {polygons->points[k].x, polygons->points[k].y};
        for (int m = 0; m < 2; m++) {
            low[m] = k == 0 || at[m] < low[m] ? at[m] : low[m];
            high[m] = k == 0 || at[m] > high[m] ? at[m] : high[m];
        }
    }
}

/* The square of the distance of (x, y) from the segment a b. */
static double distance2(const struct polygons_point *a, const struct polygons_point *b, double x,
                        double y) {
    double dx = b->x - a->x, dy = b->y - a->y, length2 = dx * dx + dy * dy;
    double share = length2 > 0 ? ((x - a->x) * dx + (y - a->y) * dy) / length2 : 0;
    share = share < 0 ? 0 : share > 1 ? 1 : share;
    dx = x - a->x - share * dx;
    dy = y - a->y - share * dy;
    return dx * dx + dy * dy;
}

/* ---- fewer points ---- */

enum { LONGEST_RUN = 256 };

/* Whether the points between two are within the tolerance of the line between these. */
static bool is_straight_run(const struct polygons_point *p, size_t from, size_t to,
                            double tolerance) {
    for (size_t k = from + 1; k < to; k++)
        if (distance2(&p[from], &p[to], p[k].x, p[k].y) > tolerance * tolerance)
            return false;
    return true;
}

void polygons_simplify(struct polygons *polygons, double tolerance) {
    struct polygons_point *p = polygons->points;
    size_t kept = 0;
    for (size_t first = 0, end; first < polygons->count; first = end) {
        size_t begin = kept;
        for (end = first + 1; !p[end - 1].last;)
            end++;
        for (size_t at = first; at < end;) {
            size_t next = at + 1;
            while (next + 1 < end && next - at < LONGEST_RUN && p[next].part == p[at].part &&
                   is_straight_run(p, at, next + 1, tolerance))
                next++;
            p[kept++] = (struct polygons_point){p[at].x, p[at].y, p[at].part, false};
            at = next;
        }
        if (kept - begin < 3)
            kept = begin;
        else
            p[kept - 1].last = true;
    }
    polygons->count = kept;
}

/* ---- a grid of segments ---- */

enum { GRID_MOST = 256 };

/* Segments by the squares of a grid that their boxes meet. */
struct grid {
    const struct polygons *of;
    double low[2], side;
    int size[2];
    size_t *first; /* of each square, and one more */
    size_t *entries;
};

static int square_of(const struct grid *grid, int k, double x) {
    double at = floor((x - grid->low[k]) / grid->side);
    return at < 0 ? 0 : at >= grid->size[k] ? grid->size[k] - 1 : (int)at;
}

/* The squares that a box meets: from[k] to to[k]. */
static void squares_of(const struct grid *grid, const double low[2], const double high[2],
                       int from[2], int to[2]) {
    for (int k = 0; k < 2; k++) {
        from[k] = square_of(grid, k, low[k]);
        to[k] = square_of(grid, k, high[k]);
    }
}

/* Segments numbered by their first points; `ends` has the second ones. */
static bool grid_make(struct grid *grid, const struct polygons *of, const size_t *ends,
                      double least_side) {
    double high[2];
    *grid = (struct grid){.of = of};
    polygons_bounds(of, grid->low, high);
    grid->side = fmax(least_side, fmax(high[0] - grid->low[0], high[1] - grid->low[1]) / GRID_MOST);
    for (int k = 0; k < 2; k++)
        grid->size[k] = (int)((high[k] - grid->low[k]) / grid->side) + 1;
    size_t squares = (size_t)grid->size[0] * (size_t)grid->size[1], total = 0;
    grid->first = calloc(squares + 2, sizeof *grid->first);
    for (int pass = 0; pass < 2 && grid->first; pass++) {
        for (size_t k = 0; k < of->count; k++) {
            const struct polygons_point *p = &of->points[k], *q = &of->points[ends[k]];
            const double least[2] = {fmin(p->x, q->x), fmin(p->y, q->y)};
            const double most[2] = {fmax(p->x, q->x), fmax(p->y, q->y)};
            int from[2], to[2];
            squares_of(grid, least, most, from, to);
            for (int y = from[1]; y <= to[1]; y++)
                for (int x = from[0]; x <= to[0]; x++) {
                    size_t square = (size_t)y * (size_t)grid->size[0] + (size_t)x;
                    if (pass == 0)
                        grid->first[square + 2]++;
                    else
                        grid->entries[grid->first[square + 1]++] = k;
                }
        }
        for (size_t s = 0; s < squares && pass == 0; s++)
            total = grid->first[s + 2] += grid->first[s + 1];
        if (pass == 0)
            grid->entries = malloc((total + 1) * sizeof *grid->entries);
        if (!grid->entries)
            return false;
    }
    return grid->first != NULL;
}

static void grid_free(struct grid *grid) {
    free(grid->first);
    free(grid->entries);
}

static size_t *segment_ends(const struct polygons *polygons) {
    size_t *ends = malloc((polygons->count + 1) * sizeof *ends);
    for (size_t k = 0, first = 0; ends && k < polygons->count; k++) {
        ends[k] = polygons->points[k].last ? first : k + 1;
        first = polygons->points[k].last ? k + 1 : first;
    }
    return ends;
}

/* ---- the parallel ---- */

/* Arcs are cut into chords of this angle, the sine of 3.6 degrees or so: off by 2e-3 / 4 of their
 * radius; and what is nearer than the distance by more is none of the parallel. */
static const double arc_step = 0.0625, near_share = 1e-3;

/* Adds a point from which on the boundary is of a part. */
static bool add_of_part(struct polygons *to, double x, double y, int part) {
    bool good = polygons_add(to, x, y);
    if (good)
        to->points[to->count - 1].part = part;
    return good;
}

/* The corner at (at->x, at->y) of the moved segments, which are off it to a and b, unit vectors,
 * before and after it. Where it turns left, an arc. Where it turns right, the point where the
 * segments meet, or, when the `shorter` half of them is too short for that, the ends of both. */
static bool widen_corner(struct polygons *to, const struct polygons_point *at, double distance,
                         const double a[2], const double b[2], double shorter) {
    double cosine = a[0] * b[0] + a[1] * b[1], sine = a[0] * b[1] - a[1] * b[0];
    double miter = distance / (1 + cosine);
    bool left = sine > 0;
    int part = at->part;
    if (!left && 1 + cosine > 1e-9 && miter * fabs(sine) < shorter)
        return add_of_part(to, at->x + miter * (a[0] + b[0]), at->y + miter * (a[1] + b[1]), part);
    double angle = left ? atan2(sine, cosine) : 0;
    int steps = left ? (int)ceil(fabs(angle) / arc_step) : 0;
    bool good = add_of_part(to, at->x + distance * a[0], at->y + distance * a[1], part);
    if (good && !left)
        good = add_of_part(to, at->x, at->y, part);
    for (int k = 1; k < steps && good; k++) {
        double turn = angle * k / steps, c = cos(turn), s = sin(turn);
        good = add_of_part(to, at->x + distance * (c * a[0] - s * a[1]),
                           at->y + distance * (s * a[0] + c * a[1]), part);
    }
    return good && add_of_part(to, at->x + distance * b[0], at->y + distance * b[1], part);
}

/* The direction to the right of the segment from a to b; false when it has no length. */
static bool right_direction(const struct polygons_point *a, const struct polygons_point *b,
                            double right[2]) {
    double dx = b->x - a->x, dy = b->y - a->y, length = sqrt(dx * dx + dy * dy);
    right[0] = dy / length;
    right[1] = -dx / length;
    return length > 0;
}

/* Each segment moved to its right, with arcs round the corners that turn left. Where they turn
 * right by too much it goes by way of the corner, and crosses itself. Between two parts it steps to
 * the lesser distance, and round the corner by that. */
static bool make_raw(const struct polygons *of, const double *distance, struct polygons *raw) {
    for (size_t first = 0, end; first < of->count; first = end) {
        const struct polygons_point *p = of->points;
        double before[2], after[2];
        for (end = first + 1; !p[end - 1].last;)
            end++;
        size_t last = end - 1;
        while (last > first && !right_direction(&p[last], &p[first], before))
            last--;
        double length = hypot(p[first].x - p[last].x, p[first].y - p[last].y);
        double far = distance[p[last].part];
        for (size_t k = first; k <= last; k++) {
            const struct polygons_point *own = &p[k], *next = &p[k == last ? first : k + 1];
            if (!right_direction(own, next, after))
                continue;
            double own_length = hypot(next->x - own->x, next->y - own->y);
            double shorter = fmin(length, own_length) / 2;
            double to = distance[own->part], least = fmin(far, to);
            bool good = far <= least || add_of_part(raw, own->x + far * before[0],
                                                    own->y + far * before[1], own->part);
            good = good && widen_corner(raw, own, least, before, after, shorter) &&
                   (to <= least ||
                    add_of_part(raw, own->x + to * after[0], own->y + to * after[1], own->part));
            if (!good)
                return false;
            far = to;
            length = own_length;
            memcpy(before, after, sizeof before);
        }
        polygons_close(raw);
    }
    return true;
}

/* Where two segments cross: at which share of the one that begins at `segment`. */
struct cut {
    size_t segment, node;
    double share;
};

struct cuts {
    struct cut *all;
    size_t count, capacity, nodes;
};

static bool add_crossing_of(struct cuts *cuts, size_t segment, double share) {
    struct cut *all = room_for_next(cuts->all, cuts->count, &cuts->capacity, sizeof *cuts->all);
    if (!all)
        return false;
    cuts->all = all;
    all[cuts->count++] = (struct cut){segment, cuts->nodes, share};
    return true;
}

/* Whether the segments cross within both, and at which shares. */
static bool cross(const struct polygons_point *a, const struct polygons_point *b,
                  const struct polygons_point *c, const struct polygons_point *d, double share[2]) {
    double ux = b->x - a->x, uy = b->y - a->y, vx = d->x - c->x, vy = d->y - c->y;
    double determinant = ux * vy - uy * vx, wx = c->x - a->x, wy = c->y - a->y;
    if (determinant == 0)
        return false;
    share[0] = (wx * vy - wy * vx) / determinant;
    share[1] = (wx * uy - wy * ux) / determinant;
    return share[0] > 0 && share[0] < 1 && share[1] > 0 && share[1] < 1;
}

/* All crossings, each found in the square that it lies in. */
static bool find_cuts(const struct grid *grid, const size_t *ends, struct cuts *cuts) {
    const struct polygons_point *p = grid->of->points;
    for (int y = 0; y < grid->size[1]; y++)
        for (int x = 0; x < grid->size[0]; x++) {
            size_t square = (size_t)y * (size_t)grid->size[0] + (size_t)x;
            for (size_t m = grid->first[square]; m < grid->first[square + 1]; m++)
                for (size_t n = m + 1; n < grid->first[square + 1]; n++) {
                    size_t a = grid->entries[m], c = grid->entries[n];
                    double share[2];
                    if (!cross(&p[a], &p[ends[a]], &p[c], &p[ends[c]], share))
                        continue;
                    double at[2] = {p[a].x + share[0] * (p[ends[a]].x - p[a].x),
                                    p[a].y + share[0] * (p[ends[a]].y - p[a].y)};
                    if (square_of(grid, 0, at[0]) != x || square_of(grid, 1, at[1]) != y)
                        continue;
                    if (!add_crossing_of(cuts, a, share[0]) || !add_crossing_of(cuts, c, share[1]))
                        return false;
                    cuts->nodes++;
                }
        }
    return true;
}

static int compare_raw_crossings(const void *a, const void *b) {
    const struct cut *x = a, *y = b;
    if (x->segment != y->segment)
        return x->segment < y->segment ? -1 : 1;
    return (x->share > y->share) - (x->share < y->share);
}

/* A part of the raw parallel from one crossing to another, or all of a polygon. */
struct chain {
    size_t first, count; /* of the points gathered */
    size_t begin, end;   /* nodes; NO_NODE: it is closed */
    double length;
    bool used;
};

static const size_t NO_NODE = (size_t)-1;

struct chains {
    struct polygons points; /* of all chains, one after the other */
    struct chain *all;
    size_t count, capacity;
    bool failed;
};

static struct chain *open_chain(struct chains *chains, size_t begin) {
    struct chain *all =
        room_for_next(chains->all, chains->count, &chains->capacity, sizeof *chains->all);
    chains->failed = chains->failed || !all;
    if (!all)
        return NULL;
    chains->all = all;
    all[chains->count] =
        (struct chain){.first = chains->points.count, .begin = begin, .end = NO_NODE};
    return &all[chains->count++];
}

static void chain_point(struct chains *chains, double x, double y, int part) {
    chains->failed = chains->failed || !add_of_part(&chains->points, x, y, part);
    if (chains->count && !chains->failed)
        chains->all[chains->count - 1].count++;
}

/* The points first .. end - 1 of the raw parallel, a polygon. */
struct loop {
    const struct polygons_point *points;
    size_t length;
};

static void add_crossing(struct chains *chains, const struct loop *loop, size_t first,
                         const struct cut *cut) {
    size_t segment = cut->segment - first;
    const struct polygons_point *a = &loop->points[segment];
    const struct polygons_point *b = &loop->points[(segment + 1) % loop->length];
    chain_point(chains, a->x + cut->share * (b->x - a->x), a->y + cut->share * (b->y - a->y),
                a->part);
}

/* The polygons that are made wider, and by how much. */
struct source {
    struct grid grid;
    size_t *ends, *before; /* of each segment its second point; of each point that before it */
    const double *distance;
    double most; /* of the distances */
};

static bool source_make(struct source *source, const struct polygons *of, const double *distance) {
    *source = (struct source){.ends = segment_ends(of), .distance = distance};
    source->before = malloc((of->count + 1) * sizeof *source->before);
    for (size_t k = 0; source->ends && source->before && k < of->count; k++) {
        source->before[source->ends[k]] = k;
        source->most = fmax(source->most, distance[of->points[k].part]);
    }
    return source->ends && source->before &&
           grid_make(&source->grid, of, source->ends, source->most);
}

static void free_polygon_source(struct source *source) {
    grid_free(&source->grid);
    free(source->ends);
    free(source->before);
}

/* Whether (x, y), of the parallel of an edge that is `own` away, is nearer to segment a than that
 * one's distance. Beyond an end it is the lesser one of both parts that meet there; and an edge of
 * another part may come near from within, as a lip does at a sharp corner. */
static bool lies_in_polygon(const struct source *source, size_t a, double own, double x, double y) {
    const struct polygons_point *points = source->grid.of->points;
    const struct polygons_point *p = &points[a], *q = &points[source->ends[a]];
    double dx = q->x - p->x, dy = q->y - p->y, wx = x - p->x, wy = y - p->y;
    double length = hypot(dx, dy), far = source->distance[p->part], end = near_share * far;
    double along = length > 0 ? (wx * dx + wy * dy) / length : 0;
    if (own < far && dx * wy - dy * wx >= 0)
        return false;
    if (along <= end)
        far = fmin(far, source->distance[points[source->before[a]].part]);
    if (along >= length - end)
        far = fmin(far, source->distance[q->part]);
    double near = (1 - near_share) * far;
    return distance2(p, q, x, y) < near * near;
}

/* Judges a chain by the middle of its longest piece: whether no part of the source is nearer to it
 * than its distance. */
static bool is_parallel(const struct chains *chains, const struct chain *chain,
                        const struct source *source) {
    const struct polygons_point *p = chains->points.points + chain->first;
    const struct grid *grid = &source->grid;
    size_t at = 0, pieces = chain->begin == NO_NODE ? chain->count : chain->count - 1;
    double most = -1, near = source->most;
    for (size_t k = 0; k < pieces; k++) {
        const struct polygons_point *q = &p[(k + 1) % chain->count];
        double dx = q->x - p[k].x, dy = q->y - p[k].y, length = dx * dx + dy * dy;
        at = length > most ? k : at;
        most = fmax(most, length);
    }
    if (pieces == 0)
        return false;
    const struct polygons_point *q = &p[(at + 1) % chain->count];
    const double x = (p[at].x + q->x) / 2, y = (p[at].y + q->y) / 2;
    const double low[2] = {x - near, y - near}, high[2] = {x + near, y + near};
    double own = source->distance[p[at].part];
    int from[2], to[2];
    squares_of(grid, low, high, from, to);
    for (int sy = from[1]; sy <= to[1]; sy++)
        for (int sx = from[0]; sx <= to[0]; sx++) {
            size_t square = (size_t)sy * (size_t)grid->size[0] + (size_t)sx;
            for (size_t m = grid->first[square]; m < grid->first[square + 1]; m++)
                if (lies_in_polygon(source, grid->entries[m], own, x, y))
                    return false;
        }
    return true;
}

static int compare_lengths(const void *a, const void *b) {
    const struct chain *x = a, *y = b;
    if (x->length != y->length)
        return x->length > y->length ? -1 : 1;
    return (x->first > y->first) - (x->first < y->first);
}

/* Joins the chains that are left to polygons. */
static bool join_parallels(struct chains *chains, struct polygons *wider, double sliver) {
    for (size_t k = 0; k < chains->count; k++) {
        struct chain *chain = &chains->all[k];
        size_t begin = chain->begin, first = wider->count;
        while (chain && !chain->used) {
            const struct polygons_point *p = chains->points.points + chain->first;
            size_t count = chain->begin == NO_NODE ? chain->count : chain->count - 1;
            chain->used = true;
            for (size_t m = 0; m < count; m++)
                if (!polygons_add(wider, p[m].x, p[m].y))
                    return false;
            bool ends = chain->end == NO_NODE || chain->end == begin;
            /* On with the longest chain that goes on from there, and is not used. */
            size_t n = 0;
            while (!ends && n < chains->count &&
                   (chains->all[n].used || chains->all[n].begin != chain->end))
                n++;
            if (!ends && n == chains->count)
                wider->count = first; /* a sliver that rounding left open */
            chain = ends || n == chains->count ? NULL : &chains->all[n];
        }
        /* Closes the polygon, unless its area is what rounding leaves. */
        const struct polygons_point *p = wider->points;
        double area = 0;
        for (size_t m = first; m < wider->count; m++) {
            const struct polygons_point *next = &p[m + 1 == wider->count ? first : m + 1];
            area += (p[m].x * next->y - next->x * p[m].y) / 2;
        }
        if (fabs(area) < sliver)
            wider->count = first;
        else
            polygons_close(wider);
    }
    return true;
}

/* Cuts each polygon of the raw parallel into chains, from each of its cuts to the next; one without
 * any is a chain by itself. */
static bool cut_polygons(const struct polygons *raw, const struct cuts *cuts,
                         struct chains *chains) {
    for (size_t first = 0, end, at = 0; first < raw->count; first = end) {
        size_t from = at;
        for (end = first + 1; !raw->points[end - 1].last;)
            end++;
        while (at < cuts->count && cuts->all[at].segment < end)
            at++;
        struct loop loop = {raw->points + first, end - first};
        size_t count = at - from;
        if (count == 0 && open_chain(chains, NO_NODE))
            for (size_t k = 0; k < loop.length; k++)
                chain_point(chains, loop.points[k].x, loop.points[k].y, loop.points[k].part);
        for (size_t c = 0; c < count && !chains->failed; c++) {
            const struct cut *own = &cuts->all[from + c];
            const struct cut *next = &cuts->all[from + (c + 1) % count];
            size_t steps = (next->segment + loop.length - own->segment) % loop.length;
            steps = steps == 0 && c + 1 == count ? loop.length : steps;
            struct chain *chain = open_chain(chains, own->node);
            if (!chain)
                return false;
            chain->end = next->node;
            add_crossing(chains, &loop, first, own);
            for (size_t k = 1; k <= steps; k++) {
                size_t place = (own->segment - first + k) % loop.length;
                chain_point(chains, loop.points[place].x, loop.points[place].y,
                            loop.points[place].part);
            }
            add_crossing(chains, &loop, first, next);
        }
    }
    return !chains->failed;
}

bool polygons_widen(const struct polygons *polygons, const double *distance,
                    struct polygons *wider) {
    struct polygons raw = {0};
    struct source source = {0};
    struct grid grid = {0};
    struct cuts cuts = {0};
    struct chains chains = {0};
    size_t *raw_ends = NULL;
    bool good = source_make(&source, polygons, distance) && make_raw(polygons, distance, &raw) &&
                (raw_ends = segment_ends(&raw)) && grid_make(&grid, &raw, raw_ends, 0) &&
                find_cuts(&grid, raw_ends, &cuts);
    if (good && cuts.count)
        qsort(cuts.all, cuts.count, sizeof *cuts.all, compare_raw_crossings);
    good = good && cut_polygons(&raw, &cuts, &chains);
    for (size_t k = 0; good && k < chains.count; k++)
        chains.all[k].used = !is_parallel(&chains, &chains.all[k], &source);
    /* The longest first. Where three pieces of the raw parallel all but meet, the sides of the
     * triangle between them are parallels to within rounding and arcs, too, but lead nowhere. */
    for (size_t k = 0; good && k < chains.count; k++) {
        const struct polygons_point *p = chains.points.points + chains.all[k].first;
        double length = 0;
        for (size_t m = 1; m < chains.all[k].count; m++)
            length += hypot(p[m].x - p[m - 1].x, p[m].y - p[m - 1].y);
        chains.all[k].length = length;
    }
    if (good && chains.count)
        qsort(chains.all, chains.count, sizeof *chains.all, compare_lengths);
    good = good && join_parallels(&chains, wider, near_share * source.most * source.most);
    polygons_free(&raw);
    polygons_free(&chains.points);
    free(chains.all);
    free(cuts.all);
    free_polygon_source(&source);
    grid_free(&grid);
    free(raw_ends);
    return good;
}
