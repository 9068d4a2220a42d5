/* SPDX-License-Identifier: MIT */
/*
 * What cuts cost. Of a dome with a cut from an edge to a quarter of the way to the other one, by
 * nets of about 1,000, 15,000 and 60,000 nodes: ns a node, without the cut and with it. And of a
 * box with rounded edges that has a dart at each of its four corners.
 *
 *     bench_cuts [NODES METHOD CUTS]    the dome alone, once: to count its instructions
 */
#include "solver/drape.h"
#include "solver/shell/shell.h"
#include "tests/exact/shapes.h"
#include "timing.h"
#include <malloc.h>
#include <stdio.h>
#include <stdlib.h>

enum { ROUNDS = 7, CORNERS = 4, BOX_FACES = 1 + 4 * CORNERS };

/* Of the dome z = -(x^2 + y^2) bend / 2 over a square, and the box. */
static const double side = 200, bend = 1.0 / 120;
static const double box[3] = {200, 150, 60}, edge = 10;

/* One run; seconds, HUGE_VAL if it failed. */
static double run(const struct drape_part *part, struct drape_settings settings, size_t *nodes) {
    struct arena *arena = arena_new((size_t)4 << 30);
    struct drape_result result = {0};
    settings.max_nodes = 10000000;
    double begun = seconds();
    enum status status = drape_solve(part, &settings, NULL, arena, &result);
    double taken = status == STATUS_OK ? seconds() - begun : HUGE_VAL;
    *nodes = result.nodes.count;
    arena_free(arena);
    return taken;
}

static struct surface *surface_of(struct shape *shape, struct arena *arena) {
    struct nurbs nurbs = shape_nurbs(shape);
    struct surface *surface;
    if (surface_make(&nurbs, arena, &surface) != STATUS_OK)
        abort();
    return surface;
}

static struct vec3 on_dome(double x, double y) {
    return vec3_make(x, y, -(x * x + y * y) * bend / 2);
}

/* ---- the dome ---- */

enum { POINTS = 9 };

struct dome {
    struct shape shape;
    struct drape_part part;
    struct vec3 path[POINTS];
    struct drape_cut_line cut;
};

static void make_dome(struct dome *dome, struct arena *arena) {
    const double x[2] = {-side / 2, side / 2};
    shape_quadric(&dome->shape, -bend, -bend, x, x);
    dome->part = (struct drape_part){.surface = surface_of(&dome->shape, arena)};
    for (int k = 0; k < POINTS; k++)
        dome->path[k] = on_dome(0.3 * side / 2, side / 2 - side / 4 * k / (POINTS - 1));
    dome->cut = (struct drape_cut_line){dome->path, POINTS};
}

static double run_dome(const struct dome *dome, enum drape_method method, double wanted,
                       size_t cuts, size_t *nodes) {
    double d = sqrt(surface_area(dome->part.surface, NULL) / wanted);
    struct drape_settings settings = {.method = method,
                                      .spacing = {d, d},
                                      .direction_deg = 20,
                                      .cuts = &dome->cut,
                                      .cut_count = cuts};
    return run(&dome->part, settings, nodes);
}

static void bench_dome(const struct dome *dome) {
    static const double sizes[] = {1000, 15000, 60000};
    for (size_t n = 0; n < sizeof sizes / sizeof *sizes; n++)
        for (int m = 0; m < METHODS; m++) {
            double taken[2] = {HUGE_VAL, HUGE_VAL};
            size_t nodes[2];
            for (int round = 0; round < ROUNDS; round++)
                for (size_t cuts = 0; cuts < 2; cuts++)
                    taken[cuts] = fmin(taken[cuts], run_dome(dome, methods[m].method, sizes[n],
                                                             cuts, &nodes[cuts]));
            printf("dome, %-8s %6zu nodes, %5.0f ns each; with a cut %6zu, %5.0f ns each: %.2f "
                   "times as long\n",
                   methods[m].name, nodes[0], 1e9 * taken[0] / (double)nodes[0], nodes[1],
                   1e9 * taken[1] / (double)nodes[1], taken[1] / taken[0]);
        }
}

/* ---- the box ---- */

struct rounded_box {
    struct shape shape[BOX_FACES];
    struct drape_part part;
    struct vec3 path[CORNERS][POINTS];
    struct drape_cut_line cuts[CORNERS];
};

/* Quarter k of what stands round an upright axis, to its corner of the box; the height 0 is the
 * lid's. */
static void move_to_corner(struct shape *shape, int k) {
    double x = box[0] / 2 - edge, y = box[1] / 2 - edge;
    struct motion motion =
        motion_similar(1, vec3_make(0, 0, 1), k * M_PI / 2,
                       vec3_make(k == 1 || k == 2 ? -x : x, k == 2 || k == 3 ? -y : y, -edge));
    shape_move(shape, &motion);
}

