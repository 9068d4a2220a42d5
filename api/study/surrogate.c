/* SPDX-License-Identifier: MIT */
#include "surrogate.h"

#include "solver/wide.h"
#include <math.h>
#include <string.h>

enum { TAIL = 1 + SURROGATE_DIMENSIONS };

/* Functions whose sums are held in registers together, or thrice as many, and the points between
 * two of their loads. */
enum { TOGETHER = 12, BLOCK = 64 };

/* Added to the diagonal, so that equal points, and coordinates that none of them differs in, leave
 * the equations regular; far below what values differ by. */
static const double ridge = 1e-9;

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
        for (size_t i = p + 1; i < unknowns; i++)
            for (size_t k = unknowns; k < width; k++)
                row[k] -= row[i] * rows[i][k];
        for (size_t k = unknowns; k < width; k++)
            row[k] /= row[p];
    }
}

enum status surrogate_make(const struct surrogate_point *points, const double *value, size_t count,
                           size_t values, struct arena *arena, struct surrogate *surrogate) {
    size_t unknowns = count + TAIL, width = unknowns + values;
    size_t stride = (values + TOGETHER - 1) / TOGETHER * TOGETHER;
    double *weight = arena_alloc(arena, unknowns * stride, sizeof *weight);
    double *across = arena_take(arena, count * SURROGATE_DIMENSIONS, sizeof *across);
    struct arena_mark mark = arena_mark(arena);
    double *all = arena_take(arena, unknowns * width, sizeof *all);
    double **rows = arena_take(arena, unknowns, sizeof *rows);
    if (!weight || !across || !all || !rows)
        return STATUS_OUT_OF_MEMORY;
    for (size_t i = 0; i < unknowns; i++) { /* [Phi T; T' 0] and its right sides */
        double *row = rows[i] = all + i * width;
        memset(row, 0, width * sizeof *row);
        for (size_t k = 0; k < count; k++) {
            double d2 = i < count ? surrogate_distance2(&points[i], &points[k]) : 0;
            row[k] = i < count ? d2 * sqrt(d2) : i == count ? 1 : points[k].x[i - count - 1];
        }
        row[i] += i < count ? ridge : -ridge;
        if (i >= count)
            continue;
        row[count] = 1;
        memcpy(row + count + 1, points[i].x, sizeof points[i].x);
        memcpy(row + unknowns, value + i * values, values * sizeof *row);
    }
    eliminate(rows, unknowns, width);
    for (size_t i = 0; i < unknowns; i++)
        memcpy(weight + i * stride, rows[i] + unknowns, values * sizeof *weight);
    for (size_t k = 0; k < count * SURROGATE_DIMENSIONS; k++)
        across[k] = points[k % count].x[k / count];
    arena_rewind(arena, mark);
    *surrogate = (struct surrogate){points, count, values, stride, weight, across};
    return STATUS_OK;
}

typedef double four __attribute__((vector_size(32)));

INLINE four load(const double *from) {
    four a;
    memcpy(&a, from, sizeof a);
    return a;
}

/* Adds what `count` points, their distances cubed, give to `fours` times four functions, which is a
 * constant where it is called: so their sums stay in registers, and enough of them that none waits
 * for another. */
INLINE void add_points(const double *weight, size_t stride, const double *cube, size_t count,
                       int fours, double *value) {
    four sum[3 * TOGETHER / 4];
    for (int k = 0; k < fours; k++)
        sum[k] = load(value + 4 * k);
    for (size_t i = 0; i < count; i++, weight += stride)
        for (int k = 0; k < fours; k++)
            sum[k] += load(weight + 4 * k) * cube[i];
    memcpy(value, sum, (size_t)fours * sizeof *sum);
}

/* The squares of the distances to some points. */
INLINE void distances(const struct surrogate *s, size_t first, size_t count,
                      const struct surrogate_point *at, double *square) {
    const double *x = s->across + first;
    for (size_t i = 0; i < count; i++) {
        double sum = 0;
        for (size_t c = 0; c < SURROGATE_DIMENSIONS; c++) {
            double by = x[c * s->count + i] - at->x[c];
            sum += by * by;
        }
        square[i] = sum;
    }
}

WIDE_CLONES
void surrogate_at(const struct surrogate *s, const struct surrogate_point *at,
                  double value[SURROGATE_VALUES_MOST], double *nearest) {
    const double *tail = s->weight + s->count * s->stride;
    double least = HUGE_VAL, cube[BLOCK];
    for (size_t k = 0; k < s->stride; k++) {
        value[k] = tail[k];
        for (size_t c = 0; c < SURROGATE_DIMENSIONS; c++)
            value[k] += tail[(1 + c) * s->stride + k] * at->x[c];
    }
    for (size_t first = 0; first < s->count; first += BLOCK) {
        size_t left = s->count - first, count = left < BLOCK ? left : BLOCK;
        distances(s, first, count, at, cube);
        for (size_t i = 0; i < count; i++)
            least = cube[i] < least ? cube[i] : least;
        for (size_t i = 0; i < count; i++) /* by itself it is done four at a time */
            cube[i] *= sqrt(cube[i]);
        const double *weight = s->weight + first * s->stride;
        size_t k = 0;
        for (; k + 3 * TOGETHER <= s->stride; k += 3 * TOGETHER)
            add_points(weight + k, s->stride, cube, count, 3 * TOGETHER / 4, value + k);
        for (; k < s->stride; k += TOGETHER)
            add_points(weight + k, s->stride, cube, count, TOGETHER / 4, value + k);
    }
    *nearest = least;
}
