/* SPDX-License-Identifier: MIT */
#include "disguise.h"

#include <math.h>
#include <stdbool.h>
#include <string.h>

/* x in [0, 1] of direction k becomes c x / (1 + (c - 1) x): points get the factor's denominator at
 * their knots, which is the blossom of its p-th power. */
static void project(struct shape *shape, int k, double c) {
    int p = shape->degree[k], count = shape->size[k] + p + 1;
    double *t = shape->knots[k], low = t[p], length = t[shape->size[k]] - low;
    for (int i = 0; i < shape->size[0]; i++)
        for (int j = 0; j < shape->size[1]; j++)
            for (int m = 1; m <= p; m++) {
                double x = (t[(k == 0 ? i : j) + m] - low) / length;
                for (int n = 0; n < 4; n++)
                    shape->h[i * shape->size[1] + j][n] /= 1 + (c - 1) * x;
            }
    for (int i = 0; i < count; i++) {
        double x = (t[i] - low) / length;
        t[i] = low + length * c * x / (1 + (c - 1) * x);
    }
}

/* Raises the degree of a direction of one span. */
static void elevate(struct shape *shape, int k) {
    int p = shape->degree[k], size[2] = {shape->size[0], shape->size[1]};
    static double h[SHAPE_SIZE_MAX * SHAPE_SIZE_MAX][4];
    double *t = shape->knots[k], ends[2] = {t[p], t[p + 1]};
    memcpy(h, shape->h, sizeof h);
    shape->degree[k]++;
    shape->size[k]++;
    for (int i = 0; i < shape->size[0]; i++)
        for (int j = 0; j < shape->size[1]; j++) {
            int along = k == 0 ? i : j;
            double share = (double)along / (p + 1);
            double *to = shape->h[i * shape->size[1] + j];
            for (int n = 0; n < 4; n++) {
                double before =
                    along > 0 ? h[k == 0 ? (i - 1) * size[1] + j : i * size[1] + j - 1][n] : 0;
                double at = along <= p ? h[i * size[1] + j][n] : 0;
                to[n] = share * before + (1 - share) * at;
            }
        }
    for (int i = 0; i <= 2 * p + 3; i++)
        t[i] = ends[i > p + 1];
}

static void reverse(struct shape *shape, int k) {
    int count = shape->size[k] + shape->degree[k] + 1, n[2] = {shape->size[0], shape->size[1]};
    static double h[SHAPE_SIZE_MAX * SHAPE_SIZE_MAX][4];
    double *t = shape->knots[k], sum = t[0] + t[count - 1];
    memcpy(h, shape->h, sizeof h);
    for (int i = 0; i < n[0]; i++)
        for (int j = 0; j < n[1]; j++) {
            int from = k == 0 ? (n[0] - 1 - i) * n[1] + j : i * n[1] + n[1] - 1 - j;
            memcpy(shape->h[i * n[1] + j], h[from], sizeof h[from]);
        }
    for (int i = 0; i < count - 1 - i; i++) {
        double swap = t[i];
        t[i] = t[count - 1 - i];
        t[count - 1 - i] = swap;
    }
    for (int i = 0; i < count; i++)
        t[i] = sum - t[i];
}

static bool one_span(const struct shape *shape, int k) {
    return shape->size[k] == shape->degree[k] + 1;
}

double disguise_spread(uint64_t *seed, double largest) {
    return exp(random_between(seed, -1, 1) * log(largest));
}

/* With interior knots, what rounding of knots far from 0 leaves of them is part of the surface; and
 * a short span at the end tells little of how the surface goes on. */
int disguise_direction(struct shape *shape, int k, uint64_t *seed) {
    int flips = 0;
    bool bezier = one_span(shape, k);
    if (bezier && random_unit(seed) < 0.5)
        elevate(shape, k);
    if (bezier && random_unit(seed) < 0.3) {
        double *t = shape->knots[k];
        int p = shape->degree[k];
        shape_insert_knot(shape, k, t[p] + random_between(seed, 0.3, 0.7) * (t[p + 1] - t[p]));
        bezier = false;
    }
    if (random_unit(seed) < 0.6)
        project(shape, k, disguise_spread(seed, bezier ? 1e4 : 100));
    if (random_unit(seed) < 0.5) {
        reverse(shape, k);
        flips++;
    }
    double offset = random_unit(seed) < 0.7 ? disguise_spread(seed, bezier ? 1e6 : 1e3) : 0;
    double scale = disguise_spread(seed, 100);
    for (int i = 0; i <= shape->size[k] + shape->degree[k]; i++)
        shape->knots[k][i] = scale * (shape->knots[k][i] + offset);
    return flips;
}

void disguise_keeping_normal(struct shape *shape, uint64_t *seed) {
    int flips = disguise_direction(shape, 0, seed);
    flips += disguise_direction(shape, 1, seed);
    if (flips % 2)
        shape_transpose(shape);
}

void disguise_affine(struct shape *shape, int k, uint64_t *seed, double map[2]) {
    bool bezier = one_span(shape, k);
    double *t = shape->knots[k], scale = disguise_spread(seed, 100);
    int p = shape->degree[k], count = shape->size[k] + p + 1;
    double offset = random_unit(seed) < 0.7 ? disguise_spread(seed, 1e3) : 0;
    map[0] = 0;
    map[1] = 1;
    if (random_unit(seed) < 0.5) {
        map[0] = t[0] + t[count - 1];
        map[1] = -1;
        reverse(shape, k);
    }
    if (bezier && random_unit(seed) < 0.5)
        elevate(shape, k);
    if (random_unit(seed) < 0.3 && shape->size[k] < SHAPE_SIZE_MAX - 1) {
        p = shape->degree[k];
        shape_insert_knot(shape, k, t[p] + random_between(seed, 0.3, 0.7) * (t[p + 1] - t[p]));
    }
    for (int i = 0; i <= shape->size[k] + shape->degree[k]; i++)
        t[i] = scale * (t[i] + offset);
    map[0] = scale * (map[0] + offset);
    map[1] *= scale;
}
