/* SPDX-License-Identifier: MIT */
#include "flat_pattern.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

/* ---- the rim ---- */

enum { LOOP, P, Q, COVERED, COLUMNS };

struct points {
    double *column[COLUMNS]; /* of `count` */
    size_t count;
};

/* ---- where no cloth reaches the rim ---- */

/* The corner of the outline nearest to a place; `distance` in steps. */
static size_t nearest_corner(const struct outline *outline, double p, double q, double *distance) {
    size_t best = 0;
    *distance = HUGE_VAL;
    for (size_t k = 0; k < outline->count; k++) {
        double dp = outline->points[k].i - p, dq = outline->points[k].j - q;
        double own = sqrt(dp * dp + dq * dq);
        best = own < *distance ? k : best;
        *distance = fmin(*distance, own);
    }
    return best;
}

static size_t corner_after(const struct outline *outline, size_t k) {
    if (!outline->points[k].last)
        return k + 1;
    while (k > 0 && !outline->points[k - 1].last)
        k--;
    return k;
}

/* Goes along the outline, as it turns, from the corner nearest to one place of the rim to that
 * nearest to another; if no way leads there, straight. */
static bool follow_outline(struct polygons *polygons, const struct outline *outline,
                           const double from[2], const double to[2]) {
    static const double reach = 3;
    double gap[2];
    size_t at = nearest_corner(outline, from[0], from[1], &gap[0]);
    size_t end = nearest_corner(outline, to[0], to[1], &gap[1]), walk = at;
    if (outline->count == 0 || gap[0] > reach || gap[1] > reach)
        return true;
    for (size_t steps = 0; walk != end; steps++) {
        walk = corner_after(outline, walk);
        if (steps > outline->count)
            return true;
    }
    for (;; at = corner_after(outline, at)) {
        if (!polygons_add(polygons, outline->points[at].i, outline->points[at].j))
            return false;
        if (at == end)
            return true;
    }
}

/* ---- loops ---- */

/* Each closed edge of the part, from a point of it that is covered on. */
static bool add_rim(struct polygons *polygons, const struct points *points,
                    const struct outline *outline) {
    const double *loop = points->column[LOOP], *covered = points->column[COVERED];
    const double *p = points->column[P], *q = points->column[Q];
    for (size_t first = 0, end = 1; first < points->count; first = end++) {
        while (end < points->count && loop[end] == loop[end - 1])
            end++;
        size_t length = end - first, begin = 0;
        while (begin < length && covered[first + begin] == 0)
            begin++;
        if (begin == length)
            continue;
        for (size_t k = 0, next; k < length; k = next) {
            size_t at = first + (begin + k) % length;
            if (!polygons_add(polygons, p[at], q[at]))
                return false;
            next = k + 1;
            while (next < length && covered[first + (begin + next) % length] == 0)
                next++;
            size_t to = first + (begin + next % length) % length;
            if (next > k + 1 && !follow_outline(polygons, outline, (const double[2]){p[at], q[at]},
                                                (const double[2]){p[to], q[to]}))
                return false;
        }
        polygons_close(polygons);
    }
    return true;
}

enum api_problem_id flat_pattern_make(struct flat_pattern *pattern, const struct api_reader *reader,
                                      const struct api_columns *columns,
                                      const struct outline *outline, double tolerance,
                                      struct api_problem *problem) {
    static const char *const names[COLUMNS] = {"loop", "p", "q", "covered"};
    struct points points = {.count = api_columns_rows(columns, API_TABLE_RIM)};
    bool rim = points.count > 0, read = true, good = true;
    for (int k = 0; rim && read && k < COLUMNS; k++) {
        const struct api_column *column = api_columns_find(columns, API_TABLE_RIM, names[k]);
        points.column[k] = malloc(points.count * sizeof *points.column[k]);
        read = column && points.column[k] &&
               api_columns_read(reader, column, 0, points.count, points.column[k]);
    }
    if (!read)
        api_problem_set(problem, API_INTERNAL, "the stored result is damaged");
    else if (rim)
        good = add_rim(&pattern->polygons, &points, outline);
    for (int k = 0; k < COLUMNS; k++)
        free(points.column[k]);
    if (problem->id == API_OK && good && pattern->polygons.count == 0)
        for (size_t k = 0; k < outline->count && good; k++) {
            good = polygons_add(&pattern->polygons, outline->points[k].i, outline->points[k].j);
            if (good && outline->points[k].last)
                polygons_close(&pattern->polygons);
        }
    else
        polygons_simplify(&pattern->polygons, tolerance);
    if (good && problem->id == API_OK) {
        pattern->notches = calloc(2 * pattern->polygons.count + 1, sizeof *pattern->notches);
        good = pattern->notches != NULL;
    }
    if (!good)
        api_problem_no_memory(problem, "the pattern");
    /* The crossings of the polygons with the line x = 0 or y = 0: outwards is the way to their
     * right. */
    size_t count = problem->id == API_OK ? pattern->polygons.count : 0;
    for (size_t k = 0, first = 0; k < count; k++) {
        const struct polygons_point *at = pattern->polygons.points;
        const struct polygons_point *a = &at[k], *b = &at[a->last ? first : k + 1];
        first = a->last ? k + 1 : first;
        const double across[2][2] = {{a->y, b->y}, {a->x, b->x}};
        for (int family = 0; family < 2; family++) {
            double from = across[family][0], to = across[family][1];
            if ((from < 0) == (to < 0))
                continue;
            double share = from / (from - to);
            int way = (family == 0) == (to > from) ? 1 : -1;
            pattern->notches[pattern->notch_count++] =
                (struct pattern_notch){family ? 0 : a->x + share * (b->x - a->x),
                                       family ? a->y + share * (b->y - a->y) : 0, family, way};
        }
    }
    return problem->id;
}

void flat_pattern_free(struct flat_pattern *pattern) {
    polygons_free(&pattern->polygons);
    free(pattern->notches);
    *pattern = (struct flat_pattern){0};
}
