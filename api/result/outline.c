/* SPDX-License-Identifier: MIT */
#include "outline.h"

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { BLOCK = 1024, TABLES = 2 /* whole cells, and those that the rim cuts */ };

/* The rim passes a corner or side of a cell that is so near, in spacings. */
static const double near = 1e-9;

/* A straight piece of the rim within one cell. */
struct piece {
    int32_t i, j;
    size_t order; /* along the rim */
    double from[2], to[2];
    bool loose; /* the cloth does not reach it */
};

/* Cells first .. last - 1 of a row. */
struct run {
    int32_t first, last;
};

struct row {
    int32_t j;
    struct run *runs;
    size_t count, capacity;
};

static const struct row none = {0};

/* Some of the side of a cell that lies on the line i = line (upright) or j = line, from `at` to
 * at + 1 along it. It goes from one place to the other. */
struct side {
    bool upright;
    int32_t line, at;
    double from, to;
};

/* A part of the outline. */
struct edge {
    double from[2], to[2];
    bool used;
};

struct builder {
    struct piece *pieces;
    size_t piece_count, piece_capacity, next; /* the first of the cells to come */
    struct row below, row; /* of whole cells that the rim does not cut: before, and that grows */
    struct side *sides;
    size_t side_count, side_capacity;
    struct edge *edges;
    size_t edge_count, edge_capacity;
    bool failed; /* no memory */
};

/* The elements with room for one more of `size` bytes; `failed` is set without memory. */
static void *room_for(void *elements, size_t count, size_t *capacity, size_t size, bool *failed) {
    if (count < *capacity)
        return elements;
    size_t wanted = *capacity ? 2 * *capacity : 64;
    void *larger = realloc(elements, wanted * size);
    *capacity = larger ? wanted : *capacity;
    *failed = *failed || !larger;
    return larger ? larger : elements;
}

static void add_side(struct builder *b, bool upright, int32_t line, int32_t at, double from,
                     double to) {
    b->sides = room_for(b->sides, b->side_count, &b->side_capacity, sizeof *b->sides, &b->failed);
    if (!b->failed && from != to)
        b->sides[b->side_count++] = (struct side){upright, line, at, from, to};
}

static void add_edge(struct builder *b, const double from[2], const double to[2]) {
    b->edges = room_for(b->edges, b->edge_count, &b->edge_capacity, sizeof *b->edges, &b->failed);
    if (!b->failed)
        b->edges[b->edge_count++] = (struct edge){{from[0], from[1]}, {to[0], to[1]}, false};
}

/* ---- the rim, cell by cell ---- */

static double snapped(double x) {
    double whole = round(x);
    return fabs(x - whole) <= near ? whole : x;
}

/* The cell on the left of a piece, by its extent along one axis; on a line between cells it goes
 * along the other one in the sense `along`. */
static int32_t cell_left_of(double from, double to, double along) {
    double middle = (from + to) / 2;
    return (int32_t)(from == to && from == floor(from) && along < 0 ? from - 1 : floor(middle));
}

static void add_outline_piece(struct builder *b, const double from[2], const double to[2],
                              bool loose) {
    int32_t i = cell_left_of(from[0], to[0], from[1] - to[1]);
    int32_t j = cell_left_of(from[1], to[1], to[0] - from[0]);
    if (from[0] == to[0] && from[1] == to[1])
        return;
    b->pieces =
        room_for(b->pieces, b->piece_count, &b->piece_capacity, sizeof *b->pieces, &b->failed);
    if (b->failed)
        return;
    b->pieces[b->piece_count] =
        (struct piece){i, j, b->piece_count, {from[0], from[1]}, {to[0], to[1]}, loose};
    b->piece_count++;
}

/* Divides a straight line of the rim where it passes from one cell to the next. */
static void add_line(struct builder *b, const double from[2], const double to[2], bool loose) {
    double begin[2] = {from[0], from[1]}, end[2], share = 0;
    while (share < 1 && !b->failed) {
        double next = 1, lines[2] = {0, 0};
        int axis = -1;
        for (int k = 0; k < 2; k++) {
            double way = to[k] - from[k];
            lines[k] = way > 0 ? floor(begin[k]) + 1 : ceil(begin[k]) - 1;
            double own = way == 0 ? 1 : (lines[k] - from[k]) / way;
            axis = own < next ? k : axis;
            next = fmin(next, own);
        }
        share = fmax(next, share);
        for (int k = 0; k < 2; k++)
            end[k] = axis < 0 ? to[k] : snapped(from[k] + share * (to[k] - from[k]));
        if (axis >= 0)
            end[axis] = lines[axis];
        add_outline_piece(b, begin, end, loose);
        memcpy(begin, end, sizeof begin);
        share = axis < 0 ? 1 : share;
    }
}

