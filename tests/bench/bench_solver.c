/* SPDX-License-Identifier: MIT */
/*
 * What a node costs: evaluation, then each method at 1e4, 1e5 and 1e6 nodes on a rational bicubic
 * surface of 8 x 8 spans, with the error on an exact case beside it, so that speed is never bought
 * with accuracy; then one large drape on more and more threads. Times are the least of a few runs,
 * CPU times but for the threads; the methods take turns, so that a busy machine disturbs all of
 * them alike and ratios hold. The process keeps its memory from run to run, as a worker does.
 */
#include "api/threads.h"
#include "solver/drape.h"
#include "solver/surface/surface.h"

#include <malloc.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <time.h>

enum {
    SPANS = 8,
    SIZE = SPANS + 3,
    KNOTS = SIZE + 4,
    ROUNDS = 5,
    EVALUATIONS = 2000000,
    THREADS_MAX = 4
};

static double seconds(clockid_t clock) {
    struct timespec t;
    clock_gettime(clock, &t);
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
        double begun = seconds(CLOCK_PROCESS_CPUTIME_ID);
        for (int k = 0; k < EVALUATIONS; k++) {
            double u = (k % 1000) / 1000.0, v = (double)k / EVALUATIONS;
            surface_evaluate(surface, &cursor, u, v, &jet);
            sum += jet.uv.z;
        }
        best = fmin(best, seconds(CLOCK_PROCESS_CPUTIME_ID) - begun);
    }
    printf("full second-order evaluation, rational bicubic: %.1f ns (checksum %.3g)\n",
           best / EVALUATIONS * 1e9, sum);
}

struct figure {
    double ns, wall_ns, bytes;
    size_t nodes;
};

static void keep_least(double *least, double value) {
    *least = *least > 0 ? fmin(*least, value) : value;
}

