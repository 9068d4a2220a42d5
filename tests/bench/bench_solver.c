/* SPDX-License-Identifier: MIT */
/*
 * What a node costs: evaluation, then each method at 1e4, 1e5 and 1e6 nodes on a rational bicubic
 * surface of 8 x 8 spans, with the error on an exact case beside it, so that speed is never bought
 * with accuracy. Times are CPU times of the calling thread, the least of a few runs; the methods
 * take turns, so that a busy machine disturbs all of them alike and ratios hold.
 */
#include "../../solver/drape.h"

#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum { SPANS = 8, SIZE = SPANS + 3, KNOTS = SIZE + 4, ROUNDS = 5, EVALUATIONS = 2000000 };

static double cpu_seconds(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

struct wavy {
    double knots[KNOTS];
    struct vec3 points[SIZE * SIZE];
    double weights[SIZE * SIZE];
    struct nurbs nurbs;
};

/* A gently waved square of side 1. */
static void wavy_make(struct wavy *w) {
    for (int k = 0; k < KNOTS; k++)
        w->knots[k] = fmin(fmax((double)(k - 3) / SPANS, 0), 1);
    for (int i = 0; i < SIZE; i++)
        for (int j = 0; j < SIZE; j++) {
            double x = (double)i / (SIZE - 1), y = (double)j / (SIZE - 1);
            w->points[i * SIZE + j] = vec3_make(x, y, 0.05 * sin(6 * x) * cos(5 * y));
            w->weights[i * SIZE + j] = 1 + 0.2 * sin(3.0 * i + 2.0 * j);
        }
    struct nurbs_axis axis = {3, SIZE, w->knots, KNOTS};
    w->nurbs = (struct nurbs){axis, axis, w->points, SIZE * SIZE, w->weights, SIZE * SIZE};
}

static void bench_evaluation(const struct surface *surface) {
    struct surface_cursor cursor = {0};
    struct surface_jet jet;
    double best = HUGE_VAL, sum = 0;
    for (int round = 0; round < ROUNDS; round++) {
        double begun = cpu_seconds();
        for (int k = 0; k < EVALUATIONS; k++) {
            double u = (k % 1000) / 1000.0, v = (double)k / EVALUATIONS;
            surface_evaluate(surface, &cursor, u, v, &jet);
            sum += jet.uv.z;
        }
        best = fmin(best, cpu_seconds() - begun);
    }
    printf("full second-order evaluation, rational bicubic: %.1f ns (checksum %.3g)\n",
           best / EVALUATIONS * 1e9, sum);
}

struct figure {
    double ns, bytes;
    size_t nodes;
};

static bool run_once(const struct wavy *wavy, enum drape_method method, double nodes,
                     struct figure *best) {
    struct arena *arena = arena_new((size_t)8 << 30);
    struct surface *surface;
    struct drape_result result;
    double area, begun = 0;
    bool good = arena && surface_make(&wavy->nurbs, arena, &surface) == STATUS_OK;
    if (good) {
        area = surface_area(surface, NULL);
        double d = sqrt(area / nodes);
        struct drape_settings settings = {
            .method = method, .spacing = {d, d}, .direction_deg = 20, .max_nodes = 20000000};
        begun = cpu_seconds();
        good = drape_solve(surface, &settings, NULL, arena, &result) == STATUS_OK;
    }
    if (good) {
        double ns = (cpu_seconds() - begun) / (double)result.nodes.count * 1e9;
        best->ns = best->ns > 0 ? fmin(best->ns, ns) : ns;
        best->bytes = (double)arena_peak(arena) / (double)result.nodes.count;
        best->nodes = result.nodes.count;
    }
    arena_free(arena);
    return good;
}

static const struct {
    enum drape_method method;
    const char *name;
} methods[] = {
    {DRAPE_GIB, "gib"}, {DRAPE_BASIC, "basic"}, {DRAPE_GIB4, "gib4"}, {DRAPE_GEODESIC, "geodesic"}};
enum { METHODS = sizeof methods / sizeof *methods };

static bool bench_size(const struct wavy *wavy, double nodes) {
    struct figure figure[METHODS] = {{0}};
    for (int round = 0; round < ROUNDS; round++)
        for (int m = 0; m < METHODS; m++)
            if (!run_once(wavy, methods[m].method, nodes, &figure[m]))
                return false;
    for (int m = 0; m < METHODS; m++)
        printf("%-9s %9zu %8.0f %12.0f %8.0f %8.2f\n", methods[m].name, figure[m].nodes,
               figure[m].ns, 1e9 / figure[m].ns, figure[m].bytes, figure[m].ns / figure[0].ns);
    return true;
}

int main(void) {
    static struct wavy wavy;
    wavy_make(&wavy);
    struct arena *arena = arena_new((size_t)1 << 30);
    struct surface *surface;
    if (!arena || surface_make(&wavy.nurbs, arena, &surface) != STATUS_OK)
        return 1;
    bench_evaluation(surface);
    arena_free(arena);
    printf("%-9s %9s %8s %12s %8s %8s\n", "method", "nodes", "ns/node", "nodes/s", "B/node",
           "x gib");
    bool good = true;
    for (double nodes = 1e4; nodes <= 1e6 && good; nodes *= 10)
        good = bench_size(&wavy, nodes);
    return good ? 0 : 1;
}
