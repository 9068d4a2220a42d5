/* SPDX-License-Identifier: MIT */
#include "edge.h"

#include <math.h>
#include <string.h>

enum { BLOCK = 512, COLUMNS = 4 };

/* Straight lines between points of the rim are right to 1e-3 spacings, and places on facets that
 * stand for curved cells to some times that. */
static const double width = 1e-2;

/* The largest slack that is looked at. */
static const double most_slack = 0.05;

/* A straight line between two points, in each row of cells that it passes. */
struct line {
    double from[2], to[2];
};

/* The lines of row low + k are lines[first[k]] .. lines[first[k + 1] - 1]. */
struct edge {
    int64_t low, count; /* rows */
    size_t *first;
    struct line *lines;
    bool *loose; /* by row: the rim is not known there */
};

/* The points, read in blocks: loop, p, q, covered. */
struct points {
    const struct api_reader *reader;
    const struct api_column *column[COLUMNS];
    size_t first, held;
    double block[COLUMNS][BLOCK];
    bool failed;
};

struct point {
    double loop, pq[2], covered;
};

static struct point point_at(struct points *points, size_t k) {
    if (k < points->first || k >= points->first + points->held) {
        size_t left = points->column[0]->rows - k;
        points->first = k;
        points->held = left < BLOCK ? left : BLOCK;
        for (int c = 0; c < COLUMNS; c++)
            points->failed = points->failed || !api_columns_read(points->reader, points->column[c],
                                                                 k, points->held, points->block[c]);
    }
    size_t at = k - points->first;
    return (struct point){
        points->block[0][at], {points->block[1][at], points->block[2][at]}, points->block[3][at]};
}

static int64_t row_of(const struct edge *edge, double q) {
    return (int64_t)fmin(fmax(floor(q) - (double)edge->low, 0), (double)edge->count - 1);
}

/* Counts a line in its rows or, with room for it, puts it there. */
static void put_line(struct edge *edge, const struct point *a, const struct point *b, bool count) {
    int64_t from = row_of(edge, fmin(a->pq[1], b->pq[1]) - width - most_slack);
    int64_t to = row_of(edge, fmax(a->pq[1], b->pq[1]) + width + most_slack);
    for (int64_t row = from; row <= to; row++) {
        if (count) {
            edge->first[row + 2]++;
            edge->loose[row] = edge->loose[row] || a->covered == 0 || b->covered == 0;
            continue;
        }
        struct line *line = &edge->lines[edge->first[row + 1]++];
        memcpy(line->from, a->pq, sizeof line->from);
        memcpy(line->to, b->pq, sizeof line->to);
    }
}

static void put_lines(struct edge *edge, struct points *points, bool count) {
    size_t rows = points->column[0]->rows;
    struct point begin = {0}, last = {0};
    for (size_t k = 0; k <= rows && !points->failed; k++) {
        struct point here = k < rows ? point_at(points, k) : (struct point){.loop = -1};
        bool same = k > 0 && here.loop == last.loop;
        if (k > 0)
            put_line(edge, &last, same ? &here : &begin, count);
        if (!same)
            begin = here;
        last = here;
    }
}

/* Finds the rows that there are. */
static void find_rows(struct edge *edge, struct points *points) {
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (size_t k = 0; k < points->column[0]->rows && !points->failed; k++) {
        double q = point_at(points, k).pq[1];
        low = fmin(low, q);
        high = fmax(high, q);
    }
    edge->low = (int64_t)floor(low) - 1;
    edge->count = (int64_t)floor(high) + 2 - edge->low;
}

static enum api_problem_id fail(struct api_problem *problem, bool memory) {
    api_problem_set(problem, memory ? API_OUT_OF_MEMORY : API_INTERNAL,
                    memory ? "the map needs more memory than allowed"
                           : "the stored result is damaged or cannot be read");
    return problem->id;
}

enum api_problem_id edge_make(const struct api_reader *reader, const struct api_columns *columns,
                              struct arena *arena, struct edge **result,
                              struct api_problem *problem) {
    static const char *const names[COLUMNS] = {"loop", "p", "q", "covered"};
    struct edge *edge = arena_alloc(arena, 1, sizeof *edge);
    struct points *points = arena_alloc(arena, 1, sizeof *points);
    if (!edge || !points)
        return fail(problem, true);
    *result = edge;
    if (api_columns_rows(columns, API_TABLE_RIM) == 0)
        return API_OK;
    points->reader = reader;
    for (int c = 0; c < COLUMNS; c++) {
        points->column[c] = api_columns_find(columns, API_TABLE_RIM, names[c]);
        if (!points->column[c])
            return fail(problem, false);
    }
    find_rows(edge, points);
    if (points->failed || !(edge->count > 0))
        return fail(problem, false);
    edge->first = arena_alloc(arena, (size_t)edge->count + 2, sizeof *edge->first);
    edge->loose = arena_alloc(arena, (size_t)edge->count, sizeof *edge->loose);
    if (!edge->first || !edge->loose)
        return fail(problem, true);
    put_lines(edge, points, true);
    for (int64_t row = 0; row <= edge->count; row++)
        edge->first[row + 1] += edge->first[row];
    edge->lines = arena_alloc(arena, edge->first[edge->count + 1], sizeof *edge->lines);
    if (!edge->lines)
        return fail(problem, true);
    put_lines(edge, points, false);
    return points->failed ? fail(problem, false) : API_OK;
}

/* Whether (p, q) lies in the box round a line, so much wider on all sides. */
static bool is_about(const struct line *line, double p, double q, double near) {
    const double *a = line->from, *b = line->to;
    return p >= fmin(a[0], b[0]) - near && p <= fmax(a[0], b[0]) + near &&
           q >= fmin(a[1], b[1]) - near && q <= fmax(a[1], b[1]) + near;
}

/* The distance of (p, q) from a line. */
static double distance(const struct line *line, double p, double q) {
    double x = line->to[0] - line->from[0], y = line->to[1] - line->from[1];
    double dp = p - line->from[0], dq = q - line->from[1], length2 = x * x + y * y;
    double share = length2 > 0 ? fmin(fmax((dp * x + dq * y) / length2, 0), 1) : 0;
    double gap[2] = {dp - share * x, dq - share * y};
    return sqrt(gap[0] * gap[0] + gap[1] * gap[1]);
}

bool edge_is_beyond(const struct edge *edge, double p, double q, double slack) {
    double near = width + fmin(slack, most_slack);
    int winding = 0;
    if (edge->count == 0)
        return false;
    int64_t row = row_of(edge, q);
    for (size_t k = edge->first[row]; k < edge->first[row + 1]; k++) {
        const struct line *line = &edge->lines[k];
        const double *a = line->from, *b = line->to;
        if (is_about(line, p, q, near) && distance(line, p, q) <= near)
            return false;
        if ((a[1] <= q) == (b[1] <= q))
            continue;
        double share = (q - a[1]) / (b[1] - a[1]);
        if (a[0] + share * (b[0] - a[0]) > p)
            winding += b[1] > a[1] ? 1 : -1;
    }
    return !edge->loose[row] && winding <= 0;
}