static int compare_pieces(const void *a, const void *b) {
    const struct piece *x = a, *y = b;
    if (x->j != y->j)
        return x->j < y->j ? -1 : 1;
    if (x->i != y->i)
        return x->i < y->i ? -1 : 1;
    return (x->order > y->order) - (x->order < y->order);
}

static void divide_rim(struct builder *b, const struct outline_rim *rim) {
    for (size_t first = 0, k = 0; k < rim->count; k++) {
        bool last = k + 1 == rim->count || rim->loop[k + 1] != rim->loop[k];
        size_t next = last ? first : k + 1;
        const double from[2] = {snapped(rim->p[k]), snapped(rim->q[k])};
        const double to[2] = {snapped(rim->p[next]), snapped(rim->q[next])};
        add_line(b, from, to, rim->covered[k] == 0 || rim->covered[next] == 0);
        first = last ? k + 1 : first;
    }
    if (b->piece_count > 0)
        qsort(b->pieces, b->piece_count, sizeof *b->pieces, compare_pieces);
}

/* ---- cells that the rim cuts ---- */

enum { CHAINS = 64 /* of one cell; more are left out */ };

/* The rim from where it enters a cell to where it leaves it. */
struct chain {
    const double *enters, *leaves;
    double in, out; /* where on the way round the cell, as `way_round` */
    double twice;   /* twice the area that it goes round to the left */
};

/* Where a place is on the way round the cell (i, j) to the left: 0..1 on its lower side, then 1..2
 * on its right one, and so on; negative inside. */
static double way_round(int32_t i, int32_t j, const double at[2]) {
    double x = at[0] - i, y = at[1] - j;
    return y == 0 ? x : x == 1 ? 1 + y : y == 1 ? 3 - x : x == 0 ? 4 - y : -1;
}

/* The sides on the way round the cell from where the rim leaves it to where it enters it again, at
 * `in`, no earlier on that way than `out`. */
static void add_arc(struct builder *b, int32_t i, int32_t j, const struct chain *leaving, double in,
                    const double *enters) {
    double out = leaving->out;
    for (int k = (int)out; k < in; k++) {
        int side = k % 4, axis = side % 2;
        double low = axis ? j : i, ends[2] = {side < 2 ? low : low + 1, side < 2 ? low + 1 : low};
        double from = k <= out ? leaving->leaves[axis] : ends[0];
        double to = k + 1 >= in ? enters[axis] : ends[1];
        bool far = side == 1 || side == 2;
        add_side(b, axis == 1, (axis ? i : j) + far, axis ? j : i, from, to);
    }
}

/* The chains of a cell's pieces, in their order. */
static size_t find_chains(const struct piece *pieces, size_t count, struct chain *chains) {
    int32_t i = pieces[0].i, j = pieces[0].j;
    size_t found = 0;
    for (size_t k = 0; k < count; k++) {
        const struct piece *own = &pieces[k];
        bool on = found > 0 && memcmp(chains[found - 1].leaves, own->from, sizeof own->from) == 0;
        if (!on && found == CHAINS)
            break;
        if (!on)
            chains[found++] = (struct chain){.enters = own->from};
        chains[found - 1].leaves = own->to;
        chains[found - 1].twice +=
            (own->from[0] - i) * (own->to[1] - j) - (own->to[0] - i) * (own->from[1] - j);
    }
    struct chain *last = &chains[found - 1];
    if (found > 1 && memcmp(last->leaves, chains[0].enters, sizeof pieces->from) == 0) {
        chains[0].enters = last->enters; /* the rim's own list begins here */
        chains[0].twice += last->twice;
        found--;
    }
    for (size_t k = 0; k < found; k++) {
        chains[k].in = way_round(i, j, chains[k].enters);
        chains[k].out = way_round(i, j, chains[k].leaves);
    }
    return found;
}

