/* SPDX-License-Identifier: MIT */
#include "stored_rim.h"

#include <math.h>
#include <string.h>

enum { BLOCK = 512, COLUMNS = 7 };

/* Straight lines between points of the rim are right to 1e-3 spacings, and places on facets that
 * stand for curved cells to some times that. */
static const double width = 1e-2;

/* The largest slack that is looked at. */
static const double most_slack = 0.05;

/* A straight line between two points, in each row of cells that it passes. */
struct line {
    double from[2], to[2]; /* p, q */
    struct vec3 point[2];
    bool covered; /* at both ends */
};

/* The lines of row low + k are lines[first[k]] .. lines[first[k + 1] - 1]. */
struct stored_rim {
    int64_t low, count; /* rows */
    size_t *first;
    struct line *lines;
    bool *loose; /* by row: the rim is not known there */
};

/* The points, read in blocks: loop, p, q, covered, x, y, z. */
struct points {
    const struct api_reader *reader;
    const struct api_column *column[COLUMNS];
    size_t first, held;
    double block[COLUMNS][BLOCK];
    bool failed;
};

struct point {
    double loop, pq[2], covered;
    struct vec3 place;
};

static struct point rim_point_at(struct points *points, size_t k) {
    if (k < points->first || k >= points->first + points->held) {
        size_t left = points->column[0]->rows - k;
        points->first = k;
        points->held = left < BLOCK ? left : BLOCK;
        for (int c = 0; c < COLUMNS; c++)
            points->failed = points->failed || !api_columns_read(points->reader, points->column[c],
                                                                 k, points->held, points->block[c]);
    }
    size_t at = k - points->first;
    double(*block)[BLOCK] = points->block;
    return (struct point){block[0][at],
                          {block[1][at], block[2][at]},
                          block[3][at],
                          vec3_make(block[4][at], block[5][at], block[6][at])};
}

static int64_t rim_row(const struct stored_rim *rim, double q) {
    return (int64_t)fmin(fmax(floor(q) - (double)rim->low, 0), (double)rim->count - 1);
}

/* Counts the lines of each row or, with room for them, puts them there. */
static void put_lines(struct stored_rim *rim, struct points *points, bool count) {
    size_t rows = points->column[0]->rows;
    struct point begin = {0}, last = {0};
    for (size_t k = 0; k <= rows && !points->failed; k++) {
        struct point here = k < rows ? rim_point_at(points, k) : (struct point){.loop = -1};
        bool same = k > 0 && here.loop == last.loop;
        const struct point *a = &last, *b = same ? &here : &begin;
        int64_t row = k > 0 ? rim_row(rim, fmin(a->pq[1], b->pq[1]) - width - most_slack) : 0;
        int64_t to = k > 0 ? rim_row(rim, fmax(a->pq[1], b->pq[1]) + width + most_slack) : -1;
        for (; row <= to; row++) {
            if (count) {
                rim->first[row + 2]++;
                rim->loose[row] = rim->loose[row] || a->covered == 0 || b->covered == 0;
                continue;
            }
            struct line *line = &rim->lines[rim->first[row + 1]++];
            memcpy(line->from, a->pq, sizeof line->from);
            memcpy(line->to, b->pq, sizeof line->to);
            line->point[0] = a->place;
            line->point[1] = b->place;
            line->covered = a->covered != 0 && b->covered != 0;
        }
        if (!same)
            begin = here;
        last = here;
    }
}

enum api_problem_id stored_rim_make(const struct api_reader *reader,
                                    const struct api_columns *columns, struct arena *arena,
                                    struct stored_rim **result, struct api_problem *problem) {
    static const char *const names[COLUMNS] = {"loop", "p", "q", "covered", "x", "y", "z"};
    static const char damaged[] = "the stored result is damaged or cannot be read";
    struct stored_rim *rim = arena_alloc(arena, 1, sizeof *rim);
    struct points *points = arena_alloc(arena, 1, sizeof *points);
    if (!rim || !points)
        return api_problem_no_memory(problem, "the edge of the part");
    *result = rim;
    if (api_columns_rows(columns, API_TABLE_RIM) == 0)
        return API_OK;
    points->reader = reader;
    for (int c = 0; c < COLUMNS; c++) {
        points->column[c] = api_columns_find(columns, API_TABLE_RIM, names[c]);
        if (!points->column[c])
            return api_problem_set(problem, API_INTERNAL, damaged);
    }
    /* The rows that there are. */
    double low = HUGE_VAL, high = -HUGE_VAL;
    for (size_t k = 0; k < points->column[0]->rows && !points->failed; k++) {
        double q = rim_point_at(points, k).pq[1];
        low = fmin(low, q);
        high = fmax(high, q);
    }
    rim->low = (int64_t)floor(low) - 1;
    rim->count = (int64_t)floor(high) + 2 - rim->low;
    if (points->failed || !(rim->count > 0))
        return api_problem_set(problem, API_INTERNAL, damaged);
    rim->first = arena_alloc(arena, (size_t)rim->count + 2, sizeof *rim->first);
    rim->loose = arena_alloc(arena, (size_t)rim->count, sizeof *rim->loose);
    if (!rim->first || !rim->loose)
        return api_problem_no_memory(problem, "the edge of the part");
    put_lines(rim, points, true);
    for (int64_t row = 0; row <= rim->count; row++)
        rim->first[row + 1] += rim->first[row];
    rim->lines = arena_alloc(arena, rim->first[rim->count + 1], sizeof *rim->lines);
    if (!rim->lines)
        return api_problem_no_memory(problem, "the edge of the part");
    put_lines(rim, points, false);
    return points->failed ? api_problem_set(problem, API_INTERNAL, damaged) : API_OK;
}

