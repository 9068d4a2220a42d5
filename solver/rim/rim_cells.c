/* SPDX-License-Identifier: MIT */
#include "rim_cells.h"

#include <stdlib.h>

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
    size_t point;        /* of the rim, at which it begins */
    bool reached, loose; /* the cloth reaches some of it; and does not reach some */
};

struct passages {
    struct march *march;
    struct passage *all;
    size_t count, room;
    bool failed; /* no memory */
};

/* ---- shares ---- */

/* Where the cloth ends on a side of cells, what does not reach the rim belongs to the cell beyond:
 * so much of it is rounding. */
static const double shortest_loose = 1e-9;

/* Adds a piece to the passage of its cell: the last, or a new one. */
static void add_passage(struct passages *c, const struct rim_piece *piece) {
    double p = (piece->from[0] + piece->to[0]) / 2, q = (piece->from[1] + piece->to[1]) / 2;
    double dp = piece->to[0] - piece->from[0], rise = piece->to[1] - piece->from[1];
    double weight = sqrt(dp * dp + rise * rise) + 1e-12;
    struct passage *own = c->count ? &c->all[c->count - 1] : NULL;
    if (!own || own->i != piece->i || own->j != piece->j) {
        if (c->count == c->room)
            c->all = arena_enlarge(c->march->arena, c->all, c->count, sizeof *c->all, &c->room);
        c->failed = c->failed || !c->all;
        if (c->failed)
            return;
        own = &c->all[c->count++];
        *own = (struct passage){.i = piece->i, .j = piece->j, .point = piece->point};
    }
    own->rise += rise;
    own->area += rise * (p - piece->i);
    own->length += weight;
    own->p += weight * p;
    own->q += weight * q;
    own->reached = own->reached || !piece->loose;
    own->loose = own->loose || (piece->loose && !piece->at_extent && weight > shortest_loose);
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
    struct rim_walk walk = {.rim = rim};
    struct rim_piece piece;
    while (!c.failed && rim_walk_next(&walk, &piece))
        add_passage(&c, &piece);
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
        double area = 0, length = 0, longest = 0;
        bool reached = false;
        rise = new_row ? 0 : rise;
        for (; k < c.count && c.all[k].i == cell.i && c.all[k].j == cell.j; k++) {
            const struct passage *own = &c.all[k];
            rise += own->rise;
            area += own->area;
            length += own->length;
            cell.point = own->length > longest ? own->point : cell.point;
            longest = fmax(longest, own->length);
            cell.p += own->p;
            cell.q += own->q;
            cell.loose = cell.loose || own->loose;
            reached = reached || own->reached;
        }
        cell.loose = cell.loose || !reached;
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
