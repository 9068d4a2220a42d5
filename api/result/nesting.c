/* SPDX-License-Identifier: MIT */
#include "nesting.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum {
    BANDS = 240,      /* across the roll */
    BANDS_LEAST = 40, /* of many shapes */
    EXCHANGES = 400
};

/* Steps of the inner loop in all, half a second or so. */
static const double most_work = 4e8;

/* An outline as the bands across the roll have it, turned or not: in band b of its own it lies
 * between near[b] and far[b] of its lower left corner; nothing of it is there where near > far.
 * `reach` is `far` with the gap round it, and has `margin` bands more at both ends. */
struct profile {
    int bands, margin;
    double *near, *reach;
};

struct nest {
    const struct nesting_shape *shapes;
    const struct nesting_roll *roll;
    int bands;
    double step;                  /* the width of a band */
    struct profile (*outline)[2]; /* of each shape, as it is and turned */
    double *front;                /* of each band: up to where the roll is taken */
    struct nesting_place *trial, *best;
    size_t count;
    double length; /* of the best */
};

void nesting_point(const struct nesting_shape *shape, const struct nesting_place *place, double x,
                   double y, double on_roll[2]) {
    on_roll[0] = place->x + (place->turned ? shape->high[0] - x : x - shape->low[0]);
    on_roll[1] = place->y + (place->turned ? shape->high[1] - y : y - shape->low[1]);
}

/* ---- outlines in bands ---- */

/* Widens the bands by what an edge has in them; x and y from the lower left corner. */
static void widen_profile(const struct nest *nest, struct profile *profile, double *far,
                          const double a[2], const double b[2]) {
    const double *low = a[1] <= b[1] ? a : b, *high = a[1] <= b[1] ? b : a;
    int first = (int)fmax(floor(low[1] / nest->step - 1e-9), 0);
    int last = (int)fmin(floor(high[1] / nest->step + 1e-9), profile->bands - 1);
    double slope = high[1] > low[1] ? (high[0] - low[0]) / (high[1] - low[1]) : 0;
    for (int k = first < last ? first : last; k <= last; k++) {
        double from = fmin(fmax(k * nest->step, low[1]), high[1]);
        double to = fmin(fmax((k + 1) * nest->step, low[1]), high[1]);
        double x = low[0] + slope * (from - low[1]), y = low[0] + slope * (to - low[1]);
        bool flat = high[1] - low[1] <= 0;
        profile->near[k] = fmin(profile->near[k], flat ? fmin(a[0], b[0]) : fmin(x, y));
        far[k] = fmax(far[k], flat ? fmax(a[0], b[0]) : fmax(x, y));
    }
}

static bool make_profile(const struct nest *nest, const struct nesting_shape *shape, bool turned,
                         struct arena *arena, struct profile *profile) {
    const struct polygons_point *p = shape->cut->points;
    double wide = shape->high[1] - shape->low[1], gap = nest->roll->gap;
    const struct nesting_place origin = {.turned = turned};
    profile->bands = (int)fmin(fmax(ceil(wide / nest->step - 1e-9), 1), nest->bands);
    profile->margin = (int)fmin(ceil(gap / nest->step - 1e-9), nest->bands);
    int reached = profile->bands + 2 * profile->margin;
    profile->near = arena_alloc(arena, (size_t)profile->bands, sizeof *profile->near);
    profile->reach = arena_alloc(arena, (size_t)reached, sizeof *profile->reach);
    double *far = arena_alloc(arena, (size_t)profile->bands, sizeof *far);
    if (!profile->near || !profile->reach || !far)
        return false;
    for (int k = 0; k < profile->bands; k++) {
        profile->near[k] = HUGE_VAL;
        far[k] = -HUGE_VAL;
    }
    for (size_t k = 0, first = 0; k < shape->cut->count; k++) {
        const struct polygons_point *next = &p[p[k].last ? first : k + 1];
        double a[2], b[2];
        nesting_point(shape, &origin, p[k].x, p[k].y, a);
        nesting_point(shape, &origin, next->x, next->y, b);
        widen_profile(nest, profile, far, a, b);
        first = p[k].last ? k + 1 : first;
    }
    for (int k = 0; k < reached; k++) {
        profile->reach[k] = -HUGE_VAL;
        for (int b = k - 2 * profile->margin; b <= k; b++)
            if (b >= 0 && b < profile->bands)
                profile->reach[k] = fmax(profile->reach[k], far[b] + gap);
    }
    return true;
}

