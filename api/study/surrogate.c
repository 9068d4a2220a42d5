/* SPDX-License-Identifier: MIT */
#include "surrogate.h"

#include "solver/wide.h"
#include <math.h>
#include <string.h>

enum { TAIL = 1 + SURROGATE_DIMENSIONS };

/* Added to the diagonal, so that equal points, and coordinates that none of them differs in, leave
 * the equations regular; far below what values differ by. */
static const double ridge = 1e-9;

double surrogate_distance2(const struct surrogate_point *a, const struct surrogate_point *b) {
    double sum = 0;
    for (int c = 0; c < SURROGATE_DIMENSIONS; c++)
        sum += (a->x[c] - b->x[c]) * (a->x[c] - b->x[c]);
    return sum;
}

/* Row i of the equations [Phi T; T' 0] and their right sides. */
static void set_row(const struct surrogate_point *points, const double *value, size_t count,
                    size_t values, size_t i, double *row) {
    size_t unknowns = count + TAIL;
    memset(row, 0, (unknowns + values) * sizeof *row);
    if (i < count) {
        for (size_t k = 0; k < count; k++) {
            double d2 = surrogate_distance2(&points[i], &points[k]);
            row[k] = d2 * sqrt(d2);
        }
        row[count] = 1;
        memcpy(row + count + 1, points[i].x, sizeof points[i].x);
        memcpy(row + unknowns, value + i * values, values * sizeof *row);
    } else {
        for (size_t k = 0; k < count; k++)
            row[k] = i == count ? 1 : points[k].x[i - count - 1];
    }
    row[i] += i < count ? ridge : -ridge;
}

/* Gauss's elimination of `rows`, each of `unknowns` coefficients and the right sides behind them,
 * with the largest pivot of each column; the solution takes the place of the right sides. */
WIDE_CLONES
static void eliminate(double **rows, size_t unknowns, size_t width) {
    for (size_t p = 0; p < unknowns; p++) {
        size_t largest = p;
        for (size_t i = p + 1; i < unknowns; i++)
            largest = fabs(rows[i][p]) > fabs(rows[largest][p]) ? i : largest;
        double *pivot = rows[largest];
        rows[largest] = rows[p];
        rows[p] = pivot;
        for (size_t i = p + 1; i < unknowns; i++) {
            double *row = rows[i], factor = row[p] / pivot[p];
            for (size_t k = p + 1; k < width; k++)
                row[k] -= factor * pivot[k];
        }
    }
    for (size_t p = unknowns; p-- > 0;) {
        double *row = rows[p];
        for (size_t k = unknowns; k < width; k++) {
            for (size_t i = p + 1; i < unknowns; i++)
                row[k] -= row[i] * rows[i][k];
            row[k] /= row[p];
        }
    }
}

enum status surrogate_make(const struct surrogate_point *points, const double *value, size_t count,
                           size_t values, struct arena *arena, struct surrogate *surrogate) {
    size_t unknowns = count + TAIL, width = unknowns + values;
    double *weight = arena_take(arena, unknowns * values, sizeof *weight);
    struct arena_mark mark = arena_mark(arena);
    double *all = arena_take(arena, unknowns * width, sizeof *all);
    double **rows = arena_take(arena, unknowns, sizeof *rows);
    if (!weight || !all || !rows)
        return STATUS_OUT_OF_MEMORY;
    for (size_t i = 0; i < unknowns; i++) {
        rows[i] = all + i * width;
        set_row(points, value, count, values, i, rows[i]);
    }
    eliminate(rows, unknowns, width);
    for (size_t i = 0; i < unknowns; i++)
        memcpy(weight + i * values, rows[i] + unknowns, values * sizeof *weight);
    arena_rewind(arena, mark);
    *surrogate = (struct surrogate){points, count, values, weight};
    return STATUS_OK;
}

WIDE_CLONES
void surrogate_at(const struct surrogate *s, const struct surrogate_point *at,
                  double value[SURROGATE_VALUES_MOST], double *nearest) {
    const double *tail = s->weight + s->count * s->values;
    *nearest = HUGE_VAL;
    for (size_t k = 0; k < s->values; k++) {
        value[k] = tail[k];
        for (size_t c = 0; c < SURROGATE_DIMENSIONS; c++)
            value[k] += tail[(1 + c) * s->values + k] * at->x[c];
    }
    for (size_t i = 0; i < s->count; i++) {
        double d2 = surrogate_distance2(&s->points[i], at), d3 = d2 * sqrt(d2);
        *nearest = fmin(*nearest, d2);
        for (size_t k = 0; k < s->values; k++)
            value[k] += s->weight[i * s->values + k] * d3;
    }
}
