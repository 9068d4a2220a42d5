/* SPDX-License-Identifier: MIT */
/*
 * What a node costs on twenty surfaces (surfaces.h), for nets of about N x N nodes: each surface,
 * then the median and the worst, and a full second-order evaluation of the same surface beside
 * them. Times are the least CPU times of a few runs of drape_solve. A net has its start given, so
 * that what is measured is the net and not the search for the middle of the surface.
 *
 *     bench_surfaces [N [SURFACE [METHOD]]]      default: 30, 100 and 1000 on all
 */
#include "solver/drape.h"
#include "solver/surface/spans.h"
#include "surfaces.h"
#include "timing.h"

#include <malloc.h>
#include <stdio.h>
#include <stdlib.h>

enum { EVALUATIONS = 20000 };

/* A net's figures; ns a node. */
struct figure {
    double ns[METHODS], evaluation, bytes;
    size_t nodes, lost;
    double coverage, steps;
};

static double time_evaluation(const struct surface *surface) {
    double lower[2], upper[2], sum = 0, begun = seconds();
    struct surface_cursor cursor = {0};
    for (int k = 0; k < 2; k++) {
        lower[k] = surface_axis_lower(&surface->axis[k]);
        upper[k] = surface_axis_upper(&surface->axis[k]);
    }
    for (int k = 0; k < EVALUATIONS; k++) {
        struct surface_jet jet;
        double x = (double)(k % 200) / 200, y = (double)k / EVALUATIONS;
        surface_jet_at(surface, &cursor, lower[0] + x * (upper[0] - lower[0]),
                       lower[1] + y * (upper[1] - lower[1]), &jet);
        sum += jet.uv.z;
    }
    return sum == HUGE_VAL ? 0 : (seconds() - begun) / EVALUATIONS * 1e9;
}

static void keep_least(double *least, double value) {
    *least = *least > 0 ? fmin(*least, value) : value;
}

static bool run_once(struct bench_surface *from, int side, int m, struct figure *figure) {
    struct arena *arena = arena_new((size_t)8 << 30);
    struct surface *surface;
    struct trim *trim = NULL;
    struct drape_result result;
    struct nurbs nurbs = shape_nurbs(&from->shape);
    bool good = arena && surface_make(&nurbs, arena, &surface) == STATUS_OK;
    if (good && from->loop_count)
        good = trim_make(surface, from->loops, from->loop_count, arena, &trim) == STATUS_OK;
    if (good) {
        struct vec3 centroid;
        double area = trim ? trim_area(trim, &centroid) : surface_area(surface, NULL);
        double d = sqrt(area) / side, lower[2], upper[2];
        struct drape_settings settings = {.method = methods[m].method,
                                          .spacing = {d, d},
                                          .start_kind = DRAPE_START_UV,
                                          .direction_deg = from->angle_deg,
                                          .max_nodes = 20000000};
        surface_domain(surface, lower, upper);
        for (int k = 0; k < 2; k++)
            settings.start_uv[k] = lower[k] + from->start[k] * (upper[k] - lower[k]);
        double begun = seconds();
        good = drape_solve(&(struct drape_part){.surface = surface, .trim = trim}, &settings, NULL,
                           arena, &result) == STATUS_OK;
        double taken = seconds() - begun;
        if (good) {
            keep_least(&figure->ns[m], taken / (double)result.nodes.count * 1e9);
            keep_least(&figure->evaluation, time_evaluation(surface));
        }
    }
    if (good && m == 0) {
        figure->nodes = result.nodes.count;
        figure->bytes = (double)arena_peak(arena) / (double)result.nodes.count;
        figure->coverage = result.summary.coverage;
        figure->steps = result.summary.newton_iterations_mean;
        figure->lost = result.summary.front_reasons[DRAPE_REASON_NO_CONVERGENCE] +
                       result.summary.front_reasons[DRAPE_REASON_DEGENERATE];
    }
    arena_free(arena);
    return good;
}

static int compare(const void *a, const void *b) {
    double x = *(const double *)a, y = *(const double *)b;
    return (x > y) - (x < y);
}

static void print_summary(const struct figure *figures, int count) {
    static const char *const names[] = {"median", "worst"};
    for (int which = 0; which < 2; which++) {
        double column[BENCH_SURFACES];
        printf("%-26s %7s", names[which], "");
        for (int m = -1; m < METHODS; m++) {
            for (int k = 0; k < count; k++)
                column[k] = m < 0 ? figures[k].evaluation : figures[k].ns[m];
            qsort(column, (size_t)count, sizeof *column, compare);
            printf(" %9.0f", column[which ? count - 1 : count / 2]);
        }
        for (int k = 0; k < count; k++)
            column[k] = figures[k].bytes;
        qsort(column, (size_t)count, sizeof *column, compare);
        printf(" %6.0f\n", column[which ? count - 1 : count / 2]);
    }
}

static bool bench_side(int side, int only, int only_method) {
    static struct bench_surface surface;
    struct figure figures[BENCH_SURFACES] = {{.nodes = 0}};
    int count = 0, rounds = only_method >= 0 ? 1 : side <= 30 ? 9 : side <= 100 ? 3 : 1;
    printf("nets of %d x %d, ns a node\n%-26s %7s %9s", side, side, "surface", "nodes", "evaluate");
    for (int m = 0; m < METHODS; m++)
        printf(" %9s", methods[m].name);
    printf(" %6s %5s %5s %5s\n", "B/node", "cover", "lost", "steps");
    for (int k = only < 0 ? 0 : only; k <= (only < 0 ? BENCH_SURFACES - 1 : only); k++) {
        struct figure *figure = &figures[count++];
        bench_surface_make(&surface, k);
        for (int round = 0; round < rounds; round++)
            for (int m = 0; m < (side > 300 ? METHODS - 1 : METHODS); m++)
                if ((only_method < 0 || m == only_method) && !run_once(&surface, side, m, figure))
                    return false;
        printf("%-26s %7zu %9.0f", surface.name, figure->nodes, figure->evaluation);
        for (int m = 0; m < METHODS; m++)
            printf(" %9.0f", figure->ns[m]);
        printf(" %6.0f %5.3f %5zu %5.2f\n", figure->bytes, figure->coverage, figure->lost,
               figure->steps);
    }
    print_summary(figures, count);
    return true;
}

int main(int argc, char **argv) {
    static const int sides[] = {30, 100, 1000};
    mallopt(M_TRIM_THRESHOLD, 1 << 30);
    mallopt(M_MMAP_THRESHOLD, 1 << 30);
    if (argc > 1)
        return bench_side(atoi(argv[1]), argc > 2 ? atoi(argv[2]) : -1,
                          argc > 3 ? atoi(argv[3]) : -1)
                   ? 0
                   : 1;
    bool good = true;
    for (int k = 0; k < 3 && good; k++)
        good = bench_side(sides[k], -1, -1);
    return good ? 0 : 1;
}
