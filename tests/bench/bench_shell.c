/* SPDX-License-Identifier: MIT */
/*
 * What a node costs on a shell: a rational bicubic surface as one face, and cut into 4, 16 and 64,
 * as they are and trimmed along their borders. Times are the least CPU times of a few runs of
 * drape_solve, in ns a node; `on edges` is the share of cells that a joint crosses. The
 * process keeps its memory from run to run, as a worker does.
 *
 *     bench_shell [N]      nets of about N x N nodes; default: 100 and 300
 */
#include "solver/drape.h"
#include "tests/exact/shapes.h"
#include "timing.h"

#include <malloc.h>
#include <stdio.h>
#include <stdlib.h>

enum { SIDE_MAX = 8, ROUNDS = 5 };

/* side x side pieces of the whole, with the loops of their borders if they are trimmed. */
struct part {
    struct shape shape[SIDE_MAX * SIDE_MAX];
    double corners[SIDE_MAX * SIDE_MAX][4][2];
    struct trim_curve border[SIDE_MAX * SIDE_MAX];
    struct trim_loop loop[SIDE_MAX * SIDE_MAX];
    int count;
};

static void cut(struct part *part, int side, bool trimmed) {
    static struct shape whole;
    double low[2], high[2];
    shape_bezier(&whole);
    shape_domain(&whole, low, high);
    part->count = side * side;
    for (int k = 0; k < part->count; k++) {
        int at[2] = {k / side, k % side};
        double box[2][2];
        for (int x = 0; x < 2; x++)
            for (int e = 0; e < 2; e++)
                box[x][e] =
                    at[x] + e == side ? high[x] : low[x] + (high[x] - low[x]) * (at[x] + e) / side;
        part->shape[k] = whole;
        shape_cut(&part->shape[k], box[0], box[1]);
        const double corners[4][2] = {{box[0][0], box[1][0]},
                                      {box[0][1], box[1][0]},
                                      {box[0][1], box[1][1]},
                                      {box[0][0], box[1][1]}};
        for (int c = 0; c < 4; c++)
            for (int x = 0; x < 2; x++)
                part->corners[k][c][x] = corners[c][x];
        part->border[k] = (struct trim_curve){
            .degree = 1, .points = (const double(*)[2])part->corners[k], .count = 4};
        part->loop[k] = (struct trim_loop){true, &part->border[k], trimmed ? 1 : 0};
    }
}

static struct shell *make(struct part *part, struct arena *arena) {
    struct shell_patch faces[SIDE_MAX * SIDE_MAX] = {{0}};
    struct shell *shell;
    for (int k = 0; k < part->count; k++) {
        struct nurbs nurbs = shape_nurbs(&part->shape[k]);
        struct surface *surface;
        if (surface_make(&nurbs, arena, &surface) != STATUS_OK)
            return NULL;
        faces[k] = (struct shell_patch){
            .surface = surface, .loops = &part->loop[k], .loop_count = part->loop[k].count};
    }
    return shell_make(faces, (size_t)part->count, 0, arena, &shell, NULL) == STATUS_OK ? shell
                                                                                       : NULL;
}

/* One run; ns a node, negative if it failed. */
static double run(struct part *part, enum drape_method method, int side, double *build,
                  double *share) {
    struct arena *arena = arena_new((size_t)8 << 30);
    struct drape_result result;
    double begun = seconds(), ns = -1;
    struct shell *shell = arena ? make(part, arena) : NULL;
    *build = seconds() - begun;
    if (shell) {
        double area = shell_area(shell, 0, NULL), d = sqrt(area) / side;
        struct drape_settings settings = {
            .method = method, .spacing = {d, d}, .direction_deg = 20, .max_nodes = 20000000};
        begun = seconds();
        if (drape_solve(&(struct drape_part){.shell = shell}, &settings, NULL, arena, &result) ==
            STATUS_OK)
            ns = (seconds() - begun) / (double)result.nodes.count * 1e9;
        *share = 2 * (sqrt(part->count) - 1) / side * 1.2;
    }
    arena_free(arena);
    return ns;
}

static bool bench(int side) {
    static struct part part;
    printf("nets of %d x %d, ns a node\n%-10s %-8s %9s %9s", side, side, "faces", "", "on edges",
           "joining s");
    for (int m = 0; m < METHODS; m++)
        printf(" %9s", methods[m].name);
    printf("\n");
    for (int pieces = 1; pieces <= SIDE_MAX; pieces *= 2)
        for (int trimmed = 0; trimmed < 2; trimmed++) {
            double ns[METHODS] = {0}, build = 0, share = 0;
            cut(&part, pieces, trimmed);
            for (int round = 0; round < ROUNDS; round++)
                for (int m = 0; m < METHODS; m++) {
                    double now = run(&part, methods[m].method, side, &build, &share);
                    if (now < 0)
                        return false;
                    ns[m] = round == 0 ? now : fmin(ns[m], now);
                }
            printf("%-10d %-8s %9.3f %9.4f", part.count, trimmed ? "trimmed" : "", share, build);
            for (int m = 0; m < METHODS; m++)
                printf(" %9.0f", ns[m]);
            printf("\n");
        }
    return true;
}

int main(int argc, char **argv) {
    mallopt(M_TRIM_THRESHOLD, 1 << 30);
    mallopt(M_MMAP_THRESHOLD, 1 << 30);
    if (argc > 1)
        return bench(atoi(argv[1])) ? 0 : 1;
    return bench(100) && bench(300) ? 0 : 1;
}