/* A drape of about so many nodes, with these settings for the rest. */
static bool run_once(const struct wavy *wavy, const struct drape_settings *with, double nodes,
                     struct figure *best) {
    struct arena *arena = arena_new((size_t)8 << 30);
    struct surface *surface;
    struct drape_result result;
    double begun = 0, wall = 0;
    bool good = arena && surface_make(&wavy->nurbs, arena, &surface) == STATUS_OK;
    if (good) {
        double d = sqrt(surface_area(surface, NULL) / nodes);
        struct drape_settings settings = *with;
        settings.spacing[0] = settings.spacing[1] = d;
        settings.direction_deg = 20;
        settings.max_nodes = 20000000;
        begun = seconds(CLOCK_PROCESS_CPUTIME_ID);
        wall = seconds(CLOCK_MONOTONIC);
        good = drape_solve(&(struct drape_part){.surface = surface}, &settings, NULL, arena,
                           &result) == STATUS_OK;
    }
    if (good) {
        double scale = 1e9 / (double)result.nodes.count;
        keep_least(&best->ns, (seconds(CLOCK_PROCESS_CPUTIME_ID) - begun) * scale);
        keep_least(&best->wall_ns, (seconds(CLOCK_MONOTONIC) - wall) * scale);
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
enum { METHODS = sizeof methods / sizeof *methods, EXACT_CELLS = 64 };
static const double exact_side = 1.2;

/* x of arc length s from the apex of the parabola x^2 / 2, by Newton. */
static double parabola_at(double s) {
    double x = s;
    for (int round = 0; round < 50; round++)
        x -= ((x * sqrt(1 + x * x) + asinh(x)) / 2 - s) / sqrt(1 + x * x);
    return x;
}

/* Largest distance of a node from the exact net of z = (x^2 - y^2) / 2, r = a(s) + b(t), by the
 * side of the net: 64 cells of 1.2 / 64. */
static double saddle_error(enum drape_method method) {
    static const double knots[] = {0, 0, 0, 1, 1, 1};
    static const struct vec3 points[] = {{-2, -2, 0}, {-2, 0, 4}, {-2, 2, 0},
                                         {0, -2, -4}, {0, 0, 0},  {0, 2, -4},
                                         {2, -2, 0},  {2, 0, 4},  {2, 2, 0}};
    struct nurbs_axis axis = {2, 3, knots, 6};
    struct nurbs nurbs = {axis, axis, points, 9, NULL, 0};
    struct arena *arena = arena_new((size_t)1 << 30);
    struct surface *surface;
    struct drape_result result;
    double d = exact_side / EXACT_CELLS, worst = HUGE_VAL;
    struct drape_settings settings = {
        .method = method,
        .spacing = {d, d},
        .start_kind = DRAPE_START_UV,
        .start_uv = {0.5, 0.5},
        .has_extent = {true, true},
        .extent = {{-EXACT_CELLS, EXACT_CELLS}, {-EXACT_CELLS, EXACT_CELLS}},
        .max_nodes = 1000000};
    if (arena && surface_make(&nurbs, arena, &surface) == STATUS_OK &&
        drape_solve(&(struct drape_part){.surface = surface}, &settings, NULL, arena, &result) ==
            STATUS_OK) {
        const struct drape_nodes *n = &result.nodes;
        worst = 0;
        for (size_t k = 0; k < n->count; k++) {
            double x = parabola_at(n->i[k] * d), y = parabola_at(n->j[k] * d);
            struct vec3 exact = vec3_make(x, y, (x * x - y * y) / 2);
            worst = fmax(worst, vec3_distance(exact, vec3_make(n->x[k], n->y[k], n->z[k])));
        }
    }
    arena_free(arena);
    return worst / exact_side;
}

static bool bench_size(const struct wavy *wavy, double nodes) {
    struct figure figure[METHODS] = {{0}};
    for (int round = 0; round < ROUNDS; round++)
        for (int m = 0; m < METHODS; m++)
            if (!run_once(wavy, &(struct drape_settings){.method = methods[m].method}, nodes,
                          &figure[m]))
                return false;
    for (int m = 0; m < METHODS; m++)
        printf("%-9s %9zu %8.0f %12.0f %8.0f %8.2f %13.1e\n", methods[m].name, figure[m].nodes,
               figure[m].ns, 1e9 / figure[m].ns, figure[m].bytes, figure[m].ns / figure[0].ns,
               saddle_error(methods[m].method));
    return true;
}

/* Fabrics whose weft slides, by the time of the weave; runs of small nets are short, and many. */
static bool bench_slide(const struct wavy *wavy, double nodes) {
    static const double slides[] = {0, 0.5, 1};
    enum { SLIDES = sizeof slides / sizeof *slides };
    printf("method      ns/node: weave, slide 0.5, parallel   x weave (%.0f nodes)\n", nodes);
    for (int m = 0; m < METHODS; m++) {
        struct figure figure[SLIDES] = {{0}};
        int rounds = nodes < 1e5 ? 20 * ROUNDS : ROUNDS;
        for (int round = 0; round < rounds; round++)
            for (int k = 0; k < SLIDES; k++) {
                const struct drape_settings with = {.method = methods[m].method,
                                                    .slide = slides[k]};
                if (!run_once(wavy, &with, nodes, &figure[k]))
                    return false;
            }
        double weave = figure[0].ns;
        printf("%-9s %15.0f %9.0f %9.0f %9.2f %6.2f\n", methods[m].name, weave, figure[1].ns,
               figure[2].ns, figure[1].ns / weave, figure[2].ns / weave);
    }
    return true;
}

/* Generators of least energy, with four values a side of each. */
static bool bench_least(const struct wavy *wavy) {
    struct drape_settings with = {.method = DRAPE_GIB};
    struct figure figure[2] = {{0}};
    for (int round = 0; round < ROUNDS; round++)
        for (int least = 0; least < 2; least++) {
            for (int k = 0; k < 2; k++) {
                with.generator[k].kind = least ? DRAPE_GENERATOR_LEAST : DRAPE_GENERATOR_GEODESIC;
                with.generator[k].curvature.points = 4;
            }
            if (!run_once(wavy, &with, 3e3, &figure[least]))
                return false;
        }
    double ms = 1e-6 * figure[1].ns * (double)figure[1].nodes;
    printf("least energy, 16 values: %zu nodes in %.0f ms, %.0f drapes' time\n", figure[1].nodes,
           ms, figure[1].ns / figure[0].ns);
    return true;
}

static bool bench_threads(const struct wavy *wavy) {
    struct figure alone = {0};
    printf("threads   ns/node  speed-up (gib, 1e6 nodes, wall time)\n");
    for (int threads = 1; threads <= THREADS_MAX; threads *= 2) {
        struct api_threads team;
        struct figure figure = {0};
        const struct drape_team *used = api_threads_make(&team, threads);
        for (int round = 0; round < ROUNDS; round++)
            if (!run_once(wavy, &(struct drape_settings){.method = DRAPE_GIB, .team = used}, 1e6,
                          &figure))
                return false;
        alone = threads == 1 ? figure : alone;
        printf("%7d  %8.0f  %8.2f\n", threads, figure.wall_ns, alone.wall_ns / figure.wall_ns);
    }
    return true;
}

int main(void) {
    static struct wavy wavy;
    mallopt(M_TRIM_THRESHOLD, 1 << 30);
    mallopt(M_MMAP_THRESHOLD, 1 << 30);
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
    return good && bench_slide(&wavy, 900) && bench_slide(&wavy, 1e5) && bench_least(&wavy) &&
                   bench_threads(&wavy)
               ? 0
               : 1;
}
