/* SPDX-License-Identifier: MIT */
#include "rim_cells.h"

#include <stdlib.h>
#include <string.h>

/* Rounding, and the corners that straight lines cut, leave the shares of cells this exact. */
static const double twice = 1e-2;

/* A cell that the rim does not pass lies within it once or not at all, but for rounding. */
static const double within = 0.5;

/* What the rim adds to a cell while it passes it once. */
struct passage {
    int32_t i, j;
    double rise;         /* to q, along the edge */
    double area;         /* on the left of the edge in this cell */
    double length, p, q; /* and the sums of p and q of its pieces by their lengths */
    bool loose;
};

struct passages {
    struct march *march;
    struct passage *all;
    size_t count, room;
    bool failed; /* no memory */
};

/* ---- shares ---- */

/* The rim that runs along the sides of cells, as far as rounding goes, is that of the cells that it
 * has on its left: they may have nodes beyond it, and then are no whole cells. */
static const double beside = 1e-9;

/* Adds a straight piece within one cell to the passage of that cell: the last, or a new one. */
static void add_passage(struct passages *c, const double from[2], const double to[2], bool loose) {
    double p = (from[0] + to[0]) / 2, q = (from[1] + to[1]) / 2, rise = to[1] - from[1];
    double dp = to[0] - from[0], weight = sqrt(dp * dp + rise * rise) + 1e-12;
    double i = floor(p - beside * rise / weight), j = floor(q + beside * dp / weight);
    struct passage *own = c->count ? &c->all[c->count - 1] : NULL;
    if (!own || own->i != (int32_t)i || own->j != (int32_t)j) {
        if (c->count == c->room)
            c->all = arena_enlarge(c->march->arena, c->all, c->count, sizeof *c->all, &c->room);
        c->failed = c->failed || !c->all;
        if (c->failed)
            return;
        own = &c->all[c->count++];
        *own = (struct passage){.i = (int32_t)i, .j = (int32_t)j};
    }
    own->rise += rise;
    own->area += rise * (p - i);
    own->length += weight;
    own->p += weight * p;
    own->q += weight * q;
    own->loose = own->loose || loose;
}

/* The share of the way from `x` to `to`, starting at share `at`, at which the next whole number is
 * passed; 1 if none is. */
static double next_cell_side(double from, double to, double at) {
    double x = from + at * (to - from), step = to - from;
    if (step == 0)
        return 1;
    double line = step > 0 ? floor(x) + 1 : ceil(x) - 1, next = (line - from) / step;
    if (next <= at)
        next = (line + (step > 0 ? 1 : -1) - from) / step;
    return next < 1 ? next : 1;
}

static int compare_passages(const void *a, const void *b) {
    const struct passage *x = a, *y = b;
    if (x->j != y->j)
        return x->j < y->j ? -1 : 1;
    if (x->i != y->i)
        return x->i < y->i ? -1 : 1;
    if (x->p != y->p)
        return x->p < y->p ? -1 : 1;
    return (x->q > y->q) - (x->q < y->q);
}

enum status rim_cells_make(struct march *march, const struct rim *rim, struct rim_cells *cells) {
    struct passages c = {.march = march};
    /* the passages: the straight lines between two points go from cell to cell */
    for (size_t first = 0, k = 0; k < rim->count && !c.failed; k++) {
        bool last = k + 1 == rim->count || rim->points[k + 1].loop != rim->points[k].loop;
        const struct rim_point *a = &rim->points[k], *b = &rim->points[last ? first : k + 1];
        const double from[2] = {a->p, a->q}, to[2] = {b->p, b->q};
        double begin[2] = {from[0], from[1]}, end[2] = {to[0], to[1]};
        bool loose = !a->covered || !b->covered;
        bool one_cell = floor(from[0]) == floor(to[0]) && floor(from[1]) == floor(to[1]);
        for (double at = one_cell; at < 1 && !c.failed;) {
            at = fmin(next_cell_side(from[0], to[0], at), next_cell_side(from[1], to[1], at));
            for (int n = 0; n < 2; n++)
                end[n] = at == 1 ? to[n] : from[n] + at * (to[n] - from[n]);
            add_passage(&c, begin, end, loose);
            memcpy(begin, end, sizeof begin);
        }
        if (one_cell)
            add_passage(&c, from, to, loose);
        first = last ? k + 1 : first;
    }
    *cells = (struct rim_cells){.cells = arena_take(march->arena, c.count, sizeof *cells->cells)};
    if (c.failed || !cells->cells)
        return STATUS_OUT_OF_MEMORY;
    if (c.count)
        qsort(c.all, c.count, sizeof *c.all, compare_passages);
    double rise = 0; /* of the row so far */
    /* their sum, cell by cell */
    for (size_t k = 0; k < c.count;) {
        struct rim_cell cell = {.i = c.all[k].i, .j = c.all[k].j};
        bool new_row = cells->count == 0 || cells->cells[cells->count - 1].j != cell.j;
        double area = 0, length = 0;
        rise = new_row ? 0 : rise;
        for (; k < c.count && c.all[k].i == cell.i && c.all[k].j == cell.j; k++) {
            const struct passage *own = &c.all[k];
            rise += own->rise;
            area += own->area;
            length += own->length;
            cell.p += own->p;
            cell.q += own->q;
            cell.loose = cell.loose || own->loose;
        }
        cell.p /= length;
        cell.q /= length;
        cell.share = area - rise;
        bool beyond = cell.share > 1 + twice || cell.share < -twice;
        cells->overlaps = cells->overlaps || (rim->covered && beyond);
        cell.share = fmin(fmax(cell.share, 0), 1);
        bool closed = k < c.count && c.all[k].j == cell.j && !cell.loose && -rise > within;
        cell.inner = closed ? c.all[k].i - cell.i - 1 : 0;
        cells->cells[cells->count++] = cell;
    }
    return STATUS_OK;
}