/* ---- one order ---- */

/* The place nearest to the roll's begin, of several the one that leaves the least before it. */
static void find_free_room(const struct nest *nest, struct nesting_place *place) {
    double least = HUGE_VAL, least_lost = HUGE_VAL;
    for (int turned = 0; turned <= nest->roll->turn; turned++) {
        const struct profile *own = &nest->outline[place->shape][turned];
        for (int at = 0; at + own->bands <= nest->bands; at++) {
            const double *front = nest->front + at;
            double x = 0, lost = 0;
            for (int b = 0; b < own->bands; b++)
                x = fmax(x, front[b] - own->near[b]);
            if (x > least)
                continue;
            for (int b = 0; b < own->bands; b++)
                lost += own->near[b] < HUGE_VAL ? x + own->near[b] - front[b] : 0;
            if (x < least || lost < least_lost) {
                least_lost = lost;
                least = place->x = x;
                place->y = at * nest->step;
                place->turned = turned;
            }
        }
    }
}

/* Lays the trial's places out in their order; how long the roll becomes. */
static double lay_out_order(const struct nest *nest) {
    double length = 0;
    memset(nest->front, 0, (size_t)nest->bands * sizeof *nest->front);
    for (size_t n = 0; n < nest->count; n++) {
        struct nesting_place *place = &nest->trial[n];
        const struct nesting_shape *shape = &nest->shapes[place->shape];
        find_free_room(nest, place);
        const struct profile *own = &nest->outline[place->shape][place->turned];
        int first = (int)lround(place->y / nest->step) - own->margin;
        for (int b = 0; b < own->bands + 2 * own->margin; b++)
            if (first + b >= 0 && first + b < nest->bands)
                nest->front[first + b] = fmax(nest->front[first + b], place->x + own->reach[b]);
        length = fmax(length, place->x + shape->high[0] - shape->low[0]);
    }
    return length;
}

/* Lays the trial's places on shelves across the roll: one takes what fits, the next begins behind
 * the longest of it. */
static double lay_out_shelves(const struct nest *nest) {
    double along = 0, across = 0, longest = 0;
    for (size_t n = 0; n < nest->count; n++) {
        struct nesting_place *place = &nest->trial[n];
        const struct nesting_shape *shape = &nest->shapes[place->shape];
        double wide = shape->high[1] - shape->low[1];
        if (across > 0 && across + wide > nest->roll->width) {
            along += longest + nest->roll->gap;
            across = longest = 0;
        }
        place->x = along;
        place->y = across;
        place->turned = false;
        across += wide + nest->roll->gap;
        longest = fmax(longest, shape->high[0] - shape->low[0]);
    }
    return along + longest;
}

/* ---- orders ---- */

enum by { BY_LENGTH, BY_AREA, BY_WIDTH, BY_COUNT };

struct ranked {
    struct nesting_place place;
    double size;
};

/* The larger first; of the same size in the order that they were given. */
static int compare_ranked(const void *a, const void *b) {
    const struct ranked *x = a, *y = b;
    if (x->size > y->size || y->size > x->size)
        return x->size > y->size ? -1 : 1;
    if (x->place.shape != y->place.shape)
        return x->place.shape > y->place.shape ? 1 : -1;
    return (x->place.layer > y->place.layer) - (x->place.layer < y->place.layer);
}

static void rank_places(const struct nest *nest, enum by by, struct ranked *ranked) {
    size_t n = 0;
    for (size_t k = 0; n < nest->count; k++) {
        const struct nesting_shape *shape = &nest->shapes[k];
        double size =
            by == BY_AREA ? shape->area : shape->high[by == BY_WIDTH] - shape->low[by == BY_WIDTH];
        for (int layer = 0; layer < shape->layers; layer++)
            ranked[n++] = (struct ranked){{.shape = k, .layer = layer}, size};
    }
    qsort(ranked, nest->count, sizeof *ranked, compare_ranked);
    for (n = 0; n < nest->count; n++)
        nest->trial[n] = ranked[n].place;
}