/* What encloses the cloth of a cell: the rim and, from where this leaves the cell to where it comes
 * back next on the way round, the cell's sides. */
static void add_cut_cell(struct builder *b, const struct piece *pieces, size_t count) {
    struct chain chains[CHAINS];
    size_t found = find_chains(pieces, count, chains);
    int32_t i = pieces[0].i, j = pieces[0].j;
    const double corner[2] = {i, j};
    for (size_t k = 0; k < count; k++)
        add_edge(b, pieces[k].from, pieces[k].to);
    for (size_t k = 0; k < found; k++) {
        const struct chain *own = &chains[k], *next = NULL;
        double least = HUGE_VAL;
        if (own->out < 0) { /* a loop within the cell: a hole in it, or all that there is */
            const struct chain round = {.leaves = corner, .out = 0};
            if (own->twice < 0 && found == 1)
                add_arc(b, i, j, &round, 4, corner);
            continue;
        }
        for (size_t m = 0; m < found; m++) {
            double way = chains[m].in - own->out;
            way += way < 0 || (way == 0 && m == k && own->twice < 0) ? 4 : 0;
            next = chains[m].in >= 0 && way < least ? &chains[m] : next;
            least = next == &chains[m] ? way : least;
        }
        if (next)
            add_arc(b, i, j, own, own->out + least, next->enters);
    }
}

/* ---- other cells ---- */

/* The place of the k-th end of a row's runs, INT32_MAX behind the last. */
static int32_t run_end_at(const struct row *row, size_t k) {
    if (k / 2 >= row->count)
        return INT32_MAX;
    return k % 2 ? row->runs[k / 2].last : row->runs[k / 2].first;
}

/* The sides on the line j between two rows: where only one of them has cells. */
static void close_line(struct builder *b, int32_t j, const struct row *below,
                       const struct row *above) {
    size_t ends[2] = {0, 0};
    int32_t from = 0;
    for (;;) {
        int32_t next[2] = {run_end_at(below, ends[0]), run_end_at(above, ends[1])};
        int32_t to = next[0] < next[1] ? next[0] : next[1];
        bool in_below = ends[0] % 2, in_above = ends[1] % 2;
        for (int32_t i = from; in_above != in_below && i < to; i++)
            add_side(b, false, j, i, in_above ? i : i + 1, in_above ? i + 1 : i);
        if (to == INT32_MAX)
            return;
        for (int k = 0; k < 2; k++)
            ends[k] += next[k] == to;
        from = to;
    }
}

/* The row is complete: its sides, and those on the line under it. */
static void finish_row(struct builder *b) {
    struct row *row = &b->row, *below = &b->below;
    if (row->count == 0)
        return;
    bool adjacent = below->count > 0 && below->j == row->j - 1;
    if (below->count > 0 && !adjacent)
        close_line(b, below->j + 1, below, &none);
    close_line(b, row->j, adjacent ? below : &none, row);
    for (size_t k = 0; k < row->count; k++) {
        add_side(b, true, row->runs[k].last, row->j, row->j, row->j + 1);
        add_side(b, true, row->runs[k].first, row->j, row->j + 1, row->j);
    }
    struct row swap = *below;
    *below = *row;
    *row = swap;
    row->count = 0;
}

/* The cell goes on the last run of its row, or begins one. */
static void add_whole_cell(struct builder *b, int32_t i, int32_t j) {
    struct row *row = &b->row;
    if (row->count > 0 && row->j != j)
        finish_row(b);
    row->j = j;
    if (row->count > 0 && row->runs[row->count - 1].last == i) {
        row->runs[row->count - 1].last = i + 1;
        return;
    }
    row->runs = room_for(row->runs, row->count, &row->capacity, sizeof *row->runs, &b->failed);
    if (!b->failed)
        row->runs[row->count++] = (struct run){i, i + 1};
}

/* A cell of the cloth, no earlier in their order than those before. */
static void add_cell(struct builder *b, int32_t i, int32_t j) {
    const struct piece *p = b->pieces;
    bool loose = false;
    while (b->next < b->piece_count &&
           (p[b->next].j < j || (p[b->next].j == j && p[b->next].i < i)))
        b->next++;
    size_t first = b->next;
    for (; b->next < b->piece_count && p[b->next].j == j && p[b->next].i == i; b->next++)
        loose = loose || p[b->next].loose;
    if (b->next > first && !loose)
        add_cut_cell(b, p + first, b->next - first);
    else
        add_whole_cell(b, i, j);
}

