/* SPDX-License-Identifier: MIT */
/*
 * Courses: how long twelve of 80 x 320 cells take, against one net of as many nodes.
 */
#include "solver/courses.h"
#include "tests/exact/shapes.h"
#include "timing.h"
#include <stdio.h>

enum { COURSES = 12, ROWS = 80, COLUMNS = 320, ROUNDS = 5 };

/* A gently curved part that the courses cover. */
static void make_part(struct shape *shape, double d) {
    const double x[2] = {0, COLUMNS * d}, y[2] = {0, COURSES * ROWS * d};
    shape_quadric(shape, 0.02, 0.03, x, y);
}

static double time_courses(const struct drape_part *part, struct drape_settings settings,
                           size_t *nodes) {
    static const double width = ROWS * 0.01;
    struct courses_settings courses = {
        .drape = settings, .widths = &width, .width_count = 1, .most = COURSES};
    struct arena *arena = arena_new((size_t)4 << 30);
    struct courses_result result;
    double begun = seconds();
    enum status status = courses_lay(part, &courses, NULL, arena, &result);
    double taken = status == STATUS_OK ? seconds() - begun : HUGE_VAL;
    *nodes = 0;
    for (size_t k = 0; k < result.count; k++)
        *nodes += result.courses[k].net.nodes.count;
    arena_free(arena);
    return taken;
}

static double time_net(const struct drape_part *part, struct drape_settings settings,
                       size_t *nodes) {
    struct arena *arena = arena_new((size_t)4 << 30);
    struct drape_result result;
    double begun = seconds();
    enum status status = drape_solve(part, &settings, NULL, arena, &result);
    double taken = status == STATUS_OK ? seconds() - begun : HUGE_VAL;
    *nodes = result.nodes.count;
    arena_free(arena);
    return taken;
}

int main(void) {
    static struct shape shape;
    struct surface *surface;
    struct arena *arena = arena_new((size_t)1 << 30);
    double d = 0.01, taken[2] = {HUGE_VAL, HUGE_VAL};
    size_t nodes[2];
    make_part(&shape, d);
    struct nurbs nurbs = shape_nurbs(&shape);
    if (surface_make(&nurbs, arena, &surface) != STATUS_OK)
        return 1;
    const struct drape_part part = {.surface = surface};
    struct drape_settings settings = {.method = DRAPE_GIB,
                                      .spacing = {d, d},
                                      .start_kind = DRAPE_START_UV,
                                      .start_uv = {COLUMNS * d / 2, 0},
                                      .max_nodes = 10000000};
    for (int round = 0; round < ROUNDS; round++) {
        taken[0] = fmin(taken[0], time_courses(&part, settings, &nodes[0]));
        taken[1] = fmin(taken[1], time_net(&part, settings, &nodes[1]));
    }
    printf("%d courses of %d x %d cells: %zu nodes in %.3f s, %.0f ns each; one net of the part: "
           "%zu nodes, %.0f ns each\n",
           COURSES, ROWS, COLUMNS, nodes[0], taken[0], 1e9 * taken[0] / (double)nodes[0], nodes[1],
           1e9 * taken[1] / (double)nodes[1]);
    arena_free(arena);
    return taken[0] < HUGE_VAL ? 0 : 1;
}