/* Takes the trial if it is shorter than the best. */
static bool keep_shorter(struct nest *nest, double length) {
    bool shorter = length < nest->length;
    if (shorter)
        memcpy(nest->best, nest->trial, nest->count * sizeof *nest->best);
    nest->length = shorter ? length : nest->length;
    return shorter;
}

/* Exchanges two of different shapes in the best order, again and again. */
static void exchange_places(struct nest *nest, int exchanges) {
    uint32_t state = 1;
    for (int k = 0; k < exchanges && nest->count > 1; k++) {
        size_t pair[2];
        for (int n = 0; n < 2; n++) { /* numbers of Lehmer's, the same every time */
            state = (uint32_t)((uint64_t)state * 48271 % 2147483647);
            pair[n] = state % nest->count;
        }
        memcpy(nest->trial, nest->best, nest->count * sizeof *nest->trial);
        struct nesting_place first = nest->trial[pair[0]];
        if (first.shape == nest->trial[pair[1]].shape)
            continue;
        nest->trial[pair[0]] = nest->trial[pair[1]];
        nest->trial[pair[1]] = first;
        keep_shorter(nest, lay_out_order(nest));
    }
}

static int compare_on_roll(const void *a, const void *b) {
    const struct nesting_place *x = a, *y = b;
    if (x->x > y->x || y->x > x->x)
        return x->x > y->x ? 1 : -1;
    return (x->y > y->y) - (x->y < y->y);
}

bool nesting_make(const struct nesting_shape *shapes, size_t count, const struct nesting_roll *roll,
                  struct arena *arena, struct nesting_place **places, double *length) {
    struct nest nest = {.shapes = shapes, .roll = roll, .bands = BANDS, .length = HUGE_VAL};
    for (size_t k = 0; k < count; k++)
        nest.count += (size_t)shapes[k].layers;
    double each = (double)nest.count * (1 + roll->turn); /* of one order, times bands squared / 4 */
    while (nest.bands > BANDS_LEAST && BY_COUNT * each * nest.bands * nest.bands / 4 > most_work)
        nest.bands -= BANDS_LEAST;
    double work = each * nest.bands * nest.bands / 4;
    bool many = BY_COUNT * work > most_work; /* shelves will do */
    nest.step = roll->width / nest.bands;
    nest.trial = arena_alloc(arena, nest.count, sizeof *nest.trial);
    nest.best = arena_alloc(arena, nest.count, sizeof *nest.best);
    *places = nest.best;
    struct arena_mark mark = arena_mark(arena);
    struct ranked *ranked = arena_alloc(arena, nest.count, sizeof *ranked);
    nest.front = arena_alloc(arena, (size_t)nest.bands, sizeof *nest.front);
    nest.outline = arena_alloc(arena, count, sizeof *nest.outline);
    bool good = nest.trial && nest.best && ranked && nest.front && nest.outline;
    for (size_t k = 0; good && !many && k < count; k++)
        for (int turned = 0; turned <= roll->turn; turned++)
            good = good && make_profile(&nest, &shapes[k], turned, arena, &nest.outline[k][turned]);
    if (good) {
        rank_places(&nest, BY_LENGTH, ranked);
        keep_shorter(&nest, lay_out_shelves(&nest));
        for (int by = BY_LENGTH; !many && by < BY_COUNT; by++) {
            rank_places(&nest, (enum by)by, ranked);
            keep_shorter(&nest, lay_out_order(&nest));
        }
        exchange_places(&nest, many ? 0 : (int)fmin(EXCHANGES, most_work / work));
        qsort(nest.best, nest.count, sizeof *nest.best, compare_on_roll);
    }
    arena_rewind(arena, mark);
    *length = nest.length;
    return good;
}