/* Wall k and the fillet above it, from corner k to the next. */
static void make_wall(int k, struct shape *wall, struct shape *fillet) {
    double far = k % 2 ? box[1] / 2 - edge : box[0] / 2 - edge; /* half of its length */
    double off = k % 2 ? box[0] / 2 : box[1] / 2, low = edge - box[2];
    const double x[2] = {-far, far}, z[2] = {low, 0}, quarter[2] = {0, M_PI / 2};
    const double begin[2] = {edge, -far}, end[2] = {edge, far};
    struct motion upright = {.m = {{-1, 0, 0}, {0, 0, 0}, {0, 1, 0}}, .shift = {0, off, -edge}};
    struct motion lying = {.m = {{0, 0, -1}, {1, 0, 0}, {0, 1, 0}},
                           .shift = {0, off - edge, -edge}};
    struct motion turn = motion_similar(1, vec3_make(0, 0, 1), k * M_PI / 2, vec3_make(0, 0, 0));
    shape_plane(wall, x, z);
    shape_move(wall, &upright);
    shape_move(wall, &turn);
    shape_frustum(fillet, quarter, begin, end, M_PI / 2);
    shape_move(fillet, &lying);
    shape_move(fillet, &turn);
}

static void make_box(struct rounded_box *made, struct arena *arena) {
    const double x[2] = {edge - box[0] / 2, box[0] / 2 - edge};
    const double y[2] = {edge - box[1] / 2, box[1] / 2 - edge};
    const double quarter[2] = {0, M_PI / 2}, low[2] = {edge, edge - box[2]}, high[2] = {edge, 0};
    struct shell_patch faces[BOX_FACES] = {{0}};
    struct shell *shell;
    struct shape *at = made->shape;
    shape_plane(at++, x, y);
    for (int k = 0; k < CORNERS; k++) {
        shape_frustum(at, quarter, low, high, M_PI / 2);
        move_to_corner(at++, k);
        shape_sphere(at, edge, quarter, quarter, M_PI / 2);
        move_to_corner(at++, k);
        make_wall(k, at, at + 1);
        at += 2;
        struct vec3 diagonal = {k == 1 || k == 2 ? -sqrt(0.5) : sqrt(0.5),
                                k == 2 || k == 3 ? -sqrt(0.5) : sqrt(0.5), 0};
        for (int n = 0; n < POINTS; n++) {
            double a = M_PI / 2 * (n - 1) / (POINTS - 1);
            struct vec3 centre = {k == 1 || k == 2 ? x[0] : x[1], k == 2 || k == 3 ? y[0] : y[1],
                                  n ? -edge : -box[2]};
            made->path[k][n] = vec3_axpy(edge * (n ? cos(a) : 1), diagonal, centre);
            made->path[k][n].z += n ? edge * sin(a) : 0;
        }
        made->cuts[k] = (struct drape_cut_line){made->path[k], POINTS};
    }
    for (int n = 0; n < BOX_FACES; n++)
        faces[n].surface = surface_of(&made->shape[n], arena);
    if (shell_make(faces, BOX_FACES, 0, arena, &shell, NULL) != STATUS_OK)
        abort();
    made->part = (struct drape_part){.shell = shell};
}

static void bench_box(const struct rounded_box *made) {
    for (int m = 0; m < METHODS; m++) {
        double taken[2] = {HUGE_VAL, HUGE_VAL};
        size_t nodes[2];
        for (int round = 0; round < ROUNDS; round++)
            for (size_t cuts = 0; cuts < 2; cuts++) {
                struct drape_settings settings = {.method = methods[m].method,
                                                  .spacing = {2, 2},
                                                  .start_kind = DRAPE_START_POINT,
                                                  .cuts = made->cuts,
                                                  .cut_count = cuts ? CORNERS : 0};
                taken[cuts] = fmin(taken[cuts], run(&made->part, settings, &nodes[cuts]));
            }
        printf("box, %-8s %6zu nodes in %.1f ms; with four darts %6zu in %.1f ms\n",
               methods[m].name, nodes[0], 1e3 * taken[0], nodes[1], 1e3 * taken[1]);
    }
}

int main(int argc, char **argv) {
    static struct dome dome;
    static struct rounded_box made;
    mallopt(M_TRIM_THRESHOLD, 1 << 30);
    mallopt(M_MMAP_THRESHOLD, 1 << 30);
    struct arena *arena = arena_new((size_t)1 << 30);
    make_dome(&dome, arena);
    make_box(&made, arena);
    if (argc > 3) {
        size_t nodes;
        return run_dome(&dome, methods[atoi(argv[2])].method, atof(argv[1]), (size_t)atoi(argv[3]),
                        &nodes) < HUGE_VAL
                   ? 0
                   : 1;
    }
    bench_dome(&dome);
    bench_box(&made);
    arena_free(arena);
    return 0;
}