/* ---- the cells as they are stored ---- */

struct stored_cells {
    const struct api_reader *reader;
    const struct api_column *column[2]; /* i, j; NULL: there are none */
    size_t row, first, held;
    double block[2][BLOCK];
};

/* The cell that is next in its table; false at the end or, with `failed`, if it cannot be read. */
static bool look_at_cell(struct stored_cells *cells, int32_t at[2], bool *failed) {
    size_t rows = cells->column[0] && cells->column[1] ? cells->column[0]->rows : 0;
    if (cells->row >= rows)
        return false;
    if (cells->row >= cells->first + cells->held) {
        cells->first = cells->row;
        cells->held = rows - cells->row < BLOCK ? rows - cells->row : BLOCK;
        for (int k = 0; k < 2; k++)
            if (!api_columns_read(cells->reader, cells->column[k], cells->first, cells->held,
                                  cells->block[k]))
                *failed = true;
    }
    for (int k = 0; k < 2 && !*failed; k++)
        at[k] = (int32_t)cells->block[k][cells->row - cells->first];
    return !*failed;
}

/* Takes the cells of both tables in their common order. */
static bool read_cells(struct builder *b, const struct api_reader *reader,
                       const struct api_columns *columns) {
    static const enum api_table tables[TABLES] = {API_TABLE_CELLS, API_TABLE_CUT};
    struct stored_cells cells[TABLES];
    int32_t before[2] = {0, 0};
    bool failed = false, begun = false;
    for (int k = 0; k < TABLES; k++)
        cells[k] = (struct stored_cells){.reader = reader,
                                         .column = {api_columns_find(columns, tables[k], "i"),
                                                    api_columns_find(columns, tables[k], "j")}};
    while (!failed && !b->failed) {
        int32_t at[TABLES][2];
        bool there[TABLES];
        for (int k = 0; k < TABLES; k++)
            there[k] = look_at_cell(&cells[k], at[k], &failed);
        if (failed || (!there[0] && !there[1]))
            break;
        int own =
            !there[0] ||
            (there[1] && (at[1][1] < at[0][1] || (at[1][1] == at[0][1] && at[1][0] < at[0][0])));
        int32_t i = at[own][0], j = at[own][1];
        failed = begun && (j < before[1] || (j == before[1] && i <= before[0]));
        begun = true;
        before[0] = i;
        before[1] = j;
        cells[own].row++;
        if (!failed)
            add_cell(b, i, j);
    }
    finish_row(b);
    if (b->below.count > 0 && !b->failed)
        close_line(b, b->below.j + 1, &b->below, &none);
    return !failed && cells[0].column[0] && cells[0].column[1];
}

/* ---- what is left of the sides ---- */

static int compare_sides(const void *a, const void *b) {
    const struct side *x = a, *y = b;
    if (x->upright != y->upright)
        return x->upright ? 1 : -1;
    if (x->line != y->line)
        return x->line < y->line ? -1 : 1;
    return (x->at > y->at) - (x->at < y->at);
}

static int compare_outline_places(const void *a, const void *b) {
    const double *x = a, *y = b;
    return (*x > *y) - (*x < *y);
}

/* Of the sides of two cells that lie on each other what only one of them has. */
static void add_rest(struct builder *b, const struct side *sides, size_t count) {
    double places[4 * CHAINS];
    size_t found = 0;
    for (size_t k = 0; k < count && found + 2 <= sizeof places / sizeof *places; k++) {
        places[found++] = sides[k].from;
        places[found++] = sides[k].to;
    }
    qsort(places, found, sizeof *places, compare_outline_places);
    for (size_t k = 0; k + 1 < found; k++) {
        double low = places[k], high = places[k + 1], line = sides->line;
        int sense = 0;
        for (size_t m = 0; m < count; m++)
            sense += (sides[m].from <= low && sides[m].to >= high) -
                     (sides[m].to <= low && sides[m].from >= high);
        if (low == high || sense == 0)
            continue;
        double from = sense > 0 ? low : high, to = sense > 0 ? high : low;
        const double a[2] = {sides->upright ? line : from, sides->upright ? from : line};
        const double c[2] = {sides->upright ? line : to, sides->upright ? to : line};
        add_edge(b, a, c);
    }
}