/* The distance of (p, q) from a line. */
static double distance(const struct line *line, double p, double q) {
    double x = line->to[0] - line->from[0], y = line->to[1] - line->from[1];
    double dp = p - line->from[0], dq = q - line->from[1], length2 = x * x + y * y;
    double share = length2 > 0 ? fmin(fmax((dp * x + dq * y) / length2, 0), 1) : 0;
    double gap[2] = {dp - share * x, dq - share * y};
    return sqrt(gap[0] * gap[0] + gap[1] * gap[1]);
}

/* Whether a line passes q, where on it, there p, and the turn that this is seen from smaller p. */
static bool passes_height(const struct line *line, double q) {
    return (line->from[1] <= q) != (line->to[1] <= q);
}

static double crossing_share(const struct line *line, double q) {
    return (q - line->from[1]) / (line->to[1] - line->from[1]);
}

static double p_at(const struct line *line, double share) {
    return line->from[0] + share * (line->to[0] - line->from[0]);
}

static int way_of(const struct line *line) {
    return line->to[1] > line->from[1] ? 1 : -1;
}

bool stored_rim_is_beyond(const struct stored_rim *rim, double p, double q, double slack) {
    double near = width + fmin(slack, most_slack);
    int winding = 0;
    if (rim->count == 0)
        return false;
    int64_t row = rim_row(rim, q);
    for (size_t k = rim->first[row]; k < rim->first[row + 1]; k++) {
        const struct line *line = &rim->lines[k];
        const double *a = line->from, *b = line->to;
        bool about = /* in the box round the line, so much wider on all sides */
            (p >= a[0] - near || p >= b[0] - near) && (p <= a[0] + near || p <= b[0] + near) &&
            (q >= a[1] - near || q >= b[1] - near) && (q <= a[1] + near || q <= b[1] + near);
        if (about && distance(line, p, q) <= near)
            return false;
        if (passes_height(line, q) && p_at(line, crossing_share(line, q)) > p)
            winding += way_of(line);
    }
    return !rim->loose[row] && winding <= 0;
}

void stored_rim_find_clear(const struct stored_rim *rim, const int32_t (*cells)[2], size_t count,
                           bool *clear) {
    const double near = width + most_slack;
    memset(clear, 1, count);
    for (int64_t row = 0; row < rim->count; row++)
        for (size_t k = rim->first[row]; k < rim->first[row + 1]; k++) {
            const double a = rim->lines[k].from[0], b = rim->lines[k].to[0];
            const double low = floor((a < b ? a : b) - near), high = floor((a < b ? b : a) + near);
            /* The first of the cells, which come by j, then i, that is not before (low, j). */
            const int64_t j = rim->low + row;
            size_t cell = 0;
            for (size_t end = count; cell < end;) {
                size_t middle = cell + (end - cell) / 2;
                bool before =
                    cells[middle][1] < j || (cells[middle][1] == j && cells[middle][0] < low);
                cell = before ? middle + 1 : cell;
                end = before ? end : middle;
            }
            for (; cell < count && cells[cell][1] == j && cells[cell][0] <= high; cell++)
                clear[cell] = false;
        }
}

/* ---- stretches ---- */

/* Where the line meets the rim; behind it the winding is `way` less. */
struct crossing {
    struct stretch_end end;
    int way;
};

size_t stored_rim_stretches(const struct stored_rim *rim, double q, double low, double high,
                            struct stretch_end stretches[STORED_RIM_STRETCHES][2]) {
    struct crossing list[2 * STORED_RIM_STRETCHES];
    size_t crossings = 0, count = 0;
    int winding = rim->count == 0;
    int64_t row = rim->count ? rim_row(rim, q) : 0;
    for (size_t k = rim->count ? rim->first[row] : 0; rim->count && k < rim->first[row + 1]; k++) {
        const struct line *line = &rim->lines[k];
        double share = passes_height(line, q) ? crossing_share(line, q) : -1;
        if (share < 0 || p_at(line, share) <= low)
            continue;
        winding += way_of(line);
        if (p_at(line, share) >= high || crossings == 2 * STORED_RIM_STRETCHES)
            continue;
        /* Among the crossings before it, ascending. */
        double p = p_at(line, share);
        size_t at = crossings++;
        for (; at > 0 && list[at - 1].end.p > p; at--)
            list[at] = list[at - 1];
        struct vec3 along = vec3_sub(line->point[1], line->point[0]);
        list[at].way = way_of(line);
        list[at].end = (struct stretch_end){
            .p = p, .known = line->covered, .point = vec3_axpy(share, along, line->point[0])};
    }
    struct stretch_end begin = {.p = low};
    for (size_t k = 0; k <= crossings; k++) {
        struct stretch_end end = k < crossings ? list[k].end : (struct stretch_end){.p = high};
        int behind = winding - (k < crossings ? list[k].way : 0);
        bool goes_on = k < crossings && winding > 0 && behind > 0;
        if (winding > 0 && !goes_on && count < STORED_RIM_STRETCHES) {
            stretches[count][0] = begin;
            stretches[count++][1] = end;
        }
        if (!goes_on)
            begin = end;
        winding = behind;
    }
    return count;
}