static void join_sides(struct builder *b, struct outline *outline) {
    size_t first = b->edge_count;
    if (b->side_count > 0)
        qsort(b->sides, b->side_count, sizeof *b->sides, compare_sides);
    for (size_t k = 0, end; k < b->side_count && !b->failed; k = end) {
        for (end = k + 1; end < b->side_count && compare_sides(&b->sides[k], &b->sides[end]) == 0;)
            end++;
        add_rest(b, b->sides + k, end - k);
    }
    outline->sides = calloc(b->edge_count - first + 1, sizeof *outline->sides);
    b->failed = b->failed || !outline->sides;
    for (size_t k = first; k < b->edge_count && !b->failed; k++) {
        struct outline_side *side = &outline->sides[outline->count++];
        memcpy(side->from, b->edges[k].from, sizeof side->from);
        memcpy(side->to, b->edges[k].to, sizeof side->to);
    }
}

/* ---- polygons ---- */

static int compare_starts(const void *a, const void *b) {
    const struct edge *x = a, *y = b;
    return x->from[1] != y->from[1] ? (x->from[1] > y->from[1]) - (x->from[1] < y->from[1])
                                    : (x->from[0] > y->from[0]) - (x->from[0] < y->from[0]);
}

/* By how much the outline turns left from one edge to the next, -pi..pi. */
static double edge_turn(const struct edge *edge, const struct edge *next) {
    double a[2] = {edge->to[0] - edge->from[0], edge->to[1] - edge->from[1]};
    double b[2] = {next->to[0] - next->from[0], next->to[1] - next->from[1]};
    return atan2(a[0] * b[1] - a[1] * b[0], a[0] * b[0] + a[1] * b[1]);
}

/* The edge that begins where this one ends; where several do, the one furthest to the left, which
 * keeps cells that touch at a corner apart. */
static struct edge *edge_after(const struct builder *b, const struct edge *edge) {
    const struct edge key = {.from = {edge->to[0], edge->to[1]}};
    struct edge *edges = b->edges, *end = edges + b->edge_count, *next = NULL;
    struct edge *found = bsearch(&key, edges, b->edge_count, sizeof *edges, compare_starts);
    while (found && found > edges && compare_starts(found - 1, &key) == 0)
        found--;
    for (; found && found < end && compare_starts(found, &key) == 0; found++)
        if (!found->used && (!next || edge_turn(edge, found) > edge_turn(edge, next)))
            next = found;
    return next;
}

/* Each polygon begins at its lowest corner, of these the one furthest to the left. */
static void join_edges(struct builder *b, struct polygons *outline) {
    if (b->edge_count > 0)
        qsort(b->edges, b->edge_count, sizeof *b->edges, compare_starts);
    for (size_t k = 0; k < b->edge_count && !b->failed; k++) {
        struct edge *edge = b->edges[k].used ? NULL : &b->edges[k];
        if (!edge)
            continue;
        for (bool corner = true; edge && !b->failed;) {
            if (corner && !polygons_add(outline, edge->from[0], edge->from[1]))
                b->failed = true;
            edge->used = true;
            struct edge *next = edge_after(b, edge);
            corner = next && edge_turn(edge, next) != 0;
            edge = next;
        }
        polygons_close(outline);
    }
}

enum api_problem_id outline_make(const struct api_reader *reader, const struct api_columns *columns,
                                 const struct outline_rim *rim, struct outline *outline,
                                 struct api_problem *problem) {
    struct builder *b = calloc(1, sizeof *b);
    if (!b)
        return api_problem_no_memory(problem, "the outline");
    divide_rim(b, rim);
    if (!read_cells(b, reader, columns))
        api_problem_set(problem, API_INTERNAL, "the stored result is damaged");
    if (problem->id == API_OK && !b->failed)
        join_sides(b, outline);
    if (problem->id == API_OK && !b->failed)
        join_edges(b, &outline->polygons);
    if (b->failed)
        api_problem_no_memory(problem, "the outline");
    free(b->pieces);
    free(b->below.runs);
    free(b->row.runs);
    free(b->sides);
    free(b->edges);
    free(b);
    return problem->id;
}

void outline_free(struct outline *outline) {
    polygons_free(&outline->polygons);
    free(outline->sides);
    *outline = (struct outline){0};
}
